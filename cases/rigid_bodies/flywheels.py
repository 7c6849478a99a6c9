"""A belt drive that slips and then grips; a flywheel under a cyclic torque, and one that coasts down.

Cases: belt_driven_machine, flywheel, flywheel_coast_down.
"""

from gnomon.cases.core.scene import Torque
from gnomon.cases.declare import *
from gnomon.cases.scenes.hinge import hinged_point
from gnomon.reference.numerics.precision import publish, working
from gnomon.reference.rigid_bodies.flywheels import BeltDrive, CoastDown, Flywheel
from mpmath import mpf


def belt_slipping(t: Any, state: Values, parameters: Values) -> Values:
    """The belt's force opposes the slip, whose sign is a constant of the mode."""
    i1, i2, r1, r2, force, torque, side = parameters
    return (torque - side * force * r1) / i1, side * force * r2 / i2


def belt_gripping(t: Any, state: Values, parameters: Values) -> Values:
    i1, i2, r1, r2, _force, torque = parameters
    rate = torque * r2 / (i1 * r2 * r2 + i2 * r1 * r1)
    return rate * r2, rate * r1


def belt_slip(t: Any, state: Values, parameters: Values) -> Values:
    return (parameters[2] * state[0] - parameters[3] * state[1],)


def belt_grips(t: Any, state: Values, parameters: Values) -> Values:
    return state[0], parameters[2] * state[0] / parameters[3]


def belt_mode(t: Any, state: Values, parameters: Values) -> str:
    (slip,) = belt_slip(t, state, parameters)
    return "ahead" if slip > 0 else "behind" if slip < 0 else "grip"


def cyclic_torque(t: Any, state: Values, parameters: Values) -> Values:
    inertia, c, torque, share, rate = parameters
    return state[1], (torque * (1 + share * cos(rate * t)) - c * state[1]) / inertia


def coasting(t: Any, state: Values, parameters: Values) -> Values:
    inertia, c, torque = parameters
    return state[1], -(torque + c * state[1]) / inertia


def wheel_at_rest(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def wheel_rate(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1],)


def wheel_stops(t: Any, state: Values, parameters: Values) -> Values:
    return state[0], 0


def wheel_energy(t: Any, state: Values, parameters: Values) -> Values:
    return (parameters[0] * state[1] * state[1] / 2,)


def coast_mode(t: Any, state: Values, parameters: Values) -> str:
    return "turns" if state[1] > 0 else "rests"


def viscous(t: Any, state: Values, parameters: Values) -> Values:
    return state[1], -parameters[1] * state[1] / parameters[0]


def belt_scene(state: Values, parameters: Values) -> Scene:
    """Two pulleys, each on its axle; a separate token states the belt between them."""
    i1, i2, r1, r2, _force, torque = parameters
    w1, w2 = state
    up = (0.0, 0.0, 1.0)
    bodies = (Body("driving", 1.0, (i1, i1, i1)), Body("driven", 1.0, (i2, i2, i2)))
    axles = (
        Hinge("first", "driving", (0.0, 0.0, 0.0), up, (0.0, 0.0, 0.0), 0.0, w1),
        Hinge("second", "driven", (2 * (r1 + r2), 0.0, 0.0), up, (0.0, 0.0, 0.0), 0.0, w2),
    )
    driven = Torque("driving", "torque", lambda t, attitude, spin: (0.0, 0.0, torque))
    return Scene((0.0, 0.0, 0.0), bodies, hinges=axles, torques=(driven,))


def belt_reading(readings: Readings, parameters: Values) -> Values:
    return readings.joints["first"][1], readings.joints["second"][1]


BELT_SCENE = SceneForm(belt_scene, belt_reading, frozenset({"hinge", "belt", "torque"}), conservative=False)
WHEEL_SCENE = hinged_point(cyclic_torque, "time_force")
COAST_SCENE = hinged_point(viscous, "joint_friction", friction=lambda parameters: parameters[2] / parameters[0])


class BeltDrivenMachine(Case):
    name = "belt_driven_machine"
    title = "Belt-driven machine: the belt slips until both pulleys run together"
    section = "10.12.1"
    conventions = (
        "[inferred] Two pulleys and a massless belt, which transmits the constant force F while it slips and grips once "
        "r1 w1 = r2 w2; a constant torque M drives the first pulley."
    )
    w1 = Coordinate("rad/s", 100, typical(-10, 10))
    w2 = Coordinate("rad/s", 0, typical(-10, 10))
    I1 = Parameter("kg m^2", "0.5", "moment of the driving pulley with its machine", positive())
    I2 = Parameter("kg m^2", 2, "moment of the driven pulley with its machine", positive())
    r1 = Parameter("m", "0.1", "radius of the driving pulley", positive())
    r2 = Parameter("m", "0.25", "radius of the driven pulley", positive())
    F = Parameter("N", 60, "force of the slipping belt", positive())
    M = Parameter("N m", 4, "torque on the driving pulley", typical(-1, 1))
    rules = (
        Rule(
            "the belt can grip: |M| r1/I1 < F (r1^2/I1 + r2^2/I2)",
            lambda n: abs(n["M"]) * n["r1"] / n["I1"] < n["F"] * (n["r1"] ** 2 / n["I1"] + n["r2"] ** 2 / n["I2"]),
        ),
    )
    exact_motion = bind(BeltDrive)
    default_span = Span(2.3, "time scale")
    variants = (
        Variant("behind", "the machine accelerates the motor", initial_state=(0, 50)),
        Variant("weak", "the belt's force barely suffices: a long slip", {"F": "8.2", "M": 2}),
        Variant("grips", "no slip from the start", {"r1": "0.125"}, (100, 50), 10),
    )
    scene = BELT_SCENE
    forms = (
        Hybrid(
            modes=(Mode("ahead", belt_slipping, (1.0,)), Mode("behind", belt_slipping, (-1.0,)),
                   Mode("grip", belt_gripping)),
            start=belt_mode,
            transitions=(
                Transition("grips_ahead", "ahead", belt_slip, -1, belt_grips, "grip"),
                Transition("grips_behind", "behind", belt_slip, 1, belt_grips, "grip"),
            ),
            terminal=frozenset({"grip"}),
        ),
    )  # fmt: skip

    @property
    def time_scale(self) -> float:
        """The duration of the slip."""
        return float(self.exact_motion.grip_time) or 1.0

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion = self.exact_motion
        if not motion.side or motion.grip_time > self.span:
            return ()
        with working(digits + 2) as mp:
            time, *there = publish(map(mp.mpf, (motion.grip_time, *motion.gripped)), digits)
        return (Event(time, "grips_ahead" if motion.side > 0 else "grips_behind", tuple(there), tuple(there)),)

    def same_course(self, other: Case) -> bool:
        return BeltDrive(*other.parameter_values(), *other.initial_state).side == self.exact_motion.side

    def derived(self, digits: int) -> dict[str, Any]:
        """`belt_energy_loss`: the heat that the slip produces (J)."""
        motion = self.exact_motion
        return {
            "grip_time": motion.grip_time,
            "common_w1": motion.gripped[0],
            "belt_energy_loss": motion.belt_energy_loss,
        }


class FlywheelCase(Case):
    name = "flywheel"
    title = "Flywheel under a cyclic torque"
    section = "10.12.2, 10.11.1"
    conventions = "I w' = M (1 + p cos(W t)) - c w."
    autonomous = False
    angle = Coordinate("rad", 0, typical(-5, 5))
    w = Coordinate("rad/s", 30, typical(-10, 10))
    I = Parameter("kg m^2", 10, "moment of inertia", positive())
    c = Parameter("N m s", "0.5", "viscous drag", nonnegative(0, 2))
    M = Parameter("N m", 20, "mean torque", typical(-10, 10))
    p = Parameter("1", 1, "cyclic share of the torque", typical(-2, 2))
    W = Parameter("rad/s", 6, "rate of the cycle", typical(-8, 8))
    exact_motion = bind(Flywheel, inertia="I")
    variants = (
        Variant("start_up", "from rest to the steady state, (M/c) (1 - e^(-c t/I))", {"p": 0}, (0, 0), 100),
        Variant(
            "constant_torque",
            "c = p = 0: the start of rotation about a fixed axis, w = M t/I, exact for any method of order 2",
            {"p": 0, "c": 0},
            (0, 0),
            10,
        ),
        Variant("fast_cycle", "W = 1e4: a small oscillation on a slow rise", {"W": 10000}, span="1.03"),
        Variant("no_drag", "c = 0: rises without bound", {"c": 0}),
        Variant("long", "1e4 cycles: drift of the angle", span="10472.4"),
    )
    forms = (FirstOrder(cyclic_torque),)
    scene = WHEEL_SCENE

    @property
    def time_scale(self) -> float:
        """The shortest time of a radian of the cycle or of the wheel, or of the drag."""
        n = {name: float(value) for name, value in self.parameters.items()}
        return 1 / max(abs(n["W"]), n["c"] / n["I"], 0.1)

    def natural_span(self) -> Number:
        """10.37 cycles, but no less than ten seconds if the cycle is slow."""
        return min(10.37 * 2 * pi / max(abs(float(self.W)), 1.0), 65.0)

    @property
    def quantity_names(self) -> tuple[str, ...]:
        """`fluctuation`: the amplitude of w in the steady state (rad/s)."""
        return ("fluctuation",) if self.W or self.c else ()


class FlywheelCoastDown(Case):
    name = "flywheel_coast_down"
    title = "Flywheel coasting down under constant friction and drag"
    section = "10.12.2"
    conventions = "I w' = -M - c w while w > 0; then the wheel rests."
    angle = Coordinate("rad", 0, typical(-5, 5))
    w = Coordinate("rad/s", 30, nonnegative(0, 30))
    I = Parameter("kg m^2", 10, "moment of inertia", positive())
    c = Parameter("N m s", "0.05", "viscous drag", nonnegative(0, 2))
    M = Parameter("N m", 2, "constant friction torque", positive())
    exact_motion = bind(CoastDown, inertia="I")
    quantity_names = ("stop_time", "stop_angle")
    variants = (
        Variant("dry", "no drag: the stop is at a rational time", {"c": 0}),
        Variant("little_friction", "M = 1e-9: a long slow phase before the stop", {"M": "1e-9", "c": 1}),
        Variant("rests", "at rest from the start", initial_state=(1, 0), span=10),
    )
    invariants = decaying(energy=wheel_energy)
    scene = COAST_SCENE
    forms = (
        Hybrid(
            modes=(Mode("turns", coasting), Mode("rests", wheel_at_rest)),
            start=coast_mode,
            transitions=(Transition("stops", "turns", wheel_rate, -1, wheel_stops, "rests"),),
            terminal=frozenset({"rests"}),
        ),
    )

    @property
    def time_scale(self) -> float:
        """The time until the stop, or the decay time of the drag if it is shorter."""
        n = {name: float(value) for name, value in self.parameters.items()}
        stop = float(self.exact_motion.stop_time()) if self.w else 1.0
        return min(stop, n["I"] / n["c"]) if n["c"] else stop

    def natural_span(self) -> Number:
        """1.3 times the time until the stop."""
        return 1.3 * float(self.exact_motion.stop_time()) if self.w else 1.0

    def list_events(self, digits: int) -> tuple[Event, ...]:
        if self.w == 0 or self.exact_motion.stop_time(20) > self.span:
            return ()
        there = (self.exact_motion.stop_angle(digits), mpf(0))
        return (Event(self.exact_motion.stop_time(digits), "stops", there, there),)

    def same_course(self, other: Case) -> bool:
        return (other.initial_state[1] == 0) == (self.w == 0)

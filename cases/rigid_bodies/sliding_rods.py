"""A rod that slides down: the ladder between wall and floor, and the rod on a smooth floor.

Cases: sliding_ladder, rigid_link_plane_motion.
"""

from functools import partial

from gnomon.cases.declare import *
from gnomon.reference.rigid_bodies.sliding_rods import FallingRod, SlidingLadder
from mpmath import mpf


def on_wall_and_floor(t: Any, state: Values, parameters: Values) -> Values:
    theta, omega = state
    g, length = parameters
    return omega, 3 * g / (2 * length) * sin(theta)


def on_floor_alone(t: Any, state: Values, parameters: Values) -> Values:
    """The horizontal velocity of the centre is constant."""
    theta, omega = state
    g, length = parameters
    s = sin(theta)
    return omega, 3 * s * (2 * g / length - cos(theta) * omega * omega) / (3 * s * s + 1)


def flat_on_floor(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def wall_force(t: Any, state: Values, parameters: Values) -> Values:
    """The wall's force over (m L/2) sin(theta)."""
    theta, omega = state
    g, length = parameters
    return (3 * g / (2 * length) * cos(theta) - omega * omega,)


def upright_share(t: Any, state: Values, parameters: Values) -> Values:
    return (cos(state[0]),)


def unchanged_rod(t: Any, state: Values, parameters: Values) -> Values:
    return state


def come_to_lie(t: Any, state: Values, parameters: Values) -> Values:
    return state[0], 0


def floor_state(t: Any, state: Values, parameters: Values) -> Values:
    """The state in which the fall through a given state meets the floor, from its energy."""
    theta, omega = state
    g, length = parameters
    s = sin(theta)
    return acos(0), sqrt((omega * omega * (3 * s * s + 1) + 12 * g / length * cos(theta)) / 4)


def rod_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy on the floor alone over m L^2/24."""
    theta, omega = state
    g, length = parameters
    s = sin(theta)
    return (omega * omega * (3 * s * s + 1) + 12 * g / length * cos(theta),)


def ladder_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy of the motion in theta; it excludes the horizontal velocity of the centre after the rod leaves the wall."""
    theta, omega = state
    g, length = parameters
    return (omega * omega / 3 + g / length * cos(theta),)


def ladder_mode(t: Any, state: Values, parameters: Values) -> str:
    return "stands" if state[0] == 0 and state[1] == 0 else "wall"


def rod_mode(t: Any, state: Values, parameters: Values) -> str:
    return "stands" if state[0] == 0 else "floor"


def rod_scene(wall: bool, state: Values, parameters: Values) -> Scene:
    """A thin rod with smooth ends, its lower end on the floor and, if there is a `wall`, its upper end against it."""
    theta, omega = state
    g, length = parameters
    half, moment = length / 2, length * length / 12
    rod = Body(
        "rod",
        1.0,
        (moment, moment, 0.0),
        (half * sin(theta), 0.0, half * cos(theta)),
        (0.0, -sin(theta / 2), 0.0, cos(theta / 2)),
        (half * cos(theta) * omega if wall else 0.0, 0.0, -half * sin(theta) * omega),
        (0.0, -omega, 0.0),
        half_extents=(0.0, 0.0, half),
    )
    floor, side = Contact("rod", (0.0, 0.0, 1.0)), Contact("rod", (1.0, 0.0, 0.0))
    return Scene((0.0, 0.0, -g), (rod,), contacts=(floor, side) if wall else (floor,))


def rod_reading(readings: Readings, parameters: Values) -> Values:
    _, (_x, y, _z, w), _, spin = readings.bodies["rod"]
    return -2 * atan2(y, w), -spin[1]


LADDER_SCENE = SceneForm(partial(rod_scene, True), rod_reading, frozenset({"thin_rod_contact"}), conservative=False)
FLOOR_SCENE = SceneForm(partial(rod_scene, False), rod_reading, frozenset({"thin_rod_contact"}), conservative=False)
LIE = Transition("lies", "floor", upright_share, -1, come_to_lie, "flat", floor_state)
REST = (Mode("flat", flat_on_floor), Mode("stands", flat_on_floor))


class SlidingLadderCase(Case):
    name = "sliding_ladder"
    title = "Uniform rod sliding between smooth wall and floor until it leaves the wall, and on to the floor"
    section = "10.12.3"
    conventions = (
        "theta from the vertical; the rod touches the wall while (3g/2L) cos(theta) > omega^2, from rest until cos(theta) = "
        "(2/3) cos(theta0); then it slides on the floor alone, and comes to rest at pi/2 in a plastic impact."
    )
    theta = Coordinate("rad", "0.3", Range(0.0, pi / 2, typical=(0.0, 1.2)))
    omega = Coordinate("rad/s", 0, nonnegative(0, 1))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    L = Parameter("m", 2, "length of the rod", positive())
    rules = (
        Rule(
            "the rod starts in contact with the wall: 2 L omega^2 < 3 g cos(theta)",
            lambda n: 2 * n["L"] * n["omega"] ** 2 < 3 * n["g"] * Fraction(cos(n["theta"])),
        ),
    )
    exact_motion = bind(SlidingLadder)
    variants = (
        Variant("upright", "released 1e-9 rad from the vertical: a long exponential phase", initial_state=("1e-9", 0)),
        Variant("never", "released exactly upright: must not move", initial_state=(0, 0), span=10),
        Variant("pushed", "starts at the vertical with speed", initial_state=(0, "0.5")),
        Variant("low", "released nearly flat", initial_state=("1.4", 0)),
    )
    invariants = decaying(energy_on_floor_frame=ladder_energy)
    scene = LADDER_SCENE
    forms = (
        Hybrid(
            modes=(Mode("wall", on_wall_and_floor), Mode("floor", on_floor_alone), *REST),
            start=ladder_mode,
            transitions=(Transition("leaves_wall", "wall", wall_force, -1, unchanged_rod, "floor"), LIE),
            terminal=frozenset({"flat", "stands"}),
        ),
    )

    @property
    def time_scale(self) -> float:
        """sqrt(2L/3g), the time of the inverted pendulum."""
        return sqrt(2 * float(self.L / self.g) / 3)

    def natural_span(self) -> Number:
        """1.2 times the time of the whole fall."""
        return 10 * self.time_scale if self.exact_motion.stands else 1.2 * float(self.exact_motion.floor_time())

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion, events = self.exact_motion, list[Event]()
        if not motion.stands and motion.leaving_time(20) <= self.span:
            there = motion.leaving_state(digits)
            events.append(Event(motion.leaving_time(digits), "leaves_wall", there, there))
            if motion.floor_time(20) <= self.span:
                events.append(lying(motion, digits))
        return tuple(events)

    def same_course(self, other: Case) -> bool:
        return (not any(other.initial_state)) == self.exact_motion.stands

    @property
    def quantity_names(self) -> tuple[str, ...]:
        """`centre_velocity`: the horizontal one, constant after the rod has left the wall (m/s)."""
        leaving = ("leaving_time", "leaving_angle leaving_rate=leaving_state")
        return () if self.exact_motion.stands else (*leaving, "floor_time", "floor_rate", "centre_velocity")


class RigidLinkPlaneMotion(Case):
    name = "rigid_link_plane_motion"
    title = "Uniform rod falling from rest on a smooth floor"
    section = "10.12.3"
    conventions = (
        "theta from the vertical; the lower end slides without friction, the centre falls straight down, and the rod "
        "comes to rest at pi/2 in a plastic impact."
    )
    theta = Coordinate("rad", "0.3", Range(0.0, pi / 2, typical=(0.0, 1.4)))
    omega = Coordinate("rad/s", 0, Range(0.0, 0.0, typical=(0.0, 0.0)))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    L = Parameter("m", 2, "length of the rod", positive())
    exact_motion = bind(lambda c: FallingRod(c.g, c.L, c.initial_state[0]))
    variants = (
        Variant("upright", "released 1e-9 rad from the vertical: a long exponential phase", initial_state=("1e-9", 0)),
        Variant("never", "released exactly upright: must not move", initial_state=(0, 0), span=10),
        Variant("low", "released nearly flat", initial_state=("1.5", 0)),
    )
    invariants = decaying(energy=rod_energy)
    scene = FLOOR_SCENE
    forms = (
        Hybrid(
            modes=(Mode("floor", on_floor_alone), *REST),
            start=rod_mode,
            transitions=(LIE,),
            terminal=frozenset({"flat", "stands"}),
        ),
    )

    @property
    def time_scale(self) -> float:
        """sqrt(L/6g), the time in which the angle grows by e close to the vertical."""
        return sqrt(float(self.L / self.g) / 6)

    def natural_span(self) -> Number:
        """1.2 times the time of the fall."""
        return 10 * self.time_scale if self.exact_motion.stands else 1.2 * float(self.exact_motion.floor_time())

    def list_events(self, digits: int) -> tuple[Event, ...]:
        if self.exact_motion.stands or self.exact_motion.floor_time(20) > self.span:
            return ()
        return (lying(self.exact_motion, digits),)

    def same_course(self, other: Case) -> bool:
        return (other.initial_state[0] == 0) == self.exact_motion.stands

    @property
    def quantity_names(self) -> tuple[str, ...]:
        return () if self.exact_motion.stands else ("floor_time", "floor_rate")


def lying(motion: SlidingLadder | FallingRod, digits: int) -> Event:
    """The event at which the rod comes to rest on the floor."""
    flat = motion.flat_angle(digits)
    return Event(motion.floor_time(digits), "lies", (flat, motion.floor_rate(digits)), (flat, mpf(0)))

"""A block on a moving belt, held by a spring: stick-slip motion."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.box import flat_box
from gnomon.reference.contact.stick_slip_belt import StickSlip
from gnomon.reference.numerics.precision import exact
from mpmath import mpf


def slipping(t: Any, state: Values, parameters: Values) -> Values:
    """v' = mu_k g - (k/m) x: the belt is faster and pulls the block forward."""
    x, v = state
    m, k, g, _mu_s, mu_k, _belt = parameters
    return v, mu_k * g - (k / m) * x


def riding(t: Any, state: Values, parameters: Values) -> Values:
    """x' = V."""
    belt = parameters[5]
    return belt, 0


def lag(t: Any, state: Values, parameters: Values) -> Values:
    _x, v = state
    belt = parameters[5]
    return (v - belt,)


def pull(t: Any, state: Values, parameters: Values) -> Values:
    """The spring force less the largest static friction."""
    x, _v = state
    m, k, g, mu_s = parameters[:4]
    return (k * x - mu_s * m * g,)


def at_belt_speed(t: Any, state: Values, parameters: Values) -> Values:
    x, _v = state
    belt = parameters[5]
    return x, belt


def stick_slip_mode(t: Any, state: Values, parameters: Values) -> str:
    """The block sticks at the belt's speed if static friction can hold the spring force, decided exactly."""
    x, v = map(exact, state)
    m, k, g, mu_s, _mu_k, belt = map(exact, parameters[:6])
    return "stick" if v == belt and k * x < mu_s * m * g else "slip"


def slip_sticks(n: Any) -> bool:
    """(x - xk)^2 + (v^2 - V^2) m/k <= (xk + xs)^2, xk = mu_k m g/k, xs = mu_s m g/k."""
    length = n["m"] * n["g"] / n["k"]
    reach = (n["x"] - n["mu_k"] * length) ** 2 + (n["v"] ** 2 - n["V"] ** 2) * n["m"] / n["k"]
    return bool(reach <= ((n["mu_k"] + n["mu_s"]) * length) ** 2)


def weight_on_belt(parameters: tuple[float, ...]) -> Vector:
    return 0.0, 0.0, -parameters[2]


def spring_to_the_wall(t: float, x: float, parameters: tuple[float, ...]) -> Vector:
    return -parameters[1] * x, 0.0, 0.0


ONE_FRICTION, TWO_FRICTIONS = (
    flat_box(
        weight_on_belt,
        lambda parameters: parameters[4],
        "moving_surface",
        *more,
        mass=lambda parameters: parameters[0],
        push=spring_to_the_wall,
        belt=lambda parameters: parameters[5],
    )
    for more in ((), ("static_friction",))
)


class BlockOnBelt(Case):
    """A block on a belt that moves at V, held by a spring: what its laws of friction have in common."""

    x = Coordinate("m", 0, typical(-0.1, 1))
    v = Coordinate("m/s", "0.5", typical(-0.5, 0.5))
    m = Parameter("kg", 1, "mass", positive())
    k = Parameter("N/m", 20, "stiffness of the spring", positive(1, 20))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 10))
    mu_s = Parameter("1", "0.5", "coefficient of static friction", nonnegative(0.2, 1))
    mu_k = Parameter("1", "0.3", "coefficient of kinetic friction", nonnegative(0.1, 0.6))
    V = Parameter("m/s", "0.5", "speed of the belt", positive(0.1, 2))
    exact_motion: StickSlip

    @property
    def time_scale(self) -> float:
        """sqrt(m/k)."""
        return sqrt(float(self.m / self.k))

    def natural_span(self) -> Number:
        """Until the first release, and 5.37 cycles more."""
        return float(self.exact_motion.release_time()) + 5.37 * float(self.exact_motion.period())

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """`release` and `stick` alternate."""
        motion, events = self.exact_motion, list[Event]()
        if motion.slips_for_good:
            return ()
        if motion.repeats:
            self.limit_events(2 * float(self.span) / float(motion.period()))
        belt = motion.number(motion.V, digits)

        def add(time: Any, name: str, place: Any) -> bool:
            if time > self.span:
                return False
            events.append(Event(time, name, (place, belt), (place, belt)))
            return True

        caught = motion.first_catch(digits)
        if caught is not None and not add(caught[0], "stick", caught[1]):
            return tuple(events)
        loose, again = motion.number(motion.xs, digits), motion.place_caught(digits) if motion.repeats else None
        cycle = 0
        while True:
            if not (motion.loose_first and cycle == 0) and not add(
                motion.cycle_time(cycle, False, digits), "release", loose
            ):
                break
            if not motion.repeats or not add(motion.cycle_time(cycle, True, digits), "stick", again):
                break
            cycle += 1
        return tuple(events)

    def same_course(self, other: Case) -> bool:
        return isinstance(other, BlockOnBelt) and other.exact_motion.course == self.exact_motion.course

    def derived(self, digits: int) -> dict[str, Any]:
        motion = self.exact_motion
        return {
            "period": motion.period(digits),
            "slip_time": motion.slip_time(digits) if motion.repeats else None,
            "stick_time": motion.stick_time(digits) if motion.repeats else None,
            "first_release": mpf("inf") if motion.slips_for_good else motion.release_time(digits),
        }


class StickSlipBelt(BlockOnBelt):
    name = "stick_slip_belt"
    title = "Stick-slip of a block on a moving belt"
    section = "5.11.2, 5.12"
    conventions = (
        "x from the position of the unstretched spring, along the belt, which moves at V > 0; the block sticks until "
        "k x = mu_s m g. It is never faster than the belt."
    )
    rules = (
        Rule("mu_k <= mu_s (friction does not grow when sliding begins)", lambda n: n["mu_k"] <= n["mu_s"]),
        Rule("v <= V (the block is not faster than the belt)", lambda n: n["v"] <= n["V"]),
        Rule("an initial slip ends where the belt can hold the block, at x >= -mu_s m g/k", slip_sticks),
    )
    exact_motion = bind(StickSlip, mass="m", stiffness="k")
    variants = (
        Variant("slow_belt", "V = 1e-3: long phases of sticking, short slips", {"V": "1e-3"}, (0, "1e-3")),
        Variant(
            "fast_belt", "V = 1e3: the block's speed reaches the belt's nearly as a tangent", {"V": 1000}, (0, 1000)
        ),
        Variant(
            "one_friction",
            "mu_s = mu_k: oscillates about the point of release and reaches V as a tangent",
            {"mu_s": "0.3"},
        ),
        Variant("slipping_start", "starts at rest on the moving belt", initial_state=(0, 0)),
        Variant("many", "1,389 cycles: errors of event times add up", span="2050.3"),
    )
    forms = (
        Hybrid(
            modes=(Mode("stick", riding), Mode("slip", slipping)),
            start=stick_slip_mode,
            transitions=(
                Transition("release", "stick", pull, 1, at_belt_speed, "slip"),
                Transition("stick", "slip", lag, 1, at_belt_speed, "stick"),
            ),
        ),
    )

    @property
    def scene(self) -> SceneForm:
        return ONE_FRICTION if self.mu_s == self.mu_k else TWO_FRICTIONS

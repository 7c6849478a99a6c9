"""A particle that slides off a sphere, one that leaves a loop, and a pendulum whose string goes slack.

Cases: bead_leaving_sphere, amusement_park, pendulum_on_string.
"""

from typing import ClassVar

from gnomon.cases.declare import *
from gnomon.reference.guided.contact_loss import ContactLoss
from gnomon.reference.numerics.precision import quantity, working
from mpmath import mpf


def on_sphere(t: Any, state: Values, parameters: Values) -> Values:
    """theta'' = (g/R) sin(theta)."""
    theta, _, omega, _ = state
    g, radius = parameters
    return omega, 0, g / radius * sin(theta), 0


def off_sphere(t: Any, state: Values, parameters: Values) -> Values:
    """Free flight in polar coordinates, r = R + h."""
    theta, h, omega, u = state
    g, radius = parameters
    r = radius + h
    return omega, u, (g * sin(theta) - 2 * u * omega) / r, r * omega * omega - g * cos(theta)


def sphere_force(t: Any, state: Values, parameters: Values) -> Values:
    """Normal force over the mass."""
    theta, _, omega, _ = state
    g, radius = parameters
    return (g * cos(theta) - radius * omega * omega,)


def in_loop(t: Any, state: Values, parameters: Values) -> Values:
    """theta'' = -(g/R) sin(theta)."""
    theta, _, omega, _ = state
    g, radius = parameters
    return omega, 0, -g / radius * sin(theta), 0


def across_loop(t: Any, state: Values, parameters: Values) -> Values:
    """Free flight in polar coordinates, r = R - h."""
    theta, h, omega, u = state
    g, radius = parameters
    r = radius - h
    return omega, u, (2 * u * omega - g * sin(theta)) / r, -r * omega * omega - g * cos(theta)


def loop_force(t: Any, state: Values, parameters: Values) -> Values:
    theta, _, omega, _ = state
    g, radius = parameters
    return (radius * omega * omega + g * cos(theta),)


def sphere_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero at the top of the sphere."""
    theta, h, omega, u = state
    g, radius = parameters
    r, half = radius + h, sin(theta / 2)
    return ((r * r * omega * omega + u * u) / 2 + g * (h - 2 * r * half * half),)


def loop_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero at the bottom of the loop."""
    theta, h, omega, u = state
    g, radius = parameters
    r, half = radius - h, sin(theta / 2)
    return ((r * r * omega * omega + u * u) / 2 + g * (h + 2 * r * half * half),)


def as_it_is(t: Any, state: Values, parameters: Values) -> Values:
    theta, h, omega, u = state
    return theta, h, omega, u


def sphere_mode(t: Any, state: Values, parameters: Values) -> str:
    return "contact" if state[1] == 0 and state[3] == 0 else "flight"


def _carries(n: Mapping[str, Fraction]) -> bool:
    """Whether the sphere carries the particle at the start, decided with 60 digits."""
    with working(60) as mp:
        return bool(mp.mpf(n["g"]) * mp.cos(mp.mpf(n["theta"])) > mp.mpf(n["R"] * n["omega"] ** 2))


def _leaves_the_top(n: Mapping[str, Fraction]) -> bool:
    """Whether the start is at most 138 e-foldings from the top: closer ones need hundreds of digits."""
    away = n["theta"] ** 2 + n["R"] * n["omega"] ** 2 / n["g"]
    return away == 0 or away >= Fraction(1, 10**120)


NEEDS = frozenset({"curved_guide", "loss_of_contact"})


def _one_sided(up: int) -> SceneForm:
    """A guide that holds on one side (tokens `curved_guide`, `loss_of_contact`).

    `up` is 1 if theta is measured from the top and the particle leaves outward, -1 if from the bottom and inward.
    """

    def build(state: Values, parameters: Values) -> Scene:
        theta, h, omega, u = state
        g, radius = parameters
        r, rate = radius + up * h, up * u
        s, c = sin(theta), cos(theta)

        def circle(angle: float) -> Vector:
            return radius * sin(angle), 0.0, up * radius * cos(angle)

        velocity = (rate * s + r * omega * c, 0.0, up * (rate * c - r * omega * s))
        body = Body("particle", 1.0, (0.0, 0.0, 0.0), (r * s, 0.0, up * r * c), velocity=velocity)
        return Scene((0.0, 0.0, -g), (body,), guides=(Guide("circle", "particle", circle, theta, omega),))

    def observe(readings: Readings, parameters: Values) -> Values:
        _g, radius = parameters
        (x, _, z), _, (vx, _, vz), _ = readings.bodies["particle"]
        r = hypot(x, z)
        rate = (x * vx + z * vz) / r
        return atan2(x, up * z), up * (r - radius), up * (z * vx - x * vz) / (r * r), up * rate

    return SceneForm(build, observe, NEEDS, conservative=False)


SPHERE, LOOP = _one_sided(1), _one_sided(-1)


def until_contact_is_lost(slides: Equations, flies: Equations, force: Equations) -> Hybrid:
    """Contact until the normal force vanishes, then free flight."""
    return Hybrid(
        modes=(Mode("contact", slides), Mode("flight", flies)),
        start=sphere_mode,
        transitions=(Transition("leaves", "contact", force, -1, as_it_is, "flight"),),
        terminal=frozenset({"flight"}),
    )


class _ContactLossCase(Case):
    _INSIDE: ClassVar[bool]

    exact_motion = bind(lambda c: ContactLoss(c.g, c.R, c.theta, c.omega, c._INSIDE))

    @property
    def time_scale(self) -> float:
        g, radius = map(float, self.parameter_values())
        return sqrt(radius / g)

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """`leaves`, where the normal force vanishes."""
        motion = self.exact_motion
        if not motion.leaves or motion.leaving_time(20) > self.span:
            return ()
        there = (motion.leaving_angle(digits), mpf(0), motion.leaving_rate(digits), mpf(0))
        return (Event(motion.leaving_time(digits), "leaves", there, there),)

    def same_course(self, other: Case) -> bool:
        return isinstance(other, _ContactLossCase) and other.exact_motion.leaves == self.exact_motion.leaves

    @property
    def quantity_names(self) -> tuple[str, ...]:
        return ("leaving_time", "leaving_angle", "leaving_rate") if self.exact_motion.leaves else ()


class BeadLeavingSphere(_ContactLossCase):
    """A particle that slides down a smooth sphere until it leaves it."""

    name = "bead_leaving_sphere"
    title = "Particle sliding off a smooth sphere, contact-loss event"
    section = "6.3.4, 7.5, 7.11.1"
    conventions = "theta from the top. h is the height above the surface, zero until contact is lost, and u its rate."
    theta = Coordinate("rad", "0.1", Range(low=0.0, high=pi / 2, typical=(0.01, 0.7)))
    h = Coordinate("m", 0, Range(0.0, 0.0, typical=(0.0, 0.0)))
    omega = Coordinate("rad/s", 0, nonnegative(0, 1))
    u = Coordinate("m/s", 0, Range(0.0, 0.0, typical=(0.0, 0.0)))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 10))
    R = Parameter("m", 1, "radius", positive(0.5, 3))
    rules = (
        Rule("R omega^2 < g cos(theta) (the sphere carries the particle at the start)", _carries),
        Rule("theta = omega = 0, or theta^2 + R omega^2/g >= 1e-120 (at most 138 e-foldings)", _leaves_the_top),
    )
    variants = (
        Variant(
            "near_top",
            "released 1e-9 rad from the top: 21 e-foldings before it visibly moves",
            initial_state=("1e-9", 0, 0, 0),
        ),
        Variant("at_top", "exactly at the top: must not slide", initial_state=(0, 0, 0, 0)),
        Variant("launched", "starts at the top with speed", initial_state=(0, 0, 1, 0)),
    )
    invariants = conserved(energy=sphere_energy)
    _INSIDE = False
    forms = (until_contact_is_lost(on_sphere, off_sphere, sphere_force),)
    scene = SPHERE

    def natural_span(self) -> Number:
        """Until half a time scale after contact is lost; ten time scales at the top."""
        motion = self.exact_motion
        return float(motion.leaving_time()) + 0.5 * self.time_scale if motion.leaves else 10 * self.time_scale


class AmusementPark(_ContactLossCase):
    """A particle in a smooth vertical loop, too slow to stay in contact."""

    name = "amusement_park"
    title = "Loop-the-loop: contact loss inside a vertical circle"
    section = "6.3.4"
    conventions = (
        "theta from the bottom. h is the distance from the loop, zero until contact is lost, and u its rate. The motion "
        "ends before the next contact."
    )
    theta = Coordinate("rad", 0, Range(low=0.0, high=pi / 2, typical=(0.0, 1.0)))
    h = Coordinate("m", 0, Range(0.0, 0.0, typical=(0.0, 0.0)))
    omega = Coordinate("rad/s", "6.5", nonnegative(1, 8))
    u = Coordinate("m/s", 0, Range(0.0, 0.0, typical=(0.0, 0.0)))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 10))
    R = Parameter("m", 1, "radius", positive(0.5, 2))
    variants: ClassVar[tuple[Variant, ...]] = (
        Variant("through", "fast enough: contact lasts all round", initial_state=(0, 0, "7.2", 0)),
        Variant(
            "just_short",
            "1e-9 below sqrt(5 g/R): leaves 1e-4 rad before the top, where the force reaches zero as a tangent",
            {"g": 5},
            (0, 0, "4.999999995", 0),
        ),
        Variant("swings", "too slow to reach the side: swings like a pendulum", initial_state=(0, 0, 4, 0)),
    )
    invariants = conserved(energy=loop_energy)
    _INSIDE = True
    forms = (until_contact_is_lost(in_loop, across_loop, loop_force),)
    scene = LOOP

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        motion = self.exact_motion
        if motion.leaves and self.span >= Fraction(float(motion.leaving_time() + motion.flight_time())):
            raise ValueError(
                f"{self.name}: span = {float(self.span):g} s reaches the next contact; give a span that ends before "
                f"{float(motion.leaving_time() + motion.flight_time()):.10g} s"
            )

    def natural_span(self) -> Number:
        """Until nine tenths of the flight; ten time scales if contact lasts."""
        motion = self.exact_motion
        if not motion.leaves:
            return 10 * self.time_scale
        return float(motion.leaving_time()) + 0.9 * float(motion.flight_time())

    @property
    def quantity_names(self) -> tuple[str, ...]:
        return (*super().quantity_names, "flight_time") if self.exact_motion.leaves else ()


class PendulumOnString(AmusementPark):
    """A mass on a string, which pulls and does not push."""

    name = "pendulum_on_string"
    title = "Pendulum on a string that goes slack"
    section = "7.10"
    conventions = (
        "theta from the downward vertical. h is the string's length less the distance of the mass from the pivot, zero while "
        "the string is taut, and u its rate: the same motion as amusement_park. It ends before the string is taut again."
    )
    theta = Coordinate("rad", 1, Range(low=0.0, high=pi / 2, typical=(0.0, 1.0)))
    omega = Coordinate("rad/s", "5.4", nonnegative(1, 8))
    R = Parameter("m", 1, "length of the string", positive(0.5, 2))
    variants: ClassVar[tuple[Variant, ...]] = (
        Variant("through", "fast enough: the string stays taut all round", initial_state=(0, 0, "7.2", 0)),
        Variant(
            "just_short",
            "1e-9 below sqrt(5 g/R): the tension reaches zero as a tangent, 1e-4 rad before the top",
            {"g": 5},
            (0, 0, "4.999999995", 0),
        ),
        Variant("swings", "too slow to reach the side: the string stays taut", initial_state=(0, 0, 4, 0)),
        Variant(
            "just_slack",
            "goes slack 8e-5 rad above the side, and is taut again 0.04 s later",
            {"g": 1},
            (0, 0, "1.4143", 0),
        ),
    )

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`tension_start` over the mass (m/s^2); at `leaving` the string goes slack."""
        pull = self.R * self.omega**2
        tension = quantity(digits, lambda mp: mp.mpf(pull) + mp.mpf(self.g) * mp.cos(mp.mpf(self.theta)))
        return {"tension_start": tension} | super().quantities(digits)

"""A mass on a table, its string drawn through a hole at a given speed: moment of momentum is constant, energy is not."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.rope import SHORTENED
from gnomon.reference.orbits.central_force_shortened_string import ShortenedString


def drawn_in(t: Any, state: Values, parameters: Values) -> Values:
    """r theta'' = -2 r' theta' with r = r0 - c t."""
    _, omega = state
    _m, r0, c = parameters
    return omega, 2 * c * omega / (r0 - c * t)


def spin_on_string(t: Any, state: Values, parameters: Values) -> Values:
    """r^2 theta'."""
    _, omega = state
    _m, r0, c = parameters
    r = r0 - c * t
    return (r * r * omega,)


class CentralForceShortenedString(Case):
    name = "central_force_shortened_string"
    title = "Mass on a table, its string drawn through a hole at a given speed"
    section = "7.8"
    conventions = (
        "Polar angle of the mass about the hole; its distance is prescribed, r = r0 - c t. The moment of momentum is "
        "constant, the string does work. The motion ends before the mass reaches the hole; c < 0 lets the string out."
    )
    theta = Coordinate("rad", 0, typical(-3, 3))
    omega = Coordinate("rad/s", 2, typical(-5, 5))
    m = Parameter("kg", 1, "mass", positive())
    r0 = Parameter("m", 1, "distance from the hole at the start", positive())
    c = Parameter("m/s", "0.05", "speed at which the string is drawn in", typical(-2, 2))
    exact_motion = bind(ShortenedString, rate="c")
    variants = (
        Variant(
            "to_the_hole",
            "drawn in to 1e-3 of the initial distance: turns 1e6 times as fast at the end",
            {"c": 1},
            (0, "0.5"),
            span="0.999",
        ),
        Variant("let_out", "let out to 100 times the distance: turns 1e-4 times as fast", {"c": -1}, span=99),
        Variant("slow", "drawn in by a third during 1,568 turns: r^2 omega must not drift", {"c": "1e-4"}, span=3300),
        Variant("held", "c = 0: a circle", {"c": 0}, span="32.7"),
    )
    invariants = conserved(areal_spin=spin_on_string)
    autonomous = False
    forms = (FirstOrder(drawn_in),)
    scene = SHORTENED

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        if self.c * self.span >= self.r0:
            raise ValueError(
                f"{self.name}: span = {float(self.span):g} s reaches the hole; give a span that ends before "
                f"{float(self.r0 / self.c):.10g} s"
            )

    @property
    def time_scale(self) -> float:
        """The time of a radian at the mean rate; without rotation the time until the hole, or 1 s."""
        r0, c = self.r0, self.c
        mean = abs(self.omega) * r0 / self.exact_motion.radius(self.span)
        return float(1 / mean if mean else r0 / abs(c) if c else Fraction(1))

    @property
    def fastest_time(self) -> float:
        """The shortest time of a radian, or in which the distance changes by e."""
        r0, c, omega = self.r0, self.c, self.omega
        nearest = min(r0, self.exact_motion.radius(self.span))
        rates = (abs(omega) * (r0 / nearest) ** 2, abs(c) / nearest)
        return min([self.time_scale] + [float(1 / rate) for rate in rates if rate])

    def natural_span(self) -> Number:
        """Until the distance is a quarter of the initial one, or four times that if c < 0; if c = 0 5.37 turns, or 1 s."""
        r0, c, omega = self.r0, self.c, self.omega
        if c:
            return r0 / c * Fraction(3, 4) if c > 0 else -3 * r0 / c
        return 5.37 * tau / abs(float(omega)) if omega else 1

    def derived(self, digits: int) -> dict[str, Any]:
        """Tension of the string at start and end of the span (N), and its work, which becomes kinetic energy (J)."""
        motion, end = self.exact_motion, self.span
        return {
            "tension_start": motion.tension(Fraction(0)),
            "tension_end": motion.tension(end),
            "rate_end": motion.at(end)[1],
            "work": motion.work(end),
        }

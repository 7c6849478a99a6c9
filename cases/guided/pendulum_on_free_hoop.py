"""A bead on a hoop whose rate is not constant: a hoop that turns freely, and one whose rate is changed slowly.

Cases: rotating_pendulum_free_hoop, rotating_pendulum_swept.
"""

from gnomon.cases.declare import *
from gnomon.cases.guided.free_azimuth import FreeAzimuthCase
from gnomon.cases.guided.pendulum_on_hoop import RotatingPendulum, hoop_acceleration
from gnomon.cases.scenes.hinge import hinged_point
from gnomon.cases.scenes.hoop import FREE_HOOP
from gnomon.reference.guided.free_azimuth import Governor


def free_hoop_equations(t: Any, state: Values, parameters: Values) -> Values:
    theta, _phi, rate, spin = state
    g, radius, m, inertia = parameters
    sine, cosine = sin(theta), cos(theta)
    square = m * radius * radius
    return (
        rate,
        spin,
        (spin * spin * cosine - g / radius) * sine,
        -2 * square * sine * cosine * rate * spin / (inertia + square * sine * sine),
    )


def free_hoop_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy, zero at the bottom."""
    theta, _phi, rate, spin = state
    g, radius, m, inertia = parameters
    sine, half = sin(theta), sin(theta / 2)
    square = m * radius * radius
    turning = (inertia + square * sine * sine) * spin * spin
    return ((square * rate * rate + turning) / 2 + 2 * m * g * radius * half * half,)


def free_hoop_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """(I + m R^2 sin^2(theta)) phi', the momentum conjugate to the azimuth."""
    theta, _phi, _rate, spin = state
    _g, radius, m, inertia = parameters
    sine = sin(theta)
    return ((inertia + m * radius * radius * sine * sine) * spin,)


def swept_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """The rate at t is Om + sweep t; the force due to its change is perpendicular to the hoop."""
    g, radius, rate, sweep = parameters
    now = rate + sweep * t
    return hoop_acceleration(q[0], g / radius, now * now)


def swept_equations(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1], *swept_acceleration(t, state[:1], parameters))


SWEPT = hinged_point(swept_equations, "time_force", token="position_force")


def _motion(n: Mapping[str, Fraction]) -> Governor:
    """The motion of a governor without a sleeve, with two balls together as heavy as the bead."""
    return Governor(n["g"], n["m"] / 2, Fraction(0), n["R"], n["I"], n["theta"], n["phi"], n["rate"], n["spin"])


class RotatingPendulumFreeHoop(FreeAzimuthCase):
    name = "rotating_pendulum_free_hoop"
    title = "Bead on a hoop that turns freely about the vertical: ignorable azimuth"
    section = "11.12.2, 11.10.1"
    conventions = (
        "theta from the downward vertical, phi the azimuth of the hoop; I is the hoop's moment about the axis."
    )
    theta = Coordinate("rad", "0.5", Range(low=-pi, high=pi, typical=(0.5, 1.0)))
    phi = Coordinate("rad", 0, typical(-3, 3))
    rate = Coordinate("rad/s", 0, typical(-0.3, 0.3))
    spin = Coordinate("rad/s", 4, typical(3, 5))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(9, 10))
    R = Parameter("m", 1, "radius of the hoop", positive(0.8, 1.2))
    m = Parameter("kg", 1, "mass of the bead", positive(0.5, 2))
    I = Parameter("kg m^2", "0.5", "moment of the hoop about the vertical", positive(0.5, 2))
    rules = (Rule("the energy is below that at the top (the bead swings)", lambda n: _motion(n).swings),)
    exact_motion = bind(lambda c: _motion(c.numbers))
    variants = (
        Variant("heavy_hoop", "I = 1e8 m R^2: nearly a prescribed rate", {"I": 10**8}),
        Variant("light_hoop", "I = 1e-4 m R^2: the rate almost triples when the bead comes in", {"I": "1e-4"}, ("0.5", 0, 0, 2)),
        Variant("slow", "too slow to lift the bead from the bottom", {}, ("0.5", 0, 0, 1)),
        Variant("through", "swings through the bottom to the other side and back", {}, ("0.3", 0, "-2", 4)),
        Variant("long_1e4", "10,000 swings: phase errors of swing and azimuth", periods=10000.37),
    )  # fmt: skip
    invariants = conserved(energy=free_hoop_energy, momentum=free_hoop_momentum)
    forms = (FirstOrder(free_hoop_equations),)
    scene = FREE_HOOP

    _DRIVEN = "prescribed rate: a hoop that the bead does not slow"


class RotatingPendulumSwept(IntegratedCase):
    """The rate passes the bifurcation at Om^2 = g/R; the bead leaves the bottom with a delay."""

    name = "rotating_pendulum_swept"
    title = "Bead on a hoop whose rate is swept slowly through the bifurcation (certified Taylor)"
    section = "11.12.2, 6.14"
    conventions = "theta from the downward vertical, rad, not wrapped; the hoop turns at Om + sweep t."
    autonomous = False
    theta = Coordinate("rad", "0.05", typical(-1, 1))
    omega = Coordinate("rad/s", 0, typical(-0.5, 0.5))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 12))
    R = Parameter("m", 1, "radius of the hoop", positive(0.5, 2))
    Om = Parameter("rad/s", 2, "rate of the hoop at the start", typical(-5, 5))
    sweep = Parameter("rad/s^2", "0.25", "change of the rate", typical(-0.5, 0.5))
    default_span = "11.3"
    variants = (
        Variant("late", "1e-6 rad from the bottom: leaves it long after the bifurcation", {}, ("1e-6", 0), "14.1"),
        Variant("down", "slowed: from the tilted equilibrium to swings about the bottom", {"Om": 5, "sweep": "-0.25"}, ("1.1678", 0)),
        Variant("slow", "sweep = 1e-3: the frequency follows, the amplitude adapts", {"Om": 4, "sweep": "1e-3"}, ("0.5", 0)),
    )  # fmt: skip
    forms = (SecondOrder(swept_acceleration),)
    scene = SWEPT

    @property
    def time_scale(self) -> float:
        """The time of a small swing, or of a radian of the hoop if that is shorter."""
        g, radius, rate, sweep = map(float, self.parameter_values())
        fastest = max(abs(rate), abs(rate + sweep * float(self.default_span)))
        return 1 / sqrt(g / radius + fastest * fastest)

    def derived(self, digits: int) -> dict[str, Any]:
        """`bifurcation_time`: when the rate is sqrt(g/R) (s)."""

        def critical(mp: Any) -> Any:
            return mp.sqrt(mp.mpf(self.g / self.R))

        def passage(mp: Any) -> Any:
            return (critical(mp) - mp.mpf(self.Om)) / mp.mpf(self.sweep)

        return {"critical_rate": critical, "bifurcation_time": passage if self.sweep else None}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        return (self.level(RotatingPendulum, "a constant rate, the one at the start"),)

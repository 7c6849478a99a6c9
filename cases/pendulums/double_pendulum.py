"""The planar double pendulum."""

import numpy as np
from gnomon.cases.declare import *
from gnomon.cases.oscillators.small_vibrations import SmallVibrations
from gnomon.cases.pendulums.double_cartesian import CARTESIAN
from gnomon.reference.numerics.precision import publish, working


def double_pendulum_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Lagrange's equations, solved for the accelerations."""
    th1, th2, w1, w2 = state
    m1, m2, l1, l2, g = parameters
    sine, cosine = sin(th1 - th2), cos(th1 - th2)
    weight1, weight2 = g * sin(th1), g * sin(th2)
    first, second = l1 * w1 * w1, l2 * w2 * w2
    inertia = m1 + m2 * sine * sine
    total = m1 + m2
    a1 = m2 * (weight2 * cosine - sine * (first * cosine + second)) - total * weight1
    a2 = total * (weight1 * cosine - weight2 + sine * first) + m2 * sine * cosine * second
    return w1, w2, a1 / (l1 * inertia), a2 / (l2 * inertia)


def double_pendulum_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy (J); potential energy is zero at the pivot."""
    th1, th2, w1, w2 = state
    m1, m2, l1, l2, g = parameters
    first, second = l1 * w1, l2 * w2
    kinetic = (m1 + m2) * first * first / 2 + m2 * second * (second / 2 + first * cos(th1 - th2))
    return (kinetic - (m1 + m2) * g * l1 * cos(th1) - m2 * g * l2 * cos(th2),)


def double_pendulum_scene(state: Values, parameters: Values) -> Scene:
    """Two point masses; the second hinge hangs from the first mass (token `chained_hinges`)."""
    th1, th2, w1, w2 = state
    m1, m2, l1, l2, g = parameters
    origin, across = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    bodies = (Body("upper", m1, origin), Body("lower", m2, origin))
    first = Hinge("pivot", "upper", origin, across, (0.0, 0.0, -l1), th1, w1)
    second = Hinge("joint", "lower", origin, across, (0.0, 0.0, -l2), th2 - th1, w2 - w1, parent="upper")
    return Scene((0.0, 0.0, -g), bodies, hinges=(first, second))


def double_pendulum_reading(readings: Readings, parameters: Values) -> Values:
    (first, rate), (second, other) = readings.joints["pivot"], readings.joints["joint"]
    return first, first + second, rate, rate + other


SCENE = SceneForm(
    double_pendulum_scene, double_pendulum_reading, frozenset({"hinge", "chained_hinges"}), conservative=False
)


class DoublePendulum(IntegratedCase):
    """Two point masses on two rigid massless rods, the second hanging from the first."""

    name = "double_pendulum"
    title = "Planar double pendulum (no closed form; certified Taylor)"
    section = "11.9, 11.13"
    conventions = "th1, th2 from the downward vertical, rad, continuous (not wrapped); absolute angles."
    th1 = Coordinate("rad", 2, typical(-2, 2))
    th2 = Coordinate("rad", 1, typical(-2, 2))
    w1 = Coordinate("rad/s", 0, typical(-2, 2))
    w2 = Coordinate("rad/s", 0, typical(-2, 2))
    m1 = Parameter("kg", 1, "upper mass", positive(0.5, 2))
    m2 = Parameter("kg", 1, "lower mass", positive(0.5, 2))
    l1 = Parameter("m", 1, "upper rod", positive(0.5, 2))
    l2 = Parameter("m", 1, "lower rod", positive(0.5, 2))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 15))
    default_span = Span(10.37, "time scale")
    default_horizon = "29.4"
    variants = (
        Variant("small", "small swings: two modes, almost linear", initial_state=("1e-3", "-1e-3", 0, 0)),
        Variant(
            "upright",
            "released 1e-8 rad from the top: a long exponential phase first",
            initial_state=("3.14159264", "3.1415926", 0, 0),
        ),
        Variant("light_below", "a lower mass of 1e-6: it whips and hardly moves the upper mass", {"m2": "1e-6"}),
        Variant(
            "light_above",
            "an upper mass of 0.01: turns twenty times faster than the lower mass swings",
            {"m1": "0.01"},
            (1, "1.1", 0, 0),
            periods=1.87,
        ),
        Variant("chaotic", "over the span 12 digits are lost; the horizon is 29.4 s", span="22.6", horizon="29.4"),
        Variant(
            "engines",
            "the slow mode of the engine tables, 1e-4 rad, up to rounding",
            initial_state=("1e-4", 1.4142135623730951e-4, 0, 0),
            span=20,
        ),
    )
    most_work = 40_000
    invariants = conserved(energy=double_pendulum_energy)
    forms = (FirstOrder(double_pendulum_equations),)
    formulations = (CARTESIAN,)
    scene = SCENE
    reversal = ("w1", "w2")
    mirror = ("th1", "th2", "w1", "w2")

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """Small swings: horizontal displacements of two masses in a row on springs; the third mass stays at rest."""
        m1, m2, l1, l2, g = self.parameter_values()
        th1, th2, w1, w2 = self.initial_state
        springs: dict[str, Any] = {"k1": (m1 + m2) * g / l1, "k2": 0, "k3": g, "k12": m2 * g / l2, "k23": 0}
        start = (l1 * th1, l1 * th1 + l2 * th2, 0, l1 * w1, l1 * w1 + l2 * w2, 0)
        small = SmallVibrations(initial_state=start, span=self.span, m1=m1, m2=m2, m3=1, **springs)
        upper, lower = float(l1), float(l2)

        def swung(states: Floats) -> Floats:
            x1, x2, _, v1, v2, _ = states.T
            return np.stack([x1 / upper, (x2 - x1) / lower, v1 / upper, (v2 - v1) / lower], axis=1)

        return (Level(small, swung, "small swings: two modes"),)

    def _frequencies(self, digits: int = 15) -> tuple[Any, ...]:
        """Small-swing frequencies: roots of m1 w^4 - (m1 + m2) g (1/l1 + 1/l2) w^2 + (m1 + m2) g^2/(l1 l2) = 0."""
        with working(digits + 10) as mp:
            m1, m2, l1, l2, g = map(mp.mpf, self.parameter_values())
            total = (m1 + m2) / m1
            half, product = total * g * (1 / l1 + 1 / l2) / 2, total * g * g / (l1 * l2)
            upper = half + mp.sqrt(half * half - product)
            return publish((mp.sqrt(product / upper), mp.sqrt(upper)), digits)

    @property
    def time_scale(self) -> float:
        """One radian of the slow mode of small swings."""
        return 1 / float(self._frequencies()[0])

    @property
    def fastest_time(self) -> float:
        return 1 / float(self._frequencies()[1])

    def derived(self, digits: int) -> dict[str, Any]:
        """Angular frequencies of the two modes of small swings."""
        return dict(zip(("slow_frequency", "fast_frequency"), self._frequencies(digits), strict=True))

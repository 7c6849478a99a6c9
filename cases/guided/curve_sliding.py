"""A bead that slides on a smooth curve in a vertical plane: parabola, quartic, catenary.

Cases: curve_sliding_small, curve_sliding_quartic, curve_sliding_catenary.
"""

from typing import ClassVar

from gnomon.cases.declare import *
from gnomon.cases.oscillators.harmonic_oscillator import HarmonicOscillator
from gnomon.cases.oscillators.well import WellCase
from gnomon.reference.guided.curve_sliding import Catenary, Parabola, Quartic


def parabola_equations(t: Any, state: Values, parameters: Values) -> Values:
    """x'' = -y' (g + y'' x'^2)/(1 + y'^2), y = x^2/4p."""
    x, v = state
    g, p = parameters
    slope = x / (2 * p)
    return v, -slope * (g + v * v / (2 * p)) / (1 + slope * slope)


def parabola_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    g, p = parameters
    slope = x / (2 * p)
    return ((1 + slope * slope) * v * v / 2 + g * x * slope / 2,)


def quartic_equations(t: Any, state: Values, parameters: Values) -> Values:
    """x'' = -y' (g + y'' x'^2)/(1 + y'^2), y = x^4/a^3."""
    x, v = state
    g, a = parameters
    u = x / a
    slope = 4 * u * u * u
    return v, -slope * (g + 12 * u * u * v * v / a) / (1 + slope * slope)


def quartic_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    g, a = parameters
    u = x / a
    slope = 4 * u * u * u
    return ((1 + slope * slope) * v * v / 2 + g * x * slope / 4,)


def catenary_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """s'' = -g s/sqrt(c^2 + s^2)."""
    (s,) = q
    g, c = parameters
    return (-g * s / sqrt(c * c + s * s),)


def catenary_potential(t: Any, q: Values, parameters: Values) -> Values:
    (s,) = q
    g, c = parameters
    return (g * sqrt(c * c + s * s),)


def catenary_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero at the bottom."""
    s, v = state
    g, c = parameters
    return (v * v / 2 + g * s * s / (sqrt(c * c + s * s) + c),)


def _guided(place: Any) -> SceneForm:
    """A bead of mass 1 on a smooth guide; `place(q, size)` -> (x, y), y upward."""

    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        g, size = parameters

        def curve(q: float) -> Vector:
            x, y = place(q, size)
            return x, 0.0, y

        body = Body("bead", 1.0, (0.0, 0.0, 0.0))
        return Scene((0.0, 0.0, -g), (body,), guides=(Guide("curve", "bead", curve, *state),))

    def observe(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
        return readings.joints["curve"]

    return SceneForm(build, observe, frozenset({"curved_guide"}), conservative=False)


class _Curve(WellCase):
    section = "7.11.1, 7.11.2"
    reversal = ("v",)

    _CURVATURE: ClassVar[Any]
    """Curvature at the bottom as a function of the curve's size; 0 for the quartic."""

    def derived(self, digits: int) -> dict[str, Any]:
        """`normal_force_bottom`: over the mass, g + v^2 times the curvature at the bottom (m/s^2)."""
        motion = self.exact_motion
        g, size = self.parameter_values()
        curvature = self._CURVATURE(size)
        force = motion._quantity(digits, lambda mp: mp.mpf(g) + 2 * mp.mpf(curvature) * motion._energy(mp), 60)
        small = (lambda mp: mp.sqrt(mp.mpf(g * curvature))) if curvature else None
        return {"normal_force_bottom": force, "small_frequency": small}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The shallow motion, harmonic with the curvature at the bottom."""
        g, size = self.parameter_values()
        curvature = self._CURVATURE(size)
        if not curvature:
            return ()
        effect = "restoring force proportional to the displacement"
        return (self.level(HarmonicOscillator, effect, m=1, k=g * curvature),)


def _low(place: str, size: str, energy: Equations, most: int) -> Rule:
    """Bounds the height over the size of the curve: on a much smaller curve the bottom is like a kink to the series."""

    def holds(n: Mapping[str, Fraction]) -> bool:
        (reached,) = energy(0, (n[place], n["v"]), (n["g"], n[size]))
        return bool(reached <= most * n["g"] * n[size])

    return Rule(f"the bead rises by at most {most} {size}", holds)


PARABOLA = _guided(lambda x, p: (x, x * x / (4 * p)))


class CurveSlidingSmall(_Curve):
    name = "curve_sliding_small"
    title = "Bead on a smooth parabola"
    conventions = "x^2 = 4 p y, y upward; the state is x and x'."
    x = Coordinate("m", 1, typical(-0.7, 0.7))
    v = Coordinate("m/s", 0, typical(-1, 1))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    p = Parameter("m", "0.5", "focal length of the parabola", positive(1, 3))
    rules = (_low("x", "p", parabola_energy, 2000),)
    exact_motion = bind(Parabola, size="p", q0="x")
    variants = (
        Variant(
            "shallow", "amplitude 1e-3 p: the period is within 1e-7 of the harmonic one", initial_state=("5e-4", 0)
        ),
        Variant("steep", "released 10 p from the axis: changes direction sharply at the bottom", {"p": "0.1"}),
        Variant("long_1e4", "10,000 periods: phase error", periods=10000.37),
    )
    invariants = conserved(energy=parabola_energy)
    forms = (FirstOrder(parabola_equations),)
    scene = PARABOLA

    _CURVATURE = staticmethod(lambda p: 1 / (2 * p))


QUARTIC = _guided(lambda x, a: (x, x**4 / a**3))


class CurveSlidingQuartic(_Curve):
    name = "curve_sliding_quartic"
    title = "Bead on the smooth curve y = x^4/a^3"
    conventions = "y upward; the state is x and x'. The bottom is flat: the period grows as 1/amplitude."
    x = Coordinate("m", 1, typical(-1, 1))
    v = Coordinate("m/s", 0, typical(-1, 1))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    a = Parameter("m", 2, "size of the curve", positive(2, 5))
    rules = (_low("x", "a", quartic_energy, 50_000),)
    exact_motion = bind(Quartic, size="a", q0="x")
    variants = (
        Variant("flat", "amplitude 1e-3 a: the force is proportional to x^3", initial_state=("2e-3", 0)),
        Variant("launched", "starts at the bottom with speed", initial_state=(0, 4)),
    )
    invariants = conserved(energy=quartic_energy)
    forms = (FirstOrder(quartic_equations),)
    scene = QUARTIC

    _CURVATURE = staticmethod(lambda a: 0)


CATENARY = _guided(lambda s, c: (c * asinh(s / c), sqrt(c * c + s * s)))


class CurveSlidingCatenary(_Curve):
    name = "curve_sliding_catenary"
    title = "Bead on a smooth catenary"
    conventions = "y = c cosh(x/c), y upward; the state is the arc length from the bottom, s = c sinh(x/c), and s'."
    s = Coordinate("m", 1, typical(-0.7, 0.7))
    v = Coordinate("m/s", 0, typical(-1, 1))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    c = Parameter("m", "0.5", "radius of curvature at the bottom", positive(1, 3))
    rules = (_low("s", "c", catenary_energy, 40),)
    exact_motion = bind(Catenary, size="c", q0="s")
    variants = (
        Variant(
            "shallow", "amplitude 1e-3 c: the period is within 1e-6 of the harmonic one", initial_state=("5e-4", 0)
        ),
        Variant("deep", "amplitude 10 c: free fall along either side, a sharp turn at the bottom", {"c": "0.1"}),
    )
    invariants = conserved(energy=catenary_energy)
    forms = (Separable(catenary_acceleration, catenary_potential),)
    scene = CATENARY

    _CURVATURE = staticmethod(lambda c: 1 / c)

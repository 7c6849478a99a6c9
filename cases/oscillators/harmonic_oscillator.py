"""The harmonic oscillator."""

from gnomon.cases.declare import *
from gnomon.reference.oscillators.harmonic_oscillator import HarmonicMotion


def linear_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = -(k/m) x."""
    (x,) = q
    m, k = parameters
    return (-(k / m) * x,)


def linear_potential(t: Any, q: Values, parameters: Values) -> Values:
    (x,) = q
    m, k = parameters
    return ((k / m) * x * x / 2,)


def spring_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    m, k = parameters
    return ((m * v * v + k * x * x) / 2,)


def spring_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """A mass on a slider, with the spring as a force."""
    x, v = state
    m, k = parameters

    def spring(t: float, position: Vector, velocity: Vector) -> Vector:
        return -k * position[0], 0.0, 0.0

    slider = Slider("rail", "mass", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), x, v)
    body = Body("mass", m, (0.0, 0.0, 0.0))
    return Scene((0.0, 0.0, 0.0), (body,), sliders=(slider,), forces=(Force("mass", "position_force", spring),))


SCENE = SceneForm(spring_scene, joint("rail"), frozenset({"slider", "position_force"}))


class HarmonicOscillator(Case):
    """A mass m on a spring k."""

    name = "harmonic_oscillator"
    title = "Harmonic oscillator"
    section = "6.7"
    conventions = (
        "x from the equilibrium, which for a hanging spring is m g/k below its free end. "
        "Springs in parallel add k, springs in series add 1/k."
    )
    x = Coordinate("m", 1, typical(-5, 5))
    v = Coordinate("m/s", "0.5", typical(-5, 5))
    m = Parameter("kg", 1, "mass", positive())
    k = Parameter("N/m", 4, "stiffness of the spring", positive())
    exact_motion = bind(HarmonicMotion, mass="m", stiffness="k")
    default_span = Span(10.37, "turn")
    quantity_names = ("period", "amplitude", "phase", "energy")
    variants = (
        Variant("long_1e6", "1,000,000 periods: phase error", span="3141654.57"),
        Variant("fast", "w = 1e8 rad/s: times far below 1 s", {"k": 10**16}),
    )
    invariants = conserved(energy=spring_energy)
    forms = (Separable(linear_acceleration, linear_potential),)
    scene = SCENE
    mirror = ("x", "v")

    @property
    def time_scale(self) -> float:
        return sqrt(float(self.m) / float(self.k))

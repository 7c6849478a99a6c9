"""Free vibration with viscous damping."""

from collections.abc import Sequence

from gnomon.cases.declare import *
from gnomon.cases.oscillators.harmonic_oscillator import spring_energy
from gnomon.reference.oscillators.damped_oscillator import DampedMotion


def damped_equations(t: Any, state: Values, parameters: Values) -> Values:
    """x' = v, v' = -(c/m) v - (k/m) x."""
    x, v = state
    m, c, k = parameters
    return v, -(c / m) * v - (k / m) * x


def damped_matrix(parameters: Values) -> Values:
    m, c, k = parameters
    return 0, 1, -k / m, -c / m


def nothing_else(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def damped_energy(t: Any, state: Values, parameters: Values) -> Values:
    m, _, k = parameters
    return spring_energy(t, state, (m, k))


def damped_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """A mass on a slider, with spring and damper as one force."""
    x, v = state
    m, c, k = parameters

    def spring_and_damper(t: float, position: Vector, velocity: Vector) -> Vector:
        return -c * velocity[0] - k * position[0], 0.0, 0.0

    slider = Slider("rail", "mass", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), x, v)
    force = Force("mass", "velocity_force", spring_and_damper)
    body = Body("mass", m, (0.0, 0.0, 0.0))
    return Scene((0.0, 0.0, 0.0), (body,), sliders=(slider,), forces=(force,))


SCENE = SceneForm(damped_scene, joint("rail"), frozenset({"slider", "velocity_force"}), conservative=False)
"""Not conservative: the damper's force depends on the velocity."""


class DampedOscillator(Case):
    """A mass m on a spring k with a viscous damper c."""

    name = "damped_oscillator"
    title = "Free vibration with viscous damping"
    section = "6.11, 11.13-11.14"
    conventions = "x from the equilibrium; the damper's force is -c v."
    x = Coordinate("m", "0.5", typical(-5, 5))
    v = Coordinate("m/s", 0, typical(-5, 5))
    m = Parameter("kg", 1, "mass", positive())
    c = Parameter("N s/m", "0.4", "damping constant", nonnegative())
    k = Parameter("N/m", 20, "stiffness of the spring", positive())
    exact_motion = bind(DampedMotion, mass="m", damping="c", stiffness="k")
    variants = (
        Variant("critical", "exactly critical: both rates equal", {"c": 4, "k": 4}, (1, 1)),
        Variant(
            "near_critical_above",
            "discriminant 1.8e-15: two rates that differ in the 8th digit",
            {"c": 4.000000000000001, "k": 4},
            (1, 1),
        ),
        Variant(
            "near_critical_below",
            "discriminant -8.9e-16: a period of 7 years",
            {"c": 3.9999999999999996, "k": 4},
            (1, 1),
        ),
        Variant("stiff_1e6", "rates 1 and 1e6: the fast mode decays at once", {"c": 10**6 + 1, "k": 10**6}, (1, 0)),
        Variant("stiff_1e9", "rates 1 and 1e9: the fast mode decays at once", {"c": 10**9 + 1, "k": 10**9}, (1, 0)),
        Variant("stiff_1e12", "rates 1 and 1e12: the fast mode decays at once", {"c": 10**12 + 1, "k": 10**12}, (1, 0)),
        Variant(
            "long_1e5",
            "100,000 cycles at damping ratio 1e-6: phase error under a slow decay",
            {"c": "2e-6", "k": 1},
            (1, 0),
            span="628472.14",
        ),
    )
    invariants = decaying(energy=damped_energy)
    forms = (SemiLinear(damped_equations, linear=damped_matrix, rest=nothing_else),)
    scene = SCENE
    reversal = ("v",)
    mirror = ("x", "v")

    @property
    def time_scale(self) -> float:
        """sqrt(m/k); if overdamped, the time of the slow mode, which remains when the fast one has decayed."""
        m, _, k = map(float, self.parameter_values())
        if self.exact_motion.regime == DampedMotion.OVERDAMPED:
            return 1 / float(self.exact_motion.rates()[0])
        return sqrt(m / k)

    @property
    def fastest_time(self) -> float:
        decay = self.exact_motion.decay
        return min(self.time_scale, 1 / float(decay)) if decay > 0 else self.time_scale

    def natural_span(self) -> Number:
        """10.37 damped periods, at most 10 decay times; 10 decay times of the slow mode if nothing oscillates."""
        if self.exact_motion.regime != DampedMotion.UNDERDAMPED:
            return 10 / float(self.exact_motion.rates()[0])
        cycles, decay = 10.37 * float(self.exact_motion.period()), float(self.exact_motion.decay)
        return cycles if decay * cycles <= 10 else 10 / decay

    @property
    def quantity_names(self) -> tuple[str, ...]:
        oscillates = self.exact_motion.regime == DampedMotion.UNDERDAMPED
        rates = ("period", "logarithmic_decrement") if oscillates else ("slow_rate fast_rate=rates",)
        return ("damping_ratio", "undamped_period", *rates, "overshoot_time")

    def reversed(self, state: Sequence[Any]) -> tuple[tuple[Any, ...], dict[str, Fraction]] | None:
        """Only without damping: reversed damping would add energy."""
        return super().reversed(state) if self.c == 0 else None

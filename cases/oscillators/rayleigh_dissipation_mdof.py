"""Damped vibrations of two masses: Rayleigh's dissipation function."""

from collections.abc import Sequence
from functools import cached_property

from gnomon.cases.declare import *
from gnomon.cases.scenes.row import masses_in_a_row
from gnomon.reference.oscillators.small_vibrations import Vibrations, chain


def rayleigh_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Two masses between walls, a spring and a damper in each of the three gaps."""
    x1, x2, v1, v2 = state
    m1, m2, k1, k2, k3, c1, c2, c3 = parameters
    between = k2 * (x2 - x1) + c2 * (v2 - v1)
    return v1, v2, (between - k1 * x1 - c1 * v1) / m1, (-between - k3 * x2 - c3 * v2) / m2


def rayleigh_matrix(parameters: Values) -> Values:
    m1, m2, k1, k2, k3, c1, c2, c3 = parameters
    first = -(k1 + k2) / m1, k2 / m1, -(c1 + c2) / m1, c2 / m1
    second = k2 / m2, -(k2 + k3) / m2, c2 / m2, -(c2 + c3) / m2
    return (0, 0, 1, 0, 0, 0, 0, 1, *first, *second)


def nothing_else(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0, 0, 0


def as_row(parameters: Values) -> Values:
    """Masses, springs to the ground and between the masses, dampers to the ground and between the masses."""
    m1, m2, k1, k2, k3, c1, c2, c3 = parameters
    return m1, m2, k1, k3, k2, c1, c3, c2


SCENE = masses_in_a_row(2, as_row, damped=True)


def rayleigh_energy(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, v1, v2 = state
    m1, m2, k1, k2, k3, _, _, _ = parameters
    return ((m1 * v1 * v1 + m2 * v2 * v2 + k1 * x1 * x1 + k2 * (x2 - x1) * (x2 - x1) + k3 * x2 * x2) / 2,)


class RayleighDissipation(Case):
    """M q'' + C q' + K q = 0 for two masses between two walls."""

    name = "rayleigh_dissipation_mdof"
    title = "Damped vibrations of two masses, Rayleigh's dissipation function"
    section = "11.14"
    conventions = (
        "x1, x2 from the equilibrium; gap i (wall, between, wall) holds a spring k_i and a damper c_i. "
        "Energy falls at twice D = (c1 v1^2 + c2 (v2 - v1)^2 + c3 v2^2)/2."
    )
    x1 = Coordinate("m", 1, typical(-2, 2))
    x2 = Coordinate("m", 0, typical(-2, 2))
    v1 = Coordinate("m/s", 0, typical(-2, 2))
    v2 = Coordinate("m/s", "-0.5", typical(-2, 2))
    m1 = Parameter("kg", 1, "first mass", positive())
    m2 = Parameter("kg", 2, "second mass", positive())
    k1 = Parameter("N/m", 10, "spring from the first wall", positive())
    k2 = Parameter("N/m", 5, "spring between", nonnegative())
    k3 = Parameter("N/m", 8, "spring to the second wall", positive())
    c1 = Parameter("N s/m", "0.3", "damper from the first wall", nonnegative(0, 4))
    c2 = Parameter("N s/m", "0.1", "damper between", nonnegative(0, 4))
    c3 = Parameter("N s/m", "0.2", "damper to the second wall", nonnegative(0, 4))
    exact_motion = bind(
        lambda c: Vibrations(
            (c.m1, c.m2),
            chain((c.k1, c.k3), (c.k2,)),
            chain((c.c1, c.c3), (c.c2,)),
            c.initial_state[:2],
            c.initial_state[2:],
        )
    )
    variants = (
        Variant(
            "proportional",
            "C = M/4 + K/8: the modes are those without damping",
            {"m1": 1, "m2": 1, "k1": 2, "k2": 4, "k3": 2, "c1": "0.5", "c2": "0.5", "c3": "0.5"},
        ),
        Variant(
            "defective",
            "both modes exactly critical, at different rates: eigenvectors form no basis",
            {"m1": 1, "m2": 1, "k1": 1, "k2": 12, "k3": 1, "c1": 2, "c2": 4, "c3": 2},
        ),
        Variant(
            "near_defective",
            "a double next to the critical one: eigenvectors equal to eight digits",
            {"m1": 1, "m2": 1, "k1": 1, "k2": 12, "k3": 1, "c1": 2.0000000000000004, "c2": 4, "c3": 2},
        ),
        Variant(
            "overdamped_stiff",
            "a damper of 1e6 between the masses: a rate of 2e6 beside a vibration that hardly decays",
            {"m1": 1, "m2": 1, "k1": 1, "k2": 0, "k3": 2, "c1": 0, "c2": 10**6, "c3": 0},
            (1, 0, 0, 0),
        ),
        Variant("undamped", "no dampers: energy must stay constant", {"c1": 0, "c2": 0, "c3": 0}),
    )
    invariants = decaying(energy=rayleigh_energy)
    forms = (SemiLinear(rayleigh_equations, linear=rayleigh_matrix, rest=nothing_else),)
    scene = SCENE
    reversal = ("v1", "v2")
    mirror = ("x1", "x2", "v1", "v2")
    alike = (("x1", "v1", "m1", "k1", "c1"), ("x2", "v2", "m2", "k3", "c3"))

    @property
    def time_scale(self) -> float:
        """One radian of the slower undamped mode."""
        return 1 / float(self.exact_motion.frequencies()[0])

    @cached_property
    def fastest_time(self) -> float:
        return 1 / max(abs(complex(*map(float, rate))) for rate in self.exact_motion.rates())

    def natural_span(self) -> Number:
        """65.3 radians of the slower undamped mode, at most 20 times the slowest decay."""
        decay = float(self.exact_motion.rates()[0][0])
        cycles = 65.3 * self.time_scale
        return min(cycles, 20 / decay) if decay > 0 else cycles

    def derived(self, digits: int) -> dict[str, Any]:
        """The decay rate (1/s) and the frequency (rad/s; 0 if it does not oscillate) of each mode."""
        modes = enumerate(self.exact_motion.rates(digits), start=1)
        return {
            f"{name}_{i}": value for i, mode in modes for name, value in zip(("decay", "frequency"), mode, strict=True)
        }

    def reversed(self, state: Sequence[Any]) -> tuple[tuple[Any, ...], dict[str, Fraction]] | None:
        """Only without damping."""
        return None if self.c1 or self.c2 or self.c3 else super().reversed(state)

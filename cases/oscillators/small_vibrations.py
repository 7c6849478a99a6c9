"""Small vibrations of three masses in a row, without damping.

Cases: small_vibrations_3dof_chain, small_vibrations_mdof.
"""

from collections.abc import Sequence
from functools import cached_property

from gnomon.cases.declare import *
from gnomon.cases.scenes.row import masses_in_a_row
from gnomon.reference.numerics.precision import exact
from gnomon.reference.oscillators.small_vibrations import Vibrations, chain


def chain_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """Three equal masses between four equal springs."""
    x1, x2, x3 = q
    (k,) = parameters
    return k * (x2 - 2 * x1), k * (x1 + x3 - 2 * x2), k * (x2 - 2 * x3)


def chain_potential(t: Any, q: Values, parameters: Values) -> Values:
    x1, x2, x3 = q
    (k,) = parameters
    return (k * (x1 * x1 + (x2 - x1) * (x2 - x1) + (x3 - x2) * (x3 - x2) + x3 * x3) / 2,)


def chain_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    v1, v2, v3 = state[3:]
    return ((v1 * v1 + v2 * v2 + v3 * v3) / 2 + chain_potential(t, state[:3], parameters)[0],)


def row_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """Three masses, each on a spring to the ground, with springs between neighbours."""
    x1, x2, x3 = q
    m1, m2, m3, k1, k2, k3, k12, k23 = parameters
    first, second = k12 * (x2 - x1), k23 * (x3 - x2)
    return (first - k1 * x1) / m1, (second - first - k2 * x2) / m2, (-second - k3 * x3) / m3


def row_energy(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, v1, v2, v3 = state
    m1, m2, m3, k1, k2, k3, k12, k23 = parameters
    twice = m1 * v1 * v1 + m2 * v2 * v2 + m3 * v3 * v3 + k1 * x1 * x1 + k2 * x2 * x2 + k3 * x3 * x3
    return ((twice + k12 * (x2 - x1) * (x2 - x1) + k23 * (x3 - x2) * (x3 - x2)) / 2,)


def chain_equations(t: Any, state: Values, parameters: Values) -> Values:
    return (*state[3:], *chain_acceleration(t, state[:3], parameters))


def row_equations(t: Any, state: Values, parameters: Values) -> Values:
    return (*state[3:], *row_acceleration(t, state[:3], parameters))


def chain_matrix(parameters: Values) -> Values:
    (k,) = parameters
    return row_matrix((1, 1, 1, k, 0, k, k, k))


def row_matrix(parameters: Values) -> Values:
    """The matrix of the first-order equations, row by row; the first three rows are x' = v."""
    m1, m2, m3, k1, k2, k3, k12, k23 = parameters
    return (
        *(0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1),
        *(-(k1 + k12) / m1, k12 / m1, 0, 0, 0, 0),
        *(k12 / m2, -(k12 + k2 + k23) / m2, k23 / m2, 0, 0, 0),
        *(0, k23 / m3, -(k23 + k3) / m3, 0, 0, 0),
    )


def nothing_else(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0, 0, 0, 0, 0


def chain_as_row(parameters: Values) -> Values:
    (k,) = parameters
    return 1.0, 1.0, 1.0, k, 0.0, k, k, k


CHAIN_SCENE = masses_in_a_row(3, chain_as_row)
ROW_SCENE = masses_in_a_row(3, lambda parameters: parameters)


def _vibrations(
    case: Case, masses: Sequence[Number], ground: Sequence[Number], couplings: Sequence[Number]
) -> Vibrations:
    """The motion of masses without dampers, between springs to the ground and to each other."""
    still = chain((Fraction(0),) * 3, (Fraction(0),) * 2)
    springs = chain([exact(k) for k in ground], [exact(k) for k in couplings])
    return Vibrations(tuple(map(exact, masses)), springs, still, case.initial_state[:3], case.initial_state[3:])


class _Vibrating(Case):
    """Base of the two cases: a motion of three modes."""

    default_span = Span(10.37, "turn")
    quantity_names = ("frequency_1 frequency_2 frequency_3=frequencies",)
    exact_motion: Vibrations
    section = "11.13"
    mirror = ("x1", "x2", "x3", "v1", "v2", "v3")

    @cached_property
    def _moving(self) -> list[float]:
        """The frequencies above zero (rad/s); 1 rad/s if there is none."""
        return [w for w in map(float, self.exact_motion.frequencies()) if w > 0] or [1.0]

    @property
    def time_scale(self) -> float:
        """One radian of the slowest mode with a frequency above zero."""
        return 1 / self._moving[0]

    @property
    def fastest_time(self) -> float:
        return 1 / self._moving[-1]


class SmallVibrationsChain(_Vibrating):
    """Three equal masses and four equal springs between two walls."""

    name = "small_vibrations_3dof_chain"
    title = "Three equal masses, four equal springs, fixed ends: modal closed form"
    section = "11.13.2"
    conventions = "x1, x2, x3 from the equilibrium; k is stiffness over mass; frequencies 2 sqrt(k) sin(j pi/8)."
    x1 = Coordinate("m", 1, typical(-2, 2))
    x2 = Coordinate("m", 0, typical(-2, 2))
    x3 = Coordinate("m", "-0.5", typical(-2, 2))
    v1 = Coordinate("m/s", 0, typical(-2, 2))
    v2 = Coordinate("m/s", "0.25", typical(-2, 2))
    v3 = Coordinate("m/s", 0, typical(-2, 2))
    k = Parameter("1/s^2", 1, "stiffness of each spring over each mass", positive())
    exact_motion = bind(lambda c: _vibrations(c, (1, 1, 1), (c.k, 0, c.k), (c.k, c.k)))
    variants = (
        Variant(
            "slow_mode",
            "the slowest mode up to rounding: its shape is irrational, so both other modes have amplitudes of 1e-16",
            initial_state=(1, 1.4142135623730951, 1, 0, 0, 0),
        ),
        Variant("middle_mode", "the middle mass stays at rest", initial_state=(1, 0, -1, 0, 0, 0)),
        Variant("long_1e3", "1000 periods of the slowest mode: three phase errors", periods=1000.37),
        Variant("long_1e4", "10,000 periods of the slowest mode: three phase errors", periods=10000.37),
    )
    invariants = conserved(energy=chain_energy)
    forms = (
        Separable(chain_acceleration, chain_potential),
        SemiLinear(chain_equations, linear=chain_matrix, rest=nothing_else),
    )
    scene = CHAIN_SCENE
    alike = (("x1", "v1"), ("x3", "v3"))


class SmallVibrations(_Vibrating):
    """Three masses, each on its spring to the ground, with springs between neighbours."""

    name = "small_vibrations_mdof"
    title = "Small vibrations of three masses: beats, molecules, stiff couplings"
    conventions = (
        "x1, x2, x3 from the equilibrium; springs k1, k2, k3 join each mass to the ground, k12 and k23 join neighbours. "
        "A pendulum of mass m with small swings is like a spring m g/L to the ground."
    )
    x1 = Coordinate("m", 1, typical(-2, 2))
    x2 = Coordinate("m", 0, typical(-2, 2))
    x3 = Coordinate("m", 0, typical(-2, 2))
    v1 = Coordinate("m/s", 0, typical(-2, 2))
    v2 = Coordinate("m/s", 0, typical(-2, 2))
    v3 = Coordinate("m/s", "0.5", typical(-2, 2))
    m1 = Parameter("kg", 1, "first mass", positive())
    m2 = Parameter("kg", 2, "second mass", positive())
    m3 = Parameter("kg", "1.5", "third mass", positive())
    k1 = Parameter("N/m", 10, "first mass to the ground", nonnegative(0, 20))
    k2 = Parameter("N/m", 0, "second mass to the ground", nonnegative(0, 20))
    k3 = Parameter("N/m", 5, "third mass to the ground", nonnegative(0, 20))
    k12 = Parameter("N/m", 8, "between first and second mass", nonnegative(0, 20))
    k23 = Parameter("N/m", 12, "between second and third mass", nonnegative(0, 20))
    exact_motion = bind(lambda c: _vibrations(c, (c.m1, c.m2, c.m3), (c.k1, c.k2, c.k3), (c.k12, c.k23)))
    variants = (
        Variant(
            "beats",
            "equal pendulums, coupled at 1e-3: the motion passes to the next one and back in 2000 swings",
            {"m1": 1, "m2": 1, "m3": 1, "k1": 1, "k2": 1, "k3": 1, "k12": "0.001", "k23": "0.001"},
            (1, 0, 0, 0, 0, 0),
            periods=2100.37,
        ),
        Variant(
            "near_degenerate",
            "equal pendulums, coupled at 1e-10: three frequencies equal to ten digits, beats of 1e10 swings",
            {"m1": 1, "m2": 1, "m3": 1, "k1": 1, "k2": 1, "k3": 1, "k12": "1e-10", "k23": "1e-10"},
            (1, 0, 0, 0, 0, 0),
        ),
        Variant(
            "carbon_dioxide",
            "masses 16:12:16 on two springs: a mode of frequency zero, in which the molecule drifts",
            {"m1": 16, "m2": 12, "m3": 16, "k1": 0, "k2": 0, "k3": 0, "k12": 1400, "k23": 1400},
            ("0.1", 0, "-0.05", "0.5", 0, 0),
        ),
        Variant(
            "stiff_1e12",
            "a coupling 1e12 times stiffer than the others: frequencies 1e6 apart",
            {"m1": 1, "m2": 1, "m3": 1, "k1": 1, "k2": 1, "k3": 1, "k12": 10**12, "k23": 1},
            (1, 1, 0, 0, 0, 0),
        ),
        Variant(
            "free",
            "no springs: all three modes have frequency zero",
            dict.fromkeys(("k1", "k2", "k3", "k12", "k23"), 0),
            (1, 2, 3, 1, 0, -1),
            periods=2,
        ),
    )
    invariants = conserved(energy=row_energy)
    forms = (SecondOrder(row_acceleration), SemiLinear(row_equations, linear=row_matrix, rest=nothing_else))
    scene = ROW_SCENE
    alike = (("x1", "v1", "m1", "k1", "k12"), ("x3", "v3", "m3", "k3", "k23"))

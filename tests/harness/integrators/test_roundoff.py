"""Round-off of fixed steps is a random walk: a method's own quadratic invariant drifts as sqrt t, not as t.

The exact step of the method keeps this invariant, computed to 60 digits, so that truncation does not hide round-off.
"""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import Charged, Constrained, FirstOrder, Form, RigidBody, SecondOrder, SemiLinear, Values
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.integrators.base.fixed_step import FixedStep
from gnomon.harness.integrators.gauss import gauss
from gnomon.harness.integrators.gauss.gauss import Gauss5, ImplicitMidpoint
from gnomon.harness.integrators.geometric import boris, exponential, lie, rattle, splitting
from gnomon.harness.integrators.geometric.exponential import HochbruckOstermann4
from gnomon.harness.integrators.multistep_extrapolation import stormer
from gnomon.harness.integrators.multistep_extrapolation.stormer import Stormer, Stormer8, adams_weights, stormer_weights
from gnomon.harness.studies.growth import STRETCH, fit_powers, twenty_bits
from gnomon.harness.studies.orders import solve_exactly
from gnomon.reference.numerics.precision import working
from scipy import stats

METHODS = (
    *splitting.INTEGRATORS, *stormer.INTEGRATORS, *boris.INTEGRATORS, *exponential.INTEGRATORS, *rattle.INTEGRATORS,
    *lie.INTEGRATORS,
)  # fmt: skip
LONG = (rattle.Rattle4, rattle.Rattle6, lie.MuntheKaas4, lie.AxisSplitting6)
"""Their steps take microseconds."""
GAUSS = gauss.INTEGRATORS
PUSHED = (boris.Boris, boris.VolumePreserving4, boris.VolumePreserving6)
"""They conserve the energy exactly in uniform fields, where the charge is not relativistic."""
STARTS, BLOCKS, AVERAGED = 24, 512, 8
"""Samples are averaged in blocks, so that the rounding of a sample, half a unit, does not hide the walk."""

CONFIDENCE = 1 - 0.01 / (len(METHODS) + 2 * len(GAUSS))
"""Confidence of each method's interval, so that all together hold with 99 % (Bonferroni)."""

SQUARE = 1.0734915
FIELD = (0.3, -0.5, 0.8123)
PUSH = 1.2345678
UNITS = np.finfo(float).eps

Value = Callable[[Any], Any]


def oscillator(t: Any, q: Values, parameters: Values) -> Values:
    return (-parameters[0] * q[0],)


def oscillator_first_order(t: Any, state: Values, parameters: Values) -> Values:
    return state[1], -parameters[0] * state[0]


def no_rest(t: Any, state: Values, parameters: Values) -> Values:
    return 0 * state[0], 0 * state[0]


def linear_part(parameters: Values) -> Values:
    return 0, 1, -parameters[0], 0


def only_turning(t: Any, place: Values, parameters: Values) -> Values:
    nothing = 0 * place[0]
    return nothing, nothing, nothing, parameters[0] + nothing, parameters[1] + nothing, parameters[2] + nothing


def pushing_and_turning(t: Any, place: Values, parameters: Values) -> Values:
    nothing = 0 * place[0]
    return 1 + nothing, nothing, nothing, nothing, nothing, 5 + nothing


def gyration(parameters: Values) -> Values:
    """The slopes of (x, y, u_x, u_y) in a uniform magnetic field."""
    b = parameters[0]
    return 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, b, 0, 0, -b, 0


def constant_push(t: Any, state: Values, parameters: Values) -> Values:
    nothing = 0 * state[0]
    return nothing, nothing, PUSH + nothing, nothing


def on_sphere(t: Any, state: Values, parameters: Values) -> Values:
    raise NotImplementedError("RATTLE calls the parts of the form")


def no_force(t: Any, place: Values, parameters: Values) -> Values:
    nothing = (
        0 * place[-1]
    )  # of the attitude, for a rigid body: a splitting takes no torque that depends on the rotation
    return nothing, nothing, nothing


def half_square(t: Any, place: Values, parameters: Values) -> Values:
    return ((place[0] * place[0] + place[1] * place[1] + place[2] * place[2]) / 2,)


def outward(t: Any, place: Values, parameters: Values) -> Values:
    return place[0], place[1], place[2]


MOMENTS = (1.0, 1.7320508, 2.2360679)


def moments(parameters: Values) -> Values:
    return MOMENTS


def slow_light(parameters: Values) -> Values:
    return (3,)


def turning_equations(t: Any, state: Values, parameters: Values) -> Values:
    raise NotImplementedError("methods for charges call the fields")


def step_of(method: type[FixedStep]) -> float:
    """A step so short that truncation at the start is below round-off. The exponential method has no truncation: at its
    step the rounded exponential is far from a rotation, as its determinant is 0.077 units of round-off off."""
    if method is HochbruckOstermann4:
        return 0.275
    return 0.01 if method is Stormer8 else 0.02 if issubclass(method, Stormer) else 0.1


def problem_for(method: type[FixedStep], interval: float, count: int, first_order: bool) -> Problem:
    times = np.arange(1, count + 1) * interval
    if method in boris.INTEGRATORS:
        light = slow_light if method is boris.HigueraCary else None
        form: Form = Charged(turning_equations, fields=only_turning, light=light)
        return Problem(form, 6, np.array(FIELD), times, 1.0)
    if method in rattle.INTEGRATORS:
        form = Constrained(on_sphere, force=no_force, constraint=half_square, gradient=outward)
        return Problem(form, 6, np.zeros(0), times, 1.0)
    if method in lie.INTEGRATORS:
        return Problem(RigidBody(moments, no_force), 12, np.zeros(0), times, 1.0)
    if method is HochbruckOstermann4:
        form = SemiLinear(oscillator_first_order, linear=linear_part, rest=no_rest)
    else:
        form = FirstOrder(oscillator_first_order) if first_order else SecondOrder(oscillator)
    return Problem(form, 2, np.array([SQUARE]), times, 1.0)


def starts_of(form: Form, dimension: int) -> Any:
    """Random states (STARTS, dimension): on the unit sphere with a tangent velocity; at first without a rotation."""
    start = np.random.default_rng(1).standard_normal((STARTS, dimension))
    if isinstance(form, Constrained):
        place, velocity = start[:, :3], start[:, 3:]
        place /= np.linalg.norm(place, axis=1, keepdims=True)
        velocity -= np.sum(place * velocity, axis=1, keepdims=True) * place
    if isinstance(form, RigidBody):
        start[:, 3:] = np.eye(3).ravel()
    return start


def invariant_of(method: type[FixedStep], form: Any, h: float) -> tuple[Value, Any]:
    """A quadratic form that a step multiplies by a factor, and the logarithm of that factor.

    Of the 2x2 matrix M of a step it is y x M y, as My x MMy = det M (y x My). Boris's methods rotate u. On a sphere without
    a force a step of RATTLE conserves the angular momentum, and methods for rigid bodies rotate that in body axes.
    """
    if isinstance(form, Constrained):
        return (lambda y: np.sum(np.cross(y[..., :3], y[..., 3:]) ** 2, axis=-1)), np.longdouble(0)
    if isinstance(form, RigidBody):
        return (lambda y: np.sum((np.array(MOMENTS) * y[..., :3]) ** 2, axis=-1)), np.longdouble(0)
    if isinstance(form, Charged):
        return (lambda state: np.sum(state[..., 3:] ** 2, axis=-1)), np.longdouble(0)
    with working(60) as mp:
        if issubclass(method, Stormer):
            m = matrix_of_stormer(mp, method.order, mp.mpf(h))
        else:
            numbers = form, (Fraction(SQUARE),)
            ends = [solve_exactly(method(), *numbers, start, Fraction(h), 1) for start in ((1, 0), (0, 1))]
            m = mp.matrix(ends).T
        weights = [wide(x) for x in (m[1, 0], m[1, 1] - m[0, 0], -m[0, 1])]
        factor = wide(mp.log(mp.det(m)))
    return (
        lambda y: weights[0] * y[..., 0] ** 2 + weights[1] * y[..., 0] * y[..., 1] + weights[2] * y[..., 1] ** 2
    ), factor


def matrix_of_stormer(mp: Any, order: int, h: Any) -> Any:
    """The matrix of a step on (q, v) = (1, d) z^n, once all parts of the start but the oscillation z^n have decayed."""
    square = h * h * mp.mpf(SQUARE)

    def total(weights: Any, z: Any) -> Any:
        return mp.fsum(mp.mpf(w.numerator) / w.denominator * (1 - 1 / z) ** m for m, w in enumerate(weights))

    z = mp.findroot(lambda z: z - 2 + 1 / z + square * total(stormer_weights(order), z), mp.expj(mp.sqrt(square)))
    d = -square / h * total(adams_weights(order + 1), z) / (1 - 1 / z)
    modes = mp.matrix([[1, 1], [d, mp.conj(d)]])
    return (modes * mp.diag([z, mp.conj(z)]) * modes**-1).apply(mp.re)


def wide(x: Any) -> Any:
    """A number of mpmath in extended precision."""
    high = np.longdouble(float(x))
    return high + np.longdouble(float(x - float(x)))


def drifts(method: type[FixedStep], steps: int, first_order: bool, h: float = 0.0) -> Any:
    """The drift of the invariant in units of round-off, (starts, blocks of time); in steps of h, or of `step_of`."""
    substeps = steps // (BLOCKS * AVERAGED)
    interval = twenty_bits((h or step_of(method)) * substeps)
    problem = problem_for(method, interval, BLOCKS * AVERAGED, first_order)
    solution = method().prepare(problem, interval / substeps)(starts_of(problem.form, problem.dimension))
    assert solution.stopped is None
    value, factor = invariant_of(method, problem.form, interval / substeps)
    sizes = value(solution.states.astype(np.longdouble))
    made = substeps * np.arange(BLOCKS * AVERAGED)
    # From the first sample on: the start of a multistep method does not conserve its invariant.
    moved = sizes / sizes[:, :1] * np.exp(-factor * made) - 1
    return (moved / UNITS).astype(np.float64).reshape(STARTS, BLOCKS, AVERAGED).mean(axis=2)


def interval_of_power(
    method: type[FixedStep], steps: int, first_order: bool = False, h: float = 0.0
) -> tuple[float, float]:
    """Student's interval of the mean power of time over the starts."""
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("this machine has no arithmetic beyond binary64")
    powers = fit_powers((np.arange(BLOCKS) + 0.5) / BLOCKS, drifts(method, steps, first_order, h))
    low, high = stats.t.interval(CONFIDENCE, STARTS - 1, np.mean(powers), stats.sem(powers))
    return float(low), float(high)


@pytest.mark.parametrize(
    "method",
    [pytest.param(method, marks=pytest.mark.slow if method in LONG else ()) for method in METHODS],
    ids=lambda method: method.name,
)
def test_over_65536_steps_the_drift_is_no_faster_than_a_random_walk(method: type[FixedStep]) -> None:
    """Coefficients or a rotation that are rounded the same way in every step give the power 1, and so do biased ties."""
    low, _ = interval_of_power(method, 2**16)
    assert low < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_over_a_million_steps_a_random_walk_is_not_excluded(method: type[FixedStep]) -> None:
    low, high = interval_of_power(method, 2**20)
    assert low < 0.5 < high


@pytest.mark.slow
@pytest.mark.parametrize("first_order", [True, False], ids=["first order", "second order"])
@pytest.mark.parametrize("method", GAUSS, ids=lambda method: method.name)
def test_over_a_million_steps_the_drift_of_gauss_methods_is_a_random_walk(
    method: type[FixedStep], first_order: bool
) -> None:
    """With coefficients rounded one by one methods of 2 and 3 stages gain or lose 1.5e-4 units in each step of the
    first-order equations, even if their rests are added: products by 1/4 or 5/18 round that rest the same way."""
    low, high = interval_of_power(method, 2**20, first_order)
    assert low < 0.5 < high


def test_at_steps_of_a_radian_rounded_coefficients_make_no_drift() -> None:
    """Second-order coefficients rounded one by one made a drift of .0053 units in each step, with a power of .88."""
    low, _ = interval_of_power(Gauss5, 2**17, h=1.0)
    assert low < 0.5


@pytest.mark.parametrize("method", PUSHED, ids=lambda method: method.name)
def test_where_a_uniform_field_pushes_the_energy_is_a_random_walk(method: type[FixedStep]) -> None:
    """The rounding of a sum with the same push is the same wherever the sum is between the same powers of two: without its
    residual the power is .998 (Volume-preserving 4) and .914 (6)."""
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("this machine has no arithmetic beyond binary64")
    interval = twenty_bits(STRETCH * 2 * np.pi / 5 / 16 * 8)
    times = np.arange(1, BLOCKS * AVERAGED + 1) * interval
    problem = Problem(Charged(turning_equations, fields=pushing_and_turning), 6, np.array([0.0]), times, 1.0)
    start = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.5]) * (1 - np.arange(STARTS)[:, None] / 64)
    solution = method().prepare(problem, interval / 8)(start.copy())
    assert solution.stopped is None
    states = np.concatenate([start[:, None], solution.states], axis=1).astype(np.longdouble)
    energy = np.sum(states[..., 3:] ** 2, axis=-1) / 2 - states[..., 0]
    moved = (energy[:, 1:] / energy[:, :1] - 1).astype(np.float64) / UNITS
    powers = fit_powers((np.arange(BLOCKS) + 0.5) / BLOCKS, moved.reshape(STARTS, BLOCKS, AVERAGED).mean(axis=2))
    low, _ = stats.t.interval(1 - 0.01 / len(PUSHED), STARTS - 1, np.mean(powers), stats.sem(powers))
    assert low < 0.5


def test_where_a_constant_rest_pushes_an_exponential_method_the_energy_is_a_random_walk() -> None:
    """Without the rounding residuals of the coefficients of that rest, and of its sums, the power was at least .89."""
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("this machine has no arithmetic beyond binary64")
    substeps = 16
    h = twenty_bits(0.0779 * substeps) / substeps
    times = np.arange(1, BLOCKS * AVERAGED + 1) * (substeps * h)
    problem = Problem(
        SemiLinear(turning_equations, linear=gyration, rest=constant_push), 4, np.array([5.0]), times, 1.0
    )
    solution = HochbruckOstermann4().prepare(problem, h)(np.random.default_rng(1).standard_normal((STARTS, 4)))
    assert solution.stopped is None
    states = solution.states.astype(np.longdouble)
    energy = (states[..., 2] ** 2 + states[..., 3] ** 2) / 2 - np.longdouble(PUSH) * states[..., 0]
    moved = ((energy - energy[:, :1]) / UNITS).astype(np.float64).reshape(STARTS, BLOCKS, AVERAGED).mean(axis=2)
    powers = fit_powers((np.arange(BLOCKS) + 0.5) / BLOCKS, moved)
    low, _ = stats.t.interval(0.99, STARTS - 1, np.mean(powers), stats.sem(powers))
    assert low < 0.5


def test_the_error_that_an_iteration_leaves_is_not_biased() -> None:
    """When stages were accepted with a last change below round-off, the error left made the power 1.000."""
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("this machine has no arithmetic beyond binary64")
    h = twenty_bits(0.1)
    times = np.arange(1, BLOCKS * AVERAGED + 1) * (8 * h)
    problem = Problem(FirstOrder(oscillator_first_order), 2, np.array([SQUARE]), times, 1.0)
    solution = ImplicitMidpoint().prepare(problem, h)(np.random.default_rng(1).standard_normal((STARTS, 2)))
    states = solution.states.astype(np.longdouble)
    energy = np.longdouble(SQUARE) * states[..., 0] ** 2 + states[..., 1] ** 2
    moved = ((energy / energy[:, :1] - 1) / UNITS).astype(np.float64).reshape(STARTS, BLOCKS, AVERAGED).mean(axis=2)
    powers = fit_powers((np.arange(BLOCKS) + 0.5) / BLOCKS, moved)
    low, _ = stats.t.interval(0.99, STARTS - 1, np.mean(powers), stats.sem(powers))
    assert low < 0.5

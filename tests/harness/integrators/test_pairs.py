"""Embedded pairs: order conditions of both formulas and of the dense output, error against tolerance."""

import math
from dataclasses import replace

import numpy as np
import pytest
from breadth import marks
from gnomon.cases.core.forms import FirstOrder, SecondOrder
from gnomon.cases.core.registry import get
from gnomon.harness.contract.problem import counting, initial_state, problem_of
from gnomon.harness.integrators.base import step_control
from gnomon.harness.integrators.base.fixed_step import DIGITS, round_table
from gnomon.harness.integrators.base.step_control import Adaptive, tabulate
from gnomon.harness.integrators.base.tableau import full
from gnomon.harness.integrators.multistep_extrapolation.extrapolation import GraggBulirschStoer
from gnomon.harness.integrators.runge_kutta import dop853
from gnomon.harness.integrators.runge_kutta.embedded import Embedded
from gnomon.harness.integrators.runge_kutta.nystrom import DormandPrinceNystrom12, Nystrom
from gnomon.harness.integrators.runge_kutta.nystrom_table import RKN_12_10
from gnomon.harness.registry import lookup
from gnomon.harness.studies.fixed_step_formulas import at_fixed_steps
from gnomon.harness.studies.orders import measure_order_exactly
from gnomon.reference.numerics.precision import working
from on_cases import solved
from order_conditions import formulas, has_order, matrix, nystrom_residuals, rk_residuals
from scipy.integrate import solve_ivp

SMOOTH = [type(one) for one in lookup.in_house() if {FirstOrder, SecondOrder} & {*one.accepts}]
RUNGE_KUTTA = [kind for kind in SMOOTH if issubclass(kind, Embedded) and kind is not dop853.Dop853]
NYSTROM = [kind for kind in SMOOTH if issubclass(kind, Nystrom)]
PAIRS: tuple[type[Adaptive], ...] = (*RUNGE_KUTTA, dop853.Dop853, *NYSTROM)
RUN = pytest.mark.parametrize("pair", [pytest.param(one, id=one.name, marks=marks(one)) for one in PAIRS])

PRINTED = 1e-58
"""The coefficients are exact, or given to 60 digits."""

NYSTROM_PRINTED = 1e-51
"""The last rows of RKN 12(10) hold to 54 digits; their sums have terms up to 40."""


@pytest.mark.parametrize(
    "pair", [pair for pair in RUNGE_KUTTA if pair.tableau.dense is not None and not pair.tableau.extra]
)
def test_dense_output_meets_the_conditions_of_its_order(pair: type[Embedded]) -> None:
    """At fractions x of the step the weights of `embedded.interpolate`, applied to the slopes: cubic without a row of
    coefficients, and of one degree, and order, more with it. Further stages would have conditions of their own."""
    order = 3 + len(pair.tableau.dense or ())
    with working(62) as mp:
        (_, a, b), _ = formulas(mp, pair.tableau)
        s, dense = len(pair.tableau.a), [full(mp, row, len(a)) for row in pair.tableau.dense or ()]
        for x in (mp.mpf(1) / 7, mp.mpf(2) / 3):
            inner = dense[0] if dense else [mp.mpf(0)] * len(a)
            weights = []
            for j in range(len(a)):
                first, last = mp.mpf(j == 0), mp.mpf(j == s)
                cubic = first - b[j] + x * (2 * b[j] - first - last + (1 - x) * inner[j])
                weights.append(x * (b[j] + (1 - x) * cubic))
            assert has_order(rk_residuals(a, weights, order + 1, x), order, PRINTED)


@pytest.mark.parametrize("pair", NYSTROM, ids=lambda pair: pair.name)
def test_both_nystrom_formulas_meet_their_conditions_and_no_more(pair: type[Nystrom]) -> None:
    with working(66) as mp:
        table = pair.tableau.fixed_rows(mp)
        stages = len(table) - 2
        a, c = matrix(mp, [row[1:] for row in table[:stages]]), [row[0] for row in table[:stages]]
        others = [full(mp, row, stages) for row in pair.tableau.embedded]
        weights = (table[-2][1 : stages + 1], table[-1][1 : stages + 1])
        for (b, d), order in zip((weights, others), pair.tableau.orders, strict=True):
            assert has_order(nystrom_residuals(a, c, b, d, order + 1), order, NYSTROM_PRINTED)
        assert all(abs(mp.fsum(row[1:]) - row[0] ** 2 / 2) < NYSTROM_PRINTED for row in table[:stages])


def test_a_planted_coefficient_is_caught() -> None:
    """One wrong digit of the smallest weight of RKN 12(10), 1e-3 of it, lowers the order from 12."""

    class Mistyped(DormandPrinceNystrom12):
        tableau = replace(RKN_12_10, d={**RKN_12_10.d, 15: "-113178588/12362232960"})

    measured = measure_order_exactly(at_fixed_steps(Mistyped()), get("kepler_orbit", span="0.5"), (24, 32, 48, 64))
    assert measured is None or measured[0] < 11


FOLLOWING = [
    *(pytest.param(one, name, marks=marks(one)) for one in PAIRS for name in ("pendulum_simple", "kepler_orbit")),
    *((GraggBulirschStoer, name) for name in ("pendulum_simple", "kepler_orbit", "euler_top")),
    (dop853.Dop853, "euler_top"),
]


@pytest.mark.parametrize(("pair", "name"), FOLLOWING, ids=lambda value: getattr(value, "name", value))
def test_the_error_follows_the_tolerance(pair: type[Adaptive], name: str) -> None:
    """Over six decades of tolerance the error falls by five to six, by up to nine where the estimate is of low order."""
    case = get(name).rounded()
    loose, tight = (solved(pair(), case, tolerance) for tolerance in (1e-6, 1e-12))
    assert 1e-9 < tight.error / loose.error < 1e-4
    # Over ten periods errors grow with the square of time, and each of many short steps may add the tolerance; signs of the
    # errors differ where steps are very many.
    assert tight.error < 1e-12 * np.clip(5 * tight.steps, 10**4, 3 * 10**4)


@RUN
def test_samples_do_not_change_the_steps_and_are_as_good_as_they(pair: type[Adaptive]) -> None:
    """At some ten times in each step the error is at most twice that at the ends of the intervals between samples."""
    case = get("pendulum_simple").rounded()
    problem = problem_of(case, pair.accepts)
    times = np.linspace(0.0, float(case.times[-1]), 4097)[1:]
    few, many = (
        pair().prepare(replace(problem, times=t), 1e-8)(initial_state(case)[None])
        for t in (problem.times[-1:].copy(), times)
    )
    assert few.steps == many.steps
    assert np.array_equal(few.states[0, -1], many.states[0, -1])
    errors = case.metric.distance(many.states[0], case.sample(times))
    assert np.max(errors) < 2 * np.max(errors[63::64])


@pytest.mark.parametrize("method", PAIRS, ids=lambda method: method.name)
def test_tables_of_decimals_are_those_of_mpmath(method: type[Adaptive]) -> None:
    with working(DIGITS) as mp:
        assert tabulate(method.rows).tobytes() == round_table(method.rows(mp)).tobytes()


@pytest.mark.parametrize("tolerance", [1e-8, 1e-10])
@pytest.mark.parametrize("eccentricity", [0.6, 0.9])
def test_few_steps_are_rejected_on_eccentric_orbits(eccentricity: float, tolerance: float) -> None:
    """DOP853 takes 11 right-hand sides an attempt, one more a step accepted, three more where a step holds samples and
    two at the start. With a controller that uses the last error alone a fifth to a third of these steps are rejected."""
    state = (1 - eccentricity, 0.0, 0.0, math.sqrt((1 + eccentricity) / (1 - eccentricity)))
    case = get("kepler_orbit", "speed_e06", initial_state=state).rounded()
    found = solved(dop853.Dop853(), case, tolerance, counted=True)
    rejected = (found.calls - 12 * found.steps - 3 * len(case.times) - 2) / 11
    assert rejected < 0.06 * found.steps


def test_work_is_that_of_scipy_at_the_same_tolerance() -> None:
    """The controllers differ (PI here, I in SciPy), the formulas and the norm do not: within a fifth."""
    case = get("kepler_orbit").rounded()
    problem = counting(problem_of(case, dop853.Dop853.accepts))
    dop853.Dop853().prepare(problem, 1e-9)(initial_state(case)[None])
    equations = problem.form.equations  # type: ignore[union-attr]
    parameters = tuple(problem.parameters.tolist())
    scipy = solve_ivp(
        lambda t, y: equations(t, tuple(y.tolist()), parameters),
        (0.0, problem.times[-1]),
        initial_state(case),
        method="DOP853",
        rtol=1e-9,
        atol=1e-9,
    )
    extra = 3 * len(problem.times)  # stages of the dense output, in steps that hold samples
    assert 0.8 * scipy.nfev < problem.buffer[-1] < 1.2 * scipy.nfev + extra


def next_error(coefficient: float, step: float, factor: float) -> float:
    """The error over the tolerance, where it is `coefficient` h^8."""
    return coefficient * (step * factor) ** 8


@pytest.mark.parametrize("grown", [1.5, 40.0])
def test_steps_of_high_order_extrapolate_the_growth_of_the_error(monkeypatch: pytest.MonkeyPatch, grown: float) -> None:
    """The growth of the error's coefficient in the last step is assumed to go on: the next error is 0.8^8 of the tolerance."""
    monkeypatch.setattr(step_control, "ERROR_ORDER", 8)
    last, step, before = 0.3, 0.2, 0.4
    error = before * grown * (step / last) ** 8
    factor = step_control.lengthen(error, before, step, last)
    assert next_error(error / step**8 * grown, step, factor) == pytest.approx(0.8**8)
    # A decrease is not extrapolated, nor is anything after the first step.
    for known in (
        step_control.lengthen(error, before, step, 0.8 * step),
        step_control.lengthen(error, before, step, 0.0),
    ):
        assert next_error(error / step**8, step, known) == pytest.approx(0.8**8)
    # At most half of the factor from the error alone, and errors below 1e-4 count as 1e-4.
    assert step_control.lengthen(error, 1e-4, step, last) == pytest.approx(0.5 * 0.8 * error ** (-1 / 8))
    assert step_control.lengthen(1e-9, 1e-4, step, step) == pytest.approx(0.8 * 1e-4 ** (-1 / 8))
    assert next_error(7.0 / step**8, step, step_control.shorten(7.0)) == pytest.approx(0.8**8)


def test_steps_of_lower_order_are_those_of_hairers_controller(monkeypatch: pytest.MonkeyPatch) -> None:
    """Solving Ordinary Differential Equations I, II.4: 0.9 err^-(1/q - 0.2 beta) err_before^beta with beta = 0.04."""
    monkeypatch.setattr(step_control, "ERROR_ORDER", 5)
    for error, before in ((0.5, 0.1), (0.01, 0.9)):
        factor = 0.9 * error ** -(0.2 - 0.008) * before**0.04
        assert step_control.lengthen(error, before, 0.1, 0.3) == pytest.approx(factor)
        assert step_control.shorten(1 / error) == pytest.approx(0.9 * error ** (0.2 - 0.008))

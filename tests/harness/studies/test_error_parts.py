"""The four parts of an engine's error are found in errors whose parts are known."""

import math
from fractions import Fraction

import pytest
from gnomon.cases import get
from gnomon.harness.studies.error_parts import BINARY32, BITS, floor_of, parts

STEPS = [1e-2 / 2**k for k in range(8)]
FLOOR = 1e-15


def test_a_power_of_the_step_is_integration_alone() -> None:
    """Without a rest nothing is left when the step goes to zero, so no part of the error is of the model."""
    found = parts(STEPS, [3.0 * (h / 0.5) ** 2 for h in STEPS], 0.5, FLOOR)
    assert found.order == pytest.approx(2.0)
    assert found.constant == pytest.approx(3.0)
    assert (found.rest, found.rest_is, found.solver) == (None, "", None)


def test_what_remains_far_above_the_arithmetic_is_of_the_model() -> None:
    """A compliant contact stops at the compliance: the finest steps have one error."""
    found = parts(STEPS, [2e-3 + h**2 for h in STEPS], 1.0, FLOOR)
    assert found.rest_is == "model"
    assert found.rest == pytest.approx(2e-3, rel=0.05)


def test_what_remains_at_the_floor_of_the_arithmetic_is_precision() -> None:
    floor = floor_of(BINARY32, FLOOR)
    found = parts(STEPS, [floor + h**4 for h in STEPS], 1.0, floor)
    assert found.rest_is == "precision"


def test_an_error_that_scatters_has_no_order() -> None:
    """A rank of orders that a scatter imitates would be false: between neighbours the slope is 3 and -1 here."""
    errors = [h * (4.0 if k % 2 else 1.0) for k, h in enumerate(STEPS)]
    found = parts(STEPS, errors, 1.0, FLOOR)
    assert found.order is None


def test_the_solver_is_the_change_by_a_tighter_one_at_the_finest_common_step() -> None:
    errors = [h for h in STEPS]
    found = parts(STEPS, errors, 1.0, FLOOR, {STEPS[3]: 0.9 * STEPS[3], STEPS[1]: 0.0})
    assert found.solver == pytest.approx(0.1 * STEPS[3])


def test_the_largest_step_counts_only_if_all_finer_ones_keep_the_error() -> None:
    """An error that is small by chance at one step recommends nothing."""
    found = parts([4e-3, 2e-3, 1e-3, 5e-4], [1e-5, 5e-3, 5e-4, 1e-4], 1.0, FLOOR)
    assert found.steps == {"0.01": 4e-3, "0.001": 1e-3, "0.0001": 5e-4}
    lost = parts([2e-3, 1e-3], [math.inf, 5e-3], 1.0, FLOOR)
    assert lost.steps["0.01"] == 1e-3


def test_the_floor_of_binary32_is_the_effect_of_its_ulps() -> None:
    """Half an ulp of binary32 in a start moves the exact motion 2^29 times as far as half an ulp of binary64."""
    case = get("pendulum_simple", "engines").rounded()
    moved = {}
    for bits in (BITS, BINARY32):
        theta = case.initial_state[0] * (1 + Fraction(1, 2**bits))
        other = get("pendulum_simple", initial_state=(theta, case.initial_state[1]), span=case.span)
        times = case.times[-1:]
        moved[bits] = abs(float(case.exact(times[0].item(), digits=40)[0] - other.exact(times[0].item(), digits=40)[0]))
    # The next term of the effect of 2^-24 is 2^-24 times the growth over the span, some 1e5 here: 1 %.
    assert moved[BINARY32] / moved[BITS] == pytest.approx(2.0 ** (BITS - BINARY32), rel=0.03)
    assert floor_of(BINARY32, 1e-16) == pytest.approx(1e-16 * 2.0**29)

"""Extrapolation: each column has its order, the error follows the tolerance, the order follows it too."""

import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.integrators.multistep_extrapolation.extrapolation import GraggBulirschStoer
from gnomon.harness.studies.fixed_step_formulas import with_columns
from gnomon.harness.studies.orders import measure_order_exactly
from on_cases import of_order, solved


@pytest.mark.parametrize(("count", "coarsest"), [(1, 96), (2, 48), (4, 24), (7, 24)])
def test_each_column_is_two_orders_better(count: int, coarsest: int) -> None:
    counts = [coarsest * n // 12 for n in (12, 16, 24, 32)]
    measured = measure_order_exactly(with_columns(count), get("kepler_orbit", span="0.5"), counts, digits=80)
    assert measured == of_order(2 * count), "the next term is smaller by the square of the step"


def test_the_order_follows_the_tolerance() -> None:
    """Right-hand sides a step: a third column at 1e-3, a seventh or more at 1e-13, and at most three times as many steps."""
    case = get("kepler_orbit").rounded()
    loose, tight = (solved(GraggBulirschStoer(), case, tolerance, counted=True) for tolerance in (1e-3, 1e-13))
    assert loose.calls < 25 * loose.steps
    assert tight.calls > 50 * tight.steps
    assert tight.steps < 3 * loose.steps


def test_steps_follow_an_orbit_of_high_eccentricity() -> None:
    """At e = 0.99 the steps at pericentre are a thousandth of those at apocentre."""
    case = get("kepler_orbit", "speed_e099").rounded()
    assert solved(GraggBulirschStoer(), case, 1e-13).error < 1e-13 * 1e7, (
        "a hundred periods, and a conditioning near 1e-9"
    )

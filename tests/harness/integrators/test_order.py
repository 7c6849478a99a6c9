"""The order as it is measured: a wrong coefficient does not pass, and a slope is fitted where it means something."""

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any
from unittest.mock import ANY

import numpy as np
import pytest
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator, Problem, Solution, Steps
from gnomon.harness.integrators.base.fixed_step import FixedStep
from gnomon.harness.integrators.gauss.gauss import Gauss4
from gnomon.harness.integrators.geometric.splitting import KahanLi6, KahanLi8, Yoshida8
from gnomon.harness.integrators.runge_kutta.explicit import RK4
from gnomon.harness.results.convergence_order import fit_order, line, mean_slope
from gnomon.harness.studies.orders import (
    WITHIN,
    fit_order_exactly,
    measure_order,
    measure_order_exactly,
    solve_exactly,
)
from on_cases import exact_states


class WrongWeight(RK4):
    """RK4 with one weight off by 1e-5."""

    tableau = replace(RK4.tableau, b={0: "1/6", 1: "0.333343", 2: "1/3", 3: "1/6"})


class MistypedLength(KahanLi6):
    """Kahan-Li 6 with two digits of one length exchanged, an error of 1e-8: the sum is still 1."""

    half = (*KahanLi6.half[:1], "0.332599146789359438599748629305934", *KahanLi6.half[2:])


class MistypedBelowBinary64(KahanLi8):
    """Kahan-Li 8 with one length off by 1e-16, which its binary64 rounding hardly shows."""

    @classmethod
    def lengths(cls, mp: Any) -> list[Any]:
        first = [mp.mpf(text) for text in cls.half]
        first[2] += mp.mpf(10) ** -16
        return [*first, 1 - 2 * mp.fsum(first), *reversed(first)]


def pendulum(order: int) -> Case:
    """Long enough for steps at which a method of high order stands clear of round-off, short for the others."""
    return get("pendulum_simple", span=16 if order >= 8 else 8 if order >= 6 else 3)


@pytest.mark.parametrize(
    ("method", "counts"),
    [
        (KahanLi8, (48, 64, 96, 128)),
        (Yoshida8, (96, 128, 192, 256)),
        (Gauss4, (48, 64, 96, 128)),
    ],
)
def test_order_in_sixty_digits(method: type[FixedStep], counts: tuple[int, ...]) -> None:
    found = measure_order_exactly(method(), get("pendulum_simple", span=3), counts)
    assert found == (pytest.approx(method.order, abs=WITHIN), ANY)


@pytest.mark.parametrize("method", [WrongWeight, MistypedLength])
def test_a_planted_coefficient_is_caught(method: type[FixedStep]) -> None:
    assert method.order is not None
    measured = measure_order(method(), pendulum(method.order))
    assert measured is None or abs(measured[0] - method.order) > WITHIN


def test_a_planted_coefficient_below_binary64_is_caught_in_sixty_digits() -> None:
    measured = measure_order_exactly(MistypedBelowBinary64(), get("pendulum_simple", span=3), (768, 1024, 1536, 2048))
    assert measured is not None
    assert abs(measured[0] - 8) > WITHIN


class Planted(Integrator):
    """Errors of order 4, `small` at one step a sample, on the exact states of a case; nothing is integrated."""

    name, accepts, sweep = "planted", (FirstOrder,), Steps()

    def __init__(self, case: Case, small: float, compensated: bool) -> None:
        self.exact, self.small, self.compensated = exact_states(case), small, compensated

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        share = 1 + self.small * (setting / problem.interval) ** 4
        return lambda initial: Solution(self.exact[None] * share)


@pytest.mark.parametrize(("compensated", "points"), [(False, 5), (True, 6)])
def test_the_range_ends_where_round_off_does(compensated: bool, points: int) -> None:
    """A hundred times the conditioning, and where steps are summed plainly times the root of 64 n: up to n = 7 and 15,
    which leaves n = 1, 2, 3, 4, 6 of the refinements, and more."""
    case = pendulum(4).rounded()
    small = 5e6 * float(np.max(case.conditioning(case.times)))
    measured = measure_order(Planted(case, small, compensated), case)
    assert measured == (pytest.approx(4, abs=0.01), points)


def test_a_state_larger_than_one_is_measured_by_its_size_and_down_to_ten_digits_less() -> None:
    """Errors of order 4 from 0.9e-2 of the place, thousands of metres, on."""
    case, counts = get("projectile_parabola", initial_state=(0, 0, 4096, 4096), g=1, span=2), (1, 2, 3, 4)
    exact = case.exact(case.span, 40)

    def end(count: int) -> list[Any]:
        return [x + 9 * x / (1000 * count**4) for x in exact]

    assert fit_order_exactly(end, case, counts, 20) == (pytest.approx(4.0), 4)


def cubic(t: Any, state: Values, parameters: Values) -> Values:
    return (4 * t**3,)


def test_steps_in_many_digits_know_the_time() -> None:
    """RK4 is Simpson's rule on y' = 4 t^3, exact for cubics."""
    (y,) = solve_exactly(RK4(), FirstOrder(cubic), (), (Fraction(0),), Fraction(2), 3)
    assert abs(y - 16) < 1e-55


def test_coarser_points_that_bend_the_slope_are_left_out() -> None:
    """h^2 (1 + 64 h): the slopes of the last 4 and 5 points are 2.09 and 2.13; of h^2 (1 + 8 h), 2.01 to 2.03."""
    steps = [2.0**-k for k in range(5, 12)]
    for bend, points in ((64, 4), (8, 6)):
        assert fit_order(steps, [h**2 * (1 + bend * h) / 4 for h in steps]) == (ANY, points)


def test_fit_needs_four_points_in_the_range() -> None:
    steps = [2.0**-k for k in range(10)]
    assert fit_order(steps, [h**3 for h in steps]) == (pytest.approx(3.0), 6)
    assert fit_order(steps[:5], [h**3 for h in steps[:5]]) is None, "only h = 1/8 and 1/16 lie below 1e-2"


def test_fit_stops_at_the_floor() -> None:
    steps = [2.0**-k for k in range(20)]
    errors = np.maximum([h**4 for h in steps], 1e-12)
    assert fit_order(steps, errors.tolist(), floor=1e-12) == (pytest.approx(4.0, abs=1e-9), ANY)
    assert fit_order(steps, [h**4 for h in steps], floor=1e-3) is None


def test_fit_leaves_out_what_comes_before_a_large_error_or_after_the_floor() -> None:
    """A lucky coarse step; round-off that happens to stand above the floor again. Three points are left of each."""
    steps = [2.0**-k for k in range(9)]
    lucky = [1e-5, *(h**2 for h in steps[1:7])]
    assert fit_order(steps[:7], lucky) is None
    after = [*(h**2 for h in steps[:8]), 5e-3]
    assert fit_order(steps, after, floor=1e-6) is None
    assert fit_order(steps, [h**2 for h in steps]) == (pytest.approx(2.0), 5)


def test_an_order_that_settings_agree_on_has_a_margin_that_holds_the_declared_one() -> None:
    """An error h^4 (1 + 1.5 h) at h from 1/16 to 1/128: the slopes agree within 0.1, on 4.03; the order is 4."""
    steps = [2.0**-k for k in range(4, 8)]
    found = line(steps, [h**4 * (1 + 1.5 * h) / 4 for h in steps], 0.0, 0.1)
    assert found is not None
    order, margin = found
    assert order - margin < 4 < order - 0.02
    assert line(steps, [h**4 for h in steps], 0.0, 0.1) == (pytest.approx(4), pytest.approx(0, abs=1e-9))


def test_the_interval_of_a_mean_slope_holds_it_as_often_as_it_says() -> None:
    """Of points that scatter independently neighbouring slopes are against each other, and it is wider than it need be."""
    random = np.random.default_rng(8)
    held = 0
    for _ in range(300):
        slope, margin = mean_slope([(x, 2 * x + y) for x, y in enumerate(0.1 * random.standard_normal(4))])
        held += abs(slope - 2) <= margin
    assert held > 0.95 * 300 - 2 * math.sqrt(0.95 * 0.05 * 300)
    walk = [mean_slope(list(enumerate(np.cumsum(random.standard_normal(4)).tolist()))) for _ in range(1000)]
    # Of independent slopes it is Student's interval itself: 950 of 1000, give or take 7.
    assert 930 < sum(abs(slope) <= margin for slope, margin in walk) < 970

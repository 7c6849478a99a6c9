"""The loop of steps that adaptive methods share: sums keep their last digits, step sizes depend only on the motion."""

import math
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, Hybrid, Mode, SecondOrder, Values
from gnomon.harness.contract.integrator import Integrator, Problem
from gnomon.harness.integrators.base import sizes, step_control
from gnomon.harness.integrators.base.step_control import GROW_MOST
from gnomon.harness.integrators.base.stepping import StepData
from gnomon.harness.integrators.events.hybrid import Dop853Events
from gnomon.harness.integrators.multistep_extrapolation.extrapolation import GraggBulirschStoer
from gnomon.harness.integrators.runge_kutta.dop853 import Dop853
from gnomon.harness.integrators.runge_kutta.explicit_pairs import BogackiShampine3, DormandPrince5
from gnomon.harness.integrators.runge_kutta.nystrom import DormandPrinceNystrom6

DRIFT = 1e-3 * math.sqrt(0.5)


def problem(form: Any, dimension: int, times: Any, **more: Any) -> Problem:
    return Problem(form, dimension, np.zeros(0), np.asarray(times, dtype=float), 1.0, **more)


def drifting(t: float, state: Values, parameters: Values) -> Values:
    """x drifts uniformly; an oscillator beside it keeps the steps short."""
    x, a, b = state
    return DRIFT + 0 * x, b, -a


def drifting_twice(t: float, q: Values, parameters: Values) -> Values:
    x, a = q
    return 0 * x, -a


@pytest.mark.parametrize(
    ("method", "form", "start"),
    [
        (Dop853, FirstOrder(drifting), [1.0, 1.0, 0.0]),
        (DormandPrince5, FirstOrder(drifting), [1.0, 1.0, 0.0]),
        (GraggBulirschStoer, FirstOrder(drifting), [1.0, 1.0, 0.0]),
        (DormandPrinceNystrom6, SecondOrder(drifting_twice), [1.0, 1.0, DRIFT, 0.0]),
    ],
)
def test_sums_are_compensated(method: type[Integrator], form: Any, start: list[float]) -> None:
    """Thousands of steps of a uniform motion from 1 to 1.7: plain sums lose the root of their number in half units of
    the last place, some ten; with compensation the error is the rounding of the last step alone."""
    times = np.arange(1, 9) * 125.0
    found = method().prepare(problem(form, len(start), times), 1e-13)(np.array([start]))
    assert (found.steps or 0) > 500
    assert np.max(np.abs(found.states[0, :, 0] - (1 + DRIFT * times))) <= 3 * 2.0**-52


def growing(t: float, state: Values, parameters: Values) -> Values:
    return state


@pytest.mark.parametrize("method", [Dop853, BogackiShampine3])
def test_a_motion_that_grows_is_measured_by_the_size_that_it_has(method: type[Integrator]) -> None:
    """y' = y does not depend on size: as many steps from 1 to e^20 as from e^20 to e^40."""
    once, twice = (
        method().prepare(problem(FirstOrder(growing), 1, [span]), 1e-8)(np.ones((1, 1))) for span in (20.0, 40.0)
    )
    assert twice.steps == pytest.approx(2 * (once.steps or 0), rel=0.1)
    assert twice.states[0, 0, 0] == pytest.approx(math.exp(40.0), rel=1e-6)


def shrinking(t: float, state: Values, parameters: Values) -> Values:
    x, v = state
    return v, -x / 16 - v / 4


@pytest.mark.parametrize("method", [Dop853, DormandPrince5, GraggBulirschStoer])
def test_a_motion_that_shrinks_is_measured_by_the_size_that_it_had(method: type[Integrator]) -> None:
    """At e^-25 of its size it is far below the tolerance: for 100 s more only stability limits the steps."""
    solve = method().prepare(problem(FirstOrder(shrinking), 2, [200.0, 300.0]), 1e-8)
    first = method().prepare(problem(FirstOrder(shrinking), 2, [200.0]), 1e-8)
    start = np.array([[1.0, 0.0]])
    more, steps = solve(start).steps, first(start).steps
    assert more is not None
    assert steps is not None
    assert more - steps <= 35, "of 0.25 / s, in steps of at least 0.75 / 0.25 s"


def test_the_absolute_rule_takes_the_larger_of_both_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    inverse = np.array([0.125])
    for a, b in ((3.0, -7.0), (-7.0, 3.0)):
        assert sizes.one_over(0, np.array([a]), np.array([b]), inverse) == 0.125
    monkeypatch.setattr(sizes, "ABSOLUTE", 1)
    for a, b in ((3.0, -7.0), (-7.0, 3.0)):
        assert sizes.one_over(0, np.array([a]), np.array([b]), inverse) == 0.125
        assert sizes.one_over(0, np.array([a / 7]), np.array([b / 7]), inverse) == 0.5


def free(t: float, state: Values, parameters: Values) -> Values:
    x, v = state
    return v, 0 * x


def moving(t: float, state: Values, parameters: Values) -> str:
    return "free"


FREE = Hybrid(modes=(Mode("free", free),), start=moving, transitions=(), settle=1e-9)


@pytest.mark.parametrize("method", [DormandPrince5, Dop853Events])
def test_a_step_without_error_is_followed_by_one_six_times_as_long(method: type[Integrator]) -> None:
    """More could miss the motion that follows; less would take many short steps. So the steps are a geometric series."""
    form = FREE if method is Dop853Events else FirstOrder(free)
    start = np.array([[1.0, 1.0]])
    counts = []
    for span in (1e4, 1e4 * 6**3, 1e4 * 6**6):
        found = method().prepare(problem(form, 2, [span]), 1e-4)(start)
        assert found.states[0, 0, 0] == pytest.approx(1 + span, rel=1e-15)
        counts.append(found.steps)
    assert GROW_MOST == 6
    assert np.diff(np.array(counts)).tolist() == [3, 3]


def attracted(t: float, state: Values, parameters: Values) -> Values:
    x, y, u, v = state
    r3 = (x * x + y * y) ** 1.5
    return u, v, -x / r3, -y / r3


ORBIT = Hybrid(modes=(Mode("free", attracted),), start=moving, transitions=(), settle=1e-9)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
def test_steps_between_events_are_those_of_dop853(tolerance: float) -> None:
    """Ten orbits of e = 0.5 without an event: the same formulas, another controller, at most a fifth more work."""
    start, work = np.array([[0.5, 0.0, 0.0, math.sqrt(3.0)]]), []
    for method, form in ((Dop853, FirstOrder(attracted)), (Dop853Events, ORBIT)):
        counted = problem(form, 4, [62.5], counted=True, groups=(0, 0, 1, 1))
        found = method().prepare(counted, tolerance)(start)
        assert found.stopped is None
        work.append(counted.buffer[-1])
    assert 0.8 < work[1] / work[0] < 1.25


@pytest.mark.parametrize("method", [Dop853, DormandPrinceNystrom6, GraggBulirschStoer])
@pytest.mark.parametrize("speed", [1e-4, 1.0, 1e4])
def test_the_first_step_needs_no_search(method: type[Integrator], speed: float) -> None:
    """An oscillator of any frequency, from rest: a tenth of a radian takes some three to five steps."""
    form = {FirstOrder: FirstOrder(oscillating), SecondOrder: SecondOrder(restoring)}[method.accepts[0]]
    counted = Problem(form, 2, np.array([speed]), np.array([0.1 / speed]), 1 / speed, counted=True)
    found = method().prepare(counted, 1e-8)(np.array([[1.0, 0.0]]))
    assert found.steps is not None
    assert found.steps <= 6
    assert counted.buffer[-1] <= 80
    assert found.states[0, 0, 0] == pytest.approx(math.cos(0.1), abs=1e-7)


def oscillating(t: float, state: Values, parameters: Values) -> Values:
    x, v = state
    (speed,) = parameters
    return v, -speed * speed * x


def restoring(t: float, q: Values, parameters: Values) -> Values:
    (speed,) = parameters
    return (-speed * speed * q[0],)


@pytest.mark.parametrize("most", [1.0, 1e4, 1e8])
def test_the_pericentre_of_a_long_ellipse_sets_the_first_step(most: float) -> None:
    """e = 0.99 from pericentre, where the motion turns within about sqrt(r^3 / mu) / 2: a thousandth of a radian of the whole
    period, for any span and time scale, in a millionth of which there may be many periods."""
    groups, r = np.array([0, 0, 1, 1]), 0.01
    y = np.array([r, 0.0, 0.0, math.sqrt(1.99 / r)])

    def rates(y: np.ndarray) -> np.ndarray:
        return np.array(attracted(0.0, tuple(y), ()))

    h = sizes.trial_step(y, rates(y), groups, most)
    found = sizes.turning_time(y, rates(y), rates(y + h * rates(y)), h, groups, most)
    assert 0.3 * r**1.5 < found < 3 * r**1.5


@pytest.mark.parametrize("most", [10.0, 1e4, 1e8])
def test_the_trial_step_is_short_beside_the_motion(most: float) -> None:
    """y' = y^2 from 1, where y'' = 2: it leaves its tangent in the time 1, for any time scale. Over a trial step of 100 the
    rate grows a hundred times as fast."""
    groups, y = np.zeros(1, dtype=np.int64), np.ones(1)
    h = sizes.trial_step(y, y**2, groups, most)
    assert sizes.turning_time(y, y**2, (y + h * y**2) ** 2, h, groups, most) == pytest.approx(1.0, rel=0.01)


@pytest.mark.parametrize("most", [10.0, 1e6])
@pytest.mark.parametrize("speed", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("second_order", [False, True])
def test_the_first_step_is_a_part_of_the_time_in_which_the_motion_turns(
    second_order: bool, speed: float, most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """That of an oscillator from rest is a radian, however long the span: an error of order 8 is then a hundredth of the
    tolerance."""
    monkeypatch.setattr(step_control, "ORDER", 8)

    width, y, tolerance = 1 if second_order else 2, np.array([1.0, 0.0]), 1e-8
    f = restoring if second_order else oscillating
    s = StepData(f, y, np.array([speed]), None, np.empty(width), np.empty(width), None, None)
    found = step_control.first_step(s, np.empty((1, width)), tolerance, most / speed, np.array([0, 1]))
    assert found == pytest.approx((0.01 * tolerance) ** (1 / 8) / speed, rel=0.01)

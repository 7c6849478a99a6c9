"""A verification ends early only for a known cause, and what it did not check is never a pass."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import planted_methods
import pytest
from command_line import gnomon
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Floats, Integrator, Steps, TooManyCalls
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import CALLS, Trials
from gnomon.harness.verification.claims import DEPTHS, Finding, Outcome, not_checked, pass_claim
from gnomon.harness.verification.verify import ACCURACY, CLAIMS, FOLLOWS, Report, Row, verify

from gnomon.verify import Refused, Tolerance, from_solve, from_step


def checked(claim: str, integrator: Integrator, case: str = "pendulum_simple") -> Finding:
    return CLAIMS[claim].check(Trials.of(integrator, CaseSpec.of(get(case).rounded()), DEPTHS["low"]))


def heun(weight: float) -> Integrator:
    """Heun's pair of order 2 with Euler's method; its estimate is right with the weight -1, and with 1 of the size of h."""

    def solve(f: Any, t0: float, y0: Floats, times: Floats, tolerance: float) -> Any:
        found, t, y, h = [], t0, y0, 1e-2
        for end in times:
            while t < end:
                step = min(h, end - t)
                a = f(t, y)
                b = f(t + step, y + step * a)
                error = np.max(np.abs(step / 2 * (b + weight * a))) / tolerance
                if error <= 1:
                    t, y = end if step == end - t else t + step, y + step / 2 * (a + b)
                h = step * min(4.0, max(0.2, 0.9 * max(error, 1e-10) ** -0.5))
            found.append(y)
        return np.array(found)

    return from_solve(solve, name=f"Heun {weight:g}", order=2, sweep=Tolerance(1e-2, 1e-4))


def test_a_solution_that_takes_many_times_the_calls_of_a_right_one_is_given_up() -> None:
    """Steps that collapse would take minutes at each setting; the count of calls is the same on every machine."""
    trials = Trials.of(heun(1.0), CaseSpec.of(get("pendulum_simple").rounded()), DEPTHS["low"])
    problem = trials.limited(trials.problem(), 1e-4)
    with pytest.raises(TooManyCalls, match="right-hand sides in one solution"):
        trials.solutions(trials.problem(), 1e-4, [trials.start])
    ((_, calls),) = Trials.of(heun(-1.0), CaseSpec.of(trials.case), DEPTHS["low"]).solved(problem, 1e-4, [trials.start])
    assert calls < problem.most_calls / (CALLS / 3), "a right pair is far below the limit"


def test_a_known_cause_ends_the_run_and_the_rest_is_not_checked() -> None:
    report = verify(heun(1.0), ["pendulum_simple", "kepler_orbit"], "low", ["runs", "order", "repeatable"], workers=1)
    assert report.diagnosis is not None
    assert report.diagnosis.startswith("work: it needs more than")
    assert [row.claim for row in report.of(Outcome.FAILED)] == ["runs"]
    assert {row.case for row in report.of(Outcome.NOT_CHECKED)} == {"pendulum_simple", "kepler_orbit"}


def test_all_claims_are_verified_after_a_failure_if_all_are_asked_for() -> None:
    claims = ["step_order", "repeatable"]
    few, every = (
        verify(planted_methods.signed, ["pendulum_simple", "kepler_orbit"], "low", claims, workers=1, every=every)
        for every in (False, True)
    )
    assert {row.case for row in few.of(Outcome.NOT_CHECKED)} == {"kepler_orbit"}
    assert every.of(Outcome.NOT_CHECKED) == []
    assert few.diagnosis is not None


def test_no_time_is_no_pass(capsys: pytest.CaptureFixture[str]) -> None:
    named = ("verify", "planted_methods:good_rk4", "--depth", "low", "--case", "pendulum_simple")
    assert gnomon(*named, "--max-seconds", "1e-6") == 2
    shown = capsys.readouterr().out
    assert "not verified: pendulum_simple: follows was not checked: the time of --max-seconds is over" in shown


def test_a_case_is_verified_if_it_is_followed_and_its_accuracy_was_checked() -> None:
    """Units, mirror and history hold for zeros too."""
    follows, order = (Row(claim, "pendulum_simple", pass_claim("")) for claim in (FOLLOWS, ACCURACY[0]))
    others = [Row(claim, "pendulum_simple", pass_claim("")) for claim in ("units", "mirror", "history")]
    late = Row(FOLLOWS, "pendulum_simple", not_checked("no time"))
    for rows, complete in (([follows, order], True), ([follows], False), ([order], False), ([late, order], False)):
        assert (Report("mine:mine", "low", [*rows, *others]).gaps() == []) is complete


def leapfrog(length: Any) -> Integrator:
    """Each step from sample to sample has `length` of the distance in time."""

    def solve(f: Any, t0: float, y0: Floats, times: Floats, step: float) -> Any:
        found, y = [], np.array(y0)
        for begin, end in pairwise([t0, *times]):
            count = max(1, math.ceil(abs(end - begin) / step - 1e-9))
            h = length(end - begin) / count
            for _ in range(count):
                q, v = np.split(y, 2)
                v = v + h / 2 * f(begin, q)
                q = q + h * v
                y = np.concatenate([q, v + h / 2 * f(begin, q)])
            found.append(y)
        return np.array(found)

    return from_solve(solve, name="leapfrog", order=2, accelerations=True, sweep=Steps(0.125, 8))


def test_a_step_without_its_sign_goes_forward_where_times_fall() -> None:
    assert checked("backward", leapfrog(float)).outcome == Outcome.PASSED
    assert checked("backward", leapfrog(abs)).outcome == Outcome.FAILED
    unsigned = from_step(
        lambda f, t, y, h: planted_methods.good_rk4.function(f, t, y, abs(h)), name="unsigned", order=4
    )
    assert checked("backward", unsigned).outcome == Outcome.FAILED
    rk4 = planted_methods.good_rk4.function

    def solve(f: Any, t0: float, y0: Floats, times: Floats, step: float) -> Any:
        found, y = [], y0
        for begin, end in pairwise([t0, *(t0 + abs(times - t0))]):  # it asks for no derivative at an earlier time
            count = max(1, math.ceil((end - begin) / step - 1e-9))
            for k in range(count):
                y = rk4(f, begin + k * (end - begin) / count, y, (end - begin) / count)
            found.append(y)
        return np.array(found)

    distances = from_solve(solve, name="distances", order=4, sweep=Steps(0.125, 8))
    assert checked("backward", distances).outcome == Outcome.FAILED
    assert checked("backward", planted_methods.good_rk4).outcome == Outcome.PASSED


def test_a_solver_for_rising_times_is_not_blamed() -> None:
    """It returns its start at each earlier time: no step, and no derivative, is asked for there."""
    assert checked("backward", heun(-1.0)).outcome == Outcome.NOT_APPLICABLE


def test_steps_that_are_declined_as_too_long_are_no_history() -> None:
    def step(f: Any, t: float, y: Floats, h: float) -> Any:
        if h > 0.05:
            raise Refused("Newton's iteration does not converge")
        return planted_methods.good_rk4.function(f, t, y, h)

    mine = from_step(step, name="declines", order=4, sweep=Steps(0.25, 6))
    assert checked("history", mine).outcome == Outcome.PASSED

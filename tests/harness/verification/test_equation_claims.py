"""Faults that only other equations, the arrays that were given, or a fitted slope show, and right methods beside each."""

import inspect
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import right_methods
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator, Solution, Steps, Tolerance
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.registry.lookup import find_one
from gnomon.harness.verification.claims import DEPTHS, Outcome
from gnomon.harness.verification.function_adapter import from_solve, from_step
from gnomon.harness.verification.verify import CLAIMS, plan_verification
from planted_methods import good_pair, good_rk4, good_verlet
from planted_steps import increment
from special_adapters import from_events

rk4 = right_methods.rk4


def outcome(claim: str, integrator: Integrator, name: str = "pendulum_simple") -> Outcome:
    return CLAIMS[claim].check(Trials.of(integrator, CaseSpec.of(get(name).rounded()), DEPTHS["low"])).outcome


def changed(name: str, *changes: tuple[str, str]) -> Callable[..., Any]:
    """A function of right_methods.py with other text in some places."""
    text = inspect.getsource(getattr(right_methods, name))
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    names = dict(vars(right_methods))
    exec(text, names)
    return names[name]  # type: ignore[no-any-return]


def pair(*changes: tuple[str, str], name: str = "dormand_prince", order: int = 5) -> Integrator:
    dense = 4 if name == "dormand_prince" else None
    function = changed(name, *changes)
    return from_solve(function, name=name, order=order, dense_order=dense, sweep=Tolerance(1e-4, 1e-12))


def in_place(f: Any, t: float, y: Any, h: float) -> Any:
    y += rk4(f, t, y, h) - y
    return y


def kept_if_not_finite(f: Any, t: float, y: Any, h: float) -> Any:
    new = rk4(f, t, y, h)
    return new if np.all(np.isfinite(new)) else y


def clipped(f: Any, t: float, y: Any, h: float) -> Any:
    return np.clip(rk4(f, t, y, h), -1e12, 1e12)


SLOPES: dict[Any, Any] = {}


def slopes_kept(f: Any, t: float, y: Any, h: float) -> Any:
    """The slope at a step's start from a table: right as long as there is one problem."""
    key = (t, y.tobytes())
    if key not in SLOPES:
        SLOPES[key] = f(t, y)
    first = SLOPES[key]
    return rk4(lambda s, z: first if s == t and z is y else f(s, z), t, y, h)


LAST: dict[str, Any] = {}


def last_slope_kept(f: Any, t: float, y: Any, h: float) -> Any:
    """First same as last, over the end of a problem too."""
    first = LAST["slope"] if LAST.get("at") == (t + 0.0, y.tobytes()) else f(t, y)
    new = rk4(lambda s, z: first if s == t and z is y else f(s, z), t, y, h)
    LAST.update(slope=f(t + h, new), at=(t + h, new.tobytes()))
    return new


class OneProblem(Integrator):
    """RK4 that solves the problem that was prepared last."""

    name, library, order, accepts, sweep = "one problem", "planted", 4, good_rk4.accepts, good_rk4.sweep
    solve: Any = None

    def prepare(self, problem: Any, setting: float) -> Any:
        self.solve = good_rk4.prepare(problem, setting)
        return lambda starts: self.solve(starts)


class ChangesTimes(OneProblem):
    def prepare(self, problem: Any, setting: float) -> Any:
        solve = good_rk4.prepare(replace(problem, times=problem.times.copy()), setting)

        def again(starts: Any) -> Solution:
            problem.times[:] = 0
            return solve(starts)

        return again


def six_by_rk4(f: Any, t: float, y: Any, h: float) -> Any:
    """Euler's method from the seventh variable on."""
    return np.append(rk4(f, t, y, h)[:6], (y + h * f(t, y))[6:])


def summed(sign: float) -> Callable[..., Any]:
    """RK4 whose sums have a compensation of this sign."""

    def solve(f: Any, t0: float, y0: Any, times: Any, step: float) -> Any:
        count = round((times[-1] - t0) / step)
        y, lost, found = y0, np.zeros_like(y0), []
        for k in range(count):
            change = increment(f, t0 + k * step, y, step) + sign * lost
            new = y + change
            lost = change - (new - y)
            y = new
            if (k + 1) % (count // len(times)) == 0:
                found.append(y)
        return np.array(found)

    return solve


def compensated(sign: float) -> Integrator:
    method = from_solve(summed(sign), name="RK4", order=4, sweep=Steps(0.25, 8))
    type(method).compensated = True
    return method


INTERPOLANTS = {
    2: "def between(f, t, y, h, x):\n    return y + x * f(t, y) + (x / h)**2 * (rk4(f, t, y, h) - y - h * f(t, y))\n",
    3: "def between(f, t, y, h, x):\n    s, z = x / h, rk4(f, t, y, h)\n"
    "    return (1 - s) * y + s * z + s * (s - 1) * ((1 - 2 * s) * (z - y) + (s - 1) * h * f(t, y) + s * h * f(t + h, z))\n",
}


def events_between(degree: int) -> Integrator:
    """RK4 that locates events on an interpolant of this degree over the step."""
    before = "event.guard(t + x, tuple(rk4(f, t, y, x)), p)"
    after = "event.guard(t + x, tuple(between(f, t, y, end - t, x)), p)"
    function = changed("rk4_events", (before, after))
    exec(INTERPOLANTS[degree], function.__globals__)
    return from_events(function, name="RK4", library="planted", order=4, sweep=Steps(0.25, 10))


SHORTEST = (
    ("if error <= 1:", "if error <= 1 or h <= 1e-9:"),
    ("h = h * min(", "h = max(1e-9, h * min("),
    ("** -0.2))", "** -0.2)))"),
    ("not np.isfinite(error) or h < 1e-15 * max(abs(t), 1e-300)", "False"),
)
"""No step is shorter, and the shortest is accepted with any error."""


@pytest.mark.parametrize(
    ("claim", "method"),
    [
        ("start_kept", from_step(in_place, name="in place", order=4)),
        ("start_kept", ChangesTimes()),
        ("tolerance_effect", pair(("t, y, h =", "tolerance = 1e-9\n    t, y, h ="))),
        ("blow_up", from_step(kept_if_not_finite, name="kept", order=4)),
        ("blow_up", from_step(clipped, name="clipped", order=4)),
        ("blow_up", pair(*SHORTEST)),
        ("other_problems", from_step(slopes_kept, name="slopes kept", order=4)),
        ("other_problems", from_step(last_slope_kept, name="last slope kept", order=4)),
        ("other_problems", OneProblem()),
        ("more_variables", from_step(six_by_rk4, name="six", order=4)),
        ("more_variables", pair(("error = np.linalg.norm(h * sum(", "error = np.linalg.norm((h * sum("),
                                ("strict=True))) / norm(y", "strict=True)))[:6]) / norm(y"))),
        ("compensated", compensated(-1.0)),
        ("compensated", compensated(0.0)),
        ("dense", pair(("(r3 + (1 - x) * r4)", "r3"))),
    ],
)  # fmt: skip
def test_a_fault_fails_the_claim_that_it_is_about(claim: str, method: Integrator) -> None:
    assert outcome(claim, method) == Outcome.FAILED


CALLS = ("start_kept", "other_problems", "more_variables", "blow_up")


@pytest.mark.parametrize("method", [good_rk4, good_verlet, good_pair, pair(), find_one("gnomon:Gauss 2-stage")])
def test_right_methods_keep_these_claims(method: Integrator) -> None:
    adaptive = isinstance(method.sweep, Tolerance)
    for claim in (*CALLS, *(("tolerance_effect",) if adaptive else ()), *(("dense",) if method.dense_order else ())):
        assert outcome(claim, method) == Outcome.PASSED, claim


def test_compensated_sums_are_right_to_two_roundings() -> None:
    assert outcome("compensated", compensated(1.0)) == Outcome.PASSED
    assert outcome("compensated", find_one("gnomon:Störmer 12")) == Outcome.PASSED
    assert outcome("compensated", good_rk4) == Outcome.NOT_APPLICABLE


def test_a_method_that_damps_fast_growth_may_go_over_a_pole() -> None:
    """One step of Rosenbrock and Euler: with a Jacobian J, (1 - h J) k = f, whose factor tends to 0 for growth that is fast."""

    def step(f: Any, t: float, y: Any, h: float) -> Any:
        near, size = f(t, y), 1e-7 * np.maximum(np.abs(y), 1e-3)
        jacobian = np.array([(f(t, y + d) - near) / d.sum() for d in np.diag(size)]).T
        if not np.all(np.isfinite(jacobian)):
            return np.full_like(y, np.nan)
        return y + h * np.linalg.solve(np.eye(len(y)) - h * jacobian, near)

    method = from_step(step, name="linearly implicit", order=1)
    trials = Trials.of(method, CaseSpec.of(get("pendulum_simple").rounded()), DEPTHS["low"])
    assert CLAIMS["blow_up"].check(trials).outcome == Outcome.PASSED


def test_a_solver_that_goes_on_for_ever_near_a_singularity_is_stopped() -> None:
    """It has no finite states there; its process, which may run a user's tests, does not wait for ever."""
    endless = pair(("if not np.isfinite(error) or h < 1e-15 * max(abs(t), 1e-300):", "if False:"))
    assert outcome("blow_up", endless) == Outcome.PASSED


@pytest.mark.parametrize(("time", "expected"), [("h / 2", Outcome.PASSED), ("h / 2 * (1 - 1e-10)", Outcome.FAILED)])
def test_the_time_of_a_stage_is_right_to_ten_digits_in_a_method_with_a_structure(time: str, expected: Outcome) -> None:
    """The error of the stage is a part of the method's own error, so that no order shows it; the area does."""
    step = changed("implicit_midpoint", ("better = y + h / 2 * f(t + h / 2,", f"better = y + h / 2 * f(t + {time},"))
    method = from_step(step, name=time, order=2, conserves=("symplectic", "reversible"), sweep=Steps(0.125, 8))
    assert outcome("time_structure", method) == expected


def test_low_has_an_event_whose_guard_depends_on_the_time() -> None:
    """Elsewhere the time of the guard shows in no result."""
    chosen = plan_verification(find_one("gnomon:RK4 [events]"), None, "low")
    assert not all(case.autonomous for case, _ in chosen)


def test_events_are_located_to_the_order_declared() -> None:
    """The errors of an event on a parabola fall as h^3, but not from each step to its half: its place in a step changes."""
    case = "coulomb_friction_oscillator"
    assert outcome("event_order", events_between(2), case) == Outcome.FAILED
    assert outcome("event_order", events_between(3), case) == Outcome.PASSED
    assert outcome("event_order", find_one("gnomon:RK4 [events]"), case) == Outcome.PASSED


def test_times_of_events_that_are_not_well_defined_are_not_fitted() -> None:
    """Sliding turns into rolling where the guard hardly changes: the time is known less well than the states."""
    assert outcome("event_order", find_one("gnomon:RK4 [events]"), "billiard_ball") == Outcome.PASSED


def test_claims_with_equations_of_their_own_are_made_once() -> None:
    made = [claim for _, claims in plan_verification(good_rk4, None, "low") for claim in claims]
    assert all(made.count(name) == 1 for name, claim in CLAIMS.items() if claim.once)
    assert any(claim.once for claim in CLAIMS.values())

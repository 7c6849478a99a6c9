"""Claims of conduct: the same bits again, no dependence on earlier calls, bad input."""

from __future__ import annotations

import math

import numpy as np
from gnomon.harness.contract import validation
from gnomon.harness.contract.integrator import Refused, solver_of
from gnomon.harness.verification.claims import Finding, claim, failed, passed
from gnomon.harness.verification.convergence_claims import same_solution
from gnomon.harness.verification.trials import Floats, Trials

FAR = 2.0**-10
"""Relative distance of another start: its solution differs in most bits."""
IMPOSSIBLE = (0.0, -1e-3, math.nan)
"""Settings that are no step size and no tolerance."""


def _other(trials: Trials) -> Floats:
    other: Floats = trials.start * (1 - FAR) + FAR * trials.reference.exact[0]
    return other


@claim("repeatable")
def _repeatable(trials: Trials) -> Finding:
    first, second = (trials.solutions(trials.problem(), trials.usual(), [trials.start])[0] for _ in range(2))
    return _same(trials, first, second, "two preparations from one start")


@claim("history")
def _history(trials: Trials) -> Finding:
    """A solution before and after solutions from another start and at another setting."""
    setting = trials.usual()
    first, _, again = trials.solutions(trials.problem(), setting, [trials.start, _other(trials), trials.start])
    found = _same(trials, first, again, "one start before and after another")
    if found.expected:
        return found
    trials.solutions(trials.problem(), trials.settings[0], [_other(trials)])
    (fresh,) = trials.solutions(trials.problem(), setting, [trials.start])
    return _same(trials, first, fresh, "one start before and after another setting")


@claim("aliasing")
def _aliased(trials: Trials) -> Finding:
    """States that were returned must not change with the next call."""
    problem = trials.problem()
    solve = solver_of(trials.integrator, problem, trials.usual())
    returned = solve(trials.start[None].copy()).states
    kept = np.array(returned)
    solve(_other(trials)[None].copy())
    return _same(trials, kept[0], np.asarray(returned)[0], "states returned by an earlier call")


def _smooth(trials: Trials) -> str | None:
    return None if trials.case.hybrid is None else "two starts of a motion with events may have other events"


@claim("ensemble", _smooth)
def _ensemble(trials: Trials) -> Finding:
    """The solution of a start is that of the start alone, whichever others are solved in the same call."""
    problem, setting = trials.problem(), trials.usual()
    starts = np.array([_other(trials), trials.start])
    solve = solver_of(trials.integrator, problem, setting)
    together = validation.checked(solve(starts.copy()), (2, len(problem.times), problem.dimension)).states[1]
    return same_solution(trials, together, "the second of two starts")


def _same(trials: Trials, first: Floats, second: Floats, what: str) -> Finding:
    if np.array_equal(first, second, equal_nan=True):
        return passed()
    different = int(np.argmax(np.any(first != second, axis=1)))
    apart = float(np.max(trials.distance(second, first)))
    return failed(
        trials.named(trials.usual()), f"the same bits: {what}", f"{apart:.2g} apart, first at sample {different + 1}"
    )


def _answers(trials: Trials) -> str | None:
    """An integrator that has no solution at all says nothing by having none for bad input."""
    answer = trials.whole(trials.usual())
    return None if answer.states is not None else f"no solution at {trials.named(answer.setting)}: {answer.why}"


@claim("bad_start", _answers)
def _bad_start(trials: Trials) -> Finding:
    for value in (math.nan, math.inf):
        try:  # at the cheapest setting: an implicit method makes all its iterations in every step
            (states,) = trials.solutions(trials.problem(), trials.settings[0], [np.full_like(trials.start, value)])
        except Exception:  # an exception says that there is no solution
            continue
        if np.all(np.isfinite(states)):
            return failed(f"start {value}", "no finite states", "finite states")
    return passed()


@claim("bad_setting", _answers)
def _bad_setting(trials: Trials) -> Finding:
    for setting in IMPOSSIBLE:
        kind = "step size" if trials.steps else "tolerance"
        try:
            solve = solver_of(trials.integrator, trials.problem(), setting)
            solution = solve(trials.start[None].copy())
        except Refused:
            continue
        except Exception:  # an exception is no answer either
            continue
        if solution.stopped is None and np.all(np.isfinite(solution.states)):
            return failed(f"{kind} {setting:g}", "refused, or no finite states", "finite states")
    return passed()

"""Claims about calls: equal bits when repeated, no effect of earlier calls, arguments left unchanged, bad input."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.measuring.trials import Floats, Trials
from gnomon.harness.verification.claims import Finding, claim, fail_claim, not_applicable, pass_claim
from gnomon.harness.verification.convergence_claims import same_solution

FAR = 2.0**-10
"""Relative distance of another start, so large that its solution differs in most bits."""
DIFFERENCES, POLYNOMIAL = 8, 1e-10
"""Order and bound of differences of the samples: below the bound the motion is a polynomial of lower degree."""
IMPOSSIBLE = (0.0, -1e-3, math.nan)
"""Values that are neither a step size nor a tolerance."""


def _other(trials: Trials) -> Floats:
    other: Floats = trials.start * (1 - FAR) + FAR * trials.reference.exact[0]
    return other


@claim("repeatable")
def _repeatable(trials: Trials) -> Finding:
    first, second = (trials.solutions(trials.problem(), trials.usual(), [trials.start])[0] for _ in range(2))
    return same_bits(trials, first, second, "two preparations from one start")


@claim("history")
def _history(trials: Trials) -> Finding:
    """The solution from one start, before and after solutions from another start and at another setting."""
    setting = trials.usual()
    first, _, again = trials.solutions(trials.problem(), setting, [trials.start, _other(trials), trials.start])
    finding = same_bits(trials, first, again, "one start before and after another")
    if finding.expected:
        return finding
    with suppress(Refused):  # stages need not converge at the coarsest setting
        trials.solutions(trials.problem(), trials.settings[0], [_other(trials)])
    (fresh,) = trials.solutions(trials.problem(), setting, [trials.start])
    return same_bits(trials, first, fresh, "one start before and after another setting")


@claim("start_kept")
def _start_kept(trials: Trials) -> Finding:
    """The arrays given to the integrator hold the same bits after the call."""
    problem, start = trials.problem(), trials.start[None].copy()
    with trials.prepared(problem, trials.usual()) as solver:
        solver.given(start)
    before = trials.problem()
    pairs = {"initial states": (trials.start, start[0]), "times": (before.times, problem.times)}
    pairs["parameters"] = (before.parameters, problem.parameters)
    for what, (right, left) in pairs.items():
        if not np.array_equal(right, left, equal_nan=True):
            apart = float(np.max(np.abs(right - left)))
            return fail_claim(
                trials.named(trials.usual()), f"the same {what} after the call", f"changed by {apart:.2g}"
            )
    return pass_claim()


@claim("aliasing")
def _check_aliasing(trials: Trials) -> Finding:
    """States returned by an earlier call must not change with the next call."""
    problem = trials.problem()
    with trials.prepared(problem, trials.usual()) as solver:
        returned = solver.solver(trials.start[None].copy()).states  # the array itself, which `solver` would copy
        copy = np.array(returned)
        solver(_other(trials)[None])
    return same_bits(trials, copy[0], np.asarray(returned)[0], "states returned by an earlier call")


def _smooth(trials: Trials) -> str | None:
    return None if trials.case.hybrid is None else "two starts of a motion with events may have other events"


@claim("ensemble", _smooth)
def _ensemble(trials: Trials) -> Finding:
    """The solution from a start must not depend on the other starts in the same call."""
    problem, setting = trials.problem(), trials.usual()
    starts = np.array([_other(trials), trials.start])
    with trials.prepared(problem, setting) as solver:
        together = solver(starts).states[1]
    return same_solution(trials, together, "the second of two starts")


def same_bits(trials: Trials, first: Floats, second: Floats, what: str) -> Finding:
    if np.array_equal(first, second, equal_nan=True):
        return pass_claim()
    different = int(np.argmax(np.any(first != second, axis=1)))
    apart = float(np.max(trials.distance(second, first)))
    return fail_claim(
        trials.named(trials.usual()), f"the same bits: {what}", f"{apart:.2g} apart, first at sample {different + 1}"
    )


def answers(trials: Trials) -> str | None:
    """Claims about bad input apply only if there is a solution for good input."""
    answer = trials.whole(trials.usual())
    return None if answer.states is not None else f"no solution at {trials.named(answer.setting)}: {answer.why}"


def _tolerance(trials: Trials) -> str | None:
    if trials.steps:
        return "its setting is a step size"
    if trials.case.hybrid is not None:
        return "between events a motion may be a polynomial, which is exact at any tolerance"
    return answers(trials)


@claim("tolerance_effect", _tolerance)
def _tolerance_effect(trials: Trials) -> Finding:
    """The states at the loosest and the tightest tolerance must differ.

    If every step ends at a sample, equal states are compared again with the end of the span as the only sample.
    """
    solved = [answer for answer in trials.answers() if not answer.declined]
    if len(solved) < 2:
        return not_applicable("fewer than two tolerances have a solution")
    loose, tight = solved[0], solved[-1]
    assert loose.states is not None
    assert tight.states is not None
    if not np.array_equal(loose.states, tight.states):
        return pass_claim()
    if np.max(np.abs(np.diff(trials.reference.exact / trials.reference.sizes, DIFFERENCES, axis=0))) < POLYNOMIAL:
        return not_applicable("the motion is a polynomial, which may be exact at any tolerance")
    last = replace(trials.problem(), times=trials.problem().times[-1:])
    first, second = (trials.solutions(last, answer.setting, [trials.start])[0] for answer in (loose, tight))
    if not np.array_equal(first, second):
        return pass_claim()
    return fail_claim(f"tolerances {loose.setting:g} and {tight.setting:g}", "states that differ", "the same bits")


@claim("bad_start", answers)
def _bad_start(trials: Trials) -> Finding:
    for value in (math.nan, math.inf):
        # At the cheapest setting: for bad states an implicit method makes all its iterations in every step.
        outcome = trials.outcome(trials.problem(), trials.settings[0], np.full_like(trials.start, value))
        if outcome.solution is not None and np.all(np.isfinite(outcome.states)):
            return fail_claim(f"start {value}", "no finite states", "finite states")
    return pass_claim()


@claim("bad_setting", answers)
def _bad_setting(trials: Trials) -> Finding:
    for setting in IMPOSSIBLE:
        kind = "step size" if trials.steps else "tolerance"
        solution = trials.outcome(trials.problem(), setting, trials.start).solution
        if solution is not None and solution.stopped is None and np.all(np.isfinite(solution.states)):
            return fail_claim(f"{kind} {setting:g}", "refused, or no finite states", "finite states")
    return pass_claim()

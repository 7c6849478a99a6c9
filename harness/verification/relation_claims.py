"""Claims that relate two solutions: turned starts, another clock, samples between the steps."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from gnomon.cases.core.clock import from_start
from gnomon.harness.results.convergence_order import ABOVE_FLOOR_ON_A_LINE, FEWEST, LARGEST_ERROR
from gnomon.harness.verification.claims import Finding, claim, failed, not_applicable, passed
from gnomon.harness.verification.convergence_claims import MARGIN, SHORT, TIGHT, allowed_error, same_solution
from gnomon.harness.verification.trials import Answer, Trials

TURNED = 3
"""Turned starts that are solved."""
CLOCKS = 4.0
"""The later clock has a larger unit in the last place, by which the times of stages are rounded: up to four times that
of the clock from 0, with an effect that the conditioning counts as that of one rounding."""


def _has_turning(trials: Trials) -> str | None:
    if not len(trials.reference.turned):
        return "the case has no rotational symmetry"
    return "it declares no order" if trials.steps and trials.integrator.order is None else None


def _allowed(trials: Trials, answer: Answer) -> float:
    """The error that a setting may have from any start of the same kind of motion."""
    if not trials.steps:
        return allowed_error(trials, answer.setting, answer)
    order = trials.integrator.order
    assert order is not None
    usable = [a for a in trials.answers() if a.error < LARGEST_ERROR]
    line = max((max(a.error, a.roundoff) / a.setting**order for a in usable), default=math.inf)
    return float(line * (2 * answer.setting) ** order + ABOVE_FLOOR_ON_A_LINE * answer.roundoff)


@claim("turned", _has_turning)
def _turned(trials: Trials) -> Finding:
    """The errors from turned starts, at the tightest setting with an answer."""
    usable = [a for a in trials.answers() if not a.declined and a.error < LARGEST_ERROR]
    if not usable:
        return not_applicable(f"no setting with an error below {LARGEST_ERROR:g}")
    answer = usable[-1]
    allowed = _allowed(trials, answer)
    if not allowed < LARGEST_ERROR:
        return not_applicable(f"no setting whose error is bounded below {LARGEST_ERROR:g}")
    starts, exact = trials.reference.turned_starts[:TURNED], trials.reference.turned_exact
    solutions = trials.solutions(trials.problem(), answer.setting, list(starts))
    for number, (states, right) in enumerate(zip(solutions, exact, strict=False), 1):
        error = float(np.max(trials.distance(states, right)))
        if not error <= allowed:
            where = f"{trials.named(answer.setting)}, turned start {number}"
            return failed(
                where, f"error below {allowed:.2g}, as from the start itself ({answer.error:.2g})", f"{error:.2g}"
            )
    return passed()


def _smooth(trials: Trials) -> str | None:
    return None if trials.case.hybrid is None else "events at other times may change the motion"


@claim("clock", _smooth)
def _clock(trials: Trials) -> Finding:
    """The equations of a later clock, from a later start: the same motion."""
    problem = trials.problem()
    late = 2.0 ** math.ceil(math.log2(float(problem.times[-1])))
    times = problem.times + late
    if not np.array_equal(times - late, problem.times):
        return not_applicable("its sample times cannot be shifted exactly")
    names = None if problem.names is None else replace(problem.names, case=f"{problem.names.case} from t = {late:g}")
    shifted = replace(problem, form=from_start(problem.form, -late), times=times, t0=late, names=names)
    (states,) = trials.solutions(shifted, trials.usual(), [trials.start])
    return same_solution(trials, states, f"the motion by a clock that starts at {late:g}", CLOCKS)


def _dense_applies(trials: Trials) -> str | None:
    if trials.integrator.dense_order is None:
        return "it declares no order of its dense output (dense_order)"
    if trials.steps or trials.integrator.sampling != "dense output":
        return "its samples are no dense output of an adaptive method"
    return "events limit the order" if trials.case.hybrid is not None else None


@claim("dense", _dense_applies)
def _dense(trials: Trials) -> Finding:
    """The slope of the largest error of a sample over the mean length of a step, over a short span."""
    order, dense = trials.integrator.order, trials.integrator.dense_order
    assert dense is not None
    expected = min(order or dense + 1, dense + 1)
    points = []
    for answer in (trials.short(SHORT - 3, tolerance) for tolerance in trials.settings if tolerance <= TIGHT):
        if (
            answer.work
            and not answer.declined
            and ABOVE_FLOOR_ON_A_LINE * answer.roundoff < answer.error < LARGEST_ERROR
        ):
            points.append((1.0 / answer.work, answer.error))
    if len(points) < FEWEST or points[0][0] < 4 * points[-1][0]:
        return not_applicable(f"{len(points)} tolerances with errors above round-off and steps that differ by 4 times")
    h, errors = np.log(np.array(points)).T
    slope = float(np.polyfit(h, errors, 1)[0])
    if slope >= expected - MARGIN:
        return passed(f"{slope:.2f}")
    return failed(
        f"tolerances from {TIGHT:g} down", f"errors of samples proportional to h^{expected}", f"h^{slope:.2f}"
    )

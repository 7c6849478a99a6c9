"""The claim that always applies: over the span, or a part that is short enough, the states are near the exact motion."""

from __future__ import annotations

import math

import numpy as np
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.trials import HALF_ULP, SHORTEST, Trials
from gnomon.harness.results.convergence_order import ABOVE_FLOOR_ON_A_LINE
from gnomon.harness.verification.claims import Finding, claim, failed, not_applicable, not_checked, passed

NEAR = 0.01
"""Largest error, as a share of the distance that the exact motion covers in the part of the span. States that are one of
64 samples early or late are off by at least 1/64 of it."""
ORDER_1 = 2.0
"""The error constant of a method of order 1, in halves of h^2 y'': 1 for both methods of Euler, and a margin of 2."""
STEPS, FEWEST = 1e4, 64
"""Steps over the whole span, and over a part, whose errors may add up to the tolerance each."""


@claim("follows")
def _follows(trials: Trials) -> Finding:
    """The error at the finest setting that has a solution, over the longest part that a consistent method must follow."""
    answers = trials.answers()
    usable = [answer for answer in answers if not answer.declined]
    if not answers:
        return not_checked("its sweep has no setting that this depth allows")
    if not usable:
        last = answers[-1]
        if last.status == Status.UNSUPPORTED:
            return not_applicable(f"unsupported: {last.why}")
        return not_checked(f"no solution at {trials.named(last.setting)}: {last.why}")
    finest, longest = usable[-1].setting, _first_part(trials)
    for halvings in range(longest, SHORTEST):
        covered = distance_covered(trials, halvings)
        must = _largest_error(trials, halvings, finest) <= NEAR * covered
        answer = trials.short(halvings, _setting(trials, halvings, finest))
        if answer.declined:
            continue
        allowed = NEAR * covered + ABOVE_FLOOR_ON_A_LINE * answer.roundoff
        if answer.error <= allowed:
            return passed(f"{answer.error:.2g}")
        if must:
            part = f" over 1/{2**halvings} of the span" * (halvings > 0)
            expected = f"states within {allowed:.2g} of the exact motion, which covers {covered:.2g}"
            return failed(f"{trials.named(answer.setting)}{part}", expected, f"{answer.error:.2g}")
    return not_checked("no part of the span is so short that a method of order 1 must follow it")


def _setting(trials: Trials, halvings: int, finest: float) -> float:
    """The finest setting; a step is at most a sampling interval of the part."""
    return min(finest, float(trials.problem(halvings).interval)) if trials.steps else finest


def _first_part(trials: Trials) -> int:
    """The halvings of the longest part that counts: for an engine it ends before the first event, such as a contact."""
    if trials.case.hybrid is None or not isinstance(trials.form, SceneForm):
        return 0
    first = next((float(event.time) for event in trials.case.events()), math.inf)
    span = float(trials.reference.times[-1])
    return next((k for k in range(SHORTEST) if span * 2.0**-k < first), 0) if first > 0 else 0


def distance_covered(trials: Trials, halvings: int) -> float:
    """The largest distance of the exact motion from its start, in the metric; 1, its size, for a motion that rests."""
    exact = trials.exact(halvings)
    covered = float(np.max(trials.distance(exact, np.broadcast_to(trials.start, exact.shape))))
    return covered or 1.0


def _largest_error(trials: Trials, halvings: int, finest: float) -> float:
    """An upper bound of the error of any consistent method at a setting over the span divided by 2^halvings.

    With a step h each step of a method of order 1 leaves h^2/2 of the second derivative, whose integral the second
    differences of the samples give; with a tolerance each step leaves the tolerance. The motion carries each error to the
    end: at most by the conditioning over half an ulp, and a velocity by the time in time scales.
    """
    span = float(trials.reference.times[-1]) * 2.0**-halvings
    grown = max(1.0, trials.conditioning(halvings) / HALF_ULP) * (1 + span / trials.reference.time_scale)
    if not trials.steps:
        return max(STEPS * 2.0**-halvings, FEWEST) * math.sqrt(len(trials.start)) * finest * grown
    exact = np.concatenate([trials.start[None], trials.exact(halvings)])
    bends = trials.distance(2 * exact[1:-1] - exact[:-2], exact[2:])
    share = _setting(trials, halvings, finest) / float(trials.problem(halvings).interval)
    return ORDER_1 * 0.5 * share * float(np.sum(bends)) * grown

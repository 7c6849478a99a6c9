"""Claims about motions with events: each event is found at its time, and the error falls with the declared order."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from gnomon.cases.core.case import Event
from gnomon.harness.measuring.events import EventScore, score_events
from gnomon.harness.measuring.trials import HALF_ULP, SHORTEST, TIGHT, Answer, Trials
from gnomon.harness.results.convergence_order import FEWEST, LARGEST_ERROR
from gnomon.harness.verification.claims import Finding, claim, fail_claim, not_applicable, pass_claim
from gnomon.harness.verification.convergence_claims import (
    MARGIN,
    MOST_ON_A_LINE,
    Point,
    above_line,
    fit_slope,
    in_range,
    sum_allowed_errors,
)

WITHIN = 0.75
"""The first event is within this share of a short span, so that the motion after it counts."""
CLEAR = 1e-3
"""Least distance of an event from the end of a short span, in lengths of the span."""
LONGER = 7.0
"""Errors are compared with errors at steps at least 8 times as long. A method of half the order exceeds the bound
there; the constant of a right method changes by less."""
COARSE = 3
"""Least number of longer steps to compare with. Where events are located to the declared order only, the error depends
on the place of an event in its step, and may be small at one step size. Order 1 is left out: events may be anywhere in
their step."""
UNRELATED = 2.0
"""Largest distance of two states of the size of the motion. A larger bound of an error would allow any state."""
SHARES = tuple(k / 32 for k in range(25, 32))
"""Shares of the short span: solutions over these lengths are fitted with solutions over all of it."""
STEPS = 2**14
"""Largest number of steps over a short span."""


def _has_events(trials: Trials) -> str | None:
    return None if trials.case.hybrid is not None else "the case has no events"


@claim("events", _has_events)
def _events(trials: Trials) -> Finding:
    """The events, and their times, at the two most accurate settings over the whole span."""
    exact, span = trials.case.events(), float(trials.case.span)
    usable = [a for a in trials.answers() if a.events is not None and not a.declined]
    usable = [a for a in usable if a.error < LARGEST_ERROR and (trials.steps or a.setting <= TIGHT)]
    if not usable:
        return not_applicable("no accurate setting gives events")
    for answer in usable[-2:]:
        score, named = score_events(answer.events or (), exact), trials.named(answer.setting)
        if score.missing or score.extra:
            return _other_events(named, len(exact), score)
        allowed = answer.setting if trials.steps else sum_allowed_errors(trials, answer.setting, answer) * span
        if not score.time_error <= allowed + 2 * trials.conditioning() * span:
            return fail_claim(named, f"event times within {allowed:.2g} s", f"{score.time_error:.2g} s")
    return pass_claim()


def _other_events(named: str, count: int, score: EventScore) -> Finding:
    return fail_claim(named, f"{count} events", f"{score.missing} missing, {score.extra} that do not exist")


@dataclass(frozen=True)
class _Few:
    """A short span with few events: the span divided by 2^halvings, its length, its exact events."""

    halvings: int
    span: float
    events: tuple[Event, ...]


def _few(trials: Trials) -> _Few | None:
    """The shortest span, the case's span halved up to SHORTEST times, with an event before its end and none near it."""
    events = trials.case.events()
    for halvings in reversed(range(SHORTEST)):
        span = float(trials.reference.times[-1]) * 2.0**-halvings
        times = [float(event.time) for event in events]
        if times and 0 < times[0] < WITHIN * span and not any(abs(time - span) < CLEAR * span for time in times):
            return _Few(halvings, span, tuple(event for event in events if float(event.time) < span))
    return None


def _order_with_events(trials: Trials) -> str | None:
    if not trials.steps:
        return "its setting is a tolerance"
    return "it declares no order" if trials.integrator.order is None else _has_events(trials)


@claim("event_order", _order_with_events)
def _event_order(trials: Trials) -> Finding:
    """Errors of states and event times over a span with few events: at the finest setting, and against longer steps."""
    few, order = _few(trials), trials.order
    if few is None:
        return not_applicable("no short span has an event within it")
    answers = [a for a in _answers(trials, few.halvings) if a.states is not None and not a.declined]
    if not answers:
        return not_applicable("no setting has a solution")
    finest = answers[-1]
    named = f"{trials.named(finest.setting)} over 1/{2**few.halvings} of the span"
    whole = _Few(0, float(trials.reference.times[-1]), tuple(trials.case.events()))
    for part, answer, where in ((few, finest, named), (whole, trials.answers()[-1], "")):
        allowed = _first_order(trials, part, answer)
        if not answer.declined and allowed < UNRELATED and not answer.error <= allowed:
            where = where or trials.named(answer.setting)
            return fail_claim(where, f"an error below {allowed:.2g}, as of order 1", f"{answer.error:.2g}")
    scores = [(a, score_events(a.events, few.events)) for a in answers if a.events is not None]
    if finest.events is not None and finest.error < LARGEST_ERROR and (scores[-1][1].missing or scores[-1][1].extra):
        return _other_events(named, len(few.events), scores[-1][1])
    states = [(a.setting, a.error, a.roundoff) for a in answers if a.error < LARGEST_ERROR]
    times = [(a.setting, s.time_error / few.span, a.roundoff) for a, s in scores if not (s.missing or s.extra)]
    for points, what in ((states, "error"), (times, "error of the times of events over the span")):
        worse = above_line(points, order, LONGER, COARSE) if order > 1 else None
        if worse is not None:
            h, error, most = worse
            return fail_claim(
                f"h = {h:.6g} over 1/{2**few.halvings} of the span", f"{what} below {most:.2g}", f"{error:.2g}"
            )
    return _slope(trials, few, (states, times)) if order > 1 else pass_claim()


def _slope(trials: Trials, few: _Few, first: tuple[list[Point], list[Point]]) -> Finding:
    """Whether the errors of the states, and of the event times, may have the slope of the order.

    `first` has the points over the short span. Over other lengths events are at other places in their steps.
    """
    order, finding = trials.order, pass_claim()
    lines = [[in_range(points)] for points in _select_conditioned(*first)]
    if not any(len(usable) >= FEWEST for (usable,) in lines):
        return finding
    for share in SHARES:
        for line, points in zip(lines, _select_conditioned(*_points_over(trials, few, share)), strict=True):
            line.append(in_range(points))
    for line, what in zip(lines, ("errors", "errors of the times of events"), strict=True):
        logarithms = [
            [(math.log(h), math.log(error)) for h, error, _ in points[-MOST_ON_A_LINE:]]
            for points in line
            if len(points) >= FEWEST
        ]
        if not logarithms:
            continue
        slope, largest = fit_slope(logarithms)
        if largest < order - MARGIN:
            count = sum(map(len, logarithms))
            where = f"{count} solutions over {len(logarithms)} lengths, to 1/{2**few.halvings} of the span"
            return fail_claim(where, f"{what} proportional to h^{order}", f"h^{slope:.2f}, at most h^{largest:.2f}")
        finding = pass_claim(f"{slope:.2f}")
    return finding


def _select_conditioned(states: list[Point], times: list[Point]) -> tuple[list[Point], list[Point]]:
    """The points, with event times only at step sizes at which the states have errors above round-off.

    Where a guard hardly changes at an event, the time of the event is known less well than the states.
    """
    steps = {h for h, _, _ in in_range(states)}
    return states, [point for point in times if point[0] in steps]


def _points_over(trials: Trials, few: _Few, share: float) -> tuple[list[Point], list[Point]]:
    """(step size, error, round-off) of states and of event times over a share of the short span.

    They go from one step a sample down to round-off; there are no points if an event is close to the end.
    """
    whole = trials.problem(few.halvings)
    points: tuple[list[Point], list[Point]] = ([], [])
    problem, span = replace(whole, times=whole.times * share), few.span * share
    events = [event for event in few.events if float(event.time) < span]
    if any(abs(float(event.time) - span) < CLEAR * span for event in few.events):
        return points
    exact, interval = trials.case.sample(problem.times), problem.interval
    for h in _step_sizes(trials, interval):
        solution = trials.outcome(problem, h, trials.start).solution
        if solution is None:
            continue
        error = float(np.max(trials.distance(solution.states[0], exact)))
        roundoff = trials.roundoff(solution.steps or round(span / h), few.halvings)
        points[0].append((h, error, roundoff))
        if solution.events is not None:
            score = score_events(solution.events, events)
            if not (score.missing or score.extra):
                points[1].append((h, score.time_error / span, roundoff))
        if error < roundoff:
            break
    return points


def _answers(trials: Trials, halvings: int) -> Sequence[Answer]:
    """The answers over the short span, from one step a sample to `STEPS` steps."""
    return [trials.short(halvings, h) for h in _step_sizes(trials, trials.problem(halvings).interval)]


def _step_sizes(trials: Trials, interval: float) -> list[float]:
    """Step sizes of the sweep, from one step in a sampling interval to `STEPS` steps in all."""
    sizes = [interval / 2**k for k in range(64) if 64 * 2**k <= min(STEPS, trials.extent.steps)]
    return [h for h in sizes if h <= trials.longest_step]


def _first_order(trials: Trials, few: _Few, answer: Answer) -> float:
    """The largest error that a method of order 1 may have, see the bound of `event_order`."""
    scales = max(1.0, few.span / trials.reference.time_scale)
    growth = max(1.0, trials.conditioning(few.halvings) / HALF_ULP)
    return growth * scales * (scales + 4 * len(few.events)) * answer.setting / few.span + answer.roundoff

"""Claims about motions with events: that each is found at its time, and that the error falls with the order declared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gnomon.harness.contract.integrator import Steps
from gnomon.harness.results.convergence_order import LARGEST_ERROR
from gnomon.harness.scoring.events import EventScore, score_events
from gnomon.harness.verification.claims import Finding, claim, failed, not_applicable, passed
from gnomon.harness.verification.convergence_claims import above_line, allowed_error
from gnomon.harness.verification.trials import HALF_ULP, SHORTEST, TIGHT, Answer, Trials

WITHIN = 0.75
"""The first event is in this share of a short span: the motion after it counts."""
CLEAR = 1e-3
"""No event is so close to the end of a short span, in lengths of it."""
LONGER = 7.0
"""Errors are compared with those at 8 times longer steps and more: an order that is lower by half has 2^order times the
error there, and the constant of a right method changes by less."""
COARSE = 3
"""So many longer steps: where events are located to the order declared and no better, the error depends on where in its
step an event is, and may be small at one step size. At order 1 events may be anywhere in their step: this does not apply."""
UNRELATED = 2.0
"""Two states of the size of the motion are at most so far apart: a larger bound of an error says nothing."""
STEPS = 2**14
"""Steps over a short span, at most."""


def _has_events(trials: Trials) -> str | None:
    return None if trials.case.hybrid is not None else "the case has no events"


@claim("events", _has_events)
def _events(trials: Trials) -> Finding:
    """The two most accurate settings over the whole span."""
    exact, span = trials.case.events(), float(trials.case.span)
    usable = [a for a in trials.answers() if a.events is not None and not a.declined]
    usable = [a for a in usable if a.error < LARGEST_ERROR and (trials.steps or a.setting <= TIGHT)]
    if not usable:
        return not_applicable("no accurate setting gives events")
    for answer in usable[-2:]:
        score, named = score_events(answer.events or (), exact), trials.named(answer.setting)
        if score.missing or score.extra:
            return _other_events(named, len(exact), score)
        allowed = answer.setting if trials.steps else allowed_error(trials, answer.setting, answer) * span
        if not score.time_error <= allowed + 2 * trials.conditioning() * span:
            return failed(named, f"event times within {allowed:.2g} s", f"{score.time_error:.2g} s")
    return passed()


def _other_events(named: str, count: int, score: EventScore) -> Finding:
    return failed(named, f"{count} events", f"{score.missing} missing, {score.extra} that do not exist")


@dataclass(frozen=True)
class _Few:
    """A short span with few events: the span divided by 2^halvings, its length, its exact events."""

    halvings: int
    span: float
    events: tuple[object, ...]


def _few(trials: Trials) -> _Few | None:
    """The shortest span with an event in its first part and none at its end."""
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
    if trials.integrator.order is None:
        return "it declares no order"
    return _has_events(trials)


@claim("event_order", _order_with_events)
def _event_order(trials: Trials) -> Finding:
    """Errors and times of events over a span with few of them: at the finest setting, and by the line of longer steps."""
    few, order = _few(trials), trials.integrator.order
    assert order is not None
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
            return failed(where, f"an error below {allowed:.2g}, as of order 1", f"{answer.error:.2g}")
    scores = [(a, score_events(a.events, few.events)) for a in answers if a.events is not None]  # type: ignore[arg-type]
    if finest.events is not None and finest.error < LARGEST_ERROR and (scores[-1][1].missing or scores[-1][1].extra):
        return _other_events(named, len(few.events), scores[-1][1])
    states = [(a.setting, a.error, a.roundoff) for a in answers if a.error < LARGEST_ERROR]
    times = [(a.setting, s.time_error / few.span, a.roundoff) for a, s in scores if not (s.missing or s.extra)]
    for points, what in ((states, "error"), (times, "error of the times of events over the span")):
        worse = above_line(points, order, LONGER, COARSE) if order > 1 else None
        if worse is not None:
            h, error, most = worse
            return failed(
                f"h = {h:.6g} over 1/{2**few.halvings} of the span", f"{what} below {most:.2g}", f"{error:.2g}"
            )
    return passed()


def _answers(trials: Trials, halvings: int) -> Sequence[Answer]:
    """The answers over the short span, from one step a sample to `STEPS` steps."""
    sweep, interval = trials.integrator.sweep, trials.problem(halvings).interval
    assert isinstance(sweep, Steps)
    counts = [2**k for k in range(64) if 64 * 2**k <= min(STEPS, trials.depth.steps)]
    return [
        trials.short(halvings, interval / n)
        for n in counts
        if interval / n <= sweep.coarsest * trials.reference.time_scale
    ]


def _first_order(trials: Trials, few: _Few, answer: Answer) -> float:
    """The error that a method of order 1 may have: see the bound of `event_order`."""
    scales = max(1.0, few.span / trials.reference.time_scale)
    growth = max(1.0, trials.conditioning(few.halvings) / HALF_ULP)
    return growth * scales * (scales + 4 * len(few.events)) * answer.setting / few.span + answer.roundoff

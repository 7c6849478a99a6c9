"""Claims about accuracy: whether a solution follows the exact motion, its order, and its error at each setting."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.trials import HALF_ULP, SHORT, SHORT_SPANS, SHORTEST, TIGHT, Answer, Floats, Trials
from gnomon.harness.results.convergence_order import ABOVE_FLOOR_ON_A_LINE, FEWEST, LARGEST_ERROR
from gnomon.harness.verification.claims import (
    TEXTS,
    Finding,
    Outcome,
    claim,
    fail_claim,
    not_applicable,
    not_checked,
    pass_claim,
    within,
)
from gnomon.harness.verification.function_adapter import Stepped
from scipy.special import stdtrit

TINY = 20
"""Number of halvings of the span in which a tiny step is a 64th: the step is some 1e-8 time scales long."""
HALVED = 7
"""Number of step sizes of `order_short`, each half of the one before."""
MARGIN = 0.5
"""Orders are whole numbers: a slope that is lower by more than this belongs to a lower order."""

STEADY = 0.25
"""Largest distance of the slopes between settings from a steady order."""
MOST_ON_A_LINE, CONFIDENCE = 6, 0.99
"""Largest number of tolerances that a line is fitted to; one-sided confidence of the upper end of its slope."""

NEAR = 0.01
"""Largest error, as a share of the distance that the exact motion covers in a part of the span. States that are one of 64
samples too early or too late have an error of at least 1/64 of this distance."""
ORDER_1 = 2.0
"""Largest error of a step of a method of order 1, in units of h^2 y''/2: 1 for both Euler methods, times a margin of 2."""
STEPS, FEWEST_STEPS = 1e4, 64
"""Numbers of steps over the whole span, and least number over a part, each with an error of the tolerance."""

Point = tuple[float, float, float]
"""(step size, error, round-off)"""


@claim("runs")
def _ran(trials: Trials) -> Finding:
    """Whether two settings of the sweep give finite states, or a reason."""
    solved = trials.answers()
    # Not at the tightest setting of the sweep: a slow method may take hours there.
    answers = [solved[k] for k in sorted({len(solved) // 2, len(solved) - 1})]
    for answer in answers:
        lost = math.isnan(answer.error) if answer.status == Status.OK else not answer.refused
        if lost and not answer.stopped:
            return fail_claim(trials.named(answer.setting), "finite states, or a reason why there are none", answer.why)
    if all(answer.refused for answer in answers):
        return not_applicable(f"it declines: {answers[-1].why}")
    return pass_claim()


@claim("follows")
def _follows(trials: Trials) -> Finding:
    """The error at the finest setting with a solution, over the longest part in which every consistent method has small ones."""
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
            return pass_claim(f"{answer.error:.2g}")
        if must:
            part = f" over 1/{2**halvings} of the span" * (halvings > 0)
            expected = f"states within {allowed:.2g} of the exact motion, which covers {covered:.2g}"
            return fail_claim(f"{trials.named(answer.setting)}{part}", expected, f"{answer.error:.2g}")
    return not_checked("no part of the span is so short that a method of order 1 must follow it")


def _setting(trials: Trials, halvings: int, finest: float) -> float:
    """The finest setting; a step is at most a sampling interval of the part."""
    return min(finest, float(trials.problem(halvings).interval)) if trials.steps else finest


def _first_part(trials: Trials) -> int:
    """The halvings of the longest part to compare: for an engine, a part that ends before the first event, as a contact."""
    if trials.case.hybrid is None or not isinstance(trials.form, SceneForm):
        return 0
    first = next((float(event.time) for event in trials.case.events()), math.inf)
    span = float(trials.reference.times[-1])
    return next((k for k in range(SHORTEST) if span * 2.0**-k < first), 0) if first > 0 else 0


def distance_covered(trials: Trials, halvings: int) -> float:
    """The largest distance of the exact motion from its start, in the metric; 1, its size, for a motion that rests."""
    exact = trials.exact(halvings)
    return float(np.max(trials.distance(exact, np.broadcast_to(trials.start, exact.shape)))) or 1.0


def _largest_error(trials: Trials, halvings: int, finest: float) -> float:
    """An upper bound of the error of any consistent method at a setting over the span divided by 2^halvings.

    A step h of a method of order 1 has an error of h^2/2 times the second derivative, whose integral is estimated by the
    second differences of the samples; a step of a tolerance has an error of the tolerance. By the end of the motion an error
    grows at most by the conditioning over half an ulp, and an error of a velocity by the time in time scales.
    """
    span = float(trials.reference.times[-1]) * 2.0**-halvings
    grown = max(1.0, trials.conditioning(halvings) / HALF_ULP) * (1 + span / trials.reference.time_scale)
    if not trials.steps:
        return max(STEPS * 2.0**-halvings, FEWEST_STEPS) * math.sqrt(len(trials.start)) * finest * grown
    exact = np.concatenate([trials.start[None], trials.exact(halvings)])
    bends = trials.distance(2 * exact[1:-1] - exact[:-2], exact[2:])
    share = _setting(trials, halvings, finest) / float(trials.problem(halvings).interval)
    return ORDER_1 * 0.5 * share * float(np.sum(bends)) * grown


def _has_order(trials: Trials) -> str | None:
    if not trials.steps:
        return "its setting is a tolerance"
    return "it declares no order" if trials.integrator.order is None else None


def _explain_order(trials: Trials) -> str | None:
    return _has_order(trials) or ("with events error/h^order is not smooth" if trials.case.hybrid is not None else None)


def in_range(points: Sequence[Point]) -> list[Point]:
    """The points, from the longest step down, whose errors are small and well above round-off.

    They begin after the last large error, and end before the first error that round-off may have changed.
    """
    usable: list[Point] = []
    for h, error, roundoff in points:
        if not error < LARGEST_ERROR:
            usable = []
        elif error < ABOVE_FLOOR_ON_A_LINE * roundoff:
            break
        else:
            usable.append((h, error, roundoff))
    return usable


def slope_of(points: Sequence[Point], order: int, what: str) -> Finding:
    """Whether the errors at the finest settings have at least the slope of this order.

    The largest of three slopes counts: over the finest four points in range, over the last two of these, and over the
    last two points above round-off. Where the leading terms of an error cancel at some step size, the slope of a right
    method is too low nearby, but tends to its order for shorter steps. The error of a fault has a lower order and
    dominates for shorter steps.
    """
    usable = in_range(points)
    if len(usable) < FEWEST:
        return not_applicable(
            f"{len(usable)} settings between an error of {LARGEST_ERROR:g} and round-off, {FEWEST} are needed"
        )
    above = [point for point in points if point[2] < point[1] < LARGEST_ERROR]
    (h1, e1, _), (h0, e0, _) = usable[-1], usable[-FEWEST]
    pairs = [(usable[-FEWEST], usable[-1]), (usable[-2], usable[-1]), (above[-2], above[-1])]
    slope = max(math.log(coarse[1] / fine[1]) / math.log(coarse[0] / fine[0]) for coarse, fine in pairs)
    if slope >= order - MARGIN:
        return pass_claim(f"{slope:.2f}")
    return fail_claim(
        f"h = {h0:.3g} to {h1:.3g}", f"{what} proportional to h^{order}", f"h^{slope:.2f} ({e0:.2g} to {e1:.2g})"
    )


@claim("order", _explain_order)
def _order(trials: Trials) -> Finding:
    return slope_of(_points(trials.answers()), trials.order, "errors over the whole span")


@claim("step_order", _explain_order)
def _step_order(trials: Trials) -> Finding:
    """The order of one step, from 64 steps over spans that are halved again and again; then the error of 64 tiny steps.

    The line of the other errors bounds the error of the tiny steps. They show a wrong formula for small arguments, or a
    step size below which nothing moves.
    """
    power = trials.order + isinstance(trials.integrator, Stepped)
    points = [(h, answer.error, answer.roundoff) for h, answer in trials.single_steps()]
    finding = slope_of(points, power, "errors of a step")
    if finding.outcome != Outcome.PASSED:
        return finding
    h = float(trials.problem(TINY).interval)
    tiny = trials.short(TINY, h)
    allowed = on_line(in_range(points), power, h, tiny.roundoff)
    if tiny.declined or tiny.error <= allowed:
        return finding
    return fail_claim(f"h = {h:.3g}", f"errors of a step below {allowed:.2g}", f"{tiny.error:.2g}")


@claim("order_short", _explain_order)
def _order_short(trials: Trials) -> Finding:
    """The order over a 64th of the span, or a shorter part, in which 64 steps have a small error.

    A method that converges to another motion may have large errors over the whole span, where no order can be measured.
    """
    halvings, answers = _short_answers(trials)
    if not answers:
        return not_applicable(f"64 steps over a short span have no error below {LARGEST_ERROR:g}")
    what, last = f"errors over 1/{2**halvings} of the span", answers[-1]
    if last.error >= LARGEST_ERROR:
        return fail_claim(
            f"h = {last.setting:.3g}", f"{what} below {LARGEST_ERROR:g}, as of 64 steps", f"{last.error:.2g}"
        )
    return slope_of(_points(answers), trials.order, what)


def _short_answers(trials: Trials) -> tuple[int, list[Answer]]:
    """(halvings, answers) over the longest short span in which 64 steps have a small error; no answers without one."""
    for halvings in range(SHORT, SHORTEST):
        interval = float(trials.problem(halvings).interval)
        if trials.short(halvings, interval).error < LARGEST_ERROR:
            return halvings, [trials.short(halvings, interval / 2**k) for k in range(HALVED)]
    return SHORTEST, []


def _points(answers: Sequence[Answer]) -> list[Point]:
    """The answers at fixed steps as (step size, error, round-off)."""
    return [(answer.setting, answer.error, answer.roundoff) for answer in answers]


def fit_slope(lines: Sequence[Sequence[tuple[float, float]]]) -> tuple[float, float]:
    """(slope, upper end of its interval) of lines of points (x, y), fitted with one slope and a constant for each line."""
    centred = [np.array(line) - np.mean(line, axis=0) for line in lines]
    x, y = np.concatenate(centred).T
    slope = float(x @ y / (x @ x))
    free = len(x) - len(lines) - 1
    spread = math.sqrt(float(np.sum((y - slope * x) ** 2)) / free / float(x @ x))
    return slope, slope + float(stdtrit(free, CONFIDENCE)) * spread


def on_line(points: Sequence[Point], order: int, h: float, roundoff: float) -> float:
    """The error at a step 2 h by the largest error/step^order of these points, plus round-off; infinite without points."""
    line = max((max(error, own) / step**order for step, error, own in points), default=math.inf)
    return line * (2 * h) ** order + ABOVE_FLOOR_ON_A_LINE * roundoff


def above_line(
    points: Sequence[Point], order: int, longer: float = 1.0, fewest: int = 1
) -> tuple[float, float, float] | None:
    """(h, error, allowed error) of the point whose error exceeds its bound by the largest factor; None if no error does.

    The bound is the largest error/step^order of the steps longer than `longer` h, times (2 h)^order, plus round-off. A
    point with fewer than `fewest` longer steps has no bound.
    """
    above: list[Point] = []
    for h, error, roundoff in points:
        lines = [max(e, r) / step**order for step, e, r in points if step > longer * h]
        if len(lines) < fewest:
            continue
        allowed = max(lines) * h**order * 2.0 ** max(order, 2) + ABOVE_FLOOR_ON_A_LINE * roundoff
        if error > allowed:
            above.append((h, error, allowed))
    return max(above, key=lambda point: point[1] / point[2], default=None)


@claim("error", lambda trials: None if trials.steps else "its setting is a tolerance")
def _error(trials: Trials) -> Finding:
    """Whether no error lies above the line error/h^order through the errors of longer steps (`above_line`).

    Cases with events count too: if events are located with a lower order, the error falls more slowly.
    """
    points = [point for point in _points(trials.answers()) if not math.isnan(point[1])]
    if points and all(error <= ABOVE_FLOOR_ON_A_LINE * roundoff for _, error, roundoff in points):
        return pass_claim("round-off at all settings")
    if trials.integrator.order is None:
        return _steady_order(points, trials)
    first = next((k for k, (_, error, _) in enumerate(points) if error < LARGEST_ERROR), len(points))
    points = points[first:]
    if len(points) < FEWEST:
        return not_applicable(f"{len(points)} settings with an error below {LARGEST_ERROR:g}, {FEWEST} are needed")
    worse = above_line(points, trials.order)
    if worse is None:
        return pass_claim()
    h, error, allowed = worse
    return fail_claim(f"h = {h:.6g}", f"error below {allowed:.2g}", f"{error:.2g}")


def _steady_order(points: Sequence[Point], trials: Trials) -> Finding:
    """The order of a method without a declared one: a steady order of 1 or more, over the span or a short span."""
    slopes: list[float] = []
    for usable in (in_range(points), in_range(_points(_short_answers(trials)[1]))):
        pairs = itertools.pairwise(usable[-FEWEST:])
        slopes = [math.log(coarse[1] / fine[1]) / math.log(coarse[0] / fine[0]) for coarse, fine in pairs]
        if len(slopes) == FEWEST - 1 and min(slopes) > 1 - STEADY and max(slopes) - min(slopes) < 2 * STEADY:
            return pass_claim(f"order {slopes[-1]:.2f} found")
    shown = ", ".join(f"{slope:.2f}" for slope in slopes) or "too few small errors"
    return not_checked(f"it declares no order, and its errors show no steady one of at least 1 ({shown})")


def _tolerance_applies(trials: Trials) -> str | None:
    return "its setting is a step size" if trials.steps else None


def sum_allowed_errors(
    trials: Trials, tolerance: float, answer: Answer, halvings: int = 0, last: bool = False
) -> float:
    """The sum of all local errors that the tolerance allows, at the worst sample or at the last one, plus round-off.

    Each step may add `tolerance` times the size of the state to each component, which is sqrt(dim) tolerance in the norm.
    Until a sample each of these errors grows at most by the growth of errors of the exact motion. The sum is infinite if
    neither steps nor calls are counted.
    """
    growth = trials.growth(halvings)
    largest = float(growth[-1] if last else np.max(growth))
    return trials.steps_of(answer) * math.sqrt(len(trials.start)) * tolerance * largest + answer.roundoff


def same_solution(trials: Trials, states: Floats, what: str, roundings: float = 1.0, share: float = 0.0) -> Finding:
    """Whether states (samples, dim) agree with the solution of a call from this start alone, at the usual setting.

    They may differ by `roundings` times the round-off plus `share` of the error at a step size, or by twice the error that a
    tolerance allows.
    """
    alone = trials.whole(trials.usual())
    named = trials.named(alone.setting)
    if alone.states is None or alone.declined or math.isnan(alone.error):
        return not_applicable(f"no solution at {named}: {alone.why}")
    last = is_dense(trials)
    apart = float(np.max(trials.distance(states, alone.states)[-1 if last else 0 :]))
    at_steps = roundings * alone.roundoff + share * alone.error
    allowed = at_steps if trials.steps else 2 * sum_allowed_errors(trials, alone.setting, alone, last=last)
    if not allowed < math.inf:
        return not_applicable("it counts neither steps nor right-hand sides: its tolerance bounds no error")
    return within(allowed, apart, named, f"{what} within {allowed:.2g} of the solution from the start alone")


def is_dense(trials: Trials) -> bool:
    """Whether an adaptive method interpolates: the interpolant then adds an error at all samples except the last."""
    return not trials.steps and trials.integrator.sampling == "dense output"


def _error_of_steps(trials: Trials, answer: Answer) -> float:
    """The error of an adaptive method's steps; with dense output only at the last sample, which is not interpolated."""
    return answer.last if is_dense(trials) else answer.error


def _over_tolerance(trials: Trials, answers: Sequence[tuple[int, Answer]]) -> Finding:
    """Whether the errors of (halvings, answer) pairs, over the span divided by 2^halvings, are within their tolerances.

    A failure shows the worst answer.
    """
    counted, worse = 0, []
    for halvings, answer in answers:
        if answer.declined:
            continue
        error = _error_of_steps(trials, answer)
        allowed = sum_allowed_errors(trials, answer.setting, answer, halvings, last=is_dense(trials) or halvings > 0)
        if not allowed < LARGEST_ERROR:
            continue
        counted += 1
        if not error <= allowed:
            part = f" over 1/{2**halvings} of the span" if halvings else ""
            where = " at the last sample" if is_dense(trials) or halvings else ""
            work = f"{trials.steps_of(answer):.0f} steps at most"
            expected = f"error{where} below {allowed:.2g} with {work}"
            failure = fail_claim(f"{trials.named(answer.setting)}{part}", expected, f"{error:.2g}")
            worse.append((math.inf if math.isnan(error) else error / allowed, failure))
    if worse:
        return max(worse, key=lambda each: each[0])[1]
    return pass_claim() if counted else not_applicable("no setting whose tolerance bounds the error")


def _tolerances(trials: Trials) -> list[float]:
    return [setting for setting in trials.settings if setting <= TIGHT]


@claim("tolerance", _tolerance_applies)
def _tolerance(trials: Trials) -> Finding:
    return _over_tolerance(trials, [(0, a) for a in trials.answers() if a.setting <= TIGHT])


_hard = replace(_tolerance, **TEXTS["hard"], id="hard", hard=True, no_answer=True)
"""The claim `tolerance` on hard variants."""


def _short_applies(trials: Trials) -> str | None:
    return _tolerance_applies(trials) or ("events need the whole span" if trials.case.hybrid is not None else None)


@claim("tolerance_short", _short_applies)
def _tolerance_short(trials: Trials) -> Finding:
    short = [(n, trials.short(n, s, end=True)) for n in SHORT_SPANS for s in _tolerances(trials)]
    return _over_tolerance(trials, short)


@claim("proportional", _short_applies)
def _proportional(trials: Trials) -> Finding:
    """Whether the errors at the two tightest tolerances above round-off are far below those at 100 times the tolerance.

    A method of variable order may have the same error at all loose tolerances, and only round-off at the next one. So the
    claim passes as soon as an error has fallen to round-off.
    """
    usable: list[tuple[float, float]] = []
    for tolerance in _tolerances(trials):
        answer = trials.short(SHORT, tolerance)
        error = _error_of_steps(trials, answer)
        if answer.declined:
            continue
        if usable and error <= ABOVE_FLOOR_ON_A_LINE * answer.roundoff:
            return pass_claim(f"{usable[0][1] / max(error, answer.roundoff):.3g}")
        if ABOVE_FLOOR_ON_A_LINE * answer.roundoff < error < LARGEST_ERROR:
            usable.append((tolerance, error))
    tight = usable[-2:]
    loose = [(t, e) for t, e in usable if tight and 1e2 <= t / tight[0][0] <= 1e4 * 1.01]
    if not loose:
        return not_applicable("no tolerances, a hundred times apart, with errors above round-off")
    least, most = min(e for _, e in tight), max(e for _, e in loose)
    if least <= most / 10:
        return pass_claim(f"{most / least:.3g}")
    return fail_claim(
        f"tolerances {loose[0][0]:g} to {tight[-1][0]:g} over 1/{2**SHORT} of the span",
        f"an error below {most / 10:.2g}, a tenth of that at tolerances 100 to 10,000 times larger",
        f"{least:.2g}",
    )


def _work_applies(trials: Trials) -> str | None:
    order = trials.integrator.order
    if trials.steps or order is None or order < 3:
        return "its setting is a step size" if trials.steps else "it declares no order of 3 or more"
    return "events add steps" if trials.case.hybrid is not None else None


@claim("work", _work_applies)
def _work(trials: Trials) -> Finding:
    """Whether the number of steps grows no faster than the order allows."""
    usable = [a for a in trials.answers() if a.work and not a.declined and a.setting <= TIGHT and a.error > a.roundoff]
    if len(usable) < FEWEST:
        return not_applicable(f"{len(usable)} settings with an error above round-off, {FEWEST} are needed")
    loose, tight = usable[0], usable[-1]
    assert loose.work is not None
    assert tight.work is not None
    allowed = 2.0 * (loose.setting / tight.setting) ** (1.0 / (trials.order - 1))
    ratio = tight.work / loose.work
    if ratio <= allowed:
        return pass_claim(f"{ratio:.3g}")
    settings = f"tolerances {loose.setting:g} and {tight.setting:g}"
    return fail_claim(settings, f"at most {allowed:.3g} times the work", f"{ratio:.3g} times")


@claim("work_order", _work_applies)
def _work_order(trials: Trials) -> Finding:
    """The slope of the error over the mean length of a step, at the tightest tolerances."""
    answers = [answer for answer in trials.answers() if answer.setting <= TIGHT]
    return slope_over_work([(answer, _error_of_steps(trials, answer)) for answer in answers], trials.order, "errors")


def slope_over_work(solved: Sequence[tuple[Answer, float]], order: int, errors: str) -> Finding:
    """Whether these errors of answers, loosest first, may have the slope `order` over the mean length of a step."""
    points = [
        (-math.log(answer.work), math.log(error))
        for answer, error in solved
        if answer.work and not answer.declined and ABOVE_FLOOR_ON_A_LINE * answer.roundoff < error < LARGEST_ERROR
    ]
    points = points[-MOST_ON_A_LINE:]
    if len(points) < FEWEST or points[0][0] - points[-1][0] < math.log(2):
        return not_applicable(
            f"{len(points)} tolerances with errors above round-off, {FEWEST} and twice the work are needed"
        )
    slope, largest = fit_slope([points])
    if largest >= order - MARGIN:
        return pass_claim(f"{slope:.2f}")
    where = f"the {len(points)} tightest tolerances with errors above round-off"
    expected = f"{errors} proportional to h^{order}, h the mean step"
    return fail_claim(where, expected, f"h^{slope:.2f}, at most h^{largest:.2f}")

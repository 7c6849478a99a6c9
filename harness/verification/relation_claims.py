"""Claims that relate two solutions: turned starts, another clock, falling times, units, signs, bodies; dense output."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from gnomon.cases.core.forms import FirstOrder, Form, SecondOrder, Values
from gnomon.cases.core.scene import SceneForm
from gnomon.cases.core.symmetry import Relation, in_units, mirrored, permuted
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.contract.velocity_forces import VelocityForces
from gnomon.harness.measuring.trials import SHORT, SHORTEST, TIGHT, Answer, Trials
from gnomon.harness.results.convergence_order import LARGEST_ERROR
from gnomon.harness.studies.related_motions import holds, later, relate
from gnomon.harness.verification.claims import Finding, claim, fail_claim, not_applicable, not_checked, pass_claim
from gnomon.harness.verification.convergence_claims import (
    NEAR,
    distance_covered,
    is_dense,
    on_line,
    same_solution,
    slope_over_work,
    sum_allowed_errors,
)
from gnomon.harness.verification.fmu.adapter import FmuIntegrator
from gnomon.harness.verification.function_adapter import FunctionAdapter

TURNED = 3
"""Number of turned starts that are solved."""
CLOCKS = 4.0
"""Factor on round-off for the later clock: its unit in the last place, to which the times of stages are rounded, is up
to four times as large, and the conditioning counts the effect of one rounding."""
APART = 2.0
"""Factor on round-off for two related motions, each with its own roundings."""
LENGTH, TIME = 2.0**10, 2.0**-5
"""Number of the new units in a metre and in a second: powers of two, which change no rounding. Lengths, velocities and
rates become larger numbers, so that an absolute bound inside the integrator is tighter."""
BACK, MOST_CALLS = 3, 100.0
"""BACK: least number of halvings of the span that is solved backwards. MOST_CALLS: most calls of a backward solution, as a
multiple of the calls of a forward one."""
TENTH = 0.1
"""A second in units of 10 s: times and steps then round, as for most users; with powers of two they never do."""


def _has_turning(trials: Trials) -> str | None:
    if not len(trials.reference.turned):
        return "the case has no rotational symmetry"
    return "it declares no order" if trials.steps and trials.integrator.order is None else None


def _allow_error(trials: Trials, answer: Answer) -> float:
    """The error that a setting may have from any start of a similar motion."""
    if not trials.steps:
        return sum_allowed_errors(trials, answer.setting, answer, last=is_dense(trials))
    usable = [(a.setting, a.error, a.roundoff) for a in trials.answers() if a.error < LARGEST_ERROR]
    return on_line(usable, trials.order, answer.setting, answer.roundoff)


@claim("turned", _has_turning)
def _check_turned(trials: Trials) -> Finding:
    """The errors from turned starts, at the tightest accurate setting that takes at most the seconds of the extent."""
    quick = [a for a in trials.answers() if a.seconds <= trials.extent.seconds]
    usable = [a for a in quick if not a.declined and a.error < LARGEST_ERROR]
    if not usable:
        return not_applicable(f"no setting with an error below {LARGEST_ERROR:g} within {trials.extent.seconds:g} s")
    answer = usable[-1]
    allowed = _allow_error(trials, answer)
    if not allowed < LARGEST_ERROR:
        return not_applicable(f"no setting whose error is bounded below {LARGEST_ERROR:g}")
    starts, exact = trials.reference.turned_starts[:TURNED], trials.reference.turned_exact
    solutions = trials.solutions(trials.problem(), answer.setting, list(starts))
    samples = slice(-1 if is_dense(trials) else 0, None)
    errors = [
        float(np.max(trials.distance(states, right)[samples])) for states, right in zip(solutions, exact, strict=False)
    ]
    worst = int(np.argmax(errors))  # the first nan, if any
    if errors[worst] <= allowed:
        return pass_claim()
    where = f"{trials.named(answer.setting)}, turned start {worst + 1}"
    expected = f"error below {allowed:.2g}, as from the start itself ({answer.error:.2g})"
    return fail_claim(where, expected, f"{errors[worst]:.2g}")


def _smooth(trials: Trials) -> str | None:
    return None if trials.case.hybrid is None else "events at other times may change the motion"


@claim("clock", _smooth)
def _clock(trials: Trials) -> Finding:
    """Whether the motion is equal if the times of the start and of all samples are later by a constant."""
    shifted = later(trials.problem())
    if shifted is None:
        return not_applicable("its sample times cannot be shifted exactly")
    (states,) = trials.solutions(shifted, trials.usual(), [trials.start])
    return same_solution(trials, states, f"the motion by a clock that starts at {shifted.t0:g}", CLOCKS)


def _check_related(trials: Trials, relation: Relation | None, what: str, share: float = 0.0) -> Finding:
    """Solve the transformed motion, transform the states back, and compare them with the motion of the case."""
    assert relation is not None
    other = relate(trials, trials.problem(), trials.usual(), relation)
    (states,) = trials.solutions(other.problem, other.setting, [other.start])
    return same_solution(trials, other.undone(states), what, APART, share)


def _no_engine(trials: Trials) -> str | None:
    if isinstance(trials.form, SceneForm) or isinstance(trials.integrator, FmuIntegrator):
        return "an engine that is given a scene, or an FMU, may have lengths, times and axes of its own"
    return _smooth(trials)


def _has_units(trials: Trials) -> str | None:
    relation, case = in_units(trials.case, LENGTH, TIME), trials.case
    if relation is None or min(relation.factors[coordinate.name] for coordinate in case.state) < 1:
        return "its state has units that are unknown, or do not become smaller with the unit of length"
    if not holds(trials, relation):
        return "its equations hold in one system of units only"
    return _no_engine(trials)


@claim("units", _has_units)
def _units(trials: Trials) -> Finding:
    relation = in_units(trials.case, LENGTH, TIME)
    return _check_related(trials, relation, f"the motion in units of 1/{LENGTH:g} m and {1 / TIME:g} s", 0.5)


@claim("rounded_times", _has_units)
def _check_rounded_times(trials: Trials) -> Finding:
    try:
        return _check_related(trials, in_units(trials.case, 1.0, TENTH), f"the motion in units of {1 / TENTH:g} s", 0.5)
    except Refused as refusal:
        return not_applicable(f"it declines samples at times that round: {refusal}")


@claim("mirror", lambda trials: _no_engine(trials) if trials.case.mirror else "the case has no mirror symmetry")
def _mirror(trials: Trials) -> Finding:
    signs = ", ".join(trials.case.mirror)
    return _check_related(trials, mirrored(trials.case), f"the motion with other signs of {signs}")


def _has_like_parts(trials: Trials) -> str | None:
    if not trials.case.alike:
        return "the case has no bodies or axes that are alike"
    if not set(trials.integrator.accepts) <= {FirstOrder, SecondOrder, VelocityForces}:
        return "it is given more than derivatives, and may treat one body or axis after the other"
    return _no_engine(trials)


@claim("permuted", _has_like_parts)
def _check_permuted(trials: Trials) -> Finding:
    parts = ", ".join(f"({', '.join(part)})" for part in trials.case.alike)
    return _check_related(trials, permuted(trials.case), f"the motion with the numbers of {parts} in turn")


def _dense_applies(trials: Trials) -> str | None:
    if trials.integrator.dense_order is None:
        return "it declares no order of its dense output (dense_order)"
    if trials.steps or trials.integrator.sampling != "dense output":
        return "its samples are not dense output of an adaptive method"
    return "events limit the order" if trials.case.hybrid is not None else None


@claim("dense", _dense_applies)
def _dense(trials: Trials) -> Finding:
    """The slope of the largest sample error over the mean length of a step, at the tightest tolerances.

    At looser tolerances the error of the steps hides the error of the interpolant.
    """
    order, dense = trials.integrator.order, trials.integrator.dense_order
    assert dense is not None
    expected = min(order or dense + 1, dense + 1)
    answers = [trials.short(SHORT - 3, tolerance) for tolerance in trials.settings if tolerance <= TIGHT]
    return slope_over_work([(answer, answer.error) for answer in answers], expected, "errors of samples")


def _goes_back(trials: Trials) -> str | None:
    if not isinstance(trials.integrator, FunctionAdapter):
        return "it is not a plain function, to which times that fall may be given"
    return None if trials.case.hybrid is None else "events may change the motion"


@claim("backward", _goes_back, once=True)
def _backward(trials: Trials) -> Finding:
    """Solve backwards in time: from the exact state at the end of a part of the span, at falling times, to its start.

    A solver that is written for rising times may return anything. It fails if its states continue the motion forward, or if
    it asked for derivatives at earlier times.
    """
    for halvings in range(BACK, SHORTEST):
        ahead, setting = trials.problem(halvings), trials.usual()
        setting = min(setting, float(ahead.interval)) if trials.steps else setting
        answer, allowed = trials.short(halvings, setting), NEAR * distance_covered(trials, halvings)
        if answer.error <= allowed:
            break
    else:
        return not_checked(f"no part of the span is followed at {trials.named(trials.usual())}")
    exact = np.concatenate([trials.start[None], trials.exact(halvings)])
    end, asked, most = float(ahead.times[-1]), list[float](), MOST_CALLS * max(answer.calls or 0, len(exact))
    problem = replace(ahead, form=_recording(ahead.form, asked), t0=end, times=end - ahead.times, most_calls=most)
    solution = trials.outcome(problem, setting, exact[-1]).solution
    if solution is None or solution.stopped is not None or not np.all(np.isfinite(solution.states)):
        return pass_claim("it declines")
    allowed += APART * answer.error
    states, named = solution.states[0], trials.named(setting)
    error = float(np.max(trials.distance(states, exact[-2::-1])))
    if error <= allowed:
        return pass_claim(f"{error:.2g}")
    ahead_too = float(np.max(trials.distance(states, trials.case.sample(end + ahead.times))))
    expected = f"the motion back to its start within {allowed:.2g}, or no states"
    if ahead_too <= allowed:
        return fail_claim(named, expected, f"the motion that goes on forward within {ahead_too:.2g}")
    if min(asked, default=end) < end / 2:
        return fail_claim(named, expected, f"{error:.2g}")
    return not_applicable("it does not solve where times fall: it asks for no derivative at an earlier time")


def _recording(form: Form | SceneForm, asked: list[float]) -> FirstOrder | SecondOrder:
    """The equations; the times at which they are evaluated are appended to `asked`."""
    assert isinstance(form, FirstOrder | SecondOrder)
    function = form.acceleration if isinstance(form, SecondOrder) else form.equations

    def recorded(t: Any, state: Values, parameters: Values) -> Values:
        asked.append(float(t))
        return function(t, state, parameters)

    return SecondOrder(recorded) if isinstance(form, SecondOrder) else FirstOrder(recorded)

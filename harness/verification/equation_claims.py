"""Claims without a case: motions that end, problems in between, more variables, sums of known result, a body in space."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import count
from math import cos, sqrt
from typing import Any

import numpy as np
from gnomon.cases.core.arithmetic import calling, written
from gnomon.cases.core.forms import FirstOrder, Form, SecondOrder, Values, first_order
from gnomon.cases.core.scene import Body, Force, Readings, Scene, SceneForm, Vector
from gnomon.harness.contract.integrator import Problem, Refused, Solution
from gnomon.harness.contract.velocity_forces import VelocityForces
from gnomon.harness.measuring.trials import HALF_ULP, Floats, Trials
from gnomon.harness.results.convergence_order import LARGEST_ERROR
from gnomon.harness.verification.call_claims import answers, same_bits
from gnomon.harness.verification.claims import Finding, Outcome, claim, fail_claim, not_applicable, pass_claim, within
from gnomon.harness.verification.convergence_claims import Point, same_solution, slope_of
from gnomon.harness.verification.fmu.adapter import FmuIntegrator
from gnomon.harness.verification.function_adapter import FunctionAdapter
from gnomon.harness.verification.quadrature_claim import ROUNDINGS
from gnomon.harness.verification.relation_claims import APART
from gnomon.harness.verification.structure_claims import DECLINED

SAMPLES, END, STEPS = 8, 2.0, 8
"""Number of samples, end time, and number of fixed steps between samples, of motions that end before 3/4 of it."""
DAMPED = 2.0
"""If q'' = 2^60 q grows to at most this many times its start, the method damps all fast growth."""
RESTING = 6
"""Number of variables at rest, before the moving ones: the first that moves is the seventh."""
LARGER = 2.0**13
"""Ratio of the variables at rest to the start, for fixed steps: an iteration that ends by the largest variable."""
MOST_CALLS = 10**5
"""Most right-hand sides of a plain function before a motion that ends: thousands suffice, but some solvers go on."""
SWINGS = 4
"""Least number of steps of an oscillator whose stiffness depends on the time: long steps show a stage at a wrong time."""
FREQUENCIES = np.array([1.0, 2.0, 3.0])
"""Frequencies of the springs, or of the forces, along the three axes: different ones, so that exchanged axes show."""
COUNTS = 2 ** np.arange(4, 12)
"""Numbers of steps in a time of 1; the finest show a time that is wrong by its fifth digit."""
STARTS = np.array([[-1.0, 2.0, -0.5, 1.0, 0.5, -2.0], [0.5, -0.75, 1.0, 1.0, 0.25, -0.5]])
"""Two starts that one engine solves in turn; the second one is compared with its exact motion."""
ADDED = 4
"""Half ulps that each step of an engine may add to the state: two roundings, which the motion at most doubles."""
SUMMED = 2**12
"""Number of samples, and least number of steps, of a sum that is compared with its exact value."""


def leaves(t: Any, place: Values, parameters: Values) -> Values:
    """q'' = -1 - q sqrt(q): from rest at q = 1, q falls below 0 before t = 1.5. There the root has no value: the motion ends."""
    (q,) = place
    return (-1 - q * sqrt(q),)


def pole(t: Any, place: Values, parameters: Values) -> Values:
    """Acceleration of q = 1/(1 - t)^2."""
    (q,) = place
    return (6 * q * q,)


def collision(t: Any, place: Values, parameters: Values) -> Values:
    """Acceleration of q = (1 - t)^(2/3): two bodies that meet."""
    (q,) = place
    return (-2 / (9 * q * q),)


def grows(t: Any, place: Values, parameters: Values) -> Values:
    """Acceleration of q = exp(2^30 t)."""
    (q,) = place
    return (2**60 * q,)


def swing(t: Any, place: Values, parameters: Values) -> Values:
    """Acceleration of an oscillator whose stiffness is 1 + (t - c)^2."""
    (q,), (c,) = place, parameters
    return (-q * (1 + (t - c) * (t - c)),)


def steady(t: Any, place: Values, parameters: Values) -> Values:
    """A constant acceleration. Each sum of 2/3 2^-12 and a velocity between 1 and 2 loses a third of an ulp."""
    (q,), (acceleration,) = place, parameters
    return (acceleration + 0 * q,)


@cache
def rests(variables: int) -> Callable[[Any, Values, Values], Values]:
    """Equations in which all variables stay constant."""
    where = f"<{__name__}, {variables} variables that rest>"
    return written(_zeros(variables), f"rests_{variables}", where, {"__name__": __name__})


def _zeros(variables: int) -> str:
    return f"({''.join(f'0 * state[{i}], ' for i in range(variables))})"


def takes_plain(trials: Trials) -> str | None:
    """The reason why the integrator does not accept the equations of a claim; None if it accepts them."""
    if isinstance(trials.integrator, FmuIntegrator):
        return "an FMU has its own equations"
    return None if {FirstOrder, SecondOrder} & set(trials.integrator.accepts) else "it takes no plain equations"


def takes_accelerations(trials: Trials) -> bool:
    """Whether the integrator accepts accelerations."""
    return SecondOrder in trials.integrator.accepts


def takes_velocities(trials: Trials) -> bool:
    """Whether the integrator is given equations of first order whose first half are the velocities."""
    return VelocityForces in trials.integrator.accepts and isinstance(trials.form, FirstOrder)


def plain_form(trials: Trials, acceleration: Callable[[Any, Values, Values], Values]) -> Form:
    """A form with these accelerations: of second order if the integrator accepts it, else of first order."""
    form = SecondOrder(acceleration)
    return form if takes_accelerations(trials) else first_order(form) or form


@claim("blow_up", lambda trials: takes_plain(trials) or answers(trials), once=True, no_answer=True)
def _blow_up(trials: Trials) -> Finding:
    """A solution must not be finite after its motion has ended.

    A fixed step may pass over a collision, and also over a pole if the method damps fast growth: these are left out.
    """
    motions = [("the domain of the equations ends", leaves, 0.0)]
    if not trials.steps:
        motions += [("a pole", pole, 2.0), ("a collision", collision, -2 / 3)]
    elif not abs(_last(trials, grows, 2.0**30)) <= DAMPED:
        motions.append(("a pole", pole, 2.0))
    for what, acceleration, rate in motions:
        last = _last(trials, acceleration, rate)
        if math.isfinite(last):
            return fail_claim(
                trials.named(END / SAMPLES / STEPS if trials.steps else trials.usual()),
                f"no finite state at t = {END:g}: {what} before t = {0.75 * END:g} from q = 1, q' = {rate:.3g}",
                f"q = {last:.3g}",
            )
    return pass_claim()


def _last(trials: Trials, acceleration: Callable[[Any, Values, Values], Values], rate: float) -> float:
    """q at the last sample, from q = 1; inf or nan without a solution there."""
    times = END * np.arange(1, SAMPLES + 1) / SAMPLES
    called = _limit_calls(acceleration) if isinstance(trials.integrator, FunctionAdapter) else acceleration
    problem = Problem(plain_form(trials, called), 2, np.zeros(0), times, 1.0)
    setting = times[0] / STEPS if trials.steps else trials.usual()
    solution = trials.outcome(problem, float(setting), np.array([1.0, rate])).solution
    lost = solution is None or solution.stopped is not None or not np.all(np.isfinite(solution.states[0, -1]))
    return math.nan if solution is None or lost else float(solution.states[0, -1, 0])


def _limit_calls(acceleration: Callable[[Any, Values, Values], Values]) -> Callable[[Any, Values, Values], Values]:
    """The function with a limit: after MOST_CALLS calls it raises Refused."""
    calls = count()

    def limited(t: Any, place: Values, parameters: Values) -> Values:
        if next(calls) >= MOST_CALLS:
            raise Refused(f"no answer after {MOST_CALLS} right-hand sides")
        return acceleration(t, place, parameters)

    return limited


@claim("other_problems", answers)
def _other_problems(trials: Trials) -> Finding:
    """A solution must not change when other problems are prepared and solved in between.

    The other problems begin at the start of the motion, and at its end at the last time, where a slope that was kept
    would be used. Their variables rest if plain equations are accepted; else they are the first half of the motion.
    """
    problem, setting = trials.problem(), trials.usual()
    plain = takes_plain(trials) is None
    with trials.prepared(problem, setting) as solver:
        alone = solver(trials.start[None]).states[0]
        for start, t0 in ((trials.start, problem.t0), (alone[-1], float(problem.times[-1]))):
            other = _at_rest(trials, t0) if plain else trials.problem(1)
            with trials.prepared(other, setting) as second:
                again = solver(trials.start[None]).states[0]
                finding = same_bits(trials, alone, again, "one start before and after another problem is prepared")
                if finding.outcome != Outcome.PASSED:
                    return finding
                solution = second((start if plain else trials.start)[None])
            if plain:
                finding = _check_rest(trials, other, start, solution)
                if finding.outcome != Outcome.PASSED:
                    return finding
        again = solver(trials.start[None]).states[0]
    return same_bits(trials, alone, again, "one start before and after another problem")


def _at_rest(trials: Trials, t0: float) -> Problem:
    """The problem of the case from the time `t0`, with equations in which nothing changes, or without accelerations."""
    problem = trials.problem()
    form = (
        SecondOrder(rests(problem.dimension // 2))
        if takes_accelerations(trials)
        else FirstOrder(rests(problem.dimension))
    )
    return replace(problem, form=form, t0=t0, times=problem.elapsed + t0, names=None)


def _check_rest(trials: Trials, problem: Problem, start: Floats, solution: Solution) -> Finding:
    """Whether the states stay at the start, or move on with its velocities."""
    half = len(start) // 2
    rates = np.append(start[half:], np.zeros(half)) if takes_accelerations(trials) else np.zeros_like(start)
    exact = start + problem.elapsed[:, None] * rates
    if not np.all(np.isfinite(start)) or not np.all(np.isfinite(solution.states)):
        return not_applicable(f"no solution of equations without motion: {solution.stopped or 'states are not finite'}")
    apart = float(np.max(np.abs(solution.states[0] - exact)))
    allowed = 2 * HALF_ULP * ROUNDINGS * (solution.steps or len(exact)) * float(np.max(np.abs(exact)))
    if apart <= allowed:
        return pass_claim()
    moves = "positions that move with their velocities" if takes_accelerations(trials) else "states that stay"
    where = "start" if problem.t0 == trials.problem().t0 else "end"
    expected = f"with f = 0, {moves} to within {allowed:.2g}, from the {where} of the motion solved before"
    return fail_claim(trials.named(trials.usual()), expected, f"off by {apart:.2g}")


def _few_variables(trials: Trials) -> str | None:
    if len(trials.start) > RESTING:
        return f"the case has more than {RESTING} variables itself"
    if not isinstance(trials.form, FirstOrder | SecondOrder) or takes_velocities(trials):
        return "it takes no plain equations"
    return takes_plain(trials) or (None if trials.case.hybrid is None else "its motion has events")


@claim("more_variables", _few_variables, once=True)
def _more_variables(trials: Trials) -> Finding:
    """Six variables at rest (positions, for accelerations), before the case's variables, must not change the motion.

    With a tolerance they are as large as the variables of the case, as the tolerance may be relative to the largest one.
    """
    form, second = _after_resting(trials.form)
    larger = LARGER if trials.steps else 1.0
    parts = np.split(trials.start, 1 + second)
    rest = larger * np.resize(parts[0], RESTING)
    start = np.concatenate([np.append(rest * (part is parts[0]), part) for part in parts])
    moving = np.tile(np.arange(RESTING + len(parts[0])) >= RESTING, len(parts))
    problem = replace(trials.problem(), form=form, dimension=len(start), groups=(), names=None)
    (states,) = trials.solutions(problem, trials.usual(), [start])
    moved = float(np.max(np.abs(states[:, ~moving] - start[~moving])))
    if not moved <= 2 * HALF_ULP * ROUNDINGS * len(states) * float(np.max(np.abs(start))):
        return fail_claim(
            trials.named(trials.usual()), "variables whose derivatives are 0 at rest", f"moved by {moved:.2g}"
        )
    what = f"the motion after {np.sum(~moving)} variables that rest"
    return same_solution(trials, states[:, moving], what, APART * larger, 0.5)


def _after_resting(form: FirstOrder | SecondOrder) -> tuple[Form, bool]:
    """The equations, with variables at rest before their own, and whether they are accelerations."""
    source = form.source if isinstance(form, FirstOrder) and isinstance(form.source, SecondOrder) else form
    second = isinstance(source, SecondOrder)
    function = source.acceleration if isinstance(source, SecondOrder) else source.equations
    after = calling(function, f"t, state[{RESTING}:], parameters", "after_resting", _zeros(RESTING))
    more = SecondOrder(after) if second else FirstOrder(after)
    return more if isinstance(form, SecondOrder) else first_order(more) or more, second


def _explain_structure(trials: Trials) -> str | None:
    if not {"symplectic", "reversible"} & set(trials.integrator.conserves):
        return "it declares neither symplectic nor reversible"
    return takes_plain(trials) if trials.steps else "its setting is a tolerance"


@claim("time_structure", _explain_structure, once=True)
def _time_structure(trials: Trials) -> Finding:
    """The map of a linear oscillator has determinant 1, and is its own way back if the stiffness is even in time."""
    turn = np.diag([1.0, -1.0])
    for steps in (SWINGS * 2 ** np.arange(DECLINED)).tolist():
        try:
            growing, even = (_swing_map(trials, c, 1 / steps) for c in (0.0, 0.5))
        except Refused:
            continue
        if not np.all(np.isfinite([growing, even])):
            continue
        defects = {
            "symplectic": abs(float(np.linalg.det(growing)) - 1),
            "reversible": float(np.max(np.abs(turn @ even @ turn @ even - np.eye(2)))),
        }
        allowed = 2 * HALF_ULP * ROUNDINGS * 2 * steps
        word = max(defects.keys() & set(trials.integrator.conserves), key=lambda each: defects[each])
        return within(allowed, defects[word], f"h = {1 / steps:.6g}", f"{word} to {allowed:.2g}")
    return not_applicable("no solution with finite states at its longest steps")


def _swing_map(trials: Trials, c: float, setting: float) -> Floats:
    """The matrix (2, 2) of the motion of `swing` over a time of 1."""
    times = np.arange(1, SWINGS + 1) / SWINGS
    problem = Problem(plain_form(trials, swing), 2, np.array([c]), times, 1.0)
    return np.array([states[-1] for states in trials.solutions(problem, setting, list(np.eye(2)))]).T


def _explain_sum(trials: Trials) -> str | None:
    return takes_plain(trials) if trials.integrator.compensated else "it does not declare that its sums are compensated"


@claim("compensated", _explain_sum, once=True)
def _check_compensation(trials: Trials) -> Finding:
    """Thousands of equal changes: each addition loses a third of a unit in the last place."""
    return compensates(trials)


def compensates(trials: Trials, end: bool = False) -> Finding:
    """The claim `compensated`; with `end` the end is the only sample."""
    problem, start = _sum(trials)
    setting = problem.interval if trials.steps else trials.usual()
    problem = replace(problem, times=problem.times[-1 if end else 0 :])
    ((solution, calls),) = trials.solved(problem, setting, [start])
    work = solution.steps or calls
    if work < SUMMED:
        return not_applicable(f"{work} steps, {SUMMED} are needed for a law of round-off")
    error = float(np.max(np.abs(solution.states[0, :, -1] - (1 + problem.times * problem.parameters[-1]))))
    allowed = 2 * HALF_ULP * (2 + ROUNDINGS * problem.parameters[-1])
    what = f"an error of a sum of {work} changes below {allowed:.2g}"
    return within(allowed, error, trials.named(setting), what)


def _sum(trials: Trials) -> tuple[Problem, Floats]:
    """The problem of a velocity 1 + 2/3 t to t = 1, and its start."""
    times = np.arange(1, SUMMED + 1) / SUMMED
    form, counted = plain_form(trials, steady), trials.integrator.counts_rhs
    return Problem(form, 2, np.array([2 / 3]), times, 1.0, counted=counted), np.array([0.0, 1.0])


def springs(t: float, position: Vector, velocity: Vector) -> Vector:
    x, y, z = position
    return -x, -4 * y, -9 * z


def pushes(t: float, position: Vector, velocity: Vector) -> Vector:
    return cos(t), cos(2 * t), cos(3 * t)


def _scene(token: str) -> SceneForm:
    law = springs if token == "position_force" else pushes

    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        x, y, z, u, v, w = state
        body = Body("body", 1.0, (0.0, 0.0, 0.0), (x, y, z), velocity=(u, v, w))
        return Scene((0.0, 0.0, 0.0), (body,), forces=(Force("body", token, law),))

    def observe(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
        position, _, velocity, _ = readings.bodies["body"]
        return *position, *velocity

    return SceneForm(build, observe, frozenset({token}), conservative=token == "position_force")


def _exact(token: str, t: float) -> Floats:
    place, speed = np.split(STARTS[1], 2)
    w = FREQUENCIES
    c, s = np.cos(w * t), np.sin(w * t)
    if token == "position_force":
        return np.concatenate([place * c + speed * s / w, speed * c - place * w * s])
    return np.concatenate([place + speed * t + (1 - c) / w**2, speed + s / w])


def _is_engine(trials: Trials) -> str | None:
    if SceneForm not in trials.integrator.accepts or not trials.steps:
        return "it is not an engine that takes scenes"
    return "it declares no order" if trials.integrator.order is None else None


@claim("scene", _is_engine, once=True)
def _scenes(trials: Trials) -> Finding:
    overall = not_applicable("it takes neither forces of position nor forces of time")
    for token, what in (("position_force", "springs"), ("time_force", "forces of time")):
        if trials.integrator.unsupported(_scene(token)) is not None:
            continue
        points = _points(trials, token)
        if points and points[-1][0] == 1 / COUNTS[-1] and not points[-1][1] < LARGEST_ERROR:
            expected = f"an error of a body under {what} below {LARGEST_ERROR:g}, as of order 1"
            return fail_claim(f"h = {points[-1][0]:.3g}", expected, f"{points[-1][1]:.2g}")
        finding = slope_of(points, trials.order, f"errors of a body under {what}")
        if finding.outcome == Outcome.FAILED:
            return finding
        if overall.outcome != Outcome.PASSED:
            overall = finding
    return overall


def _points(trials: Trials, token: str) -> list[Point]:
    times = np.arange(1, SWINGS + 1) / SWINGS
    exact = np.array([_exact(token, t) for t in times])
    points: list[Point] = []
    for steps in COUNTS.tolist():
        problem = Problem(_scene(token), STARTS.shape[1], np.zeros(0), times, 1.0)
        try:
            states = trials.solutions(problem, 1 / steps, list(STARTS))[1]
        except Refused:
            continue
        error = float(np.max(np.abs(states - exact)) / np.max(np.abs(exact)))
        roundoff = ADDED * HALF_ULP * steps
        points.append((1 / steps, error, roundoff))
        if error < roundoff:
            break
    return points

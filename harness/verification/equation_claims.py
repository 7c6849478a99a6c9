"""Claims on equations without a case: motions that end, problems in between, more variables, sums of known result."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import count
from math import sqrt
from typing import Any

import numpy as np
from gnomon.cases.core.arithmetic import calling, written
from gnomon.cases.core.forms import FirstOrder, Form, SecondOrder, Values, first_order
from gnomon.harness.contract.integrator import Problem, Refused, Solution
from gnomon.harness.verification.call_claims import answers, same_bits
from gnomon.harness.verification.claims import Finding, Outcome, claim, failed, not_applicable, passed
from gnomon.harness.verification.convergence_claims import same_solution
from gnomon.harness.verification.function_adapter import FunctionAdapter
from gnomon.harness.verification.quadrature_claim import ROUNDINGS
from gnomon.harness.verification.relation_claims import APART
from gnomon.harness.verification.trials import HALF_ULP, Floats, Trials

SAMPLES, END, STEPS = 8, 2.0, 8
"""Number of samples, end time, and number of fixed steps between samples, of motions that end before 3/4 of it."""
DAMPED = 2.0
"""If q'' = 2^60 q grows to at most this many times its start, the method damps all fast growth."""
RESTING = 6
"""Number of variables at rest, before the moving ones: the first that moves is the seventh."""
MOST_CALLS = 10**5
"""Most right-hand sides of a plain function before a motion that ends: thousands suffice, but some solvers go on."""
SUMMED = 2**12
"""Number of samples, and least number of steps, of a sum that is compared with its exact value."""


def leaves(t: Any, place: Values, parameters: Values) -> Values:
    """Acceleration of a motion that ends: from q = 1 at rest, q is 0 before t = 1.5, where the root has no value."""
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


def steady(t: Any, place: Values, parameters: Values) -> Values:
    """A constant acceleration. A 2^-12th of 2/3, added to a velocity from 1 to 2, loses a third of an ulp."""
    (q,), (acceleration,) = place, parameters
    return (acceleration + 0 * q,)


@cache
def rests(variables: int) -> Callable[[Any, Values, Values], Values]:
    """Equations in which all variables stay constant."""
    return written(
        _zeros(variables),
        f"rests_{variables}",
        f"<{__name__}, {variables} variables that rest>",
        {"__name__": __name__},
    )


def _zeros(variables: int) -> str:
    return f"({''.join(f'0 * state[{i}], ' for i in range(variables))})"


def _plain(trials: Trials) -> str | None:
    return None if {FirstOrder, SecondOrder} & set(trials.integrator.accepts) else "it takes no plain equations"


def _second(trials: Trials) -> bool:
    """Whether the integrator accepts accelerations."""
    return SecondOrder in trials.integrator.accepts


def _form(trials: Trials, acceleration: Callable[[Any, Values, Values], Values]) -> Form:
    form = SecondOrder(acceleration)
    return form if _second(trials) else first_order(form) or form


@claim("blow_up", lambda trials: _plain(trials) or answers(trials), once=True, no_answer=True)
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
            return failed(
                _named(trials),
                f"no finite state at t = {END:g}: {what} before t = {0.75 * END:g} from q = 1, q' = {rate:.3g}",
                f"q = {last:.3g}",
            )
    return passed()


def _named(trials: Trials) -> str:
    return trials.named(END / SAMPLES / STEPS if trials.steps else trials.usual())


def _last(trials: Trials, acceleration: Callable[[Any, Values, Values], Values], rate: float) -> float:
    """q at the last sample, from q = 1; inf or nan without a solution there."""
    times = END * np.arange(1, SAMPLES + 1) / SAMPLES
    called = _limited(acceleration) if isinstance(trials.integrator, FunctionAdapter) else acceleration
    problem = Problem(_form(trials, called), 2, np.zeros(0), times, 1.0)
    setting = times[0] / STEPS if trials.steps else trials.usual()
    solution = trials.outcome(problem, float(setting), np.array([1.0, rate])).solution
    lost = solution is None or solution.stopped is not None or not np.all(np.isfinite(solution.states[0, -1]))
    return math.nan if solution is None or lost else float(solution.states[0, -1, 0])


def _limited(acceleration: Callable[[Any, Values, Values], Values]) -> Callable[[Any, Values, Values], Values]:
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
    plain = _plain(trials) is None
    with trials.prepared(problem, setting) as solver:
        alone = solver(trials.start[None]).states[0]
        for start, t0 in ((trials.start, problem.t0), (alone[-1], float(problem.times[-1]))):
            other = _at_rest(trials, t0) if plain else trials.problem(1)
            with trials.prepared(other, setting) as second:
                again = solver(trials.start[None]).states[0]
                found = same_bits(trials, alone, again, "one start before and after another problem is prepared")
                if found.outcome != Outcome.PASSED:
                    return found
                solution = second((start if plain else trials.start)[None])
            if plain:
                found = _rested(trials, other, start, solution)
                if found.outcome != Outcome.PASSED:
                    return found
        again = solver(trials.start[None]).states[0]
    return same_bits(trials, alone, again, "one start before and after another problem")


def _at_rest(trials: Trials, t0: float) -> Problem:
    """The problem of the case from the time `t0`, with equations in which nothing changes, or without accelerations."""
    problem = trials.problem()
    form = SecondOrder(rests(problem.dimension // 2)) if _second(trials) else FirstOrder(rests(problem.dimension))
    return replace(problem, form=form, t0=t0, times=problem.elapsed + t0, names=None)


def _rested(trials: Trials, problem: Problem, start: Floats, solution: Solution) -> Finding:
    """Whether the states stay at the start, or move on with its velocities."""
    half = len(start) // 2
    rates = np.append(start[half:], np.zeros(half)) if _second(trials) else np.zeros_like(start)
    exact = start + problem.elapsed[:, None] * rates
    if not np.all(np.isfinite(start)) or not np.all(np.isfinite(solution.states)):
        return not_applicable(f"no solution of equations without motion: {solution.stopped or 'states are not finite'}")
    apart = float(np.max(np.abs(solution.states[0] - exact)))
    allowed = 2 * HALF_ULP * ROUNDINGS * (solution.steps or len(exact)) * float(np.max(np.abs(exact)))
    if apart <= allowed:
        return passed(f"{apart:.2g}")
    from_where = f"from the {'start' if problem.t0 == trials.problem().t0 else 'end'} of the motion solved before"
    return failed(
        trials.named(trials.usual()), f"equations without motion {from_where} followed to {allowed:.2g}", f"{apart:.2g}"
    )


def _few_variables(trials: Trials) -> str | None:
    if len(trials.start) > RESTING:
        return f"the case has more than {RESTING} variables itself"
    if not isinstance(trials.form, FirstOrder | SecondOrder):
        return "it takes no plain equations"
    return _plain(trials) or (None if trials.case.hybrid is None else "its motion has events")


@claim("more_variables", _few_variables, once=True)
def _more_variables(trials: Trials) -> Finding:
    """Six variables at rest (positions, for accelerations), before the case's variables, must not change the motion."""
    form, second = _after_resting(trials.form)
    parts = np.split(trials.start, 1 + second)
    start = np.concatenate([np.append(np.resize(part, RESTING) * (part is parts[0]), part) for part in parts])
    moving = np.tile(np.arange(RESTING + len(parts[0])) >= RESTING, len(parts))
    problem = replace(trials.problem(), form=form, dimension=len(start), groups=(), names=None)
    (states,) = trials.solutions(problem, trials.usual(), [start])
    moved = float(np.max(np.abs(states[:, ~moving] - start[~moving])))
    if not moved <= 2 * HALF_ULP * ROUNDINGS * len(states) * float(np.max(np.abs(start))):
        return failed(
            trials.named(trials.usual()), "variables whose derivatives are 0 at rest", f"moved by {moved:.2g}"
        )
    what = f"the motion after {np.sum(~moving)} variables that rest"
    return same_solution(trials, states[:, moving], what, APART, 0.5)


def _after_resting(form: FirstOrder | SecondOrder) -> tuple[Form, bool]:
    """The equations, with variables at rest before their own, and whether they are accelerations."""
    given = form.source if isinstance(form, FirstOrder) and isinstance(form.source, SecondOrder) else form
    second = isinstance(given, SecondOrder)
    function = given.acceleration if isinstance(given, SecondOrder) else given.equations
    after = calling(function, f"t, state[{RESTING}:], parameters", "after_resting", _zeros(RESTING))
    more = SecondOrder(after) if second else FirstOrder(after)
    return more if isinstance(form, SecondOrder) else first_order(more) or more, second


def _summed(trials: Trials) -> str | None:
    return _plain(trials) if trials.integrator.compensated else "it does not declare that its sums are compensated"


@claim("compensated", _summed, once=True)
def _compensated(trials: Trials) -> Finding:
    """Thousands of equal changes: each addition loses a third of a unit in the last place."""
    problem, start = _sum(trials)
    setting = problem.interval if trials.steps else trials.usual()
    ((solution, calls),) = trials.solved(problem, setting, [start])
    work = solution.steps or calls
    if work < SUMMED:
        return not_applicable(f"{work} steps, {SUMMED} are needed for a law of round-off")
    error = float(np.max(np.abs(solution.states[0, :, -1] - (1 + problem.times * problem.parameters[-1]))))
    allowed = 2 * HALF_ULP * (2 + ROUNDINGS * problem.parameters[-1])
    if error <= allowed:
        return passed(f"{error:.2g}")
    what = f"an error of a sum of {work} changes below {allowed:.2g}"
    return failed(trials.named(setting), what, f"{error:.2g}")


def _sum(trials: Trials) -> tuple[Problem, Floats]:
    """The problem of a velocity 1 + 2/3 t to t = 1, and its start."""
    times = np.arange(1, SUMMED + 1) / SUMMED
    form, counted = _form(trials, steady), trials.integrator.counts_rhs
    return Problem(form, 2, np.array([2 / 3]), times, 1.0, counted=counted), np.array([0.0, 1.0])

"""Claims about step-size control: many samples in each step against few, and the norm of the error estimate."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from math import cos
from typing import Any

import numpy as np
from gnomon.cases.core.arithmetic import written
from gnomon.cases.core.forms import FirstOrder, Form, SecondOrder, Values
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.measuring.solved import Solved
from gnomon.harness.measuring.trials import HALF_ULP, SHORT, Floats, Trials
from gnomon.harness.results.convergence_order import LARGEST_ERROR
from gnomon.harness.verification.claims import Finding, claim, fail_claim, not_applicable, pass_claim
from gnomon.harness.verification.equation_claims import plain_form, takes_accelerations, takes_plain
from gnomon.harness.verification.quadrature_claim import ROUNDINGS

LOOSE, TIGHT = 1e-4, 1e-6
"""Tolerances; the nearest ones of the sweep are used. Errors are far above round-off, and steps are few."""
MOST_CALLS = 600
"""Right-hand sides at the loose tolerance, above which the tight one is not used: a low order, or a wrong estimate."""
FEW, MANY = 8, 2048
"""Numbers of samples: about one in four steps, and tens in each step."""
FIRST_FREQUENCY, LEAST_FREQUENCY, MOST_FREQUENCY = 8.0, 1.0, 64.0
"""Frequencies of the wave. The steps at the first one give the frequency of the other waves, within the limits."""
WANTED, CALLS = 32, 3
"""Desired number of steps in the span of the wave; assumed right-hand sides in a step if steps are not counted."""
SPAN = 2.0
"""The wave's times are from 0 to 2: its period at the end is three times the period at the start."""
WORSE = 10.0
"""Largest ratio of the error at many samples to the error at few."""
RESOLVED = 20
"""Least number of samples in a step that distinguishes a jump from a smooth error."""
JUMP = 0.5
"""Largest change of the error between neighbouring samples, as a share of the largest error."""
VARIABLES, FREQUENCY, END = 6, 20.0, 0.5
"""Number of variables (positions, for accelerations), frequency of the fast one, end time: 1.6 periods."""
SLOW = 0.1
"""Rate of decay of all variables; frequency of the slow ones, for accelerations."""
LARGE = 1000.0
"""Size of the large variable; the others have size 1."""
GROWTH = math.e
"""The largest growth of an error in these variables: exp(p/20 (sin - sin)), p/20 = 1/2; 1 for oscillators."""
APART = 10.0
"""Largest ratio of the errors when equal variables are arranged in two ways."""


def wave(t: Any, place: Values, parameters: Values) -> Values:
    """Acceleration of q = sqrt(1 + t) cos(w log(1 + t)); the parameter is w^2 + 1/4."""
    (q,), (stiffness,) = place, parameters
    return (-stiffness * q / ((1 + t) * (1 + t)),)


@dataclass(frozen=True)
class _Motion:
    """A problem with a known motion: `exact` gives its states (n, dim) at times; errors are divided by `sizes`."""

    problem: Problem
    start: Floats
    exact: Callable[[Floats], Floats]
    sizes: Floats

    def solved(self, trials: Trials, tolerance: float, samples: int) -> tuple[Solved, Floats]:
        """(outcome, errors (samples, dim)) at equally spaced samples; nan without a solution."""
        span = self.problem.times[-1] - self.problem.t0
        times = self.problem.t0 + span * np.arange(1, samples + 1) / samples
        outcome = trials.outcome(replace(self.problem, times=times), tolerance, self.start)
        if outcome.solution is None:
            return outcome, np.full((samples, len(self.start)), np.nan)
        return outcome, (outcome.solution.states[0] - self.exact(times)) / self.sizes


def _waves(trials: Trials, frequency: float) -> _Motion:
    """The wave of a frequency, from q = 1 and q' = 1/2."""
    w, times, counted = frequency, np.array([SPAN]), trials.integrator.counts_rhs
    problem = Problem(plain_form(trials, wave), 2, np.array([w * w + 0.25]), times, 1 / w, counted=counted)

    def exact(times: Floats) -> Floats:
        root, angle = np.sqrt(1 + times), w * np.log(1 + times)
        return np.stack([root * np.cos(angle), (np.cos(angle) / 2 - w * np.sin(angle)) / root], axis=1)

    return _Motion(problem, np.array([1.0, 0.5]), exact, np.full(2, max(w, math.sqrt(1 + SPAN))))


def _usable(trials: Trials, solve: Callable[[float], Solved]) -> tuple[float, Solved]:
    """(tolerance, its outcome): the tight tolerance, or the loose one if it already takes many right-hand sides."""
    loose, tight = (min(trials.settings, key=lambda s: abs(math.log(s / wanted))) for wanted in (LOOSE, TIGHT))
    outcome = solve(loose)
    return (loose, outcome) if MOST_CALLS < _steps(outcome, 1) < math.inf else (tight, solve(tight))


def _tolerance(trials: Trials) -> str | None:
    return "its setting is a step size" if trials.steps else None


def _steps(outcome: Solved, calls: int = CALLS) -> float:
    """The number of steps, or of right-hand sides over `calls`; infinite if nothing was counted."""
    steps = None if outcome.solution is None else outcome.solution.steps
    return steps or (outcome.calls or math.inf) / calls


def _resolve_wave(trials: Trials) -> tuple[float, _Motion | None]:
    """(tolerance, motion): a wave of about WANTED steps, or an eighth of the case's span if there is no solution of a wave.

    A program, for example, may know cases only by their names. The motion is None if this case has events, as a motion has
    corners there.
    """
    tolerance = TIGHT
    if takes_plain(trials) is None:
        first = _waves(trials, FIRST_FREQUENCY)
        tolerance, outcome = _usable(trials, lambda tolerance: first.solved(trials, tolerance, 1)[0])
        if outcome.solution is not None:
            steps = _steps(outcome)
            frequency = FIRST_FREQUENCY * (WANTED / steps if math.isfinite(steps) else 1.0)
            return tolerance, _waves(trials, min(max(frequency, LEAST_FREQUENCY), MOST_FREQUENCY))
    if trials.case.hybrid is not None:
        return tolerance, None
    problem = trials.problem(SHORT - 3, counted=trials.integrator.counts_rhs)
    motion = _Motion(problem, trials.start, trials.case.sample, trials.reference.sizes)
    return _usable(trials, lambda tolerance: motion.solved(trials, tolerance, 1)[0])[0], motion


@claim("many_samples", _tolerance, once=True)
def _many_samples(trials: Trials) -> Finding:
    """Whether tens of samples in each step have errors as small as one sample in several steps, and errors without jumps.

    If each sample ends a step, the errors of many samples are compared with the error of a single sample at the end.
    """
    tolerance, motion = _resolve_wave(trials)
    if motion is None:
        return not_applicable("it takes no plain equations, and between events a motion has corners")
    (few, sparse), (many, dense) = (motion.solved(trials, tolerance, samples) for samples in (FEW, MANY))
    samples = FEW
    added = (many.calls or _steps(many)) - (few.calls or _steps(few))
    if trials.integrator.sampling != "dense output" and MANY - FEW <= added < math.inf:
        samples, (few, sparse) = 1, motion.solved(trials, tolerance, 1)
    for outcome in (few, many):
        if outcome.solution is None or outcome.solution.stopped:
            why = outcome.reason if outcome.solution is None else outcome.solution.stopped
            return not_applicable(f"no solution at {trials.named(tolerance)}: {why}")
    before, error = (float(np.max(np.abs(errors))) for errors in (sparse, dense))
    if not before < LARGEST_ERROR:
        return not_applicable(f"{samples} samples have no error below {LARGEST_ERROR:g} at {trials.named(tolerance)}")
    least = max(tolerance, 2 * HALF_ULP * ROUNDINGS * (many.calls or MANY))
    more = 1.0 if trials.integrator.order is not None else _steps(many) / _steps(few)
    allowed = WORSE * max(before, least) * (max(more, 1.0) if math.isfinite(more) else 1.0)
    setting = f"{trials.named(tolerance)}, {MANY} samples"
    if not error <= allowed:
        return fail_claim(
            setting, f"an error below {allowed:.2g}, as at {samples} of them ({before:.2g})", f"{error:.2g}"
        )
    jump = float(np.max(np.abs(np.diff(dense, axis=0))))
    if RESOLVED * _steps(few) > MANY or jump <= max(JUMP * error, least):
        return pass_claim(f"{error:.2g}, at {samples} {before:.2g}")
    expected = f"an error that changes by less than {JUMP * error:.2g} from sample to sample"
    return fail_claim(setting, expected, f"{jump:.2g}: the samples jump at the ends of steps")


@dataclass(frozen=True)
class _Arrangement:
    """The places of the fast variables, and the sizes of all variables, with their signs."""

    fast: tuple[int, ...]
    sizes: tuple[float, ...]

    def __str__(self) -> str:
        text = " and ".join(str(k + 1) for k in self.fast)
        text = f"only {text} of {VARIABLES} variables fast"
        if len(self.fast) > 1:
            return f"{text}, with opposite signs"
        large = [k + 1 for k, size in enumerate(self.sizes) if size == LARGE]
        return f"{text}, variable {large[0]} {LARGE:g} times as large" if large else text


def _sizes(changed: dict[int, float]) -> tuple[float, ...]:
    return tuple(changed.get(k, 1.0) for k in range(VARIABLES))


PLACES = range(VARIABLES)
ALONE = [_Arrangement((k,), _sizes({})) for k in PLACES]
BESIDE = [_Arrangement((k,), _sizes({j: LARGE})) for k in PLACES for j in PLACES if j != k]
OPPOSITE = [_Arrangement((0, 1), _sizes({1: -1.0}))]


@cache
def _separate(accelerations: bool) -> Form:
    """Equations in which each variable has its own rate, a parameter, and no variable changes another one."""
    rates = [
        f"-parameters[{k}]" if accelerations else f"(parameters[{k}] * cos({FREQUENCY} * t) - {SLOW})" for k in PLACES
    ]
    value = f"({', '.join(f'{rate} * state[{k}]' for k, rate in zip(PLACES, rates, strict=True))})"
    name = "oscillators" if accelerations else "rates"
    function = written(value, f"separate_{name}", f"<{__name__}, {name}>", {"__name__": __name__, "cos": cos})
    return SecondOrder(function) if accelerations else FirstOrder(function)


def _solve_arranged(trials: Trials, arrangement: _Arrangement, tolerance: float) -> tuple[Solved, float, float]:
    """(outcome, error of the fast variables at the end, largest number of the state at the start or at the end)."""
    accelerations, sizes = takes_accelerations(trials), np.array(arrangement.sizes)
    fast = np.isin(PLACES, arrangement.fast)
    if accelerations:
        frequencies = np.where(fast, FREQUENCY, SLOW)
        parameters, start = frequencies**2, np.append(sizes, 0 * sizes)
        exact, largest = sizes * np.cos(frequencies * END), max(float(np.max(np.abs(sizes))), FREQUENCY)
    else:
        parameters, start = np.where(fast, FREQUENCY / 2, 0.0), sizes
        exact = sizes * np.exp(np.where(fast, math.sin(FREQUENCY * END) / 2, 0.0) - SLOW * END)
        largest = GROWTH * float(np.max(np.abs(sizes)))
    problem = Problem(
        _separate(accelerations), len(start), parameters, np.array([END]), 1 / FREQUENCY,
        counted=trials.integrator.counts_rhs,
    )  # fmt: skip
    outcome = trials.outcome(problem, tolerance, start)
    if outcome.solution is None:
        return outcome, math.nan, largest
    errors = np.abs(outcome.solution.states[0, -1, :VARIABLES] - exact)
    return outcome, float(np.max(errors[fast])), largest


@claim("error_norm", lambda trials: _tolerance(trials) or takes_plain(trials), once=True)
def _error_norm(trials: Trials) -> Finding:
    """Whether the error of a fast variable is bounded and equal at each place, also beside a large variable.

    A third group has two fast variables with opposite signs.
    """
    tolerance, _ = _usable(trials, lambda tolerance: _solve_arranged(trials, ALONE[0], tolerance)[0])
    for group in (ALONE, BESIDE, OPPOSITE):
        errors = []
        for arrangement in group:
            outcome, error, largest = _solve_arranged(trials, arrangement, tolerance)
            if outcome.solution is None or outcome.solution.stopped:
                why = outcome.reason if outcome.solution is None else outcome.solution.stopped
                return not_applicable(f"no solution with {arrangement} at {trials.named(tolerance)}: {why}")
            steps = _steps(outcome, 1)
            if math.isinf(steps) and group != BESIDE and not error < LARGEST_ERROR:
                return not_applicable(f"no error below {LARGEST_ERROR:g}, and no number of steps that would bound it")
            allowed = steps * math.sqrt(outcome.solution.states.shape[2]) * tolerance * largest * GROWTH
            if not error <= allowed:
                expected = f"an error below {allowed:.2g}, with {arrangement}"
                return fail_claim(trials.named(tolerance), expected, f"{error:.2g} with {steps:.0f} steps at most")
            errors.append(error)
        least, worst = min(errors), int(np.argmax(errors))
        allowed = APART * max(least, tolerance)
        if errors[worst] > allowed:
            expected = f"an error below {allowed:.2g} with {group[worst]}, as with other places of these variables"
            return fail_claim(trials.named(tolerance), f"{expected} ({least:.2g})", f"{errors[worst]:.2g}")
    return pass_claim()

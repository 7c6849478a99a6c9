"""Runs an integrator on one case for the claims: each solution is computed once, with a bound of its rounding errors."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.forms import Constrained
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Integrator, Problem, Solution, Steps
from gnomon.harness.contract.problem import find_accepted_form
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.measuring.reference_solution import CaseSpec, ReferenceSolution, reference_solution
from gnomon.harness.measuring.score import Scorer, moves
from gnomon.harness.measuring.settings import sweep_settings
from gnomon.harness.measuring.shorter_spans import error_growth, exact_states
from gnomon.harness.measuring.solved import Solved, solve_within
from gnomon.harness.system.child_process import processor_time
from numpy.typing import NDArray

Floats = NDArray[np.float64]

HALF_ULP = 2.0**-53
ROOT_OF_ULP = 2.0**-26
SHORTEST = 24
"""Largest number of halvings of the span."""
SHORT = 6
"""Halvings of the span for `proportional` and `order_short`: one sampling interval of the whole span."""
SHORT_SPANS = (SHORT, SHORT - 1, SHORT - 2)
"""Halvings of the span for `tolerance_short`."""
TIGHT = 1e-4
"""Largest tolerance of the claims: at looser tolerances a correct estimate of a local error may be far from the error."""
CALLS = 20.0
"""A plain function is given up after this number of right-hand sides for each step that `Trials.limited` expects and each
component of the state. Correct pairs, extrapolation, multistep, implicit and Rosenbrock methods took at most 3.9."""
COUNTS = 6
"""Least number of different counts from which the right-hand sides of a step are found. All 5 differences have a factor
2 by chance with a probability of 1/32."""


@dataclass(frozen=True)
class Extent:
    """The most that a solution takes: fixed steps, and processor seconds after which no harder setting is solved."""

    steps: int
    seconds: float


@dataclass(frozen=True)
class Answer:
    """The outcome of one call of `solve`: states (samples, dim), or the status and the reason of a failure.

    `errors` (samples,): distances from the exact motion. `roundoff`: the error that rounding may cause, see
    `Trials.roundoff`. `work`: the number of steps, or of right-hand sides if steps are unknown (`steps` False).
    `seconds`: processor time.
    """

    setting: float
    status: Status
    reason: str = ""
    states: Floats | None = None
    errors: Floats = field(default_factory=lambda: np.full(1, math.nan))
    roundoff: float = math.nan
    work: int | None = None
    calls: int | None = None
    steps: bool = False
    stopped: str | None = None
    events: tuple[tuple[float, str], ...] | None = None
    seconds: float = 0.0

    @property
    def error(self) -> float:
        """The largest error, nan without finite states."""
        return float(np.max(self.errors)) if np.all(np.isfinite(self.errors)) else math.nan

    @property
    def last(self) -> float:
        """The error at the last sample."""
        return float(self.errors[-1])

    @property
    def refused(self) -> bool:
        return self.status in (Status.REFUSED, Status.UNSUPPORTED)

    @property
    def declined(self) -> bool:
        """Whether the integrator refused, stopped early or raised."""
        return self.status != Status.OK or self.stopped is not None

    @property
    def why(self) -> str:
        return self.reason or self.stopped or "states are not finite"


class Trials:
    """One integrator on one case. `case` has binary64 numbers, and `reference` is its reference solution.

    `moving`: whether a solution that rests although the exact motion moves is refused. A panel refuses it; a claim names
    its fault. `longest`: processor seconds after which a call is given up.
    """

    moving, longest = False, math.inf

    def __init__(self, integrator: Integrator, case: Case, reference: ReferenceSolution, extent: Extent) -> None:
        self.integrator, self.case, self.reference, self.extent = integrator, case, reference, extent
        self.scorer = Scorer(case, None, reference)
        self.start: Floats = reference.start
        self._answers: dict[tuple[int, float, bool], Answer] = {}
        self._growth: dict[int, Floats] = {}
        self._exact: dict[int, Floats] = {0: reference.exact}

    @property
    def order(self) -> int:
        """The order that the integrator declares; only for claims that it makes."""
        assert self.integrator.order is not None
        return self.integrator.order

    @property
    def longest_step(self) -> float:
        """The largest step size of the sweep (s); only for integrators with fixed steps."""
        assert isinstance(self.integrator.sweep, Steps)
        return self.integrator.sweep.coarsest * float(self.reference.time_scale)

    @classmethod
    def of(cls, integrator: Integrator, spec: CaseSpec, extent: Extent) -> Trials:
        return cls(integrator, spec.build()[0], reference_solution(spec), extent)

    @property
    def steps(self) -> bool:
        return isinstance(self.integrator.sweep, Steps)

    @cached_property
    def form(self) -> Any:
        return find_accepted_form(self.case, self.integrator.accepts)

    @cached_property
    def settings(self) -> tuple[float, ...]:
        """The settings of the sweep within the extent, from cheap to expensive."""
        settings = sweep_settings(self.integrator, self.case, self.problem())
        span = float(self.reference.times[-1])
        return tuple(s for s in settings if span / s < self.extent.steps * 1.01) if self.steps else settings

    def problem(self, halvings: int = 0, counted: bool = False, end: bool = False) -> Problem:
        """The problem over the span divided by 2^halvings; with `end`, its only sample is at the end."""
        problem = self.scorer.problem(self.form, counted)
        return replace(problem, times=(problem.times[-1:] if end else problem.times) * 2.0**-halvings)

    @property
    def counting(self) -> Problem:
        """The problem of `whole`, whose equations are compiled: it counts right-hand sides if the integrator does."""
        return self.problem(counted=self.integrator.counts_rhs)

    def answers(self) -> list[Answer]:
        """The answers over the whole span, up to the first setting that takes longer than the extent allows."""
        answers: list[Answer] = []
        for setting in self.settings:
            answers.append(self.whole(setting))
            if answers[-1].seconds > self.extent.seconds and getattr(self.integrator, "compiles", False):
                answers[-1] = self._answers[0, setting, False] = self._answer(setting, 0, False)
            if answers[-1].seconds > self.extent.seconds:
                break
        return answers

    def whole(self, setting: float) -> Answer:
        return self.short(0, setting)

    def short(self, halvings: int, setting: float, end: bool = False) -> Answer:
        """The answer over the span divided by 2^halvings, at 64 samples or, with `end`, at its end."""
        key = (halvings, setting, end)
        if key not in self._answers:
            self._answers[key] = self._answer(setting, halvings, end)
        return self._answers[key]

    def single_steps(self) -> list[tuple[float, Answer]]:
        """(step size, answer) with one step a sample, over shorter and shorter spans until round-off dominates."""
        sweep, answers = self.integrator.sweep, []
        assert isinstance(sweep, Steps)
        for halvings in range(SHORTEST):
            interval = float(self.problem(halvings).interval)
            if interval > sweep.coarsest * self.reference.time_scale:
                continue
            answer = self.short(halvings, interval)
            answers.append((interval, answer))
            if answer.error < answer.roundoff or answer.declined:
                break
        return answers

    def usual(self) -> float:
        """A setting from the middle of the sweep."""
        return self.settings[len(self.settings) // 2]

    def named(self, setting: float) -> str:
        """A setting as text."""
        return f"h = {setting:.6g}" if self.steps else f"tolerance {setting:g}"

    def roundoff(self, work: int, halvings: int = 0) -> float:
        """The largest error that `work` roundings of the state may cause; each has the effect of an ulp at the start.

        This bound adds the effects linearly. The conditioning of a case is the typical effect of half an ulp.
        """
        return 2.0 * max(work, 1) * self.conditioning(halvings)

    def conditioning(self, halvings: int = 0) -> float:
        """The largest conditioning over the span divided by 2^halvings, at least half an ulp."""
        count = max(1, math.ceil(len(self.reference.times) * 2.0**-halvings))
        return max(float(np.max(self.reference.conditioning[:count])), HALF_ULP)

    def growth(self, halvings: int = 0) -> Floats:
        """The largest growth of an error to each sample, shape (64,), or to each eighth of a shorter span, shape (8,).

        The shorter span is divided by 2^halvings. If `error_growth` gives None, the growth is the largest conditioning
        over half an ulp. Without events it is multiplied by 1 + the span in time scales: the conditioning moves states
        within the constraints only, but an error of a velocity may leave a constraint, and grows as the time.
        """
        if halvings not in self._growth:
            times = self.reference.times[7::8] * 2.0**-halvings if halvings else self.reference.times
            largest = error_growth(self.case, times, self.reference.sizes)
            drift = 0.0 if self.case.hybrid is not None else float(times[-1]) / self.reference.time_scale
            worst = max(1.0, self.conditioning(halvings) / HALF_ULP) * (1 + drift)
            self._growth[halvings] = np.full(len(times), worst) if largest is None else largest
        return self._growth[halvings]

    @cached_property
    def calls_of_a_step(self) -> int:
        """An upper bound of the right-hand sides in a step: the greatest common divisor of the differences of counts.

        If all steps, also rejected ones, take equally many right-hand sides, this number divides every difference. The
        bound is 1 if there are too few counts.
        """
        answers = [self.short(n, s, end=True) for n in SHORT_SPANS for s in self.settings if s <= TIGHT]
        counts = sorted({a.work for a in answers if a.work is not None and not (a.steps or a.declined)})
        return math.gcd(*np.diff(counts).tolist()) if len(counts) >= COUNTS else 1

    def steps_of(self, answer: Answer) -> float:
        """The largest possible number of steps of an adaptive method; infinite if nothing was counted."""
        if answer.work is None:
            return math.inf
        least = 1 if self.integrator.sampling == "dense output" or answer.states is None else len(answer.states)
        return max(answer.work / (1 if answer.steps else self.calls_of_a_step), least)

    def of_differences(self, h: float, halvings: int) -> float:
        """The error at a step size that a Jacobian by differences may cause; 0 unless the integrator declares one.

        A one-sided difference has a relative error of at least the root of an ulp. A Jacobian J has the share h |J| of
        a step, and 1 / |J| is the time scale of the case.
        """
        if self.integrator.jacobian != "differences":
            return 0.0
        exact = np.concatenate([self.case.sample(np.zeros(1)), self.exact(halvings)])
        path = float(np.sum(self.scorer.metric.distance(exact[1:], exact[:-1])))
        share = min(1.0, h / self.reference.time_scale)
        return ROOT_OF_ULP * share * path * max(1.0, self.conditioning(halvings) / HALF_ULP)

    def of_velocities(self, h: float, halvings: int) -> float:
        """The error of velocities at a step size, if they may be differences of positions over the step; else 0.

        Positions are known to half an ulp. Such velocities are found by methods that keep positions on constraints, by
        engines that keep joints by constraints between bodies, and by interpolants, which differentiate positions.
        """
        takes = {Constrained, SceneForm} & set(self.integrator.accepts)
        if not takes and self.integrator.dense_order is None:
            return 0.0
        return 2.0 * self.conditioning(halvings) * self.reference.time_scale / h

    def exact(self, halvings: int) -> Floats:
        """The exact states at the samples of a shorter span, shape (64, dim)."""
        if halvings not in self._exact:
            self._exact[halvings] = exact_states(self.case, self.reference.times * 2.0**-halvings)
        return self._exact[halvings]

    def limited(self, problem: Problem, setting: float) -> Problem:
        """The problem with a limit of right-hand sides, after which a plain function with a tolerance is given up.

        A method of order p, whose estimate has order p or one less, takes steps of about tolerance^(1/p) of the fastest
        time of the equations.
        """
        if self.steps or not 0 < setting < 1 or problem.most_calls < math.inf:
            return problem
        fastest = min(problem.time_scale, self.case.fastest_time) if problem.names else problem.time_scale
        scales = abs(float(problem.elapsed[-1])) / fastest
        steps = len(problem.times) + scales * setting ** (-1 / (self.integrator.order or 2))
        return replace(problem, most_calls=CALLS * problem.dimension * steps)

    def prepared(self, problem: Problem, setting: float) -> Prepared:
        """The integrator, prepared for a problem."""
        return Prepared(self.integrator, self.limited(problem, setting), setting)

    def solved(self, problem: Problem, setting: float, starts: Sequence[Floats]) -> list[tuple[Solution, int]]:
        """(solution, number of right-hand sides) from each start (dim,), by one solver; exceptions pass through."""
        with self.prepared(problem, setting) as solver:
            return [solver.counted(start[None]) for start in starts]

    def solutions(self, problem: Problem, setting: float, starts: Sequence[Floats]) -> list[Floats]:
        """The states (64, dim) from each start, otherwise as `solved`."""
        return [solution.states[0] for solution, _ in self.solved(problem, setting, starts)]

    def distance(self, states: Floats, exact: Floats, times: Floats | None = None) -> Floats:
        with np.errstate(all="ignore"):  # very large finite states overflow in the metric
            return self.scorer.metric.distance(states, exact, times)

    def outcome(self, problem: Problem, setting: float, start: Floats, moving: bool = False) -> Solved:
        """The outcome from a start (dim,)."""
        limited = self.limited(problem, setting)
        return solve_within(self.integrator, limited, setting, start[None], moving, self.longest)

    def _answer(self, setting: float, halvings: int, end: bool = False) -> Answer:
        began, counted = _clock(), self.integrator.counts_rhs
        problem = self.problem(halvings, counted, end)
        outcome = self.outcome(problem, setting, self.start, self.moving and moves(self.reference))
        seconds, solution = _clock() - began, outcome.solution
        if solution is None:
            return Answer(setting, outcome.status, outcome.reason, seconds=seconds)
        work, states = solution.steps or outcome.calls or None, solution.states[0]
        times = self.reference.times if halvings == 0 else None
        errors = self.distance(states, self.exact(halvings)[-len(states) :], times)
        roundoff = self.roundoff(work or len(problem.times), halvings)
        if self.steps:
            roundoff += self.of_differences(setting, halvings) + self.of_velocities(setting, halvings)
        return Answer(
            setting, Status.OK, "", states, errors, roundoff, work, outcome.calls if counted else None,
            bool(solution.steps), solution.stopped, solution.events, seconds,
        )  # fmt: skip


def _clock() -> float:
    """Processor time of this process and of the programs that it drives."""
    return max(time.process_time(), processor_time(os.getpid()))

"""An ensemble: the numbers that vary, the integrator, and the errors of any of its samples."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.metric import Metric
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Solution, Tolerance
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.contract.status import Status
from gnomon.harness.ensembles import draws
from gnomon.harness.ensembles.draws import Varied
from gnomon.harness.ensembles.exact_formulas import exact_states, with_numbers
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.measuring.solved import Solved, outcome
from gnomon.harness.registry import lookup, selection
from numpy.typing import NDArray

Floats = NDArray[np.float64]
BLOCK = 256
"""The number of starts that are solved in one call. Vectors of eight starts may share their steps, so that the bits of
an answer depend on its neighbours. So blocks begin at multiples of BLOCK, and a start always has the same
neighbours."""
USUAL_TOLERANCE, STEPS_EACH = 1e-9, 64


@dataclass(frozen=True)
class Samples:
    """Consecutive samples: the index of the first, then arrays for all.

    `units` and `numbers` (n, d): places in the unit cube, and varied numbers. `errors` (n,): nan unless the status is
    ok.
    """

    first: int
    units: Floats
    numbers: Floats
    errors: Floats
    statuses: list[str]


@dataclass(frozen=True)
class Ensemble:
    """A case with numbers that vary, an integrator at one setting, and errors at `times` equal intervals.

    `case`: a name, case/variant or package.module:Case, with `parameters` as pairs (name, text). Numbers are binary64.
    All samples have the metric of the case with its own start.
    """

    case: str
    integrator: str
    setting: float
    vary: tuple[Varied, ...]
    seed: int = 1
    times: int = 1
    parameters: tuple[tuple[str, str], ...] = ()

    @property
    def prepared(self) -> PreparedEnsemble:
        """The ensemble, prepared once in a process.

        Raises ValueError for a wrong name or a pair of case and integrator that cannot run.
        """
        return _prepare(self)

    def error(self, numbers: Mapping[str, float]) -> float:
        """The error from one start alone, by the exact motion of the case; `numbers`: the varied numbers.

        In its block the start may have neighbours that share its steps, so that its error there differs a little.
        Raises ValueError outside the domain, and Refused if the integrator gives no finite answer.
        """
        ready = self.prepared
        row = np.array([[numbers[number.name] for number in self.vary]])
        parameters, starts = ready.split(row)
        exact = with_numbers(ready.case, parameters[0], starts[0]).sample(ready.times)
        states, statuses = ready.solved(parameters, starts)
        if statuses[0] != Status.OK:
            raise Refused(f"{self.integrator}: {statuses[0]}")
        return float(ready.errors(states, exact[np.newaxis])[0])


@dataclass(frozen=True)
class PreparedEnsemble:
    """The parts that all samples of an ensemble share."""

    ensemble: Ensemble
    case: Case
    integrator: Integrator
    problem: Problem
    times: Floats
    metric: Metric

    @cached_property
    def solver(self) -> Prepared:
        return Prepared(self.integrator, self.problem, self.ensemble.setting)

    @cached_property
    def places(self) -> list[int]:
        """The column of each varied number among parameters and start."""
        names = [*self.case.parameters, *(c.name for c in self.case.state)]
        return [names.index(number.name) for number in self.ensemble.vary]

    def unit(self, name: str) -> str:
        """The unit of a number of the case."""
        units = {p.name: p.unit for p in self.case.parameter_list} | {c.name: c.unit for c in self.case.state}
        return units[name]

    @property
    def parameters_vary(self) -> bool:
        return any(place < len(self.case.parameters) for place in self.places)

    def split(self, numbers: Floats) -> tuple[Floats, Floats]:
        """Parameters (n, p) and starts (n, dim) of samples with these varied numbers (n, d)."""
        own = [float(x) for x in (*self.case.parameter_values(), *self.case.initial_state)]
        rows = np.tile(own, (len(numbers), 1))
        rows[:, self.places] = numbers
        count = len(self.case.parameters)
        return np.ascontiguousarray(rows[:, :count]), np.ascontiguousarray(rows[:, count:])

    def solved(self, parameters: Floats, starts: Floats) -> tuple[Floats, list[str]]:
        """States (n, k, dim) and statuses of starts (n, dim), in one call unless parameters vary.

        If a call raises an exception, each start is solved alone, so that its status does not depend on its neighbours.
        """
        if not self.parameters_vary:
            outcome = self._outcome(parameters[0], starts)
            if outcome.solution is not None or len(starts) == 1:
                return self._states(outcome)
        alone = [self._states(self._outcome(*row)) for row in zip(parameters, starts[:, np.newaxis], strict=True)]
        states = np.array([states[0] for states, _ in alone]).reshape(-1, len(self.times), starts.shape[1])
        return states, [status for _, (status,) in alone]

    def _outcome(self, parameters: Floats, starts: Floats) -> Solved:
        def call() -> tuple[Solution, int]:
            if not self.parameters_vary:
                return self.solver.counted(starts)
            # The forms of some cases depend on the parameters of a sample.
            own = problem_of(with_numbers(self.case, parameters, starts[0]), self.integrator.accepts)
            problem = replace(own, times=self.times, time_scale=self.problem.time_scale)
            with Prepared(self.integrator, problem, self.ensemble.setting) as solver:
                return solver.counted(starts)

        return outcome(call)

    def _states(self, outcome: Solved) -> tuple[Floats, list[str]]:
        if outcome.solution is None:
            return np.full((1, len(self.times), len(self.case.state)), np.nan), [str(outcome.status)]
        finite = np.all(np.isfinite(outcome.states), axis=(1, 2))
        return outcome.states, [str(Status.OK if is_finite else Status.DIVERGED) for is_finite in finite.tolist()]

    def errors(self, states: Floats, exact: Floats) -> Floats:
        """The largest error of each sample over the times, infinite if a state is too large to measure."""
        n, k, dimension = states.shape
        with np.errstate(all="ignore"):
            errors = self.metric.distance(states.reshape(-1, dimension), exact.reshape(-1, dimension))
        return np.asarray(np.where(np.isfinite(errors), errors, math.inf).reshape(n, k).max(axis=1))

    def drawn(self, first: int, count: int) -> tuple[Floats, Floats]:
        """Samples in the unit cube, and their varied numbers, (count, d) each."""
        units = draws.unit(self.ensemble.seed, len(self.ensemble.vary), first, count)
        return units, draws.numbers(units, self.ensemble.vary)

    def measured(self, first: int, count: int) -> Samples:
        """Measure `count` samples from `first` on, a multiple of BLOCK."""
        units, numbers = self.drawn(first, count)
        parameters, starts = self.split(numbers)
        exact, statuses = exact_states(self.case, parameters, starts, self.times)
        errors = np.full(count, np.nan)
        for begin in range(0, count, BLOCK):
            indices = begin + np.flatnonzero(np.array(statuses[begin : begin + BLOCK]) == "")
            if not len(indices):
                continue
            states, call_statuses = self.solved(parameters[indices], starts[indices])
            errors[indices] = self.errors(states, exact[indices])
            for row, status in zip(indices.tolist(), call_statuses, strict=True):
                statuses[row] = Status.DIVERGED if status == Status.OK and errors[row] == math.inf else status
        errors[np.array(statuses) != Status.OK] = np.nan
        return Samples(first, units, numbers, errors, statuses)


@lru_cache(maxsize=4)
def _prepare(ensemble: Ensemble) -> PreparedEnsemble:
    """Pair the case and the integrator of an ensemble. Raises ValueError if they cannot run, and for varying guards."""
    ((case, _),) = selection.choose([ensemble.case], False, True, **dict(ensemble.parameters))
    integrator = lookup.find_one(ensemble.integrator)
    absent = lookup.missing(integrator)
    if absent is not None:
        raise ValueError(f"{integrator.id}: {absent}")
    problem = problem_of(case, integrator.accepts)
    lacks = integrator.unsupported(problem.form)
    if lacks is not None:
        raise ValueError(f"{integrator.id} does not support {case.id}: {lacks}")
    interval = short_interval(float(case.times[-1]) / ensemble.times)
    times: Floats = np.arange(1, ensemble.times + 1, dtype=np.float64) * np.float64(interval)
    prepared = PreparedEnsemble(ensemble, case, integrator, replace(problem, times=times), times, case.metric)
    if prepared.parameters_vary and case.hybrid is not None:
        raise ValueError(
            f"{case.name} has events, whose guards depend on its parameters: vary numbers of its start only"
        )
    return prepared


def short_interval(length: float) -> float:
    """The length rounded to 20 significant bits, so that its multiples and halves are exact."""
    mantissa, exponent = math.frexp(length)
    return math.ldexp(round(math.ldexp(mantissa, 20)), exponent - 20)


def setting_for(case: Case, integrator: Integrator, times: int, setting: float | None = None) -> float:
    """The tolerance or step size of an ensemble over `times` equal intervals; a step `setting` is shortened to divide them.

    The default is a tolerance of 1e-9, within the sweep, or the interval divided by the power of two that gives a step of
    at most a 64th of the time scale. Raises ValueError for a setting that is not positive.
    """
    if setting is not None and not 0 < setting < math.inf:
        raise ValueError(f"--setting {setting}: give a positive number")
    sweep = integrator.sweep
    if isinstance(sweep, Tolerance):
        return min(max(USUAL_TOLERANCE, sweep.tightest), sweep.loosest) if setting is None else setting
    interval = short_interval(float(case.times[-1]) / times)
    if setting is None:
        return math.ldexp(interval, -max(0, math.ceil(math.log2(interval * STEPS_EACH / case.time_scale))))
    return interval / max(1.0, math.ceil(interval / setting))

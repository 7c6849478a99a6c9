"""One launch of one series: requests its trials from cheap to expensive, scores the outcomes, skips what is too slow."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from gnomon.harness.contract.integrator import Steps, Tolerance
from gnomon.harness.contract.status import CANNOT_RUN, SCORED, Status
from gnomon.harness.registry.lookup import reference
from gnomon.harness.results.schema import TIMES
from gnomon.harness.results.store import Known
from gnomon.harness.running.plan import Series, Suite, Trial, wants_first_use
from gnomon.harness.running.worker import FEWEST_CALLS, Request, Task
from gnomon.harness.scoring.outcome import Outcome
from gnomon.harness.scoring.reference_solution import CaseSpec, ReferenceSolution
from gnomon.harness.scoring.score import Scorer, above_text
from numpy.typing import NDArray

SECONDS_EACH = {
    "gnomon": 2e-7,
    "gnomon:Taylor": 2e-6,
    "heyoka": 4e-6,
    "sksundae": 2e-5,
    "diffrax": 2e-5,
    "diffrax:Kvaerno5": 1e-4,
    "rebound": 1e-6,
    "rebound:BS [ODE mode]": 6e-7,
    "rebound:IAS15": 4e-5,
    "rebound:BS": 4e-5,
    "scipy": 2e-5,
    "scipy:odeint": 5e-6,
    "scipy:ode dop853": 5e-6,
    "scipy:ode vode Adams": 5e-6,
    "scipy:Radau": 1e-4,
    "scipy:BDF": 1.5e-4,
    "scipy:RK45 [events]": 1e-4,
    "scipy:DOP853 [events]": 1e-4,
    "scipy:LSODA [events]": 1.5e-4,
    "scipy:Radau [events]": 1.5e-4,
    "pybullet": 4e-5,
}
"""An upper estimate, in seconds, of one right-hand side (of one step, if right-hand sides are not counted), by
integrator id or library. It is above the largest, and one to six times the median, of the processor times measured on a
busy machine for ten cases from the pendulum to the tops. Which trials are skipped follows from these numbers and from
counts, which are the same on every machine; with measured times it would differ between runs. Trials of libraries
without an entry all run, until one passes the limit."""
RELAUNCHED_SECONDS = 0.08
"""Trials above this by the same estimate are launched once: they are never Pareto-optimal, and would dominate the run
time."""
REPEATED_SECONDS = 0.001
"""Trials of hard variants above this are timed in one call. For shorter ones a single call is too slow by 5 to 10 % in
the median, and below 30 microseconds by half in one of ten, since its code was just loaded."""
MOST_INTERRUPTIONS = 2
"""How many times a trial that was interrupted is run again, each at the next call; after that its status is `crashed`."""


Record = Callable[[Mapping[str, Any], Mapping[str, Any] | None, NDArray[Any] | None], None]
"""A function that stores a measurement, the engine options and the states."""


def task_of(series: Series, exact: ReferenceSolution) -> Task:
    """The task of a worker for a series; the path of its output is still empty."""
    return Task(
        reference(series.integrator),
        CaseSpec.of(series.case, series.formulation),
        exact.problem_times,
        exact.start,
        exact.sizes,
        exact.time_scale,
        exact.turned_starts,
        "",
    )


@dataclass(eq=False)
class Sweep:
    """One launch of a series. By (trial_key, launch), `history` has the results of earlier runs and `interruptions` the
    number of interruptions."""

    series: Series
    trials: Sequence[Trial]
    scorer: Scorer
    suite: Suite
    launch: int
    history: Mapping[tuple[str, int], Known]
    record: Record
    finished: Callable[[], None]
    interruptions: Mapping[tuple[str, int], int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.limit_seconds = self.suite.limit(self.series.case)
        self.task = task_of(self.series, self.scorer.reference)
        self._waiting = list(self.trials)
        self._current: Trial | None = None
        self._counted: list[tuple[float, int]] = []
        self._places = {trial.key: place for place, trial in enumerate(self.trials)}
        integrator = self.series.integrator
        self._seconds_each = SECONDS_EACH.get(integrator.id, SECONDS_EACH.get(integrator.library, 0.0))
        self._stopped: str | None = None

    def next(self) -> Request | None:
        """The request for the next trial that must run. Those that earlier runs measured, and those not to be relaunched,
        are passed over; those that would pass the limit are recorded as skipped."""
        while self._waiting:
            trial = self._waiting.pop(0)
            assert trial.setting is not None
            known = self.history.get((trial.key, self.launch))
            if known is not None:
                self._note(known.status, known.work, trial.setting)
                continue
            if self.launch > 1 and not self._to_relaunch(trial):
                continue
            reason = self._stopped or self._predicted(trial.setting)
            if reason is not None:
                self._stopped = reason
                self._add(trial, {"status": Status.SKIPPED, "reason": reason})
                continue
            self._current = trial
            return replace(self._request(trial.setting), place=self._places[trial.key])
        self.finished()
        return None

    def done(self, outcome: Outcome) -> None:
        """Score an outcome and record it."""
        trial = self._taken()
        tolerance = trial.setting if isinstance(self.series.integrator.sweep, Tolerance) else None
        try:
            measurement, states = self.scorer.measure(outcome, tolerance)
        except Exception as error:  # an unexpected outcome of one trial must not end the other trials
            self._note(Status.CRASHED, None)
            self._add(trial, {"status": Status.CRASHED, "reason": f"its outcome cannot be scored: {error!r}"})
            return
        work = outcome.steps if outcome.rhs_calls is None else outcome.rhs_calls
        self._note(measurement["status"], work, trial.setting)
        self._add(trial, measurement, outcome.options, states if self.launch == 1 else None)

    def failed(self, status: Status, reason: str, output: str, tries: int | None = None) -> None:
        """Record a trial without outcome. After too many interruptions its status is `crashed`: it causes them itself."""
        trial = self._taken()
        before = self.interruptions.get((trial.key, self.launch), 0)
        if status == Status.INTERRUPTED and before >= MOST_INTERRUPTIONS:
            status, reason = Status.CRASHED, f"{reason}, as {before} times before"
        self._note(status, None)
        self._add(trial, {"status": status, "reason": reason, "output": output or None, "repeats": tries})

    def _taken(self) -> Trial:
        assert self._current is not None
        trial, self._current = self._current, None
        return trial

    def _note(self, status: Status, work: int | None, setting: float | None = None) -> None:
        if status in (Status.TIMEOUT, *CANNOT_RUN):
            self._stopped = f"the setting before it ended as {status}"
        if work is not None and setting is not None:
            self._counted.append((setting, work))

    def _predicted(self, setting: float) -> str | None:
        """Why a setting would pass the limit, extrapolated by the smallest growth of the counts; None if it would not."""
        if not self._counted or not self._seconds_each:
            return None
        before, work = self._counted[-1]
        ratios = [after / max(count, 1) for (_, count), (_, after) in itertools.pairwise(self._counted[-3:])]
        if isinstance(self.series.integrator.sweep, Steps):  # the work is proportional to the number of steps
            ratios.append(before / setting)
        most = self.limit_seconds / self._seconds_each
        expected = work * max(min(ratios, default=1.0), 1.0)
        if expected <= most:
            return None
        what = "right-hand sides" if self.series.integrator.counts_rhs else "steps"
        return f"predicted {above_text(expected, most)} {what}, above the {most:.2g} of a limit of {self.limit_seconds:g} s"

    def _to_relaunch(self, trial: Trial) -> bool:
        first = self.history.get((trial.key, 1))
        if first is None or first.status not in SCORED:
            return False
        return (first.work or 0) * self._seconds_each <= RELAUNCHED_SECONDS

    def _request(self, setting: float) -> Request:
        """The request for a trial. Default variants are timed precisely; on the others a few calls suffice, as their
        times serve as orders of magnitude."""
        suite, count = self.suite, self.launch == 1 and self.series.integrator.counts_rhs
        if self.series.case.variant is None:
            turned = suite.turned and self.launch == 1 and len(self.task.turned) > 0
            slow, null = suite.slow_seconds, suite.timed
            first = setting == self.trials[0].setting and wants_first_use(self.series, suite, self.launch)
            return Request(setting, count, suite.block_seconds, suite.repeats, slow, turned, null, first)
        fewest = min(FEWEST_CALLS, suite.repeats)
        return Request(setting, count, 0.0, fewest, min(suite.slow_seconds, REPEATED_SECONDS))

    def _add(self, trial: Trial, measurement: Mapping[str, Any], options: Any = None, states: Any = None) -> None:
        row = {"trial_key": trial.key, "launch": self.launch, "limit_seconds": self.limit_seconds, **measurement}
        if not self.suite.timed:
            row = {name: value for name, value in row.items() if name not in TIMES}
        self.record(row, options, states)

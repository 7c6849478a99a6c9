"""One launch of one series: requests its trials from cheap to expensive, scores the outcomes, skips slow settings."""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from gnomon.harness.contract.integrator import Steps, Tolerance
from gnomon.harness.contract.status import AGAIN, CANNOT_RUN, SCORED, Status
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.measuring.reference_solution import CaseSpec, ReferenceSolution
from gnomon.harness.measuring.score import Scorer, moves
from gnomon.harness.registry.references import reference
from gnomon.harness.results.schema import TIMES
from gnomon.harness.results.store import Known
from gnomon.harness.running.plan import Series, Suite, Trial, wants_first_use
from gnomon.harness.running.worker import FEWEST_CALLS, Request, Task
from numpy.typing import NDArray

TIMES_THE_LIMIT = 3.0
"""A setting is left out if its predicted time is at least this multiple of the limit."""
GRACE_SECONDS = 0.15
"""Seconds beyond the trial's limit before a worker is killed, for the start of the call, its message and scheduling."""
TIMEOUTS_IN_A_ROW = 3
"""Number of successive timeouts that end a sweep. One does not: a loose tolerance may hang, as near a pericentre."""
REPEATED_SECONDS = 0.001
"""Trials of hard variants that take longer are timed in one call. In shorter trials a single call is too slow by 5 to 10 %
in the median, because its code was just loaded; below 30 microseconds one call in ten is too slow by half."""
MOST_INTERRUPTIONS = 2
"""Number of times that an interrupted trial runs again, each at the next call; after that its status is `crashed`."""


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
        moves=moves(exact),
    )


@dataclass(eq=False)
class Sweep:
    """One launch of a series. `history`: earlier results, `interruptions`: their counts, both by (trial_key, launch)."""

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
        self.limit_seconds = self.suite.limit(self.series.case, self.series.integrator)
        self.task = task_of(self.series, self.scorer.reference)
        self._waiting = list(self.trials)
        self._current: Trial | None = None
        self._counted: list[tuple[float, int]] = []
        self._fastest = math.inf
        self._timeouts: list[float] = []
        self._places = {trial.key: place for place, trial in enumerate(self.trials)}
        self._stopped: str | None = None

    def next(self) -> Request | None:
        """The request for the next trial that must run.

        It passes over trials that earlier runs measured and, after the first launch, trials that the first launch did
        not score. Trials that would exceed the limit are recorded as skipped.
        """
        while self._waiting:
            trial = self._waiting.pop(0)
            assert trial.setting is not None
            known = self.history.get((trial.key, self.launch))
            if known is not None:
                self._note(trial.setting, known)
                continue
            if self.launch > 1 and not self._scored_before(trial):
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
            self._add(trial, {"status": Status.CRASHED, "reason": f"its outcome cannot be scored: {error!r}"})
            return
        self._add(trial, measurement, outcome.options, states if self.launch == 1 else None)

    def failed(self, status: Status, reason: str, output: str, tries: int | None = None) -> None:
        """Record a trial without outcome. After too many interruptions it is `crashed`: it causes them itself."""
        trial = self._taken()
        before = self.interruptions.get((trial.key, self.launch), 0)
        if status == Status.INTERRUPTED and before >= MOST_INTERRUPTIONS:
            status, reason = Status.CRASHED, f"{reason}, as {before} {AGAIN}"
        self._add(trial, {"status": status, "reason": reason, "output": output or None, "repeats": tries})

    def _taken(self) -> Trial:
        assert self._current is not None
        trial, self._current = self._current, None
        return trial

    def _note(self, setting: float, known: Known) -> None:
        """Use a measurement, of this run or an earlier one, to decide about the settings after it."""
        if known.status in CANNOT_RUN:
            self._stopped = f"the setting before it ended as {known.status}"
        self._timeouts = [*self._timeouts, setting] if known.status == Status.TIMEOUT else []
        if len(self._timeouts) == TIMEOUTS_IN_A_ROW and self.launch == 1:
            settings = ", ".join(f"{each:.3g}" for each in self._timeouts)
            self._stopped = f"the {TIMEOUTS_IN_A_ROW} settings before it ended as timeout: {settings}"
        if known.work:
            self._counted.append((setting, known.work))
            self._fastest = min(self._fastest, (known.seconds or math.inf) / known.work)

    def _predicted(self, setting: float) -> str | None:
        """The reason to skip a setting that would exceed the limit by far; None if it would not, or without a count.

        The prediction is a count of right-hand sides or steps times the least time of one in this series so far. The
        count is extrapolated from the last count by the smallest factor between two counts, once for each setting since.
        The prediction must exceed TIMES_THE_LIMIT; after a timeout the deadline of the worker, as a cheaper setting has
        already failed to end before it.
        """
        if self.launch > 1 or not math.isfinite(self._fastest):
            return None
        (before, work), has_steps = self._counted[-1], isinstance(self.series.integrator.sweep, Steps)
        ratios = [after / count for (_, count), (_, after) in itertools.pairwise(self._counted[-3:])]
        if has_steps:  # the work is proportional to the number of steps
            ratios.append(before / setting)
        elif len(ratios) < 2:  # the first solution may have missed a pericentre
            ratios.append(1.0)
        since = 0 if has_steps else len(self._timeouts)
        expected = work * max(min(ratios), 1.0) ** (since + 1)
        seconds, times = expected * self._fastest, TIMES_THE_LIMIT
        if self._timeouts:
            times = min(times, (self.limit_seconds + GRACE_SECONDS) / self.limit_seconds)
        if seconds < times * self.limit_seconds:
            return None
        what = "right-hand sides" if self.series.integrator.counts_rhs else "steps"
        return (
            f"predicted {seconds:.3g} s, at least {times:.2g} times the limit of {self.limit_seconds:g} s:"
            f" {expected:.3g} {what}, by their smallest growth, of {self._fastest:.3g} s each, the fastest measured"
        )

    def _scored_before(self, trial: Trial) -> bool:
        first = self.history.get((trial.key, 1))
        return first is not None and first.status in SCORED

    def _request(self, setting: float) -> Request:
        """The request for a trial.

        Default variants are timed precisely. A few calls suffice for other variants, whose times serve as orders of
        magnitude only.
        """
        suite, count = self.suite, self.launch == 1 and self.series.integrator.counts_rhs
        if self.series.case.variant is None:
            wanted = suite.scope.turned and self.launch == 1 and not self.series.over_timing_span
            turned = wanted and len(self.task.turned) > 0
            slow, null = suite.timing.slow_seconds, suite.timing.timed
            first = setting == self.trials[0].setting and wants_first_use(self.series, suite, self.launch)
            return Request(setting, count, suite.timing.block_seconds, suite.timing.repeats, slow, turned, null, first)
        fewest = min(FEWEST_CALLS, suite.timing.repeats)
        return Request(setting, count, 0.0, fewest, min(suite.timing.slow_seconds, REPEATED_SECONDS))

    def _add(self, trial: Trial, measurement: Mapping[str, Any], options: Any = None, states: Any = None) -> None:
        row = {"trial_key": trial.key, "launch": self.launch, "limit_seconds": self.limit_seconds, **measurement}
        if not self.suite.timing.timed:
            row = {name: value for name, value in row.items() if name not in TIMES}
        assert trial.setting is not None
        self._note(trial.setting, Known.of(row))
        self.record(row, options, states)

"""One launch of one series: hands out its trials from cheap to dear, judges what comes back, knows when to stop."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from gnomon.harness.integrator import Steps, Tolerance
from gnomon.harness.judge import Judge, above_text
from gnomon.harness.plan import Series, Suite, Trial
from gnomon.harness.registry import reference
from gnomon.harness.store import Known
from gnomon.harness.truth import CaseSpec
from gnomon.harness.worker import FEWEST_CALLS, Order, Outcome, Task
from numpy.typing import NDArray

RELAUNCHED_SECONDS = 0.01
"""Trials above this are launched once: what is that slow is on nobody's Pareto front, and would fill the run."""
REPEATED_SECONDS = 0.001
"""Hard variants above this are timed in one call. Below, a single call is the first of code that was just loaded: 5 to
10 % too slow in the middle, half too slow in one of ten below 30 microseconds."""
MOST_INTERRUPTIONS = 2
"""A trial that was interrupted runs again at the next call, so often at most; then it is `crashed`."""
MOST_GROWTH = 16.0
"""A prediction takes ratios of times up to this: below a tenth of a millisecond they are noise."""


class Record(Protocol):
    """Where a sweep puts its measurements."""

    def __call__(
        self, measurement: Mapping[str, Any], settings: Mapping[str, Any] | None, states: NDArray[Any] | None
    ) -> None: ...


class Sweep:
    """One launch of a series. `history` is what earlier runs know by (trial_key, launch), `interruptions` how often each
    was interrupted."""

    def __init__(
        self,
        series: Series,
        trials: Sequence[Trial],
        judge: Judge,
        suite: Suite,
        launch: int,
        history: Mapping[tuple[str, int], Known],
        record: Record,
        finished: Callable[[], None],
        interruptions: Mapping[tuple[str, int], int] | None = None,
    ) -> None:
        self.series, self.judge, self.suite, self.launch, self.record = series, judge, suite, launch, record
        self.limit_seconds = suite.limit(series.case)
        truth = judge.truth
        spec = CaseSpec.of(series.case, series.formulation)
        self.task = Task(
            reference(series.integrator),
            spec,
            truth.problem_times,
            truth.start,
            truth.sizes,
            truth.time_scale,
            truth.turned_starts,
            "",
        )
        self._history = history
        self._finished = finished
        self._interruptions = interruptions or {}
        self._waiting = list(trials)
        self._current: Trial | None = None
        self._timed: list[tuple[float, float]] = []
        self._stopped: str | None = None

    def next(self) -> Order | None:
        """The next trial that must run. Trials that need not run are passed over, or recorded as skipped."""
        while self._waiting:
            trial = self._waiting.pop(0)
            assert trial.setting is not None
            known = self._history.get((trial.key, self.launch))
            if known is not None:
                self._note(known.status, known.seconds, trial.setting)
                continue
            if self.launch > 1 and not self._worth_relaunching(trial):
                continue
            reason = self._stopped or self._predicted(trial.setting)
            if reason is not None:
                self._stopped = reason
                self._add(trial, {"status": "skipped", "reason": reason})
                continue
            self._current = trial
            return self._order(trial.setting)
        self._finished()
        return None

    def done(self, outcome: Outcome) -> None:
        """Judge an outcome and record it."""
        trial = self._taken()
        tolerance = trial.setting if isinstance(self.series.integrator.sweep, Tolerance) else None
        try:
            measurement, states = self.judge.measure(outcome, tolerance)
        except Exception as error:  # an answer that nobody foresaw must not cost the others theirs
            self._note("crashed", None)
            self._add(trial, {"status": "crashed", "reason": f"its answer cannot be judged: {error!r}"})
            return
        self._note(measurement["status"], measurement["seconds_low"], trial.setting)
        self._add(trial, measurement, outcome.settings, states if self.launch == 1 else None)

    def failed(self, status: str, reason: str, output: str, tries: int | None = None) -> None:
        """Record a trial that has no outcome. What is ended from outside again and again ends itself."""
        trial = self._taken()
        before = self._interruptions.get((trial.key, self.launch), 0)
        if status == "interrupted" and before >= MOST_INTERRUPTIONS:
            status, reason = "crashed", f"{reason}, as {before} times before"
        self._note(status, None)
        self._add(trial, {"status": status, "reason": reason, "output": output or None, "repeats": tries})

    def _taken(self) -> Trial:
        assert self._current is not None
        trial, self._current = self._current, None
        return trial

    def _note(self, status: str, seconds: float | None, setting: float | None = None) -> None:
        if status in ("timeout", "not_installed"):
            self._stopped = f"the setting before it is {status}"
        if seconds is not None and setting is not None:
            self._timed.append((setting, seconds))

    def _predicted(self, setting: float) -> str | None:
        """Why the next setting would pass the limit, by the smallest growth that is likely; None where it would not."""
        if not self._timed:
            return None
        ratios = [after / before for (_, before), (_, after) in itertools.pairwise(self._timed[-3:])]
        before, seconds = self._timed[-1]
        if isinstance(self.series.integrator.sweep, Steps):  # the work is in proportion to the number of steps
            ratios.append(before / setting)
        if not ratios:
            return None
        expected = seconds * min(max(min(ratios), 1.0), MOST_GROWTH)
        if expected <= self.limit_seconds:
            return None
        return f"predicted {above_text(expected, self.limit_seconds)} s, above the limit of {self.limit_seconds:g} s"

    def _worth_relaunching(self, trial: Trial) -> bool:
        first = self._history.get((trial.key, 1))
        return first is not None and first.seconds is not None and first.seconds <= RELAUNCHED_SECONDS

    def _order(self, setting: float) -> Order:
        """Default variants are timed; on the others times are orders of magnitude, and a few calls tell them."""
        suite, count = self.suite, self.launch == 1 and self.series.integrator.counts_rhs
        if self.series.case.variant is None:
            turned = suite.turned and self.launch == 1 and len(self.task.turned) > 0
            return Order(setting, count, suite.block_seconds, suite.repeats, suite.slow_seconds, turned, null=True)
        return Order(setting, count, 0.0, FEWEST_CALLS, min(suite.slow_seconds, REPEATED_SECONDS))

    def _add(self, trial: Trial, measurement: Mapping[str, Any], settings: Any = None, states: Any = None) -> None:
        row = {"trial_key": trial.key, "launch": self.launch, "limit_seconds": self.limit_seconds, **measurement}
        self.record(row, settings, states)

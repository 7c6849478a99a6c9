"""A run: plan, reference solutions, sweeps in worker processes, results in the store."""

import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from time import monotonic
from typing import Any, Protocol

from gnomon.cases import Case
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.status import Status
from gnomon.harness.kernels.kept_code import cache_folder
from gnomon.harness.measuring.reference_solution import CaseSpec, ReferenceSolution, find_kept, reference_solutions
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.registry import declaration, environment, lookup, references
from gnomon.harness.registry.selection import DEFAULT
from gnomon.harness.results.contenders import Names
from gnomon.harness.results.number_text import count_text, duration_text
from gnomon.harness.results.store import TO_REPEAT, Known, Store
from gnomon.harness.running import order, plan, rounds
from gnomon.harness.running.call_cost import describe as python_calls
from gnomon.harness.running.cost import launch_seconds, run_seconds, shard, shard_named
from gnomon.harness.running.plan import Repeat, Series, Suite, Trial
from gnomon.harness.running.pool import PREPARE_SECONDS, Pool
from gnomon.harness.running.rounds import Rounds
from gnomon.harness.running.sweep import Sweep
from gnomon.harness.system.limitations import need_fork
from gnomon.harness.system.progress import Progress
from gnomon.harness.system.streams import open_standard_streams
from gnomon.reference.storage import cachefolder, diskcache

WORKERS = 2
SETTINGS = 8
"""A typical number of settings of a sweep, for predictions."""
Work = tuple[Series, tuple[Trial, ...], Scorer]
"""A series, its trials on this machine, its scorer."""


@dataclass(frozen=True, eq=False)
class Launch:
    """A launch of a series with some of its trials.

    `is_again`: whether only the middle one of its timed trials runs, for the scatter between launches.
    """

    number: int
    series: Series
    trials: tuple[Trial, ...]
    scorer: Scorer
    is_again: bool = False

    def pending(self, history: Mapping[tuple[str, int], Known]) -> tuple[Trial, ...]:
        """Its trials, or none if all are in the history."""
        trials = order.middle_trial(self.trials, history) if self.is_again else self.trials
        return trials if any((trial.key, self.number) not in history for trial in trials) else ()


def run(
    out: str | Path,
    suite: Suite,
    chosen: Sequence[tuple[Case, str]],
    integrators: Sequence[Integrator],
    progress: Progress | None = None,
    workers: int = WORKERS,
    prepare_seconds: float = PREPARE_SECONDS,
    near_duplicates: bool = True,
) -> Path:
    """Run every chosen case (see `selection.choose`) through every integrator; return the path of the results file.

    If `near_duplicates` is False, near-duplicate methods (those with `primary = False`) do not run on hard variants.

    Trials that the file already contains are not repeated. After an interruption at any moment, an equal call continues
    from the file. Raises ValueError before anything runs if the declaration of an integrator is wrong, if two integrators
    have one id, or if a worker process cannot make an integrator from its pickle. If the exact motion of a case cannot be
    computed, raises ValueError after all other cases have run.
    """
    need_fork()
    began = monotonic()
    path = Path(out) / "results.sqlite" if Path(out).suffix != ".sqlite" else Path(out)
    progress, at_once = progress or Progress(quiet=True), suite.timing.launches > 1
    with open_run(path, suite, chosen, integrators, progress, near_duplicates, at_once) as run_:
        in_process = any(CaseSpec.of(case).in_process for case, _ in chosen)
        method = "fork" if in_process else references.start_method(integrators)
        minutes = suite.budget(integrators)
        run_.workers = workers
        run_.further = Rounds(run_.results.timed, minutes, began) if minutes else None
        Pool(workers, method, prepare_seconds).run(run_.sweeps(), run_.progress.interlude)
    return path


@contextmanager
def open_run(
    path: Path,
    suite: Suite,
    chosen: Sequence[tuple[Case, str]],
    integrators: Sequence[Integrator],
    progress: Progress,
    near_duplicates: bool,
    at_once: bool = True,
) -> Iterator["PlannedRun"]:
    """Write the plan of a run to the results file, and give the run, whose `work` the caller runs.

    With `at_once` all series are planned now. Without it, series whose exact motions are not on disk yet are planned
    after the other series have run, so that the first trial begins within seconds. Raises ValueError as `run` does.
    """
    open_standard_streams()  # else a file of the run may take the place of a standard stream
    for integrator in integrators:
        declaration.validate(integrator)
        references.require_rebuilt(integrator)
    lookup.require_distinct(integrators)
    _verify_caches()
    every = plan.list_series(
        chosen, integrators, suite.scope.formulations, near_duplicates, always=suite.scope.for_stiff
    )
    whole = list(filter(suite.has, every))
    series, named = shard(whole, suite, near_duplicates), shard_named(whole, suite, near_duplicates)
    with progress, Store(path) as results:
        first, later = (series, []) if at_once else _in_two(series)
        known, broken = _reference_solutions(first, progress)
        calls = python_calls() if any(integrator.library == "scipy" for integrator in integrators) else {}
        ended = results.noted(suite.name, rounds.NAME)
        number = results.begin_run(suite.name, shlex.join(sys.argv), environment.describe() | calls | named)
        run_ = PlannedRun(results, number, suite, known, progress, near_duplicates, named, later=later, broken=broken)
        run_.ended = None if suite.limits.asked else ended
        run_.plan(first)
        yield run_
        results.end_run(number)
    _verify_caches()  # the disk may have become full in the meantime
    if run_.broken:
        raise ValueError("; ".join(f"{spec.path} {spec.variant or ''}: {error}" for spec, error in run_.broken.items()))


def _verify_caches() -> None:
    """Warn if a cache cannot be written, as workers do not. Raises ValueError if another user could write to it."""
    cachefolder.prepare(cache_folder(), diskcache.folder())


def _in_two(all_series: Sequence[Series]) -> tuple[Sequence[Series], Sequence[Series]]:
    """(first, later): series whose exact motions are on disk, or else the series of the first case; all other series."""
    specs = dict.fromkeys(CaseSpec.of(series.case, series.formulation) for series in all_series)
    ready = {spec for spec in specs if find_kept(spec) is not None} or {*list(specs)[:1]}
    parts: tuple[list[Series], list[Series]] = [], []
    for series in all_series:
        parts[CaseSpec.of(series.case, series.formulation) not in ready].append(series)
    return parts


def _reference_solutions(
    series: Sequence[Series], progress: Progress
) -> tuple[dict[CaseSpec, ReferenceSolution], dict[CaseSpec, str]]:
    """The reference solutions of all cases in the run, and the error messages of the cases without one."""
    wanted = dict.fromkeys(CaseSpec.of(s.case, s.formulation) for s in series)
    progress.begin("reference solutions", len(wanted))
    solutions = reference_solutions(list(wanted), progress.advance)
    known = {spec: exact for spec, exact in solutions.items() if isinstance(exact, ReferenceSolution)}
    return known, {spec: exact for spec, exact in solutions.items() if isinstance(exact, str)}


def _name_series(series: Series) -> Names:
    """(case, variant, integrator) of a series, as `Rounds.next` names it; no integrator in another formulation."""
    variant = "" if series.variant == DEFAULT else series.variant
    return series.case.name, variant, series.integrator.id if series.formulation is None else ""


class Results(Protocol):
    """The part of a `Store` that a run needs, and that other classes have too."""

    def history(self) -> dict[tuple[str, int], Known]: ...

    def interruptions(self) -> dict[tuple[str, int], int]: ...

    def plan(self, run: int, trials: Iterable[Mapping[str, Any]]) -> None: ...

    def add(self, run: int, measurement: Mapping[str, Any], options: Any = None, states: Any = None) -> None: ...

    def add_all(self, run: int, measurements: Iterable[Mapping[str, Any]]) -> None: ...

    def note(self, run: int, name: str, value: str) -> None: ...

    def timed(self) -> list[dict[str, Any]]: ...


@dataclass
class PlannedRun:
    """The work of one run: its sweeps, their order, and the place of their measurements."""

    results: Results
    number: int
    suite: Suite
    reference_solutions: dict[CaseSpec, ReferenceSolution]
    progress: Progress
    near_duplicates: bool
    shard: Mapping[str, str] = field(default_factory=dict)
    """Its shard, in the form of a run's environment."""
    again: dict[str, set[int]] = field(default_factory=dict)
    """By series, the launches that run in any suite, because they were interrupted or are to be repeated."""
    scorers: dict[CaseSpec, Scorer] = field(default_factory=dict)
    work: list[Work] = field(default_factory=list)
    later: Sequence[Series] = ()
    """Series that `sweeps` plans after the others have run, because their exact motions are computed first."""
    broken: dict[CaseSpec, str] = field(default_factory=dict)
    """The error messages of the cases without an exact motion."""
    further: Rounds | None = None
    """The rounds of repeated launches after the launches of the suite."""
    ended: str | None = None
    """The record of the rounds of the suite's last run in the file."""
    workers: int = WORKERS
    measured: int = 0
    """The number of trials that this run has measured."""

    def __post_init__(self) -> None:
        self.history = self.results.history()
        self.interruptions = self.results.interruptions()
        self.known: dict[str, list[int]] = {}
        for key, launch in self.history:
            self.known.setdefault(key, []).append(launch)

    def plan(self, all_series: Sequence[Series]) -> None:
        """Record the trials of all series; for pairs that cannot run, also record the status."""
        rows: list[dict[str, Any]] = []
        left_out: list[dict[str, Any]] = []
        for series in all_series:
            spec = CaseSpec.of(series.case, series.formulation)
            if spec not in self.reference_solutions:
                continue
            scorer = self._scorer(spec, series)
            trials = series.trials(scorer.problem(series.form), settings=self.suite.scope.settings)
            rows += [series.describe(trial, **scorer.summary()) for trial in trials]
            if self.history and series.left_out is None:
                self.reopen(series, trials, len(scorer.reference.turned) > 0 and not series.over_timing_span)
            if series.left_out is None:
                self.work.append((series, trials, scorer))
            elif (trials[0].key, 1) not in self.history:
                status, reason = series.left_out
                left_out.append({"trial_key": trials[0].key, "launch": 1, "status": status, "reason": reason})
        self.results.plan(self.number, rows)
        self.results.add_all(self.number, left_out)

    def sweeps(self) -> Iterator[Sweep | None]:
        """Every launch of every series that has trials to run, in the order of `order.places`.

        Every series is launched once before a series is launched again. A launch repeats the settings of the previous
        launch of its series, so it begins after that launch has ended. None means that all launches left must wait.
        """
        under_way = set[str]()
        self._predict()
        yield from self._sweeps(self._with_scatter(self._launches(self.work)), under_way)
        if self.later:
            while under_way:  # computing exact motions would disturb their times
                yield None
            known, broken = _reference_solutions(self.later, self.progress)
            self.reference_solutions |= known
            self.broken |= broken
            planned = len(self.work)
            self.plan(self.later)
            yield from self._sweeps(self._launches(self.work[planned:]), under_way)
        if self.further is not None:
            yield from self._rounds(self.further, under_way)

    def _predict(self) -> None:
        """Print the predicted time of the launches that are not in the file yet."""
        launches = self._with_scatter(self._launches(self.work))
        pending = [launch for launch in launches if launch.is_again or launch.pending(self.history)]
        count = sum(not launch.is_again for launch in pending)
        later = [series for series in self.later if series.left_out is None]
        costs = [(launch.series.id, self._cost(launch)) for launch in pending]
        costs += [(series.id, launch_seconds(series, self.suite, 1)) for series in later]
        text = f"predicted: {count + len(later)} series (a method on a problem each), "
        text += f"{duration_text(run_seconds(costs, self.workers))} on {count_text(self.workers, 'quiet core')}"
        if later:
            motions = len({CaseSpec.of(series.case, series.formulation) for series in later})
            text += f" and the time of {count_text(motions, 'exact motion')} that no earlier run has kept"
        if self.further is not None:
            text += f"; then repeated launches where comparisons are open, until {self.further.minutes:g} min at most"
        self.progress.tell(text)

    def _launches(self, works: Sequence[Work]) -> list[Launch]:
        """The launches of these series in their order."""
        places = order.places(series for series, *_ in works)
        launches = [Launch(number, *work) for work in works for number in self.launches(work[0])]
        return sorted(launches, key=lambda launch: (launch.number, places[launch.series.id]))

    def _with_scatter(self, launches: Sequence[Launch]) -> list[Launch]:
        """These launches with the additional launches that measure the scatter, spread among them."""
        fewest = max((launch.number for launch in launches), default=1) + 1
        first = {launch.series.id: launch for launch in launches if launch.number == 1}
        if len({launch.series.integrator.id for launch in launches}) < 2:
            return list(launches)  # nothing is compared
        again = [first[series.id] for series in order.choose_for_scatter(launch.series for launch in first.values())]
        blocks = [
            [Launch(number, launch.series, launch.trials, launch.scorer, is_again=True) for launch in again]
            for number in range(fewest, self.suite.timing.scatter_launches + 1)
        ]
        return order.spread(launches, blocks)

    def _rounds(self, further: Rounds, under_way: set[str]) -> Iterator[Sweep | None]:
        """Launch series with open comparisons again, in rounds that follow one another, until the time is spent.

        If this run measured nothing new and the last run of the suite recorded its rounds, no round begins.
        """
        while under_way:
            yield None
        if self.ended is not None and not self.measured:
            self.results.note(self.number, rounds.NAME, self.ended)
            return
        while (next_round := further.next()) is not None:
            number, chosen = next_round
            launches = []
            for series, trials, scorer in self.work:
                beside = tuple(trial for trial in trials if trial.setting in chosen.get(_name_series(series), ()))
                if beside:
                    launches.append(Launch(number, series, beside, scorer))
            yield from self._sweeps(launches, under_way, further.over)
            while under_way:
                yield None
        self.results.note(self.number, rounds.NAME, further.record())

    def _sweeps(
        self, launches: Sequence[Launch], under_way: set[str], over: Callable[[], bool] = lambda: False
    ) -> Iterator[Sweep | None]:
        """The launches that have trials to run, until the time is `over`."""
        pending = [launch for launch in launches if launch.is_again or launch.pending(self.history)]
        self.progress.begin("series", len(pending), sum(map(self._cost, pending)))

        def finished(launch: Launch) -> None:
            under_way.remove(launch.series.id)
            self.progress.advance(self._cost(launch))

        while pending and not over():
            place = next((k for k, launch in enumerate(pending) if launch.series.id not in under_way), None)
            if place is None:
                yield None
                continue
            launch = pending.pop(place)
            series, trials = launch.series, launch.pending(self.history)
            if not trials:
                self.progress.advance(self._cost(launch))
                continue
            under_way.add(series.id)
            suite, ended = self.suite.of(series.case), partial(finished, launch)
            record = self.history, self._record, ended, self.interruptions
            yield Sweep(series, trials, launch.scorer, suite, launch.number, *record)

    def _cost(self, launch: Launch) -> float:
        """The predicted seconds of a launch; for a launch of one setting, this share of the whole launch."""
        whole = launch_seconds(launch.series, self.suite, launch.number)
        return whole / (SETTINGS if launch.is_again else 1)

    def launches(self, series: Series) -> list[int]:
        """The launches of a series in this run."""
        suite = range(1, plan.launches(series, self.suite, self.near_duplicates) + 1)
        return sorted({*suite, *self.again.get(series.id, ())})

    def reopen(self, series: Series, trials: Sequence[Trial], symmetric: bool) -> None:
        """Remove from the history the results of these trials that this run must measure again.

        A trial to repeat is first recorded as interrupted: if this run ends early, the next one measures it, and no old
        measurement remains among new ones.
        """
        suite, repeat = self.suite.of(series.case), self.suite.repeat
        limit_seconds = suite.limit(series.case, series.integrator)
        marks: list[dict[str, Any]] = []
        for trial in trials:
            for launch in self.known.get(trial.key, ()):
                known = self.history[trial.key, launch]
                turned = symmetric and suite.scope.turned and launch == 1
                first = trial is trials[0] and plan.wants_first_use(series, suite, launch)
                repeated = repeat == Repeat.ALL or (repeat == Repeat.FROM_OUTSIDE and known.from_outside)
                if repeated:
                    row = {"trial_key": trial.key, "launch": launch, "status": Status.INTERRUPTED, "reason": TO_REPEAT}
                    marks.append(row)
                    self.interruptions.pop((trial.key, launch), None)
                if repeated or known.status == Status.INTERRUPTED:
                    self.again.setdefault(series.id, set()).add(launch)
                elif launch > self.suite.timing.launches or known.settles(
                    limit_seconds, turned, suite.timing.timed, first
                ):
                    continue
                del self.history[trial.key, launch]
        self.results.add_all(self.number, marks)

    def _scorer(self, spec: CaseSpec, series: Series) -> Scorer:
        if spec not in self.scorers:
            self.scorers[spec] = Scorer(series.case, series.formulation, self.reference_solutions[spec])
        return self.scorers[spec]

    def _record(self, measurement: Mapping[str, Any], options: Any, states: Any) -> None:
        self.measured += 1
        self.results.add(self.number, measurement, options, states)
        self.history[measurement["trial_key"], measurement["launch"]] = Known.of(measurement)

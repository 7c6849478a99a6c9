"""`gnomon run --dask`: the plan's series in tasks, which a Dask cluster runs, into the results file of this machine."""

from __future__ import annotations

import pickle
import secrets
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gnomon.cases import Case
from gnomon.harness.cluster.connection import Cluster, Lost, connect
from gnomon.harness.cluster.identity import identity
from gnomon.harness.cluster.task import Differs, Group, Packed, Row, execute, pack, rows
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.registry import environment
from gnomon.harness.registry.references import reference
from gnomon.harness.results.store import Store
from gnomon.harness.running.cost import divide, predict_seconds
from gnomon.harness.running.plan import Series, Suite, Trial
from gnomon.harness.running.planned_run import PlannedRun, Work, open_run
from gnomon.harness.running.sweep import Sweep
from gnomon.harness.system.limitations import need_fork
from gnomon.harness.system.progress import Progress

TASK_SECONDS = 4.0
"""The predicted cost of a task. Dask needs 1 ms for each task; a lost worker's task has to run again."""


def run(
    out: str | Path,
    suite: Suite,
    chosen: Sequence[tuple[Case, str]],
    integrators: Sequence[Integrator],
    address: str,
    progress: Progress | None = None,
    workers: int = 2,
    near_duplicates: bool = True,
) -> Path:
    """Run as `gnomon.harness.running.planned_run.run` does, on the Dask cluster at `address`; returns the path of the results.

    `address`: the address of a scheduler, or `local` for `workers` processes of this machine. A series that is complete
    in the file, from any machine, is not repeated. Raises ValueError before anything runs if versions or sources of a
    worker differ from this process, and Lost if the scheduler ends: an equal call then continues the run.
    """
    need_fork()
    path = Path(out) / "results.sqlite" if Path(out).suffix != ".sqlite" else Path(out)
    progress = progress or Progress(quiet=True)
    client = identity([case for case, _ in chosen], integrators)
    with connect(address, workers) as cluster:
        cluster.compare(client)
        with open_run(path, suite, chosen, integrators, progress, near_duplicates) as run_:
            _Distributed(run_, cluster, client).run()
    return path


@dataclass
class _Distributed:
    """A planned run, its cluster, and the versions and sources of the client, which workers must share."""

    run_: PlannedRun
    cluster: Cluster
    client: dict[str, str]
    runs: dict[str, int] = field(default_factory=dict)
    """The numbers of runs in the file, by machine: each machine has a run of its own there, with its environment."""
    exact: dict[CaseSpec, Packed] = field(default_factory=dict)

    def __post_init__(self) -> None:
        assert isinstance(self.run_.results, Store)
        self.store: Store = self.run_.results
        self.machines = [machine for machine in self.store.machines() if machine != environment.machine()]
        self.runs[environment.machine()] = self.run_.number

    def run(self) -> None:
        """Run all groups, and record their results as they come back."""
        groups = self._groups()
        self.run_.progress.begin("series", sum(map(len, groups)))
        name, failed = f"gnomon-{secrets.token_hex(4)}", list[str]()
        calls = (((self.client, self._content(group)), group) for group in groups)
        for group, answer in self.cluster.map(execute, calls, name):
            if isinstance(answer, Differs):
                raise answer
            if isinstance(answer, Exception):
                failed.append(f"{group[0][0].id}: {type(answer).__name__}: {answer}")
                continue
            self._record(group, *rows(answer))
            for _ in group:
                self.run_.progress.advance()
        for number in self.runs.values():
            self.store.end_run(number)
        if failed:
            raise Lost(f"{len(failed)} tasks failed, the first with {failed[0]}")

    def _groups(self) -> list[list[Work]]:
        """The series with trials to run, in groups of about TASK_SECONDS; series of one case are together."""
        run_ = self.run_
        pending = [work for work in run_.work if not self._finished(*work)]
        pending.sort(key=lambda work: work[0].id)
        costs = [predict_seconds(series, run_.suite, run_.near_duplicates) for series, _, _ in pending]
        return list(filter(None, divide(pending, costs, max(1, round(sum(costs) / TASK_SECONDS)))))

    def _finished(self, series: Series, trials: tuple[Trial, ...], scorer: Scorer) -> bool:
        """Whether a series is complete in the file, from one machine; plans it for machines that have measured it."""
        if self._complete(series, trials, scorer):
            return True
        for machine in self.machines:
            others = self._trials((series, trials, scorer), machine)
            if any((trial.key, 1) in self.run_.history for trial in others):
                self._plan(series, scorer, machine, others, self.run_.number)
                self.run_.reopen(series, others, len(scorer.reference.turned) > 0)
                if self._complete(series, others, scorer):
                    return True
        return False

    def _trials(self, work: Work, machine: str) -> tuple[Trial, ...]:
        """The trials of a series on a machine."""
        series, trials, scorer = work
        if machine == environment.machine():
            return trials
        return series.trials(scorer.problem(series.form), machine, self.run_.suite.scope.settings)

    def _complete(self, series: Series, trials: Sequence[Trial], scorer: Scorer) -> bool:
        """Whether all launches of a series have nothing left to measure or to skip."""
        run_, needed = self.run_, list[Any]()
        if (trials[0].key, 1) not in run_.history:
            return False
        suite = run_.suite.of(series.case)
        for launch in run_.launches(series):
            sweep = Sweep(
                series, trials, scorer, suite, launch, run_.history, lambda *row: needed.append(row), lambda: None
            )
            if sweep.next() is not None or needed:
                return False
        return True

    def _plan(self, series: Series, scorer: Scorer, machine: str, trials: Sequence[Trial], number: int) -> None:
        """Record the trials of a series on another machine as planned by a run of the file."""
        self.store.plan(number, [series.describe(trial, machine=machine, **scorer.summary()) for trial in trials])

    def _content(self, group: Sequence[Work]) -> bytes:
        """A group as the data of a task."""
        run_ = self.run_
        specs = [CaseSpec.of(series.case, series.formulation) for series, _, _ in group]
        for spec, (_, _, scorer) in zip(specs, group, strict=True):
            if spec not in self.exact:
                self.exact[spec] = pack(scorer.reference)
        measured = [
            (trial.key, launch)
            for work in (group if run_.history else ())
            for machine in (environment.machine(), *self.machines)
            for trial in self._trials(work, machine)
            for launch in {*range(1, run_.suite.timing.launches + 1), *run_.launches(work[0])}
        ]
        task = Group(
            run_.suite,
            run_.near_duplicates,
            tuple((reference(s.integrator), spec, s.label) for spec, (s, _, _) in zip(specs, group, strict=True)),
            {spec: self.exact[spec] for spec in specs},
            {key: run_.history[key] for key in measured if key in run_.history},
            {key: run_.interruptions[key] for key in measured if key in run_.interruptions},
            {series.id: run_.again[series.id] for series, _, _ in group if series.id in run_.again},
        )
        return pickle.dumps(task)

    def _record(self, group: Sequence[Work], worker: dict[str, str], measured: Sequence[Row]) -> None:
        """Record the measurements of a group. Raises ValueError for trials that do not belong to its series."""
        machine = worker["machine"]
        trials = [self._trials(work, machine) for work in group]
        if not {t.key for each in trials for t in each}.issuperset(row.get("trial_key") for row, _, _ in measured):
            raise ValueError(
                f"a worker on {machine} measured other trials than {group[0][0].id}: restart the workers, which"
                " have other sources or libraries than this process"
            )
        if machine not in self.runs:
            about = {**worker, **self.run_.shard}
            self.runs[machine] = self.store.begin_run(self.run_.suite.name, shlex.join(sys.argv), about)
        number = self.runs[machine]
        if number != self.run_.number:
            for (series, _, scorer), each in zip(group, trials, strict=True):
                self._plan(series, scorer, machine, each, number)
        self.store.add_batch(number, measured)

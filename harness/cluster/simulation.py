"""How a run would scale on a cluster: simulates its tasks from the times that a run on one machine took.

`python -m gnomon.harness.cluster.simulation RESULTS` prints the table of docs/cluster.md, from the results file of a
run with two processes.
"""

from __future__ import annotations

import argparse
import heapq
from collections import deque
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from gnomon.harness.cluster.connection import AHEAD, FEWEST_AHEAD
from gnomon.harness.cluster.dask_run import TASK_SECONDS
from gnomon.harness.contract.status import CANNOT_RUN, Status
from gnomon.harness.results import opening
from gnomon.harness.running.cost import divide, seconds_of

WORKERS = (1, 10, 100, 1000)
START_SECONDS = 3.0
"""Seconds from the start of a worker to its first trial: imports of the worker and of the server of its processes."""
SCHEDULER_SECONDS = 1e-3
"""The scheduler's time for a task, from Dask's documentation."""
RECORD_SECONDS = 0.28e-3
"""The client's time for a measurement with its states, measured by tests/benchmarks/test_cluster.py."""


class Measured(NamedTuple):
    """A series of a run: the seconds of all its launches, the predicted seconds, and the number of measurements."""

    seconds: float
    predicted: float
    rows: int


class Scaling(NamedTuple):
    """Seconds of a simulated run, and the seconds in which its scheduler and its client are busy."""

    seconds: float
    scheduler: float
    client: float


def read_measured(path: Path, processes: int = 2) -> list[Measured]:
    """The series of a results file in the order of their names.

    The time of a launch is counted from the end of the launch before it in the same process to its last measurement.
    The file does not record the process: each launch is assigned to the process whose last launch ended first.
    """
    marks = ", ".join("?" * (len(CANNOT_RUN) + 1))
    with opening.reading(path, ("runs", "trials", "measurements")) as db:
        launches = db.execute(
            'SELECT run, series, launch, min(recorded), max(recorded), count(*), library, variant != "default",'
            " max(limit_seconds), count(turned_starts) FROM measurements JOIN trials USING (trial_key) GROUP BY run, series, launch"
            f" HAVING sum(status NOT IN ({marks})) > 0 ORDER BY run, min(recorded)",
            (*CANNOT_RUN, Status.SKIPPED),
        ).fetchall()
    costs: dict[str, list[tuple[float, int, float]]] = {}
    ends, current = list[float](), 0
    for run, series, _, first, last, rows, library, hard, limit, turned in launches:
        began, ended = (datetime.fromisoformat(text).timestamp() for text in (first, last))
        if run != current:
            current, ends = run, [began] * processes
        seconds = max(0.0, ended - heapq.heapreplace(ends, max(ended, ends[0])))
        predicted = seconds_of(library, bool(hard), limit or 0.0, turned > 0)
        costs.setdefault(series, []).append((seconds, rows, predicted))
    return [
        Measured(sum(each[0] for each in of), sum(each[2] for each in of), sum(each[1] for each in of))
        for _, of in sorted(costs.items())
    ]


def simulate(tasks: Sequence[tuple[float, int]], workers: int) -> Scaling:
    """Simulate a run of tasks (seconds, measurements), of which the client keeps a limited number under way.

    Scheduler and client each do one thing at a time. Workers take the tasks in sequence.
    """
    waiting, ahead = deque(tasks), max(FEWEST_AHEAD, AHEAD * workers)
    free = [START_SECONDS] * workers
    under_way: list[tuple[float, int]] = []
    now = scheduler = scheduler_busy = client_busy = 0.0
    while waiting or under_way:
        if waiting and len(under_way) < ahead:
            seconds, rows = waiting.popleft()
            scheduler = max(now, scheduler) + SCHEDULER_SECONDS
            scheduler_busy += SCHEDULER_SECONDS
            ended = max(scheduler, free[0]) + seconds
            heapq.heapreplace(free, ended)
            heapq.heappush(under_way, (ended, rows))
        else:
            ended, rows = heapq.heappop(under_way)
            now = max(now, ended) + rows * RECORD_SECONDS
            client_busy += rows * RECORD_SECONDS
    return Scaling(now, scheduler_busy, client_busy)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path)
    series = read_measured(parser.parse_args().results)
    predicted = [measured.predicted for measured in series]
    parts = divide(series, predicted, round(sum(predicted) / TASK_SECONDS))
    tasks = [(sum(m.seconds for m in part), sum(m.rows for m in part)) for part in parts if part]
    longest, total = max(seconds for seconds, _ in tasks), sum(seconds for seconds, _ in tasks)
    print(f"{len(series)} series, {total:.0f} s in {len(tasks)} tasks, the longest {longest:.1f} s\n")
    print("| workers | run | workers busy | scheduler busy | client busy |\n|---|---|---|---|---|")
    for workers in WORKERS:
        run = simulate(tasks, workers)
        print(
            f"| {workers} | {run.seconds:.0f} s | {100 * total / workers / run.seconds:.0f} %"
            f" | {100 * run.scheduler / run.seconds:.0f} % | {100 * run.client / run.seconds:.0f} % |"
        )


if __name__ == "__main__":
    main()

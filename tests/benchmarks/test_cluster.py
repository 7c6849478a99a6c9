"""The costs of sharing a run between machines: recording and merging a measurement, a task, two Dask workers."""

import time
from contextlib import nullcontext
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import planted
import pytest
from gnomon.harness.registry import selection
from gnomon.harness.results.merging import merge
from gnomon.harness.results.store import Store
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run as run_here

TRIAL = {
    "case": "c", "variant": "default", "formulation": "standard", "library": "l", "integrator": "i", "policy": "",
    "setting_kind": "step", "machine": "m",
}  # fmt: skip
MEASURED = {"status": "ok", "error_max": 1e-3, "error_end": 1e-3, "rhs_calls": 1000, "seconds_median": 1e-3}
BATCH = 100
"""Measurements of one task, about."""


def batches(name: str, rows: int) -> tuple[list[Any], list[Any]]:
    """Trials, and their measurements with states of a system of four coordinates."""
    trials = [
        TRIAL | {"series": f"{name} {k}", "integrator_id": f"l:{name}", "setting": 1.0, "trial_key": f"{name} {k}"}
        for k in range(rows)
    ]
    states = np.random.default_rng(0).random((64, 4))
    measured = [({"trial_key": trial["trial_key"], "launch": 1} | MEASURED, {}, states) for trial in trials]
    return trials, [measured[k : k + BATCH] for k in range(0, rows, BATCH)]


def written(path: Path, name: str, rows: int) -> Path:
    trials, measured = batches(name, rows)
    with Store(path) as store:
        run = store.begin_run("quick", "gnomon run", {})
        store.plan(run, trials)
        for batch in measured:
            store.add_batch(run, batch)
        store.end_run(run)
    return path


def test_recording(benchmark: Any, tmp_path: Path) -> None:
    """The client's part in 100 measurements."""
    trials, measured = batches("a", 2000)
    with Store(tmp_path / "a.sqlite") as store:
        run = store.begin_run("quick", "gnomon run", {})
        store.plan(run, trials)
        waiting = iter(measured)
        benchmark.pedantic(lambda batch: store.add_batch(run, batch), setup=lambda: ((next(waiting),), {}), rounds=15)


@pytest.mark.slow
@pytest.mark.parametrize("rows", [1000, 4000, 16000])
def test_merging(benchmark: Any, tmp_path: Path, rows: int) -> None:
    """Two files of half the rows: the time a row does not depend on the number of rows."""
    files, targets = [written(tmp_path / f"{name}.sqlite", name, rows // 2) for name in "ab"], count()
    benchmark.extra_info["rows"] = rows
    benchmark.pedantic(lambda: merge(files, tmp_path / f"merged_{next(targets)}.sqlite"), rounds=3)


def nothing(content: bytes) -> bytes:
    return content


@pytest.mark.slow
def test_a_task(benchmark: Any) -> None:
    """200 calls that do nothing, with the data of a task: the costs of Dask and the connection."""
    pytest.importorskip("distributed", reason="needs Dask: pip install 'gnomon[cluster]'")
    from gnomon.harness.cluster.connection import connect

    content, names = bytes(50_000), count()
    with connect("local", 2) as cluster:
        calls = [((content,), k) for k in range(200)]
        benchmark.pedantic(lambda: list(cluster.map(nothing, calls, f"nothing-{next(names)}")), rounds=3)


@pytest.mark.slow
def test_two_dask_workers_against_two_processes(
    benchmark: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same series by two processes and by two Dask workers in turn, all started before: `efficiency` is the ratio
    of the shortest times."""
    pytest.importorskip("distributed", reason="needs Dask: pip install 'gnomon[cluster]'")
    from gnomon.harness.cluster.connection import connect
    from gnomon.harness.cluster.dask_run import run as run_on_cluster

    suite = plan.suite("quick").within(5.0).change(launches=2)
    chosen = [(case, f" {k}") for k in range(12) for case, _ in selection.choose(["planted:Short"], False)]
    places = count()

    def alone() -> None:
        run_here(tmp_path / f"{next(places)}", suite, chosen, [planted.Sound()], workers=2)

    def shared() -> None:
        run_on_cluster(tmp_path / f"{next(places)}", suite, chosen, [planted.Sound()], "local")

    with connect("local", 2) as cluster:
        monkeypatch.setattr("gnomon.harness.cluster.dask_run.connect", lambda *_: nullcontext(cluster))
        times: dict[Any, list[float]] = {alone: [], shared: []}
        for _ in range(3):
            for each in (alone, shared):
                began = time.perf_counter()
                each()
                times[each].append(time.perf_counter() - began)
        benchmark.pedantic(shared, rounds=1)
    benchmark.extra_info["efficiency"] = min(times[alone][1:]) / min(times[shared][1:])
    print({each.__name__: [round(t, 2) for t in of] for each, of in times.items()}, benchmark.extra_info)

"""A run on a real Dask scheduler has the results of a run on one machine, even if a worker or the scheduler ends."""

import sqlite3
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import planted
import pytest
from gnomon.harness.cluster import identity
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.status import STOPPED
from gnomon.harness.registry import environment, lookup, selection
from gnomon.harness.results import store
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run as run_here
from gnomon.harness.system.progress import Progress

pytest.importorskip("distributed", reason="needs Dask: pip install 'gnomon[cluster]'")

from command_line import gnomon
from dask_processes import Processes, connected
from gnomon.harness.cluster.connection import Lost
from gnomon.harness.cluster.dask_run import run as run_on_cluster
from waiting import LONG_SECONDS

SUITE = plan.suite("quick").within(LONG_SECONDS).untimed().change(name="cluster")
CASES = ["planted:Short"]
ANSWERS = [
    "series", "setting", "launch", "status", "reason", "error_max", "error_end", "error_rms", "rhs_calls", "steps",
]  # fmt: skip


def integrators() -> list[Integrator]:
    """Some that succeed, one of another library, one that crashes its process, one that declines."""
    found = [one for name in ("gnomon:DOP853", "scipy:DOP853") for one in lookup.find(name)]
    return [*found, planted.Sound(), planted.Aborts(), planted.Declines()]


def run(path: Path, address: str, progress: Progress | None = None, suite: Any = SUITE) -> Any:
    run_on_cluster(path, suite, selection.choose(CASES, False), integrators(), address, progress)
    return store.load(path)


def answers(frame: Any) -> Any:
    """The columns that do not depend on time, in a fixed order."""
    return frame.sort_values(["trial_key", "launch"])[["trial_key", *[n for n in ANSWERS if n in frame]]].reset_index(
        drop=True
    )


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """This run without a cluster."""
    folder = tmp_path_factory.mktemp("alone")
    run_here(folder, SUITE, selection.choose(CASES, False), integrators(), workers=2)
    return store.load(folder)


@pytest.fixture
def processes(tmp_path: Path) -> Iterator[Processes]:
    with Processes(tmp_path) as found:
        yield found


class After(Progress):
    """Calls each function once that number of series has come back."""

    def __init__(self, calls: dict[int, Callable[[], None]]) -> None:
        super().__init__(quiet=True)
        self.calls, self.count, self.name = calls, 0, ""

    def begin(self, name: str, total: int) -> None:
        self.count, self.name = 0, name

    def advance(self) -> None:
        if self.name == "series":
            self.count += 1
            self.calls.get(self.count, lambda: None)()


def ended(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()


@pytest.mark.slow
def test_workers_and_scheduler_are_killed_and_nothing_is_lost_or_repeated(
    tmp_path: Path, processes: Processes, alone: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worker dies first: its tasks run elsewhere. Then the scheduler dies: returned results stay, the run resumes on
    another cluster, and runs only the rest. A run without a cluster has the same trials and errors, faults included."""
    monkeypatch.setattr("gnomon.harness.cluster.dask_run.TASK_SECONDS", 0.1)  # one series a task
    path = tmp_path / "results.sqlite"
    address, scheduler = processes.scheduler()
    workers = [processes.worker(address) for _ in range(2)]
    connected(address, 2)
    kills = After({1: lambda: ended(workers[0]), 3: lambda: ended(scheduler)})
    with pytest.raises(Lost, match="connection to the scheduler was lost"):
        run(path, address, kills)
    before = measurements(path)
    assert 0 < len(before) < len(alone)

    address, _ = processes.scheduler()
    processes.worker(address)
    connected(address, 1)
    frame = run(path, address)
    after = measurements(path)
    assert after[: len(before)] == before, "the results that came back are not touched"
    assert len(after) == len({row[:2] for row in after}) == len(alone), "each trial and launch once"
    assert answers(frame).equals(answers(alone))
    assert {"ok", "crashed", "refused"} <= set(frame["status"])
    run(path, address)
    assert measurements(path) == after, "a complete run repeats nothing"


@pytest.mark.slow
def test_the_quick_suite_on_two_dask_workers_gives_the_results_of_two_processes(tmp_path: Path) -> None:
    """All cases and installed libraries of the suite; the clock decides which trials the limit ends, and those after them."""
    frames = []
    for name, more in (("here", ()), ("there", ("--dask", "local"))):
        path = tmp_path / f"{name}.sqlite"
        assert gnomon("run", "--suite", "quick", "--timing", "none", "--workers", "2", "--out", str(path), *more) == 0
        frames.append(answers(store.load(path)))
    assert frames[1]["trial_key"].equals(frames[0]["trial_key"])
    ended = frames[0]["status"].isin(STOPPED) | frames[1]["status"].isin(STOPPED)
    assert (~ended).sum() > 300
    assert frames[1][~ended].equals(frames[0][~ended])


def measurements(path: Path) -> list[tuple[Any, ...]]:
    query = "SELECT trial_key, launch, recorded, status, error_max FROM measurements ORDER BY measurement"
    with sqlite3.connect(path) as db:
        return db.execute(query).fetchall()


def test_a_worker_of_another_version_is_refused_by_name(tmp_path: Path, processes: Processes) -> None:
    """Before anything runs, in one line that names the worker, its version and the client's version."""
    (tmp_path / "other_version.py").write_text(
        "from gnomon.harness.registry import environment\n"
        "found = environment.versions() | {'numba': '0.1'}\n"
        "environment.versions = lambda: found\n"
    )
    address, _ = processes.scheduler()
    processes.worker(address)
    processes.worker(address, "--preload", str(tmp_path / "other_version.py"))
    connected(address, 2)
    own = environment.versions()["numba"]
    with pytest.raises(
        ValueError, match=rf"^the worker tcp://127\.0\.0\.1:\d+ has numba 0\.1, the client numba {own};"
    ):
        run(tmp_path / "runs", address)
    assert not (tmp_path / "runs").exists()


def test_a_module_that_is_not_the_clients_is_a_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker that lacks a user's module, or has another one, would measure something else."""
    wanted = identity.identity([], [planted.Sound()])
    assert identity.difference(wanted) is None
    assert identity.difference(wanted | {"module planted": "another"}) is not None
    assert "has module nowhere none" in str(identity.difference({"module nowhere": "1"}))


def test_an_integrator_of_the_script_that_runs_is_refused() -> None:
    """Workers could not import it."""
    mine = type("Mine", (planted.Sound,), {"__module__": "__main__"})
    with pytest.raises(ValueError, match="workers cannot import __main__; put the integrator"):
        identity.identity([], [mine()])


@pytest.mark.parametrize("address", ["nonsense", "tcp://host", "tcp://host:x", "carrier://host:1"])
def test_what_is_no_address_is_refused_before_a_client_is_made(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A client that was not made whole waits at the end of the process."""
    monkeypatch.setattr("distributed.Client", None)
    with pytest.raises(ValueError, match=f"--dask {address}: no scheduler answers there"):
        run(tmp_path, address)

"""Standard streams that are closed, flooded, or held open by processes that an integrator leaves behind."""

import os
import shlex
import signal
import subprocess
import sys
import tracemalloc
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import planted_attacks
import pytest
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.measuring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.results import store
from gnomon.harness.running import plan, worker
from gnomon.harness.running.pool import Pool
from gnomon.harness.running.sweep import task_of
from gnomon.harness.running.worker import Request
from gnomon.harness.system import child_process
from planted import Short
from waiting import LIMIT_SECONDS, LONG_SECONDS, wait_until, with_variable

HELPERS = Path(__file__).parents[1] / "helpers"
ODD_PROGRAM = HELPERS.parent / "harness" / "verification" / "odd_program.py"
GNOMON = [sys.executable, "-c", "from gnomon.harness.commands.cli import main; main()"]
QUICK = ["--case", "planted:Short", "--integrator", "planted:Sound", "--suite", "quick", "--limit", str(LONG_SECONDS)]
END_SECONDS = 240
"""A command that hangs fails its test after this; a busy machine takes less for one that does not."""


def ended(
    command: Sequence[str], folder: Path, closed: str = "", **environment: str
) -> subprocess.CompletedProcess[str]:
    """A command after its end, started by a shell with some of its streams closed."""
    return subprocess.run(
        ["sh", "-c", f'exec "$0" "$@" {closed}', *command],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(HELPERS)} | environment,
        capture_output=True,
        text=True,
        timeout=END_SECONDS,
        check=False,
    )


STREAMS = """
import os, subprocess, sys
from gnomon.harness.system.streams import open_standard_streams

open_standard_streams()
null = os.stat(os.devnull).st_rdev
assert [os.fstat(number).st_rdev == null for number in range(3)] == [True, False, True]
with open("mine", "w") as file:
    os.write(2, b"printed by a library")
    assert sys.stdin.read() == ""
    print("printed", file=sys.stderr, flush=True)
subprocess.run([sys.executable, "-c", "import os; os.fstat(0), os.fstat(2)"], check=True)
print(os.path.getsize("mine"))
"""


def test_a_file_does_not_take_the_place_of_a_closed_stream(tmp_path: Path) -> None:
    """Here and in a program that is started; an open stream stays as it is."""
    found = ended([sys.executable, "-c", STREAMS], tmp_path, "<&- 2>&-")
    assert (found.returncode, found.stdout) == (0, "0\n"), found


@pytest.mark.parametrize(
    "closed",
    ["<&- >&- 2>&-", *(pytest.param(one, marks=pytest.mark.slow) for one in ("2>&-", ">&-", "<&-"))],
)
def test_a_run_with_closed_streams_measures_what_any_run_does(closed: str, tmp_path: Path) -> None:
    found = ended([*GNOMON, "run", *QUICK, "--out", "results.sqlite"], tmp_path, closed)
    assert found.returncode == 0, found
    statuses = set(store.load(tmp_path / "results.sqlite")["status"])
    assert "ok" in statuses
    assert "crashed" not in statuses


SCRIPT = """
import gnomon

if __name__ == "__main__":
    found = gnomon.compare(gnomon.case("planted:Short"), "planted:Sound", limit_seconds={limit!r})
    statuses = {{row["status"] for row in found.rows}}
    assert "ok" in statuses and "crashed" not in statuses
"""


@pytest.mark.slow
def test_a_script_with_closed_streams_measures_too(tmp_path: Path) -> None:
    (tmp_path / "job.py").write_text(SCRIPT.format(limit=LONG_SECONDS))
    assert ended([sys.executable, "job.py"], tmp_path, "<&- >&- 2>&-").returncode == 0
    assert ended([sys.executable, "job.py"], tmp_path, "2>&-").returncode == 0


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("NUMBA_NUM_THREADS", "0", ("ValueError", "0")),
        pytest.param("SOURCE_DATE_EPOCH", "abc", ("ValueError", "abc"), marks=pytest.mark.slow),
    ],
)
def test_a_server_that_cannot_start_says_why_in_one_line(
    name: str, value: str, words: tuple[str, ...], tmp_path: Path
) -> None:
    """The libraries that it imports read these variables. The failure is not an interruption, which exits with 130."""
    found = ended([*GNOMON, "run", *QUICK, "--out", "results.sqlite"], tmp_path, **{name: value})
    assert found.returncode == 1, found
    (line,) = found.stderr.strip().splitlines()
    assert line.startswith("error: the server of the worker processes cannot start: ")
    assert all(word in line for word in words)


def test_a_server_that_dies_is_named_too() -> None:
    """A library that crashes at its import leaves no reason: the pipe ends."""
    with (
        pytest.raises(child_process.ServerFailed, match="ended without a reason"),
        child_process.starting(),
    ):
        raise EOFError


class Recorded:
    """One trial of a planted integrator, as a job of the pool."""

    limit_seconds = LONG_SECONDS

    def __init__(self, attack: str) -> None:
        (integrator,) = (one for one in planted_attacks.ATTACKS if one.name == attack)
        case = Short().rounded()
        self.task = task_of(plan.Series(case, None, integrator), reference_solution(CaseSpec.of(case)))
        self.requests = [Request(float(case.times[0]), True, 60.0, 100, 1.0)]
        self.rows = list[tuple[str, str, str, bool]]()

    def next(self) -> Request | None:
        return self.requests.pop() if self.requests else None

    def done(self, outcome: Outcome) -> None:
        self.rows.append(("done", "", outcome.output, False))

    def failed(self, status: Status, reason: str, output: str, tries: int | None = None) -> None:
        self.rows.append((status, reason, output, Path(self.task.output).exists()))


@pytest.mark.parametrize(
    "attack", ["prints without end", "starts a program that prints without end", "prints too much and answers"]
)
def test_output_without_end_ends_the_trial_and_keeps_no_space(attack: str) -> None:
    """With a status and a reason of its own, unlike a time limit or a full disk. The end of the output is kept."""
    job = Recorded(attack)
    Pool(1, "fork").run([job])
    ((status, reason, output, there),) = job.rows
    assert (status, reason) == (Status.CRASHED, "printed more than 64 MB in one call")
    length = len(output)
    assert 0 < length <= 4000
    assert not there, "its process may go on for a while: its file is removed at once"


@pytest.mark.parametrize("attack", ["has no standard streams", "prints megabytes"])
def test_odd_use_of_the_streams_is_no_failure(attack: str) -> None:
    """The output of 100 calls together, 180 MB, has no limit: an integrator does not choose the number of calls."""
    job = Recorded(attack)
    Pool(1, "fork").run([job])
    assert [status for status, *_ in job.rows] == ["done"]


def test_the_end_of_a_long_output_is_read_without_the_rest(tmp_path: Path) -> None:
    path = tmp_path / "output"
    with path.open("wb") as file:
        file.truncate(2**28)
        file.seek(0, os.SEEK_END)
        file.write(b"the end")
    tracemalloc.start()
    text = worker.take_output(str(path))
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert text.endswith("the end")
    assert most < 2**20
    assert path.stat().st_size == 0
    path.unlink()
    assert worker.take_output(str(path)) == "", "an integrator may remove files that it does not own"


LEAVES_A_DAEMON = """
import os, subprocess, sys

child = subprocess.Popen(["sleep", "600"], start_new_session=True)  # it inherits standard error
if os.fork() == 0:  # the other way to outlive a session: its parent ends
    os.setsid()
    if os.fork() == 0:
        os.execvp("sleep", ["sleep", "600"])
    os._exit(0)
os.wait()
print(child.pid, file=open(sys.argv[1], "w"))
os.execv(sys.executable, [sys.executable, *sys.argv[2:]])
"""
"""A program that leaves two processes in sessions of their own, and then is an integrator."""
DESCRIBES = """
import os, signal, sys
from gnomon.harness.verification import program_adapter
from gnomon.harness.verification.program_process import ProgramProcess

if sys.argv[1] == "killed":  # while the program runs
    ProgramProcess.close = lambda _self: os.kill(os.getpid(), signal.SIGKILL)
program_adapter.from_command(sys.argv[2:])
"""


@pytest.fixture
def daemons(tmp_path: Path) -> Any:
    """The words of a program that leaves processes in other sessions, and the file that has the number of one of them."""
    (tmp_path / "program.py").write_text(LEAVES_A_DAEMON)
    place = tmp_path / "number"
    yield [sys.executable, str(tmp_path / "program.py"), str(place), str(ODD_PROGRAM), "right"], place
    for number in with_variable("GNOMON_TEST", tmp_path):
        os.kill(number, signal.SIGKILL)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has subreapers")
@pytest.mark.parametrize("end", ["normal", "killed"])
def test_what_a_program_leaves_in_other_sessions_ends_with_gnomon(end: str, tmp_path: Path, daemons: Any) -> None:
    """Otherwise it runs on, and a step of a pipeline that reads standard error to its end never ends."""
    command, place = daemons
    found = ended([sys.executable, "-c", DESCRIBES, end, *command], tmp_path, GNOMON_TEST=str(tmp_path))
    assert found.returncode == (0 if end == "normal" else -signal.SIGKILL), found
    assert place.read_text(), "the program did start them"
    wait_until(lambda: not with_variable("GNOMON_TEST", tmp_path), "all that the program started has ended")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has subreapers")
@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "--suite", "quick", "--case", "planted:Short", "--out", "results.sqlite"],
        ["verify", "--case", "pendulum_simple", "--depth", "low"],
    ],
    ids=["run", "verify"],
)
def test_what_a_program_leaves_in_other_sessions_ends_with_a_command(
    arguments: list[str], tmp_path: Path, daemons: Any
) -> None:
    command, place = daemons
    ended([*GNOMON, *arguments, "--command", shlex.join(command)], tmp_path, GNOMON_TEST=str(tmp_path))
    assert place.read_text()
    wait_until(lambda: not with_variable("GNOMON_TEST", tmp_path), "all that the program started has ended")


KILLED = """
import os, sys
sys.path[:0] = {folders!r}
from test_streams import Recorded
from gnomon.harness.running.pool import Pool

if __name__ == "__main__":
    Pool(1, "fork").run([Recorded("leaves a fork and hangs")])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has subreapers")
def test_a_run_that_is_killed_leaves_no_process_in_another_session(tmp_path: Path) -> None:
    """kill -9 reaches the run alone; the kernel tells the guards of its workers."""
    (tmp_path / "job.py").write_text(KILLED.format(folders=sys.path))
    environment = os.environ | {"GNOMON_TEST": str(tmp_path), "GNOMON_ATTACKS": str(tmp_path)}
    process = subprocess.Popen([sys.executable, "job.py"], cwd=tmp_path, env=environment, start_new_session=True)
    try:
        wait_until((tmp_path / "forked").exists, "the integrator has forked")
        process.kill()
        process.wait()
        assert LIMIT_SECONDS < planted_attacks.END_SECONDS
        wait_until(lambda: not with_variable("GNOMON_TEST", tmp_path), "all processes of the run have ended")
    finally:
        for number in with_variable("GNOMON_TEST", tmp_path):
            os.kill(number, signal.SIGKILL)

"""Integrators that return invalid solutions or attack other processes; each is run by worker processes."""

import os
import pickle
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import planted
from gnomon.harness.contract.integrator import Problem, Solution
from passing_time import hang, wait_for_ever
from planted import Sound, runge_kutta, throw

FOLDER = Path(
    os.environ.setdefault("GNOMON_HOSTILE", os.path.join(tempfile.gettempdir(), f"gnomon-hostile-{os.getpid()}"))
)
"""The folder into which planted integrators write: named after the process that runs the tests, also in its workers."""
SLEEP_SECONDS = f"100{FOLDER.name.rpartition('-')[2]}"
"""The time that processes sleep which an integrator leaves: more than a day, and found by this number."""


fault = partial(planted.fault, module=__name__)
HalfACharacter = fault("HalfACharacter", lambda *_: throw(ArithmeticError("\ud800 planted")), early=True)
"""Raises an exception whose text cannot be encoded as UTF-8."""


class OddOptions(Sound):
    name = "odd options"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        sound = runge_kutta(problem, setting)

        def solve(initial_states: Any) -> Solution:
            return sound(initial_states)

        solve.options = 3  # type: ignore[attr-defined]
        return solve


def leave_child() -> None:
    command = ["sleep", SLEEP_SECONDS]
    subprocess.Popen(command, start_new_session=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)


def kill_server(solution: Solution, _: Any) -> Solution:
    """Kill the process above the one above it, once."""
    done = FOLDER / "killed"
    if not done.exists():
        done.touch()
        status = Path(f"/proc/{os.getppid()}/stat").read_text()
        os.kill(int(status.rpartition(")")[2].split()[1]), signal.SIGKILL)
        wait_for_ever()
    return solution


Forks = fault("Forks", lambda found, _: Solution(found.states + 0.01, found.steps) if os.fork() == 0 else found)
"""A forked process returns from `solve` too, with wrong states."""
LeavesChildren = fault("LeavesChildren", lambda found, _: (leave_child(), found)[1])
"""Each call leaves a child process, in a session of its own."""
LeavesChildrenAndAborts = fault("LeavesChildrenAndAborts", lambda *_: (leave_child(), os.abort()))
LeavesChildrenAndHangs = fault("LeavesChildrenAndHangs", lambda *_: (leave_child(), hang()))
KillsParent = fault("KillsParent", lambda *_: (os.kill(os.getppid(), signal.SIGKILL), wait_for_ever()))
"""Its own end follows; a solution sent before would count."""
KillsServer = fault("KillsServer", kill_server)
EndedFromOutside = fault("EndedFromOutside", lambda *_: os.kill(os.getpid(), signal.SIGKILL))
"""As by a user or by a machine without memory."""
DiskFull = fault("DiskFull", lambda *_: throw(OSError(28, "No space left", "/somewhere/cache")), early=True)


class Runs:
    """Runs a command when it is unpickled."""

    def __reduce__(self) -> Any:
        return (os.mkdir, (str(FOLDER / "unpickled"),))


def write_pickles(solution: Solution, _: Any) -> Solution:
    """To every pipe and socket of its process, as a message of multiprocessing."""
    content = pickle.dumps(("done", Runs()))
    message = len(content).to_bytes(4, "big") + content
    for descriptor in range(3, 64):
        try:
            os.write(descriptor, message)
        except OSError:
            continue
    return solution


Pickles = fault("Pickles", write_pickles)


class RaisesUnsupported(Sound):
    name = "raises unsupported"

    def unsupported(self, form: Any) -> str | None:
        raise LookupError("planted")


class OddUnsupported(Sound):
    name = "odd unsupported"

    def unsupported(self, form: Any) -> Any:
        return 7


class RaisesVersions(Sound):
    name = "raises versions"

    def versions(self) -> Mapping[str, Any]:
        raise LookupError("planted")


def with_(**attributes: Any) -> Sound:
    """A correct integrator with other declarations."""
    return type("Changed", (Sound,), {"__module__": __name__} | attributes)()  # type: ignore[no-any-return]


def commands() -> Iterable[str]:
    """The command line of each process."""
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            yield path.read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:
            continue  # the process has ended

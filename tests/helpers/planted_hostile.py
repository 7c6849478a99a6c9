"""Integrators that return invalid solutions or attack other processes; each is run by worker processes."""

import os
import pickle
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from gnomon.harness.contract.integrator import Problem, Solution
from planted import Sound, hang, runge_kutta

FOLDER = Path(
    os.environ.setdefault("GNOMON_HOSTILE", os.path.join(tempfile.gettempdir(), f"gnomon-hostile-{os.getpid()}"))
)
"""The folder into which planted integrators write: that of the process that runs the tests, also in its workers."""
SLEEP_SECONDS = f"100{FOLDER.name.rpartition('-')[2]}"
"""The time that processes sleep which an integrator leaves: more than a day, and found by this number."""


class Answers(Sound):
    """Integrates correctly and returns `answer` of the solution."""

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        sound = runge_kutta(problem, setting)
        return lambda initial_states: self.answer(sound(initial_states))

    def answer(self, solution: Solution) -> Any:
        raise NotImplementedError


class HalfACharacter(Sound):
    """Raises an exception whose text cannot be encoded as UTF-8."""

    name = "half a character"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        raise ArithmeticError("\ud800 planted")


class OddOptions(Sound):
    name = "odd options"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        sound = runge_kutta(problem, setting)

        def solve(initial_states: Any) -> Solution:
            return sound(initial_states)

        solve.options = 3  # type: ignore[attr-defined]
        return solve


class Forks(Answers):
    """A forked process returns from `solve` too, with wrong states."""

    name = "forks"

    def answer(self, solution: Solution) -> Any:
        if os.fork() == 0:
            return Solution(solution.states + 0.01, solution.steps)
        return solution


class LeavesChildren(Answers):
    """Each call leaves a child process, in a session of its own."""

    name = "leaves children"

    def answer(self, solution: Solution) -> Any:
        command = ["sleep", SLEEP_SECONDS]
        subprocess.Popen(command, start_new_session=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        return solution


class LeavesChildrenAndAborts(LeavesChildren):
    name = "leaves children and aborts"

    def answer(self, solution: Solution) -> Any:
        super().answer(solution)
        os.abort()


class LeavesChildrenAndHangs(LeavesChildren):
    name = "leaves children and hangs"

    def answer(self, solution: Solution) -> Any:
        super().answer(solution)
        hang()


class KillsParent(Answers):
    name = "kills its parent"

    def answer(self, solution: Solution) -> Any:
        os.kill(os.getppid(), signal.SIGKILL)
        hang()  # its own end follows; a solution sent before would count


class KillsServer(Answers):
    """Kills the process above the one above it, once."""

    name = "kills the server"

    def answer(self, solution: Solution) -> Any:
        done = FOLDER / "killed"
        if not done.exists():
            done.touch()
            status = Path(f"/proc/{os.getppid()}/stat").read_text()
            os.kill(int(status.rpartition(")")[2].split()[1]), signal.SIGKILL)
            hang()
        return solution


class EndedFromOutside(Answers):
    """Ended by SIGKILL, as by a user or by a machine without memory."""

    name = "ended from outside"

    def answer(self, solution: Solution) -> Any:
        os.kill(os.getpid(), signal.SIGKILL)
        return solution


class DiskFull(Sound):
    name = "disk full"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        raise OSError(28, "No space left on device", "/somewhere/cache")


class Runs:
    """Runs a command when it is unpickled."""

    def __reduce__(self) -> Any:
        return (os.mkdir, (str(FOLDER / "unpickled"),))


class Pickles(Answers):
    """Writes a pickle to every pipe and socket of its process, as a message of multiprocessing."""

    name = "pickles"

    def answer(self, solution: Solution) -> Any:
        content = pickle.dumps(("done", Runs()))
        message = len(content).to_bytes(4, "big") + content
        for descriptor in range(3, 64):
            try:
                os.write(descriptor, message)
            except OSError:
                continue
        return solution


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

"""Children of the supervisor: each call has its result, and no child can outlive or hold up its parent."""

import os
import signal
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import pytest
from gnomon.harness.system.supervisor import TICK_SECONDS, Child, Job, Send, calls, require, run
from waiting import wait_until


def divided(number: int) -> float:
    return 12 / number


def test_each_call_has_its_result_or_its_exception() -> None:
    """One that fails takes nothing from the others; each has the traceback of the process in its notes."""
    found = dict(calls(divided, [1, 2, 0, 3], 2, "fork"))
    assert isinstance(found[0], ZeroDivisionError)
    assert "divided" in found[0].__notes__[0]
    assert {n: require(result) for n, result in found.items() if n} == {1: 12.0, 2: 6.0, 3: 4.0}
    with pytest.raises(ZeroDivisionError):
        require(found[0])


@pytest.mark.parametrize("attempts", [1, 2, 3])
def test_a_call_that_ends_its_process_is_tried_again_and_alone_lost(tmp_path: Path, attempts: int) -> None:
    """It ends the first two processes that call it; all other calls have their results."""

    def call(number: int) -> int:
        tries = len(list(tmp_path.iterdir()))
        if number == 2 and tries < 2:
            (tmp_path / str(tries)).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return number

    found = dict(calls(call, range(6), 2, "fork", attempts=attempts))
    lost = found.pop(2)
    assert list(map(str, [lost])) == (["2"] if attempts == 3 else ["its process died of SIGKILL"])
    assert found == {n: n for n in (0, 1, 3, 4, 5)}
    assert len(list(tmp_path.iterdir())) == min(attempts, 2)


def is_running(number: str) -> bool:
    """Whether a process exists, and is not a zombie."""
    try:
        return "\nState:\tZ" not in Path(f"/proc/{number}/status").read_text()
    except OSError:
        return False


class Attack(Job):
    """A job whose process attacks instead of its first part, and answers the second part."""

    def __init__(self, act: Callable[[Connection], Any], place: Path) -> None:
        self.pending, self.limit, self.act, self.place = ["attack", "answer"], 0.2, act, place
        self.lost: list[str] = []
        self.answered: list[Any] = []

    def serve(self, connection: Connection) -> None:
        self.pipe = connection
        super().serve(connection)

    def work(self, send: Send) -> None:
        if self.pending[0] == "attack":
            self.place.write_text(str(os.getpid()))
            self.act(self.pipe)
            signal.pause()
        send("answer")

    def receive(self, message: Any) -> None:
        self.answered.append((self.pending.pop(), message))

    def lose(self, why: str, late: bool = False) -> None:
        del self.pending[0]
        self.lost.append(why)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells the child that its guard has ended")
@pytest.mark.parametrize(
    ("act", "why"),
    [
        (lambda _: os.kill(os.getppid(), signal.SIGSTOP), "no answer within 2 s"),
        (lambda _: os.kill(os.getpid(), signal.SIGSTOP), "no answer within 2 s"),
        (lambda _: os.closerange(3, 2**16), "its process closed its pipe"),
        (lambda pipe: os.write(pipe.fileno(), b"gnom"), "no answer within 2 s"),
    ],
    ids=["stops its guard", "stops itself", "closes all files", "sends a part of a message"],
)
def test_a_process_that_attacks_its_parent_is_killed_and_the_job_goes_on(
    act: Callable[[Connection], Any], why: str, tmp_path: Path
) -> None:
    """A guard that is stopped hears no request to end; a pipe that is closed, or half a message, says nothing more."""
    job = Attack(act, tmp_path / "number")
    run([job], 1)
    assert job.lost == [why]
    assert job.answered == [("answer", "answer")]
    wait_until(lambda: not is_running((tmp_path / "number").read_text()), "the process has ended")


@pytest.mark.parametrize(("load", "found"), [(0.0, None), (16.0, 3)])
def test_a_process_has_more_time_to_end_where_many_want_the_processor(
    load: float, found: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It ends at the 60th look; on a machine that does nothing else only the first ten are waited for."""

    class Ending:
        looks = 0

        @property
        def exitcode(self) -> int | None:
            self.looks += 1
            return 3 if self.looks >= 60 else None

    monkeypatch.setattr(os, "getloadavg", lambda: (load, 0.0, 0.0))
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    pipe: Any = None
    assert Child(Ending(), pipe, pipe, None).wait(10 * TICK_SECONDS) == found

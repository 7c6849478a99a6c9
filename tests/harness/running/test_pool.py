"""The process pool: deadlines by stage, tries, and workers that die, fork, fill memory or are interrupted.

The workers here run a script of the test instead of a series; no integrator is called and nothing is stored. The pool's
clock advances only if a worker says so, so that no result depends on the speed of the machine.
"""

import faulthandler
import itertools
import os
import signal
import time
from collections.abc import Callable
from dataclasses import replace
from multiprocessing import connection
from pathlib import Path
from typing import Any

import numpy as np
import planted
import pytest
from gnomon.harness.contract.status import THROUGHOUT, TRIES, Status
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.registry.references import reference
from gnomon.harness.running import messages, pool
from gnomon.harness.running.messages import Message
from gnomon.harness.running.pool import GRACE_SECONDS, LOST, RETRY_SECONDS, Pool
from gnomon.harness.running.worker import Request, Task, answer
from gnomon.harness.system import supervisor
from gnomon.harness.system.memory import worker_bytes
from gnomon.harness.system.supervisor import write
from passing_time import hang, say_hanging
from turned_clock import Clock
from waiting import LIMIT_SECONDS, wait_until

PREPARE, LIMIT, SHORT, BLOCK = 1000.0, 10.0, RETRY_SECONDS / 4, 3.0
"""Seconds: the deadline of a preparation, two limits of a trial, and the time of a block of calls."""
OUTCOME = Outcome(np.zeros((2, 1)), None, None, 1, 1, (1.0,), 1.0, None)
NOTHING = np.zeros((0, 1))
TASK = Task(b"", CaseSpec("", None, (), (), "1"), np.arange(1.0, 3.0), np.zeros(1), np.ones(1), 1.0, NOTHING, "")


class Job:
    """`count` requests; `rows` has a tuple for each that ended: "done", or status, reason and tries."""

    def __init__(self, count: int = 1, limit: float = LIMIT, task: Task = TASK) -> None:
        self.task, self.limit_seconds, self.left = task, limit, count
        self.rows: list[Any] = []

    def next(self) -> Request | None:
        self.left -= 1
        return None if self.left < 0 else Request(1.0, True, BLOCK, 3, 1.0)

    def done(self, outcome: Outcome) -> None:
        self.rows.append("done")

    def failed(self, status: Status, reason: str, output: str, tries: int | None = None) -> None:
        self.rows.append((status, reason, tries))


class Worker:
    """The actions of a script in the process of a worker."""

    def __init__(self, pipe: Any) -> None:
        self._pipe = pipe
        self.receive()

    def receive(self) -> None:
        self.number = self._pipe.recv().number

    def say(self, *stages: str, **content: Any) -> None:
        for stage in stages:
            write(self._pipe.fileno(), messages.encode(Message(self.number, stage, content, {})))

    def done(self) -> None:
        write(self._pipe.fileno(), messages.encode(answer(OUTCOME, self.number)))

    def write(self, content: bytes) -> None:
        os.write(self._pipe.fileno(), content)

    def close(self) -> None:
        self._pipe.close()


Script = Callable[[Worker], None]


@pytest.fixture
def ran(clock: Clock, monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[Any]]:
    """ran(script, job, workers=1): the rows of a job whose workers run a script."""

    def run(script: Script, job: Job, *others: Job, workers: int = 1) -> list[Any]:
        def serve(_task: Task, pipe: Any) -> None:
            faulthandler.disable()  # pytest's own would print the stack of a worker that aborts
            script(Worker(pipe))

        monkeypatch.setattr(pool, "serve", serve)
        Pool(workers, "fork", PREPARE).run([job, *others])
        return job.rows

    return run


def after(*stages: str) -> Script:
    """A script that says these stages and then nothing more."""

    def script(worker: Worker) -> None:
        worker.say(*stages)
        hang()

    return script


RUN = LIMIT + GRACE_SECONDS
UNPREPARED, NO_ANSWER = f"not prepared within {PREPARE:g} s", f"no answer within {LIMIT:g} s"


@pytest.mark.parametrize(
    ("stages", "seconds", "reason"),
    [
        ((), PREPARE, UNPREPARED),
        (("prepared",), RUN, NO_ANSWER),
        (("prepared", "counted"), PREPARE, UNPREPARED),
        (("prepared", "counted", "prepared"), RUN, NO_ANSWER),
        (("prepared", "calling"), RUN, NO_ANSWER),
        (("prepared", "calling", "extra"), PREPARE, UNPREPARED),
        (("prepared", "compiling"), PREPARE, UNPREPARED),
        (("prepared", "compiling", "compiled"), RUN, NO_ANSWER),
        (("prepared", "calling", "compiling", "compiled"), RUN, NO_ANSWER),
        (("prepared", "compiling", "compiling", "compiled"), RUN, NO_ANSWER),
    ],
    ids=lambda value: "-".join(value) or "start" if isinstance(value, tuple) else "",
)
def test_each_stage_has_its_deadline(
    ran: Any, clock: Clock, stages: tuple[str, ...], seconds: float, reason: str
) -> None:
    """A compilation during a call has the deadline of a preparation; after it the interrupted stage begins again."""
    assert ran(after(*stages), Job()) == [(Status.TIMEOUT, reason, 1)]
    assert clock.now == pytest.approx(seconds, abs=1e-3)


def test_a_trial_with_a_short_limit_is_tried_again(ran: Any, clock: Clock) -> None:
    """A stall of the machine is shorter than RETRY_SECONDS: only a trial that stops each time is a timeout."""
    assert ran(after("prepared"), Job(limit=SHORT)) == [(Status.TIMEOUT, f"no answer within {SHORT:g} s", TRIES)]
    assert clock.now == pytest.approx(TRIES * (SHORT + GRACE_SECONDS), abs=1e-3)


@pytest.mark.parametrize(("share", "tries"), [(1.0, 1), (0.5, TRIES)], ids=["ran", "stalled"])
def test_a_trial_that_ran_all_the_time_is_tried_once(
    ran: Any, clock: Clock, monkeypatch: pytest.MonkeyPatch, share: float, tries: int
) -> None:
    """No stall can have cost its time. One that ran for half of it may have been stopped by the machine."""
    monkeypatch.setattr(supervisor, "read_scheduled_seconds", lambda _guard: (share * clock.now, 0.0))
    ((status, reason, found),) = ran(after("prepared"), Job(limit=SHORT))
    assert (status, found, reason.endswith(THROUGHOUT)) == (Status.TIMEOUT, tries, tries == 1)
    assert clock.now == pytest.approx(tries * (SHORT + GRACE_SECONDS), abs=1e-3)


def test_a_stall_costs_no_trial(ran: Any, tmp_path: Path) -> None:
    """The same request goes to a new worker, and the series goes on there."""
    stalled = tmp_path / "stalled"

    def script(worker: Worker) -> None:
        worker.say("prepared")
        if not stalled.exists():
            stalled.touch()
            hang()
        worker.done()
        worker.receive()
        worker.done()

    assert ran(script, Job(2, SHORT)) == ["done", "done"]
    assert stalled.exists()


@pytest.fixture
def costly(monkeypatch: pytest.MonkeyPatch) -> None:
    """A new process costs more than all tries of a trial together, as one that compiles for seconds."""
    monkeypatch.setattr(pool, "monotonic", iter(range(0, 10**6, 100)).__next__)


def test_a_costly_worker_that_hangs_is_replaced_once(ran: Any, clock: Clock, costly: None, tmp_path: Path) -> None:
    """It has the time of all tries, so that no library gets less than another, but compiles anew only once."""

    def script(worker: Worker) -> None:
        (tmp_path / str(os.getpid())).touch()
        worker.say("prepared")
        hang()

    assert ran(script, Job(limit=SHORT)) == [(Status.TIMEOUT, f"no answer within {SHORT:g} s", TRIES)]
    assert clock.now == pytest.approx(TRIES * (SHORT + GRACE_SECONDS), abs=1e-3)
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("late", range(1, TRIES + 1))
def test_a_costly_worker_that_answers_late_tries_again(
    ran: Any, clock: Clock, costly: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, late: int
) -> None:
    """A late answer may come from a stall: the trial is tried again in this worker, which keeps what it compiled."""
    os.mkfifo(tmp_path / "late")
    true_wait, answers = clock.wait, list[float]()

    def wait(connections: list[Any], timeout: float) -> None:
        # It answers once the pool has seen that the deadline has passed: before, its answer would not be late.
        if answers and answers[-1] == clock.now and clock.hanging is not None:
            (tmp_path / "late").write_text("answer")
            clock.hanging = None
        before = clock.now
        true_wait(connections, timeout)
        if clock.now > before and clock.hanging is not None and len(answers) < min(late, TRIES - 1):
            answers.append(clock.now)

    def script(worker: Worker) -> None:
        for number in range(1, TRIES + 1):
            worker.say("prepared")
            if number <= late:
                say_hanging()
                (tmp_path / "late").read_text()
            worker.done()
            worker.receive()

    monkeypatch.setattr(supervisor, "wait", wait)
    timeout = (Status.TIMEOUT, f"no answer within {SHORT:g} s", TRIES)
    assert ran(script, Job(limit=SHORT)) == ["done" if late < TRIES else timeout]


@pytest.mark.parametrize(("share", "rows"), [(0.0, [(Status.TIMEOUT, NO_ANSWER, 1)]), (0.5, ["done"])])
def test_waiting_for_the_processor_extends_the_deadline(
    ran: Any, clock: Clock, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, share: float, rows: list[Any]
) -> None:
    """The kernel says how long a process was ready while others ran; here that is a share of the time. The worker answers
    after its limit, unless it was killed there."""
    os.mkfifo(tmp_path / "late")
    monkeypatch.setattr(supervisor, "read_scheduled_seconds", lambda _guard: (0.0, share * clock.now))
    true_wait = clock.wait

    def wait(connections: list[Any], timeout: float) -> None:
        true_wait(connections, timeout)
        if clock.now > 1.2 * RUN and clock.hanging is not None:
            (tmp_path / "late").write_text("answer")
            clock.hanging = None

    def script(worker: Worker) -> None:
        worker.say("prepared")
        say_hanging()
        (tmp_path / "late").read_text()
        worker.done()

    monkeypatch.setattr(supervisor, "wait", wait)
    assert ran(script, Job()) == rows


def end_with(code: int) -> Script:
    return lambda _worker: os._exit(code)


def end_by(number: int) -> Script:
    def script(_worker: Any) -> None:
        if number != signal.SIGKILL:
            signal.signal(number, signal.SIG_DFL)  # Python ignores SIGPIPE, and nohup SIGHUP
        os.kill(os.getpid(), number)

    return script


@pytest.mark.parametrize(
    ("script", "status", "reason"),
    [
        (end_with(0), Status.CRASHED, "the process ended with exit code 0"),
        (end_with(3), Status.CRASHED, "the process ended with exit code 3"),
        (lambda _worker: os.abort(), Status.CRASHED, "the process died of SIGABRT"),
        (end_by(signal.SIGSEGV), Status.CRASHED, "the process died of SIGSEGV"),
        (end_by(signal.SIGPIPE), Status.CRASHED, "the process died of SIGPIPE"),
        (end_by(signal.SIGKILL), Status.INTERRUPTED, "the process died of SIGKILL"),
        (end_by(signal.SIGHUP), Status.INTERRUPTED, "the process died of SIGHUP"),
        (lambda worker: worker.write(b"x" * 99), Status.CRASHED, "its process sent something that is not a message"),
        (lambda worker: worker.close(), Status.CRASHED, "its process closed its pipe"),
        (lambda worker: worker.say("lunch"), Status.CRASHED, "its process sent the stage 'lunch'"),
        (lambda worker: worker.say("failed", status="ok"), Status.CRASHED, "its process sent the status 'ok'"),
    ],
    ids=["exit 0", "exit 3", "abort", "fault", "pipe", "killed", "hangup", "garbled", "closed", "stage", "status"],
)
def test_a_worker_that_ends_or_sends_nonsense_fails_its_trial_alone(
    ran: Any, tmp_path: Path, script: Script, status: Status, reason: str
) -> None:
    """The end of a process from outside does not count against the integrator. A new worker continues the series."""
    began = tmp_path / "began"

    def first(worker: Worker) -> None:
        if began.exists():
            worker.done()
        else:
            began.touch()
            script(worker)
        signal.pause()

    failure, *rest = ran(first, Job(2))
    assert failure[0] is status
    assert failure[1].startswith(reason)
    assert failure[2] is None
    assert rest == ["done"]


@pytest.mark.parametrize("word", [Status.REFUSED, Status.CRASHED, Status.OUT_OF_MEMORY, Status.NOT_INSTALLED])
def test_only_after_a_refusal_the_series_goes_on_in_the_same_worker(ran: Any, tmp_path: Path, word: Status) -> None:
    def script(worker: Worker) -> None:
        with (tmp_path / "workers").open("a") as file:
            file.write("one\n")
        worker.say("failed", status=word, reason="because")
        worker.receive()
        worker.say("failed", status=word, reason="because")
        signal.pause()

    assert ran(script, Job(2)) == 2 * [(word, "because", None)]
    assert len((tmp_path / "workers").read_text().split()) == (1 if word is Status.REFUSED else 2)


@pytest.mark.parametrize("losses", [1, 2])
def test_a_loss_of_the_server_costs_no_trial_but_the_second_one_does(ran: Any, tmp_path: Path, losses: int) -> None:
    """Then the exit code of the worker is unknown: it may have been the worker that killed the server."""

    def script(worker: Worker) -> None:
        lost = len(list(tmp_path.iterdir()))
        if lost < losses:
            (tmp_path / str(lost)).touch()
            os._exit(LOST)
        worker.done()
        signal.pause()

    interrupted = (Status.INTERRUPTED, "the server of the worker processes was lost, twice", None)
    assert ran(script, Job()) == (["done"] if losses == 1 else [interrupted])


def test_an_answer_to_an_earlier_request_is_ignored(ran: Any) -> None:
    """A process that an integrator forked may answer an earlier request later."""

    def script(worker: Worker) -> None:
        worker.number -= 1
        worker.done()
        worker.number += 1
        worker.say("failed", status=Status.REFUSED, reason="the answer to this request")
        signal.pause()

    assert ran(script, Job()) == [(Status.REFUSED, "the answer to this request", None)]


def running(number: int) -> bool:
    """Whether a process exists, and is not a zombie."""
    try:
        return "\nState:\tZ" not in Path(f"/proc/{number}/status").read_text()
    except OSError:
        return False


def forking(folder: Path, end: Script) -> Script:
    """A script whose worker leaves a process in a session of its own, writes both numbers down, and ends."""

    def script(worker: Worker) -> None:
        child = os.fork()
        if child == 0:
            os.setsid()
            signal.pause()
        (folder / "processes").write_text(f"{os.getpid()} {child}")
        end(worker)

    return script


def assert_ended(folder: Path) -> None:
    """Both have ended, or end now: they were killed."""
    numbers = [int(word) for word in (folder / "processes").read_text().split()]
    assert len(numbers) == 2
    wait_until(lambda: not any(map(running, numbers)), f"processes {numbers} have ended")


def finish(worker: Worker) -> None:
    worker.done()
    signal.pause()


@pytest.mark.parametrize(
    ("end", "row"),
    [(finish, "done"), (after("prepared"), Status.TIMEOUT), (end_with(3), Status.CRASHED)],
    ids=["done", "timeout", "crashed"],
)
def test_no_process_of_a_worker_outlives_the_run(ran: Any, tmp_path: Path, end: Script, row: object) -> None:
    (found,) = ran(forking(tmp_path, end), Job())
    assert (found if row == "done" else found[0]) == row
    assert_ended(tmp_path)


def test_an_interruption_ends_all_workers_and_is_raised(
    ran: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It arrives while the second of two workers is served, and the first hangs long before its deadline."""
    monkeypatch.setattr(supervisor, "wait", lambda connections, _timeout: connection.wait(connections, LIMIT_SECONDS))

    class Interrupted(Job):
        def done(self, outcome: Outcome) -> None:
            wait_until((tmp_path / "written").exists, "the first worker runs")
            raise KeyboardInterrupt

    def mark(_worker: Worker) -> None:
        (tmp_path / "written").touch()
        signal.pause()

    def script(worker: Worker) -> None:
        (forking(tmp_path, mark) if worker.number == 1 else finish)(worker)

    with pytest.raises(KeyboardInterrupt):
        ran(script, Job(), Interrupted(), workers=2)
    assert_ended(tmp_path)


def task_of(kind: type[planted.Sound]) -> Task:
    """The short pendulum with an integrator, for the worker's own code."""
    case = planted.Short().rounded()
    start = np.array(case.initial_state, dtype=float)
    task = replace(TASK, integrator=reference(kind()), spec=CaseSpec.of(case), times=case.times, start=start)
    return replace(task, sizes=np.ones(2), turned=np.zeros((0, 2)))


@pytest.mark.parametrize(("kind", "status"), [(planted.Busy, "done"), (planted.Busier, Status.TIMEOUT)])
def test_the_limit_is_that_of_a_call(clock: Clock, kind: type[planted.Sound], status: object) -> None:
    """With the worker's own code: the timed calls of a trial may take longer together, and a single one may not."""

    class Trial(Job):
        def next(self) -> Request | None:
            found = super().next()
            return found and replace(found, setting=float(self.task.times[0]), slow_seconds=0.1)

    job = Trial(limit=0.6, task=task_of(kind))
    Pool(1, "fork", LIMIT_SECONDS).run([job])
    (found,) = job.rows
    assert (found if found == "done" else found[0]) == status
    assert clock.now > kind.counted_seconds + 0.6 + GRACE_SECONDS


def test_a_worker_has_a_share_of_the_memory() -> None:
    """With the worker's own code: the integrator asks for 512 GB."""
    job = Job(limit=LIMIT_SECONDS, task=task_of(planted.TakesMemory))
    Pool(3, "fork", LIMIT_SECONDS).run([job])
    ((status, reason, _),) = job.rows
    assert status is Status.OUT_OF_MEMORY
    assert f"needed more than {worker_bytes(3) / 2**30:.3g} GiB" in reason


class Rests:
    """An interlude that is due if `due` says so."""

    def __init__(self, due: Callable[[], bool], take: Callable[[], None]) -> None:
        self.due, self._take, self.taken = due, take, 0

    def take(self) -> None:
        self._take()
        self.taken += 1


def test_no_trial_overlaps_an_interlude(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A page that is drawn during a trial takes the processor and the caches from it: its time would be too long.

    All write into one file in the sequence of events. The pauses only give a wrong pool the opportunity to overlap."""
    log = tmp_path / "events"

    def note(what: str) -> None:
        with log.open("a") as file:
            file.write(what)

    def script(worker: Worker) -> None:
        while True:
            note("(")
            time.sleep(0.001 * (1 + worker.number % 3))
            note(")")
            worker.done()
            worker.receive()

    def rest() -> None:
        note("<")
        time.sleep(0.01)
        note(">")

    monkeypatch.setattr(pool, "serve", lambda _task, pipe: script(Worker(pipe)))
    jobs, rests = [Job(12), Job(12), Job(12)], Rests(lambda: next(asked) % 2 == 0, rest)
    asked = itertools.count(1)
    Pool(2, "fork", PREPARE).run(jobs, rests)
    assert [job.rows for job in jobs] == [["done"] * 12] * 3
    assert rests.taken >= 5
    events, trials, pauses = log.read_text(), 0, 0
    for event in events:
        trials += (event == "(") - (event == ")")
        pauses += (event == "<") - (event == ">")
        assert not (trials and pauses)
    assert events.count("(") == 36


def test_a_worker_that_waits_for_an_interlude_has_no_deadline(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """One worker has answered and waits while the other is busy for longer than the limit of the former."""
    os.mkfifo(tmp_path / "busy")
    os.mkfifo(tmp_path / "second")
    clock, paused = [0.0], []
    for module in (supervisor, pool):
        monkeypatch.setattr(module, "monotonic", lambda: clock[0])
    monkeypatch.setattr(supervisor, "read_scheduled_seconds", lambda _guard: (0.0, 0.0))
    first, second = Job(1, limit=10 * LIMIT), Job(3)

    def wait(connections: list[Any], _timeout: float) -> None:
        if len(second.rows) == 1 and not paused:  # the pool has seen that the interlude is due
            paused.append(True)
            (tmp_path / "second").write_text("answer")
        if len(second.rows) == 2 and clock[0] == 0:  # its third request waits
            clock[0] = 5 * LIMIT
            (tmp_path / "busy").write_text("no more")
        else:
            assert connection.wait(connections, LIMIT_SECONDS)

    def script(worker: Worker) -> None:
        while True:
            worker.say("prepared")
            if worker.number in (1, 3):
                (tmp_path / ("busy" if worker.number == 1 else "second")).read_text()
            worker.done()
            worker.receive()

    monkeypatch.setattr(supervisor, "wait", wait)
    monkeypatch.setattr(pool, "serve", lambda _task, pipe: script(Worker(pipe)))
    rests = Rests(lambda: bool(second.rows), lambda: None)
    Pool(2, "fork", PREPARE).run([first, second], rests)
    assert rests.taken
    assert [job.rows for job in (first, second)] == [["done"], ["done"] * 3]

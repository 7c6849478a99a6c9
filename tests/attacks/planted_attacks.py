"""Integrators that attack the run, each with the statuses that its trials may have.

Every fork takes one of few tokens, files that are made once, so that a failure of the harness cannot multiply forks.
Forked processes end by themselves after ten minutes.
"""

import atexit
import ctypes
import gc
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import mpmath
import numpy as np
from gnomon.harness.contract.integrator import Problem, Refused, Solution
from passing_time import hang, say_hanging, wait_for_ever
from planted import Sound, runge_kutta, throw

FOLDER = os.environ.get("GNOMON_ATTACKS", "")
"""The folder of the tokens; without it nothing forks."""
MOST_FORKS = 3
END_SECONDS = 600
"""Longer than tests wait for the end of such a process, which gnomon must end."""

Act = Callable[[Solution, Problem], Any]


def fork() -> bool:
    """Whether this is a forked child; forks only while there are tokens."""
    for number in range(MOST_FORKS if FOLDER else 0):
        try:
            os.close(os.open(os.path.join(FOLDER, f"fork-{number}"), os.O_CREAT | os.O_EXCL))
        except FileExistsError:
            continue
        if os.fork() == 0:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(END_SECONDS)
            return True
        return False
    return False


class Attack(Sound):
    """Integrates correctly, then calls `act`; with `early`, calls it in `prepare` instead."""

    library = "attack"

    def __init__(self, name: str, statuses: str, act: Act, early: bool = False) -> None:
        self.name = name  # type: ignore[misc]
        self.statuses = set(statuses.split())
        self.act, self.early = act, early

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        if self.early:
            self.act(Solution(np.zeros(1)), problem)
        sound = runge_kutta(problem, setting)
        return sound if self.early else lambda initial_states: self.act(sound(initial_states), problem)


ATTACKS: list[Attack] = []


def attack(statuses: str, early: bool = False) -> Callable[[Act], Act]:
    """Register a function as an attack."""

    def plant(act: Act) -> Act:
        ATTACKS.append(Attack(act.__name__.replace("_", " "), statuses, act, early))
        return act

    return plant


def answer(name: str, statuses: str, make: Callable[[Any], Any]) -> None:
    """Register an attack that returns `make(solution)`."""
    ATTACKS.append(Attack(name, statuses, lambda solution, _: make(solution)))


def call(name: str, statuses: str, act: Callable[[], Any], early: bool = False) -> None:
    """Register an attack that calls `act` and, if that returns, answers correctly."""
    ATTACKS.append(Attack(name, statuses, lambda solution, _: (act(), solution)[1], early))


# --- processes that end, exceptions and hangs ---

call("hangs", "timeout skipped", hang)
call("hangs while preparing", "timeout skipped", hang, early=True)


@attack("timeout skipped")
def ignores_all_signals_and_hangs(solution: Solution, _: Problem) -> Any:
    for number in signal.valid_signals() - {signal.SIGKILL, signal.SIGSTOP}:
        try:
            signal.signal(number, signal.SIG_IGN)
        except OSError:
            continue
    hang()


call("stops itself", "timeout skipped", lambda: (say_hanging(), os.kill(os.getpid(), signal.SIGSTOP), hang()))
call("exits", "crashed", sys.exit)
call("exits while preparing", "crashed", sys.exit, early=True)
call("exits at once", "crashed", lambda: os._exit(0))
call("aborts", "crashed", os.abort)
call("reads address zero", "crashed", lambda: ctypes.string_at(0))
call("sets an alarm", "crashed", lambda: (signal.setitimer(signal.ITIMER_REAL, 0.001), wait_for_ever()))
call("kills itself", "interrupted", lambda: os.kill(os.getpid(), signal.SIGKILL))
call("terminates its parent", "interrupted crashed", lambda: (os.kill(os.getppid(), signal.SIGTERM), wait_for_ever()))
call("raises an interrupt", "crashed", lambda: throw(KeyboardInterrupt()))
call("refuses", "refused", lambda: throw(Refused("planted")))


@attack("crashed")
def recurs_without_end(solution: Solution, problem: Problem) -> Any:
    return recurs_without_end(solution, problem)


class Unspeakable(Exception):  # noqa: N818
    def __str__(self) -> str:
        raise LookupError("planted")

    __repr__ = __str__


call("raises what cannot be printed", "crashed", lambda: throw(Unspeakable()))
answer("takes half a terabyte", "out_of_memory", lambda s: Solution(np.ones(2**36).reshape(1, 64, -1)))
call("takes a terabyte while preparing", "out_of_memory", lambda: bytearray(2**40), early=True)


# --- invalid solutions ---


class Raising:
    """Raises at every operation."""

    def __getattribute__(self, name: str) -> Any:
        raise LookupError("planted")

    def __repr__(self) -> str:
        raise LookupError("planted")


class RaisingSolution(Solution):
    """A solution whose states raise when they are read."""

    def __getattribute__(self, name: str) -> Any:
        if name == "states":
            raise LookupError("planted")
        return super().__getattribute__(name)


def _generator(solution: Solution) -> Iterator[Solution]:
    yield solution


answer("nan", "diverged", lambda s: Solution(s.states * np.nan, s.steps))
answer("infinite", "diverged", lambda s: Solution(s.states * np.inf, s.steps))
answer("complex states", "crashed", lambda s: Solution(s.states + 1e-9j, s.steps))
answer("transposed", "crashed", lambda s: Solution(np.swapaxes(s.states, 1, 2), s.steps))
answer("one state", "crashed", lambda s: Solution(s.states[0, 0], s.steps))
answer("no states", "crashed", lambda s: Solution(np.zeros((0, 64, 2)), s.steps))
answer("states as text", "crashed", lambda s: Solution(s.states.astype(str), s.steps))
answer("states as objects", "crashed", lambda s: Solution(s.states.astype(object), s.steps))
answer("a generator", "crashed", _generator)
answer("none", "crashed", lambda s: None)
answer("raising", "crashed", lambda s: Raising())
answer("raising states", "crashed", lambda s: RaisingSolution(s.states, s.steps))
answer("raising steps", "crashed", lambda s: Solution(s.states, Raising()))  # type: ignore[arg-type]
answer("1e30 steps", "crashed", lambda s: Solution(s.states, 10**30))
answer("-5 steps", "crashed", lambda s: Solution(s.states, -5))
answer("2^53 steps", "crashed", lambda s: Solution(s.states, 2**53))
answer("nan steps", "crashed", lambda s: Solution(s.states, float("nan")))  # type: ignore[arg-type]
answer("a number as reason", "crashed", lambda s: Solution(s.states, s.steps, 17))  # type: ignore[arg-type]
answer("an odd event", "crashed", lambda s: Solution(s.states, s.steps, None, ((float("nan"), "x"),)))
answer("read-only states", "ok", lambda s: (s.states.setflags(write=False), s)[1])
answer("states as wide floats", "ok", lambda s: Solution(s.states.astype(np.longdouble), s.steps))


@attack("crashed")
def counts_a_billion_calls_each_millisecond(solution: Solution, problem: Problem) -> Any:
    problem.buffer[-1] += 1e15
    return solution


@attack("crashed")
def counts_backwards(solution: Solution, problem: Problem) -> Any:
    problem.buffer[-1] = -1e9
    return solution


_GIVEN: list[Any] = []


@attack("ok")
def spoils_its_answers_at_the_next_call(solution: Solution, _: Problem) -> Any:
    for states in _GIVEN:
        states[:] = np.nan
    _GIVEN[:] = [solution.states]
    return solution


_SHARED = np.zeros((1, 128, 2))


@attack("ok")
def answers_with_views_of_one_buffer(solution: Solution, _: Problem) -> Any:
    _SHARED[:, ::2] = solution.states
    return Solution(_SHARED[:, ::2], solution.steps)


# --- attacks on other processes and on the worker ---


@attack("ok")
def forks_and_both_answer(solution: Solution, _: Problem) -> Any:
    return Solution(solution.states + 1.0, solution.steps) if fork() else solution


call("forks while preparing", "ok", fork, early=True)


@attack("ok")
def leaves_a_fork_that_waits(solution: Solution, _: Problem) -> Any:
    if fork():
        os.setsid()
        wait_for_ever()
    return solution


@attack("timeout skipped")
def leaves_a_fork_and_hangs(solution: Solution, _: Problem) -> Any:
    if fork():
        os.setsid()
        with open(os.path.join(FOLDER, "forked"), "w"):
            pass
        wait_for_ever()
    hang()


call(
    "leaves a program in a session of its own",
    "ok",
    lambda: subprocess.Popen(["sleep", str(END_SECONDS)], start_new_session=True),
)


@attack("ok")
def leaves_a_thread(solution: Solution, _: Problem) -> Any:
    if threading.active_count() < 4:
        threading.Thread(target=threading.Event().wait, daemon=False).start()
    return solution


call("closes every pipe", "crashed", lambda: os.closerange(3, 256))
call("closes its output", "ok crashed", lambda: os.closerange(0, 3))


@attack("crashed")
def writes_to_every_pipe(solution: Solution, _: Problem) -> Any:
    for descriptor in range(3, 64):
        try:
            os.write(descriptor, b"planted" * 1000)
        except OSError:
            continue
    return solution


call("prints megabytes", "ok", lambda: (print("planted" * 2**18), os.write(2, b"planted" * 2**18)))


@attack("crashed")
def prints_without_end(solution: Solution, _: Problem) -> Any:
    while True:
        os.write(2, b"planted" * 2**17)


call("starts a program that prints without end", "crashed", lambda: subprocess.run(["yes"], check=True))
call("prints too much and answers", "crashed", lambda: [os.write(1, b"x" * 10**6) for _megabyte in range(65)])


def replaces(name: str, statuses: str, module: str, **values: Any) -> None:
    """Register an attack that gives variables of a module other values."""
    call(name, statuses, lambda: vars(sys.modules[module]).update(values))


WORKER, MESSAGES = "gnomon.harness.running.worker", "gnomon.harness.running.messages"
replaces("has no standard streams", "ok", "sys", stdout=None, stderr=None)
replaces("replaces the clock", "crashed", "time", perf_counter=lambda: 0, perf_counter_ns=lambda: 0)
replaces("replaces the clock of the worker", "crashed", WORKER, perf_counter_ns=lambda: 0)
replaces("replaces functions of numpy", "ok refused crashed", "numpy", array_equal=lambda *_: True)
replaces("sends another answer", "crashed", MESSAGES, encode=lambda _message: b"gnom" + bytes(16) + b"planted" * 99)
call("makes numpy raise", "ok", lambda: np.seterr(all="raise"))
call("makes warnings raise", "ok", lambda: warnings.simplefilter("error"))
call("forbids recursion", "ok crashed", lambda: sys.setrecursionlimit(80))
call("hangs at exit", "ok", lambda: atexit.register(wait_for_ever))
call("turns off collection", "ok", lambda: (gc.disable(), gc.callbacks.append(lambda *_: None)))


@attack("ok")
def removes_its_folder(solution: Solution, _: Problem) -> Any:
    folder = tempfile.mkdtemp()
    os.chdir(folder)
    shutil.rmtree(folder)
    return solution


call("clears the environment", "ok", os.environ.clear)


@attack("ok")
def lowers_the_precision_of_mpmath(solution: Solution, _: Problem) -> Any:
    mpmath.mp.dps = 2
    return solution


INTEGRATORS = ATTACKS
"""The names by which a worker finds each."""

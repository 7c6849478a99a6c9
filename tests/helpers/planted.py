"""Integrators with planted faults, and a correct one (`Sound`): each is run by worker processes."""

import os
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, NoReturn

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Solution, Steps
from gnomon.harness.kernels.kept_code import announce
from gnomon.harness.measuring import prepared
from gnomon.harness.running import first_use, worker
from passing_time import hang, pass_time


def runge_kutta(problem: Problem, step: float) -> Callable[[Any], Solution]:
    """The classical Runge-Kutta method in Python, for states of two components."""
    form = problem.form
    assert isinstance(form, FirstOrder)
    parameters = tuple(problem.buffer[:-1].tolist())
    each = round(problem.interval / step)
    half = step / 2

    def f(t: float, x: float, v: float) -> Any:
        problem.buffer[-1] += 1
        return form.equations(t, (x, v), parameters)

    def solve(initial_states: Any) -> Solution:
        states = np.empty((1, len(problem.times), problem.dimension))
        x, v = initial_states[0].tolist()
        for k in range(len(problem.times)):
            for _ in range(each):
                x1, v1 = f(0.0, x, v)
                x2, v2 = f(0.0, x + half * x1, v + half * v1)
                x3, v3 = f(0.0, x + half * x2, v + half * v2)
                x4, v4 = f(0.0, x + step * x3, v + step * v3)
                x += step / 6 * (x1 + 2 * x2 + 2 * x3 + x4)
                v += step / 6 * (v1 + 2 * v2 + 2 * v3 + v4)
            states[0, k] = x, v
        return Solution(states, steps=each * len(problem.times))

    return solve


class Sound(Integrator):
    """The classical Runge-Kutta method. Order 4."""

    name, library, order = "sound", "planted", 4
    accepts = (FirstOrder,)
    sweep = Steps(coarsest=0.5, halvings=7)

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        return runge_kutta(problem, setting)


class HalfAMillisecond(Sound):
    """Each call takes half a millisecond by the worker's clock, which does not advance otherwise."""

    name = "half a millisecond"
    seconds = counted_seconds = 0.0005
    passed: ClassVar = 0

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        HalfAMillisecond.passed = HalfAMillisecond.passed or time.perf_counter_ns()
        worker.perf_counter_ns = prepared.perf_counter_ns = lambda: HalfAMillisecond.passed  # type: ignore[attr-defined]
        worker._verify_clocks = lambda: None  # it would notice the replaced clock
        sound, seconds = runge_kutta(problem, setting), self.counted_seconds if problem.counted else self.seconds

        def solve(initial_states: Any) -> Solution:
            self.take(seconds)
            return sound(initial_states)

        return solve

    def take(self, seconds: float) -> None:
        HalfAMillisecond.passed += round(seconds * 1e9)


class AsFast(HalfAMillisecond):
    """Takes the same time."""

    name = "as fast"


class Busy(HalfAMillisecond):
    """A call takes 0.27 s by the turned clock and the worker's clock, one of equations that count takes 0.57 s."""

    name = "busy"
    seconds, counted_seconds = 0.27, 0.57

    def take(self, seconds: float) -> None:
        pass_time(seconds)
        super().take(seconds)


class Busier(Busy):
    """A call takes 0.9 s after a counting run of 0.3 s."""

    name = "busier"
    seconds, counted_seconds = 0.9, 0.3


class NearDuplicate(Sound):
    """A near-duplicate of the correct one."""

    name, primary = "near_duplicate", False


class Hangs(Sound):
    """Never returns, from its third setting on."""

    name = "hangs"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        sound = runge_kutta(problem, setting)

        def solve(initial_states: Any) -> Solution:
            if round(problem.interval / setting) >= 8:
                hang()
            return sound(initial_states)

        return solve


class SlowAtFirst(Sound):
    """Prepares for 0.4 s where the folder for compiled code has nothing of it, and leaves something there. Its worker waits
    as long as a busy machine takes for its first use."""

    name = "slow at first"
    seconds = 0.4

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        first_use.MOST_SECONDS = 900.0
        kept = Path(os.environ.get("NUMBA_CACHE_DIR", "/nowhere")) / "slow at first"
        if kept.parent.name == "NUMBA_CACHE_DIR" and not kept.exists():
            kept.parent.mkdir(parents=True)
            kept.touch()
            time.sleep(self.seconds)
        return super().prepare(problem, setting)


class Compiles(Sound):
    """At its third setting, in each process, compiles for 1.5 s by the turned clock."""

    name = "compiles"
    compiled: ClassVar = False

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        sound = runge_kutta(problem, setting)

        def solve(initial_states: Any) -> Solution:
            if round(problem.interval / setting) == 8 and not Compiles.compiled:
                Compiles.compiled = True
                with announce():
                    pass_time(1.5)
            return sound(initial_states)

        return solve


class HalfAMillisecondAndHangs(HalfAMillisecond):
    """Takes as long by the worker's clock, and never returns, from its third setting on."""

    name = "half a millisecond and hangs"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        quick = super().prepare(problem, setting)
        return quick if round(problem.interval / setting) < 8 else lambda _starts: hang()


class CompilesAndHangs(Hangs):
    """Compiles in the call that never returns."""

    name = "compiles and hangs"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        hanging = super().prepare(problem, setting)

        def solve(initial_states: Any) -> Solution:
            with announce():
                pass
            return hanging(initial_states)

        return solve


def throw(error: BaseException) -> NoReturn:
    raise error


def fault(title: str, answer: Callable[[Any, Any], Any], early: bool = False, module: str = __name__) -> type[Sound]:
    """The class `title` of `module`: a correct integrator that returns `answer(solution, starts)`, or calls it `early`, in
    `prepare`. Its name is the title in words."""

    def prepare(self: Sound, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        if early:
            answer(None, None)
        sound = runge_kutta(problem, setting)
        return lambda starts: answer(sound(starts), starts)

    words = re.sub("([A-Z])", r" \1", title).strip().lower()
    held = {"__module__": module, "__qualname__": title, "name": words, "prepare": prepare}
    return type(title, (Sound,), held)


HangsInPrepare = fault("HangsInPrepare", lambda *_: hang(), early=True)
HangsAlways = fault("HangsAlways", lambda *_: hang())
Aborts = fault("Aborts", lambda *_: os.abort())
Exits = fault("Exits", lambda *_: os._exit(0))
NotANumber = fault("NotANumber", lambda found, _: Solution(found.states * np.nan, steps=1))
TooFew = fault("TooFew", lambda found, _: Solution(found.states[:, 1:], steps=1))
NoSolution = fault("NoSolution", lambda *_: None)
Raises = fault("Raises", lambda *_: (print("what it printed last"), throw(ArithmeticError("planted"))))
Declines = fault("Declines", lambda *_: throw(Refused("the step is too beautiful")), early=True)
DoesNothing = fault("DoesNothing", lambda _, starts: Solution(np.repeat(starts[:, np.newaxis], 64, axis=1), steps=0))
TakesMemory = fault("TakesMemory", lambda *_: Solution(np.ones(2**36).reshape(1, 64, -1)))


class RaisesAtLargeSteps(Sound):
    """Raises as an overflow would."""

    name = "raises at large steps"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        if setting == problem.interval:
            raise OverflowError("planted")
        return super().prepare(problem, setting)


class MissingLibrary(Sound):
    name = "missing library"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        import a_library_that_is_not_installed  # type: ignore[import-not-found]

        return a_library_that_is_not_installed.solve  # type: ignore[no-any-return]


class IntegratesInPrepare(Sound):
    """Remembers the last initial state that it was given, integrates it while preparing, and returns that."""

    name = "integrates in prepare"
    seen: ClassVar[list[Any]] = []

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        sound = runge_kutta(problem, setting)
        known = runge_kutta(problem, problem.interval / 32)(self.seen[-1]) if self.seen else None

        def solve(initial_states: Any) -> Solution:
            self.seen.append(initial_states.copy())
            return sound(initial_states) if known is None else known

        return solve


class Memoises(Sound):
    """Integrates an initial state once, and returns the result again for the same bits at all settings. It prints which
    of both each call did."""

    name = "memoises"
    known: ClassVar[dict[bytes, Solution]] = {}

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        sound = runge_kutta(problem, setting)

        def solve(initial_states: Any) -> Solution:
            key = initial_states.tobytes()
            print("kept" if key in self.known else "integrated")
            if key not in self.known:
                self.known[key] = sound(initial_states)
            return self.known[key]

        return solve


class ChangesInput(Sound):
    """Overwrites its arguments."""

    name = "changes its input"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        sound = runge_kutta(problem, setting)

        def solve(initial_states: Any) -> Solution:
            solution = sound(initial_states)
            initial_states[:] = np.nan
            problem.parameters[:] = np.nan
            problem.times[:] = np.nan
            return solution

        return solve


class SharesOutput(Sound):
    """Returns the same array each time, with new contents."""

    name = "shares its output"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        sound = runge_kutta(problem, setting)
        states = np.empty((1, 64, problem.dimension))

        def solve(initial_states: Any) -> Solution:
            solution = sound(initial_states)
            states[:] = solution.states
            return Solution(states, solution.steps)

        return solve


class Short(PendulumSimple):
    """The pendulum over two of its periods: fast in Python too."""

    name = "short_pendulum"
    default_span = "5.4"
    variants = ()

    def natural_span(self) -> Any:
        return self.default_span


assert issubclass(Short, Case)

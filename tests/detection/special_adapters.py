"""Adapters for the methods of right_methods.py that are neither a step nor a solver: events, rotations, an engine."""

import atexit
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder, Hybrid, RigidBody
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Solution, Solver, Steps
from gnomon.harness.verification.engine_adapter import from_engine
from gnomon.harness.verification.function_adapter import from_solve, right_hand_side
from gnomon.harness.verification.program_adapter import from_command


class _OneByOne(Integrator):
    """A fixed step; `function` makes one trajectory (n, dim) and its events."""

    function: ClassVar[Callable[..., Any]]

    def prepare(self, problem: Problem, setting: float) -> Solver:
        if not 0 < setting <= problem.interval * 1.01:
            raise Refused(f"step size {setting} is not between 0 and the sampling interval, {problem.interval}")
        return Solver(partial(self.solved, problem, setting))

    def solved(self, problem: Problem, setting: float, starts: Any) -> Solution:
        with np.errstate(all="ignore"):
            runs = [self.trajectory(problem, setting, start) for start in starts]
        steps = round(float(problem.elapsed[-1]) / setting) * len(runs)
        return Solution(np.array([states for states, _ in runs]), steps, events=runs[0][1])

    def trajectory(self, problem: Problem, setting: float, start: Any) -> Any: ...


class _Events(_OneByOne):
    accepts = (Hybrid,)
    counts_rhs = False

    def trajectory(self, problem: Problem, setting: float, start: Any) -> Any:
        if not np.all(np.isfinite(start)):
            raise Refused("the start is not finite")
        numbers = problem.parameters.tolist()
        return type(self).function(problem.form, numbers, problem.t0, start, problem.times, setting)


class _Form(_OneByOne):
    counts_rhs = False

    def trajectory(self, problem: Problem, setting: float, start: Any) -> Any:
        numbers = tuple(problem.parameters.tolist())
        try:
            return type(self).function(problem.form, numbers, problem.t0, start, problem.times, setting)
        except (ArithmeticError, ValueError):
            return np.full((len(problem.times), problem.dimension), np.nan), None


class _Ensemble(_OneByOne):
    accepts = (FirstOrder,)

    def solved(self, problem: Problem, setting: float, starts: Any) -> Solution:
        if problem.times[-1] < problem.t0:
            raise Refused("the times fall")
        f = right_hand_side(problem)
        with np.errstate(all="ignore"):
            states = type(self).function(f, problem.t0, starts, problem.times, setting)
        return Solution(states, round(float(problem.elapsed[-1]) / setting) * len(starts))


class _Rotation(_OneByOne):
    accepts = (RigidBody,)
    counts_rhs = False

    def trajectory(self, problem: Problem, setting: float, start: Any) -> Any:
        form, p = problem.form, tuple(problem.parameters.tolist())
        assert isinstance(form, RigidBody)
        moments, law = np.array(form.inertia(p), dtype=float), form.torque

        def torque(t: float, w: Any, attitude: Any) -> Any:
            return np.array(law(t, (*w.tolist(), *attitude.ravel().tolist()), p))

        count = round(problem.interval / setting)
        w, attitude, found = start[:3], start[3:].reshape(3, 3), []
        for k in range(len(problem.times)):
            for i in range(count):
                t = problem.t0 + k * problem.interval + i * setting
                w, attitude = type(self).function(moments, torque, t, w, attitude, setting)
            found.append([*w, *attitude.ravel()])
        return np.array(found), None


def _made(
    base: type[_OneByOne],
    function: Any,
    name: str,
    library: str,
    order: int,
    sweep: Steps,
    conserves: tuple[str, ...] = (),
    **more: Any,
) -> Integrator:
    declared = {"name": name, "order": order, "sweep": sweep, "conserves": conserves, **more}
    kind = type(name, (base,), declared | {"library": library, "function": staticmethod(function)})
    made: Integrator = kind()
    return made


def from_events(function: Any, **declared: Any) -> Integrator:
    """The integrator that calls `function(form, parameters, t0, y0, times, step)` -> (states, events)."""
    return _made(_Events, function, **declared)


def from_rotation(function: Any, **declared: Any) -> Integrator:
    """The integrator of `function(moments, torque, t, w, R, h)` -> (w, R), R from the body's axes to space axes."""
    return _made(_Rotation, function, **declared)


def from_form(function: Any, **declared: Any) -> Integrator:
    """The integrator that calls `function(form, parameters, t0, y0, times, step)` -> (states, None), with `accepts`."""
    return _made(_Form, function, **declared)


def from_rising(function: Any, **declared: Any) -> Integrator:
    """As `from_solve`, of a function that is written for times that rise."""

    def solve(f: Any, t0: float, y0: Any, times: Any, setting: float) -> Any:
        if times[-1] < t0:
            raise Refused("the times fall")
        return function(f, t0, y0, times, setting)

    return from_solve(solve, **declared)


def from_compensated(function: Any, make: Any = from_solve, **declared: Any) -> Integrator:
    """As `make`, of a method that declares that its sums over steps are compensated."""
    made: Integrator = make(function, **declared)
    type(made).compensated = True
    return made


def from_ensemble(function: Any, **declared: Any) -> Integrator:
    """The integrator that calls `function(f, t0, starts, times, step)` -> states (n, times, dim)."""
    return _made(_Ensemble, function, **declared)


def from_engine_class(engine: Any, *, library: str, **declared: Any) -> Integrator:
    """The integrator that drives an engine."""
    return from_engine(engine, **declared)


def from_class(base: type[Integrator], *, name: str, **declared: Any) -> Integrator:
    """An instance of a class, with these declarations."""
    made: Integrator = type(base.__name__, (base,), {"name": name, **declared, "__module__": base.__module__})()
    return made


def from_program(function: Any, **declared: Any) -> Integrator:
    """The text of a function's module as a program, which has its declarations itself."""
    folder, owner = tempfile.mkdtemp(), os.getpid()
    atexit.register(lambda: shutil.rmtree(folder, ignore_errors=True) if os.getpid() == owner else None)
    program = Path(folder, f"{function.__name__}.py")
    program.write_text(function.__globals__["TEXT"])
    return from_command([sys.executable, str(program)])

"""Integrators made of plain functions: `from_step` for one step of a method, `from_solve` for a whole solver.

The user's function, of Python, numba or JAX, receives `f(t, y)`, which returns the derivative of the state as a new float64
array; its calls are counted. With `accelerations` it receives `f(t, q)`, which returns the accelerations of the positions
q, the first half of y, and with `velocities` `f(t, q, v)`. A parameter `jac` receives the Jacobian of f.
"""

from __future__ import annotations

import contextlib
import importlib
import inspect
import math
import sys
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder, SecondOrder
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Solver, Steps, Tolerance, each_start
from gnomon.harness.contract.validation import Unusable, require_positive, short
from gnomon.harness.contract.velocity_forces import VelocityForces, require_velocities
from gnomon.harness.registry import declaration, lookup
from gnomon.harness.verification.functions.right_hand_side import Jacobian, RightHandSide
from gnomon.reference.storage.importing import confined
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Function = Callable[..., Any]

TINY = 2.0**-30
"""The part of a span over which a function is called so that JAX compiles it."""
LEAST_TOLERANCE = 2.0**-52
STEP_ARGUMENTS = 4
"""The number of arguments of a step, without `jac`; a solver has one more."""
ARGUMENTS = "a step takes (f, t, y, h), a solver (f, t0, y0, times, tolerance)"
MOST_STEPS = 10**8
"""A smaller tolerance, or more steps, are refused as mistakes."""


def from_step(
    step: Function,
    *,
    name: str,
    order: int | None = None,
    sweep: Steps | None = None,
    conserves: tuple[str, ...] = (),
    accelerations: bool = False,
    velocities: bool = False,
    jacobian: str = "exact",
    library: str = "mine",
) -> Integrator:
    """Make an integrator from a function that makes one step.

    Parameters
    ----------
    step : callable
        ``step(f, t, y, h)`` returns the state at t + h, shape (dim,). ``f(t, y)`` is the derivative of the state. A step
        with a parameter `jac` is also given ``jac(t, y)``, the exact Jacobian of f by y, shape (dim, dim); by q for
        `accelerations`, and by q and v, shape (dim/2, dim), for `velocities`. numba or JAX may compile the step.
    name : str
        The name of the method.
    order : int, optional
        The order of convergence that the method claims.
    sweep : Steps, optional
        The step sizes to run at.
    conserves : tuple of str
        The properties that hold at any step size, see `Integrator`.
    accelerations : bool
        Whether f is ``f(t, q)`` and returns accelerations; the positions q are the first half of y.
    velocities : bool
        Whether f is ``f(t, q, v)`` and returns accelerations, which may depend on the velocities v, the second half of y.
    jacobian : {"exact", "differences"}
        "differences" if the method differentiates f numerically, in the state or in time: bounds then allow the error
        of the differences.
    library : str
        The name of the library, the first part of the integrator's id.

    Returns
    -------
    Integrator
        It makes equal steps between samples.

    Raises
    ------
    ValueError
        For a wrong declaration.

    Examples
    --------
    >>> from gnomon.verify import from_step
    >>> euler = from_step(lambda f, t, y, h: y + h * f(t, y), name="Euler", order=1)
    """
    return _make_adapter(
        Stepped, step, (accelerations, velocities),
        name=name, library=library, order=order, conserves=conserves, jacobian=jacobian, sweep=sweep or Steps(),
    )  # fmt: skip


def from_solve(
    solve: Function,
    *,
    name: str,
    order: int | None = None,
    sweep: Tolerance | Steps | None = None,
    dense_order: int | None = None,
    conserves: tuple[str, ...] = (),
    accelerations: bool = False,
    velocities: bool = False,
    jacobian: str = "exact",
    library: str = "mine",
) -> Integrator:
    """Make an integrator from a whole solver.

    Parameters
    ----------
    solve : callable
        ``solve(f, t0, y0, times, tolerance)`` returns the states at `times`, shape (n, dim), from `y0`, shape (dim,),
        at `t0`. With a `sweep` of Steps the last argument is the step size. A solver that gives up raises
        `gnomon.verify.Refused`, or returns nan for the samples that it did not reach. `jac`, numba and JAX are as in
        `from_step`.
    name : str
        The name of the method.
    order : int, optional
        The order of convergence that the method claims.
    sweep : Tolerance or Steps, optional
        The settings to run at; by default tolerances from 1e-3 to 1e-12.
    dense_order : int, optional
        The order of the interpolant that gives the states at `times`, 0 if unknown; None if steps end at `times`.
    conserves : tuple of str
        The properties that hold at any step size, see `Integrator`.
    accelerations : bool
        Whether f is ``f(t, q)`` and returns accelerations; the positions q are the first half of y.
    velocities : bool
        Whether f is ``f(t, q, v)`` and returns accelerations, which may depend on the velocities v, the second half of y.
    jacobian : {"exact", "differences"}
        "differences" if the method differentiates f numerically, in the state or in time: bounds then allow the error
        of the differences.
    library : str
        The name of the library, the first part of the integrator's id.

    Returns
    -------
    Integrator
        An instance of a class of its own, which can declare more: ``type(mine).compensated = True``.

    Raises
    ------
    ValueError
        For a wrong declaration.

    Examples
    --------
    >>> import numpy as np
    >>> from gnomon.verify import from_solve
    >>> from scipy.integrate import solve_ivp
    >>> def solve(f, t0, y0, times, tolerance):
    ...     found = solve_ivp(f, (t0, times[-1]), y0, t_eval=times, rtol=tolerance, atol=tolerance)
    ...     return found.y.T
    >>> rk45 = from_solve(solve, name="RK45", order=5, dense_order=4)
    """
    sampling = "stops at samples" if dense_order is None else "dense output"
    return _make_adapter(
        _Solved, solve, (accelerations, velocities),
        name=name, library=library, order=order, conserves=conserves, jacobian=jacobian,
        sweep=sweep or Tolerance(1e-3, 1e-12), sampling=sampling, dense_order=dense_order or None,
    )  # fmt: skip


class FunctionAdapter(Integrator):
    """An integrator made of a plain function, which solves from several starts one after the other."""

    function: ClassVar[Function]
    velocities: ClassVar[bool] = False
    compiles: ClassVar[bool] = False
    """Whether the first call may take longer than others, because it compiles."""

    def prepare(self, problem: Problem, setting: float) -> Solver:
        self.validate(problem, setting)
        if self.velocities and isinstance(problem.form, FirstOrder):
            require_velocities(problem)
        f = RightHandSide(problem, self.velocities)
        function = type(self).function
        if takes_jacobian(function):
            function = partial(function, jac=Jacobian(problem, self.velocities))
        call = partial(function, f)
        self.compile()
        self.warm_up(f, call, problem, setting)

        def solve_one(start: Floats, out: Floats) -> tuple[int | None, None]:
            f.begin()
            steps = self.trajectory(call, problem, setting, start, out)
            f.end()
            return steps, None

        return Solver(each_start(problem, solve_one))

    def compile(self) -> None:
        """Compile a function of numba for its arguments, which are of one type for all cases."""
        function = type(self).function
        if not is_of_numba(function):
            return
        # numba, which takes a second to load, is loaded already.
        from gnomon.harness.verification.functions import numba_calls

        with contextlib.suppress(Exception):  # the call itself raises it, and says where
            function.compile(numba_calls.signature(inspect.signature(function), self.velocities))  # type: ignore[attr-defined]

    def warm_up(self, f: RightHandSide, call: Function, problem: Problem, setting: float) -> None:
        """Let JAX compile the function, which needs a call: over a tiny part of the span, from no special state."""
        if not uses_jax(type(self).function):
            return
        start, out = np.linspace(0.3, 1.1, problem.dimension), np.empty((len(problem.times), problem.dimension))
        tiny = replace(problem, times=problem.t0 + problem.elapsed * TINY, counted=False)
        before = problem.buffer[-1]
        f.begin()
        with contextlib.suppress(Exception):  # that state may be impossible
            self.trajectory(call, tiny, abs(tiny.interval) if isinstance(self.sweep, Steps) else setting, start, out)
        f.end()
        problem.buffer[-1] = before

    def validate(self, problem: Problem, setting: float) -> None:
        """Raise Refused for a setting that is not a reasonable step size or tolerance."""
        kind = "step size" if isinstance(self.sweep, Steps) else "tolerance"
        require_positive(setting, kind)
        if kind == "tolerance" and not LEAST_TOLERANCE <= setting < 1:
            raise Refused(f"tolerance {setting:g} is not from {LEAST_TOLERANCE:.1e} to below 1")
        span = abs(float(problem.elapsed[-1]))
        if kind == "step size" and (span / setting > MOST_STEPS or setting > 2 * abs(problem.interval)):
            raise Refused(
                f"step size {setting:g} is longer than the sampling interval, {problem.interval:g},"
                f" or makes more than {MOST_STEPS:g} steps"
            )

    @abstractmethod
    def trajectory(self, call: Function, problem: Problem, setting: float, y: Floats, out: Floats) -> int | None:
        """Write the states at the samples into `out` (n, dim); return the number of steps, None if unknown.

        `call` is the user's function without its first argument.
        """


class Stepped(FunctionAdapter):
    """A one-step method: the error over a span has one order less than the error of a step."""

    def trajectory(self, call: Function, problem: Problem, setting: float, y: Floats, out: Floats) -> int | None:
        time, steps, shape = problem.t0, 0, (problem.dimension,)
        for k, end in enumerate(problem.times.tolist()):
            count = max(1, math.ceil(abs(end - time) / setting * (1 - 1e-12)))
            h = (end - time) / count
            for i in range(count):
                y = call(time + i * h, y, h)
                if getattr(y, "shape", None) != shape:
                    require_shape(y, shape, "a step returns the state at t + h")
            out[k], time, steps = y, end, steps + count
        return steps


class _Solved(FunctionAdapter):
    def trajectory(self, call: Function, problem: Problem, setting: float, y: Floats, out: Floats) -> int | None:
        states = call(problem.t0, y, problem.times.copy(), setting)
        require_shape(states, out.shape, "a solver returns a state for each of the times")
        out[:] = states
        return None


def require_shape(answer: Any, shape: tuple[int, ...], rule: str) -> None:
    """Raise Unusable, with the answer and the rule, for an answer of another shape."""
    with contextlib.suppress(ValueError):  # rows of different lengths have no shape
        if np.shape(answer) == shape:
            return
    given = f"an array of shape {answer.shape}" if hasattr(answer, "shape") else short(answer)
    raise Unusable(f"returned {given}: {rule}, an array of shape {shape}")


def from_name(name: str) -> Integrator | None:
    """The integrator of a plain function that is named as ``mine.py:rk4`` or ``mine:rk4``, without a declaration.

    A function of f, t, y and h is a step, a function of f, t0, y0, times and a tolerance a solver; `jac` may follow. Also
    an integrator that is named by its file; None for any other name.
    """
    place, _, attribute = name.partition(":")
    file = Path(place)
    in_file = file.suffix == ".py" and file.is_file()
    if not attribute or (not in_file and name in lookup.everything()):
        return None
    if in_file and (folder := str(file.parent.resolve())) not in sys.path:
        sys.path.insert(0, folder)
    module = file.stem if in_file else place
    return _adapt_named(module, attribute) or (lookup.from_path(f"{module}:{attribute}") if in_file else None)


@cache
def _adapt_named(module: str, attribute: str) -> Integrator | None:
    """The integrator made from a plain function of a module, for a worker process; None if there is no such function."""
    try:
        with confined():
            function = getattr(importlib.import_module(module), attribute)
        if isinstance(function, Integrator | type):
            return None
        count = len([each for each in inspect.signature(function).parameters if each != "jac"])
    except BaseException:  # a user's module may raise anything: `lookup` says what is wrong with the name
        return None
    if count not in (STEP_ARGUMENTS, STEP_ARGUMENTS + 1):
        if inspect.isfunction(function):
            raise ValueError(f"{module}:{attribute} takes {inspect.signature(function)}; {ARGUMENTS}")
        return None
    integrator = (from_step if count == STEP_ARGUMENTS else from_solve)(function, name=attribute)
    kind: Any = type(integrator)
    kind.__module__, kind.__reduce__ = module, lambda self: (_adapt_named, (module, attribute))
    return integrator


def right_hand_side(problem: Problem) -> RightHandSide:
    """The equations of a problem as a plain function; each call adds 1 to the last element of `problem.buffer`."""
    return RightHandSide(problem)


def is_of_numba(function: Function) -> bool:
    """Whether numba compiles a function."""
    return type(function).__module__.startswith("numba.") and hasattr(function, "compile")


def uses_jax(function: Function) -> bool:
    """Whether JAX compiles a function, or it is Python in a module that has imported JAX or a library on it."""
    plain = inspect.unwrap(function)
    known = [function, plain, *getattr(plain, "__globals__", {}).values()]
    names = (getattr(value, "__name__" if inspect.ismodule(value) else "__module__", "") for value in known)
    roots = {str(name).partition(".")[0] for name in names}
    return "jax" in sys.modules and bool(roots & {"jax", "jaxlib", "diffrax", "equinox"})


def takes_jacobian(function: Function) -> bool:
    """Whether a function has a parameter `jac`."""
    try:
        return "jac" in inspect.signature(function).parameters
    except (TypeError, ValueError):  # a function without a signature, of a compiled library
        return False


def _require_arguments(function: Function, base: type[FunctionAdapter], name: str) -> None:
    """Raise ValueError for a function that does not take the arguments of a step, or of a solver."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # a function of a compiled library
        return
    jacobian = {"jac": None} if takes_jacobian(function) else {}
    try:
        signature.bind(*range(STEP_ARGUMENTS + (base is not Stepped)), **jacobian)
    except TypeError:
        raise ValueError(f"{name} takes {signature}; {ARGUMENTS}") from None


def _make_adapter(
    base: type[FunctionAdapter], function: Function, second: tuple[bool, bool], **attributes: Any
) -> Integrator:
    """An instance of a new class in the module of the user's call: workers import it as a variable of that module.

    `second`: whether f returns accelerations, and whether these depend on velocities.
    """
    accelerations, velocities = second
    accepts = (SecondOrder, VelocityForces) if velocities else (SecondOrder if accelerations else FirstOrder,)
    attributes |= {"function": staticmethod(function), "accepts": accepts, "velocities": velocities}
    _require_arguments(function, base, attributes["name"])
    attributes |= {"compiles": is_of_numba(function) or uses_jax(function)}
    module = sys._getframe(2).f_globals.get("__name__", "__main__")
    kind = type(base.__name__.strip("_"), (base,), attributes | {"__module__": module})
    integrator: Integrator = kind()
    declaration.validate(integrator, f"{module}: {attributes['name']!r}")
    return integrator

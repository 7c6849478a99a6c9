"""Integrators made of plain functions: `from_step` for one step of a method, `from_solve` for a whole solver.

The user's function receives `f(t, y)`, which returns the derivative of the state as a new float64 array; its calls are
counted. With `accelerations` it receives `f(t, q)`, which returns the accelerations of the positions q, the first half
of y.
"""

from __future__ import annotations

import itertools
import math
import sys
from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder, SecondOrder
from gnomon.harness.contract.integrator import (
    Integrator,
    Problem,
    Refused,
    Solver,
    Steps,
    Tolerance,
    TooManyCalls,
    each_start,
)
from gnomon.harness.contract.validation import require_positive
from gnomon.harness.registry import declaration
from numpy.typing import NDArray

Floats = NDArray[np.float64]
RightHandSide = Callable[[float, Any], Floats]

LEAST_TOLERANCE = 2.0**-52
MOST_STEPS = 10**8
"""A smaller tolerance, or more steps, are refused as mistakes."""


def from_step(
    step: Callable[[RightHandSide, float, Floats, float], Any],
    *,
    name: str,
    order: int | None = None,
    sweep: Steps | None = None,
    conserves: tuple[str, ...] = (),
    accelerations: bool = False,
    jacobian: str = "exact",
    library: str = "mine",
) -> Integrator:
    """Make an integrator from a function that makes one step.

    Parameters
    ----------
    step : callable
        ``step(f, t, y, h)`` returns the state at t + h, shape (dim,). ``f(t, y)`` is the derivative of the state.
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
    return _made(
        Stepped, step, accelerations,
        name=name, library=library, order=order, conserves=conserves, jacobian=jacobian, sweep=sweep or Steps(),
    )  # fmt: skip


def from_solve(
    solve: Callable[[RightHandSide, float, Floats, Floats, float], Any],
    *,
    name: str,
    order: int | None = None,
    sweep: Tolerance | Steps | None = None,
    dense_order: int | None = None,
    conserves: tuple[str, ...] = (),
    accelerations: bool = False,
    jacobian: str = "exact",
    library: str = "mine",
) -> Integrator:
    """Make an integrator from a whole solver.

    Parameters
    ----------
    solve : callable
        ``solve(f, t0, y0, times, tolerance)`` returns the states at `times`, shape (n, dim), from `y0`, shape (dim,),
        at `t0`. With a `sweep` of Steps the last argument is the step size. A solver that gives up raises
        `gnomon.verify.Refused`, or returns nan for the samples that it did not reach.
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
    return _made(
        _Solved, solve, accelerations,
        name=name, library=library, order=order, conserves=conserves, jacobian=jacobian,
        sweep=sweep or Tolerance(1e-3, 1e-12), sampling=sampling, dense_order=dense_order or None,
    )  # fmt: skip


class FunctionAdapter(Integrator):
    """An integrator made of a plain function, which solves from several starts one after the other."""

    function: ClassVar[Callable[..., Any]]

    def prepare(self, problem: Problem, setting: float) -> Solver:
        self.validate(problem, setting)

        def solve_one(start: Floats, out: Floats) -> tuple[int | None, None]:
            return self.trajectory(right_hand_side(problem), problem, setting, start, out), None

        return Solver(each_start(problem, solve_one))

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
    def trajectory(self, f: RightHandSide, problem: Problem, setting: float, y: Floats, out: Floats) -> int | None:
        """Write the states at the samples into `out` (n, dim); return the number of steps, None if unknown."""


class Stepped(FunctionAdapter):
    """A one-step method: the error over a span has one order less than the error of a step."""

    def trajectory(self, f: RightHandSide, problem: Problem, setting: float, y: Floats, out: Floats) -> int | None:
        time, steps, step = problem.t0, 0, type(self).function
        for k, end in enumerate(problem.times.tolist()):
            count = max(1, math.ceil(abs(end - time) / setting * (1 - 1e-12)))
            h = (end - time) / count
            for i in range(count):
                y = step(f, time + i * h, y, h)
            found = np.asarray(y)
            if found.shape != (problem.dimension,):
                raise ValueError(f"the step returned an array of shape {found.shape}, not {(problem.dimension,)}")
            out[k], time, steps = found, end, steps + count
        return steps


class _Solved(FunctionAdapter):
    def trajectory(self, f: RightHandSide, problem: Problem, setting: float, y: Floats, out: Floats) -> int | None:
        found = np.asarray(type(self).function(f, problem.t0, y, problem.times.copy(), setting))
        if found.shape != out.shape:
            raise ValueError(f"the solver returned states of shape {found.shape}, not {out.shape}: one row a time")
        out[:] = found
        return None


def right_hand_side(problem: Problem) -> RightHandSide:
    """The equations of a problem as a plain function; each call adds 1 to the last element of `problem.buffer`.

    The derivative is nan where the equations cannot be evaluated (the root of a negative number, overflow).
    """
    form = problem.form
    equations: Any = form.acceleration if isinstance(form, SecondOrder) else form.equations  # type: ignore[union-attr]
    half = problem.dimension // 2 if isinstance(form, SecondOrder) else problem.dimension
    parameters, buffer, calls = tuple(problem.parameters.tolist()), problem.buffer, itertools.count(1)

    def f(t: float, y: Any) -> Floats:
        buffer[-1] += 1.0
        if next(calls) > problem.most_calls:
            raise TooManyCalls(f"more than {problem.most_calls:.2g} right-hand sides in one solution")
        try:
            return np.array(equations(float(t), tuple(np.asarray(y, dtype=np.float64).tolist()[:half]), parameters))
        except (ArithmeticError, ValueError):
            return np.full(half, np.nan)

    return f


def _made(
    base: type[FunctionAdapter], function: Callable[..., Any], accelerations: bool, **attributes: Any
) -> Integrator:
    """An instance of a new class in the module of the user's call: workers import it as a variable of that module."""
    attributes |= {"function": staticmethod(function), "accepts": (SecondOrder if accelerations else FirstOrder,)}
    module = sys._getframe(2).f_globals.get("__name__", "__main__")
    kind = type(base.__name__.strip("_"), (base,), attributes | {"__module__": module})
    made: Integrator = kind()
    declaration.validate(made, f"{module}: {attributes['name']!r}")
    return made

"""The loop of steps that every fixed-step method shares, and the compilation of a method's step into it.

A step is one plain function, written once and run in two arithmetics: compiled in binary64, and uncompiled in mpmath
for orders that binary64 cannot show. Its contract:

    step(s, t, h) -> bool

writes into `s.increment` the change of the state `s.y` from t to t + h, and returns False if it failed. `s` is a
`StepData`.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from gnomon.harness.contract.integrator import Floats, Problem
from gnomon.harness.kernels import emission, ir, machine
from numpy.typing import NDArray

Step = Callable[..., bool]

NOT_FINITE = 1
NOT_SOLVED = 2


def blank(problem: Problem, initial: Floats) -> Floats:
    """An array for the states of a Solution, filled with nan.

    Raises ValueError for initial states of another shape than (n, dimension).
    """
    if initial.ndim != 2 or initial.shape[1] != problem.dimension:
        raise ValueError(f"initial states of shape {initial.shape}; they must be (n, {problem.dimension})")
    out = np.empty((len(initial), len(problem.times), problem.dimension))
    out.fill(np.nan)  # half the time of np.full, which takes a hundredth of a short solve
    return out


class StepData(NamedTuple):
    """The equations, numbers and arrays of a step. `x`, `slope` and `store` keep their values until the next step."""

    f: Any
    """The equations: a plain function f(t, x, p), in compiled steps the address of a compiled one."""
    y: Any
    """The state at the start of the step, (dim,)."""
    p: Any
    """The parameters of the case."""
    table: Any
    """The coefficients of the method, in rows."""
    x: Any
    """The arguments of the next call of the equations."""
    slope: Any
    """The result of the last call of the equations."""
    store: Any
    """Numbers of the method, (rows, dim); zero before the first step."""
    increment: Any
    """The change of the state in the step, (dim,)."""


def call(f: Any, t: Any, x: Any, p: Any, slope: Any) -> None:
    """Evaluate plain equations into `slope`. Compiled steps take an address for `f`."""
    slope[:] = f(t, tuple(x), tuple(p))


def evaluate(s: Any, t: Any) -> None:
    """Evaluate the equations of a step at `s.x` into `s.slope`."""
    call(s.f, t, s.x, s.p, s.slope)


def product(a: Any, b: Any) -> tuple[Any, Any]:
    """a * b, rounded, and its rounding residual: 0 here, exact in compiled steps."""
    return a * b, a * 0


def sum_of(a: Any, b: Any) -> tuple[Any, Any]:
    """a + b, rounded, and its rounding residual (Knuth, The Art of Computer Programming 2, 4.2.2)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@emission.primitive(evaluate)
def _(s: Any, t: Any) -> None:
    _call_address(s.f, t, s.x, s.p, s.slope)


@emission.primitive(call)
def _call_address(f: Any, t: Any, x: Any, p: Any, slope: Any) -> None:
    """Call the C function void(double t, double *x, double *p, double *slope) at an address."""
    place = ir.here().emit(ir.POINTER, f"inttoptr i64 {f} to ptr")
    arrays = ", ".join(array.pointer.typed for array in (x, p, slope))
    ir.here().do(f"call void {place}({ir.convert(t, ir.REAL).typed}, {arrays})")


@emission.primitive(product)
def _(a: Any, b: Any) -> Any:
    """a * b, rounded and never contracted with a sum, and its rounding residual by a fused operation."""
    rounded = ir.exact("mul", a, b)
    return rounded, ir.call("llvm.fma.f64", ir.REAL, *(ir.convert(x, ir.REAL) for x in (a, b, -rounded)))


def advance(
    f: Any, p: Floats, table: Floats, inputs: int, outputs: int, rows: int, initial: Floats, times: Floats, h: float,
    substeps: int, compensated: bool, out: Floats, stop: NDArray[np.int64],
) -> int:  # fmt: skip
    """Integrate each of `initial` (n, dim) into `out` (n, len(times), dim); returns the number of steps taken.

    With substeps > 0 the times are multiples of substeps * h. With substeps = 0 they are not: a shorter step from the grid
    point before a sample computes the sample, and the next step begins at the grid point again. A sample within two ulps of
    a grid point is the state there, because methods that divide by so short a step return round-off. A trajectory ends if
    its state is not finite or a step fails; `stop` gets the reason, the trajectory and the sample of the first early end.
    """
    dimension = initial.shape[1]
    y, compensation, increment = np.empty(dimension), np.empty(dimension), np.empty(dimension)
    x, slope, store = np.empty(inputs), np.empty(outputs), np.empty((rows, dimension))
    s = StepData(f, y, p, table, x, slope, store, increment)
    x_aside, slope_aside, store_aside = np.empty(inputs), np.empty(outputs), np.empty((rows, dimension))
    s_aside = s._replace(x=x_aside, slope=slope_aside, store=store_aside)
    taken = 0
    for n in range(initial.shape[0]):
        y[:] = initial[n]
        compensation[:] = 0.0
        for i in range(rows):
            for j in range(dimension):
                store[i, j] = 0.0
        grid = 0
        for k in range(times.size):
            target = (k + 1) * substeps if substeps > 0 else int(times[k] / h)
            solved = True
            while grid < target:
                solved = step(s, grid * h, h)
                if not solved:
                    break
                grid += 1
                if compensated:
                    for i in range(dimension):
                        change = increment[i] + compensation[i]
                        updated = y[i] + change
                        compensation[i] = change - (updated - y[i])
                        y[i] = updated
                else:
                    for i in range(dimension):
                        y[i] += increment[i]
            for i in range(dimension):
                out[n, k, i] = y[i]
            if solved and substeps == 0 and times[k] - grid * h > 2.0**-51 * times[k]:
                for i in range(rows):
                    for j in range(dimension):
                        store_aside[i, j] = 0.0
                solved = aside(s_aside, grid * h, times[k] - grid * h)
                for i in range(dimension):
                    out[n, k, i] += increment[i] + compensation[i]
            finite = True
            for i in range(dimension):
                finite = finite and abs(out[n, k, i]) < np.inf
            if not (solved and finite):
                for i in range(dimension):
                    out[n, k, i] = np.nan
                if stop[0] == 0:
                    stop[0] = NOT_FINITE if solved else NOT_SOLVED
                    stop[1] = n
                    stop[2] = k
                break
        taken += grid
    return taken


def step(*_: Any) -> bool:
    """A placeholder, which compilation replaces by the method's step, inlined into the loop."""
    raise NotImplementedError


def aside(*_: Any) -> bool:
    """A placeholder, which compilation replaces by the method's step, not inlined, for samples between grid points."""
    raise NotImplementedError


ADVANCE_SIGNATURE = "int float[1] float[2] int int int float[2] float[1] float int bool float[3] int[1]"


@cache
def compile_step(method: Step, constants: tuple[tuple[str, int], ...] = ()) -> Callable[..., int]:
    """`advance` compiled around a method's step, kept on disk under a hash of all its sources.

    By their names, `constants` replace numbers that the step reads.
    """
    replaced = {"step": method, "aside": method, **dict(constants)}
    return machine.function(advance, ADVANCE_SIGNATURE, replaced=replaced, inlined=("step",))


@cache
def compile_whole(
    method: Callable[..., int],
    signature: str,
    constants: tuple[tuple[str, int], ...] = (),
    pieces: tuple[Callable[..., Any], ...] = (),
    unrolled: bool = True,
) -> Callable[..., int]:
    """Compile a function that has its own loop of steps.

    By their names, `pieces` replace functions that it calls, and `constants` replace numbers that all these functions
    read. Without `unrolled` loops over as many turns as one of the constants stay loops: for states of two components
    this is a few per cent faster, and compiles in half the time.
    """
    named = {piece.__name__: piece for piece in pieces}
    numbers = {name: number if unrolled else ir.Value(ir.INTEGER, str(number)) for name, number in constants}
    return machine.function(method, signature, replaced=named | numbers, inlined=tuple(named))

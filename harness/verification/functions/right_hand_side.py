"""The equations of a problem, and their Jacobian, as functions that a user's method calls from Python, numba or JAX."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from gnomon.cases.core.forms import FirstOrder, SecondOrder
from gnomon.harness.contract.integrator import Floats, Problem, TooManyCalls, Unsupported
from gnomon.harness.kernels.equations import Kernel, acceleration
from gnomon.harness.kernels.equations import right_hand_side as first_order_kernel
from gnomon.harness.kernels.straight_line import derivatives_if_traced


class Equations:
    """A function of the time and of one array, the state, or of two, positions and velocities.

    numba takes such objects as arguments of compiled functions, by `_numba_type_`, and JAX traces them. `width`: the
    number of components of the state that the equations take. `rows`: the range of the rows that they return. Equal objects
    have equal results, because JAX compiles a function once for equal static arguments.
    """

    symbol = "f"
    numba_types = "OF_STATE", "OF_POSITIONS_AND_VELOCITIES"
    """The names of the types, in `numba_calls`, of functions of one array and of two."""

    def __init__(self, problem: Problem, velocities: bool = False) -> None:
        form, half = problem.form, problem.dimension // 2
        second = isinstance(form, SecondOrder)
        self.problem, self.velocities = problem, velocities
        self.equations: Callable[..., Any] = form.acceleration if second else form.equations  # type: ignore[union-attr]
        self.width = half if second else problem.dimension
        self.rows = (half, problem.dimension) if velocities and not second else (0, self.width)
        self.shapes: list[tuple[int, ...]] = [(half,), (half,)] if velocities else [(self.width,)]
        self.parameters, self.buffer = tuple(problem.parameters.tolist()), problem.buffer
        self.calls = np.array([0.0, problem.most_calls])
        """The number of calls in this solution, and the largest number allowed."""
        jax_calls = find_jax()
        if jax_calls is not None:
            jax_calls.register(type(self))

    @property
    def key(self) -> tuple[Any, ...]:
        """The static part of JAX's compilation: the equations, and whether derivatives are wanted; not the parameters."""
        return isinstance(self, Jacobian), self.equations, self.width, self.rows, self.velocities, self.problem.counted

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Equations) and (self.key, self.parameters) == (other.key, other.parameters)

    def __hash__(self) -> int:
        return hash((self.key, self.parameters))

    def __call__(self, t: Any, *arrays: Any) -> Any:
        shapes = [each.shape if type(each) is np.ndarray else None for each in arrays]
        if isinstance(t, float) and shapes == self.shapes:
            return self.evaluate(float(t), *arrays)
        self.require_shapes(t, arrays)
        jax_calls = find_jax()
        if jax_calls is not None and jax_calls.is_of_jax(t, arrays):
            return jax_calls.call(self, t, arrays)
        return self.evaluate(float(t), *arrays)

    def evaluate(self, t: float, *arrays: Any) -> Floats:
        """The result at numbers."""
        raise NotImplementedError

    def state(self, arrays: tuple[Any, ...]) -> Floats:
        """One or two arrays as one state."""
        return np.array(np.concatenate(arrays) if self.velocities else arrays[0], dtype=np.float64)

    def require_shapes(self, t: Any, arrays: tuple[Any, ...]) -> None:
        """Raise TypeError for arguments of other shapes, as those in another order; the whole state has the positions first."""
        wanted, given = [(), *self.shapes], [np.shape(each) for each in (t, *arrays)]
        if given == wanted or (given == [(), (self.problem.dimension,)] and not self.velocities):
            return
        second = isinstance(self.problem.form, SecondOrder)
        names = "t, q, v" if self.velocities else "t, q" if second else "t, y"
        texts = (" and ".join(map(str, each)) for each in (wanted, given))
        raise TypeError(
            f"{self.symbol}({names}) takes arguments of shape {', but was called with '.join(texts)}: check their order, also"
            " in the definition of your function, as step(f, t, y, h)"
        )

    @cached_property
    def _numba_type_(self) -> Any:
        # numba asks for the type, so that it is loaded already.
        from gnomon.harness.verification.functions import numba_calls

        return getattr(numba_calls, self.numba_types[self.velocities])

    @cached_property
    def kernel(self) -> Kernel:
        """The compiled function, which does not count its calls."""
        raise NotImplementedError

    @property
    def address(self) -> int:
        return self.kernel.address

    @property
    def columns(self) -> int:
        """The number of components of all arguments."""
        return self.problem.dimension if self.velocities else self.width

    @property
    def size(self) -> int:
        """The number of values of the compiled function; the result is the part of them that begins at `first`."""
        return self.kernel.sizes[2]

    @property
    def first(self) -> int:
        return self.size // self.width * self.rows[0]


class RightHandSide(Equations):
    """The derivative of the state y as f(t, y), or the accelerations as f(t, q) or f(t, q, v); its calls are counted.

    Each call adds 1 to the last element of `problem.buffer`. The result is nan where the equations cannot be evaluated
    (the root of a negative number, overflow).
    """

    def evaluate(self, t: float, *arrays: Any) -> Floats:
        self.buffer[-1] += 1.0
        self.calls[0] += 1.0
        if self.calls[0] > self.calls[1]:
            raise TooManyCalls(f"more than {self.calls[1]:.2g} right-hand sides in one solution")
        first, end = self.rows
        try:
            values = self.equations(t, tuple(self.state(arrays).tolist()[: self.width]), self.parameters)
            return np.array(values[first:end], dtype=np.float64)
        except (ArithmeticError, ValueError):
            return np.full(end - first, np.nan)

    @cached_property
    def kernel(self) -> Kernel:
        problem = replace(self.problem, counted=False)
        return acceleration(problem) if isinstance(problem.form, SecondOrder) else first_order_kernel(problem)

    def begin(self) -> None:
        """Count the calls of one more solution."""
        self.calls[0] = 0.0
        jax_calls = find_jax()
        if jax_calls is not None:
            jax_calls.begin(self)

    def end(self) -> None:
        """Wait for calls of compiled code that are not counted yet."""
        jax_calls = find_jax()
        if jax_calls is not None and self.problem.counted:
            jax_calls.end()


class Jacobian(Equations):
    """The exact derivatives of a right-hand side by its arguments, an array of shape (rows, components of the arguments).

    By the state as jac(t, y), or of accelerations as jac(t, q), or jac(t, q, v) by positions and then velocities.
    """

    symbol = "jac"
    numba_types = "MATRIX_OF_STATE", "MATRIX_OF_POSITIONS_AND_VELOCITIES"

    def evaluate(self, t: float, *arrays: Any) -> Floats:
        first, end = self.rows
        derivatives = np.zeros((end - first, self.columns))  # accelerations a(t, q) do not depend on velocities
        values = self.kernel.array(t, self.state(arrays), self.buffer)
        derivatives[:, : self.width] = values[self.first :].reshape(-1, self.width)
        return derivatives

    @cached_property
    def kernel(self) -> Kernel:
        kernel = derivatives_if_traced(FirstOrder(self.equations), self.width, len(self.parameters))
        if kernel is None:
            raise Unsupported("the equations branch, so that they have no Jacobian")
        return kernel


def find_jax() -> Any:
    """The module `jax_calls` if the user's code has imported JAX, else None."""
    if "jax" not in sys.modules:
        return None
    # JAX is optional, and slow to load.
    from gnomon.harness.verification.functions import jax_calls

    return jax_calls

"""Equations as functions that JAX traces: as an argument, static or not, and as a variable of a traced function.

JAX evaluates the equations in its own arithmetic, and compiles them with the user's function. As an argument they are a
tree with one leaf, the parameters, so that JAX compiles once for all parameters of a case.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import jax
from gnomon.cases.core.arithmetic import FUNCTIONS, rebind
from gnomon.harness.contract.integrator import Unsupported
from gnomon.harness.contract.validation import Unusable

FLOAT32 = (
    'JAX computes in float32 here, which leaves errors of 1e-7; write jax.config.update("jax_enable_x64", True) after'
    " `import jax`, or set JAX_ENABLE_X64=1"
)
_counted: list[Any] = []
"""The right-hand side whose calls are counted now. Compiled code, which serves many, calls this module."""


class Traced:
    """Equations with parameters that may be traced. `key`: as `Equations.key` of `right_hand_side`."""

    def __init__(self, key: tuple[Any, ...], parameters: Any) -> None:
        self.key, self.parameters = key, parameters

    def __call__(self, t: Any, *arrays: Any) -> Any:
        if not jax.config.jax_enable_x64:
            raise Unusable(FLOAT32)
        jacobian, _, width, _, velocities, counted = self.key
        state = jax.numpy.concatenate([jax.numpy.asarray(array) for array in arrays])
        if not jacobian:
            if counted:
                jax.debug.callback(_count)
            return self.values(t, state)
        return jax.jacfwd(self.values, 1)(t, state if velocities else state[:width])

    def values(self, t: Any, state: Any) -> Any:
        """The right-hand side at a state."""
        _, equations, width, (first, end), *_ = self.key
        try:
            values = _in_jax(equations)(t, tuple(state[:width]), tuple(self.parameters))
        except jax.errors.TracerBoolConversionError:
            raise Unsupported("the equations branch on computed values, which JAX does not compile") from None
        return jax.numpy.array(values[first:end], dtype=float)


@cache
def _in_jax(equations: Any) -> Any:
    return rebind(equations, {name: getattr(jax.numpy, name) for name in FUNCTIONS})


def call(f: Any, t: Any, arrays: tuple[Any, ...]) -> Any:
    """The result for arguments of JAX: traced, or as an array of JAX if all of them are numbers."""
    if any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree_util.tree_leaves((t, arrays))):
        return Traced(f.key, f.parameters)(t, *arrays)
    return jax.numpy.asarray(f.evaluate(float(t), *arrays))


def is_of_jax(*arguments: Any) -> bool:
    """Whether one of the arguments, or an item of one, is an array of JAX."""
    return any(isinstance(leaf, jax.Array) for leaf in jax.tree_util.tree_leaves(arguments))


def _count() -> None:
    _counted[-1].buffer[-1] += 1.0


def begin(f: Any) -> None:
    """Count the calls of a right-hand side from now on."""
    _counted[:] = [f]


def end() -> None:
    """Wait until all calls are counted."""
    jax.effects_barrier()


@cache
def register(kind: type[Any]) -> None:
    """Tell JAX that equations are a tree of their parameters."""
    jax.tree_util.register_pytree_node(kind, lambda f: ((f.problem.parameters,), f.key), _unflatten)


def _unflatten(key: tuple[Any, ...], children: tuple[Any, ...]) -> Traced:
    return Traced(key, children[0])


jax.tree_util.register_pytree_node(Traced, lambda f: ((f.parameters,), f.key), _unflatten)

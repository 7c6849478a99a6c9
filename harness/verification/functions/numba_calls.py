"""Right-hand sides as arguments of functions that numba compiles, by a type of numba's own.

A value of the type holds the address of compiled equations, the array that they read parameters from and count calls in,
and the numbers of calls, made and allowed. The type has no case in it: numba compiles a user's function once for all.
"""

import hashlib
import inspect
from functools import wraps
from pathlib import Path
from typing import Any

import numba
import numpy as np
from gnomon.harness.contract.integrator import TooManyCalls
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.imputils import lower_builtin
from numba.extending import NativeValue, intrinsic, make_attribute_wrapper, overload_method, register_model, unbox

SOLVER = 5
"""The number of arguments of a solver, without `jac`; a step has one less."""
FLOATS = types.Array(types.float64, 1, "C")
SOURCE = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:8]
"""Part of the names of the types: numba keeps compiled code of a user's function, which must not meet other code of this
module."""
MEMBERS = dict.fromkeys(("address", "size", "first", "width", "columns"), types.int64) | dict.fromkeys(
    ("buffer", "calls"), FLOATS
)


class OfState(types.Type):
    """The type of f(t, y)."""

    def __init__(self) -> None:
        super().__init__(name=f"gnomon.{type(self).__name__} {SOURCE}")


class OfPositionsAndVelocities(OfState):
    """The type of f(t, q, v)."""


class MatrixOfState(OfState):
    """The type of jac(t, y)."""


class MatrixOfPositionsAndVelocities(OfState):
    """The type of jac(t, q, v)."""


class _Model(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: OfState) -> None:
        super().__init__(manager, kind, list(MEMBERS.items()))


def _unbox(kind: OfState, value: Any, c: Any) -> NativeValue:
    """The members are attributes of the object of Python, which lives as long as the call."""
    struct, failed = cgutils.create_struct_proxy(kind)(c.context, c.builder), cgutils.false_bit
    for name, member in MEMBERS.items():
        item = c.pyapi.object_getattr_string(value, name)
        native = c.unbox(member, item)
        setattr(struct, name, native.value)
        failed = c.builder.or_(failed, native.is_error)
        c.pyapi.decref(item)
    return NativeValue(struct._getvalue(), is_error=failed)


@intrinsic  # type: ignore[untyped-decorator]
def _call(context: Any, address: Any, t: Any, y: Any, p: Any, out: Any) -> Any:
    """Call void(double t, double *y, double *p, double *out) at an address; the arrays are given by their addresses."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        real = ir.DoubleType()
        pointer = real.as_pointer()
        function = ir.FunctionType(ir.VoidType(), [real, pointer, pointer, pointer])
        arrays = [builder.inttoptr(item, pointer) for item in arguments[2:]]
        builder.call(builder.inttoptr(arguments[0], function.as_pointer()), [arguments[1], *arrays])
        return context.get_dummy_value()

    return types.void(types.intp, types.float64, types.intp, types.intp, types.intp), emit


@numba.njit  # type: ignore[untyped-decorator]
def _evaluate(f: Any, t: float, state: Any) -> Any:
    """The values of the compiled equations at a time and a state, an array."""
    out = np.empty(f.size)
    _call(f.address, t, state.ctypes.data, f.buffer.ctypes.data, out.ctypes.data)
    return out[f.first :]


@numba.njit  # type: ignore[untyped-decorator]
def _count_call(f: Any, t: float, state: Any) -> Any:
    """Evaluate the equations, and count the call. Raises TooManyCalls above the limit."""
    f.calls[0] += 1
    f.buffer[-1] += 1
    if f.calls[0] > f.calls[1]:
        raise TooManyCalls("more right-hand sides in one solution than a right method takes")
    return _evaluate(f, t, state)


@numba.njit  # type: ignore[untyped-decorator]
def _matrix(f: Any, t: float, state: Any) -> Any:
    values = _evaluate(f, t, state).reshape(-1, f.width)
    matrix = np.zeros((len(values), f.columns))
    matrix[:, : f.width] = values
    return matrix


@numba.njit  # type: ignore[untyped-decorator]
def _one(y: Any) -> Any:
    state = np.empty(len(y))
    for i in range(len(y)):  # it may be a tuple, or have any strides
        state[i] = y[i]
    return state


@numba.njit  # type: ignore[untyped-decorator]
def _two(q: Any, v: Any) -> Any:
    half = len(q)
    state = np.empty(2 * half)
    for i in range(half):
        state[i], state[half + i] = q[i], v[i]
    return state


def _of_state(f: Any, t: Any, y: Any) -> Any:
    return _count_call(f, float(t), _one(y))


def _of_two(f: Any, t: Any, q: Any, v: Any) -> Any:
    return _count_call(f, float(t), _two(q, v))


def _matrix_of_state(f: Any, t: Any, y: Any) -> Any:
    return _matrix(f, float(t), _one(y))


def _matrix_of_two(f: Any, t: Any, q: Any, v: Any) -> Any:
    return _matrix(f, float(t), _two(q, v))


def _define(kind: type[OfState], function: Any) -> OfState:
    """The type whose objects numba calls as `function`."""
    register_model(kind)(_Model)
    unbox(kind)(_unbox)
    for name in MEMBERS:
        make_attribute_wrapper(kind, name, name)
    overload_method(kind, "__call__")(wraps(function)(lambda *_: function))

    @lower_builtin(kind, kind, types.VarArg(types.Any))  # type: ignore[untyped-decorator, attr-defined]
    def lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        """Emit the call of an object: numba itself only types it."""
        return context.compile_internal(builder, function, signature, arguments)

    return kind()


OF_STATE = _define(OfState, _of_state)
OF_POSITIONS_AND_VELOCITIES = _define(OfPositionsAndVelocities, _of_two)
MATRIX_OF_STATE = _define(MatrixOfState, _matrix_of_state)
MATRIX_OF_POSITIONS_AND_VELOCITIES = _define(MatrixOfPositionsAndVelocities, _matrix_of_two)


def signature(called: inspect.Signature, velocities: bool) -> tuple[Any, ...]:
    """The types with which a user's function is called: f, t, y, h or f, t0, y0, times, tolerance, and perhaps jac."""
    function = OF_POSITIONS_AND_VELOCITIES if velocities else OF_STATE
    matrix = MATRIX_OF_POSITIONS_AND_VELOCITIES if velocities else MATRIX_OF_STATE
    names = list(called.parameters)
    plain = [
        function,
        types.float64,
        FLOATS,
        *([FLOATS] if len(names) - ("jac" in names) == SOLVER else []),
        types.float64,
    ]
    kinds = iter(plain)
    return tuple(matrix if name == "jac" else next(kinds, types.none) for name in names)

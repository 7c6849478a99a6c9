"""Compile the equations of a case, as functions (t, y, parameters, out) of machine code that is kept in the user's cache.

All have the same signature, so an integrator is compiled once and calls any case by function pointer. The key of kept code
has the source of all functions and the numbers that they read, so that every edit makes other code.
"""

import ctypes
import dis
import linecache
import math
import types
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from gnomon.cases.core import forms
from gnomon.harness.contract.integrator import Floats, Problem
from gnomon.harness.contract.sources import cache_by_content
from gnomon.harness.kernels import emission, ir, machine
from gnomon.harness.kernels.called_equations import Called

Body = Callable[[ir.Value, ir.Array, ir.Array, ir.Array], None]
CALLBACK = ctypes.CFUNCTYPE(None, ctypes.c_double, *(ctypes.POINTER(ctypes.c_double),) * 3)


class Kernel:
    """Compiled equations that can be called in three ways, each linked on first use.

    `body(t, y, p, out)` emits them; `sizes`: the sizes of the arrays y, p and out. Code is kept under `key` and the source
    of the module that has `body`.
    """

    def __init__(self, key: str, body: Body, sizes: tuple[int, int, int], plain: "Kernel | None" = None) -> None:
        self.key, self.body, self.sizes, self.plain = key, body, sizes, plain

    def counted(self) -> "Kernel":
        """A kernel that adds 1 to p[sizes[1]] at each call and then calls this kernel, so that both use one machine code."""
        return Kernel(self.key, self.body, self.sizes, self)

    @cached_property
    def address(self) -> int:
        """Address of the C function void(double t, double *y, double *p, double *out), which in-house methods call."""
        return self.code.addresses["kernel"] if self.plain is None else self.plain.code.addresses["counting"]

    @cached_property
    def code(self) -> machine.Code:
        source = "".join(linecache.getlines(self.body.__code__.co_filename))
        return machine.code(f"{self.key}\n{self.sizes}\n{source}", ("kernel", "counting"), self._emit)

    def _emit(self) -> None:
        arrays = [ir.Array(ir.Value(ir.POINTER, f"%{name}"), (n,)) for name, n in zip("ypo", self.sizes, strict=True)]
        with ir.Function("void @kernel(double %t, ptr %y, ptr %p, ptr %o)") as f:
            self.body(ir.Value(ir.REAL, "%t"), *arrays)
            f.do("ret void")
        with ir.Function("void @counting(double %t, ptr %y, ptr %p, ptr %o)") as f:
            count = ir.Array(arrays[1].pointer, (self.sizes[1] + 1,))
            count[self.sizes[1]] += 1.0
            f.do("tail call void @kernel(double %t, ptr %y, ptr %p, ptr %o) noinline")
            f.do("ret void")

    @cached_property
    def pointer(self) -> Any:
        """The compiled function (t, y, p, out) -> None."""
        return self._called("pointer")

    @cached_property
    def array(self) -> Any:
        """The compiled function (t, y, p) -> new array."""
        return self._called("array")

    def _called(self, name: str) -> Any:
        facts = np.array([self.address, *self.sizes], dtype=np.int64)
        return machine.callable_at(entries().addresses[name], name, facts)

    def bound(self, parameters: Floats) -> Callable[[float, Floats], Floats]:
        """The compiled function (t, y) -> new array at these parameters, for libraries that call it from C."""
        states, _, outputs = self.sizes
        facts = np.array([self.address, states, outputs, parameters.ctypes.data]).view(_Facts)
        facts.parameters = parameters
        return machine.callable_at(entries().addresses["bound"], "bound", facts)


class _Facts(np.ndarray[Any, np.dtype[np.int64]]):
    """The integers that a function of Python holds, and the array whose address is among them."""

    parameters: Floats


class CalledKernel(Kernel):
    """Equations that stay a function of Python, in the three ways of a kernel: C code calls them back."""

    def __init__(self, equations: Called, sizes: tuple[int, int, int], counting: bool) -> None:
        super().__init__("", lambda t, y, p, out: None, sizes)
        (states, parameters, outputs), as_array = sizes, np.ctypeslib.as_array

        def pointer(t: float, y: Floats, p: Floats, out: Floats) -> None:
            if counting:
                p[-1] += 1
            out[:] = equations.values(t, y.copy())

        def called(t: float, y: Floats, p: Floats, out: Floats) -> None:
            pointer(t, y, p, out)
            if equations.failure is not None:  # from Python it can pass; a library may go on for ever with nan
                raise equations.failure[0]

        def array(t: float, y: Floats, p: Floats) -> Floats:
            out = np.empty(outputs)
            called(t, y, p, out)
            return out

        def call(t: float, y: Any, p: Any, out: Any) -> None:
            buffer = as_array(p, (parameters + 1,)) if counting else np.empty(0)
            pointer(t, as_array(y, (states,)), buffer, as_array(out, (outputs,)))

        self.equations, self.pointer, self.array = equations, called, array
        self.callback = CALLBACK(call)
        self.address = ctypes.cast(self.callback, ctypes.c_void_p).value or 0
        equations.kernels.append(self)

    def counted(self) -> Kernel:
        return CalledKernel(self.equations, self.sizes, True)

    def bound(self, parameters: Floats) -> Callable[[float, Floats], Floats]:
        return lambda t, y: self.array(t, y, parameters)  # type: ignore[no-any-return]


def entries() -> machine.Code:
    """The entries from Python of all kernels. They read address and sizes from an array that each function holds."""
    signature = "float float[1] float[1] float[1]"

    def run(address: Any, *arguments: Any) -> None:
        place = ir.here().emit(ir.POINTER, f"inttoptr i64 {address} to ptr")
        ir.here().do(f"call void {place}({', '.join(x.typed for x in arguments)})")

    def call(address: Any, _: Any, __: Any, ___: Any, t: Any, *arrays: Any) -> None:
        run(address, t, *(x.pointer for x in arrays))

    def call_bound(address: Any, _: Any, __: Any, parameters: Any, t: Any, y: Any, out: Any) -> None:
        run(address, t, y.pointer, ir.here().emit(ir.POINTER, f"inttoptr i64 {parameters} to ptr"), out.pointer)

    def emit() -> None:
        emission.define("call", f"int int int int {signature}", call, "void")
        machine.define_entry("pointer", signature, "call", "void", own=4)
        machine.define_entry("array", signature, "call", "void", own=4, returns=True)
        emission.define("call_bound", "int int int int float float[1] float[1]", call_bound, "void")
        machine.define_entry("bound", "float float[1] float[1]", "call_bound", "void", own=4, returns=True)

    return machine.code("entries of equations", ("pointer", "array", "bound"), emit)


def right_hand_side(problem: Problem) -> Kernel:
    """Compile the first-order right-hand side of a problem.

    Parameters
    ----------
    problem : Problem
        A problem with a form FirstOrder, SecondOrder or RigidBody.

    Returns
    -------
    Kernel
        Its function `array(t, y, problem.buffer)` returns the derivatives of a state y at a time t, as a float64 array
        of shape (dimension,), in the units of the problem. It counts its calls if `problem.counted`.

    Raises
    ------
    ValueError
        If the equations cannot be compiled: a lambda, a `raise` statement, a global that is neither a number nor a function, or
        another number of values than the form needs.
    OSError
        If the equations have no source text, as at the prompt of Python: write them in a file or a notebook.

    Examples
    --------
    >>> import numpy as np
    >>> from gnomon.cases.core.forms import FirstOrder
    >>> def decay(t, y, p):
    ...     return (-p[0] * y[0],)
    >>> problem = Problem(FirstOrder(decay), 1, np.array([2.0]), np.array([0.5, 1.0]), time_scale=0.5)
    >>> right_hand_side(problem).array(0.0, np.array([3.0]), problem.buffer)
    array([-6.])
    """
    return kernel(problem.form, len(problem.parameters), problem.dimension, problem.counted)


def acceleration(problem: Problem) -> Kernel:
    """The compiled acceleration of a second-order problem; it counts its calls if `problem.counted`."""
    half, form = problem.dimension // 2, problem.form
    assert isinstance(form, forms.SecondOrder)
    return function_kernel(form.acceleration, half, len(problem.parameters), half, problem.counted)


def kernel(form: Any, parameters: int, dimension: int, counted: bool = False) -> Kernel:
    """The first-order right-hand side of a form (FirstOrder, SecondOrder or RigidBody), compiled.

    With `counted`, the parameter array has one more element, to which each call adds 1.
    """
    first = forms.first_order(getattr(form, "source", None) or form)
    if first is None:
        raise ValueError(f"{type(form).__name__} has no right-hand side to compile")
    if not isinstance(first.equations, Called):
        check_source(first.equations, set())
        check_form(first, dimension, parameters)
    return function_kernel(first.equations, dimension, parameters, dimension, counted)


def check_form(form: forms.FirstOrder, dimension: int, parameters: int) -> None:
    """Raise ValueError if a function of the form raises an exception or gives another number of values than it must."""
    source, half = form.source, dimension // 2
    if isinstance(source, forms.SecondOrder):
        check_values(source.acceleration, (half, parameters), half)
    elif source is not None:
        check_values(source.inertia, (parameters,), 3)
        check_values(source.torque, (dimension, parameters), 3)
    else:
        check_values(form.equations, (dimension, parameters), dimension)


def function_kernel(
    function: Callable[..., Any], states: int, parameters: int, outputs: int, counted: bool = False
) -> Kernel:
    """Compile any plain function (t, state, parameters) -> tuple of `outputs` values."""
    sizes = states, parameters, outputs
    if isinstance(function, Called):
        return CalledKernel(function, sizes, counted)
    kernel = _compile(function, sizes)
    return kernel.counted() if counted else kernel


@cache_by_content
def _compile(function: Callable[..., Any], sizes: tuple[int, int, int]) -> Kernel:
    states, parameters, outputs = sizes
    check_source(function, set())
    check_values(function, (states, parameters), outputs)

    def body(t: ir.Value, y: ir.Array, p: ir.Array, out: ir.Array) -> None:
        write(out, emission.Translation().inline(function)(t, content(y), content(p)))

    return Kernel(f"equations\n{emission.fingerprint(function)}", body, sizes)


def content(array: ir.Array) -> tuple[Any, ...]:
    """The elements of an array of the emitted code, as a tuple of symbolic values."""
    return tuple(array[i] for i in range(len(array)))


def write(out: ir.Array, values: Sequence[Any]) -> None:
    for i, value in enumerate(values):
        out[i] = value


def check_values(function: Callable[..., Any], sizes: Sequence[int], wanted: int) -> None:
    """Raise ValueError if a function of p, or of (t, y, p), raises an exception or gives no tuple of `wanted` values.

    `sizes`: the numbers of values in p, or in y and p.
    """
    nan, name = math.nan, function.__name__
    arguments = [*([nan] if len(sizes) > 1 else []), *((nan,) * size for size in sizes)]
    try:
        values = function(*arguments)
    except Exception as error:
        raise ValueError(
            f"{name}({'t, y, p' if len(sizes) > 1 else 'p'}) raises {type(error).__name__}: {error}"
        ) from error
    if not isinstance(values, tuple):
        raise ValueError(f"{name} gives a {type(values).__name__}; let it give a tuple of {wanted}")
    if len(values) != wanted:
        count = f"{len(values)} value{'' if len(values) == 1 else 's'}"
        raise ValueError(f"{name} gives {count} where {wanted} {'is' if wanted == 1 else 'are'} wanted")


def check_source(function: Callable[..., Any], seen: set[Any]) -> None:
    """Raise ValueError for equations that cannot be compiled.

    They are a lambda, a `raise` statement, or a global that is neither a number nor a function.
    """
    if function in seen:
        return
    seen.add(function)
    name = function.__name__
    if name == "<lambda>":
        raise ValueError(f"{function.__qualname__} is a lambda; write it as a function")
    if dis.opmap["RAISE_VARARGS"] in function.__code__.co_code[::2]:
        raise ValueError(f"{name} raises an exception, which compiled code cannot pass on; let it give nan instead")
    if not all(isinstance(value, int | float) for value in function.__defaults__ or ()):
        raise ValueError(f"{name} has default values {function.__defaults__!r}; equations may have numbers there")
    for used, value in emission.uses(function).items():
        if isinstance(value, types.FunctionType):
            check_source(value, seen)
        elif not (isinstance(value, int | float) or value is getattr(math, used, None) or used in emission.BUILTINS):
            raise ValueError(f"{name} uses {used} = {value!r}; equations may use numbers, plain functions and math")

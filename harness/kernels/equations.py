"""Compile the equations of a case: each function becomes a generated module, with its machine code in the user's cache.

The name of a module is a hash of its whole source, so that every edit makes another module. All compiled functions have
the signature `void(t, y, parameters, out)`, so an integrator is compiled once and calls any case by function pointer.
"""

import ast
import dis
import inspect
import linecache
import math
import types
from collections.abc import Callable
from functools import cache, cached_property
from typing import Any

from gnomon.cases.core import forms
from gnomon.cases.core.arithmetic import FUNCTIONS, _names
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.contract.sources import cached_by_content
from gnomon.harness.kernels import counting, emission, ir, machine

OPTIONS = 'error_model="numpy", fastmath={"contract"}'
INNER = f"{OPTIONS}, no_cpython_wrapper=True, no_cfunc_wrapper=True"
"""Options of a function that only compiled code calls. They omit its entry points for Python and C, which would take
numba an eighth of the time of compilation."""
SIGNATURE = "void(float64, float64[::1], float64[::1], float64[::1])"
ARRAY_SIGNATURE = "float64[::1](float64, float64[::1], float64[::1])"
IMPORTS = ["import numpy as np", "from numba import carray, njit"]
C_SIGNATURE = "void(float64, CPointer(float64), CPointer(float64), CPointer(float64))"


class Kernel:
    """Compiled equations that can be called in three ways, each linked on first use.

    A kernel with `plain` adds 1 to p[counts] at each call and then calls `plain`. Both share the machine code of
    `plain`, which the timed calls need in any case.
    """

    def __init__(
        self, key: str, emit: Callable[[], None], sizes: tuple[int, int, int], plain: "Kernel | None" = None
    ) -> None:
        self.key, self.emit, self.sizes, self.plain = key, emit, sizes, plain

    @cached_property
    def address(self) -> int:
        """Address of the C function void(double t, double *y, double *p, double *out), which in-house methods call."""
        if self.plain is not None:
            return counting.address(self.plain.address, self.sizes[1])
        self.code = machine.code(self.key, ("kernel",), self.emit)
        return self.code.addresses["kernel"]

    @cached_property
    def pointer(self) -> Any:
        """The compiled function (t, y, p, out) -> None."""
        if self.plain is not None:
            return _counted(self.plain.pointer, self.sizes[1])
        return self._entry("pointer", "float float[1] float[1] float[1]", 0)

    @cached_property
    def array(self) -> Any:
        """The compiled function (t, y, p) -> new array."""
        if self.plain is not None:
            return _counted(self.plain.array, self.sizes[1])
        return self._entry("array", "float float[1] float[1] float[1]", self.sizes[2])

    def _entry(self, name: str, signature: str, returns: int) -> Any:
        states, parameters, outputs = self.sizes

        def body(t: Any, y: Any, p: Any, out: Any) -> None:
            ir.here().do(f"call void @kernel({', '.join(x.typed for x in (t, y.pointer, p.pointer, out.pointer))})")

        def emit() -> None:
            self.emit()
            emission.define("sized", signature, body, "void")
            machine.define_entry(name, signature, "sized", "void", returns, ((states,), (parameters,), (outputs,)))

        found = machine.code(f"{name} {self.key}", (name,), emit)
        return machine.callable_at(found.addresses[name], name, found)


def _counted(function: Callable[..., Any], place: int) -> Callable[..., Any]:
    """A function (t, y, p, ...) that adds 1 to p[place] and then calls `function`."""

    def counted(t: float, y: Any, p: Any, *out: Any) -> Any:
        p[place] += 1.0
        return function(t, y, p, *out)

    return counted


def compiled(source: str, name: str, signature: str = "") -> Any:
    """The function `name` of a generated module, compiled for `signature`, or else for the signature in the source."""
    return keeper().function(source, name, signature)


def address(source: str, name: str, signature: str = C_SIGNATURE) -> int:
    """The address of the function `name` of a generated module as a C function, by default (t, y, p, out) -> void."""
    found: int = keeper().address(source, name, signature)
    return found


@cache
def keeper() -> Any:
    """The module that compiles and keeps functions: `machine_code` for known versions of numba, else `numba_fallback`."""
    from gnomon.harness.kernels import numba_fallback  # loads numba

    if not numba_fallback.known():
        return numba_fallback
    from gnomon.harness.kernels import machine_code

    return machine_code


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
        If the equations cannot be compiled: a closure, a lambda, a `raise` statement, a global that is neither a number
        nor a function, or another number of values than the form needs.
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
    if isinstance(form, forms.FirstOrder) and form.source is not None:
        form = form.source
    if isinstance(form, forms.FirstOrder):
        return function_kernel(form.equations, dimension, parameters, dimension, counted)
    if isinstance(form, forms.SecondOrder):
        half = dimension // 2
        call = f"acceleration(t, ({_items('y', half)}), p)"
        return call_kernel({"acceleration": form.acceleration}, call, dimension, parameters, dimension, counted, half)
    if isinstance(form, forms.RigidBody):
        functions = {"inertia": form.inertia, "torque": form.torque, "euler": forms.euler_equations}
        call = "euler(y, inertia(p), torque(t, y, p))"
        return call_kernel(functions, call, dimension, parameters, dimension, counted)
    raise ValueError(f"{type(form).__name__} has no right-hand side to compile")


def function_kernel(
    function: Callable[..., Any], states: int, parameters: int, outputs: int, counted: bool = False
) -> Kernel:
    """Compile any plain function (t, state, parameters) -> tuple of `outputs` values."""
    return call_kernel({"function": function}, "function(t, y, p)", states, parameters, outputs, counted)


@cached_by_content
def call_kernel(
    functions: dict[str, Callable[..., Any]], call: str, states: int, parameters: int, outputs: int,
    counted: bool = False, lead: int = 0,
) -> Kernel:  # fmt: skip
    """Compile the expression `call`, whose value is a tuple: it may use the names of `functions`, and t, y and p.

    The kernel writes into `out` (outputs,) first the second half of y (`lead` values, for q' = v), then the tuple.
    """
    plain = call_kernel(functions, call, states, parameters, outputs, False, lead) if counted else None
    check_values(functions, call, states, parameters, outputs - lead)
    for function in functions.values():
        check_source(function, set())
    sizes = states, parameters, outputs
    prints = "\n".join(f"{name}: {emission.fingerprint(function)}" for name, function in functions.items())

    def emit() -> None:
        translation = emission.Translation()
        known = {name: translation.inline(function) for name, function in functions.items()}
        with ir.Function("void @kernel(double %t, ptr %y, ptr %p, ptr %out)") as f:
            y, p, out = (_numbers(name, size) for name, size in zip(("y", "p", "out"), sizes, strict=True))
            state = tuple(y[i] for i in range(states))
            given = {"t": ir.Value(ir.D, "%t"), "y": state, "p": tuple(p[i] for i in range(parameters))}
            for i, value in enumerate((*state[lead : 2 * lead], *eval(call, known, given))):
                out[i] = value
            f.do("ret void")

    return Kernel(f"{call} {sizes} {lead}\n{prints}", emit, sizes, plain)


def _numbers(name: str, size: int) -> ir.Array:
    return ir.Array(ir.Value(ir.POINTER, f"%{name}"), (size,))


def check_values(functions: dict[str, Any], call: str, states: int, parameters: int, wanted: int) -> None:
    """Raise ValueError if the expression `call` raises an exception or does not give a tuple of `wanted` values."""
    nan = math.nan
    try:
        found = eval(call, dict(functions), {"t": nan, "y": (nan,) * states, "p": (nan,) * parameters})
    except Exception as error:
        raise ValueError(f"{call} raises {type(error).__name__}: {error}") from error
    names = ", ".join(function.__name__ for function in functions.values())
    if not isinstance(found, tuple):
        raise ValueError(f"{names} gives a {type(found).__name__}; let it give a tuple of {wanted}")
    if len(found) != wanted:
        count = f"{len(found)} value{'' if len(found) == 1 else 's'}"
        raise ValueError(f"{names} gives {count} where {wanted} {'is' if wanted == 1 else 'are'} wanted")


def unpack_arguments(states: int, parameters: int) -> list[str]:
    """Source lines that copy the arrays y_ and p_ into the tuples y and p, which plain functions take."""
    return [f"{name} = ({_items(f'{name}_', count)})" for name, count in (("y", states), ("p", parameters))]


def _items(name: str, count: int) -> str:
    return "".join(f"{name}[{i}], " for i in range(count))


def gather(functions: dict[str, Callable[..., Any]]) -> str:
    """Source text that defines `functions` and all functions that they call, decorated for numba."""
    seen: dict[str, Callable[..., Any]] = {}
    parts = list(IMPORTS)
    for function in functions.values():
        gather_into(function, seen, parts)
    return "\n".join(parts)


def gather_into(function: Callable[..., Any], seen: dict[str, Any], parts: list[str]) -> None:
    """Append to `parts` the source of a function and of all that it uses, except names in `seen`.

    Raises ValueError for a function that numba cannot compile: a closure, a `raise` statement, or a global that is
    neither a number nor a function.
    """
    name = function.__name__
    if name in seen:
        if seen[name] is not function:
            raise ValueError(f"two different functions are called {name}; rename one so that both can be compiled")
        return
    if name == "<lambda>" or function.__closure__:
        raise ValueError(f"{function.__qualname__} is a lambda or a closure; write it as a function of a module")
    if dis.opmap["RAISE_VARARGS"] in function.__code__.co_code[::2]:
        raise ValueError(f"{name} raises an exception, which compiled code cannot pass on; let it give nan instead")
    seen[name] = function
    for used in sorted(_names(function.__code__)):
        value = function.__globals__.get(used)
        if used in seen and value is seen[used]:
            continue
        if isinstance(value, types.FunctionType):
            gather_into(value, seen, parts)
        elif used in FUNCTIONS and value is getattr(math, used):
            parts.append(f"from math import {used}")
        elif isinstance(value, int | float):
            line = f"{used} = {value!r}"
            other = next((part for part in parts if part.startswith(f"{used} = ")), line)
            if other != line:
                raise ValueError(f"{name} uses {line}, another function uses {other}; rename one of the two numbers")
            parts.append(line)
        elif value is not None:
            raise ValueError(f"{name} uses {used} = {value!r}; equations may use numbers, plain functions and math")
    source = with_defaults(function, inspect.cleandoc("\n" + source_of(function)))
    parts.append(f"@njit({INNER})\n{source}\n")


def check_source(function: Callable[..., Any], seen: set[Any]) -> None:
    """Raise ValueError for equations that cannot be compiled.

    They are a closure, a `raise` statement, or a global that is neither a number nor a function.
    """
    if function in seen:
        return
    seen.add(function)
    name = function.__name__
    uses = emission.uses(function)
    if dis.opmap["RAISE_VARARGS"] in function.__code__.co_code[::2]:
        raise ValueError(f"{name} raises an exception, which compiled code cannot pass on; let it give nan instead")
    if not all(isinstance(value, int | float) for value in function.__defaults__ or ()):
        raise ValueError(f"{name} has default values {function.__defaults__!r}; equations may have numbers there")
    for used, value in uses.items():
        if isinstance(value, types.FunctionType):
            check_source(value, seen)
        elif not (isinstance(value, int | float) or value is getattr(math, used, None) or used in emission.BUILTINS):
            raise ValueError(f"{name} uses {used} = {value!r}; equations may use numbers, plain functions and math")


def with_defaults(function: Callable[..., Any], source: str) -> str:
    """The source of a function with its default values as numbers: generated modules do not define names in them."""
    values = function.__defaults__ or ()
    if not values:
        return source
    if not all(isinstance(value, int | float) for value in values):
        raise ValueError(f"{function.__name__} has default values {values!r}; equations may have numbers there")
    tree = ast.parse(source)
    (definition,) = tree.body
    assert isinstance(definition, ast.FunctionDef)
    definition.args.defaults = [ast.parse(repr(value), mode="eval").body for value in values]
    return ast.unparse(tree)


def source_of(function: Callable[..., Any]) -> str:
    """The source of a function, faster than by inspect.getsource, which tokenizes the file and searches all modules."""
    code = function.__code__
    linecache.checkcache(code.co_filename)  # the module may have been edited and loaded again
    lines = linecache.getlines(code.co_filename, function.__globals__)
    if not lines:
        return inspect.getsource(function)
    first, last = code.co_firstlineno - 1, max(line for _, _, line in code.co_lines() if line)
    margin = lines[first][: -len(lines[first].lstrip())]
    while last < len(lines) and lines[last].startswith((f"{margin} ", f"{margin})")):
        last += 1
    return "".join(lines[first:last])

"""Emit ordinary functions as LLVM IR: their names get meanings for symbolic values, and each function becomes one of the IR.

A function may use numbers, plain functions of modules, `math`, a few names of numpy, the operations of `PRIMITIVES`, and
records (classes of `NamedTuple`), which become their fields: they cost nothing.
Its source is rewritten once (`rewriting`); `Translation` binds its names.
"""

import builtins
import dis
import hashlib
import inspect
import math
import traceback
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import cache
from itertools import islice
from pathlib import Path
from types import BuiltinFunctionType, FunctionType, ModuleType, SimpleNamespace
from typing import Any

import numpy as np
from gnomon.cases.core import arithmetic
from gnomon.harness.kernels import ir, rewriting
from gnomon.harness.kernels.ir import INTEGER, REAL, TRUTH, VECTOR, Array, Complex, Subset, Value, convert, is_symbolic

# What names mean -------------------------------------------------------------------------------------------------------


def _function(name: str) -> Callable[..., Any]:
    plain: Callable[..., Any] = getattr(math, name)

    def function(*arguments: Any) -> Any:
        if not is_symbolic(*arguments):
            return plain(*arguments)
        values = [convert(x, REAL) for x in arguments]
        return ir.call(name if name in ir.LIBRARY else f"llvm.{name}.f64", REAL, *values)

    return function


def size_of(x: Any) -> Any:
    """abs"""
    if isinstance(x, Complex):
        return MATH["hypot"](x.real, x.imag)
    if not is_symbolic(x):
        return abs(x)
    if x.kind == INTEGER:
        return ir.select(x < 0, -x, x)
    return ir.call(f"llvm.fabs.{'v8f64' if x.kind == VECTOR else 'f64'}", x.kind, x)


def largest(*values: Any) -> Any:
    """max: the later value only where it is greater, so that nan is kept as Python keeps it."""
    high = values[0]
    for x in values[1:]:
        high = ir.select(ir.compare("gt", x, high), x, high) if is_symbolic(x, high) else max(high, x)
    return high


def least(*values: Any) -> Any:
    """min"""
    low = values[0]
    for x in values[1:]:
        low = ir.select(ir.compare("lt", x, low), x, low) if is_symbolic(x, low) else min(low, x)
    return low


def integer(x: Any) -> Any:
    """int"""
    if not is_symbolic(x):
        return int(x)
    return ir.here().emit(INTEGER, f"fptosi double {x} to i64") if x.kind == REAL else convert(x, INTEGER)


def nearest(x: Any) -> Any:
    """round"""
    return integer(ir.call("llvm.roundeven.f64", REAL, x)) if is_symbolic(x) else round(x)


def boolean(x: Any) -> Any:
    """bool"""
    return ir.truth(x) if is_symbolic(x) else bool(x)


def number(x: Any) -> Any:
    """float"""
    return convert(x, REAL) if is_symbolic(x) else float(x)


def power(x: Any, exponent: Any) -> Any:
    return x**exponent


def empty(shape: Any, dtype: Any = np.float64) -> Array:
    kind, pairs = {np.float64: (REAL, False), np.int64: (INTEGER, False), np.complex128: (REAL, True)}[dtype]
    return ir.new_array(shape, kind, pairs)


def zeros(shape: Any, dtype: Any = np.float64) -> Array:
    array = empty(shape, dtype)
    flat = Array(array.pointer, (array.size,), array.kind, array.pairs)
    flat[:] = 0 if array.kind == INTEGER else 0.0
    return array


MATH: dict[str, Any] = {name: _function(name) for name in sorted(ir.INTRINSICS | ir.LIBRARY) if hasattr(math, name)} | {
    "pow": power,
    "hypot": arithmetic.pairwise(_function("hypot")),
    "log": arithmetic.to_any_base(_function("log")),
}
NAMES_OF_MATH = {getattr(math, name): function for name, function in MATH.items()}
NUMPY = {
    "inf": math.inf, "nan": math.nan, "pi": math.pi, "empty": empty, "zeros": zeros, "abs": size_of,
    "float64": np.float64, "int64": np.int64, "complex128": np.complex128, "isfinite": lambda x: size_of(x) < math.inf, "isnan": lambda x: x != x,
    **{name: MATH[name] for name in ("sqrt", "sin", "cos", "tan", "exp", "log", "log10", "log2", "floor", "ceil", "hypot")},
}  # fmt: skip
BUILTINS = {
    "abs": size_of, "max": largest, "min": least, "int": integer, "bool": boolean, "float": number, "complex": Complex, "round": nearest,
    "range": ir.range_, "len": len, "tuple": tuple, "zip": zip, "enumerate": enumerate, "reversed": reversed, "sum": sum,
}  # fmt: skip
"""`len`, `zip` and the like run while the code is emitted."""

PRIMITIVES: dict[Any, Callable[..., Any]] = {}
"""The meaning of functions that have one of their own: `primitive` adds to it."""


def primitive(plain: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """A decorator: the decorated function emits the code of the operation that `plain` computes."""

    def register(function: Callable[..., Any]) -> Callable[..., Any]:
        PRIMITIVES[plain] = function
        return function

    return register


def turns(count: int) -> range:
    """A range whose loop stays a loop in emitted code, also where its length is known."""
    return range(count)


@primitive(turns)
def _(count: Any) -> Any:
    return ir.range_(convert(count, INTEGER))


# Functions -------------------------------------------------------------------------------------------------------------


class Translation:
    """The functions of one module of machine code.

    `replaced`: values, by name, in the place of numbers and functions of the modules. `inlined`: names of functions that
    become part of their callers. `cold`: names of functions that are rarely called; with it, all others become part of
    their callers.
    """

    def __init__(
        self,
        replaced: Mapping[str, Any] | None = None,
        inlined: Collection[str] = (),
        cold: Collection[str] | None = None,
    ) -> None:
        self.replaced, self.inlined, self.cold = dict(replaced or {}), set(inlined), cold
        self.known: dict[Any, Callable[..., Any]] = {}

    def function(self, plain: Callable[..., Any]) -> Callable[..., Any]:
        """The function on symbolic values; its source is read at the first call."""
        if plain in PRIMITIVES:
            return PRIMITIVES[plain]
        if plain not in self.known:
            function = self.inline(plain)
            if self.cold is None:
                function = ir.Outlined(function)
            elif plain.__name__ in self.cold:
                function = ir.Outlined(function, f"{ir.ATTRIBUTES} noinline cold")
            self.known[plain] = function
        return self.known[plain]

    def inline(self, plain: Callable[..., Any]) -> Callable[..., Any]:
        """The function as a part of the functions that call it."""
        bound: list[Callable[..., Any]] = []

        def inline(*arguments: Any) -> Any:
            try:
                if not bound:
                    bound.append(self._bound(plain))
                return bound[0](*arguments)
            except Exception as error:
                raise add_place(error, plain) from error

        inline.__name__ = plain.__name__
        return inline

    def _bound(self, plain: Callable[..., Any]) -> Callable[..., Any]:
        space: dict[str, Any] = {rewriting.HELPERS: ir, "__builtins__": {}}
        for name, value in uses(plain).items():
            space[name] = self._meaning(name, self.replaced.get(name, value))
        exec(rewriting.rewritten(plain), space)
        function: Callable[..., Any] = space[plain.__name__]
        function.__defaults__ = plain.__defaults__
        return function

    def _meaning(self, name: str, value: Any) -> Any:
        if value is np:
            return SimpleNamespace(**NUMPY)
        if value is math:
            return SimpleNamespace(**MATH, inf=math.inf, nan=math.nan, pi=math.pi)
        if isinstance(value, FunctionType):
            inlined = name in self.inlined and value not in PRIMITIVES and not allocates(value)
            return self.inline(value) if inlined else self.function(value)
        if isinstance(value, BuiltinFunctionType | type) and name in BUILTINS and getattr(builtins, name) is value:
            return BUILTINS[name]
        return NAMES_OF_MATH.get(value, value) if isinstance(value, BuiltinFunctionType) else value


def add_place(error: Exception, plain: Callable[..., Any]) -> Exception:
    """A refusal that names the file and the line of a function at which its emission failed."""
    if isinstance(error, Subset) and error.placed:
        return error
    file = plain.__code__.co_filename
    lines = [line for frame, line in traceback.walk_tb(error.__traceback__) if frame.f_code.co_filename == file]
    why = error if isinstance(error, Subset) else f"{type(error).__name__}: {error}"
    refusal = Subset(f"{file}, line {lines[-1]}: {why}" if lines else str(why))
    refusal.placed = bool(lines)
    return refusal


def allocates(function: Callable[..., Any]) -> bool:
    """Whether a function makes arrays. They live until it returns, so it cannot become part of a loop that calls it."""
    return not {"empty", "zeros"}.isdisjoint(function.__code__.co_names)


def uses(function: Callable[..., Any]) -> dict[str, Any]:
    """The globals, the builtins and the variables of outer functions that a function uses, by name."""
    used = {}
    for name in _global_names(function.__code__):
        if name in function.__globals__:
            used[name] = function.__globals__[name]
        elif hasattr(builtins, name):
            used[name] = getattr(builtins, name)
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        used[name] = cell.cell_contents
    return used


@cache
def _global_names(code: Any) -> tuple[str, ...]:
    names = {x.argval for x in dis.get_instructions(code) if x.opname == "LOAD_GLOBAL"}
    inner = [x for x in code.co_consts if hasattr(x, "co_code")]
    return tuple(sorted(names.union(*(_global_names(x) for x in inner))))


def fingerprint(function: Callable[..., Any], replaced: Mapping[str, Any] | None = None) -> str:
    """A text that changes whenever the emitted code of a function may: its source and all that it uses."""
    seen: dict[Any, str] = {}

    def visit(value: Any) -> str:
        value = inspect.unwrap(value) if callable(value) else value
        if isinstance(value, FunctionType):
            value = PRIMITIVES.get(value, value)
            if value not in seen and not value.__module__.startswith(f"{__package__}."):  # these are in `emitter`
                seen[value] = ""
                used = {name: (replaced or {}).get(name, x) for name, x in uses(value).items()}
                records = [visit(kind) for kind in value.__annotations__.values() if hasattr(kind, "_fields")]
                parts = [rewriting.source_of(value), repr(value.__defaults__), *records]
                if value.__name__ == "<lambda>":  # the source may have several
                    parts.append(repr([place[2:] for place in value.__code__.co_positions()]))
                parts += [f"{name} = {visit(x)}" for name, x in used.items()]
                seen[value] = "\n".join(parts)
            return f"{value.__module__}.{value.__qualname__}"
        if isinstance(value, ModuleType) and value.__name__.startswith("gnomon."):  # its numbers are read as attributes
            return hashlib.sha256(Path(value.__file__ or "").read_bytes()).hexdigest()
        if hasattr(value, "_fields"):  # a class of records
            return f"{value.__name__}{value._fields}"
        if isinstance(value, ModuleType | type | FunctionType | BuiltinFunctionType):
            return value.__name__
        if isinstance(value, np.ndarray):
            value = value.dtype, value.tolist()
        text = value.typed if isinstance(value, ir.Value) else repr(value)
        if " at 0x" in text:
            raise Subset(f"{function.__qualname__} uses {text}, which has no value that the key of kept code can name")
        return text

    return visit(function) + "\n" + "\n".join(seen.values())


def read(function: Callable[..., Any]) -> None:
    """Rewrite the sources of a function and of all that it uses, once in a process."""
    for used in uses(function).values():
        if isinstance(used, FunctionType) and used not in PRIMITIVES and used not in _read:
            _read.add(used)
            read(used)
    rewriting.rewritten(function)


_read: set[Callable[..., Any]] = set()


@cache
def emitter() -> str:
    """A hash of the modules that emit code: code that others have emitted is not used.

    `arithmetic` traces the equations. Primitives of other modules are in `fingerprint`.
    """
    files = [*sorted(Path(__file__).parent.glob("*.py")), Path(arithmetic.__file__)]
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


# Entries ---------------------------------------------------------------------------------------------------------------


def gather(plain: Callable[..., Any], values: Iterable[Any]) -> Iterator[Any]:
    """The arguments of a function from a row of values: a parameter whose annotation is a record takes all its fields."""
    left = iter(values)
    for parameter in inspect.signature(plain).parameters.values():
        fields = getattr(parameter.annotation, "_fields", None)
        yield next(left) if fields is None else parameter.annotation(*islice(left, len(fields)))


WORDS = {"float": REAL, "int": INTEGER, "bool": TRUTH}


def parameters(signature: str) -> Iterator[tuple[str, int]]:
    """(kind, number of dimensions) of each word of a signature such as "int float[1] float[2]"."""
    for word in signature.split():
        name, _, rest = word.partition("[")
        yield WORDS[name], int(rest[:-1]) if rest else 0


def define(name: str, signature: str, body: Callable[..., Any], result: str = INTEGER) -> None:
    """Emit the function @name, whose arrays are addresses followed by sizes, around a function on symbolic values."""
    heads: list[str] = []
    arguments: list[Value | Array] = []
    for n, (kind, dimensions) in enumerate(parameters(signature)):
        if not dimensions:
            heads.append(f"{kind} %a{n}")
            arguments.append(Value(kind, f"%a{n}"))
            continue
        sizes = [Value(INTEGER, f"%a{n}_{k}") for k in range(dimensions)]
        heads += [f"ptr %a{n}", *(size.typed for size in sizes)]
        arguments.append(Array(Value(ir.POINTER, f"%a{n}"), tuple(sizes), kind))
    with ir.Function(f"{{result}} @{name}({', '.join(heads)})") as f:
        value = body(*arguments)
        f.result = result
        f.do("ret void" if result == "void" else f"ret {convert(value, result).typed}")

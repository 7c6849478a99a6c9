"""Symbolic values that write the intermediate representation of LLVM (IR): numbers, lanes, arrays, branches and loops.

Code that runs on these values emits one instruction for each operation. A value has a kind: VECTOR (the lanes), REAL,
INTEGER or TRUTH. Numbers of Python stay numbers until they meet a symbolic value. So a branch on numbers is decided while the
code is emitted. `rewriting` turns the branches and loops of ordinary functions into calls of this
module. One `Module` is current in a thread.
"""

import math
import re
import struct
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any

VECTOR, REAL, INTEGER, TRUTH, POINTER = "<8 x double>", "double", "i64", "i1", "ptr"
LANES = 8
RANK = {TRUTH: 0, INTEGER: 1, REAL: 2, VECTOR: 3}
"""An operation converts its operands to the highest of their kinds."""

CONTRACT = "contract "
"""The flag that lets LLVM fuse a product and a sum, which rounds once. Operations whose residuals are computed lack it."""

_current = threading.local()


class Subset(ValueError):  # noqa: N818 - it names the rule, as a lookup of errors would not
    """Raised for code outside the subset of Python that can be emitted. `placed`: whether the text has file and line."""

    placed = False


class Module:
    """The functions of one piece of machine code."""

    def __init__(self) -> None:
        self.functions: list[Function] = []
        self.declared: dict[str, str] = {}
        self.stack: list[Function] = []
        self.outlined: dict[Any, tuple[str, str, Any, list[str], list[int]]] = {}

    def __enter__(self) -> "Module":
        self.outer = getattr(_current, "module", None)
        _current.module = self
        return self

    def __exit__(self, *_: object) -> None:
        _current.module = self.outer

    def text(self) -> str:
        return "\n".join([*(function.text() for function in self.functions), *self.declared.values(), ""])


def module() -> Module:
    emitted: Module | None = getattr(_current, "module", None)
    assert emitted is not None, "a symbolic value outside the emission of a module"
    return emitted


def here() -> "Function":
    """The function that is emitted now."""
    return module().stack[-1]


ATTRIBUTES = 'nounwind "no-builtin-memcpy" "no-builtin-memmove" "no-builtin-memset"'
"""Of functions. Arrays are short: a loop over a state takes a third of the time of the call that would replace it."""


class Function:
    """The lines of a function. Slots are allocated in its first block, where LLVM turns them into registers.

    depth: the number of branches and loops around the next line. copies: the number of times that loops of Python emit it.
    """

    def __init__(self, head: str, attributes: str = ATTRIBUTES) -> None:
        self.head, self.attributes, self.result = head, attributes, "void"
        self.lines: list[str] = []
        self.allocations: list[str] = []
        self.count = self.depth = 0
        self.copies = 1
        module().functions.append(self)

    def __enter__(self) -> "Function":
        module().stack.append(self)
        return self

    def __exit__(self, *_: object) -> None:
        module().stack.pop()

    def text(self) -> str:
        head = f"define {self.head.format(result=self.result)} {self.attributes} {{"
        return "\n".join([head, "entry:", *self.allocations, "  br label %start", "start:", *self.lines, "}"])

    def name(self, prefix: str) -> str:
        self.count += 1
        return f"{prefix}{self.count}"

    def emit(self, kind: str, operation: str) -> "Value":
        name = self.name("%x")
        self.lines.append(f"  {name} = {operation}")
        return Value(kind, name)

    def do(self, line: str) -> None:
        self.lines.append(f"  {line}")

    def at(self, label: str) -> None:
        self.lines.append(f"{label}:")

    def go(self, label: str) -> None:
        self.do(f"br label %{label}")

    def allocate(self, kind: str, align: int = 8) -> str:
        name = self.name("%s")
        self.allocations.append(f"  {name} = alloca {kind}, align {align}")
        return name


# Values ----------------------------------------------------------------------------------------------------------------


class Value:
    """A number, or eight of them, that the emitted code will compute."""

    __slots__ = ("kind", "text")

    def __init__(self, kind: str, text: str) -> None:
        self.kind, self.text = kind, text

    def __str__(self) -> str:
        return self.text

    @property
    def typed(self) -> str:
        return f"{self.kind} {self.text}"

    def __bool__(self) -> bool:
        raise Subset("a condition on values that only the emitted code knows, where Python decides at once")

    __hash__ = object.__hash__

    def __add__(self, other: Any) -> Any:
        return arithmetic("add", self, other)

    def __radd__(self, other: Any) -> Any:
        return arithmetic("add", other, self)

    def __sub__(self, other: Any) -> Any:
        return arithmetic("sub", self, other)

    def __rsub__(self, other: Any) -> Any:
        return arithmetic("sub", other, self)

    def __mul__(self, other: Any) -> Any:
        return arithmetic("mul", self, other)

    def __rmul__(self, other: Any) -> Any:
        return arithmetic("mul", other, self)

    def __truediv__(self, other: Any) -> Any:
        return divide(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return divide(other, self)

    def __neg__(self) -> "Value":
        operation = f"sub i64 0, {self}" if self.kind == INTEGER else f"fneg {CONTRACT}{self.typed}"
        return here().emit(self.kind, operation)

    def __pos__(self) -> "Value":
        return self

    def __pow__(self, exponent: Any) -> Any:
        return power(self, exponent)

    def __rpow__(self, base: Any) -> Any:
        return power(base, self)

    def __floordiv__(self, other: Any) -> Any:
        quotient, rest = self._divided(other)
        return arithmetic(
            "sub",
            quotient,
            convert(compare("slt", rest ^ convert(other, INTEGER), 0) & compare("ne", rest, 0), INTEGER),
        )

    def __mod__(self, other: Any) -> Any:
        _, rest = self._divided(other)
        wrong = compare("slt", rest ^ convert(other, INTEGER), 0) & compare("ne", rest, 0)
        return arithmetic("add", rest, select(wrong, convert(other, INTEGER), 0))

    def _divided(self, other: Any) -> tuple["Value", "Value"]:
        """Quotient and rest of integers, rounded towards zero."""
        divisor = convert(other, INTEGER)
        if self.kind != INTEGER:
            raise Subset("// and % take integers")
        return here().emit(INTEGER, f"sdiv i64 {self}, {divisor}"), here().emit(INTEGER, f"srem i64 {self}, {divisor}")

    def __and__(self, other: Any) -> "Value":
        return here().emit(self.kind, f"and {self.typed}, {convert(other, self.kind)}")

    def __or__(self, other: Any) -> "Value":
        return here().emit(self.kind, f"or {self.typed}, {convert(other, self.kind)}")

    def __xor__(self, other: Any) -> "Value":
        return here().emit(self.kind, f"xor {self.typed}, {convert(other, self.kind)}")

    def __lt__(self, other: Any) -> "Value":
        return compare("lt", self, other)

    def __le__(self, other: Any) -> "Value":
        return compare("le", self, other)

    def __gt__(self, other: Any) -> "Value":
        return compare("gt", self, other)

    def __ge__(self, other: Any) -> "Value":
        return compare("ge", self, other)

    def __eq__(self, other: object) -> "Value":  # type: ignore[override]
        return compare("eq", self, other)

    def __ne__(self, other: object) -> "Value":  # type: ignore[override]
        return compare("ne", self, other)

    def __iter__(self) -> Any:
        raise Subset("a number where several are wanted")

    @property
    def real(self) -> "Value":
        return self

    @property
    def imag(self) -> float:
        return 0.0


def is_symbolic(*values: Any) -> bool:
    """Whether one of the values is known only to the emitted code."""
    return any(isinstance(value, Value) for value in values)


def double_text(x: float) -> str:
    return f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}"


def kind_of(x: Any) -> str:
    if isinstance(x, Value):
        return x.kind
    if isinstance(x, bool):
        return TRUTH
    if isinstance(x, int):
        return INTEGER
    if isinstance(x, float):
        return REAL
    raise Subset(f"{type(x).__name__} {x!r} where a number is wanted")


def convert(x: Any, kind: str) -> Value:
    """The value as a Value of another kind. Raises Subset for a conversion that loses digits."""
    if not isinstance(x, Value):
        own = kind_of(x)
        if RANK[own] > RANK[kind]:
            raise Subset(f"the number {x!r} where {WORDS[kind]} is wanted")
        if kind == VECTOR:
            return Value(VECTOR, f"splat (double {double_text(float(x))})")
        return Value(
            kind, double_text(float(x)) if kind == REAL else str(int(x)) if kind == INTEGER else str(x).lower()
        )
    if x.kind == kind:
        return x
    if kind == REAL and x.kind == INTEGER:
        return here().emit(REAL, f"sitofp i64 {x} to double")
    if x.kind == TRUTH and kind in (INTEGER, REAL):
        return here().emit(kind, f"{'zext' if kind == INTEGER else 'uitofp'} i1 {x} to {kind}")
    if kind == VECTOR and x.kind in (REAL, INTEGER):
        first = here().emit(VECTOR, f"insertelement <8 x double> poison, {convert(x, REAL).typed}, i32 0")
        return here().emit(
            VECTOR, f"shufflevector <8 x double> {first}, <8 x double> poison, <8 x i32> zeroinitializer"
        )
    raise Subset(f"{WORDS[x.kind]} where {WORDS[kind]} is wanted; a variable keeps the kind that it gets first")


WORDS = {VECTOR: "eight lanes", REAL: "a float", INTEGER: "an integer", TRUTH: "a bool", POINTER: "an array"}


def common(a: Any, b: Any, least: str = TRUTH) -> tuple[Value, Value, str]:
    kind = max(kind_of(a), kind_of(b), least, key=RANK.__getitem__)
    return convert(a, kind), convert(b, kind), kind


def arithmetic(name: str, a: Any, b: Any, flags: str = CONTRACT) -> Any:
    """add, sub or mul, on integers or on floats."""
    if isinstance(b, Complex):
        return NotImplemented
    a, b, kind = common(a, b, INTEGER)
    return here().emit(kind, f"{name} nsw i64 {a}, {b}" if kind == INTEGER else f"f{name} {flags}{kind} {a}, {b}")


def exact(name: str, a: Any, b: Any) -> Any:
    """add, sub or mul that LLVM does not fuse with another operation."""
    return arithmetic(name, a, b, "")


def divide(a: Any, b: Any) -> Value:
    a, b, kind = common(a, b, REAL)
    return here().emit(kind, f"fdiv {CONTRACT}{kind} {a}, {b}")


def compare(how: str, a: Any, b: Any) -> Value:
    a, b, kind = common(a, b)
    if kind in (INTEGER, TRUTH):
        signed = "" if how in ("eq", "ne") or how.startswith("s") else "s"
        return here().emit(TRUTH, f"icmp {signed}{how} {kind} {a}, {b}")
    return here().emit(TRUTH, f"fcmp {'une' if how == 'ne' else f'o{how}'} {kind} {a}, {b}")


def power(base: Any, exponent: Any) -> Any:
    if isinstance(exponent, int) and not isinstance(exponent, bool):
        product, square, left = None, base, abs(exponent)
        while left:
            if left & 1:
                product = square if product is None else product * square
            left >>= 1
            if left:
                square = square * square
        return 1.0 if product is None else 1.0 / product if exponent < 0 else product
    if kind_of(exponent) == INTEGER and kind_of(base) == INTEGER:
        if base == -1:
            return 1 - 2 * (exponent & 1)
        raise Subset("an integer to the power of an integer that only the emitted code knows")
    # An integer exponent as a float: llvm.powi would call a function of a compiler's library that may be missing.
    return call("llvm.pow.f64", REAL, convert(base, REAL), convert(exponent, REAL))


def select(condition: Any, a: Any, b: Any) -> Any:
    if isinstance(a, tuple):
        return tuple(select(condition, x, y) for x, y in zip(a, b, strict=True))
    a, b, kind = common(a, b)
    return here().emit(kind, f"select i1 {condition}, {kind} {a}, {kind} {b}")


INTRINSICS = {"sqrt", "sin", "cos", "exp", "log", "log10", "log2", "pow", "floor", "ceil", "fabs", "fma", "roundeven"}
"""Intrinsics of LLVM, of floats and of lanes. Others may become calls of functions that do not exist."""
LIBRARY = {"tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "atan2", "hypot", "cbrt",
           "expm1", "log1p", "erf", "copysign", "fmod"}  # fmt: skip
"""Functions of floats of the C library."""
PYTHON = {"PyFloat_AsDouble", "PyLong_AsLongLong", "PyErr_Occurred", "PyLong_FromLongLong", "PyFloat_FromDouble",
          "PyEval_SaveThread"}  # fmt: skip
"""Functions of Python's C interface that return a value."""
ALLOWED = {*LIBRARY, *PYTHON, *(f"llvm.{name}.{kind}" for name in INTRINSICS for kind in ("f64", f"v{LANES}f64"))}


def call(name: str, result: str, *arguments: Value) -> Value:
    """Call an intrinsic of LLVM or an external function. Raises Subset for one that is not in ALLOWED."""
    if name not in ALLOWED:
        raise Subset(f"{name} is not a function that compiled code may call")
    module().declared[name] = f"declare {result} @{name}({', '.join(x.kind for x in arguments)})"
    return here().emit(result, f"call {result} @{name}({', '.join(x.typed for x in arguments)})")


class Complex:
    """A complex number of two values."""

    def __init__(self, real: Any, imag: Any) -> None:
        self.real, self.imag = real, imag

    @staticmethod
    def of(x: Any) -> "Complex":
        return x if isinstance(x, Complex) else Complex(x, 0.0)

    def __add__(self, other: Any) -> "Complex":
        other = Complex.of(other)
        return Complex(self.real + other.real, self.imag + other.imag)

    def __sub__(self, other: Any) -> "Complex":
        other = Complex.of(other)
        return Complex(self.real - other.real, self.imag - other.imag)

    def __rsub__(self, other: Any) -> "Complex":
        return Complex.of(other) - self

    def __neg__(self) -> "Complex":
        return Complex(-self.real, -self.imag)

    def __mul__(self, other: Any) -> "Complex":
        if not isinstance(other, Complex):
            return Complex(self.real * other, self.imag * other)
        a, b, c, d = self.real, self.imag, other.real, other.imag
        return Complex(a * c - b * d, a * d + b * c)

    __radd__, __rmul__ = __add__, __mul__

    def __truediv__(self, other: Any) -> "Complex":
        if not isinstance(other, Complex):
            return Complex(self.real / other, self.imag / other)
        below = other.real * other.real + other.imag * other.imag
        above = self * Complex(other.real, -other.imag)
        return Complex(above.real / below, above.imag / below)

    def __rtruediv__(self, other: Any) -> "Complex":
        return Complex.of(other) / self


# Arrays ----------------------------------------------------------------------------------------------------------------


class Array:
    """A C-contiguous array of doubles, integers or pairs of doubles (complex), by its address and sizes.

    An index that only the emitted code knows must not be negative: it is not checked. A part with fewer indices is an
    array, and so is [start:stop].
    """

    def __init__(self, pointer: Value, shape: tuple[Any, ...], kind: str = REAL, pairs: bool = False) -> None:
        self.pointer, self.shape, self.kind, self.pairs = pointer, shape, kind, pairs

    @property
    def size(self) -> Any:
        return math.prod(self.shape[1:], start=self.shape[0]) if len(self.shape) > 1 else self.shape[0]

    def reshape(self, shape: Any) -> "Array":
        """An array of other sizes with the numbers of this array."""
        return Array(self.pointer, shape if isinstance(shape, tuple) else (shape,), self.kind, self.pairs)

    def __len__(self) -> int:
        if is_symbolic(self.shape[0]):
            raise Subset("len of an array whose size only the emitted code knows; use .shape")
        return int(self.shape[0])

    def place(self, index: tuple[Any, ...]) -> Value:
        at: Any = 0
        for n, size in enumerate(self.shape):
            i = index[n] if n < len(index) else 0
            if not is_symbolic(i):
                if not is_symbolic(size) and not -size <= i < size:
                    raise Subset(f"index {i} of an array of {size}")
                i = size + i if i < 0 else i
            at = i if n == 0 else at * size + i
        return self._element(self.pointer, at * 2 if self.pairs else at)

    def _element(self, pointer: Value, at: Any) -> Value:
        return here().emit(POINTER, f"getelementptr inbounds {self.kind}, ptr {pointer}, i64 {convert(at, INTEGER)}")

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            if index.step is not None:
                raise Subset("a slice with a step")
            start = 0 if index.start is None else index.start
            stop = self.shape[0] if index.stop is None else index.stop
            ends = [x for x in (0, start, stop, self.shape[0]) if not is_symbolic(x)]
            if ends != sorted(ends):
                raise Subset(f"the slice [{start}:{stop}] of an array of {self.shape[0]}")
            return Array(self.place((start,)), (stop - start, *self.shape[1:]), self.kind, self.pairs)
        index = index if isinstance(index, tuple) else (index,)
        place = self.place(index)
        if len(index) < len(self.shape):
            return Array(place, self.shape[len(index) :], self.kind, self.pairs)
        if self.pairs:
            return Complex(self._load(place), self._load(self._element(place, 1)))
        return self._load(place)

    def _load(self, place: Value) -> Value:
        return here().emit(self.kind, f"load {self.kind}, ptr {place}, align 8")

    def __setitem__(self, index: Any, x: Any) -> None:
        if isinstance(index, slice):
            if index != slice(None) or len(self.shape) != 1:
                raise Subset("a slice other than [:] of one dimension")
            for i in iterate(range_(self.shape[0])):
                self[i] = x[i] if isinstance(x, Array) else x
            return
        index = index if isinstance(index, tuple) else (index,)
        if len(index) < len(self.shape):
            self[index][:] = x
            return
        place = self.place(index)
        if self.pairs:
            x = Complex.of(x)
            self._store(place, x.real)
            self._store(self._element(place, 1), x.imag)
        else:
            self._store(place, x)

    def _store(self, place: Value, x: Any) -> None:
        here().do(f"store {convert(x, self.kind).typed}, ptr {place}, align 8")


def new_array(shape: Any, kind: str = REAL, pairs: bool = False) -> Array:
    """An array on the stack, whose content is not set. It lives as long as the call of the emitted function."""
    shape = shape if isinstance(shape, tuple) else (shape,)
    f, parts = here(), 2 if pairs else 1
    if not is_symbolic(*shape):
        pointer = Value(POINTER, f.allocate(f"[{math.prod(shape) * parts} x {kind}]", 64))
        return Array(pointer, shape, kind, pairs)
    if f.depth:
        raise Subset("an array of a size that only the emitted code knows, in a branch or a loop")
    count = convert(math.prod(shape[1:], start=shape[0]) * parts, INTEGER)
    return Array(f.emit(POINTER, f"alloca {kind}, {count.typed}, align 64"), shape, kind, pairs)


# Variables -------------------------------------------------------------------------------------------------------------


class Slot:
    """The place of a variable that branches or loops assign."""

    __slots__ = ("kind", "place")

    def __init__(self, kind: str) -> None:
        self.kind, self.place = kind, here().allocate(kind, 64 if kind == VECTOR else 8)

    def store(self, x: Any) -> None:
        here().do(f"store {convert(x, self.kind).typed}, ptr {self.place}")

    def load(self) -> Value:
        return here().emit(self.kind, f"load {self.kind}, ptr {self.place}")


def make_slot(x: Any) -> Any:
    if isinstance(x, tuple):
        return tuple(make_slot(part) for part in x)
    if isinstance(x, Value | bool | int | float):
        return Slot(kind_of(x))
    return [x]


def store(slot: Any, x: Any) -> None:
    if isinstance(slot, Slot):
        slot.store(x)
    elif isinstance(slot, tuple):
        for part, value in zip(slot, x, strict=True):
            store(part, value)
    elif x is not slot[0]:
        if here().depth:
            raise Subset("something other than numbers is assigned in a branch or loop of the emitted code")
        slot[0] = x


def load(slot: Any) -> Any:
    if isinstance(slot, Slot):
        return slot.load()
    return tuple(load(part) for part in slot) if isinstance(slot, tuple) else slot[0]


class Frame:
    """The variables of a function that branches or loops assign: attributes, each in a slot of the kind it gets first."""

    _slots: dict[str, Any]

    def __init__(self) -> None:
        self.__dict__["_slots"] = {}

    def __setattr__(self, name: str, x: Any) -> None:
        slots = self._slots
        if name not in slots or (isinstance(x, tuple) and len(x) != len(slots[name])):
            slots[name] = make_slot(x)
        store(slots[name], x)

    def __getattr__(self, name: str) -> Any:
        if name not in self._slots:
            raise Subset(f"{name} is read where it may not have been assigned")
        return load(self._slots[name])


# Branches and loops ----------------------------------------------------------------------------------------------------


def branch(condition: Any) -> Iterator[bool]:
    """Yields True and then False where only the emitted code knows the condition: the bodies of both are emitted."""
    if not isinstance(condition, Value):
        yield bool(condition)
        return
    f = here()
    then, other, end = (f.name(hint) for hint in ("then", "else", "end"))
    f.do(f"br i1 {truth(condition)}, label %{then}, label %{other}")
    for label, is_then in ((then, True), (other, False)):
        f.at(label)
        f.depth += 1
        yield is_then
        f.depth -= 1
        f.go(end)
    f.at(end)


def truth(x: Value) -> Value:
    return x if x.kind == TRUTH else compare("ne", x, 0)


class Loop:
    """A loop: `check` leaves it, `leave` and `repeat` are break and continue."""

    def __init__(self) -> None:
        self.head, self.again, self.exit = (here().name(hint) for hint in ("head", "again", "exit"))

    def check(self, condition: Any) -> None:
        if not isinstance(condition, Value):
            if not condition:
                self.leave()
            return
        body = here().name("body")
        here().do(f"br i1 {truth(condition)}, label %{body}, label %{self.exit}")
        here().at(body)

    def leave(self) -> None:
        _jump(self.exit)

    def repeat(self) -> None:
        _jump(self.again)


def _jump(label: str) -> None:
    here().go(label)
    here().at(here().name("after"))  # unreachable: LLVM removes it


def loop() -> Iterator[Loop]:
    """The body of a `while`, emitted once."""
    labels, f = Loop(), here()
    f.go(labels.head)
    f.at(labels.head)
    f.depth += 1
    yield labels
    f.depth -= 1
    f.go(labels.again)
    f.at(labels.again)
    f.go(labels.head)
    f.at(labels.exit)


class SymbolicRange:
    """A range whose start, stop or step is symbolic. A symbolic step is positive."""

    def __init__(self, start: Any, stop: Any, step: Any) -> None:
        self.start, self.stop, self.step = start, stop, step

    def __iter__(self) -> Any:
        raise Subset("a loop over a range of unknown length, where Python runs it")


def range_(*bounds: Any) -> Any:
    if not is_symbolic(*bounds):
        return range(*bounds)
    start, stop, step = (0, bounds[0], 1) if len(bounds) == 1 else bounds if len(bounds) == 3 else (*bounds, 1)
    return SymbolicRange(start, stop, step)


def count_loop(indices: Any) -> Iterator[tuple[Loop, Any]]:
    """The body of a `for` over a range, emitted once: yields the loop and the index."""
    if not isinstance(indices, range | SymbolicRange):
        raise Subset("break or continue in a loop that is not over a range")
    start, stop, step = indices.start, indices.stop, indices.step
    place, labels, f = Slot(INTEGER), Loop(), here()
    place.store(start)
    f.go(labels.head)
    f.at(labels.head)
    f.depth += 1
    index = place.load()
    labels.check(compare("lt" if is_symbolic(step) or step > 0 else "gt", index, stop))
    yield labels, index
    f.depth -= 1
    f.go(labels.again)
    f.at(labels.again)
    place.store(place.load() + step)
    f.go(labels.head)
    f.at(labels.exit)


MOST_TURNS, MOST_COPIES = 32, 150
"""Most turns of a range that Python runs, and most copies of the body of an innermost loop; a larger range becomes a loop of
the emitted code. A hundred copies of an iteration took LLVM 15 s. With this limit Radau IIA 5 compiles in 0.8 s for 12
components instead of 3 s, and its steps are as fast."""


def iterate(values: Any, depth: int = 1) -> Iterator[Any]:
    """The body of a `for` without break, with `depth` loops in each other: emitted for each value, or once as a loop."""
    if isinstance(values, range):
        f, turns = here(), len(values)
        if turns <= MOST_TURNS and f.copies * turns**depth <= MOST_COPIES:
            f.copies, outside = f.copies * turns, f.copies
            yield from values
            f.copies = outside
            return
    if isinstance(values, range | SymbolicRange):
        for _, index in count_loop(values):
            yield index
    elif isinstance(values, Array):
        for i in iterate(range_(values.shape[0])):
            yield values[i]
    else:
        yield from values


class Exit:
    def __init__(self) -> None:
        self.label = here().name("return")

    def leave(self) -> None:
        _jump(self.label)


def leaving() -> Iterator[Exit]:
    """The body of a function that returns from within loops."""
    way_out = Exit()
    yield way_out
    here().go(way_out.label)
    here().at(way_out.label)


def either(a: Any, b: Callable[[], Any], conjunction: bool, guarded: bool) -> Any:
    """`a and b` or `a or b`. With `guarded` b is computed only where its value counts, as it may be costly or invalid."""
    if not isinstance(a, Value):
        return (b() if a else a) if conjunction else (a if a else b())
    a = truth(a)
    if not guarded:
        second = convert(b(), TRUTH)
        return a & second if conjunction else a | second
    place = Slot(TRUTH)
    place.store(a)
    for is_then in branch(a):
        if is_then == conjunction:
            place.store(b())
    return place.load()


def negate(a: Any) -> Any:
    return truth(a) ^ True if isinstance(a, Value) else not a


def choose(condition: Any, a: Callable[[], Any], b: Callable[[], Any], guarded: bool) -> Any:
    """`a() if condition else b()`."""
    if not isinstance(condition, Value):
        return a() if condition else b()
    if not guarded:
        return select(truth(condition), a(), b())
    frame = Frame()
    for is_then in branch(condition):
        frame.value = (a if is_then else b)()
    return frame.value


# Functions of their own ------------------------------------------------------------------------------------------------


def flatten(x: Any, values: list[Value]) -> Any:
    """Take apart an argument or result: append its symbolic values to `values`, and return its structure, which is hashable.

    `rebuild` puts it together again.
    """
    if isinstance(x, tuple):
        return ("tuple", type(x), *(flatten(part, values) for part in x))
    if isinstance(x, Value):
        values.append(x)
        return ("value", x.kind)
    if isinstance(x, Complex):
        return ("complex", flatten(x.real, values), flatten(x.imag, values))
    if isinstance(x, Array):
        values.append(x.pointer)
        return ("array", x.kind, x.pairs, tuple(flatten(size, values) for size in x.shape))
    if hasattr(x, "parts"):
        keys, held = x.parts()
        return ("parts", type(x), keys, flatten(held, values))
    return ("known", type(x), x)


def rebuild(structure: Any, values: Iterator[Value]) -> Any:
    """The argument or result of this structure with these symbolic values, as `flatten` found them."""
    match structure:
        case "tuple", kind, *parts:
            whole = [rebuild(part, values) for part in parts]
            return kind(*whole) if hasattr(kind, "_fields") else tuple(whole)
        case "value", _:
            return next(values)
        case "complex", real, imag:
            return Complex(rebuild(real, values), rebuild(imag, values))
        case "array", kind, pairs, sizes:
            return Array(next(values), tuple(rebuild(size, values) for size in sizes), kind, pairs)
        case "parts", holder, keys, held:
            return holder.again(keys, rebuild(held, values))
    return structure[2]


class Outlined:
    """A function as a function of the emitted code, one for each structure of its arguments."""

    def __init__(self, function: Callable[..., Any], attributes: str = ATTRIBUTES) -> None:
        self.function, self.attributes, self.__name__ = function, attributes, function.__name__

    def __call__(self, *arguments: Any) -> Any:
        operands: list[Value] = []
        structure = flatten(arguments, operands)
        outlined, key = module().outlined, (self, structure)
        if key not in outlined:
            outlined[key] = self._emitted(len(outlined), structure, operands)
        name, result, returned, kinds, used = outlined[key]
        call_ = f"call {result} @{name}({', '.join(operands[n].typed for n in used)})"
        if result == "void":
            here().do(call_)
            return rebuild(returned, iter(()))
        whole = here().emit(result, call_)
        if len(kinds) == 1:
            return rebuild(returned, iter([Value(kinds[0], whole.text)]))
        parts = (here().emit(kind, f"extractvalue {result} {whole}, {n}") for n, kind in enumerate(kinds))
        return rebuild(returned, iter(list(parts)))

    def _emitted(
        self, number: int, structure: Any, operands: Sequence[Value]
    ) -> tuple[str, str, Any, list[str], list[int]]:
        """The name, the result, its structure and kinds, and the arguments that the function uses: records bring others."""
        name = f"{self.__name__}.{number}"
        names = [Value(x.kind, f"%a{n}") for n, x in enumerate(operands)]
        with Function("", self.attributes) as f:
            results: list[Value] = []
            returned = flatten(self.function(*rebuild(structure, iter(names))), results)
            kinds = [x.kind for x in results]
            if not kinds:
                f.do("ret void")
            elif len(kinds) == 1:
                f.result = kinds[0]
                f.do(f"ret {results[0].typed}")
            else:
                f.result = f"{{{', '.join(kinds)}}}"
                whole = Value(f.result, "poison")
                for n, x in enumerate(results):
                    whole = f.emit(f.result, f"insertvalue {whole.typed}, {x.typed}, {n}")
                f.do(f"ret {whole.typed}")
        read = set(re.findall(r"%a\d+\b", "\n".join((*f.allocations, *f.lines))))
        used = [n for n, x in enumerate(names) if x.text in read]
        f.head = f"internal {{result}} @{name}({', '.join(names[n].typed for n in used)})"
        return name, f.result, returned, kinds, used

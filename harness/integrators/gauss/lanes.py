"""Eight doubles in one vector, the lanes: arrays of NumPy, or `<8 x double>` in emitted code.

Each operation has two forms: the function that is written first computes with arrays (8,) of NumPy, and the function
below it emits what LLVM splits into the registers of the processor (one with AVX-512, two with AVX2). In emitted code
LLVM may contract a product and a sum into one rounding, but rearranges nothing else; methods use `fma` and `minus` where
the rounding matters. Processors can differ in the sums that are contracted, and so in the last bits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
from gnomon.harness.integrators.gauss.constants import SCRATCH, SCRATCH_ROWS
from gnomon.harness.kernels import emission, ir
from gnomon.harness.kernels.emission import primitive
from gnomon.harness.kernels.ir import INTEGER, POINTER, REAL, TRUTH, VECTOR, convert, exact, here
from numpy.typing import NDArray

Lanes = NDArray[np.float64]
"""Eight numbers, (8,)."""
Table = NDArray[np.float64]
"""Rows of eight numbers, (rows, 8)."""

WIDTH = ir.LANES
INTEGERS, TRUTHS = "<8 x i64>", "<8 x i1>"
SHUFFLED = 2
"""The number of a vector's elements that `products` shuffles instead of reading them from memory: found by timing."""
SPLITTER = 134217729.0
"""2^27 + 1: a product with it splits a double into two halves whose products are exact (Dekker, 1971)."""


def _emit(kind: str, operation: str, *given: Any) -> Any:
    return here().emit(kind, operation.format(*given))


def _vectors(*given: Any) -> list[Any]:
    """The arguments as vectors of the emitted code: a number fills all lanes."""
    return [convert(x, VECTOR) for x in given]


# Numbers and lanes -----------------------------------------------------------------------------------------------------


def lanes(x: float | Lanes) -> Lanes:
    """A number in every lane; lanes stay as they are."""
    return x if isinstance(x, np.ndarray) else np.full(WIDTH, x)


@primitive(lanes)
def _(x: Any) -> Any:
    return convert(x, VECTOR)


def lane(a: Lanes, index: int) -> float:
    """The number in one lane."""
    return float(a[index])


@primitive(lane)
def _(a: Any, index: Any) -> Any:
    return _emit(REAL, "extractelement {}, i64 {}", a.typed, convert(index, INTEGER))


def with_lane(a: Lanes, index: int, x: float) -> Lanes:
    """The lanes with one of them replaced."""
    changed = a.copy()
    changed[index] = x
    return changed


@primitive(with_lane)
def _(a: Any, index: Any, x: Any) -> Any:
    return _emit(
        VECTOR,
        "insertelement {}, {}, i64 {}",
        convert(a, VECTOR).typed,
        convert(x, REAL).typed,
        convert(index, INTEGER),
    )


# Arithmetic ------------------------------------------------------------------------------------------------------------


def fma(a: Lanes, b: Lanes, c: Lanes) -> Lanes:
    """a * b + c, rounded once (here twice in rare cases)."""
    product = a * b
    (a_high, a_low), (b_high, b_low) = _halves(a), _halves(b)
    rest = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    rounded = product + c
    part = rounded - product
    whole: Lanes = rounded + (((product - (rounded - part)) + (c - part)) + rest)
    return whole


def _halves(x: Any) -> tuple[Any, Any]:
    """(high, low): x as the exact sum of two halves, see SPLITTER."""
    high = SPLITTER * x - (SPLITTER * x - x)
    return high, x - high


@primitive(fma)
def _(a: Any, b: Any, c: Any) -> Any:
    return ir.call("llvm.fma.v8f64", VECTOR, *_vectors(a, b, c))


def fuse(a: float, b: float, c: float) -> float:
    """a * b + c of numbers, rounded once."""
    return float(fma(np.float64(a), np.float64(b), np.float64(c)))  # type: ignore[arg-type]


@primitive(fuse)
def _(a: Any, b: Any, c: Any) -> Any:
    return ir.call("llvm.fma.f64", REAL, *(convert(x, REAL) for x in (a, b, c)))


def minus(a: Any, b: Any) -> Any:
    """a - b, never contracted: for differences that are exact or recover a rounding."""
    return a - b


@primitive(minus)
def _(a: Any, b: Any) -> Any:
    return exact("sub", a, b)


def over(a: Lanes, b: Lanes, c: Lanes) -> Lanes:
    """a / b, given c = 1 / b: rounded once, like the division (Markstein, IBM Journal 34, 1990), in a third of its time."""
    return a / b


@primitive(over)
def _(a: Any, b: Any, c: Any) -> Any:
    a, b, c = _vectors(a, b, c)
    rounded = exact("mul", a, c)
    negative = _emit(VECTOR, "fneg {}", rounded.typed)
    left = ir.call("llvm.fma.v8f64", VECTOR, negative, b, a)
    return ir.call("llvm.fma.v8f64", VECTOR, left, c, rounded)


def root(a: Lanes) -> Lanes:
    """Square roots."""
    root: Lanes = np.sqrt(a)
    return root


@primitive(root)
def _(a: Any) -> Any:
    return ir.call("llvm.sqrt.v8f64", VECTOR, convert(a, VECTOR))


def larger(a: Lanes, b: Lanes) -> Lanes:
    """The larger of two values in each lane; a nan in `a` stays."""
    return np.where(~(a <= b), a, b)


@primitive(larger)
def _(a: Any, b: Any) -> Any:
    a, b = _vectors(a, b)
    above = _emit(TRUTHS, "fcmp ugt {}, {}", a.typed, b)
    return _select(above, a, b)


def _select(condition: Any, a: Any, b: Any) -> Any:
    return _emit(VECTOR, "select {}, {}, {}", condition.typed, a.typed, b.typed)


def are_within(a: Lanes, limit: float) -> bool:
    """Whether every lane is at most the limit; nan is not."""
    return bool(np.all(a <= limit))


@primitive(are_within)
def _(a: Any, limit: Any) -> Any:
    each = _emit(TRUTHS, "fcmp ole {}, {}", a.typed, convert(limit, VECTOR))
    return _emit(TRUTH, "icmp eq i8 {}, -1", _emit("i8", "bitcast {} to i8", each.typed))


# Sums over lanes -------------------------------------------------------------------------------------------------------


def _turn(a: Any, half: int) -> Any:
    return _shuffle(a, a, [(i + half) % WIDTH for i in range(WIDTH)])


def _shuffle(a: Any, b: Any, order: Sequence[int]) -> Any:
    mask = ", ".join(f"i32 {i}" for i in order)
    return _emit(VECTOR, "shufflevector {}, {}, <8 x i32> <{}>", a.typed, b.typed, mask)


def total(a: Lanes) -> float:
    """The sum of the lanes, in pairs, always in the same sequence."""
    for half in (4, 2, 1):
        a = a + np.roll(a, -half)
    return float(a[0])


@primitive(total)
def _(a: Any) -> Any:
    for half in (4, 2, 1):
        a = exact("add", a, _turn(a, half))
    return _emit(REAL, "extractelement {}, i64 0", a.typed)


def totals(a: Lanes, b: Lanes, c: Lanes, d: Lanes) -> Lanes:
    """The sums of the lanes of four vectors, in lanes 0 to 3 and again in 4 to 7: half the operations of 4 totals."""
    sums = [((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7])) for x in (a, b, c, d)]
    return np.array([*sums, *sums])


@primitive(totals)
def _(a: Any, b: Any, c: Any, d: Any) -> Any:
    def folded(a: Any, b: Any, first: list[int], second: list[int]) -> Any:
        return exact("add", _shuffle(a, b, first), _shuffle(a, b, second))

    evens, odds = [0, 8, 2, 10, 4, 12, 6, 14], [1, 9, 3, 11, 5, 13, 7, 15]
    halves = folded(
        folded(a, b, evens, odds), folded(c, d, evens, odds), [0, 1, 8, 9, 4, 5, 12, 13], [2, 3, 10, 11, 6, 7, 14, 15]
    )
    return exact("add", halves, _turn(halves, 4))


def highest(a: Lanes) -> float:
    """The largest lane; nan if any lane is nan."""
    return float(np.max(a))


@primitive(highest)
def _(a: Any) -> Any:
    for half in (4, 2, 1):
        b = _turn(a, half)
        unordered = _emit(TRUTHS, "fcmp uno {}, {}", b.typed, b)
        above = _emit(TRUTHS, "fcmp ogt {}, {}", b.typed, a)
        a = _select(_emit(TRUTHS, "or {}, {}", unordered.typed, above), b, a)
    return _emit(REAL, "extractelement {}, i64 0", a.typed)


# Rows of a table -------------------------------------------------------------------------------------------------------


def row(table: Table, index: int) -> Lanes:
    """A row of a table."""
    vector: Lanes = table[index].copy()
    return vector


@primitive(row)
def _(table: Any, index: Any) -> Any:
    return _emit(VECTOR, "load <8 x double>, ptr {}, align 8", _place(table, index))


def _place(table: Any, index: Any) -> Any:
    return _emit(POINTER, "getelementptr <8 x double>, ptr {}, i64 {}", table.pointer, convert(index, INTEGER))


def put(table: Table, index: int, a: Lanes) -> None:
    """Write a row of a table."""
    table[index] = a


@primitive(put)
def _(table: Any, index: Any, a: Any) -> None:
    here().do(f"store {convert(a, VECTOR).typed}, ptr {_place(table, index)}, align 8")


def products(table: Table, first: int, vectors: tuple[Lanes, ...]) -> tuple[Lanes, ...]:
    """The matrix whose columns are the eight rows of a table from `first` on, times each of the vectors."""
    return tuple(_product(table[first : first + WIDTH], vector, _chains(len(vectors))) for vector in vectors)


def _chains(count: int) -> int:
    """The number of independent sums of each of `count` vectors: with few vectors several, which reduces the latency."""
    return 4 if count == 1 else 2 if count < 6 else 1


def _product(columns: Table, vector: Lanes, chains: int) -> Lanes:
    sums: list[Lanes] = [columns[k] * vector[k] for k in range(chains)]
    for k in range(chains, WIDTH):
        sums[k % chains] = fma(columns[k], np.full(WIDTH, vector[k]), sums[k % chains])
    while len(sums) > 1:
        sums = [a + b for a, b in zip(sums[::2], sums[1::2], strict=True)]
    return sums[0]


@primitive(products)
def _(table: Any, first: Any, vectors: Any) -> Any:
    """Elements are broadcast from memory: this takes no shuffles, and each column is loaded once for all vectors.

    With one or two vectors the first elements are shuffled while the stores complete. The vectors are stored in the
    table, in `SCRATCH_ROWS` rows from `SCRATCH` on.
    """
    if len(vectors) > SCRATCH_ROWS:
        raise ir.Subset(f"products of {len(vectors)} vectors, of which the table has room for {SCRATCH_ROWS}")
    chains = _chains(len(vectors))
    starts = [_hidden(_place(table, SCRATCH + i), vector) for i, vector in enumerate(vectors)]
    sums: list[list[Any]] = [[] for _ in vectors]
    for k in range(WIDTH):
        column = _emit(VECTOR, "load <8 x double>, ptr {}, align 8", _place(table, first + k))
        for vector, start, terms in zip(vectors, starts, sums, strict=True):
            if k < SHUFFLED and len(vectors) < 3:
                element = _shuffle(vector, vector, [k] * WIDTH)
            else:
                place = _emit(POINTER, "getelementptr double, ptr {}, i64 {}", start, k)
                element = convert(_emit(REAL, "load double, ptr {}, align 8", place), VECTOR)
            if k < chains:
                terms.append(exact("mul", column, element))
            else:
                terms[k % chains] = ir.call("llvm.fma.v8f64", VECTOR, column, element, terms[k % chains])
    while len(sums[0]) > 1:
        sums = [[exact("add", a, b) for a, b in zip(x[::2], x[1::2], strict=True)] for x in sums]
    return tuple(x[0] for x in sums)


def _hidden(place: Any, vector: Any) -> Any:
    """The address of a vector in memory, hidden from LLVM, which would use shuffles instead."""
    here().do(f"store {vector.typed}, ptr {place}, align 8")
    return _emit(POINTER, 'call ptr asm "", "=r,0"(ptr {})', place)


# Bits ------------------------------------------------------------------------------------------------------------------


def bits(x: float) -> int:
    """The bits of a number, read as an integer."""
    return int(np.float64(x).view(np.int64))


@primitive(bits)
def _(x: Any) -> Any:
    return _emit(INTEGER, "bitcast {} to i64", convert(x, REAL).typed)


def double(n: int) -> float:
    """The number with these bits."""
    return float(np.int64(n).view(np.float64))


@primitive(double)
def _(n: Any) -> Any:
    return _emit(REAL, "bitcast {} to double", convert(n, INTEGER).typed)


def choose(counter: Lanes, even: Lanes, odd: Lanes) -> Lanes:
    """`even` or `odd` according to the lowest bit of the counter, with the sign reversed if the next bit is set."""
    which = counter.view(np.int64)
    turned: Lanes = (np.where(which & 1, odd, even).view(np.int64) ^ ((which & 2) << 62)).view(np.float64)
    return turned


@primitive(choose)
def _(counter: Any, even: Any, odd: Any) -> Any:
    which = _as_integers(counter)
    lowest = _emit(INTEGERS, "and {}, splat (i64 1)", which.typed)
    chosen = _select(_emit(TRUTHS, "icmp ne {}, zeroinitializer", lowest.typed), odd, even)
    next_bit = _emit(INTEGERS, "and {}, splat (i64 2)", which.typed)
    sign = _emit(INTEGERS, "shl {}, splat (i64 62)", next_bit.typed)
    return _as_doubles(_emit(INTEGERS, "xor {}, {}", _as_integers(chosen).typed, sign))


def _as_integers(a: Any) -> Any:
    return _emit(INTEGERS, "bitcast {} to <8 x i64>", a.typed)


def _as_doubles(a: Any) -> Any:
    return _emit(VECTOR, "bitcast {} to <8 x double>", a.typed)


def scale(counter: Lanes, a: Lanes) -> Lanes:
    """a * 2^n for results that are normal numbers; n stands in the lowest bits of the counter."""
    scaled: Lanes = (a.view(np.int64) + (counter.view(np.int64) << 52)).view(np.float64)
    return scaled


@primitive(scale)
def _(counter: Any, a: Any) -> Any:
    exponent = _emit(INTEGERS, "shl {}, splat (i64 52)", _as_integers(counter).typed)
    return _as_doubles(_emit(INTEGERS, "add {}, {}", _as_integers(a).typed, exponent))


# Functions of numbers --------------------------------------------------------------------------------------------------


def each(name: str, *given: Any) -> Any:
    """A function of `math` on every lane of its arguments, which may be numbers; nan outside its domain."""

    def compute(*numbers: float) -> float:
        try:
            return float(getattr(math, name)(*numbers))
        except (ValueError, OverflowError):
            return math.nan

    return np.array([compute(*numbers) for numbers in zip(*map(lanes, given), strict=True)])


@primitive(each)
def _(name: str, *given: Any) -> Any:
    return _each(name)(*_vectors(*given))


@cache
def _each(name: str) -> Callable[..., Any]:
    def lane_by_lane(*given: Any) -> Any:
        values = given[0]
        for i in range(WIDTH):
            numbers = [_emit(REAL, "extractelement {}, i64 {}", x.typed, i) for x in given]
            values = _emit(VECTOR, "insertelement {}, {}, i64 {}", values.typed, emission.MATH[name](*numbers).typed, i)
        return values

    lane_by_lane.__name__ = f"{name}_of_each_lane"
    return ir.Outlined(lane_by_lane, f"{ir.ATTRIBUTES} noinline cold")


def power(a: Any, exponent: Any) -> Any:
    """a^exponent of lanes or numbers: by repeated squaring for an integer."""
    if not isinstance(exponent, int):
        return each("pow", a, exponent)
    product, square, left = lanes(1.0), a, abs(exponent)
    while left > 0:
        product, square, left = product * square if left & 1 else product, square * square, left >> 1
    return 1.0 / product if exponent < 0 else product


@primitive(power)
def _(a: Any, exponent: Any) -> Any:
    return a**exponent if isinstance(exponent, int) else _each("pow")(*_vectors(a, exponent))

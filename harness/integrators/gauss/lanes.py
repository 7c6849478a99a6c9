"""Eight doubles in one vector, as a type that numba compiles: `<8 x double>`, with operators.

LLVM splits the vector into the registers of the processor (one with AVX-512, two with AVX2). Numbers convert to a
vector of equal lanes. LLVM may contract a product and a sum into one rounding, but rearranges nothing else; the code
uses `fma` if the rounding matters. Processors can differ in the sums that are contracted, and so in the last bits. Only
generated modules import this module, as it loads numba.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from gnomon.harness.integrators.gauss.gauss_fast_constants import SCRATCH, SCRATCH_ROWS
from llvmlite import ir
from numba import types
from numba.core import cgutils, typing
from numba.core.errors import TypingError
from numba.core.typeconv import Conversion
from numba.extending import intrinsic, lower_builtin, lower_cast, models, register_model

WIDTH = 8
DOUBLES = ir.VectorType(ir.DoubleType(), WIDTH)
INTEGERS = ir.VectorType(ir.IntType(64), WIDTH)
TABLE = types.float64[:, ::1]

SHUFFLED = 2
"""The number of a vector's elements that `products` shuffles instead of reading them from memory: found by timing."""


class LanesType(types.Type):  # type: ignore[misc]  # numba has no static types
    """The type of eight doubles."""

    def __init__(self) -> None:
        super().__init__(name="Lanes8")

    def can_convert_from(self, context: Any, other: Any) -> Any:
        return Conversion.safe if isinstance(other, types.Number) else None


LANES = LanesType()


@register_model(LanesType)
class LanesModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: LanesType) -> None:
        super().__init__(manager, kind, DOUBLES)


def vector(values: list[float]) -> Any:
    return ir.Constant(DOUBLES, [ir.Constant(ir.DoubleType(), value) for value in values])


def spread(builder: Any, value: Any) -> Any:
    """A double in every lane."""
    first = builder.insert_element(ir.Constant(DOUBLES, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
    return shuffled(builder, first, [0] * WIDTH)


def shuffled(builder: Any, value: Any, order: list[int]) -> Any:
    mask = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), order)
    return builder.shuffle_vector(value, ir.Constant(DOUBLES, ir.Undefined), mask)


def llvm(builder: Any, name: str, *values: Any) -> Any:
    """An LLVM intrinsic on whole vectors."""
    kind = ir.FunctionType(DOUBLES, [DOUBLES] * len(values))
    function = builder.module.globals.get(f"llvm.{name}.v8f64")
    function = function or ir.Function(builder.module, kind, f"llvm.{name}.v8f64")
    return builder.call(function, values)


@lower_cast(types.Number, LanesType)
def number_to_lanes(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    return spread(builder, context.cast(builder, value, source, types.float64))


def _operator(function: Callable[..., Any], arguments: int, emit: Callable[..., Any]) -> None:
    class Template(typing.templates.ConcreteTemplate):  # type: ignore[misc]
        cases = [typing.signature(LANES, *[LANES] * arguments)]  # noqa: RUF012

    typing.templates.infer_global(function)(Template)

    @lower_builtin(function, *[LANES] * arguments)
    def lower(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return emit(builder, *values)


for _function in (operator.add, operator.iadd):
    _operator(_function, 2, lambda builder, a, b: builder.fadd(a, b, flags=("contract",)))
for _function in (operator.sub, operator.isub):
    _operator(_function, 2, lambda builder, a, b: builder.fsub(a, b, flags=("contract",)))
for _function in (operator.mul, operator.imul):
    _operator(_function, 2, lambda builder, a, b: builder.fmul(a, b, flags=("contract",)))
for _function in (operator.truediv, operator.itruediv):
    _operator(_function, 2, lambda builder, a, b: builder.fdiv(a, b))
_operator(operator.neg, 1, lambda builder, a: builder.fneg(a))
_operator(operator.pos, 1, lambda builder, a: a)


def emitting(arguments: int, emit: Callable[..., Any], kind: Any = LANES) -> Any:
    """An intrinsic of `arguments` vectors, emitted by `emit(builder, *vectors)`."""

    def typed(*given: Any) -> Any:
        return kind(*[LANES] * arguments), lambda context, builder, signature, values: emit(builder, *values)

    # The number of arguments is part of an intrinsic's own signature.
    if arguments == 1:
        return intrinsic(lambda typingctx, a: typed(a))
    if arguments == 2:
        return intrinsic(lambda typingctx, a, b: typed(a, b))
    if arguments == 3:
        return intrinsic(lambda typingctx, a, b, c: typed(a, b, c))
    return intrinsic(lambda typingctx, a, b, c, d: typed(a, b, c, d))


fma = emitting(3, lambda builder, a, b, c: llvm(builder, "fma", a, b, c))
"""a * b + c, rounded once."""

minus = emitting(2, lambda builder, a, b: builder.fsub(a, b))
"""a - b, never contracted: for differences that are exact or recover a rounding."""


def _over(builder: Any, a: Any, b: Any, c: Any) -> Any:
    found = builder.fmul(a, c)
    left = llvm(builder, "fma", builder.fneg(found), b, a)
    return llvm(builder, "fma", left, c, found)


over = emitting(3, _over)
"""a / b, given c = 1 / b: rounded once, like the division (Markstein, IBM Journal 34, 1990), in a third of its time."""

root = emitting(1, lambda builder, a: llvm(builder, "sqrt", a))
size = emitting(1, lambda builder, a: llvm(builder, "fabs", a))


def _total(builder: Any, a: Any) -> Any:
    """The sum of the lanes, in pairs, always in the same sequence."""
    for half in (4, 2, 1):
        a = builder.fadd(a, shuffled(builder, a, [(i + half) % WIDTH for i in range(WIDTH)]))
    return builder.extract_element(a, ir.Constant(ir.IntType(32), 0))


total = emitting(1, _total, types.float64)


def _totals(builder: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    """The sums of the lanes of four vectors, in lanes 0 to 3 and again in 4 to 7: half the operations of 4 totals."""

    def folded(a: Any, b: Any, first: list[int], second: list[int]) -> Any:
        masks = [ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), order) for order in (first, second)]
        return builder.fadd(*[builder.shuffle_vector(a, b, mask) for mask in masks])

    evens, odds = [0, 8, 2, 10, 4, 12, 6, 14], [1, 9, 3, 11, 5, 13, 7, 15]
    ab, cd = folded(a, b, evens, odds), folded(c, d, evens, odds)
    halves = folded(ab, cd, [0, 1, 8, 9, 4, 5, 12, 13], [2, 3, 10, 11, 6, 7, 14, 15])
    return builder.fadd(halves, shuffled(builder, halves, [4, 5, 6, 7, 0, 1, 2, 3]))


totals = emitting(4, _totals)

larger = emitting(2, lambda builder, a, b: builder.select(builder.fcmp_unordered(">", a, b), a, b))
"""The larger of two values in each lane; a nan in `a` stays."""


def _highest(builder: Any, a: Any) -> Any:
    """The largest lane; nan if any lane is nan."""
    for half in (4, 2, 1):
        b = shuffled(builder, a, [(i + half) % WIDTH for i in range(WIDTH)])
        unordered = builder.fcmp_unordered("uno", b, b)
        a = builder.select(builder.or_(unordered, builder.fcmp_ordered(">", b, a)), b, a)
    return builder.extract_element(a, ir.Constant(ir.IntType(32), 0))


highest = emitting(1, _highest, types.float64)


@intrinsic
def lanes(typingctx: Any, value: Any) -> Any:
    """A vector with a number in every lane; a vector is returned as it is."""
    source = value if isinstance(value, LanesType) else types.float64

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return values[0] if source is LANES else spread(builder, values[0])

    return LANES(LANES if isinstance(value, LanesType) else types.float64), generate


@intrinsic
def lane(typingctx: Any, a: Any, index: Any) -> Any:
    """The number in one lane."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.extract_element(values[0], builder.trunc(values[1], ir.IntType(32)))

    return types.float64(LANES, types.int64), generate


@intrinsic
def with_lane(typingctx: Any, a: Any, index: Any, value: Any) -> Any:
    """The vector with one lane replaced."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.insert_element(values[0], values[2], builder.trunc(values[1], ir.IntType(32)))

    return LANES(LANES, types.int64, types.float64), generate


def _row_pointer(context: Any, builder: Any, table: Any, index: Any) -> Any:
    data = context.make_array(TABLE)(context, builder, table).data
    pointer = builder.gep(data, [builder.mul(index, ir.Constant(ir.IntType(64), WIDTH))])
    return builder.bitcast(pointer, ir.PointerType(DOUBLES))


def _row(context: Any, builder: Any, table: Any, index: Any) -> Any:
    """Eight doubles of a table (rows, 8)."""
    return builder.load(_row_pointer(context, builder, table, index), align=8)


@intrinsic
def row(typingctx: Any, table: Any, index: Any) -> Any:
    """Row `index` of a table (rows, 8)."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return _row(context, builder, *values)

    return LANES(TABLE, types.int64), generate


@intrinsic
def put(typingctx: Any, table: Any, index: Any, value: Any) -> Any:
    """Write a row of a table (rows, 8)."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        table, index, value = values
        builder.store(value, _row_pointer(context, builder, table, index), align=8)
        return context.get_dummy_value()

    return types.none(TABLE, types.int64, LANES), generate


@intrinsic
def products(typingctx: Any, table: Any, first: Any, vectors: Any) -> Any:
    """The matrix whose columns are the eight rows of the table from `first` on, times each vector of a tuple.

    Elements are broadcast from memory: this takes no shuffles, and each column is loaded once for all vectors. With one
    or two vectors the first elements are shuffled while the stores complete. The vectors are stored in the table, in
    `SCRATCH_ROWS` rows from `SCRATCH` on.
    """
    if len(vectors) > SCRATCH_ROWS:
        raise TypingError(f"products of {len(vectors)} vectors, of which the table has room for {SCRATCH_ROWS}")
    # With few vectors each has several independent sums, which reduces the latency.
    chains = 4 if len(vectors) == 1 else 2 if len(vectors) < 6 else 1

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        table, first, vectors = values
        whole = cgutils.unpack_tuple(builder, vectors)
        rows = [ir.Constant(ir.IntType(64), SCRATCH + i) for i in range(len(whole))]
        places = [_row_pointer(context, builder, table, index) for index in rows]
        starts = [_elements(builder, place, vector) for place, vector in zip(places, whole, strict=True)]
        sums: list[list[Any]] = [[] for _ in starts]
        for k in range(WIDTH):
            column = _row(context, builder, table, builder.add(first, ir.Constant(ir.IntType(64), k)))
            for vector, start, found in zip(whole, starts, sums, strict=True):
                if k < SHUFFLED and len(whole) < 3:
                    element = shuffled(builder, vector, [k] * WIDTH)
                else:
                    element = spread(builder, builder.load(builder.gep(start, [ir.Constant(ir.IntType(64), k)])))
                if k < chains:
                    found.append(builder.fmul(column, element))
                else:
                    found[k % chains] = llvm(builder, "fma", column, element, found[k % chains])
        while len(sums[0]) > 1:
            sums = [[builder.fadd(a, b) for a, b in zip(found[::2], found[1::2], strict=True)] for found in sums]
        results = [found[0] for found in sums]
        return context.make_tuple(builder, signature.return_type, results)

    return types.UniTuple(LANES, len(vectors))(TABLE, types.int64, vectors), generate


def _elements(builder: Any, place: Any, vector: Any) -> Any:
    """The address of a vector's elements in memory, hidden from the compiler, which would use shuffles instead."""
    builder.store(vector, place, align=8)
    kind = ir.FunctionType(place.type, [place.type])
    hidden = builder.asm(kind, "", "=r,0", [place], False)
    return builder.bitcast(hidden, ir.PointerType(ir.DoubleType()))

"""Functions that every step of the fast Gauss method calls: bits of numbers, powers, sums with residuals."""

from __future__ import annotations

from typing import Any

from gnomon.harness.integrators.gauss.gauss_fast_constants import HIGHEST, LOW
from gnomon.harness.integrators.gauss.lanes import fma, lane, lanes, minus, row, total, totals, with_lane
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

INNER = {"error_model": "numpy", "fastmath": {"contract"}, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
ONE = 0x3FF0000000000000
"""The bits of 1.0."""


@intrinsic
def bits(typingctx: Any, x: Any) -> Any:
    return types.int64(types.float64), lambda c, builder, s, values: builder.bitcast(values[0], ir.IntType(64))


@intrinsic
def double(typingctx: Any, n: Any) -> Any:
    return types.float64(types.int64), lambda c, builder, s, values: builder.bitcast(values[0], ir.DoubleType())


@intrinsic
def fused(typingctx: Any, a: Any, b: Any, c: Any) -> Any:
    """a * b + c of numbers, rounded once."""
    number = types.float64
    return number(number, number, number), lambda x, builder, s, values: builder.fma(*values)


@njit(**INNER)  # type: ignore[misc]
def few_bits(h):  # type: ignore[no-untyped-def]
    """The step rounded to so few bits that its square and its products with the high parts of the nodes are exact."""
    return double(bits(h) & -(1 << 27))


@njit(**INNER)  # type: ignore[misc]
def root_15(x):  # type: ignore[no-untyped-def]
    """x^(1/15) within 1 %: the bits of a double, read as an integer, are nearly its logarithm."""
    return double(ONE + (bits(x) - ONE) // 15)


@njit(**INNER)  # type: ignore[misc]
def powers(r):  # type: ignore[no-untyped-def]
    """1, r, ..., r^7."""
    r2, v = r * r, lanes(1.0)
    r4 = r2 * r2
    v = with_lane(with_lane(with_lane(v, 1, r), 2, r2), 3, r2 * r)
    return with_lane(with_lane(with_lane(with_lane(v, 4, r4), 5, r4 * r), 6, r4 * r2), 7, r4 * r2 * r)


@njit(**INNER)  # type: ignore[misc]
def at(m, x):  # type: ignore[no-untyped-def]
    """The value at x of the polynomial with the coefficients m."""
    v = lanes(lane(m, 7))
    for k in range(6, -1, -1):
        v = fma(v, x, lanes(lane(m, k)))
    return v


@njit(forceinline=True, **INNER)  # type: ignore[misc]
def weighted(f, table, weights):  # type: ignore[no-untyped-def]
    """Slopes times weights, with the rounding residuals of the weights."""
    return fma(f, row(table, weights), f * row(table, weights + LOW))


@njit(forceinline=True, **INNER)  # type: ignore[misc]
def weighted_exactly(f, splitter, table, weights):  # type: ignore[no-untyped-def]
    """The sum of slopes times weights in two parts.

    Adding and subtracting the much larger splitter leaves so few bits of each lane that the sum of the lanes is exact.
    """
    w = row(table, weights)
    parts = f * w
    high = minus(parts + lanes(splitter), lanes(splitter))
    return total(high), total(minus(parts, high) + fma(f, row(table, weights + LOW), fma(f, w, -parts)))


@njit(forceinline=True, **INNER)  # type: ignore[misc]
def summed(y, change):  # type: ignore[no-untyped-def]
    """The sum of two numbers or lanes, and its rounding residual."""
    end = y + change
    back = end - y
    return end, (y - (end - back)) + (change - back)


@njit(forceinline=True, **INNER)  # type: ignore[misc]
def added(y, compensation, h, rate):  # type: ignore[no-untyped-def]
    """y + compensation + h * rate, and its rounding residual."""
    change = fused(h, rate, compensation)
    end, residual = summed(y, change)
    return end, residual + (fused(h, rate, -change) + compensation)


@njit(forceinline=True, **INNER)  # type: ignore[misc]
def legendre_of_one(f, table):  # type: ignore[no-untyped-def]
    """The Legendre coefficients 4 to 7 of one slope in their lanes."""
    return totals(
        f * row(table, HIGHEST), f * row(table, HIGHEST + 1), f * row(table, HIGHEST + 2), f * row(table, HIGHEST + 3)
    )

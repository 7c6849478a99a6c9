"""Numbers of 106 bits as unevaluated sums of two doubles, compiled. No fast-math: it would cancel the error terms.

After a change here, touch the files whose kernels numba caches: it watches only the file of the kernel itself.
Dekker, Numerische Mathematik 18 (1971); Hida, Li and Bailey, ARITH-15 (2001). Relative errors are below 2**-104.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit, types
from numba.extending import intrinsic


@intrinsic  # type: ignore[untyped-decorator]
def fma(typing_context: Any, x: Any, y: Any, z: Any) -> tuple[Any, Callable[..., Any]]:
    """x*y + z with one rounding."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), code


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def two_sum(a: float, b: float) -> tuple[float, float]:
    """a + b, exactly."""
    s = a + b
    t = s - a
    return s, (a - (s - t)) + (b - t)


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def quick_two_sum(a: float, b: float) -> tuple[float, float]:
    """a + b, exactly, for |a| >= |b|."""
    s = a + b
    return s, b - (s - a)


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def two_product(a: float, b: float) -> tuple[float, float]:
    """a * b, exactly."""
    p = a * b
    return p, fma(a, b, -p)


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def add(a: float, a_low: float, b: float, b_low: float) -> tuple[float, float]:
    s, e = two_sum(a, b)
    t, f = two_sum(a_low, b_low)
    s, e = quick_two_sum(s, e + t)
    s, e = quick_two_sum(s, e + f)
    return s, e


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def multiply(a: float, a_low: float, b: float, b_low: float) -> tuple[float, float]:
    p, e = two_product(a, b)
    p, e = quick_two_sum(p, fma(a, b_low, fma(a_low, b, e)))
    return p, e


@njit(error_model="numpy")  # type: ignore[untyped-decorator]
def multiply_add(a: float, a_low: float, b: float, b_low: float, c: float, c_low: float) -> tuple[float, float]:
    """a * b + c, with an error below 2**-102 (|a b| + |c|): relative to its terms, where they cancel."""
    p, e = two_product(a, b)
    s, f = two_sum(p, c)
    s, f = quick_two_sum(s, f + (fma(a, b_low, fma(a_low, b, e)) + c_low))
    return s, f

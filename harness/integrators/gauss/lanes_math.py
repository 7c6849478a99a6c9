"""Functions of `math` on eight lanes: sine, cosine and exponential by polynomials, other functions lane by lane.

Errors stay below 0.8 ulp (measured by the tests). Sine and cosine use the polynomials of fdlibm (Sun Microsystems,
1993) and reduce arguments with pi/2 in three parts (Cody and Waite). Arguments that are too large for this reduction go
to the scalar function, lane by lane.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

from gnomon.harness.integrators.gauss.lanes import (
    DOUBLES,
    INTEGERS,
    WIDTH,
    LanesType,
    emitting,
    fma,
    lane,
    lanes,
    minus,
    root,
    size,
    with_lane,
)
from llvmlite import ir
from numba import njit, types
from numba.extending import overload

ROUNDING = 6755399441055744.0
"""1.5 * 2^52: adding it to a number rounds the number to an integer, which the lowest bits of the sum hold."""

MOST_ANGLE = 524288.0
"""2^19: multiples of the first part of pi/2, which has 33 bits, are exact up to here."""
TWO_OVER_PI = 0.6366197723675814
HALF_PI_1, HALF_PI_2, HALF_PI_3 = 1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21
S1, S2, S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
S4, S5, S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
C1, C2, C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
C4, C5, C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11

MOST_TURN = 0.03125
"""Up to this angle the terms that `turned` leaves out are below 2^-55."""

MOST_EXPONENT = 700.0
"""Beyond it the result is near overflow or underflow."""
INVERSE_LN2, LN2_1, LN2_2 = 1.4426950408889634, 6.93147180369123816490e-01, 1.90821492927058770002e-10


def _bits(builder: Any, a: Any) -> Any:
    return builder.bitcast(a, INTEGERS)


def _integers(value: int) -> Any:
    return ir.Constant(INTEGERS, [ir.Constant(ir.IntType(64), value)] * WIDTH)


def _choose(builder: Any, counter: Any, even: Any, odd: Any) -> Any:
    """`even` or `odd` according to the lowest bit of the counter, with the sign reversed if the next bit is set."""
    bits = _bits(builder, counter)
    is_odd = builder.icmp_unsigned("!=", builder.and_(bits, _integers(1)), _integers(0))
    sign = builder.shl(builder.and_(bits, _integers(2)), _integers(62))
    return builder.bitcast(builder.xor(_bits(builder, builder.select(is_odd, odd, even)), sign), DOUBLES)


def _scale(builder: Any, counter: Any, a: Any) -> Any:
    """a * 2^counter, for results that are normal numbers."""
    exponent = builder.shl(_bits(builder, counter), _integers(52))
    return builder.bitcast(builder.add(_bits(builder, a), exponent), DOUBLES)


def _all_within(builder: Any, a: Any, limit: Any) -> Any:
    """1 if every lane is at most its limit, 0 if one is above or nan."""
    each = builder.fcmp_ordered("<=", a, limit)
    mask = builder.bitcast(each, ir.IntType(WIDTH))
    return builder.icmp_unsigned("==", mask, ir.Constant(ir.IntType(WIDTH), 2**WIDTH - 1))


choose = emitting(3, _choose)
scale = emitting(2, _scale)
all_within = emitting(2, _all_within, types.boolean)


@njit(error_model="numpy", inline="never")  # type: ignore[misc]
def scalar_sin(a):  # type: ignore[no-untyped-def]
    for i in range(WIDTH):
        a = with_lane(a, i, math.sin(lane(a, i)))
    return a


@njit(error_model="numpy", inline="never")  # type: ignore[misc]
def scalar_cos(a):  # type: ignore[no-untyped-def]
    for i in range(WIDTH):
        a = with_lane(a, i, math.cos(lane(a, i)))
    return a


@njit(error_model="numpy", inline="never")  # type: ignore[misc]
def scalar_exp(a):  # type: ignore[no-untyped-def]
    for i in range(WIDTH):
        a = with_lane(a, i, math.exp(lane(a, i)))
    return a


@njit(error_model="numpy")  # type: ignore[misc]
def two_parts(a, b):  # type: ignore[no-untyped-def]
    """a + b rounded, and its rounding residual, for |a| >= |b|."""
    found = a + b
    return found, minus(b, minus(found, a))


@njit(error_model="numpy")  # type: ignore[misc]
def quarter_turns(a, shift):  # type: ignore[no-untyped-def]
    """Sine of a + shift pi/2, for |a| up to MOST_ANGLE, and its rounding residual."""
    rounded = fma(a, lanes(TWO_OVER_PI), lanes(ROUNDING))
    n = minus(rounded, lanes(ROUNDING))
    exactly = fma(n, lanes(-HALF_PI_1), a)
    r = fma(n, lanes(-HALF_PI_2), exactly)
    # The residual of the last rounding, and the third part of pi/2.
    low = fma(n, lanes(-HALF_PI_3), fma(n, lanes(-HALF_PI_2), minus(exactly, r)))
    z = r * r
    zz = z * z
    sine = fma(zz, fma(zz, fma(z, lanes(S6), lanes(S5)), fma(z, lanes(S4), lanes(S3))), fma(z, lanes(S2), lanes(S1)))
    half = z * lanes(0.5)
    odd = minus(lanes(1.0), half)
    lost = minus(minus(lanes(1.0), odd), half)
    cosine = fma(zz, fma(zz, fma(z, lanes(C6), lanes(C5)), fma(z, lanes(C4), lanes(C3))), fma(z, lanes(C2), lanes(C1)))
    sine, sine_low = two_parts(r, fma(z * r, sine, fma(-half, low, low)))
    cosine, cosine_low = two_parts(odd, fma(zz, cosine, fma(fma(z * r, lanes(1 / 6), -r), low, lost)))
    counter = rounded + lanes(shift)
    return choose(counter, sine, cosine), choose(counter, sine_low, cosine_low)


@njit(error_model="numpy")  # type: ignore[misc]
def sin_lanes(a):  # type: ignore[no-untyped-def]
    if all_within(size(a), lanes(MOST_ANGLE)):
        return quarter_turns(a, 0.0)[0]
    return scalar_sin(a)


@njit(error_model="numpy")  # type: ignore[misc]
def cos_lanes(a):  # type: ignore[no-untyped-def]
    if all_within(size(a), lanes(MOST_ANGLE)):
        return quarter_turns(a, 1.0)[0]
    return scalar_cos(a)


@njit(error_model="numpy")  # type: ignore[misc]
def sin_and_cos(a):  # type: ignore[no-untyped-def]
    """Sine and cosine, in little more time than one of them."""
    sine, cosine, _near = turned_first(a)
    return sine, cosine


@njit(error_model="numpy")  # type: ignore[misc]
def turned_first(a):  # type: ignore[no-untyped-def]
    """Sine and cosine of a, and `near` for `turned`: a, both values, and their rounding residuals."""
    if all_within(size(a), lanes(MOST_ANGLE)):
        sine, sine_low = quarter_turns(a, 0.0)
        cosine, cosine_low = quarter_turns(a, 1.0)
        return sine, cosine, (a, sine, cosine, sine_low, cosine_low)
    sine, cosine = scalar_sin(a), scalar_cos(a)
    return sine, cosine, (a, sine, cosine, lanes(0.0), lanes(0.0))


@njit(error_model="numpy")  # type: ignore[misc]
def turned(a, near):  # type: ignore[no-untyped-def]
    """Sine and cosine of a from sine and cosine of a nearby b, in half of the time, and `near` for the next angle.

    The rounding residuals of sine and cosine of b are added before the sum is rounded. Without them the error of the
    result depends on a - b alone. If guesses are accurate to some ulps, a - b is a smooth function of the phase of a
    motion: the error of the pendulum's energy then grew as t, by 1e-20 to 1e-19 a step.
    """
    b, sine, cosine, sine_low, cosine_low = near
    d = minus(a, b)
    if not all_within(size(d), lanes(MOST_TURN)):
        return turned_first(a)
    z = d * d
    s = fma(z * d, fma(z, fma(z, lanes(-1 / 5040), lanes(1 / 120)), lanes(-1 / 6)), d)
    c = z * fma(z, fma(z, lanes(-1 / 720), lanes(1 / 24)), lanes(-0.5))
    return (
        sine + fma(cosine, s, fma(sine, c, sine_low)),
        cosine + fma(-sine, s, fma(cosine, c, cosine_low)),
        near,
    )


@njit(error_model="numpy")  # type: ignore[misc]
def exp_lanes(a):  # type: ignore[no-untyped-def]
    if not all_within(size(a), lanes(MOST_EXPONENT)):
        return scalar_exp(a)
    rounded = fma(a, lanes(INVERSE_LN2), lanes(ROUNDING))
    n = minus(rounded, lanes(ROUNDING))
    exactly = fma(n, lanes(-LN2_1), a)
    r = fma(n, lanes(-LN2_2), exactly)
    low = fma(n, lanes(-LN2_2), minus(exactly, r))
    z = r * r
    # The series: 0.35^14/14! is below a hundredth of an ulp.
    p = fma(z, fma(r, lanes(1 / 6227020800), lanes(1 / 479001600)), fma(r, lanes(1 / 39916800), lanes(1 / 3628800)))
    p = fma(z, p, fma(r, lanes(1 / 362880), lanes(1 / 40320)))
    p = fma(z, p, fma(r, lanes(1 / 5040), lanes(1 / 720)))
    p = fma(z, p, fma(r, lanes(1 / 120), lanes(1 / 24)))
    p = fma(z, p, fma(r, lanes(1 / 6), lanes(0.5)))
    return scale(rounded, lanes(1.0) + (r + fma(z, p, low)))


@overload(math.sqrt, strict=False)  # type: ignore[misc]
def overload_sqrt(a: Any) -> Any:
    return (lambda a: root(a)) if isinstance(a, LanesType) else None


@overload(math.sin, strict=False)  # type: ignore[misc]
def overload_sin(a: Any) -> Any:
    return (lambda a: sin_lanes(a)) if isinstance(a, LanesType) else None


@overload(math.cos, strict=False)  # type: ignore[misc]
def overload_cos(a: Any) -> Any:
    return (lambda a: cos_lanes(a)) if isinstance(a, LanesType) else None


@overload(math.exp, strict=False)  # type: ignore[misc]
def overload_exp(a: Any) -> Any:
    return (lambda a: exp_lanes(a)) if isinstance(a, LanesType) else None


EACH: dict[str, Callable[..., Any]] = {}
"""The functions that are evaluated lane by lane, by their names in machine code."""


def _named(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """Rename a function to `name`, which must be unique. Raises ValueError if the name is in use.

    Another process links machine code by name and by the number of functions compiled before: with two functions of one
    name the first could be called instead of the second.
    """
    if name in EACH:
        raise ValueError(f"two functions of lanes are called {name}; give each a name of its own")
    function.__name__ = function.__qualname__ = name
    EACH[name] = function
    return function


def _lane_by_lane(function: Callable[..., float]) -> None:
    def each(a):  # type: ignore[no-untyped-def]
        for i in range(WIDTH):
            a = with_lane(a, i, function(lane(a, i)))
        return a

    run = njit(error_model="numpy")(_named(f"{function.__name__}_of_lanes", each))
    chosen = _named(f"{function.__name__}_chosen", lambda a: run(a))

    @overload(function, strict=False)  # type: ignore[misc]
    def on_lanes(a: Any) -> Any:
        return chosen if isinstance(a, LanesType) else None


def _lane_by_lane_of_two(function: Callable[..., float]) -> None:
    def each(a, b):  # type: ignore[no-untyped-def]
        for i in range(WIDTH):
            a = with_lane(a, i, function(lane(a, i), lane(b, i)))
        return a

    run = njit(error_model="numpy")(_named(f"{function.__name__}_of_lanes", each))
    chosen = _named(f"{function.__name__}_chosen", lambda a, b: run(lanes(a), lanes(b)))

    @overload(function, strict=False)  # type: ignore[misc]
    def on_lanes(a: Any, b: Any) -> Any:
        return chosen if isinstance(a, LanesType) or isinstance(b, LanesType) else None


for _function in (
    math.tan, math.asin, math.acos, math.atan, math.sinh, math.cosh, math.tanh, math.asinh, math.acosh, math.atanh,
    math.log,
):  # fmt: skip
    _lane_by_lane(_function)
for _of_two in (math.atan2, math.hypot):
    _lane_by_lane_of_two(_of_two)


@njit(error_model="numpy")  # type: ignore[misc]
def whole_power(a, n):  # type: ignore[no-untyped-def]
    """a^n by repeated squaring; for a constant n the compiler leaves only the products."""
    found, square, left = lanes(1.0), a, abs(n)
    while left > 0:
        if left & 1:
            found = found * square
        square = square * square
        left >>= 1
    return lanes(1.0) / found if n < 0 else found


@njit(error_model="numpy")  # type: ignore[misc]
def real_power(a, b):  # type: ignore[no-untyped-def]
    for i in range(WIDTH):
        a = with_lane(a, i, math.pow(lane(a, i), lane(b, i)))
    return a


@overload(operator.pow, strict=False)  # type: ignore[misc]
def overload_pow(a: Any, b: Any) -> Any:
    if not (isinstance(a, LanesType) or isinstance(b, LanesType)):
        return None
    if isinstance(b, types.Integer):
        return lambda a, b: whole_power(a, b)
    return lambda a, b: real_power(lanes(a), lanes(b))

"""Functions of `math` on eight lanes: sine, cosine and exponential by polynomials, other functions lane by lane.

Errors stay below 0.8 ulp (measured by the tests). Sine and cosine use the polynomials of fdlibm (Sun Microsystems,
1993) and reduce arguments with pi/2 in three parts (Cody and Waite). Arguments that are too large for this reduction go
to the function of numbers, lane by lane.
"""

from __future__ import annotations

from gnomon.harness.integrators.gauss.lanes import Lanes, are_within, choose, each, fma, lanes, minus, scale

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
"""Up to this angle the terms that `turn_lanes` leaves out are below 2^-55."""

MOST_EXPONENT = 700.0
"""Beyond it the result is near overflow or underflow."""
INVERSE_LN2, LN2_1, LN2_2 = 1.4426950408889634, 6.93147180369123816490e-01, 1.90821492927058770002e-10

Near = tuple[Lanes, Lanes, Lanes, Lanes, Lanes]
"""An angle, its sine and cosine, and their rounding residuals."""


def polynomial(x: Lanes, coefficients: tuple[float, ...]) -> Lanes:
    """The value at x, from the lowest coefficient to the highest, by Horner's rule."""
    total = lanes(coefficients[-1])
    for c in reversed(coefficients[:-1]):
        total = fma(x, total, lanes(c))
    return total


def two_parts(a: Lanes, b: Lanes) -> tuple[Lanes, Lanes]:
    """a + b rounded, and its rounding residual, for |a| >= |b|."""
    total = a + b
    return total, minus(b, minus(total, a))


def quarter_turns(a: Lanes, shift: float) -> tuple[Lanes, Lanes]:
    """Sine of a + shift pi/2, for |a| up to MOST_ANGLE, and its rounding residual."""
    rounded = fma(a, lanes(TWO_OVER_PI), lanes(ROUNDING))
    n = minus(rounded, lanes(ROUNDING))
    exactly = fma(n, lanes(-HALF_PI_1), a)
    r = fma(n, lanes(-HALF_PI_2), exactly)
    # The residual of the last rounding, and the third part of pi/2.
    low = fma(n, lanes(-HALF_PI_3), fma(n, lanes(-HALF_PI_2), minus(exactly, r)))
    z = r * r
    zz = z * z
    sine = fma(zz, fma(zz, polynomial(z, (S5, S6)), polynomial(z, (S3, S4))), polynomial(z, (S1, S2)))
    half = z * lanes(0.5)
    odd = minus(lanes(1.0), half)
    lost = minus(minus(lanes(1.0), odd), half)
    cosine = fma(zz, fma(zz, polynomial(z, (C5, C6)), polynomial(z, (C3, C4))), polynomial(z, (C1, C2)))
    sine, sine_low = two_parts(r, fma(z * r, sine, fma(-half, low, low)))
    cosine, cosine_low = two_parts(odd, fma(zz, cosine, fma(fma(z * r, lanes(1 / 6), -r), low, lost)))
    counter = rounded + lanes(shift)
    return choose(counter, sine, cosine), choose(counter, sine_low, cosine_low)


def sin_lanes(a: Lanes) -> Lanes:
    if are_within(abs(a), MOST_ANGLE):
        return quarter_turns(a, 0.0)[0]
    return each("sin", a)  # type: ignore[no-any-return]


def cos_lanes(a: Lanes) -> Lanes:
    if are_within(abs(a), MOST_ANGLE):
        return quarter_turns(a, 1.0)[0]
    return each("cos", a)  # type: ignore[no-any-return]


def turn_lanes_first(a: Lanes) -> tuple[Lanes, Lanes, Near]:
    """Sine and cosine of a, and `near` for `turn_lanes`."""
    if are_within(abs(a), MOST_ANGLE):
        sine, sine_low = quarter_turns(a, 0.0)
        cosine, cosine_low = quarter_turns(a, 1.0)
        return sine, cosine, (a, sine, cosine, sine_low, cosine_low)
    sine, cosine = each("sin", a), each("cos", a)
    return sine, cosine, (a, sine, cosine, lanes(0.0), lanes(0.0))


def turn_lanes_far(a: Lanes) -> tuple[Lanes, Lanes, Near]:
    """`turn_lanes_first` for angles that few steps need: compiled apart from the steps."""
    return turn_lanes_first(a)


def turn_lanes(a: Lanes, near: Near) -> tuple[Lanes, Lanes, Near]:
    """Sine and cosine of a from sine and cosine of a nearby b, in half of the time, and `near` for the next angle.

    The rounding residuals of sine and cosine of b are added before the sum is rounded. Without them the error of the
    result depends on a - b alone. If guesses are accurate to some ulps, a - b is a smooth function of the phase of a
    motion: the error of the pendulum's energy then grew as t, by 1e-20 to 1e-19 a step.
    """
    b, sine, cosine, sine_low, cosine_low = near
    d = minus(a, b)
    if not are_within(abs(d), MOST_TURN):
        return turn_lanes_far(a)
    z = d * d
    s = fma(z * d, polynomial(z, (-1 / 6, 1 / 120, -1 / 5040)), d)
    c = z * polynomial(z, (-0.5, 1 / 24, -1 / 720))
    return (
        sine + fma(cosine, s, fma(sine, c, sine_low)),
        cosine + fma(-sine, s, fma(cosine, c, cosine_low)),
        near,
    )


def exp_lanes(a: Lanes) -> Lanes:
    if not are_within(abs(a), MOST_EXPONENT):
        return each("exp", a)  # type: ignore[no-any-return]
    rounded = fma(a, lanes(INVERSE_LN2), lanes(ROUNDING))
    n = minus(rounded, lanes(ROUNDING))
    exactly = fma(n, lanes(-LN2_1), a)
    r = fma(n, lanes(-LN2_2), exactly)
    low = fma(n, lanes(-LN2_2), minus(exactly, r))
    z = r * r
    # The series: 0.35^14/14! is below a hundredth of an ulp.
    p = fma(z, polynomial(r, (1 / 479001600, 1 / 6227020800)), polynomial(r, (1 / 3628800, 1 / 39916800)))
    p = fma(z, p, polynomial(r, (1 / 40320, 1 / 362880)))
    p = fma(z, p, polynomial(r, (1 / 720, 1 / 5040)))
    p = fma(z, p, polynomial(r, (1 / 24, 1 / 120)))
    p = fma(z, p, polynomial(r, (0.5, 1 / 6)))
    return scale(rounded, lanes(1.0) + (r + fma(z, p, low)))

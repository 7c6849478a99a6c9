"""Each recurrence against mpmath's Taylor coefficients of the same function."""

from collections.abc import Callable
from typing import Any

import flint
import mpmath
import pytest
from gnomon.reference.numerics.series import Tape
from gnomon.reference.numerics.taylor import flint_arithmetic

ORDER = 12
F = flint_arithmetic()

FUNCTIONS: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    "polynomial": (lambda x: 3 - 2 * x + x * x - x / 4, lambda x: 3 - 2 * x + x * x - x / 4),
    "quotient": (lambda x: (1 + x) / (2 + x * x), lambda x: (1 + x) / (2 + x * x)),
    "inverse": (lambda x: 5 / x, lambda x: 5 / x),
    "cube": (lambda x: x**3, lambda x: x**3),
    "inverse square": (lambda x: x**-2, lambda x: x**-2),
    "power 3/2": (lambda x: x ** flint.arb("1.5"), lambda x: x ** mpmath.mpf("1.5")),
    "hypot": (lambda x: F["hypot"](x, 2), lambda x: mpmath.sqrt(x * x + 4)),
} | {
    name: (lambda x, name=name: F[name](x), lambda x, name=name: getattr(mpmath, name)(x))
    for name in F
    if name != "hypot"
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_coefficients_agree_with_numerical_differentiation(name: str) -> None:
    ours, theirs = FUNCTIONS[name]
    flint.ctx.prec = 200
    tape = Tape(flint.arb(0))
    x = tape.variable()
    x.c[:] = [flint.arb("0.375"), flint.arb(2), flint.arb(-1)] + [flint.arb(0)] * ORDER
    y = ours(x)
    for k in range(ORDER):
        tape.extend(k)
    with mpmath.workdps(80):
        expected = mpmath.taylor(lambda s: theirs(mpmath.mpf("0.375") + 2 * s - s * s), 0, ORDER - 1)
        for mine, theirs_k in zip(y.c, expected, strict=False):
            value = mpmath.mpf(mine.mid().str(60, radius=False))
            # numerical differentiation at 80 digits leaves far more than 30 digits at the 12th derivative
            assert abs(value - theirs_k) < mpmath.mpf(10) ** -30 * (1 + abs(theirs_k))

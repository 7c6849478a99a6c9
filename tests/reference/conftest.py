"""Two ways to verify an exact motion that share no formula with it."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import flint
import mpmath
import pytest
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import integrate

STEP = 30
"""Central differences over 10^-30 s have an error of 10^-60 times the third derivative; states have 100 digits."""


@pytest.fixture
def residual() -> Callable[..., Any]:
    """residual(motion, rates, t): the largest |x'(t) - rates(mpmath, state)|, by central differences."""

    def largest(motion: Motion, rates: Callable[..., Any], t: Any) -> Any:
        time, h = exact(t), Fraction(1, 10**STEP)
        with mpmath.workdps(110):
            before, here, after = (motion.state(s, 100) for s in (time - h, time, time + h))
            slopes = [(b - a) / (2 * mpmath.mpf(10) ** -STEP) for a, b in zip(before, after, strict=True)]
            return max(abs(slope - rate) for slope, rate in zip(slopes, rates(mpmath, here), strict=True))

    return largest


@pytest.fixture
def taylor() -> Callable[..., Any]:
    """taylor(rates, start, t): the state at t by a Taylor integration of 60 digits."""

    def state(rates: Callable[..., Any], start: tuple[Any, ...], t: Any) -> list[Any]:
        class Arithmetic:
            """The functions that `rates` may use, over balls and series."""

            mpf = staticmethod(lambda x: ball(exact(x)))

            @staticmethod
            def sin(x: Any) -> Any:
                return x.sin()

            @staticmethod
            def tan(x: Any) -> Any:
                return x.tan() if hasattr(x, "tan") else flint.arb(x).tan()

        found = integrate(lambda _, y: tuple(rates(Arithmetic, y)), tuple(map(exact, start)), [exact(t)], 60)[0]
        with mpmath.workdps(70):
            return [mpmath.mpf(x.numerator) / x.denominator for x in found]

    return state

"""The bead on the rotating wire against its hyperbolic closed form."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.guided.bead_rotating_wire_vertical_plane import BeadOnTurningWire


@pytest.mark.parametrize("start", [("0.1", "0"), ("1", "0.5"), ("0", "2.5")])
@pytest.mark.parametrize("t", ["1e-9", "0.7", "12.25"])
def test_the_motion_is_the_sum_of_growing_decaying_and_bounded_part(start, t):
    rate, g, r0, v0 = Fraction(2), Fraction(10), Fraction(start[0]), Fraction(start[1])
    motion = BeadOnTurningWire(rate, g, r0, v0)
    with mpmath.workdps(70):
        a, b = (mpmath.mpf(x.numerator) / x.denominator for x in (motion.growing, motion.decaying))
        up, down, swing = a * mpmath.exp(2 * mpmath.mpf(t)), b * mpmath.exp(-2 * mpmath.mpf(t)), mpmath.mpf(5) / 4
        right = (
            up + down + swing * mpmath.sin(2 * mpmath.mpf(t)),
            2 * (up - down + swing * mpmath.cos(2 * mpmath.mpf(t))),
        )
        for found, expected in zip(motion.state(t, 50), right, strict=True):
            assert abs(found - expected) < mpmath.mpf(10) ** -48 * max(1, abs(expected))


def test_tuned_start_stays_bounded():
    """The growing part is exactly zero, so 25 e-foldings later the orbit is still the sine."""
    motion = BeadOnTurningWire(Fraction(2), Fraction(10), Fraction(0), Fraction(5, 2))
    assert motion.growing == 0
    with mpmath.workdps(50):
        assert abs(motion.state("12.5", 40)[0] - mpmath.mpf(5) / 4 * mpmath.sin(25)) < mpmath.mpf(10) ** -39

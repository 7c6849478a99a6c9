"""The Cartesian pendulum against the integrated equations with the multiplier eliminated."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.pendulums.holonomic_constraint_dae import CartesianPendulum

STARTS = [("0.75", "-1", "2", "1.5"), (4, 3, 0, 0), (3, -4, 16, 12), ("1e-6", 1, 0, 0), (0, -1, 2, 0)]


@pytest.mark.parametrize("start", STARTS)
def test_multiplier_form_arrives_at_the_same_state(start, taylor):
    motion = CartesianPendulum(Fraction(1), *map(exact, start))

    def rates(_, state):
        x, y, vx, vy = state
        lam = (vx * vx + vy * vy - y) / (x * x + y * y)
        return vx, vy, -lam * x, -lam * y - 1

    found = motion.state("4.5", 50)
    with mpmath.workdps(60):
        for a, b in zip(found, taylor(rates, start, "4.5"), strict=True):
            assert abs(a - b) < mpmath.mpf(10) ** -45 * 20  # the saddle multiplies a rounding by e^9 at most
        assert (
            abs(
                found[0] ** 2
                + found[1] ** 2
                - mpmath.mpf(exact(motion.radius_squared).numerator) / motion.radius_squared.denominator
            )
            < 1e-47
        )


def test_rest_at_the_top_and_motion_on_the_separatrix_are_exact():
    top = CartesianPendulum(Fraction(1), Fraction(0), Fraction(1), Fraction(0), Fraction(0))
    assert top.rests
    assert top.state(1000) == (0, 1, 0, 0)
    assert CartesianPendulum(Fraction(1), Fraction(0), Fraction(-1), Fraction(2), Fraction(0)).on_separatrix

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.radial_fall_inverse_square import RadialFall
from mpmath import mpf


def fall(mu=1, r=1, v=0):
    return RadialFall(*map(Fraction, (mu, r, v)))


def test_the_collision_time_of_a_fall_from_rest_is_that_of_the_book():
    with mpmath.workdps(60):
        assert mpmath.almosteq(
            fall(3, 2).collision_time(50), mpmath.pi / (2 * mpmath.sqrt(2)) * mpmath.sqrt(mpf(8) / 3), mpf("1e-48")
        )


@pytest.mark.parametrize("angle", ["0.3", "1.5", "1.57079632"])
def test_from_rest_by_the_cycloid(angle):
    """r = cos^2 e, t = sqrt(1/2) (e + sin e cos e); the last is 1e-24 of the time before the collision."""
    with mpmath.workdps(120):
        e = mpf(angle)
        t = (e + mpmath.sin(e) * mpmath.cos(e)) / mpmath.sqrt(2)
        r, v = fall().state(exact(t), 50)
        assert abs(r - mpmath.cos(e) ** 2) < mpf("1e-49") * mpmath.cos(e) ** 2
        assert abs(v + mpmath.sqrt(2) * mpmath.tan(e)) < mpf("1e-48") * mpmath.tan(e)


def test_exactly_at_the_escape_speed():
    """r = (r0^(3/2) + 3/2 sqrt(2 mu) t)^(2/3)."""
    motion = fall(2, 1, 2)
    assert not motion.bound
    assert motion.collision_time() is None
    with mpmath.workdps(60):
        assert mpmath.almosteq(motion.state(1000, 50)[0], mpmath.cbrt(mpf(3001) ** 2), mpf("1e-48"))
    assert fall(2, 1, Fraction(2) - Fraction(1, 10**40)).bound


def test_the_equation_holds(residual):
    def rates(m, y):
        return y[1], -2 / y[0] ** 2

    for v in ("2.000000000002", "1.999999999998", "-1"):
        assert residual(fall(2, 1, v), rates, Fraction("0.1")) < mpf("1e-50")


def test_the_state_of_a_fast_plunge_at_zero_is_the_start():
    motion = RadialFall(Fraction(1.7310667649644105), Fraction(1.9646027458576878), Fraction(-1.49467970066063))
    assert [exact(x) for x in motion.state(0, 50)] == [motion.r0, motion.v0]

"""Jacobi's functions by theta functions against mpmath's, and the quadratures that they are used in."""

import flint
import mpmath
import pytest
from gnomon.reference.numerics.balls import precision
from gnomon.reference.numerics.theta import Jacobi, Values, integral, turns

BITS = 200


def close(found: flint.acb, expected: mpmath.mpf) -> bool:
    """Whether the ball holds the other number, to the 40 digits with which that was computed and printed."""
    printed = flint.arb(mpmath.nstr(expected, 40))
    return bool(abs(found.real - printed) < flint.arb("1e-38"))


@pytest.mark.parametrize("m", ["0.3", "0.999999999999"])
@pytest.mark.parametrize("u", ["0.4", "7.3", "-61.9"])
def test_values_are_those_of_mpmath(m: str, u: str) -> None:
    with precision(BITS), mpmath.workdps(60):
        functions = Jacobi(flint.arb(m), 1 - flint.arb(m))
        found = functions.at(flint.arb(u))
        for value, name in zip(found, ("sn", "cn", "dn"), strict=True):
            assert close(value, mpmath.ellipfun(name, mpmath.mpf(u), m=mpmath.mpf(m)).real)


def test_on_a_wide_ball_the_mean_value_form_is_narrow_and_holds_the_values_of_all_points() -> None:
    with precision(BITS):
        functions = Jacobi(flint.arb("0.9"), flint.arb("0.1"))
        wide = functions.at(flint.arb("1.3", "0.01"))
        for point in ("1.2901", "1.3", "1.3099"):
            for one, ball in zip(functions.at(flint.arb(point)), wide, strict=True):
                assert ball.contains(one.mid())
        # slopes of at most 1: a little more than the ball's own radius
        assert all(x.real.rad() < 0.02 for x in wide)


@pytest.mark.parametrize("limit", [False, True])
def test_the_addition_theorem_moves_the_argument(limit: bool) -> None:
    with precision(BITS):
        functions = (
            Jacobi(flint.arb(1), flint.arb(0), limit=True) if limit else Jacobi(flint.arb("0.7"), flint.arb("0.3"))
        )
        start = Values(*(x.real for x in functions.at(flint.arb("2.9"))))
        shifted, direct = functions.shifted(start, flint.arb("1.7")), functions.at(flint.arb("4.6"))
        assert all(a.overlaps(b) for a, b in zip(shifted, direct, strict=True))
        if limit:
            assert functions.argument(start).contains(flint.arb("2.9").mid())
        else:
            # 2.9 lies beyond K = 2.07...: the branch with cn < 0
            assert start.cn < 0
            assert abs(functions.argument(start) - flint.arb("2.9")) < flint.arb("1e-50")


def test_integrals_are_proved_and_need_enough_precision() -> None:
    with precision(BITS):
        found = integral(lambda s: 1 / (1 + s * s), flint.arb(1), 50)
        assert abs(4 * found - flint.arb.pi()) < flint.arb("1e-49")
        assert found.overlaps(flint.arb.pi() / 4)


def test_turns_are_the_integer_below() -> None:
    assert [turns(flint.arb(x)) for x in (2.7, -0.2, 3)] == [2, -1, 3]

import mpmath
import pytest
from gnomon.reference.numerics.carlson import rf, rj, third
from gnomon.reference.numerics.precision import working
from mpmath import mpf


@pytest.mark.parametrize("arguments", [("0.3", "0.7", 1), (0, "1e-24", 1), ("1e-30", 2, 3)])
def test_rf_against_mpmath(arguments):
    with working(50) as mp:
        found = rf(mp, *map(mp.mpf, arguments))
        expected = mp.elliprf(*map(mp.mpf, arguments))
        assert mp.almosteq(found, expected, mp.mpf("1e-48"))


@pytest.mark.parametrize("arguments", [("0.3", "0.7", 1, "1.9"), (0, "1e-24", 1, 4), ("0.1", "0.2", "0.3", "1e10")])
def test_rj_against_mpmath(arguments):
    with working(50) as mp:
        found = rj(mp, *map(mp.mpf, arguments))
        expected = mp.elliprj(*map(mp.mpf, arguments))
        assert mp.almosteq(found, expected, mp.mpf("1e-48"))


@pytest.mark.parametrize("phase", ["0.3", "-1.1", "1.5707963", "2.5", "-7.3", "40"])
def test_the_third_integral_against_quadrature(phase):
    with mpmath.workdps(30):
        n, m = mpf("-1.7"), mpf("0.83")
        end = mpf(phase)
        pieces = mpmath.linspace(0, end, 2 + 2 * int(abs(end)))
        expected = mpmath.quad(
            lambda x: 1 / ((1 - n * mpmath.sin(x) ** 2) * mpmath.sqrt(1 - m * mpmath.sin(x) ** 2)), pieces
        )
    with working(40) as mp:
        found = third(mp, mp.mpf("-1.7"), mp.mpf(phase), mp.mpf("0.17"))
        assert abs(found - mp.mpf(expected)) < mp.mpf("1e-25")

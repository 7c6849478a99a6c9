import math
from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.pendulums.foucault_pendulum_linear import Foucault
from mpmath import mpf

PARIS = {"g": "9.81", "L": 67, "Om": "7.292115e-5", "lat": "0.8526", "x": 3, "y": 0, "vx": 0, "vy": 0}


def pendulum(larmor=False, **changed):
    return Foucault(*(Fraction(value) for value in (PARIS | changed).values()), larmor=larmor)


@pytest.mark.parametrize("larmor", [False, True])
@pytest.mark.parametrize(
    ("changed", "t"),
    [
        ({}, 86400),
        ({"L": 1}, 172800),
        ({"lat": 0}, 3600),
        ({"L": 1, "Om": 20, "lat": 1.5707963267948966}, 20),
        ({"L": 1, "Om": "1e8"}, 1),
        ({"Om": "1e-12"}, -7),
    ],
)
def test_fifty_digits_agree_with_a_hundred(larmor, changed, t):
    motion = pendulum(larmor, **changed)
    with mpmath.workdps(120):
        for pair in (slice(0, 2), slice(2, 4)):
            a, b = motion.state(t, 50)[pair], motion.state(t, 100)[pair]
            assert mpmath.hypot(a[0] - b[0], a[1] - b[1]) < mpf("1e-49") * mpmath.hypot(*b)


@pytest.mark.parametrize("larmor", [False, True])
def test_against_the_matrix_exponential(larmor):
    """The linear system's own exponential at 60 digits: it shares no formula."""
    motion = pendulum(larmor, L=1, Om=2, vy="0.3")
    with mpmath.workdps(70):
        W = 2 * mpmath.sin(mpf("0.8526"))
        k = mpf("9.81") - (W * W if larmor else 0)
        A = mpmath.matrix([[0, 0, 1, 0], [0, 0, 0, 1], [-k, 0, 0, 2 * W], [0, -k, -2 * W, 0]])
        expected = mpmath.expm(5 * A, method="taylor") * mpmath.matrix([3, 0, 0, mpf("0.3")])
        for a, b in zip(motion.state(5, 55), expected, strict=True):
            assert abs(a - b) < mpf("1e-50")


def test_without_rotation_it_is_the_harmonic_oscillator():
    motion = pendulum(Om=0, vx="0.5")
    with mpmath.workdps(60):
        w = mpmath.sqrt(mpf("9.81") / 67)
        found = motion.state(100, 50)
        assert mpmath.almosteq(found[0], 3 * mpmath.cos(100 * w) + mpf("0.5") / w * mpmath.sin(100 * w), mpf("1e-49"))
        assert found[1] == found[3] == 0


def test_the_plane_turns_clockwise_in_the_north():
    motion = pendulum(larmor=True)
    assert float(motion.precession_rate()) == pytest.approx(-7.292115e-5 * math.sin(0.8526), rel=1e-14)
    # After a whole number of swings the pendulum has only turned.
    swings = 100 * motion.swing_period(60)
    time = Fraction(*mpmath.libmp.to_rational(swings._mpf_))
    x, y = motion.state(time, 30)[:2]
    assert float(mpmath.atan2(y, x)) == pytest.approx(float(motion.precession_rate() * swings), rel=1e-4)
    assert pendulum(lat="-0.8526").precession_rate() > 0


def test_released_from_rest_it_never_meets_the_centre():
    # The least radius is |W/s| times the amplitude: the difference of the two circles' radii.
    p, q, _faster, _slower = pendulum(L=1, Om=1).circles(30)
    W = math.sin(0.8526)
    assert float(abs(p - q)) == pytest.approx(3 * W / math.sqrt(9.81 + W * W), rel=1e-14)
    assert float(p + q) == pytest.approx(3, rel=1e-14)


def test_the_closest_approach_is_where_the_distance_is_least():
    motion = pendulum(Om="0.3", L=1, vy="0.2")
    period = float(motion.swing_period())
    distances = [float(mpmath.hypot(*motion.state(period * k / 4000)[:2])) for k in range(2001)]
    # at most half a step from it, second order
    assert abs(min(distances) - float(motion.closest())) < 1e-5 * max(distances)

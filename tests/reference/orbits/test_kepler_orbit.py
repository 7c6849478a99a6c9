import math
from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.kepler_orbit import Kepler
from mpmath import mpf


def orbit(mu, x, y, vx, vy):
    return Kepler(*map(Fraction, (mu, x, y, vx, vy)))


def far(found, expected):
    """The largest relative distance of position and velocity."""
    pairs = [(found[:2], expected[:2]), (found[2:], expected[2:])]
    return max(mpmath.hypot(a[0] - b[0], a[1] - b[1]) / mpmath.hypot(*b) for a, b in pairs)


HARD = {
    "e=0.6": (orbit(1, 0.4, 0, 0, 2), [1, "65.1", -7, 62831]),
    "e=0.999999": (orbit(1, 1e-6, 0, 0, math.sqrt(1.999999e6)), ["1e-9", 1, 6.28318, 65, -3]),
    "from apocentre": (orbit(1, 2, 0, 0, "0.0007"), [1, "2.2214", "4.4428", 100]),
    "parabola": (orbit(2, 1, 0, 0, 2), [1, 100, 10**8, -5]),
    "just bound": (orbit(2, 1, 0, 0, 2 * (1 - 1e-12)), [1, 100, 10**8, 10**17, 10**19]),
    "just unbound": (orbit(2, 1, 0, 0, 2 * (1 + 1e-12)), [1, 100, 10**8, 10**20]),
    "hyperbola from far": (orbit(1, 10**6, 0.5, -3, 1e-6), [1, 10**5, 333333.2, 333333.3, 10**6]),
    "plunge": (orbit(1, 1, 0, 0, 0), ["0.5", "1.1", "1.1107207", "-1.1"]),
    "parabolic plunge": (orbit(2, 1, 0, -2, 0), ["0.1", 0.3333333333333333, -5]),
    "near plunge": (orbit(1, 1, 0, "0.1", "1e-12"), [1, 2, 3, 50]),
}
HARD_TIMES = [pytest.param(motion, t, id=f"{name}, t={t}") for name, (motion, ts) in HARD.items() for t in ts]


@pytest.mark.parametrize(("motion", "t"), HARD_TIMES)
def test_fifty_digits_agree_with_a_hundred(motion, t):
    with mpmath.workdps(120):
        assert far(motion.state(t, 50), motion.state(t, 100)) < mpf("1e-49")


@pytest.mark.parametrize(("motion", "t"), HARD_TIMES)
def test_invariants_hold(motion, t):
    """Energy, angular momentum and the eccentricity vector, each relative to its terms."""
    with mpmath.workdps(130):
        mu, x0, y0, vx0, vy0 = (
            mpf(v.numerator) / v.denominator for v in (motion.mu, motion.x, motion.y, motion.vx, motion.vy)
        )

        def values(x, y, vx, vy):
            r, h = mpmath.hypot(x, y), x * vy - y * vx
            kinetic = (vx**2 + vy**2) / 2
            swept = abs(x * vy) + abs(y * vx)
            terms = (kinetic + mu / r, swept, 1 + abs(vy) * swept / mu, 1 + abs(vx) * swept / mu)
            return (kinetic - mu / r, h, vy * h / mu - x / r, -vx * h / mu - y / r), terms

        before, _ = values(x0, y0, vx0, vy0)
        after, sizes = values(*motion.state(t, 100))
        for a, b, size in zip(before, after, sizes, strict=True):
            # Each digit of the state is good to 1e-100 and each term is a product of two or three of them.
            assert abs(a - b) <= mpf("1e-97") * size


def test_ellipse_by_keplers_equation():
    e = Fraction(3, 5)
    with mpmath.workdps(70):
        for t in (mpf(1) / 3, mpf(2), mpf(5), mpf(61)):
            E = mpmath.findroot(lambda E, t=t: E - mpf("0.6") * mpmath.sin(E) - t, t)
            r = 1 - mpf("0.6") * mpmath.cos(E)
            s = mpf("0.8")
            expected = (mpmath.cos(E) - mpf("0.6"), s * mpmath.sin(E), -mpmath.sin(E) / r, s * mpmath.cos(E) / r)
            found = orbit(1, 1 - e, 0, 0, 2).state(t, 50)
            assert far(found, expected) < mpf("1e-49")


def test_parabola_by_barkers_equation():
    # q = 1, mu = 2, pericentre at t = 0: D + D^3/3 = sqrt(mu/(2 q^3)) t = t, with r = q (1 + D^2).
    with mpmath.workdps(70):
        for t in (mpf(1) / 7, mpf(4), mpf(1000), mpf(-3)):
            w = mpmath.cbrt(abs(3 * t / 2) + mpmath.sqrt(9 * t**2 / 4 + 1))
            D = mpmath.sign(t) * (w - 1 / w)
            dot = 1 / (1 + D**2)
            found = orbit(2, 1, 0, 0, 2).state(t, 50)
            assert far(found, (1 - D**2, 2 * D, -2 * D * dot, 2 * dot)) < mpf("1e-49")


def test_circle():
    motion = orbit(4, 4, 0, 0, 1)
    with mpmath.workdps(60):
        c, s = mpmath.cos(mpf(7) / 4), mpmath.sin(mpf(7) / 4)
        assert far(motion.state(7, 50), (4 * c, 4 * s, -s, c)) < mpf("1e-49")
    assert motion.eccentricity() == 0
    assert float(motion.period()) == 8 * math.pi


def test_radial_fall():
    """Collision of the fall from rest, and the parabolic fall r = (r0^(3/2) - 3/2 sqrt(2 mu) t)^(2/3)."""
    with mpmath.workdps(60):
        assert mpmath.almosteq(orbit(1, 1, 0, 0, 0).collision_time(50), mpmath.pi / (2 * mpmath.sqrt(2)), mpf("1e-49"))
        inward = orbit(2, 1, 0, -2, 0)
        assert mpmath.almosteq(inward.collision_time(50), mpf(1) / 3, mpf("1e-49"))
        assert mpmath.almosteq(inward.state("0.3", 50)[0], (1 - mpf("0.9")) ** (mpf(2) / 3), mpf("1e-49"))
    assert inward.collision_time(forward=False) is None
    assert orbit(2, 1, 0, 2, 0).collision_time() is None
    assert orbit(2, 1, 0, 3, 0).collision_time() is None
    assert orbit(1, 1, 0, -3, 0).collision_time(30) < mpf(1) / 3
    assert orbit(1, 1, 0, 0, 1).collision_time() is None


def test_times_after_the_collision_are_refused():
    with pytest.raises(ValueError, match="not before the collision"):
        orbit(1, 1, 0, 0, 0).state("1.12")
    with pytest.raises(ValueError, match="not before the collision"):
        orbit(2, 1, 0, -2, 0).state(Fraction(1, 3))
    with pytest.raises(ValueError, match="not before the collision"):
        orbit(1, 1, 0, 0, 0).state("-1.12")


def to_fraction(value):
    return Fraction(*mpmath.libmp.to_rational(value._mpf_))


def test_conic_is_decided_exactly():
    assert orbit(2, 1, 0, 0, 2).conic == 0
    assert orbit(2, 1, 0, 0, 2 * (1 - 2**-52)).conic == 1
    assert orbit(2, 1, 0, 0, 2 * (1 + 2**-52)).conic == -1


def test_pericentre_time_is_where_the_distance_is_least():
    for motion in (orbit(1, "0.7", "0.2", "-0.4", "1.3"), orbit(1, -20, "0.5", "1.5", 0), orbit(2, 1, 1, -1, "-0.5")):
        time = motion.pericentre_time(50)
        x, y, vx, vy = motion.state(time, 50)
        with mpmath.workdps(50):
            assert abs(x * vx + y * vy) < mpf("1e-48") * mpmath.hypot(x, y) * mpmath.hypot(vx, vy)
            assert mpmath.almosteq(mpmath.hypot(x, y), motion.pericentre(50), mpf("1e-48"))


def test_sundman_variable_is_the_integral_of_dt_over_r():
    for motion, t in ((orbit(1, "0.7", "0.2", "-0.4", "1.3"), 3), (orbit(2, 1, 0, 0, 2), 3)):
        with mpmath.workdps(25):
            quadrature = mpmath.quad(
                lambda s, m=motion: 1 / mpmath.hypot(*m.state(s, 25)[:2]), mpmath.linspace(0, t, 5), maxdegree=5
            )
            assert mpmath.almosteq(motion.sundman(t, 30), quadrature, mpf("1e-20"))


def test_sundman_variable_counts_whole_periods():
    motion = orbit(1, "0.7", "0.2", "-0.4", "1.3")
    period = to_fraction(motion.period(60))
    with mpmath.workdps(60):
        a_turn = 2 * mpmath.pi * mpmath.sqrt(motion.semi_major_axis(60))
        assert mpmath.almosteq(
            motion.sundman(1 + 10**4 * period, 40), motion.sundman(1, 50) + 10**4 * a_turn, mpf("1e-38")
        )


def test_impossible_starts():
    with pytest.raises(ValueError, match="not positive"):
        orbit(0, 1, 0, 0, 1)
    with pytest.raises(ValueError, match="centre of attraction"):
        orbit(1, 0, 0, 0, 1)
    with pytest.raises(ValueError, match="only an ellipse has a period"):
        orbit(2, 1, 0, 0, 2).period()


FAST = [
    ("1e-19", "1e20", 1), (1, "1e12", 1), (1, "1e30", 1), ("1e-300", "1e200", "1e-200"), ("1e300", "1e200", "1e-200"),
    (3, "1e300", "1e-300"),
]  # fmt: skip


@pytest.mark.parametrize(("mu", "speed", "across"), FAST)
def test_a_fast_point_is_deflected_by_rutherfords_formula(mu, speed, across):
    """From (1, 0) past the centre at the distance b: two straight lines at the angle 2 atan(mu/(v^2 b)).

    The error is the angle b/r at the start, at most 1e-12 here. To 20 digits e cosh F = e sinh F at the start.
    """
    mu, speed, across = map(exact, (mu, speed, across))
    found = Kepler(mu, Fraction(1), Fraction(0), -speed, across).state(22 / speed, 30)
    with mpmath.workdps(30):
        turn = 2 * mpmath.atan(mpf(mu / (speed * across)))
        v = mpf(speed)
        expected = [a * b for a in (21, v) for b in (-mpmath.cos(turn), -mpmath.sin(turn))]
        assert far(found, expected) < mpf("1e-11")

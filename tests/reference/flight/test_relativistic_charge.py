from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.flight.relativistic_charge import RelativisticCharge
from mpmath import mpf

C = 299792458


def charge(electric=(0, 0, 0), magnetic=(0, 0, 0), proper=(0, 0, 0), q_m="1.7588e11"):
    def vector(values):
        return tuple(Fraction(value) for value in values)

    return RelativisticCharge(
        Fraction(q_m), Fraction(C), vector(electric), vector(magnetic), vector((0, 0, 0)), vector(proper)
    )


@pytest.mark.parametrize("t", ["1e-9", "1e-6", "1e-3"])
def test_along_an_electric_field_the_motion_is_hyperbolic(t):
    found = charge((10**6, 0, 0), proper=(C, C, 0)).state(Fraction(t), 50)
    with mpmath.workdps(70):
        force, p0, across = mpf("1.7588e11") * 10**6, mpf(C), mpf(C)
        p = p0 + force * mpf(t)
        energy, start = (C * mpmath.sqrt(mpf(C) ** 2 + q * q + across**2) for q in (p, p0))
        side = mpmath.sqrt(mpf(C) ** 2 + across**2)
        y = across * C / force * (mpmath.asinh(p / side) - mpmath.asinh(p0 / side))
        for a, b in zip(found, [(energy - start) / force, y, 0, p, across, 0], strict=True):
            assert abs(a - b) <= mpf("1e-48") * abs(b)


@pytest.mark.parametrize("gamma", [2, 10**6])
def test_in_a_magnetic_field_it_gyrates_more_slowly(gamma):
    motion = charge(magnetic=(0, 0, "0.01"), proper=(C * gamma, 0, 0))
    with mpmath.workdps(70):
        factor = mpmath.sqrt(1 + mpf(gamma) ** 2)
        angle = mpf("1.7588e11") / 100 * mpf("1e-6") / factor
        u = motion.state(Fraction("1e-6"), 50)[3:5]
        assert abs(u[0] - C * gamma * mpmath.cos(angle)) < mpf("1e-48") * C * gamma
        assert abs(u[1] + C * gamma * mpmath.sin(angle)) < mpf("1e-48") * C * gamma
        assert mpmath.almosteq(motion.proper_time(Fraction("1e-6"), 50), mpf("1e-6") / factor, mpf("1e-49"))


def test_in_a_null_field_it_is_a_cubic_in_proper_time():
    """E = cB along y and z: u_y = a tau, u_x = a^2 tau^2/(2c), c t = c tau + a^2 tau^3/(6c), a = (q/m) E."""
    motion = charge((0, Fraction(C, 128), 0), (0, 0, Fraction(1, 128)))
    t = Fraction("2e-7")
    tau = motion.proper_time(t, 60)
    found = motion.state(t, 50)
    with mpmath.workdps(70):
        a = mpf("1.7588e11") * C / 128
        assert abs(C * tau + a**2 * tau**3 / (6 * C) - C * mpf("2e-7")) < mpf("1e-55") * C
        expected = [a**2 * tau**3 / (6 * C), a * tau**2 / 2, 0, a**2 * tau**2 / (2 * C), a * tau, 0]
        for x, b in zip(found, expected, strict=True):
            assert abs(x - b) <= mpf("1e-48") * abs(b)


@pytest.mark.parametrize(
    ("electric", "magnetic", "proper"),
    [
        ((10**5, 10**6, 20000), ("0.02", "-0.01", "0.01"), (C, 0, C // 2)),
        ((10**7, 0, 20000), (0, 0, "0.001"), (0, 0, 0)),
        ((10**5, 0, 20000), (0, 0, "0.01"), (C * 10**6, 0, 0)),
    ],
)
def test_the_equations_of_motion_hold(electric, magnetic, proper):
    """Central differences of 1e-40 s, over time scales of 1e-10 s and more, err by 1e-60."""
    motion, t, h = charge(electric, magnetic, proper), Fraction("3e-8"), Fraction(1, 10**40)
    before, here, after = (motion.state(s, 110) for s in (t - h, t, t + h))
    with mpmath.workdps(110):
        q, e, b = mpf("1.7588e11"), [mpf(x) for x in electric], [mpf(x) for x in magnetic]
        u = here[3:]
        gamma = mpmath.sqrt(1 + sum(x * x for x in u) / mpf(C) ** 2)
        v = [x / gamma for x in u]
        rates = [
            *v,
            q * (e[0] + v[1] * b[2] - v[2] * b[1]),
            q * (e[1] + v[2] * b[0] - v[0] * b[2]),
            q * (e[2] + v[0] * b[1] - v[1] * b[0]),
        ]
        slopes = [(y - x) / (2 * mpf(10) ** -40) for x, y in zip(before, after, strict=True)]
        for slope, rate, size in zip(slopes, rates, [C] * 3 + [q * 10**7] * 3, strict=True):
            assert abs(slope - rate) < mpf("1e-50") * size


def test_tangential_acceleration_and_curvature():
    """From differences of the exact motion (6.3.2)."""
    motion = charge((10**6, -3 * 10**5, 2 * 10**5), ("0.002", "-0.01", "0.02"), (C, C // 3, -C // 2))
    with mpmath.workdps(60):
        h = mpf("1e-25")

        def velocity(t):
            u = motion.state(t, 55)[3:]
            gamma = mpmath.sqrt(1 + mpmath.fsum(x * x for x in u) / mpf(C) ** 2)
            return mpmath.matrix([x / gamma for x in u])

        slope = (velocity(h) - velocity(-h)) / (2 * h)
        v = velocity(0)
        speed = mpmath.norm(v)
        along = (slope.T * v)[0] / speed
        across = mpmath.norm(slope - along / speed * v)
        assert abs(motion.tangential_acceleration(40) / along - 1) < mpf("1e-20")
        assert abs(motion.curvature_radius(40) / (speed**2 / across) - 1) < mpf("1e-20")
    assert charge((1, 0, 0), proper=(C, 0, 0)).curvature_radius() == mpmath.inf


def test_field_invariants_are_those_of_another_frame():
    """Fields boosted along x by 3/5 c, gamma 5/4 (Lorentz): the same two numbers."""
    electric, magnetic = (Fraction(7), Fraction(-2), Fraction(5)), tuple(Fraction(x, C) for x in (3, 4, -1))
    (ex, ey, ez), (bx, by, bz) = electric, magnetic
    v, gamma = Fraction(3, 5) * C, Fraction(5, 4)
    other = (
        (ex, gamma * (ey - v * bz), gamma * (ez + v * by)),
        (bx, gamma * (by + v * ez / C**2), gamma * (bz - v * ey / C**2)),
    )
    assert charge(*other).field_invariants() == charge(electric, magnetic).field_invariants()

"""The governor against Lagrange's equations, statics and linear theory."""

import mpmath
import pytest
from gnomon.reference.guided.free_azimuth import Governor
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import integrate
from mpmath import mpf

SPINDLE = tuple(map(exact, ("9.81", 1, 2, "0.25", "0.05")))


def governor(*start, spindle=SPINDLE):
    return Governor(*spindle, *map(exact, start))


@pytest.mark.parametrize("start", [("0.5", 1, "-0.3", 4), ("0.2", 0, "-1.5", 12), ("-0.9", 0, "0.1", -16)])
def test_it_moves_as_lagranges_equations_integrate(start):
    """d/dt of 2 L^2 (m + 2 M sin^2) theta' and of the momentum, written apart from the case's equations."""

    def field(t, state):
        g, m, sleeve, length, inertia = map(ball, SPINDLE)
        theta, _phi, rate, spin = state
        s, c = theta.sin(), theta.cos()
        mass = 2 * length * length * (m + 2 * sleeve * s * s)
        about = inertia + 2 * m * length * length * s * s
        push = 4 * sleeve * length * length * s * c * rate * rate + 2 * m * length * length * s * c * spin * spin
        push = push - 2 * (m + sleeve) * g * length * s
        return (
            rate,
            spin,
            (push - 8 * sleeve * length * length * s * c * rate * rate) / mass,
            -4 * m * length * length * s * c * rate * spin / about,
        )

    (found,) = integrate(field, tuple(map(exact, start)), (exact(1),), 60)
    with mpmath.workdps(60):
        state = governor(*start).state(1, 50)
        assert max(abs(a - mpf(b.numerator) / b.denominator) for a, b in zip(state, found, strict=True)) < mpf("1e-46")


def test_the_steady_angle_is_at_watts_height():
    """The height of the cone L cos(theta) is (m + M) g/(m phi'^2)."""
    motion = governor("0.9", 0, 0, 16)
    angle = motion.steady_angle(40)
    with mpmath.workdps(40):
        about = mpf("0.05") + mpf("0.125") * mpmath.sin(angle) ** 2
        spin = motion.momentum(40) / about
        assert abs(mpmath.cos(angle) / 4 - 3 * mpf("9.81") / spin**2) < mpf("1e-37")


def test_small_swings_have_the_linear_frequency():
    """The period grows with the square of the amplitude, here 1e-10."""
    steady = governor("0.9", 0, 0, 16).steady_angle(30)
    with mpmath.workdps(30):
        about = mpf("0.05") + mpf("0.125") * mpmath.sin(steady) ** 2
        spin = governor("0.9", 0, 0, 16).momentum(30) / about
    motion = governor(steady, 0, "1e-10", spin)
    with mpmath.workdps(30):
        assert abs(motion.period(25) * motion.small_frequency(25) / (2 * mpmath.pi) - 1) < mpf("1e-18")


def test_the_arms_are_lifted_above_a_critical_spin():
    """phi'^2 > (m + M) g/(m L) at the spindle: 117.72 (rad/s)^2."""
    assert not governor(0, 0, 1, "10.84").lifted
    assert governor(0, 0, 1, "10.86").lifted
    assert not governor(0, 0, 1, "10.86").one_sided
    assert governor("0.9", 0, 0, 16).one_sided
    assert not governor("3.1", 0, 30, 1).swings
    assert governor(0, 0, 0, 16).rests
    assert governor(0, 0, 0, 16).state(5, 20)[1] == 80

"""Atwood machine and movable wedge: the forces between the parts give the accelerations."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.guided.atwood_pulley_systems import Atwood
from gnomon.reference.guided.wedge_block_energy_momentum import Wedge
from gnomon.reference.numerics.precision import exact


def test_tensions_turn_the_pulley():
    """(T1 - T2) R = I x''/R, exactly in rational numbers."""
    machine = Atwood((Fraction(0),), (Fraction(0),), *map(exact, ("9.81", 2, "1.5", "0.005", "0.1")))
    first, second = machine.m1 * (machine.g - machine.rate), machine.m2 * (machine.g + machine.rate)
    assert (first - second) * machine.radius == machine.inertia * machine.rate / machine.radius
    assert machine.tensions(30)[0] == pytest.approx(float(first), rel=1e-15)


def test_masses_that_differ_in_the_last_bit_move_the_machine():
    machine = Atwood((Fraction(0),), (Fraction(0),), *map(exact, (10, 1.5000000000000002, 1.5, 0, 1)))
    x, v = machine.state(1000, 30)
    with mpmath.workdps(30):
        expected = mpmath.mpf(10) * mpmath.mpf(2) ** -52 / (3 + mpmath.mpf(2) ** -52)
        assert mpmath.almosteq(v, 1000 * expected, mpmath.mpf(10) ** -28)
        assert mpmath.almosteq(x, 500000 * expected, mpmath.mpf(10) ** -28)


@pytest.mark.parametrize(("m", "M"), [("1", "3"), ("1", "1e-8"), ("1e8", "1")])
def test_normal_force_gives_both_accelerations(m, M):
    """Newton's law for the wedge, and for the block along and across the face, to the digits of the force."""
    wedge = Wedge((Fraction(0),) * 2, (Fraction(0),) * 2, *map(exact, ("9.81", m, M, "0.5")))
    with mpmath.workdps(60):
        X, s = wedge.acceleration(0, 55), wedge.acceleration(1, 55)
        force, alpha, g = wedge.normal_force(55), mpmath.mpf("0.5"), mpmath.mpf("9.81")
        small = mpmath.mpf(10) ** -50
        assert abs(mpmath.mpf(M) * X + force * mpmath.sin(alpha)) < small * force
        assert abs(s + X * mpmath.cos(alpha) - g * mpmath.sin(alpha)) < small * g * mpmath.mpf(m)
        across = g * mpmath.cos(alpha) - force / mpmath.mpf(m)
        assert abs(across + X * mpmath.sin(alpha)) < small * g * mpmath.mpf(m)

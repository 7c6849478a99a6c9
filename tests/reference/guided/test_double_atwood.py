"""Double Atwood machine: tensions and Newton's laws, single machines at its limits, a Taylor integration."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.guided.atwood_pulley_systems import Atwood
from gnomon.reference.guided.double_atwood import DoubleAtwood
from gnomon.reference.numerics.precision import exact

REST = (Fraction(0), Fraction(0))
MASSES = [("3", "1.5", "2"), ("1e8", "1.5", "2"), ("3", "1.5", "1e-8"), ("3.190000001", "1.1", "2.9")]


@pytest.mark.parametrize("masses", MASSES)
def test_tensions_accelerate_each_mass_and_balance_on_the_massless_pulley(masses):
    """Newton's second law of three masses, exactly in rational numbers."""
    machine = DoubleAtwood(REST, REST, *map(exact, ("9.81", *masses)))
    (pulley, relative), (upper, lower), g = machine.rates, machine.tensions, machine.g
    assert upper == 2 * lower
    assert machine.m1 * pulley == upper - machine.m1 * g
    assert machine.m2 * (pulley + relative) == machine.m2 * g - lower
    assert machine.m3 * (pulley - relative) == machine.m3 * g - lower


def test_equal_masses_on_the_movable_pulley_make_a_single_machine():
    """They do not move relative to the pulley, and weigh as one mass of 3 kg on a string without a heavy pulley."""
    double = DoubleAtwood(REST, REST, *map(exact, ("9.81", 2, "1.5", "1.5")))
    assert double.rates == (Atwood(REST[:1], REST[:1], *map(exact, ("9.81", 3, 2, 0, 1))).rate, 0)


@pytest.mark.parametrize("masses", MASSES)
def test_motion_is_the_integral_of_lagranges_equations(masses, taylor):
    """The generalised forces over the mass matrix of the kinetic energy, integrated by a Taylor series."""
    start, (m1, m2, m3) = ("0.3", "-0.2", "1.5", "-0.7"), map(exact, masses)
    motion = DoubleAtwood(tuple(map(exact, start[:2])), tuple(map(exact, start[2:])), exact("9.81"), m1, m2, m3)

    def rates(arithmetic, y):
        both, difference, forces = m2 + m3, m2 - m3, (m2 + m3 - m1, m2 - m3)
        determinant = (m1 + both) * both - difference**2
        pulley = exact("9.81") * (both * forces[0] - difference * forces[1]) / determinant
        relative = exact("9.81") * ((m1 + both) * forces[1] - difference * forces[0]) / determinant
        return y[2], y[3], arithmetic.mpf(pulley), arithmetic.mpf(relative)

    with mpmath.workdps(60):
        found, right = motion.state("2.7", 50), taylor(rates, start, "2.7")
        assert all(abs(a - b) < mpmath.mpf(10) ** -45 * (1 + abs(b)) for a, b in zip(found, right, strict=True))

"""Chain in a tube and pendulum on an accelerated support: the equation, and a Taylor integration of it."""

import mpmath
import pytest
from gnomon.reference.guided.chain_in_circular_tube import TubeChain
from gnomon.reference.numerics.precision import exact
from gnomon.reference.pendulums.moment_of_momentum_pendulum import CarriedPendulum

TUBES = {
    "default": TubeChain(*map(exact, (2, 0, "9.81", 2, 1))),
    "rotation": TubeChain(*map(exact, (0, 6, "9.81", 2, 1))),
    "neutral": TubeChain(*map(exact, (2, "1e-8", "9.81", 6.283185307179586, 1))),
}
CARRIED = {
    "default": CarriedPendulum(*map(exact, (1, 0, "9.81", 1, 3, 1))),
    "upside down": CarriedPendulum(*map(exact, (1, 0, "9.81", 1, 0, "-9.810981"))),
    "sideways": CarriedPendulum(*map(exact, (1, 8, "9.81", 1, "98.1", 0))),
}


def tube_rates(motion):
    # In mpmath for both arithmetics: the pull is a number, not part of the state.
    with mpmath.workdps(120):
        angle = mpmath.mpf(motion.length.numerator) / motion.length.denominator / 2 / motion.radius.numerator
        pull = exact(2 * mpmath.mpf(981) / 100 / (2 * angle) * mpmath.sin(angle))
    return lambda mp, y: (y[1], -mp.mpf(pull) * mp.sin(y[0]))


def carried_rates(motion):
    # cos as sin of the complement's double: sin(x + pi/2), pi to 120 digits
    with mpmath.workdps(120):
        quarter = exact(mpmath.pi / 2)
    along, across = (motion.g + motion.ay) / motion.length, motion.ax / motion.length
    return lambda mp, y: (y[1], -mp.mpf(along) * mp.sin(y[0]) - mp.mpf(across) * mp.sin(y[0] + mp.mpf(quarter)))


CASES = [
    *(pytest.param(motion, tube_rates(motion), id=f"tube {name}") for name, motion in TUBES.items()),
    *(pytest.param(motion, carried_rates(motion), id=f"carried {name}") for name, motion in CARRIED.items()),
]


@pytest.mark.parametrize(("motion", "rates"), CASES)
def test_equation_of_motion_is_satisfied(motion, rates, residual):
    with mpmath.workdps(120):
        assert residual(motion, rates, "1.3") < mpmath.mpf(10) ** -45


@pytest.mark.parametrize(("motion", "rates"), CASES)
def test_taylor_integration_arrives_at_the_same_state(motion, rates, taylor):
    there = taylor(rates, (motion.theta0, motion.omega0), "1.3")
    with mpmath.workdps(60):
        for found, right in zip(motion.state("1.3", 50), there, strict=True):
            assert abs(found - right) < mpmath.mpf(10) ** -46 * max(1, abs(right))


def test_a_short_chain_is_a_bead():
    """sin(x)/x = 1 - x^2/6: the tube's pendulum has the length R to 1e-13 for L = 1e-6 R."""
    motion = TubeChain(*map(exact, (2, 0, "9.81", "1e-6", 1)))
    with mpmath.workdps(30):
        bead = mpmath.sqrt(mpmath.mpf("9.81"))
        assert abs(motion.frequency(30) / bead - 1 + mpmath.mpf("1e-12") / 48) < 1e-25

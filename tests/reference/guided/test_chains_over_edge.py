"""Chains over an edge: the equations of both phases, and a Taylor integration up to the end."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.guided.chains_over_edge import SlidingChain
from gnomon.reference.numerics.precision import exact

G = Fraction("9.81")


def chain(mu, s, v):
    return SlidingChain(G * (1 + mu), mu / (1 + mu), Fraction(1), G, exact(s), exact(v))


CASES = [
    pytest.param(chain(Fraction(0), "0.3", 0), id="smooth"),
    pytest.param(chain(Fraction(0), "1e-12", 0), id="hair"),
    pytest.param(chain(Fraction(3, 10), "0.4", "0.5"), id="friction"),
    pytest.param(chain(Fraction(1), 0.5000000000000001, 0), id="above the limit"),
]


@pytest.mark.parametrize("motion", CASES)
def test_both_phases_satisfy_their_equation(motion, residual):
    end = exact(motion.end_time(30))
    pull, centre = motion.square, motion.centre
    assert residual(motion, lambda mp, y: (y[1], mp.mpf(pull) * (y[0] - mp.mpf(centre))), end / 2) < 1e-45
    assert residual(motion, lambda mp, y: (y[1], mp.mpf(G)), end * 2) < 1e-45


@pytest.mark.parametrize("motion", CASES)
def test_taylor_integration_reaches_the_end_at_the_leaving_time(motion, taylor):
    """Errors of the time appear in s with the speed there, 3 m/s."""
    pull, centre = motion.square, motion.centre
    there = taylor(
        lambda mp, y: (y[1], mp.mpf(pull) * (y[0] - mp.mpf(centre))), (motion.s0, motion.v0), motion.end_time(60)
    )
    with mpmath.workdps(60):
        assert abs(there[0] - 1) < mpmath.mpf(10) ** -44
        assert abs(there[1] - motion.end_speed(50)) < mpmath.mpf(10) ** -44


def test_exactly_at_the_limit_of_friction_the_chain_rests():
    motion = chain(Fraction(1), "0.5", 0)
    assert motion.rests
    assert motion.state(1000) == (mpmath.mpf("0.5"), 0)
    assert motion.end_time() == mpmath.inf

"""States of many pendulums equal the states of each exact motion, to 0.51 ulp."""

import numpy as np
import pytest
from gnomon.reference.pendulums.pendulum_ensemble import states
from gnomon.reference.pendulums.pendulum_simple import Pendulum
from many_motions import worst_ulps

NEAREST = 0.51
"""Half an ulp is the nearest double; the formulas have 40 bits more."""
TIMES = np.array([0.0, 1e-9, 0.5, 22.3, 5000.25])


def test_random_pendulums() -> None:
    random = np.random.default_rng(1)
    parameters = random.uniform(0.1, 10, (25, 2))
    starts = random.uniform((-20, -8), (20, 8), (25, 2))
    worst, known = worst_ulps(states, Pendulum, parameters, starts, TIMES)
    assert known.all()
    assert worst <= NEAREST


def test_hard_pendulums() -> None:
    """Tiny swings, starts on a zero of sn, cn or dn, many turns, both sides of the separatrix, one turn after another."""
    starts = [(1e-9, 0), (0, 1e-90), (2, 0), (-2, 0), (0, 1), (0, 30), (0, -30), (np.pi, 1), (-np.pi, 1e-3), (100, 3)]
    starts += [(3 * np.pi, -0.5), (3.1415, 0), (0, 2 * (1 + 1e-5)), (0, 2 * (1 - 1e-5)), (7, 0), (-13, 2.5)]
    parameters = np.ones((len(starts), 2))
    whole_turns = np.array([2 * np.pi * k / 30 for k in (1, 2, 100)])  # about a turn of those at 30 rad/s
    worst, known = worst_ulps(
        states, Pendulum, parameters, np.array(starts, dtype=float), np.append(TIMES[:4], whole_turns)
    )
    assert known.all()
    assert worst <= NEAREST


@pytest.mark.parametrize("omega", [0.0, 2.0, 2 * (1 + 1e-13), 2 * (1 - 1e-13)])
def test_what_the_formulas_cannot_do_is_not_called_known(omega: float) -> None:
    """At rest, on the separatrix, and so near to it that 106 bits of 1 - m do not give the phase."""
    _, known = states(np.ones((1, 2)), np.array([[0.0, omega]]), np.array([22.3]))
    assert not known.any()

"""States of many Kepler orbits equal the states of each exact motion, on every conic."""

import numpy as np
from gnomon.cases.orbits.kepler_orbit import pericentre_start
from gnomon.reference.orbits.kepler_ensemble import states
from gnomon.reference.orbits.kepler_orbit import Kepler
from many_motions import worst_ulps

NEAREST = 0.51
"""Half an ulp is the nearest double; the formulas have 30 bits more."""
TIMES = np.array([0.0, 1e-9, 0.5, 65.15, 5000.25])


def test_random_orbits() -> None:
    """In the case's typical ranges: half of them are ellipses."""
    random = np.random.default_rng(1)
    starts = random.uniform((0.5, -0.4, -0.5, 0.5), (2.0, 0.4, 0.5, 2.0), (20, 4))
    worst, known = worst_ulps(states, Kepler, random.uniform(0.5, 2, (20, 1)), starts, TIMES)
    assert known.all()
    assert worst <= NEAREST


def test_hard_orbits() -> None:
    """Close pericentres, the parabola and its neighbours, a fast flyby, a circle, a start at the apocentre."""
    starts = [tuple(map(float, pericentre_start(e))) for e in (0.0, 0.9, 0.999)]
    starts += [(1, 0, 0, np.sqrt(2)), (1, 0, 0, 1.4142), (1, 0, 0, 1.4143), (-20, 0.5, 15, 0), (1.999, 0, 0, 0.03)]
    starts += [(-2.0, 1.0, 1.0, 0.25)]
    worst, known = worst_ulps(states, Kepler, np.ones((len(starts), 1)), np.array(starts, dtype=float), TIMES)
    assert known.all()
    assert worst <= NEAREST


def test_what_the_formulas_cannot_do_is_not_called_known() -> None:
    """A start in the centre, a radial fall that ends in it, and numbers that overflow."""
    starts = np.array([(0, 0, 1, 1), (1, 0, 0, 0), (1e300, 0, 0, 1e300)], dtype=float)
    _, known = states(np.ones((3, 1)), starts, np.array([65.15]))
    assert not known.any()

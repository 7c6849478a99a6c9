"""States of many projectiles equal the states of each exact motion."""

import numpy as np
from gnomon.reference.flight.projectile_ensemble import states
from gnomon.reference.flight.projectile_parabola import Projectile
from many_motions import worst_ulps


def test_random_projectiles() -> None:
    """Next to the ground y + vy t - g t^2 / 2 cancels."""
    random = np.random.default_rng(1)
    starts, g = random.uniform(-10, 10, (30, 4)), random.uniform(0, 20, (30, 1))
    starts[0], g[0] = (0, 0, 1, 15), 10.0
    worst, known = worst_ulps(states, Projectile, g, starts, np.array([0.0, 1e-9, 3.0 - 2.0**-40, 1e4]))
    assert known.all()
    assert worst <= 0.51

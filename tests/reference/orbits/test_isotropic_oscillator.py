"""The isotropic oscillator: area law, semi-axes as extreme distances."""

import mpmath
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.isotropic_oscillator import IsotropicOscillator


def test_semi_axes_are_the_extreme_distances():
    motion = IsotropicOscillator(*map(exact, (1, 4, 1, 0, "0.5", "1.2")))
    with mpmath.workdps(50):
        large, small = motion.semi_axes(45)
        distances = []
        for k in range(200):
            x, y, vx, vy = motion.state(mpmath.pi * k / 200, 45)
            assert abs(x * vy - y * vx - mpmath.mpf("1.2")) < mpmath.mpf(10) ** -40
            assert abs(vx**2 + vy**2 + 4 * (x**2 + y**2) - 4 * (large**2 + small**2)) < mpmath.mpf(10) ** -40
            distances.append(mpmath.hypot(x, y))
        # 200 points of a cosine: off the extreme by (pi/200)^2/2 at most
        assert 0 <= large - max(distances) < 1e-3
        assert 0 <= min(distances) - small < 1e-3

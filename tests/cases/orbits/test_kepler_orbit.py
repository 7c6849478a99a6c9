import math

import gnomon.cases as cases
import numpy as np
import pytest
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.orbits.kepler_orbit import KeplerOrbit, attraction, bodies, relative, sundman_equations
from gnomon.reference.numerics.precision import working

VARIANTS = [None, *(variant.name for variant in KeplerOrbit.variants)]


def test_the_default_is_e06_and_the_variants_have_their_eccentricity():
    for variant, e in [(None, 0.6), ("e09", 0.9), ("e0999", 0.999), ("e0999999", 0.999999), ("speed_e099", 0.99)]:
        found = cases.get("kepler_orbit", variant).quantities()
        # e = r v^2 / mu - 1 with the rounded v: an error of two half ulps.
        assert float(found["eccentricity"]) == pytest.approx(e, abs=4e-16)
        # a = r / (1 - e): that error over 1 - e.
        assert float(found["semi_major_axis"]) == pytest.approx(1, abs=1e-15 / (1 - e))


@pytest.mark.parametrize("variant", VARIANTS)
def test_no_sample_leaves_the_scales(variant):
    """On a grid that resolves the pericentre, distance and speed reach the scale and never exceed it."""
    case = cases.get("kepler_orbit", variant)
    scales = case.scales()
    motion = case.motion()
    end = float(case.times[-1])
    grid = np.linspace(0, end, 200)
    if motion.angular_momentum:
        near = float(motion.pericentre_time()) + case.time_scale * np.linspace(-2e-9, 2e-9, 9)
        grid = np.concatenate([grid, near[(near >= 0) & (near <= end)]])
    states = motion.sample_each(grid)
    assert np.max(np.hypot(states[:, 0], states[:, 1])) == pytest.approx(scales["length"], rel=0.02)
    assert np.max(np.hypot(states[:, 0], states[:, 1])) <= scales["length"] * (1 + 1e-15)
    assert np.max(np.hypot(states[:, 2], states[:, 3])) <= scales["velocity"] * (1 + 1e-15)
    if variant != "e0999999":  # at 1e-9 of the period from the pericentre the speed is still below its peak
        assert np.max(np.hypot(states[:, 2], states[:, 3])) == pytest.approx(scales["velocity"], rel=0.02)


def test_sundman_equations_push_forward():
    """d(state)/ds = r d(state)/dt and dt/ds = r, at a random state in mpmath."""
    with working(40) as mp:
        arithmetic = mpmath_arithmetic(mp)
        x, y, vx, vy, mu = map(mp.mpf, ("0.31", "-0.72", "0.44", "1.7", "1.3"))
        ax, ay = rebind(attraction, arithmetic)(0, (x, y), (mu,))
        r = mp.hypot(x, y)
        found = rebind(sundman_equations, arithmetic)(0, (x, y, vx, vy, mp.mpf(0)), (mu,))
        for a, b in zip(found, (r * vx, r * vy, r * ax, r * ay, r), strict=True):
            assert mp.almosteq(a, b, mp.mpf("1e-38"))


def test_sundman_formulation_carries_time():
    case = cases.get("kepler_orbit")
    (sundman,) = case.formulations
    with working(30) as mp:
        start = sundman.encode(mp, tuple(map(mp.mpf, case.initial_state)), (mp.mpf(1),))
    assert start[sundman.clock] == 0
    assert len(start) == 5
    np.testing.assert_array_equal(sundman.decode(np.arange(10.0).reshape(2, 5), (1.0,)), [[0, 1, 2, 3], [5, 6, 7, 8]])
    # A whole period takes s = 2 pi a / sqrt(mu a) = 2 pi.
    period = case.quantities(30)["period"]
    assert float(sundman.independent(period, 30)) == pytest.approx(2 * math.pi, rel=1e-15)


def test_bodies_are_converted_back_to_the_state():
    state = (0.3, 0.4, -1.0, 2.0)
    assert relative(bodies(state)) == state


def test_a_span_through_the_collision_is_refused():
    with pytest.raises(ValueError, match=r"reaches the collision at 1\.11072073"):
        cases.get("kepler_orbit", "plunge", span=2)


def test_samples_at_a_million_times_are_right():
    """The fast way to sample agrees with high precision at a few of the times."""
    for variant in ("orbits_1e4",):
        case = cases.get("kepler_orbit", variant)
        times = np.random.default_rng(5).uniform(0, float(case.span), 4096)
        found = case.sample(times)
        chosen = np.arange(0, 4096, 97)
        np.testing.assert_array_equal(found[chosen], case.motion().sample_each(times[chosen]))

import gnomon.cases as cases
import numpy as np
import pytest
from gnomon.cases.flight.projectile_parabola import ProjectileParabola

VARIANTS = [None, *(variant.name for variant in ProjectileParabola.variants)]


@pytest.mark.parametrize("variant", VARIANTS)
def test_samples_are_the_nearest_doubles(variant):
    case = cases.get("projectile_parabola", variant)
    found = case.sample(case.times)
    motion = case.motion()
    expected = [[float(value) for value in motion.rational(float(t))] for t in case.times]
    np.testing.assert_array_equal(found, expected)


def test_the_engines_variant_is_a_throw_at_ten_metres_per_second():
    case = cases.get("projectile_parabola", "engines")
    _x, _y, vx, vy = case.initial_state
    assert vx**2 + vy**2 == 100
    assert case.span == 1


def test_quantities():
    found = cases.get("projectile_parabola", g=10).quantities(30)
    assert float(found["apex_time"]) == 1.5
    assert float(found["apex_height"]) == 11.25
    assert float(found["landing_time"]) == 3
    assert float(found["landing_x"]) == float(found["range"]) == 60
    # of all throws at 25 m/s: v^2/(2 g) straight up, v^2/g at 45 degrees
    assert float(found["highest_apex"]) == 31.25
    assert float(found["farthest_range"]) == 62.5
    # far from the origin the range keeps its digits
    far = cases.get("projectile_parabola", g=10, initial_state=(10**20, 0, 20, 15)).quantities()
    assert float(far["range"]) == 60
    assert cases.get("projectile_parabola", g=0).quantities() == {}


def test_conditioning_follows_the_powers_of_time():
    # d(y) = dv t and dg t^2 / 2: over a long fall the error of gravity's half ulp grows as t^2 over a scale g T^2 / 2.
    case = cases.get("projectile_parabola", "long_fall").rounded()
    early, late = case.conditioning(np.array([case.times[31], case.times[63]]))
    # Twice the time: four times the effect of g in y, twice the effect of time's own ulp relative to y.
    assert 2 < late / early < 4.5
    assert late < 4 * np.finfo(float).eps

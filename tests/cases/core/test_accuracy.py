import math
from fractions import Fraction

import gnomon.cases as cases
import numpy as np
import pytest
from gnomon.cases.core import accuracy
from gnomon.reference.storage import diskcache


@pytest.fixture(autouse=True)
def own_cache(monkeypatch, tmp_path):
    monkeypatch.setattr(diskcache, "folder", lambda: tmp_path)


def test_conditioning_of_a_known_motion():
    """y = v t - g t^2 / 2: each effect is a product in closed form."""
    case = cases.get("projectile_parabola", initial_state=(0, 0, 0, 1), g=1, span=4)
    t = np.array([3.0])
    half = {"v": math.ulp(1.0) / 2, "g": math.ulp(1.0) / 2, "t": math.ulp(3.0) / 2}
    scales = case.scales()
    effects = {
        "v": (half["v"] * 3, half["v"]),
        "g": (half["g"] * 4.5, half["g"] * 3),
        "t": (half["t"] * abs(1 - 3), half["t"]),
    }
    expected = math.sqrt(sum(max(y / scales["length"], v / scales["velocity"]) ** 2 for y, v in effects.values()))
    assert case.conditioning(t)[0] == pytest.approx(expected, rel=1e-12)


def test_conditioning_of_an_angle_keeps_its_digits():
    """theta = 1e-3 cos t for a short time: half its ulp is far below half an ulp of 2 pi; it must stay so."""
    case = cases.get("pendulum_simple", initial_state=(2.0**-10, 0), g=1, L=1, span=1).rounded()
    half = {"theta": math.ulp(2.0**-10) / 2, "g": math.ulp(1.0) / 2, "t": math.ulp(0.5) / 2}
    sine, cosine, size = math.sin(0.5), math.cos(0.5), 2.0**-10
    slow = size * 0.5 / 2  # the frequency is sqrt(g/L), so its relative change is half the relative change of g
    scales = case.scales()
    effects = [
        (half["theta"] * cosine, half["theta"] * sine),
        *[(half["g"] * slow * sine, half["g"] * (slow * cosine + size * sine / 2))] * 2,
        (half["t"] * size * sine, half["t"] * size * cosine),
    ]
    expected = math.sqrt(sum(max(a / scales["angle"], v / scales["angular velocity"]) ** 2 for a, v in effects))
    # the pendulum is linear up to the amplitude squared; the effects of L and g are opposite and of the same size
    assert case.conditioning(np.array([0.5]))[0] == pytest.approx(expected, rel=1e-3)


def test_a_phase_error_grows_with_time():
    """Kepler orbit: half an ulp in the energy changes the period, so the error grows with the number of orbits."""
    case = cases.get("kepler_orbit", initial_state=(1, 0, 0, 1.25)).rounded()
    period = float(case.quantities()["period"])
    times = np.array([10.2, 100.2]) * period
    early, late = case.conditioning(times)
    assert late / early == pytest.approx(100.2 / 10.2, rel=0.02)


def test_errors_grow_exponentially_close_to_the_upright_pendulum():
    """From an angle d from upright the angle is d cosh(w t): an ulp of it grows by e per time unit, w = 1."""
    case = cases.get("pendulum_simple", initial_state=(math.pi - 1e-6, 0), g=1, L=1, span=12).rounded()
    early, late = case.conditioning(np.array([5.0, 8.0]))
    assert late / early == pytest.approx(math.exp(3), rel=0.05)


def test_a_number_at_the_edge_of_the_domain_is_changed_inward():
    # I1 + I2 = I3 exactly: no body has I3 + half an ulp.
    case = cases.get("euler_top", "flat").rounded()
    perturbed = [neighbour.parameters for neighbour in accuracy._neighbours(case)]
    assert {p["I3"] for p in perturbed if p["I3"] != 3} == {3 - Fraction(math.ulp(3.0)) / 2}
    assert np.all(case.conditioning(case.times[:2]) > 0)


def test_a_zero_is_not_changed():
    case = cases.get("projectile_parabola", initial_state=(0, 0, 0, 1), g=1)
    assert len(accuracy._neighbours(case)) == 2


def test_floor_is_half_an_ulp_of_the_state():
    case = cases.get("projectile_parabola", initial_state=(1, 0, 0, 0), g=0, span=1)
    # x = 1 with scale 1 at all times: half the spacing of doubles above 1.
    assert case.floor(np.array([0.5]))[0] == 2.0**-53


def test_scales_of_a_group_that_stays_zero():
    case = cases.get("projectile_parabola", initial_state=(0, 0, 0, 0), g=0, span=1)
    assert case.scales() == {"length": 1.0, "velocity": 1.0}


def test_results_are_kept_and_found_again(monkeypatch):
    case = cases.get("projectile_parabola")
    first = case.conditioning(case.times)

    def forbidden(*_):
        raise AssertionError("computed again")

    monkeypatch.setattr(accuracy, "_conditioning", forbidden)
    np.testing.assert_array_equal(cases.get("projectile_parabola").conditioning(case.times), first)
    with pytest.raises(AssertionError, match="computed again"):
        cases.get("projectile_parabola", g="9.80665").conditioning(case.times)
    with pytest.raises(AssertionError, match="computed again"):
        case.conditioning(case.times[:32])


def test_what_is_scored_is_part_of_the_key():
    """With the same numbers but all groups scored: rates alone are better conditioned than rates and attitude."""
    speed = cases.get("euler_top", "speed", span=100)
    times = np.array([90.0])
    whole = cases.get("euler_top", initial_state=speed.initial_state, span=100, **speed.parameters)
    assert whole.conditioning(times)[0] > speed.conditioning(times)[0]


def test_roundings_of_later_states_count_if_the_start_has_a_finer_ulp():
    """1e-12 rad from the unstable bottom the energy is within 1e-24 of the saddle's: one rounding at full swing decides.

    A start whose ulp is like the ulp of later states is not restarted.
    """
    case = cases.get("rotating_pendulum", "near_homoclinic").rounded()
    times = case.times[3::8]
    found = accuracy._conditioning(case, times)
    period = float(case.quantities()["period"])
    assert np.all(found[times < 0.45 * period] < 1e-12)
    assert np.max(found[times > period]) > 0.1
    usual = cases.get("rotating_pendulum").rounded()
    assert not accuracy._coarser(usual, [usual.exact(t, 28) for t in usual.times.tolist()])

import gnomon.cases as cases
import numpy as np
import pytest
from gnomon.cases.rigid_bodies.euler_top import EulerTopCase
from gnomon.harness.certification.certify import certify
from gnomon.reference.numerics.precision import nearest_double

VARIANTS = [None, *(variant.name for variant in EulerTopCase.variants)]


@pytest.mark.parametrize("variant", [None, "separatrix", "near_symmetric", "oblate", "sphere", "flips_1e12"])
def test_certified_by_residual_taylor_and_invariants(variant):
    certificate = certify(cases.get("euler_top", variant, span=2))
    assert certificate.passed
    assert set(certificate.ways) == {"rounding", "residual", "taylor", "ball", "invariants"}


@pytest.mark.parametrize("variant", VARIANTS)
def test_samples_are_the_nearest_doubles(variant):
    case = cases.get("euler_top", variant)
    times = case.times[[0, 31, 63]]
    expected = [[nearest_double(value) for value in case.exact(float(t), 60)] for t in times]
    np.testing.assert_array_equal(case.sample(times), expected)


@pytest.mark.parametrize("variant", [v for v in VARIANTS if v != "engines"])
def test_sample_phases_leave_no_gap(variant):
    case = cases.get("euler_top", variant)
    found = case.quantities()
    rates = [float(found["precession_rate"]) / (2 * np.pi)]
    if "body_period" in found:
        rates.append(1 / float(found["body_period"]))
    for rate in rates:
        turns = case.times * rate
        if turns[-1] > 1:
            phases = np.sort(np.mod(turns, 1))
            assert np.max(np.diff(np.append(phases, phases[0] + 1))) < 0.1


def test_the_tumbling_body_flips():
    case = cases.get("euler_top", "flips_1e6")
    flip = float(case.quantities()["flip_interval"])
    rates = case.sample(np.array([0.0, flip, 2 * flip]))[:, 1]
    # After each interval w2 is reversed, up to the rounding of the time times the rate of w2, 1e-12 here.
    np.testing.assert_allclose(rates, [1, -1, 1], atol=1e-9)


def test_the_separatrix_ends_on_the_unstable_axis():
    case = cases.get("euler_top", "separatrix")
    assert case.motion().kind == "separatrix"
    assert case.rounded().motion().kind == "separatrix"
    w1, w2, w3 = (abs(float(value)) for value in case.exact(12)[:3])
    assert w1 < 1e-7
    assert w3 < 1e-7
    assert w2 == pytest.approx(float(case.quantities()["precession_rate"]), rel=1e-14)


def test_speed_scores_rates_only():
    case = cases.get("euler_top", "speed")
    exact = case.sample(case.times)
    turned = exact.copy()
    turned[:, 3:] = 0
    assert np.max(case.metric.distance(turned, exact)) == 0
    assert np.max(cases.get("euler_top", "flat").metric.distance(turned, exact)) > 0.5
    assert float(case.span) == pytest.approx(100.37 * float(case.quantities()["body_period"]), rel=1e-15)


def test_conditioning_grows_exponentially_on_the_separatrix():
    """Two e-foldings per unit of p t: p = sqrt((I3-I2)(L^2-2T I1)/(I1 I2 I3)) = 1.6159 per second."""
    case = cases.get("euler_top", "separatrix").rounded()
    early, late = case.conditioning(np.array([6.0, 8.0]))
    assert late / early == pytest.approx(np.exp(1.6159 * 2), rel=0.1)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"I3": 6}, "triangle inequality"),
        ({"I1": 0}, "I1 = 0 is outside"),
        ({"I4": 1}, "did you mean"),
        ({"initial_state": (1, 2, 3)}, "has 3 numbers, not 12"),
    ],
)
def test_bad_numbers_are_named(numbers, message):
    with pytest.raises(ValueError, match=message):
        cases.get("euler_top", **numbers)

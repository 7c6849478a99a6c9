import gnomon.cases as cases
import numpy as np
import pytest


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


def test_the_published_brick_of_nasa_ends_at_its_rates():
    """NASA/TM-2015-218675, check case 2: inertial rates (deg/s) at 30 s in Atmos_02_sim_05.csv, as a public digest of the
    report and its files quotes them. The report says that its five simulators agree within 0.004 deg/s."""
    case = cases.get("euler_top", "nasa_brick")
    rates = np.degrees([float(x) for x in case.exact(30)[:3]])
    np.testing.assert_allclose(rates, [12.61842377, -17.3974441, 31.11960301], atol=1e-4)

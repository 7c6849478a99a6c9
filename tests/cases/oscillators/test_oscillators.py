"""Properties of pendulum, springs and cycloid beyond the properties of every case."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from breadth import tenth
from gnomon.cases import case_class, get
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.reference.numerics.precision import working

OSCILLATORS = ("pendulum_simple", "harmonic_oscillator", "duffing_unforced", "damped_oscillator", "cycloidal_pendulum")
VARIANTS = [(name, variant.name) for name in OSCILLATORS for variant in case_class(name).variants]


@pytest.mark.parametrize(
    ("name", "variant"), [row for name in OSCILLATORS for row in tenth(each for each in VARIANTS if each[0] == name)]
)
def test_scales_are_the_largest_norms(name, variant):
    """No sample exceeds the scale, and one of a fine grid comes close to it. A tenth of the variants of each case in
    `make test`: a case has one formula for all."""
    case = get(name, variant).rounded()
    fine = case.sample(np.linspace(0, float(case.times[-1]), 501))
    for group in case.metric.groups:
        largest = np.linalg.norm(fine[:, list(group.indices)], axis=1).max()
        limit = math.pi if group.wrapped else math.inf
        # Samples of the coarse grid miss a peak between them by a few per cent at most.
        assert 0.9 * min(largest, limit) <= group.scale <= min(1.1 * largest, limit) or group.scale == limit


def test_engine_times_are_decimal():
    case = get("pendulum_simple", "engines").rounded()
    hundredths = np.round(case.times * 100)
    assert np.array_equal(case.times, hundredths / 100)
    assert np.all(np.diff(hundredths) > 0)
    ideal = float(case.span) * np.arange(1, 65) / 64
    assert np.abs(case.times - ideal).max() <= 0.005 + 1e-12
    assert case.times[-1] == pytest.approx(10 * float(case.quantities()["period"]), abs=0.005)


def test_speed_variant_has_the_published_numbers():
    case = get("pendulum_simple", "speed")
    assert case.numbers == {"g": 1, "L": 1, "theta": Fraction(5, 2), "omega": 0}
    assert float(case.span / Fraction(float(case.quantities(20)["period"]))) == pytest.approx(100.37)


@pytest.mark.parametrize(
    ("variant", "gap"), [("near_separatrix_below", 1e-12), ("near_separatrix_above", -1e-12), ("upright", 2.5e-25)]
)
def test_variants_of_the_pendulum_are_as_close_to_the_separatrix_as_they_say(variant, gap):
    """Rounding the numbers to binary64 changes 1 - m by 1e-4 of itself, the upright start by 2e-4."""
    for case in (get("pendulum_simple", variant), get("pendulum_simple", variant).rounded()):
        assert float(case.quantities()["one_minus_modulus_squared"]) == pytest.approx(gap, rel=1e-3)


def test_rounded_case_moves_as_the_rounded_numbers_do():
    """Close to the separatrix a decimal number and the double nearest to it give different motions."""
    given = get("pendulum_simple", "near_separatrix_below")
    rounded = given.rounded()
    assert all(Fraction(float(x)) == x for x in rounded.numbers.values())
    same = get("pendulum_simple", initial_state=[0.0, float("1.999999999999")], g=9.81, L=9.81)
    assert rounded.exact(150, 30) == same.exact(150, 30)
    assert abs(given.exact(150, 30)[0] - rounded.exact(150, 30)[0]) > 1e-6


@pytest.mark.parametrize("amplitude", ["1e-3", "1e-2", "0.1"])
def test_small_swings_are_harmonic_to_the_amplitude_squared(amplitude):
    """theta - harmonic = O(a^3) over a few periods: the frequencies differ by a^2/16."""
    case = get("pendulum_simple", initial_state=[amplitude, 0])
    linear, quartic = (level.case for level in case.hierarchy)
    t = Fraction(7)
    a = mpmath.mpf(amplitude)
    exact = case.exact(t, 30)[0]
    w = math.sqrt(9.81)
    first = abs(linear.exact(t, 30)[0] - exact) / a
    second = abs(quartic.exact(t, 30)[0] - exact) / a
    assert 0.01 * a**2 < first < w * 7 * a**2 / 16 + a**2
    # The next term of the sine, theta^5/120, changes the frequency by a^4/384.
    assert second < w * 7 * a**4 / 384 + a**4


def test_hierarchy_excludes_models_that_do_not_apply():
    """Beyond sqrt(6) the quartic potential decreases; in a rotation the angle is not small."""
    assert [level.case.name for level in get("pendulum_simple", "engines").hierarchy] == ["harmonic_oscillator"]
    assert get("pendulum_simple", "rotation").hierarchy == ()


@pytest.mark.parametrize("variant", [None, "small", "wide", "launched", "near_cusp", "nearer_cusp", "cusp_to_cusp"])
def test_cycloid_is_isochronous(variant):
    case = get("cycloidal_pendulum", variant)
    assert case.quantities(40)["period"] == get("cycloidal_pendulum").quantities(40)["period"]


@pytest.mark.parametrize("variant", [None, "small", "wide", "launched", "near_cusp"])
@pytest.mark.parametrize("t", ["0.3", "5.1", "17"])
def test_arc_length_pushes_forward_to_the_angle(variant, t):
    """The encoded exact state moves by the formulation's equations, and decodes to the state."""
    case = get("cycloidal_pendulum", variant).rounded()
    (arc,) = case.formulations
    (form,) = arc.forms
    h = Fraction(1, 10**25)
    with working(100) as mp:
        parameters = tuple(mp.mpf(v) for v in case.parameter_values())
        before, here, after = (
            arc.encode(mp, [mp.mpf(x) for x in case.exact(Fraction(t) + d, 90)], parameters) for d in (-h, 0, h)
        )
        acceleration = rebind(form.acceleration, mpmath_arithmetic(mp))(mp.mpf(0), here[:1], parameters)[0]
        # differences over 1e-25 have an error of 1e-50 w^3; close to the cusp 1 - sin^2 loses 8 digits of the rate
        assert abs((after[0] - before[0]) / (2 * mp.mpf(h)) - here[1]) < mp.mpf(10) ** -42
        assert abs((after[1] - before[1]) / (2 * mp.mpf(h)) - acceleration) < mp.mpf(10) ** -42
    decoded = arc.decode(np.array([[float(x) for x in here]]), [float(v) for v in case.parameter_values()])[0]
    state = case.exact(t)
    # Rounding s changes the angle by an ulp over cos(phi/2), the rate by an ulp over its square.
    cosine = math.cos(float(state[0]) / 2)
    assert decoded == pytest.approx([float(x) for x in state], rel=1e-14 / cosine**2)


def test_a_start_at_the_cusp_has_the_full_arc_length():
    case = get("cycloidal_pendulum", "cusp_to_cusp").rounded()
    (arc,) = case.formulations
    with working(60) as mp:
        state = [mp.mpf(x) for x in case.initial_state]
        s, rate = arc.encode(mp, state, [mp.mpf(v) for v in case.parameter_values()])
    assert (float(s), float(rate)) == (1.0, 0.0)
    assert np.isnan(arc.decode(np.array([[1.0001, 0.0]]), [0.25, 9.81])).any()


def test_exactly_critical_is_exactly_critical():
    case = get("damped_oscillator", "critical").rounded()
    quantities = case.quantities(30)
    assert quantities["slow_rate"] == quantities["fast_rate"] == 2
    assert quantities["damping_ratio"] == 1


@pytest.mark.parametrize(("variant", "rate"), [("stiff_1e6", 6), ("stiff_1e9", 9), ("stiff_1e12", 12)])
def test_stiff_rates(variant, rate):
    quantities = get("damped_oscillator", variant).rounded().quantities(30)
    assert (quantities["slow_rate"], quantities["fast_rate"]) == (1, 10**rate)


def test_escape_energy_is_that_of_the_heteroclinic_motion():
    """With a softening spring the motion escapes above the energy of the potential's maxima, which the variant has exactly."""
    found = get("duffing_unforced", "heteroclinic").quantities()
    assert found["escape_energy"] == found["energy"] == 0.5
    assert "escape_energy" not in get("duffing_unforced").quantities()

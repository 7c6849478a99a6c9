import math

import gnomon.cases as cases
import numpy as np
import pytest
from gnomon.cases.pendulums.foucault_pendulum_linear import FoucaultLinear
from gnomon.harness.certification.certify import certify
from gnomon.reference.numerics.precision import nearest_double

VARIANTS = [None, *(variant.name for variant in FoucaultLinear.variants)]


@pytest.mark.parametrize("name", ["foucault_pendulum_linear", "foucault_precession"])
def test_certified_by_residual_taylor_and_invariants(name):
    certificate = certify(cases.get(name, span=60))
    assert certificate.passed
    assert {"rounding", "residual", "invariants"} < set(certificate.ways)
    assert {"taylor", "windows"} & set(certificate.ways)


@pytest.mark.parametrize("variant", ["turntable"])
def test_certified_variants(variant):
    assert certify(cases.get("foucault_pendulum_linear", variant, span=3)).passed


@pytest.mark.parametrize("variant", VARIANTS)
def test_samples_are_the_nearest_doubles(variant):
    case = cases.get("foucault_pendulum_linear", variant)
    times = case.times[[0, 31, 63]]
    expected = [[nearest_double(value) for value in case.exact(float(t), 60)] for t in times]
    np.testing.assert_array_equal(case.sample(times), expected)


@pytest.mark.parametrize("variant", VARIANTS)
def test_scales_are_reached_and_not_passed(variant):
    case = cases.get("foucault_pendulum_linear", variant)
    scales = case.scales()
    swing = float(case.quantities()["swing_period"])
    states = case.motion().sample_each(np.linspace(0, min(swing, float(case.span)), 129))
    for name, part in (("length", states[:, :2]), ("velocity", states[:, 2:])):
        norms = np.linalg.norm(part, axis=1)
        assert np.max(norms) <= scales[name] * (1 + 1e-14)
        # Within half a grid step, swing / 256, of a peak: 1 - cos(pi / 128).
        assert np.max(norms) >= scales[name] * math.cos(math.pi / 128)


@pytest.mark.parametrize("variant", VARIANTS)
def test_sample_phases_leave_no_gap(variant):
    case = cases.get("foucault_pendulum_linear", variant)
    motion = case.motion()
    for rate in (abs(float(2 * math.pi / motion.swing_period())), abs(float(motion.precession_rate()))):
        turns = case.times * rate / (2 * math.pi)
        if turns[-1] > 1:
            phases = np.sort(np.mod(turns, 1))
            assert np.max(np.diff(np.append(phases, phases[0] + 1))) < 0.1


def test_the_ladder_climbs_to_the_case():
    case = cases.get("foucault_pendulum_linear", span=20, L=1, Om="0.3")
    exact = case.sample(case.times)
    errors = []
    for level in case.hierarchy:
        assert level.case.span == case.span
        errors.append(float(np.max(case.metric.distance(level.project(level.case.sample(case.times)), exact))))
    assert len(errors) == 2
    assert errors[0] > 10 * errors[1] > 0


def test_for_slow_rotation_the_rung_misses_the_second_order_only():
    # s - w0 = W^2 / (2 w0): the phase error is that times t.
    case = cases.get("foucault_pendulum_linear", span=3600)
    turn = 7.292115e-5 * math.sin(0.8526)
    phase = turn**2 / (2 * math.sqrt(9.81 / 67)) * float(case.times[-1])
    precession = case.hierarchy[1].case
    # The rounding of the samples, some 1e-16, is far below the phase of 1e-5.
    error = np.max(case.metric.distance(precession.sample(case.times), case.sample(case.times)))
    # At rest in the turning Earth is V0 = 0 for both; their amplitudes differ by W/w0, times W/w0 again here.
    assert error == pytest.approx(phase, rel=0.2)


def test_reversal():
    case = cases.get("foucault_pendulum_linear", "turntable")
    state = case.sample(np.array([7.0]))[0]
    back, parameters = case.reversed(state)
    found = case.with_numbers(back, parameters).sample(np.array([7.0]))[0]
    # Rounding of the state, times the ratio of the two radii's scales: some tens of ulps.
    np.testing.assert_allclose(found[:2], [0.1, 0], atol=1e-15)
    np.testing.assert_allclose(found[2:], 0, atol=1e-14)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [({"L": 0}, "L = 0 is outside"), ({"lat": 2}, "lat = 2 is outside"), ({"latitude": 1}, "no parameter 'latitude'")],
)
def test_bad_numbers_are_named(numbers, message):
    with pytest.raises(ValueError, match=message):
        cases.get("foucault_pendulum_linear", **numbers)

import math

import gnomon.cases as cases
import numpy as np
import pytest
from gnomon.cases.pendulums.foucault_pendulum_linear import FoucaultLinear

VARIANTS = [None, *(variant.name for variant in FoucaultLinear.variants)]


@pytest.mark.parametrize("variant", VARIANTS)
def test_scales_are_reached_and_not_passed(variant):
    case = cases.get("foucault_pendulum_linear", variant)
    scales = case.scales()
    swing = float(case.quantities()["swing_period"])
    states = case.motion().sample_each(np.linspace(0, min(swing, float(case.span)), 129))
    for name, part in (("length", states[:, :2]), ("velocity", states[:, 2:])):
        norms = np.linalg.norm(part, axis=1)
        assert np.max(norms) <= scales[name] * (1 + 1e-14)
        # A peak is at most half a grid step of swing / 256 away: 1 - cos(pi / 128).
        assert np.max(norms) >= scales[name] * math.cos(math.pi / 128)


def test_for_slow_rotation_the_precession_level_has_an_error_of_second_order():
    # s - w0 = W^2 / (2 w0): the phase error is that times t.
    case = cases.get("foucault_pendulum_linear", span=3600)
    turn = 7.292115e-5 * math.sin(0.8526)
    phase = turn**2 / (2 * math.sqrt(9.81 / 67)) * float(case.times[-1])
    precession = case.hierarchy[1].case
    # The rounding of the samples, about 1e-16, is far below the phase of 1e-5.
    error = np.max(case.metric.distance(precession.sample(case.times), case.sample(case.times)))
    # Both start at rest on the Earth; their amplitudes differ by W/w0, with an effect of (W/w0)^2 here.
    assert error == pytest.approx(phase, rel=0.2)

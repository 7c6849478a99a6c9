"""The distance of two states: in every case angles, and nothing else, are compared modulo 2 pi."""

import math

import numpy as np
import pytest
from gnomon.cases import get, names
from gnomon.cases.core.metric import Metric


def unit_metric(name: str) -> Metric:
    """A metric with scales of 1 and without jumps, so that distances are differences."""
    case = get(name)
    return Metric(Metric.scaled(case, dict.fromkeys((c.group for c in case.state), 1.0), frozenset()).groups)


@pytest.mark.parametrize("name", names())
def test_angles_alone_are_compared_modulo_a_turn(name: str) -> None:
    """Two angles that differ by 3.5 rad are 2 pi - 3.5 apart the other way; two lengths are not."""
    case, metric = get(name), unit_metric(name)
    state = np.linspace(0.3, 1.1, len(case.state))
    for i, coordinate in enumerate(case.state):
        if case.scored and coordinate.group not in case.scored:
            continue
        for off in (3.5, -3.5, 5.0, 7.0, -13.0, 40.0):
            perturbed = state.copy()
            perturbed[i] += off
            expected = abs(math.remainder(off, 2 * math.pi)) if coordinate.kind == "angle" else abs(off)
            # An ulp of the numbers that are subtracted, up to 41.
            assert metric.distance(perturbed[None], state[None])[0] == pytest.approx(expected, abs=4 * math.ulp(41.0))


def test_an_angle_keeps_the_digits_of_a_small_difference() -> None:
    """Wrapping adds half a turn, whose ulp is far larger."""
    state = np.zeros((1, 2))
    perturbed = np.array([[1e-30, 0.0]])
    assert unit_metric("pendulum_simple").distance(perturbed, state)[0] == 1e-30

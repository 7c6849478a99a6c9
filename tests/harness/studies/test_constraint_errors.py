"""Errors of constrained motions apart: a planted error shows in its own number, and in those that depend on it."""

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.studies.constraint_errors import Parts, parts
from on_cases import exact_states


def spoilt(name: str, column: int, size: float) -> Parts:
    """The exact motion of a case with one number of one sample changed."""
    case = get(name).rounded()
    exact = exact_states(case)
    states = exact.copy()
    states[20, column] += size
    return parts(case, case.times, exact, states)


@pytest.mark.parametrize("name", ["slider_crank", "car_axis", "andrews_squeezer"])
def test_the_exact_motion_has_no_errors_and_does_not_drift(name: str) -> None:
    """Its rounded states leave the constraints by round-off, in the units of the constraints and of their rates."""
    found = spoilt(name, 0, 0.0)
    assert (found.position, found.velocity, found.multiplier) == (0.0, 0.0, 0.0)
    assert found.constraint < 1e-14
    assert found.rate < 1e-12 * (1e3 if name == "andrews_squeezer" else 1)  # radians at up to 6e3 rad/s


def test_a_wrong_velocity_leaves_positions_and_constraints_right() -> None:
    half = get("slider_crank").rounded().sample(np.array([0.0])).shape[1] // 2
    found = spoilt("slider_crank", half, 1e-6)
    assert found.position == 0.0
    assert found.constraint < 1e-14
    assert min(found.velocity, found.rate, found.multiplier) > 1e-9


def test_a_wrong_position_drifts() -> None:
    found = spoilt("slider_crank", 0, 1e-6)
    assert found.velocity == 0.0
    assert min(found.position, found.constraint, found.multiplier) > 1e-9

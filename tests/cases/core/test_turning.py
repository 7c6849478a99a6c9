"""Declared symmetries hold: the motion from a turned start is the turned motion."""

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.core.turning import STARTS, Turning, turned_cases

from gnomon import cases

SYMMETRIC = [name for name in cases.names() if cases.case_class(name).turning is not None]


def test_the_foundation_cases_with_a_rotational_symmetry_declare_it() -> None:
    assert {"kepler_orbit", "euler_top", "foucault_pendulum_linear", "foucault_precession"} <= set(SYMMETRIC)


@pytest.mark.parametrize("name", SYMMETRIC)
def test_the_equations_turn_with_the_state(name: str) -> None:
    """At random states f(R y) = R f(y), up to rounding on both sides."""
    case = cases.get(name).rounded()
    form = next(form for form in case.all_forms() if isinstance(form, FirstOrder))
    parameters = tuple(map(float, case.parameter_values()))
    turning = case.turning
    assert turning is not None
    random = np.random.default_rng(3)
    for number in range(1, 6):
        rotation = turning.rotation(number)
        state = random.uniform(0.5, 1.5, len(case.state))
        ahead = np.array(form.equations(0.0, tuple(state.tolist()), parameters))
        turned = form.equations(0.0, tuple(turning.turned(case, state, rotation).tolist()), parameters)
        np.testing.assert_allclose(turned, turning.turned(case, ahead, rotation), rtol=0, atol=1e-13 * abs(ahead).max())


@pytest.mark.parametrize("name", SYMMETRIC)
def test_a_turned_start_has_the_turned_motion_of_its_own_rounded_numbers(name: str) -> None:
    """They differ by the rounding of the turned start: by an amount like the conditioning, and by more than zero."""
    case = cases.get(name).rounded()
    assert case.turning is not None
    times = case.times[[0, 20]]
    nominal = case.sample(times)
    found = turned_cases(case)
    assert len(found) == STARTS >= 8
    assert len({one.initial_state for one in found} | {case.initial_state}) == STARTS + 1
    for number, one in enumerate(found[:2], start=1):
        turned = case.turning.turned(case, nominal, case.turning.rotation(number))
        distance = case.metric.distance(one.sample(times), turned)
        assert np.all(distance < 100 * case.conditioning(times) + 1e-15)
        assert np.any(distance > 0), "the turned start is rounded, so its motion differs from the turned one"


@pytest.mark.parametrize("size", [2, 3])
def test_rotations_are_rotations_and_differ(size: int) -> None:
    turning = Turning((("x", "y", "z")[:size],))
    rotations = [turning.rotation(number) for number in range(1, STARTS + 1)]
    for rotation in rotations:
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(size), atol=4e-16)
        assert np.linalg.det(rotation) > 0
    closest = min(float(np.abs(a - b).max()) for k, a in enumerate(rotations) for b in rotations[:k])
    assert closest > 0.1
    assert min(float(np.abs(rotation - np.eye(size)).max()) for rotation in rotations) > 0.1


def test_rotations_about_the_vertical_keep_the_vertical() -> None:
    rotation = Turning((("x", "y", "z"),), vertical=True).rotation(2)
    np.testing.assert_array_equal(rotation[2], [0, 0, 1])
    np.testing.assert_array_equal(rotation[:, 2], [0, 0, 1])

"""Painleve's rod: what the sliding end refuses, and where its energy goes."""

import math

import pytest
from gnomon.cases import get
from gnomon.cases.contact.painleve_rod import normal_force, rod_energy, rod_equations, shape


def start(**numbers: float) -> tuple[float, ...]:
    return tuple({"x": 0, "theta": 0.4, "vx": 6, "omega": 3, **numbers}.values())


@pytest.mark.parametrize(
    ("numbers", "reason"), [({"vx": 0}, "vx > 0"), ({"theta": 1.2}, "p > 0"), ({"omega": 8}, "N > 0")]
)
def test_refuses_a_start_that_does_not_slide(numbers: dict[str, float], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        get("painleve_rod", initial_state=start(**numbers))


@pytest.mark.parametrize(
    ("numbers", "reason"),
    [
        ({}, "p reaches 0"),
        ({"mu": 1, "vx": 8}, "N reaches 0 and the rod lifts off"),
        ({"mu": 1.5, "vx": 8}, "N reaches 0 and the rod lifts off"),
        ({"mu": 1.53, "vx": 8}, "N reaches 0 and the rod lifts off"),
        ({"mu": 1.55, "vx": 8}, "p reaches 0"),
        ({"vx": 1}, "vx reaches 0"),
        ({"mu": 1, "omega": 1}, "the rod falls flat"),
    ],
)
def test_refuses_a_span_beyond_the_end_of_sliding(numbers: dict[str, float], reason: str) -> None:
    begin = {key: value for key, value in numbers.items() if key != "mu"}
    mu = numbers.get("mu", 1.6)
    with pytest.raises(ValueError, match=rf"at t = 0\.\d+ s {reason}.*give a shorter span"):
        get("painleve_rod", initial_state=start(**begin), span=1, mu=mu)


@pytest.mark.parametrize("variant", [None, "never_paradoxical", "near_boundary", "near_lift_off"])
def test_the_exact_motion_slides_throughout(variant: str | None) -> None:
    """The refusal looks at binary64 steps; here it is the exact motion."""
    case = get("painleve_rod", variant) if variant else get("painleve_rod")
    parameters = tuple(map(float, case.parameter_values()))
    for k in range(41):
        state = tuple(map(float, case.exact(case.span * k / 40, 20)))
        assert float(shape(state[1], parameters[2])) > 0
        assert float(normal_force(state, parameters)) > 0
        assert state[2] > 0
        assert math.sin(state[1]) > 0


def test_critical_friction_is_four_thirds() -> None:
    """The least p over theta is 5/2 - 3/2 sqrt(1 + mu^2), which is zero at mu = 4/3."""
    for mu in (1.0, 4 / 3, 1.6):
        least = min(float(shape(k * math.pi / 20000, mu)) for k in range(10001))
        assert math.isclose(least, 2.5 - 1.5 * math.hypot(1, mu), abs_tol=1e-6)


def test_energy_goes_to_friction_alone() -> None:
    """dE/dt = -mu N vx, by a central difference of the energy along the rates."""
    state, parameters, h = (0.0, 0.4, 6.0, 3.0), (2.0, 0.5, 1.6, 9.81), 1e-5
    rates = rod_equations(0, state, parameters)
    after, before = (
        rod_energy(0, tuple(y + sign * h * k for y, k in zip(state, rates, strict=True)), parameters)[0]
        for sign in (1, -1)
    )
    power = -parameters[2] * parameters[0] * normal_force(state, parameters) * state[2]
    assert math.isclose((after - before) / (2 * h), power, rel_tol=1e-7)

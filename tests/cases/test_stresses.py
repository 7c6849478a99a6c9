"""What variants say that they stress, where it is a number: read off the exact motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case, get


def smallest_tilt(case: Any) -> float:
    """From the vertical, up or down, by the heights between which the axis nutates."""
    low, high = case._exact.heights(30)
    return math.sqrt(2 * float(min(1 + low, 1 - high)))


def last(case: Case, name: str) -> float:
    return float(case.exact(case.span)[[c.name for c in case.state].index(name)])


def spread(case: Case, name: str) -> tuple[float, float]:
    column = case.sample(case.times)[:, [c.name for c in case.state].index(name)]
    return float(column.min()), float(column.max())


def ratio_of_spins(case: Case) -> float:
    low, high = spread(case, "spin")
    return high / low


def farthest_lean(case: Case) -> float:
    times = np.linspace(0.0, float(case.span), 300)
    return math.degrees(np.abs(case.sample(times)[:, 2] - math.pi / 2).max())


def growth_of_a_shift(case: Case) -> float:
    shift = Fraction(1, 10**20)
    beside = case.with_numbers((case.initial_state[0] + shift, case.initial_state[1]), case.parameters)
    return abs(float(case.exact(case.span, 32)[0] - beside.exact(case.span, 32)[0])) / float(shift)


def fast_over_slow(case: Any) -> float:
    """Of small motions about the level equilibrium: the tilt there by Newton's method, then the matrix of slopes."""
    parameters = tuple(map(float, case.parameter_values()))

    def rates(y: Any) -> Any:
        return np.array(case.equations_of_motion(0.0, tuple(y), parameters))

    def slopes(y: Any, step: float = 1e-6) -> Any:
        return np.array([(rates(y + step * e) - rates(y - step * e)) / (2 * step) for e in np.eye(4)]).T

    place = np.array([0.0, 0.5, 0.0, 0.0])
    for _ in range(20):
        place = place - np.linalg.solve(slopes(place), rates(place))
    turning = np.abs(np.linalg.eigvals(slopes(place)).imag)
    return float(turning.max() / turning.min())


def quantity(name: str) -> Callable[[Case], float]:
    return lambda case: float(case.quantities()[name])


CLAIMS: dict[str, tuple[Callable[[Any], float], float]] = {
    "central_force_hanging_mass/near_hole: passes 0.1 m": (quantity("least"), 0.1),
    "central_force_hanging_mass/light: out to 47 m": (quantity("largest"), 46.85),
    "central_force_shortened_string/slow: 1,568 turns": (lambda case: last(case, "theta") / math.tau, 1568),
    "particle_on_torus/thin: swings 420 times": (lambda case: math.pi / quantity("apsidal_angle")(case), 420),
    "chain_quarter_circle/just_longer: L = 1.00004": (
        lambda case: float(case.parameters["L"] / case.parameters["R"]) * 2 / math.pi - 1,
        4e-5,
    ),
    "engineering_design_analysis/light_spindle: twofold": (ratio_of_spins, 2),
    "dynamics_of_free_rigid_body_in_gravity/high: 43 turns": (
        lambda case: quantity("precession_rate")(case) * float(case.span) / math.tau,
        43,
    ),
    "stick_slip_belt/many: 1,389 cycles": (lambda case: len(case.events()) / 2, 1389),
    "spherical_pendulum/near_pole: passes 3e-7 rad": (smallest_tilt, 3.3e-7),
    "gyrocompass_tilting/fast_spin: 246 times": (fast_over_slow, 246),
    "lagrange_top/near_vertical: passes 2e-6 rad": (smallest_tilt, 2.3e-6),
    "lagrange_top/fast: a million times": (
        lambda case: math.tau / quantity("precession_per_nutation")(case),
        1e6,
    ),
    "lagrange_top_sleeping_separatrix/from_vertical: 18 s of exponential growth, to 9e-3": (
        lambda case: last(case, "theta"),
        9.4e-3,
    ),
    "rolling_disc/straight_slow: over to 65 degrees": (farthest_lean, 65),
    "bouncing_ball_table/chaotic: 3e12 times": (growth_of_a_shift, 3.35e12),
}


@pytest.mark.parametrize("claim", CLAIMS)
def test_what_a_variant_says_is_so(claim: str) -> None:
    name, _, words = claim.partition(": ")
    case = get(*name.split("/"))
    stresses = next(v.stresses for v in case.variants if v.name == case.variant)
    assert words in stresses
    measure, told = CLAIMS[claim]
    # The words have two digits.
    assert measure(case) == pytest.approx(told, rel=0.02)

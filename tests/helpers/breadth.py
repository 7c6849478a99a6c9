"""Which parameters of a wide test run in `make test`. The others are marked slow: they run in `make test-all`."""

from __future__ import annotations

import random
from collections.abc import Iterable
from typing import Any

import pytest

SEED = 18
"""Another number selects other parameters."""

EXPENSIVE = (
    "bearing_reaction_torque_stability", "curve_sliding_catenary", "curve_sliding_quartic", "curve_sliding_small",
    "cycloidal_pendulum", "double_pendulum", "engineering_design_analysis", "equilateral_three_body", "euler_top",
    "foucault_pendulum_nonlinear", "gyrocompass", "gyrocompass_damped_nonlinear", "gyrocompass_tilting",
    "holonomic_constraint_dae", "kepler_orbit", "lagrange_top", "lagrange_top_attitude", "particle_on_paraboloid",
    "particle_on_torus", "pendulum_on_cart", "pendulum_quadratic_damping", "relativistic_charge",
    "restitution_impact_1d_2d", "rigid_body_stokes_medium_torque", "rolling_disc", "rotating_pendulum",
    "rotating_pendulum_free_hoop", "rotating_pendulum_swept", "rubber_tube_thick", "rubber_tube_thin",
    "spherical_pendulum", "two_body",
)  # fmt: skip
"""Cases of whose exact motions a certificate, or all variants, take 2 to 30 s of processor time; of the others less than 2."""


def cheap_and_tenth(names: Iterable[str]) -> list[Any]:
    """The cases for `parametrize`: all that are not EXPENSIVE, and a tenth of those that are."""
    every = list(names)
    return [*(name for name in every if name not in EXPENSIVE), *tenth(name for name in every if name in EXPENSIVE)]


def tenth(values: Iterable[Any]) -> list[Any]:
    """The values for `parametrize`. A seeded tenth of them, rounded up, runs in `make test`; it is the same in every run."""
    every = list(values)
    chosen = set(random.Random(SEED).sample(range(len(every)), -(-len(every) // 10)))
    return [pytest.param(value, marks=() if index in chosen else pytest.mark.slow) for index, value in enumerate(every)]

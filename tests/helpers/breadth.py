"""Which parameters of a wide test run in `make test`. The others are marked slow: they run in `make test-all`."""

import random
from collections.abc import Iterable
from typing import Any

import pytest

SEED = 44
"""Another number selects other parameters."""

EXPENSIVE = (
    "amusement_park", "andrews_squeezer", "arenstorf_orbit", "bearing_reaction_torque_stability", "billiard_ball_attitude", "car_axis",
    "central_force_fifth_power", "central_force_hanging_mass", "central_force_logarithmic", "chain_in_circular_tube",
    "chain_quarter_circle", "chattering_ball", "choreography_five_bodies", "choreography_super_eight",
    "coulomb_friction_oscillator", "curve_sliding_catenary", "curve_sliding_quartic",
    "curve_sliding_small", "cycloidal_pendulum", "double_pendulum", "driven_pendulum", "duffing_unforced",
    "dumbbell_spring", "dynamics_of_free_rigid_body_in_gravity", "engineering_design_analysis",
    "equilateral_three_body", "euler_top", "fermi_pasta_ulam", "figure_eight", "foucault_pendulum_nonlinear", "four_bar_linkage", "gyrocompass",
    "gyrocompass_damped_nonlinear", "gyrocompass_tilting", "henon_heiles", "holonomic_constraint_dae",
    "ignorable_coordinates", "impulse_instantaneous", "kapitza_pendulum_driven", "kepler_orbit", "lagrange_top",
    "lagrange_top_attitude", "moment_of_momentum_pendulum", "outer_solar_system", "painleve_rod", "particle_on_paraboloid", "particle_on_torus",
    "pendulum_on_cart", "pendulum_on_string", "pendulum_quadratic_damping", "pleiades", "projectile_parabolic_coordinates",
    "projectile_quadratic_drag", "radial_fall_inverse_square", "relativistic_charge", "restitution_impact_1d_2d",
    "rigid_body_stokes_medium", "rigid_body_stokes_medium_falling", "rigid_body_stokes_medium_torque", "rolling_disc",
    "rolling_sphere_in_bowl", "rotating_pendulum", "rotating_pendulum_free_hoop", "rotating_pendulum_swept",
    "rotation_fixed_axis_compound_pendulum", "rubber_tube_thick", "rubber_tube_thin", "sliding_can", "slider_crank",
    "spherical_pendulum", "spring_pendulum", "stiff_spring_pendulum", "stiff_valley", "swinging_atwood",
    "symmetric_top_torque_free", "three_ball_chain", "three_body_pythagorean", "tippe_top", "tower_drop", "two_body",
)  # fmt: skip
"""Cases of whose exact motions a certificate, or all variants, take 1 to 30 s of processor time; of the others less."""


SAME_LOOP = ("Verner 6(5)", "Verner 9(8)", "RKN 12(10)")
"""Near-duplicate pairs: they run the loop of Dormand-Prince 5(4) or RKN 6(4), which is compiled for each number of
stages in ten seconds. `make test` verifies their formulas, `make test-all` also their runs."""


def marks(method: Any) -> Any:
    """The marks of a test that runs a method (an integrator or its class)."""
    return pytest.mark.slow if method.name in SAME_LOOP else ()


def cheap_and_tenth(values: Iterable[Any]) -> list[Any]:
    """The cases for `parametrize`, as names or as tuples that begin with one: all that are not EXPENSIVE, and a tenth of
    those that are."""
    every = list(values)
    chosen = [(value if isinstance(value, str) else value[0]) in EXPENSIVE for value in every]
    cheap = [value for value, expensive in zip(every, chosen, strict=True) if not expensive]
    return [*cheap, *tenth(value for value, expensive in zip(every, chosen, strict=True) if expensive)]


def tenth(values: Iterable[Any]) -> list[Any]:
    """The values, or tuples of values, for `parametrize`. A seeded tenth of them, rounded up, runs in `make test`; it is the
    same in every run."""
    every = list(values)
    chosen = set(random.Random(SEED).sample(range(len(every)), -(-len(every) // 10)))
    rows = [value if isinstance(value, tuple) else (value,) for value in every]
    return [pytest.param(*row, marks=() if i in chosen else pytest.mark.slow) for i, row in enumerate(rows)]

"""Impossible numbers of the cases of chapters 7 and 8: each rule of a domain is broken once, and the error states it."""

from __future__ import annotations

import re

import pytest
from gnomon.cases import case_class, get

BROKEN = (
    ("ballistic_pendulum", {"initial_state": (1, 0, 400, 0)}, "x = 1 is outside"),
    ("ballistic_pendulum", {"initial_state": (-10, 0, 0, 0)}, "u = 0 is outside"),
    ("ballistic_pendulum", {"initial_state": (-10, 1, 400, 0)}, "theta = 1 is outside"),
    ("torque_impulse_on_arm", {"l": 0}, "l = 0 is outside"),
    ("torque_impulse_on_arm", {"t1": 0}, "t1 = 0 is outside"),
    ("impulse_instantaneous", {"T": -1}, "T = -1 is outside"),
    ("work_energy_spring_block", {"k": 0}, "k = 0 is outside"),
    ("central_force_hanging_mass", {"initial_state": (1, 0, 0, 0)}, "omega is not zero"),
    ("central_force_hanging_mass", {"initial_state": (0, 0, 0, 1)}, "r = 0 is outside"),
    ("central_force_logarithmic", {"initial_state": (1, 0, 1, 0)}, "omega is not zero"),
    ("central_force_fifth_power", {"initial_state": (0, 0, 0, 1)}, "not at the centre"),
    ("central_force_shortened_string", {"span": 21}, "reaches the hole"),
    ("central_force_shortened_string", {"r0": 0}, "r0 = 0 is outside"),
    ("dumbbell_spring", {"initial_state": (1, 0, 1, 0)}, "omega is not zero"),
    ("dumbbell_spring", {"l": -1}, "l = -1 is outside"),
    ("pendulum_on_string", {"initial_state": (1, "0.1", 5, 0)}, "h = 0.1 is outside"),
    ("pendulum_on_string", {"initial_state": (2, 0, 5, 0)}, "theta = 2 is outside"),
    ("pendulum_on_string", {"span": 5}, "reaches the next contact"),
    ("spherical_pendulum", {"h": 0}, "h is not 0"),
    ("spherical_pendulum", {"initial_state": (0, 1, 0)}, "theta = 0 is outside"),
    ("curve_sliding_small", {"p": 0}, "p = 0 is outside"),
    ("cycloidal_pendulum", {"initial_state": (1, 7)}, "phidot^2 < g/a"),
    ("cycloidal_pendulum", {"initial_state": (4, 0)}, "phi = 4 is outside"),
    ("bead_leaving_sphere", {"initial_state": ("0.5", 0, 3, 0)}, "the sphere carries the particle"),
    ("bead_leaving_sphere", {"initial_state": ("1e-61", 0, 0, 0)}, "at most 138 e-foldings"),
    ("kepler_orbit", {"initial_state": (0, 0, 0, 1)}, "not at the centre"),
    ("kepler_orbit", {"initial_state": (1, 0, 0, 0), "span": 2}, "reaches the collision"),
    ("two_body", {"initial_state": (0, 0, 1, 0, 0, 0, 1, 0)}, "else the bodies collide"),
    ("two_body", {"m2": -1}, "m2 = -1 is outside"),
    ("man_on_cart", {"M": 0}, "M = 0 is outside"),
    ("exploding_projectile", {"t_burst": 0}, "t_burst = 0 is outside"),
    ("atwood_pulley_systems", {"I": -1}, "I = -1 is outside"),
    ("swinging_atwood", {"mu": 0}, "mu = 0 is outside"),
    ("equilateral_three_body", {"initial_state": (0,) * 18}, "no two bodies"),
    ("wedge_block_energy_momentum", {"alpha": 2}, "alpha = 2 is outside"),
    ("pendulum_on_cart", {"initial_state": (0, 0, 0, 20)}, "the pendulum swings"),
    ("chain_off_table", {"initial_state": (2, 0)}, "s <= L"),
    ("chain_off_table", {"mu": "0.5"}, "else friction holds the chain"),
    ("chain_over_pulley", {"initial_state": ("1.1", 0)}, "s <= L/2"),
    ("chain_smooth_curve", {"L": 4}, "between the cusps"),
    ("chain_in_circular_tube", {"L": 7}, "L < 2 pi R"),
    ("chain_quarter_circle", {"R": 2}, "longer than the quarter circle"),
    ("chain_quarter_circle", {"initial_state": (1, 0)}, "starts on the quarter circle"),
    ("chain_quarter_circle", {"initial_state": (0, 0)}, "beyond the edge or moves"),
    ("bouncing_ball_incline", {"initial_state": (0, 0, 0, -1)}, "does not move into it"),
    ("bouncing_ball_table", {"A": "0.011"}, "never falls faster than the ball"),
    ("bouncing_ball_table", {"initial_state": (0, 0)}, "above the table or leaves it"),
    ("bouncing_ball_table", {"e": 0}, "e = 0 is outside"),
    ("restitution_impact_1d_2d", {"initial_state": (2, 1, 0, -1)}, "x1 < x2"),
    ("restitution_impact_1d_2d", {"initial_state": (1, 2, -1, -2)}, "do not reach the wall at the same time"),
    ("restitution_impact_1d_2d", {"m1": 1, "m2": 20_000_000}, "m2 <= 1e7 m1"),
    ("oblique_impact", {"initial_state": ("0.1", 0, 0, 0, 1, 0, 0, 0)}, "the discs are apart"),
    ("three_ball_chain", {"initial_state": (0, 2, 1, 1, 0, 0)}, "apart and numbered from left to right"),
    ("three_ball_chain", {"initial_state": (0, 1, 2, 1, 0, -1)}, "meet at the same time"),
    ("three_ball_chain", {"m2": "1e-6"}, "(1 + e)^2 m1 m3 <= 3.996 e (m1 + m2)(m2 + m3)"),
    ("curve_sliding_small", {"p": "1e-6"}, "the bead rises by at most 2000 p"),
    ("newtons_cradle", {"e": "1.5"}, "e = 1.5 is outside"),
    ("newtons_cradle", {"initial_state": (0, 2, 1, 3, 4, 1, 0, 0, 0, 0)}, "apart and numbered from left to right"),
    ("central_force_hanging_mass", {"m2": 0}, "m2 = 0 is outside"),
)


@pytest.mark.parametrize(("name", "numbers", "says"), BROKEN)
def test_an_error_states_the_broken_rule(name: str, numbers: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=re.escape(says)):
        get(name, **numbers)  # type: ignore[arg-type]


def test_every_rule_of_these_cases_is_broken_once() -> None:
    for name in {name for name, _, _ in BROKEN}:
        said = [says for other, _, says in BROKEN if other == name]
        for rule in case_class(name).domain.rules:
            assert any(says in rule.statement for says in said), (name, rule.statement)

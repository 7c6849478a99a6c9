"""Numbers that are impossible together: each rule of a domain is broken once, and the error states it."""

import re

import pytest
from gnomon.cases import case_class, get

BROKEN = (
    ("central_force_hanging_mass", {"initial_state": (1, 0, 0, 0)}, "omega is not zero"),
    ("central_force_logarithmic", {"initial_state": (1, 0, 1, 0)}, "omega is not zero"),
    ("central_force_fifth_power", {"initial_state": (0, 0, 0, 1)}, "not at the centre"),
    ("central_force_shortened_string", {"span": 21}, "reaches the hole"),
    ("dumbbell_spring", {"initial_state": (1, 0, 1, 0)}, "omega is not zero"),
    ("pendulum_on_string", {"span": 5}, "reaches the next contact"),
    ("spherical_pendulum", {"h": 0}, "h is not 0"),
    ("cycloidal_pendulum", {"initial_state": (1, 7)}, "phidot^2 < g/a"),
    ("bead_leaving_sphere", {"initial_state": ("0.5", 0, 3, 0)}, "the sphere carries the particle"),
    ("bead_leaving_sphere", {"initial_state": ("1e-61", 0, 0, 0)}, "at most 138 e-foldings"),
    ("kepler_orbit", {"initial_state": (0, 0, 0, 1)}, "not at the centre"),
    ("kepler_orbit", {"initial_state": (1, 0, 0, 0), "span": 2}, "reaches the collision"),
    ("two_body", {"initial_state": (0, 0, 1, 0, 0, 0, 1, 0)}, "else the bodies collide"),
    ("euler_top", {"I3": 6}, "triangle inequality"),
    ("duffing_unforced", {"alpha": -1, "beta": -1}, "bounded"),
    ("duffing_unforced", {"beta": "-0.5", "initial_state": (0, 1.0000000000000002)}, "bounded"),
    ("bouncing_ball", {"initial_state": (0, -1)}, "does not move down"),
    ("block_incline_friction", {"mu_k": "0.5"}, "mu_k <= mu_s"),
    ("equilateral_three_body", {"initial_state": (0,) * 18}, "no two bodies"),
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
    ("restitution_impact_1d_2d", {"initial_state": (2, 1, 0, -1)}, "x1 < x2"),
    ("restitution_impact_1d_2d", {"initial_state": (1, 2, -1, -2)}, "do not reach the wall at the same time"),
    ("restitution_impact_1d_2d", {"m1": 1, "m2": 20_000_000}, "m2 <= 1e7 m1"),
    ("oblique_impact", {"initial_state": ("0.1", 0, 0, 0, 1, 0, 0, 0)}, "the discs are apart"),
    ("three_ball_chain", {"initial_state": (0, 2, 1, 1, 0, 0)}, "apart and numbered from left to right"),
    ("three_ball_chain", {"initial_state": (0, 1, 2, 1, 0, -1)}, "meet at the same time"),
    ("three_ball_chain", {"m2": "1e-6"}, "(1 + e)^2 m1 m3 <= 3.996 e (m1 + m2)(m2 + m3)"),
    ("curve_sliding_small", {"p": "1e-6"}, "the bead rises by at most 2000 p"),
    ("newtons_cradle", {"initial_state": (0, 2, 1, 3, 4, 1, 0, 0, 0, 0)}, "apart and numbered from left to right"),
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

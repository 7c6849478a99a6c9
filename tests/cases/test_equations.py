"""The equations of motion of every case agree with a second derivation that shares no formula with them.

The second derivation is d'Alembert's principle for mass points in an inertial Cartesian frame (independent_mechanics):
the modules independent_* state for each case only where its points are and which forces act on them.
"""

from collections.abc import Callable, Iterator
from typing import Any

import flint
import pytest
from gnomon.cases import get, names
from gnomon.cases.core.forms import Transition, first_order
from independent import ROUNDED, STATES, TOLERANCE, evaluated, many_digits, same
from independent_mechanics import SMALL, coefficient
from independent_models import MODELS, drawn

HYBRID = [name for name in names() if get(name).hybrid]
ONTO = [
    (name, found)
    for name in HYBRID
    for form in (get(name).hybrid,)
    for found in (form.transitions if form else ())
    if found.onto
]
ONLY_LATER = {
    ("ink_jet_printer", "paper"),
    ("torpedo_firing_pin", "stopped"),
    ("sliding_can", "float"),
    *(("chain_quarter_circle", mode) for mode in ("hanging", "tail_on_circle", "falling")),
    ("oblique_impact", "after"),
    *(("sliding_ladder", mode) for mode in ("floor", "flat")),
    ("rigid_link_plane_motion", "flat"),
}
"""Modes in which no motion can start."""
HOLDS: dict[str, tuple[str, Callable[[Any, Any], Any]]] = {
    "block_incline_friction": ("stick", lambda p, force: abs(force) <= p.mu_s * p.g * p.alpha.cos()),
    "coulomb_friction_oscillator": ("stick", lambda p, force: abs(force) <= p.mu_s * p.m * p.g),
    "rolling_bodies": ("roll", lambda p, force: abs(force) <= p.mu * p.g * p.alpha.cos()),
    # a catch keeps the pin from going back, so only the force against its motion is limited
    "torpedo_firing_pin": ("stopped", lambda p, force: -force <= p.mu * p.m * p.a),
}
"""For each case the mode in which dry friction holds, and whether friction exerts a force in it."""

FROM_REST = (
    *("block_incline_friction", "coulomb_friction_oscillator"),
    *("pendulum_quadratic_damping", "vertical_quadratic_drag"),
)
"""Cases whose modes are given by the sign of a velocity."""
BY_FLIGHT = (
    "bouncing_ball",
    "bouncing_ball_incline",
    "ballistic_pendulum",
    "sliding_ladder",
    "rigid_link_plane_motion",
)
"""Cases whose nearest state on a guard is the state in which the motion meets it."""


@pytest.fixture(autouse=True)
def _precision() -> Iterator[None]:
    with many_digits():
        yield


def test_every_case_has_a_second_derivation() -> None:
    for name in names():
        assert MODELS[name], "else it raises an error that names the file to write"
    assert set(MODELS) == set(names())


@pytest.mark.parametrize("name", names())
def test_equations_follow_from_points_and_forces(name: str) -> None:
    case = get(name)
    regimes: list[tuple[str, Any, tuple[float, ...]]] = [
        (mode.name, mode.equations, mode.constants) for mode in (case.hybrid.modes if case.hybrid else ())
    ]
    forms = [found for found in map(first_order, case.all_forms()) if found is not None]
    regimes += [("", form.equations, ()) for form in forms]
    assert regimes
    for mode, equations, constants in regimes:
        for seed in range(STATES):
            p, t, s = drawn(name, mode, seed)
            same(evaluated(equations, t, s, p, constants), MODELS[name].rates(p, t, s, mode), (mode, vars(p), vars(s)))


@pytest.mark.parametrize("name", HYBRID)
def test_a_mode_is_where_its_guards_say(name: str) -> None:
    """Inside a mode no guard of the mode has been crossed, and `start` names the mode of a state."""
    hybrid = get(name).hybrid
    assert hybrid is not None
    for mode in hybrid.modes:
        for seed in range(4 * STATES):
            p, t, s = drawn(name, mode.name, seed)
            for transition in hybrid.transitions:
                if transition.mode == mode.name:
                    (guard,) = evaluated(transition.guard, t, s, p)
                    assert guard * transition.direction < 0, (transition.name, guard)
            if (name, mode.name) not in ONLY_LATER:
                state, values = (tuple(map(float, vars(x).values())) for x in (s, p))
                assert hybrid.start(float(t), state, values) == mode.name


@pytest.mark.parametrize("name", HYBRID)
def test_transitions_follow_from_impulses(name: str) -> None:
    """In the states of the second derivation the guard is zero, and the reset follows from impulses."""
    hybrid, model = get(name).hybrid, MODELS[name]
    assert hybrid is not None
    for transition in hybrid.transitions:
        for seed in range(STATES):
            p, t, s = drawn(name, f"at {transition.name}", seed)
            (guard,) = evaluated(transition.guard, t, s, p)
            expected = flint.arb(0)
            if model.guards and transition.name in model.guards:
                expected = model.guards[transition.name](p, s, model.multipliers(p, t, s, transition.mode))
            assert abs(guard - expected) <= TOLERANCE * abs(expected) + ROUNDED, (transition.name, guard, expected)
            same(evaluated(transition.reset, t, s, p), model.after(p, t, s, transition.name), transition.name)
    for _, _, reset in hybrid.limits:
        p, t, s = drawn(name, "at limit", 0)
        same(evaluated(reset, t, s, p), model.after(p, t, s, "limit"), "limit")


@pytest.mark.parametrize("name", HOLDS)
def test_dry_friction_holds_what_it_can(name: str) -> None:
    """At rest, or without slip, friction holds if the force that it needs is within its limit."""
    hybrid, model = get(name).hybrid, MODELS[name]
    held, can = HOLDS[name]
    assert hybrid is not None
    found = set()
    for transition in hybrid.transitions:
        for seed in range(40):
            p, t, s = drawn(name, f"at {transition.name}", seed)
            (force,) = model.multipliers(p, t, s, held)
            state, values = (tuple(map(float, vars(x).values())) for x in (s, p))
            modes = [] if isinstance(transition.target, str) else [transition.lands(float(t), state, values)]
            if getattr(s, "v", 1) == 0:
                modes.append(hybrid.start(float(t), state, values))
            for mode in modes:
                assert (mode == held) == bool(can(p, force)), (transition.name, mode, force)
                found.add(mode == held)
    assert found == {True, False}


@pytest.mark.parametrize("name", FROM_REST)
def test_a_motion_from_rest_sets_off_the_way_of_its_mode(name: str) -> None:
    """Started at rest, it is in the mode whose forces accelerate it in the direction of that mode."""
    hybrid, model = get(name).hybrid, MODELS[name]
    assert hybrid is not None
    for seed in range(40):
        p, t, s = drawn(name, f"at {hybrid.transitions[0].name}", seed)
        state, values = (tuple(map(float, vars(x).values())) for x in (s, p))
        mode = hybrid.mode(hybrid.start(float(t), state, values))
        for side in mode.constants:
            s.v = side * flint.arb(SMALL)
            assert model.rates(p, t, s, mode.name)[1] * side > 0, (mode.name, side)


@pytest.mark.parametrize(("name", "transition"), ONTO, ids=lambda x: x if isinstance(x, str) else x.name)
def test_the_nearest_state_on_a_guard(name: str, transition: Transition) -> None:
    """It is on the guard, a state on the guard is not changed; for some cases it is on the motion through the state."""
    p, t, s = drawn(name, f"at {transition.name}", 0)
    same(evaluated(transition.onto, t, s, p), vars(s).values())
    p, t, s = drawn(name, transition.mode, 0)
    (guard,) = evaluated(transition.guard, t, evaluated(transition.onto, t, s, p), p)
    assert abs(guard) <= ROUNDED
    if name in BY_FLIGHT:
        rates = MODELS[name].rates(p, t, s, transition.mode)
        path = [flint.arb_series([x, v], 3) for x, v in zip(vars(s).values(), rates, strict=True)]
        moved = evaluated(transition.onto, flint.arb_series([t, 1], 3), path, p)
        same([coefficient(x, 1) for x in moved], [flint.arb(0)] * len(moved))

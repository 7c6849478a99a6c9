"""A decaying energy decays only by friction, drag or restitution: without these it is constant, to all digits."""

import itertools
from fractions import Fraction
from typing import Any

import mpmath
import pytest
from gnomon.cases import get, names
from independent_quantities import DIGITS, ObservedMotion

NEARLY_NONE = Fraction(1, 10**25)
WITHOUT: dict[str, dict[str, Any]] = {
    **{name: {"e": 1} for name in ("three_ball_chain", "newtons_cradle", "oblique_impact")},
    **{name: {"e": 1} for name in ("bouncing_ball", "bouncing_ball_incline")},
    **{name: {"mu_k": 0, "mu_s": 0} for name in ("coulomb_friction_oscillator", "block_incline_friction")},
    **{name: {"mu": 0} for name in ("torpedo_firing_pin", "chain_off_table", "slider_rotating_slot", "rolling_bodies")},
    **{name: {"mu": 0} for name in ("billiard_ball", "billiard_ball_attitude")},
    **{name: {"c": 0} for name in ("damped_oscillator", "gyrocompass_damped", "gyrocompass_damped_nonlinear")},
    **{name: {"nu": 0} for name in ("projectile_stokes_drag", "rigid_body_stokes_medium")},
    "tippe_top": {"mu": 0},
    "painleve_rod": {"mu": 0},
    "rayleigh_dissipation_mdof": {"c1": 0, "c2": 0, "c3": 0},
    "pendulum_quadratic_damping": {"c": NEARLY_NONE},
    "projectile_quadratic_drag": {"k": NEARLY_NONE},
    "vertical_quadratic_drag": {"k": NEARLY_NONE},
    "flywheel_coast_down": {"c": 0, "M": NEARLY_NONE},
    "billiard_ball_drill": {"mu": NEARLY_NONE},
    # they lose energy only at an event
    **{name: {} for name in ("sliding_ladder", "rigid_link_plane_motion", "ballistic_pendulum")},
}
DECAYING = [name for name in names() if any(i.law == "decays" for i in get(name).invariants.values())]


@pytest.mark.parametrize("name", DECAYING)
def test_nothing_is_lost_without_friction(name: str) -> None:
    assert name in WITHOUT, f"write the parameters of {name} without losses into WITHOUT of tests/cases/test_losses.py"
    # without friction the natural span of these would be infinite
    case = get(name, span=1 if name in ("flywheel_coast_down", "billiard_ball_drill") else None, **WITHOUT[name])
    with mpmath.workdps(DIGITS):
        observed = ObservedMotion(case)
        times = [event.time for event in observed.events()] if case.hybrid else []
        # without losses, energy is constant through events too; for the other cases it is compared between events
        breaks = times if name == "torpedo_firing_pin" or not WITHOUT[name] else []
        until = (
            times[0] if name == "sliding_ladder" else observed.span
        )  # the invariant holds while the rod touches the wall
        for label, invariant in case.invariants.items():
            if invariant.law != "decays":
                continue
            samples = [until * k / 13 for k in range(13)]
            found = [(sum(b <= t for b in breaks), observed.invariant(label, t)) for t in samples]
            size = max(abs(value) for _, value in found)
            pairs = [(a, b) for (m, a), (n, b) in itertools.pairwise(found) if m == n]
            assert len(pairs) >= 6
            assert size > 0
            assert all(abs(a - b) <= size * mpmath.mpf("1e-18") for a, b in pairs), (label, found)

"""Every derived quantity of every case against what it names, seen from outside; every event against guard and reset."""

from __future__ import annotations

import look_events
import look_fields
import look_forces
import look_losses
import look_returns
import look_turns
import look_vibrations
import mpmath
import pytest
from gnomon.cases import case_class, get
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from outside import DIGITS, HYBRID, SMOOTH, Outside, scorer, settings

LOOKS = (look_returns, look_turns, look_vibrations, look_forces, look_fields, look_events, look_losses)
"""They fill SMOOTH and HYBRID."""
TURNING = ("pendulum_simple", "rotating_pendulum", "chain_in_circular_tube", "rotation_fixed_axis_compound_pendulum")
MORE = [*((name, "rotation") for name in TURNING), ("duffing_unforced", "soft"), ("damped_oscillator", "critical")]
MORE += [("kepler_orbit", "plunge"), ("gyrocompass", "slow_spin"), ("gyrocompass", "pole")]
MORE_WITH_EVENTS = [("bouncing_ball", "elastic"), ("bouncing_ball_incline", "elastic"), ("torpedo_firing_pin", "short")]
MORE_WITH_EVENTS += [("sliding_can", "lifts_off")]
"""Settings with quantities that the defaults do not have."""
COUNT = 457
"""Quantities of all cases on their defaults."""


def ways(name: str, variant: str | None) -> set[tuple[str, str]]:
    hybrid = get(name, variant).hybrid
    return {(each.name, each.reset.__name__) for each in hybrid.transitions} if hybrid else set()


TRANSITIONS = [
    (name, variant)
    for name, _ in settings(hybrid=True)
    for variant in (None, *(v.name for v in case_class(name).variants if ways(name, v.name) - ways(name, None)))
]
"""Every case on its defaults, and the variants with transitions of their own."""


def test_no_quantity_is_lost() -> None:
    """A name that goes would not be missed above: that many there are."""
    counts = [len(get(*setting).quantities(10)) for hybrid in (False, True) for setting in settings(hybrid)]
    assert sum(counts) >= COUNT


@pytest.mark.parametrize(("name", "variant"), [*settings(hybrid=False), *MORE])
def test_every_quantity_of_a_smooth_motion_is_what_it_names(name: str, variant: str | None) -> None:
    scorer(SMOOTH, name, variant)


@pytest.mark.parametrize(("name", "variant"), [*settings(hybrid=True), *MORE_WITH_EVENTS])
def test_every_quantity_of_a_motion_with_events_is_what_it_names(name: str, variant: str | None) -> None:
    scorer(HYBRID, name, variant)


@pytest.mark.parametrize(("name", "variant"), TRANSITIONS)
def test_events_satisfy_guard_and_reset(name: str, variant: str | None) -> None:
    """At the first events the guard is zero, the reset maps the state before onto that after, and so does the motion."""
    case = get(name, variant)
    assert case.hybrid is not None
    sizes = max(case.scales().values())
    with mpmath.workdps(DIGITS):
        look = Outside(case)
        parameters = tuple(vars(look.p).values())
        for event in case.events(25)[:4]:
            if event.name == "limit":
                continue
            named = [transition for transition in case.hybrid.transitions if transition.name == event.name]
            assert named, event.name
            held = []
            for transition in named:
                constants = case.hybrid.mode(transition.mode).constants
                landed, gap = (
                    rebind(function, mpmath_arithmetic(mpmath.mp))(event.time, event.before, (*parameters, *constants))
                    for function in (transition.reset, transition.guard)
                )
                off = max(abs(a - b) for a, b in zip(landed, event.after, strict=True))
                held.append(off < sizes * mpmath.mpf("1e-20") and abs(gap[0]) < mpmath.mpf("1e-18") * (1 + sizes))
            assert any(held), event

"""Moreau's time stepping: its forms agree with the modes, its order is 1, a body at rest stays at rest."""

from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import Friction, Hybrid, Impact
from gnomon.cases.core.registry import get
from gnomon.harness.integrators.events.moreau import Moreau
from on_cases import solved

IMPACTS = ("bouncing_ball", "bouncing_ball_incline")
RUBBING = ("coulomb_friction_oscillator", "block_incline_friction")


def form_of(name: str) -> tuple[Any, Hybrid, tuple[float, ...]]:
    case = get(name).rounded()
    assert case.hybrid is not None
    return case, case.hybrid, tuple(float(v) for v in case.parameter_values())


@pytest.mark.parametrize("name", IMPACTS)
def test_an_impact_is_that_of_the_modes(name: str) -> None:
    """The free motion is the first mode's, the gap its guard; the reset turns the normal velocity by -e alone."""
    case, form, p = form_of(name)
    assert isinstance(form, Impact)
    n = len(case.state) // 2
    state = tuple(0.25 + i for i in range(n)) + tuple(-1.5 - i for i in range(n))
    (bounce,) = form.transitions
    assert form.free is form.mode(bounce.mode).equations
    assert form.gap(0, state[:n], p) == bounce.guard(0, state, p)
    normal, (e,) = np.array(form.normal(0, state[:n], p)), form.restitution(p)
    assert float(normal @ normal) == 1
    velocity = np.array(state[n:])
    assert bounce.reset(0, state, p)[n:] == pytest.approx(velocity - (1 + e) * (normal @ velocity) * normal, rel=1e-15)


@pytest.mark.parametrize("name", RUBBING)
def test_friction_is_that_of_the_modes(name: str) -> None:
    _, form, p = form_of(name)
    assert isinstance(form, Friction)
    state = (0.25, 0.5)
    kinetic, static = form.bounds(0, state, p)
    assert 0 < kinetic <= static
    free = form.sliding(0, state, (*p, 0.0))
    for mode in form.modes:
        if mode.constants:
            found = mode.equations(0, state, (*p, *mode.constants))
            assert found[1] == pytest.approx(free[1] - mode.constants[0] * kinetic, rel=1e-14)
            assert mode.equations is form.sliding


def errors(name: str, counts: list[int], variant: str | None = None) -> list[float]:
    case = get(name, variant).rounded()
    return [solved(Moreau(), case, steps=count).error for count in counts]


@pytest.mark.parametrize("name", [*IMPACTS, *RUBBING])
def test_order(name: str) -> None:
    """The position of an event within its step is random: the error is C h within a factor of about five.

    Over fifty steps, four to a halving, that leaves the slope uncertain by ln 5 / (sqrt 50 * 2.6) = 0.09.
    """
    counts = sorted({round(2 ** (k / 4)) for k in range(8, 60)})
    slope = np.polyfit(np.log(counts), np.log(errors(name, counts)), 1)[0]
    assert -slope == pytest.approx(1, abs=0.1)


def test_a_body_at_rest_stays_at_rest() -> None:
    assert errors("coulomb_friction_oscillator", [1, 16], "held") == [0, 0]
    ball = get("bouncing_ball", initial_state=(0, 0), span=2).rounded()
    assert not np.any(solved(Moreau(), ball, steps=1).states)


def test_steps_far_longer_than_flights_pass_the_zeno_limit() -> None:
    """The span contains infinitely many impacts; a thousand steps end at rest, on the plane within the fall of a step."""
    case = get("bouncing_ball").rounded()
    found = solved(Moreau(), case, steps=16)
    h, (y, v) = found.problem.interval / 16, found.states[-1]
    assert abs(v) < 9.81 * h
    assert abs(y) < 9.81 * h

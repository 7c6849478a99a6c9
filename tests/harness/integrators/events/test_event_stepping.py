"""The state machine of event stepping is the one of the diagram in its docstring. Uncompiled, in plain Python."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import Hybrid, Mode, Transition, Values
from gnomon.harness.contract.integrator import Problem, Solution
from gnomon.harness.integrators.events import event_functions, event_location, event_stepping, hybrid
from gnomon.harness.integrators.events.hybrid import Dop853Events, EulerEvents, EventRungeKutta, RK4Events

MOVES = ("choose_step", "arm_guards", "attempt", "search", "advance", "jump")
STATES = (
    "START", "SMOOTH", "EVENT", "CHOSEN", "ARMED", "STEPPED", "LOCATED", "CROSSED",
    "DONE", "ASK", "FULL", "NOT_FINITE", "STEP_TOO_SMALL", "TOO_MANY_STEPS", "ACCUMULATED",
)  # fmt: skip
NAMES = {getattr(event_stepping, name): name for name in STATES}
Edges = dict[str, set[tuple[str, str]]]


def diagram() -> dict[str, tuple[set[str], set[str]]]:
    """For each function the states before it and those after it: on the line below, and named on its own line."""
    assert event_stepping.__doc__ is not None
    lines = [line.strip() for line in event_stepping.__doc__.splitlines() if line.startswith("    ")]
    states = [set(re.findall(r"[A-Z_]{3,}", line)) for line in lines]
    found = {}
    for k, line in enumerate(lines):
        if line.startswith("| "):
            below = states[k + 1] if k + 1 < len(lines) else set()
            found[line.split()[1]] = (states[k - 1], below | states[k])
    return found


def fall(t: Any, state: Values, parameters: Values) -> Values:
    return state[1], -1.0


def floor(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0],)


def bounce(t: Any, state: Values, parameters: Values) -> Values:
    return state[0], -state[1]


def stop(t: Any, state: Values, parameters: Values) -> Values:
    return 0.0, 0.0


def rest(t: Any, state: Values, parameters: Values) -> Values:
    return 0.0, 0.0


def flicker(t: Any, state: Values, parameters: Values) -> Values:
    """Stiffer than what went before it, with a fast change at t = 5 that no step before it can foresee."""
    return state[1], -400.0 * state[0] + 1e3 * math.exp(-((t - 5.0) ** 2) * 1e4)


def blow_up(t: Any, state: Values, parameters: Values) -> Values:
    return state[0] * state[0] * state[0], 0.0


def never(t: Any, state: Values, parameters: Values) -> Values:
    return (1.0,)


def broken(t: Any, state: Values, parameters: Values) -> Values:
    return (math.nan,)


def breaks(t: Any, state: Values, parameters: Values) -> Values:
    return (math.nan if t > 0.6 else 1.0,)


def first(t: Any, state: Values, parameters: Values) -> str:
    return "first"


def second(t: Any, state: Values, parameters: Values) -> str:
    return "second"


def form(
    equations: Any, guard: Any, reset: Any = bounce, target: Any = "first", settle: float = 1e-9, limit: Any = ()
) -> Hybrid:
    modes = (Mode("first", equations), Mode("second", flicker), Mode("third", rest))
    return Hybrid(modes, first, (Transition("hit", "first", guard, -1, reset, target),), settle, limit)


def plain_parts(form: Hybrid, dimension: int, parameters: int) -> Callable[..., None]:
    """`event_functions.compiled_parts`, uncompiled: the same functions in the same sequence."""
    maps = {name: to_limit for name, _, to_limit in form.limits}
    signed = [
        lambda t, y, p, g=g: tuple(-g.direction * x for x in g.guard(t, y, p)) for g in form.transitions
    ]  # fmt: skip
    functions = [*(mode.equations for mode in form.modes), *signed, *(g.reset for g in form.transitions)]
    functions += [maps.get(g.name, g.reset) for g in form.transitions]

    def parts(t: float, y: Any, p: Any, out: Any) -> None:
        values = functions[int(out[0])](t, tuple(map(float, y)), tuple(p))
        out[: len(values)] = values

    return parts


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> Edges:
    """What each function between states did: (state before, state after). The machine runs as plain Python."""
    edges: Edges = defaultdict(set)
    state = event_stepping.START

    def watched(name: str, move: Callable[..., int]) -> Callable[..., int]:
        def call(*arguments: Any) -> int:
            nonlocal state
            motion = next(x for x in arguments if isinstance(x, event_stepping.Motion))
            before = motion.where[event_stepping.STATE] if name == "choose_step" else state
            state = move(*arguments)
            edges[name].add((NAMES[int(before)], NAMES[int(state)]))
            return state

        return call

    for name in MOVES:
        monkeypatch.setattr(event_stepping, name, watched(name, getattr(event_stepping, name)))
    monkeypatch.setattr(event_location, "call", lambda parts, t, y, p, out: parts(t, y, p, out))
    monkeypatch.setattr(event_stepping, "compiled", lambda: event_stepping.run)
    monkeypatch.setattr(event_functions, "compiled_parts", plain_parts)
    return edges


def solved(kind: type[EventRungeKutta], form: Hybrid, setting: float, start: Values, span: float = 8.0) -> Solution:
    problem = Problem(form, 2, np.zeros(0), np.arange(1, 17) / 16 * span, 1.0)
    with np.errstate(all="ignore"):
        return kind().prepare(problem, setting)(np.array([start]))


def test_the_changes_of_state_are_those_of_the_diagram(seen: Edges, monkeypatch: pytest.MonkeyPatch) -> None:
    """Motions that between them take every edge, and none beside it."""
    falling = form(fall, floor)
    solved(RK4Events, falling, 0.125, (0.3, 0.0))  # steps between samples, events within them
    solved(RK4Events, falling, 0.5, (0.005, 0.0))  # more events than the first arrays hold
    solved(RK4Events, form(fall, floor, stop, limit=(("hit", "third", stop),), settle=1e9), 0.5, (0.3, 0.0))
    solved(
        Dop853Events, form(fall, floor, target=second), 1e-9, (0.3, 0.0)
    )  # Python names the next mode, a stiffer one
    solved(Dop853Events, form(flicker, never), 1e-9, (1.0, 0.0))
    assert solved(Dop853Events, form(blow_up, never), 1e-6, (1.0, 0.0)).stopped is not None
    monkeypatch.setattr(event_stepping, "MOST_STEPS", 20)
    assert solved(Dop853Events, form(flicker, never), 1e-9, (1.0, 0.0)).stopped is not None
    monkeypatch.setattr(event_stepping, "MOST_RAPID", 3)
    assert solved(RK4Events, form(fall, floor, settle=1e9), 0.5, (0.3, 0.0)).stopped is not None
    for equations, guard in ((blow_up, never), (fall, broken), (fall, breaks)):
        assert "not finite" in (solved(EulerEvents, form(equations, guard), 0.5, (1e3, 0.0)).stopped or "")
    drawn = diagram()
    assert tuple(drawn) == MOVES
    for name, (before, after) in drawn.items():
        assert {state for state, _ in seen[name]} == before, name
        assert {state for _, state in seen[name]} == after, name


def test_a_rejected_step_returns_to_the_state_before_it(seen: Edges) -> None:
    """Else a guard that is zero at the start, or was just met, would fire again."""
    kept: set[tuple[int, int]] = set()
    attempt = event_stepping.attempt

    def watched(formula: Any, motion: Any, tolerance: float) -> int:
        before = int(motion.where[event_stepping.STATE])
        after = attempt(formula, motion, tolerance)
        if after != event_stepping.STEPPED:
            kept.add((before, after))
        return after

    event_stepping.attempt = watched  # the fixture `seen` restores it
    solved(Dop853Events, form(fall, floor, target=second), 1e-9, (0.3, 0.0))
    solved(Dop853Events, form(flicker, never), 1e-9, (1.0, 0.0))
    assert kept == {(state, state) for state in (event_stepping.START, event_stepping.SMOOTH, event_stepping.EVENT)}


def test_each_final_state_has_a_reason_or_an_answer() -> None:
    finals = {name for name in STATES if getattr(event_stepping, name) >= event_stepping.DONE}
    reasons = {NAMES[state] for state in hybrid.REASONS}
    assert finals - reasons == {"DONE", "ASK"}
    assert len(NAMES) == len(STATES)

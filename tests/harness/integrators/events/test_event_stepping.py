"""The state machine of event stepping is the one of the diagram in its docstring. Uncompiled, in plain Python."""

import math
import re
import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import Hybrid, Mode, Transition, Values
from gnomon.harness.contract.integrator import Problem, Solution
from gnomon.harness.integrators.events import event_functions, event_location, event_stepping, hybrid
from gnomon.harness.integrators.events.hybrid import Dop853Events, EulerEvents, EventRungeKutta, RK4Events

STATES = (
    "START", "SMOOTH", "EVENT", "CHOSEN", "ARMED", "STEPPED", "LOCATED", "CROSSED",
    "DONE", "ASK", "FULL", "NOT_FINITE", "STEP_TOO_SMALL", "TOO_MANY_STEPS", "ACCUMULATED",
)  # fmt: skip
NAMES = {getattr(event_stepping, name): name for name in STATES}


def diagram() -> set[tuple[str, str]]:
    """The changes of state that are drawn: to those on the line below, and to those named behind an arrow."""
    assert event_stepping.__doc__ is not None
    lines = [line for line in event_stepping.__doc__.splitlines() if line.startswith("    ")]
    states = [re.findall(r"[A-Z_]{3,}", line) for line in lines]
    found = set()
    for k, line in enumerate(lines):
        if line.strip().startswith("|"):
            after = states[k] + (states[k + 1] if k + 1 < len(lines) else [])
            found |= {(one, other) for one in states[k - 1] for other in after}
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
    """Stiffer than the equations before it, with a fast change at t = 5 that no step before it can foresee."""
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
    """`event_functions.compile_parts`, uncompiled: the same functions in the same sequence."""
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
def seen(monkeypatch: pytest.MonkeyPatch) -> set[tuple[str, str]]:
    """Fills with the changes of state, while the machine runs as plain Python: (before, after)."""
    edges: set[tuple[str, str]] = set()

    def run(machine: Any, method: Any, point: event_stepping.Point, samples: Any) -> int:
        last = int(point.where[event_stepping.STATE])

        def inside(frame: FrameType, event: str, argument: Any) -> Any:
            nonlocal last
            now = argument if event == "return" else frame.f_locals.get("state", last)
            if now is not None and now != last:
                edges.add((NAMES[last], NAMES[int(now)]))
                last = int(now)
            return inside

        sys.settrace(lambda frame, event, argument: inside if frame.f_code is event_stepping.run.__code__ else None)
        try:
            return event_stepping.run(machine, method, point, samples)
        finally:
            sys.settrace(before)

    before = sys.gettrace()
    monkeypatch.setattr(event_location, "call", lambda parts, t, y, p, out: parts(t, y, p, out))
    monkeypatch.setattr(event_stepping, "compile_run", lambda: run)
    monkeypatch.setattr(event_functions, "compile_parts", plain_parts)
    return edges


def solved(kind: type[EventRungeKutta], form: Hybrid, setting: float, start: Values, span: float = 8.0) -> Solution:
    problem = Problem(form, 2, np.zeros(0), np.arange(1, 17) / 16 * span, 1.0)
    with np.errstate(all="ignore"):
        return kind().prepare(problem, setting)(np.array([start]))


def test_the_changes_of_state_are_those_of_the_diagram(
    seen: set[tuple[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
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
    assert seen <= drawn
    between = dict.fromkeys(
        ("START", "SMOOTH", "EVENT"), "between steps"
    )  # not each of them can be the last of a motion
    assert {(between.get(a, a), b) for a, b in seen} == {(between.get(a, a), b) for a, b in drawn}


def test_each_final_state_has_a_reason_or_an_answer() -> None:
    finals = {name for name in STATES if getattr(event_stepping, name) >= event_stepping.DONE}
    reasons = {NAMES[state] for state in hybrid.REASONS}
    assert finals - reasons == {
        "DONE",
        "ASK",
        "ACCUMULATED",
    }  # the reason of the last one has the time and the transition
    assert len(NAMES) == len(STATES)

"""Every form that an integrator takes has its lines for a user's function, and the call with its options."""

from typing import Any

import pytest
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.own_systems.lines import call_lines, explain_form
from gnomon.harness.registry import lookup
from gnomon.harness.running.own_functions import Arguments
from gnomon.harness.running.pieces import Stated


def swing(t: float, y: Any, g: float) -> list[Any]:
    return [y[1], -g * y[0]]


STATED = Stated(swing, Arguments((9.81,)))


@pytest.mark.parametrize("integrator", lookup.own().values(), ids=lambda one: one.id)
def test_a_method_says_which_form_it_wants_and_shows_it(integrator: Integrator) -> None:
    accepted = " or ".join(kind.__name__ for kind in integrator.accepts)
    text = explain_form(accepted, STATED, (0, 1), "y[1]' depends on y[1]")
    assert "scene" in text or "swing" in text
    shown = text.partition("State it as\n")[2]
    assert accepted == "SceneForm" or 2 <= len(shown.splitlines()) <= 3
    compile(shown, "<shown>", "exec")


def lowest(t: float, y: Any, g: float) -> Any:
    return y[0]


def test_events_are_imported_too() -> None:
    text = call_lines(Stated(swing, Arguments((9.81,)), [lowest]), (0.0, 1.0), (1.0, 0.0), "gnomon:RK4", 0.1, "step")
    assert f"from {__name__} import lowest" in text
    assert "events=[lowest]" in text


def test_the_call_has_the_options_of_the_system() -> None:
    text = call_lines(STATED, (0.0, 10.0), (1.0, 0.5), "gnomon:RK4", 0.01, "step")
    assert 'gnomon.solve(swing, (0, 10), [1, 0.5], "gnomon:RK4", step=0.01, args=(9.81,))' in text
    assert f"from {__name__} import swing" in text

"""A panel answers for any integrator: its data are fit for JSON, and it never raises."""

import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gnomon.harness.contract.integrator import Integrator, Refused
from gnomon.harness.registry import lookup
from gnomon.harness.stability.panel import IDS, Panel, for_json, panels


def panel_of(measure: Callable[[Integrator, float], dict[str, Any]], why: str | None = None) -> Panel:
    return Panel("linear", "Linear stability", lambda integrator: why, measure, lambda data: [])


@pytest.fixture
def rk4() -> Integrator:
    return lookup.own()["gnomon:RK4"]


def test_every_module_of_a_panel_registers_one_of_that_name_in_the_stated_sequence() -> None:
    found = panels()
    assert list(found) == [name for name in IDS if name in found]
    assert all(name == panel.id and panel.title for name, panel in found.items())
    assert {"linear", "stiffness", "resonance"} <= set(found)


def test_what_is_not_finite_is_none_and_arrays_are_lists(rk4: Integrator) -> None:
    data = {"limit": np.float64(2.5), "rows": np.array([1.0, math.nan]), "end": math.inf, "pair": (1, np.int64(2))}
    found = panel_of(lambda integrator, seconds: data).measured(rk4, 1.0)
    assert found == {"limit": 2.5, "rows": [1.0, None], "end": None, "pair": [1, 2]}
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert for_json(np.array(math.nan)) is None


def test_refusals_and_exceptions_are_reasons(rk4: Integrator) -> None:
    def refuses(integrator: Integrator, seconds: float) -> dict[str, Any]:
        raise Refused("step size 3 is too long")

    def raises(integrator: Integrator, seconds: float) -> dict[str, Any]:
        raise ZeroDivisionError("division by zero")

    assert panel_of(refuses).measured(rk4, 1.0) == {"refused": "step size 3 is too long"}
    assert panel_of(raises).measured(rk4, 1.0) == {"refused": "ZeroDivisionError: division by zero"}
    assert panel_of(raises, "it has no step").measured(rk4, 1.0) == {"not_applicable": "it has no step"}

"""A method that solves nothing is measured as such: every panel says so, and no process ends."""

from typing import Any

import numpy as np
import pytest
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.stability import panel_run
from gnomon.harness.verification.function_adapter import from_solve, from_step


def not_finite(f: Any, t: float, y: Any, h: float) -> Any:
    return y * np.nan


def infinite(f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
    return np.full((len(times), len(y0)), np.inf)


def stands(f: Any, t: float, y: Any, h: float) -> Any:
    return y


def grows(f: Any, t: float, y: Any, h: float) -> Any:
    return y * 1e200


USELESS = [
    from_step(not_finite, name="not finite", order=1),
    from_solve(infinite, name="infinite", order=3),
    from_step(stands, name="stands", order=1),
    from_step(grows, name="grows", order=1),
]


@pytest.mark.parametrize("integrator", USELESS, ids=lambda integrator: integrator.name)
def test_no_panel_recommends_a_method_that_solves_nothing(
    integrator: Integrator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(panel_run.DEPTHS, "normal", 0.02)
    monkeypatch.setattr(panel_run, "LONGEST", 1e5)
    rows = panel_run.measure_panels(
        [integrator], ["linear", "stiffness", "resonance", "tolerance", "long_time", "digits"]
    )
    for row in rows:
        assert "process ended" not in (row.reason or "")
        kept = [text for text in row.sentences if text.startswith("Use")]
        if integrator.name == "stands":  # a method that does not move keeps its energy on all equations
            kept = [text for text in kept if "energy" not in text]
        assert kept == []

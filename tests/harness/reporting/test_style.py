"""The kind of method of a series, from the declarations of its integrator."""

import pandas as pd
import pytest
from gnomon.harness.registry.lookup import own
from gnomon.harness.reporting.figures_work import work_precision
from gnomon.harness.reporting.style import family


@pytest.mark.parametrize(
    ("name", "engine", "said"),
    [
        ("gnomon:RK4", False, "fixed step"),
        ("gnomon:Störmer-Verlet", False, "fixed step, geometric"),
        ("gnomon:Boris", False, "fixed step, geometric"),
        ("gnomon:RKMK 4", False, "fixed step, geometric"),
        ("rebound:WHFast", False, "fixed step, geometric"),
        ("gnomon:DOP853", False, "adaptive step"),
        ("pybullet:stepSimulation [configured]", True, "physics engine"),
    ],
)
def test_families(name: str, engine: bool, said: str) -> None:
    method = own()[name]
    row = {"engine": engine, "setting_kind": method.sweep.kind, "conserves": ", ".join(method.conserves)}
    assert family(pd.Series(row)) == said


def test_no_integrator_is_left_out_of_a_legend() -> None:
    """By default Vega names thirty entries and counts the others, which in this order are the other libraries."""
    look = pd.DataFrame({"series": list(own()), "colour": "#000000", "shape": "circle", "dash": "1"})
    assert work_precision(look, "time")["config"]["legend"]["symbolLimit"] > 2 * len(own())

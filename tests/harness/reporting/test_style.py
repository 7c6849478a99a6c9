"""The kind of method of a series, from the declarations of its integrator; and the colours of all pictures."""

import re
from pathlib import Path

import pandas as pd
import pytest
from gnomon.harness.registry.lookup import own
from gnomon.harness.reporting.figures_work import work_precision
from gnomon.harness.reporting.style import family, find_colour

ROOT = Path(__file__).parents[3]
HOME = Path("harness/reporting/templates/colours.toml")
NUMBER = re.compile(r"#[0-9a-fA-F]{6}\b|[:\"'] ?#[0-9a-fA-F]{3}\b")
"""A colour, also the short one of a style sheet."""


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


def test_colours_stand_in_one_file() -> None:
    """Who changes a colour, or looks for one that is free, sees all of them."""
    endings = {".py", ".css", ".js", ".j2", ".toml", ".typ"}
    files = [path for folder in ("harness", "src") for path in (ROOT / folder).rglob("*") if path.suffix in endings]
    found = {path.relative_to(ROOT) for path in files if NUMBER.search(path.read_text(encoding="utf-8"))}
    assert found == {HOME}, f"give a colour a name in {HOME} and use the name"


def test_an_unknown_colour_is_named_with_those_that_are_near() -> None:
    with pytest.raises(ValueError, match=r"'oranje' in templates/colours.toml; did you mean orange"):
        find_colour("oranje")

"""The published stability.json: of the shape that the page reads, and in agreement with itself and with theory."""

import math
from pathlib import Path
from typing import Any

import pytest
from gnomon.harness.reporting import sidecars
from gnomon.harness.stability.panel import panels
from gnomon.harness.stability.panel_run import Row, tiers_of

PUBLISHED = Path(__file__).parents[3] / "reports" / "stability.json"


@pytest.fixture(scope="module")
def found() -> dict[str, Any]:
    """The data that the page would show; a file of another shape is refused here."""
    return dict(sidecars.read(PUBLISHED))


def test_each_of_its_integrators_has_a_row_of_each_of_its_panels_at_the_full_grids(found: dict[str, Any]) -> None:
    """The file is of the revision that made it: integrators registered since then are not in it, see `make publication`."""
    assert found["depth"] == "high"
    measured = {(row["integrator"], row["panel"]) for row in found["rows"]}
    assert measured == {(name, panel) for name, _ in measured for panel in found["panels"]}


def test_limits_are_those_of_theory(found: dict[str, Any]) -> None:
    """Limits of the exponential series: sqrt 8 for RK4, sqrt 3 for RK3; 2 for Verlet; none for Gauss methods."""
    rows = {row["integrator"]: row["data"] for row in found["rows"] if row["panel"] == "linear"}
    for name, limit in (("gnomon:RK4", math.sqrt(8)), ("gnomon:RK3", math.sqrt(3)), ("rebound:leapfrog", 2.0)):
        assert rows[name]["imaginary"]["stable"][0][1] == pytest.approx(limit, rel=1e-3)
    gauss = rows["gnomon:Gauss 2-stage"]["imaginary"]
    assert gauss["stable"] == [[0.0, gauss["scanned_to"]]]


def test_sentences_and_tiers_follow_from_the_numbers(found: dict[str, Any]) -> None:
    rows = [Row(**row) for row in found["rows"]]
    for row in rows:
        if row.reason is None:
            assert list(row.sentences) == panels()[row.panel].sentences(row.data), (row.integrator, row.panel)
    again = tiers_of(rows)
    assert {name: one["tiers"] for name, one in again.items()} == {
        name: one["tiers"] for name, one in found["tiers"].items()
    }

"""The figures of stability show the numbers of the file at their places, and nothing where there is none."""

import math
import re
from typing import Any

import numpy as np
import pytest
import vl_convert
from gnomon.harness.reporting.report_stability import _bars, stability_charts

NAMES = ("gnomon:RK4", "mine:stepper")
LINEAR = {"id": "imaginary", "title": "stable on vibrations at h w", "decades": True, "ends": [0.1, 60.0]}
POWER = {"id": "power", "title": "power", "decades": False, "ends": None}


def mark(
    column: str, at: float | None = None, low: float | None = None, high: float | None = None, text: str = ""
) -> Any:
    return {"column": column, "at": at, "low": low, "high": high, "text": text}


def euler_region(spacing: float = 0.1) -> dict[str, Any]:
    """|1 + z|, the stability function of explicit Euler."""
    real, heights = np.linspace(-6, 2, round(8 / spacing) + 1), np.linspace(0, 6, round(6 / spacing) + 1)
    modulus = np.abs(1 + real[None, :] + 1j * heights[:, None])
    return {"real": [-6, 2], "imaginary": [0, 6], "spacing": spacing, "modulus": modulus.tolist()}


def found(*marks: Any, cells: bool = False, columns: Any = (LINEAR, POWER)) -> dict[str, Any]:
    rows = [
        {"integrator": name, "panel": "linear", "data": {}, "sentences": [], "marks": list(marks)} for name in NAMES
    ]
    return {"figures": {"linear": {"cells": cells, "columns": list(columns)}}, "rows": rows}


def values(chart: Any, column: str) -> list[dict[str, Any]]:
    return list(chart.to_dict()["datasets"][column])


def test_numbers_are_at_their_decade_and_at_the_end_of_the_axis_beyond_it() -> None:
    charts = stability_charts(
        found(mark("imaginary", math.sqrt(8), 0.0, 1e6, "limit 2.828"), mark("power", 0.5, 0.4, 0.6))
    )
    (row, _) = values(charts["stability_linear"], "imaginary")
    assert row["at"] == pytest.approx(math.log10(math.sqrt(8)), rel=1e-3)
    assert (row["low"], row["high"]) == pytest.approx((-1, math.log10(60)), rel=1e-3)
    assert values(charts["stability_linear"], "power")[0]["at"] == 0.5


def test_what_has_no_number_is_written_out() -> None:
    (row, _) = values(stability_charts(found(mark("power", text="lost after 3 periods")))["stability_linear"], "power")
    assert row["told"] == "lost after 3 periods"
    assert row["at"] is row["low"] is row["high"] is None


def test_columns_without_marks_and_marks_without_columns_are_left_out() -> None:
    assert stability_charts(None) == {}
    assert stability_charts({"rows": []}) == {}
    assert stability_charts(found(mark("elsewhere", 1.0))) == {}
    chart = stability_charts(found(mark("power", 1.0), mark("elsewhere", 1.0)))["stability_linear"]
    assert len(chart.to_dict()["hconcat"]) == 1


def test_the_region_of_euler_is_the_circle_about_minus_1() -> None:
    bars = _bars(euler_region())
    assert bars
    for bar in bars:
        height = 0.0 if bar["low"] == 0 else (bar["low"] + bar["high"]) / 2
        half = math.sqrt(max(1 - height**2, 0))
        assert (bar["from"], bar["to"]) == pytest.approx((-1 - half, -1 + half), abs=0.03)
    assert max(bar["high"] for bar in bars) == pytest.approx(1, abs=0.06)


@pytest.mark.parametrize(
    "region", [None, 3, {}, {"modulus": "x"}, {"modulus": [[1], [1, 2]]}, euler_region() | {"real": 1}]
)
def test_what_is_no_grid_draws_nothing(region: Any) -> None:
    assert _bars(region) == []


@pytest.mark.parametrize("cells", [False, True])
def test_every_figure_can_be_drawn_and_names_its_integrators(cells: bool) -> None:
    content = found(mark("imaginary", 0.7, 0.2, 0.9, "7/10 at 0.1"), mark("power", text="refused"), cells=cells)
    content["rows"][0]["data"] = {"region": euler_region(0.4)}
    charts = stability_charts(content)
    assert set(charts) == {"stability_linear", "stability_regions"}
    drawn = {name: vl_convert.vegalite_to_svg(chart.to_dict()) for name, chart in charts.items()}
    names = [drawn["stability_linear"].index(f">{name}<") for name in NAMES]
    assert names[1] < names[0], "third parties and a user's own are above gnomon's"
    assert all(name in drawn["stability_linear"] for name in NAMES)
    assert NAMES[0] in drawn["stability_regions"]
    assert "7/10" in drawn["stability_linear"] or not cells


def test_each_region_has_its_own_bars_only() -> None:
    """A method with a smaller disc has fewer bars; each figure once had the bars of all methods."""
    content = found(mark("imaginary", 0.7))
    small = euler_region()
    small["modulus"] = (3 * np.array(small["modulus"])).tolist()  # a disc of a third of the radius
    content["rows"][0]["data"], content["rows"][1]["data"] = {"region": euler_region()}, {"region": small}
    drawn = vl_convert.vegalite_to_svg(stability_charts(content)["stability_regions"].to_dict())
    groups = re.findall(r'<g class="mark-rect [^>]*aria-roledescription="rect mark container">(.*?)</g>', drawn)
    assert [group.count("<path") for group in groups] == [len(_bars(small)), len(_bars(euler_region()))]

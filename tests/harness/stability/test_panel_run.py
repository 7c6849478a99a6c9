"""Panels are measured in processes of their own: a crash or a hang of an integrator is a row, and the others go on."""

import json
import os
from typing import Any

import planted_methods
import pytest
from gnomon.harness.contract.integrator import Steps
from gnomon.harness.registry import lookup
from gnomon.harness.stability import panel_run
from gnomon.harness.stability.panel import Panel, panels
from gnomon.harness.verification.function_adapter import from_step


def dies(f: Any, t: float, y: Any, h: float) -> Any:
    os._exit(7)


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two panels in place of all, which measure the numbers of the panel of stiffness."""

    def measure(integrator: Any, seconds: float) -> dict[str, Any]:
        return panels()["stiffness"].measure(integrator, seconds)

    found = {
        name: Panel(name, name, lambda integrator: None, measure, lambda data: ["use it"])
        for name in ("linear", "resonance")
    }
    monkeypatch.setattr(panel_run, "panels", lambda: found)


def test_a_crash_is_a_row_and_the_next_panel_is_measured(quick: None) -> None:
    broken = from_step(dies, name="dies", order=1, sweep=Steps(0.25, 4))
    rows = panel_run.measure_panels([broken, lookup.own()["gnomon:RK4"]])
    assert [(row.integrator, row.panel) for row in rows] == [
        ("mine:dies", "linear"), ("gnomon:RK4", "linear"), ("mine:dies", "resonance"), ("gnomon:RK4", "resonance")
    ]  # fmt: skip
    assert rows[0].reason == rows[2].reason == "refused: its process ended with exit code 7"
    assert rows[1].reason is None
    assert rows[1].sentences == ["use it"]


def test_a_hang_ends_at_the_limit(quick: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of processor time, or by the clock where the machine gives it little."""
    monkeypatch.setattr(panel_run, "LONGEST", 0.2)
    (row,) = panel_run.measure_panels([planted_methods.hanging], ["linear"])
    assert row.reason in ("refused: no answer within 0.4 s of processor time", "refused: no answer within 4 s")


def test_a_library_that_is_missing_is_named(quick: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        panel_run.lookup, "missing", lambda integrator: "heyoka is not installed: pip install 'gnomon[peers]'"
    )
    rows = panel_run.measure_panels([lookup.own()["gnomon:RK4"]])
    assert {row.reason for row in rows} == {"refused: heyoka is not installed: pip install 'gnomon[peers]'"}


def test_wrong_names_are_refused_with_the_nearest() -> None:
    with pytest.raises(ValueError, match="no panel is called 'linaer'; did you mean linear"):
        panel_run.measure_panels([planted_methods.good_rk4], ["linaer"])
    with pytest.raises(ValueError, match="no depth is called 'hihg'; did you mean high"):
        panel_run.measure_panels([planted_methods.good_rk4], ["linear"], "hihg")


def test_the_json_names_its_schema_the_revision_and_the_machine(quick: None) -> None:
    rows = panel_run.measure_panels([lookup.own()["gnomon:RK4"]], ["linear"])
    found = json.loads(panel_run.as_json(rows, "normal"))
    assert found["schema"] == panel_run.SCHEMA
    assert {"machine", "gnomon", "sources"} <= set(found["environment"])
    assert found["panels"] == {"linear": "linear"}
    assert [(row["integrator"], row["panel"]) for row in found["rows"]] == [("gnomon:RK4", "linear")]
    assert found["rows"][0]["seconds"] >= 0


def test_tiers_compare_the_methods_that_were_measured() -> None:
    def row(method: str, lost: float) -> panel_run.Row:
        one = {"lost": lost, "failed": None, "calls": None, "complete": True, "levelled": True}
        variants = {f"case{k}/hard": one for k in range(8)}
        return panel_run.Row(method, "digits", 0.0, {"variants": variants}, [])

    refused = panel_run.Row("none", "digits", 0.0, {"refused": "no"}, [])
    assert panel_run.tiers_of([row("bad", 5.0), row("good", 1.0), refused])["lost_digits"]["tiers"] == [
        ["good"],
        ["bad"],
    ]
    assert panel_run.tiers_of([row("good", 1.0), refused]) == {}

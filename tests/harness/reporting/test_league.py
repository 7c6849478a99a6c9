"""The league of engines on the page and in `gnomon engine`: each number is one of the file, and nothing is left out."""

import json
from pathlib import Path

import planted_sidecars
import pytest
from gnomon.cases import get
from gnomon.harness.commands.published.engine import describe
from gnomon.harness.reporting.page.league import league
from gnomon.harness.results.advice import engine_facts

SHIPPED = "pybullet:stepSimulation [as shipped]"

UNBROKEN = 10**6
"""Columns into which each line fits."""


@pytest.fixture
def found(tmp_path: Path) -> dict:
    planted_sidecars.write(tmp_path)
    made = league(tmp_path)
    assert made is not None
    return made


def test_without_a_file_there_is_no_section(tmp_path: Path) -> None:
    assert league(tmp_path) is None


def test_every_scene_has_a_picture_and_the_row_of_every_engine(found: dict) -> None:
    assert [scene["name"] for scene in found["scenes"]] == ["pendulum_simple/engines", "billiard_ball/engines"]
    for scene in found["scenes"]:
        assert scene["picture"].startswith("<svg")
        assert "binary32" in scene["picture"]
    reasons = [row["reason"] for row in found["scenes"][1]["rows"]]
    assert reasons == ["", "refused: it did not move"]


def test_the_parts_of_an_error_are_those_of_the_file(found: dict) -> None:
    pendulum, billiard = (scene["rows"][0] for scene in found["scenes"])
    assert (pendulum["integration"], pendulum["model"], pendulum["solver"]) == ("order 1.00", "none seen", "")
    assert billiard["integration"] == "no steady order"
    assert "1.9e-3" in billiard["model"].replace("e-03", "e-3")


def test_what_failed_and_what_differs_is_said(found: dict) -> None:
    configured, shipped = found["ways"]
    assert configured["cost"]["bits"] == "differ in two threads"
    assert configured["passed"] == "1 of 1"
    assert shipped["passed"] == "0 of 1"
    assert shipped["cost"]["reason"] == "its process was killed"
    assert [row["name"] for row in found["failed"]] == ["damping"]
    assert found["table"][1]["lacks"]


def test_the_command_says_what_the_file_says() -> None:
    text = "\n".join(describe(json.loads(json.dumps(planted_sidecars.LEAGUE)), "pybullet", UNBROKEN))
    assert "no curve as a constraint" in text
    assert "error 0.32 (step / time scale)^1.00 on 1 of 1 scene" in text
    assert "no steady order on 1 scene" in text
    assert f"{SHIPPED}: damping, 1 scene: speed falls by 4 %" in text


def test_an_engine_is_found_by_its_name_or_title_and_another_name_is_refused() -> None:
    assert engine_facts.library_of(planted_sidecars.LEAGUE, "PyBullet") == "pybullet"
    with pytest.raises(ValueError, match=r"pybulet.*pybullet"):
        engine_facts.library_of(planted_sidecars.LEAGUE, "pybulet")


def test_the_kinds_of_scenes_cover_every_scene() -> None:
    assert engine_facts.kind_of(get("pendulum_simple").scene.needs) == "joints and ropes"  # type: ignore[union-attr]
    assert engine_facts.kind_of(get("bouncing_ball").scene.needs) == "impact"  # type: ignore[union-attr]
    assert engine_facts.kind_of(get("kepler_orbit").scene.needs) == engine_facts.POINTS  # type: ignore[union-attr]


def test_the_installed_file_has_all_that_the_command_says() -> None:
    kept = engine_facts.reduce_to_installed(planted_sidecars.LEAGUE)
    assert [*describe(kept, "pybullet", UNBROKEN)] == [*describe(planted_sidecars.LEAGUE, "pybullet", UNBROKEN)]
    assert all("points" not in row for row in kept["rows"])
    assert [row["scene"] for row in kept["rows"]] == [row["scene"] for row in planted_sidecars.LEAGUE["rows"]]  # type: ignore[attr-defined, index]

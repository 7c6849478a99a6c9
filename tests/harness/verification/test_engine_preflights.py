"""`gnomon verify --engine` runs pre-flights, names those that fail, and fails if it checked nothing."""

import json
import os
import re
from pathlib import Path

import pytest
from command_line import gnomon
from gnomon.cases.core.scene import Scene
from gnomon.harness.studies.preflight import TEXTS
from gnomon.harness.verification.claims import Outcome
from gnomon.harness.verification.engine_adapter import from_engine
from gnomon.harness.verification.engine_preflights import preflight_rows
from gnomon.harness.verification.verification_report import FAILED, NOT_VERIFIED
from gnomon.harness.verification.verify import Row
from rigid_engine import RigidEngine

HERE = Path(__file__).parent


def verified(engine: str, *options: str) -> int:
    """The exit code of the command."""
    return gnomon("verify", "--engine", engine, "--depth", "low", *options)


def test_the_engine_of_the_page_passes(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    monkeypatch.syspath_prepend(HERE)
    names = ("drift", "clamp", "sleep", "first_step", "declared_order", "acceleration", "order_short")
    options = [word for name in names for word in ("--claim", name)]
    assert verified("toy_engine:INTEGRATOR", "--case", "kepler_orbit", *options) == 0
    said = capfd.readouterr().out
    assert "passed acceleration on kepler_orbit" in said
    assert "passed order_short on kepler_orbit" in said
    assert "10 claims checked" in said


def test_a_pre_flight_that_fails_is_named_with_what_to_look_at(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    written = tmp_path / "found.json"
    assert verified("rigid_engine:CLAMPED", "--claim", "clamp", "--claim", "drift", "--json", str(written)) == FAILED
    said = capfd.readouterr().out
    assert "FAILED clamp on speed_1e3" in said
    assert "FAILED clamp on spin_1e3" in said
    assert "maximum velocities" in said
    assert "FAILED drift" not in said
    assert "gnomon verify --engine rigid_engine:CLAMPED --claim clamp\n" in said
    rows = json.loads(written.read_text())["rows"]
    assert {row["case"]: row["outcome"] for row in rows if row["claim"] == "drift"} == {
        "moving_body": "passed", "spinning_body": "passed",
    }  # fmt: skip


def test_a_known_failure_is_accepted(tmp_path: Path) -> None:
    known = tmp_path / "known.txt"
    scenes = ("speed_1e3", "speed_1e4", "spin_1e3", "turn_1e3")
    known.write_text("".join(f"clamp {scene} our limit\n" for scene in scenes))
    assert verified("rigid_engine:CLAMPED", "--claim", "clamp", "--known-failures", str(known)) == 0


def test_a_verification_that_checked_nothing_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    """The toy engine has no contacts."""
    monkeypatch.syspath_prepend(HERE)
    assert verified("toy_engine:INTEGRATOR", "--claim", "friction") == NOT_VERIFIED
    assert verified("toy_engine:INTEGRATOR", "--claim", "drift", "--max-seconds", "1e-9") == NOT_VERIFIED


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--engine", "gnomon:RK4"), "takes no scenes"),
        (("rigid_engine:SOUND", "--claim", "drift"), "is a pre-flight of an engine"),
        (("--engine", "rigid_engine:SOUND", "--claim", "drifts"), "no claim is called"),
        (("--engine", "rigid_engine:SOUND", "--claim", "drift", "--depth", "lowest"), "no depth is called"),
        (("--engine", "rigid_engine:SOUND", "--claim", "drift", "--case", "kepler_orb"), "no case"),
        (("rigid_engine:SOUND", "--engine", "rigid_engine:SOUND"), "name one engine"),
        (
            ("--engine", "rigid_engine:SOUND", "--claim", "drift", "--case", "kepler_orbit", "--picture", "x.svg"),
            "has no picture",
        ),
    ],
)
def test_wrong_usage_is_named(words: tuple[str, ...], said: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("verify", *words) == 2
    assert said in capfd.readouterr().err


class Crashes(RigidEngine):
    def load(self, scene: Scene) -> None:
        if scene.forces:
            os._exit(3)
        super().load(scene)


def test_an_engine_that_ends_its_process_fails_where_it_does_and_the_rest_is_verified() -> None:
    engine = from_engine(Crashes, name="crashes", tokens=("position_force",))
    shown: list[Row] = []
    chosen = ("drift", "acceleration", "clamp")
    rows = preflight_rows(engine, ["kepler_orbit", "projectile_parabola"], "low", chosen, 2, shown.append)
    found = {(row.claim, row.case): row.finding.outcome for row in rows}
    assert found["acceleration", "kepler_orbit"] == Outcome.FAILED
    assert found["acceleration", "projectile_parabola"] == Outcome.PASSED
    assert found["drift", "moving_body"] == found["clamp", "speed_1e4"] == Outcome.PASSED
    assert sorted(map(repr, shown)) == sorted(map(repr, rows))
    assert [row.claim for row in rows] == sorted(
        (row.claim for row in rows), key=("drift", "clamp", "acceleration").index
    )


@pytest.mark.parametrize("bits", [32, 0])
def test_other_numbers_of_bits_are_refused(bits: int) -> None:
    with pytest.raises(ValueError, match="it is 53, or 24"):
        from_engine(RigidEngine, name="odd", bits=bits)


def test_the_page_lists_every_pre_flight() -> None:
    page = (HERE.parents[2] / "docs" / "engine.md").read_text()
    assert re.findall(r"^\| `(\w+)` \|", page, re.M) == list(TEXTS)

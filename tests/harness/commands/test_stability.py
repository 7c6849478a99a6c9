"""`gnomon stability`: tables, JSON, and wrong usage in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import gnomon


def test_a_table_for_each_panel_and_the_result_as_json(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "new" / "stability.json"
    words = ["--integrator", "gnomon:RK4", "--integrator", "gnomon:DOP853", "--panel", "linear", "--out", str(file)]
    assert gnomon("stability", *words) == 0
    text = capfd.readouterr().out
    assert "Linear stability" in text
    assert "Use it for undamped vibrations up to h w = 2.828" in text
    assert "not applicable: it chooses its own steps" in text
    rows = json.loads(file.read_text())["rows"]
    assert [row["integrator"] for row in rows] == ["gnomon:RK4", "gnomon:DOP853"]
    assert rows[0]["data"]["imaginary"]["stable"][0][1] == pytest.approx(8**0.5, rel=1e-3)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--panel", "linaer"], "no panel is called 'linaer'; did you mean linear"),
        (["--integrator", "RK44"], "did you mean RK4 or RK45"),
        (["--depth", "deep"], "no depth is called 'deep'"),
        (["--workers", "0"], "--workers 0: give a number of processes from 1 to"),
        (["--out", "."], "--out . is a folder; name a file in it"),
    ],
)
def test_wrong_usage_is_one_line(words: list[str], message: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("stability", *words) == 2
    (line,) = capfd.readouterr().err.strip().splitlines()
    assert line.startswith("error: ")
    assert message in line


def test_nothing_measured_is_exit_code_2(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("stability", "--integrator", "gnomon:DOP853", "--panel", "linear") == 2
    assert "nothing was measured" in capfd.readouterr().err

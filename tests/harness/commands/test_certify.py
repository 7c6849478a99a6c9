"""`gnomon certify`: certificates of cases and checks."""

import json
from pathlib import Path

import pytest
from command_line import gnomon


def test_certify_takes_cases_and_checks_by_name(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "certificates.json"
    assert gnomon("certify", "projectile_parabola", "moment_equipollent", "--out", str(path)) == 0
    certificates = json.loads(path.read_text())["rows"]
    assert [c["case"] for c in certificates] == ["projectile_parabola", "moment_equipollent"]
    assert all(c["passed"] and c["digits"] >= 40 for c in certificates)
    assert gnomon("certify", "no_such_thing", "--out", str(path)) == 2
    assert "no case is named 'no_such_thing'" in capfd.readouterr().err

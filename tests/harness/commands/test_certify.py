"""`gnomon certify`: certificates of cases and checks, and where they cannot go."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from command_line import gnomon


def test_where_results_cannot_go_is_said_before_the_work(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("certify", "pendulum_simple", "--to", str(tmp_path)) == 2
    assert capfd.readouterr() == ("", f"error: --to {tmp_path} is a folder; name a file in it\n")
    assert gnomon("certify", "pendulum_simple", "--to", os.devnull) == 2
    assert capfd.readouterr() == ("", f"error: --to {os.devnull} is a device or a pipe; name a file\n")
    if Path("/proc").is_dir():  # nobody can write there, and permissions say that root could
        assert gnomon("certify", "pendulum_simple", "--to", "/proc/a.json") == 2
        captured = capfd.readouterr()
        assert captured.out == ""
        assert captured.err.startswith("error: --to /proc/a.json: cannot be written (")
        assert captured.err.endswith("; name another place with --to\n")


def test_certify_takes_cases_and_checks_by_name(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "certificates.json"
    assert gnomon("certify", "projectile_parabola", "moment_equipollent", "--to", str(path)) == 0
    certificates = json.loads(path.read_text())
    assert [c["case"] for c in certificates] == ["projectile_parabola", "moment_equipollent"]
    assert all(c["passed"] and c["digits"] >= 40 for c in certificates)
    assert gnomon("certify", "no_such_thing", "--to", str(path)) == 2
    assert "no case is named 'no_such_thing'" in capfd.readouterr().err

"""The commands behind `make bench` write the rows of all subjects, and the machine."""

import json
import sys
from pathlib import Path

import pytest
from gnomon.harness.registry import environment
from gnomon.harness.results import study_file


def test_rows_follow_the_subjects_which_may_hold_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "rows.json"
    monkeypatch.setattr(sys, "argv", ["counted", "--out", str(path)])
    study_file.publish("Letters.", dict, [{"a": 2, "b": 1}, {"b": 1}])
    found = json.loads(path.read_text())
    assert found["rows"] == [{"a": 2, "b": 1}, {"b": 1}]
    assert found["environment"]["cpu"] == environment.describe()["cpu"]
    assert list(tmp_path.iterdir()) == [path]

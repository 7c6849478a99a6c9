"""`gnomon ensemble`: its output and its files; wrong usage is in test_command_lines.py."""

import json
from pathlib import Path
from typing import Any

import pytest
from command_line import gnomon
from gnomon.harness.ensembles.ensemble_run import samples_of

from gnomon import load_ensemble

COMMAND = ("ensemble", "--case", "pendulum_simple", "--integrator", "planted_ensembles:Fails")


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("ensemble")
    files = ("--out", str(folder / "found.json"), "--parquet", str(folder / "samples"))
    assert gnomon(*COMMAND, "--samples", "2**10", "--map", "omega", "theta", "--worst", "2", *files) == 0
    return folder


def test_files_hold_the_distribution(results: Path) -> None:
    found = json.loads((results / "found.json").read_text())
    frame = load_ensemble(results / "samples")
    assert found["statuses"] == frame["status"].value_counts().to_dict()
    assert sum(count for _, count in found["bins"]) == frame["error"].notna().sum()
    assert found["map"] == ["omega", "theta"]
    assert (results / "found.png").read_bytes().startswith(b"\x89PNG")
    assert [one["error"] for one in found["worst"]] == frame["error"].nlargest(2).tolist()


def test_the_lines_of_python_reproduce_what_they_say(results: Path) -> None:
    from gnomon.harness.contract.integrator import Refused

    found = json.loads((results / "found.json").read_text())
    names: dict[str, Any] = {}
    exec("\n".join(found["python"]), names)
    for one in found["worst"]:
        assert eval(one["python"], names) == pytest.approx(one["error"], rel=1e-3)  # 1e-9 in states of size 5
    for status in ("refused", "crashed", "diverged"):
        with pytest.raises(Refused, match=status):
            eval(found["failed"][status][0]["python"], names)


def test_the_page_says_what_failed(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon(*COMMAND, "--samples", "300") == 0
    printed = capfd.readouterr()
    assert "300 samples: " in printed.out
    assert "refused" in printed.out
    assert "first crashed, as Python:" in printed.out
    assert "us for the exact state by a formula for many motions; 300 samples about" in printed.out
    assert "power of two" in printed.err


def test_samples_outside_the_domain_are_an_error(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon(*COMMAND, "--samples", "64", "--vary", "g=-2:-1") == 2
    assert "none of 64 samples is in the domain" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("text", "number"),
    [("2**20", 2**20), ("2^10", 1024), ("1e6", 10**6), ("7", 7), ("0.5", -1), ("2**x", -1), ("9**9**9", -1)],
)
def test_numbers_of_samples_are_read(text: str, number: int) -> None:
    assert samples_of(text) == number

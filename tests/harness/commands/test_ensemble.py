"""`gnomon ensemble`: what it prints and writes, and one line for what is wrong."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from command_line import gnomon
from gnomon.harness import load_ensemble
from gnomon.harness.ensembles.ensemble_run import samples_of

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


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--samples", "0"), "--samples 0: give a whole number from 1 to 2**30"),
        (("--samples", "-4"), "give a whole number"),
        (("--samples", "2**31"), "give a whole number"),
        (("--samples", "many"), "--samples many"),
        (("--seed", "-1"), "--seed -1: give a number from 0"),
        (("--times", "0"), "--times 0"),
        (("--worst", "-1"), "--worst -1"),
        (("--workers", "0"), "--workers 0"),
        (("--vary", "thet"), "did you mean theta"),
        (("--vary", "L", "--set", "L=2"), "--set L: it varies"),
        (("--map", "theta", "omega"), "--map: the map is a picture beside --out"),
        (("--map", "theta", "L", "--out", "a.json"), "--map L: it does not vary"),
        (("--out", "a.png"), "end it in .json"),
        (("--setting", "0"), "--setting 0.0: give a positive number"),
        (("--case", "pendulum_simpel"), "did you mean pendulum_simple"),
        (("--case", "bouncing_ball"), "has no form SecondOrder"),
        (("--integrator", "RK44"), "did you mean RK4"),
        (("--vary", "g=-2:-1"), "none of 64 samples is in the domain"),
        (("--integrator", "planted_ensembles:EndsAlways"), "ended its process in the first 32 samples"),
    ],
)  # fmt: skip
def test_wrong_usage_is_one_line(
    arguments: tuple[str, ...],
    message: str,
    capfd: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    samples = () if "--samples" in arguments else ("--samples", "64")
    assert gnomon(*COMMAND, *samples, *arguments) == 2
    error = capfd.readouterr().err
    assert message in error
    assert "Traceback" not in error
    assert list(tmp_path.iterdir()) == []


def test_a_folder_with_files_is_not_written_to(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mine").touch()
    assert gnomon(*COMMAND, "--samples", "64", "--parquet", str(tmp_path)) == 2
    assert "holds files already" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("text", "number"),
    [("2**20", 2**20), ("2^10", 1024), ("1e6", 10**6), ("7", 7), ("0.5", -1), ("2**x", -1), ("9**9**9", -1)],
)
def test_numbers_of_samples_are_read(text: str, number: int) -> None:
    assert samples_of(text) == number

"""`gnomon exact` prints exact states, how they were confirmed, and a hash; it refuses other tasks in one line."""

import hashlib
import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from command_line import gnomon
from gnomon.harness.certification.certify import Certificate
from gnomon.harness.trajectories import exact_states


def printed(capfd: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert gnomon("exact", *arguments) == 0
    return capfd.readouterr().out


def test_states_follow_from_the_numbers_printed_beside_them(capfd: pytest.CaptureFixture[str]) -> None:
    """A parabola, from the doubles in hexadecimal digits, in fractions: every printed digit is right."""
    text = printed(capfd, "projectile_parabola", "--times", "0.1,0x1.999999999999ap-4,1/3", "--digits", "40")
    document: dict[str, Any] = json.loads(text)
    g, x, y, vx, vy = (
        Fraction(float.fromhex(value["hexadecimal"]))
        for value in (document["parameters"] | document["initial_state"]).values()
    )
    assert list(document["initial_state"]) == ["x", "y", "vx", "vy"]
    for row, t in zip(document["states"], (Fraction(1, 10), Fraction(0.1), Fraction(1, 3)), strict=True):
        exact = {"x": x + vx * t, "y": y + vy * t - g * t * t / 2, "vx": vx, "vy": vy - g * t}
        for name, value in exact.items():
            assert abs(Fraction(row[name]) - value) <= abs(value) / 10**39, (row, name)
    assert document["certificate"]["passed"]
    assert set(document["certificate"]["ways"]) >= {"rounding", "residual", "taylor"}


def test_the_hash_is_that_of_the_lines_below_it_and_the_same_in_both_formats(
    capfd: pytest.CaptureFixture[str],
) -> None:
    asked = ("projectile_parabola", "--times", "0.5 1")
    head, rest = printed(capfd, *asked, "--format", "csv").split("# sha256 of the lines below: ")
    digest, _, below = rest.partition("\n")
    assert hashlib.sha256(below.encode()).hexdigest() == digest
    assert "certificate: confirmed to 50 digits" in head
    assert json.loads(printed(capfd, *asked))["sha256"] == digest
    other = printed(capfd, *asked, "--set", "g=9.8100000000000005")  # the next parse to the same double
    assert json.loads(other)["sha256"] == digest
    changed = printed(capfd, *asked, "--set", "g=9.810000000000002")  # the next double
    assert json.loads(changed)["sha256"] != digest


def test_times_come_from_a_file_and_by_default_from_the_case(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "times.txt").write_text("0.25\n0.5, 0.75\n")
    document = json.loads(printed(capfd, "projectile_parabola", "--times", str(tmp_path / "times.txt")))
    assert [row["t"] for row in document["states"]] == ["0.25", "0.5", "0.75"]
    document = json.loads(printed(capfd, "projectile_parabola", "--digits", "17"))
    assert len(document["states"]) == 64
    assert all(float.fromhex(row["t"]) > 0 for row in document["states"])


@pytest.mark.parametrize(
    "text", ["t\n0.25\n0.5\n", "# a log\nx;time [s]\n7;0.25\n8;0.5\n", '"Time",x\n0.25,7\n0.5,8\n']
)
def test_times_come_from_the_column_that_a_header_names(
    text: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "log.csv").write_text(text)
    document = json.loads(printed(capfd, "projectile_parabola", "--times", str(tmp_path / "log.csv")))
    assert [row["t"] for row in document["states"]] == ["0.25", "0.5"]


def test_a_header_without_a_time_is_refused_with_its_names(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.csv").write_text("x,y\n1,2\n")
    assert gnomon("exact", "projectile_parabola", "--times", str(tmp_path / "log.csv")) == 2
    assert "it has x, y" in capfd.readouterr().err


def test_its_own_output_is_a_file_of_times(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    asked = ("projectile_parabola", "--set", "vx=2", "--format", "csv", "--times")
    text = printed(capfd, *asked, "0.25,0.5")
    (tmp_path / "exact.csv").write_text(text)
    assert printed(capfd, *asked, str(tmp_path / "exact.csv")) == text
    assert text.splitlines()[-1].startswith("0.5,1.0,")  # a start by its name: 2 m/s for 0.5 s


def test_a_time_after_the_span_extends_the_motion(capfd: pytest.CaptureFixture[str]) -> None:
    """An elastic ball that falls 1 m at 2 m/s^2 takes 1 s to the ground: its period is 2 s, and 1000.5 is like 0.5."""
    asked = ("bouncing_ball", "--set", "e=1", "--set", "g=2", "--times", "1000.5", "--format", "csv")
    assert printed(capfd, *asked).splitlines()[-1] == "1000.5,0.75,-1.0"


def test_a_motion_that_is_not_confirmed_is_a_failure(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    poor = Certificate("projectile_parabola", "default", {"rounding": 50.0, "residual": 50.0, "taylor": 12.0})
    monkeypatch.setattr(exact_states, "certify", lambda case: poor)
    assert gnomon("exact", "projectile_parabola", "--times", "1") == 1
    caught = capfd.readouterr()
    assert not json.loads(caught.out)["certificate"]["passed"]
    assert "taylor agrees to 12" in caught.err

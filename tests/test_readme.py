"""The README's integrator runs unchanged, by path and by entry point; its commands run and print what it shows."""

import math
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from command_line import gnomon

README = Path(__file__).parent.parent / "README.md"
LONGEST = 30
FILES = {
    name: re.findall(rf"`{name}`:\n\n```python\n(.*?)```", README.read_text(), re.S)
    for name in ("midpoint.py", "swing.py")
}
"""The files that the README tells its reader to write, each once."""
SHOWN = dict(re.findall(r"```\n(gnomon [^\n]*)\n```\n\n```text\n(.*?)```", README.read_text(), re.S))
"""The README's commands, each with the lines that it shows of the output."""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with the README's files and the metadata that installing its integrator would leave."""
    for name, (source,) in FILES.items():
        assert len(source.splitlines()) <= LONGEST
        (tmp_path / name).write_text(source)
    page = README.parent / "docs" / "integrator.md"
    (entry,) = re.findall(r"```\n(\[project\.entry-points.*?)```", page.read_text(), re.S)
    metadata = tmp_path / "midpoint-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: midpoint\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(
        entry.replace('[project.entry-points."gnomon.integrators"]', "[gnomon.integrators]").replace('"', "")
    )
    return tmp_path


def test_the_integrator_of_the_readme_passes_its_verification(project: Path) -> None:
    """By the README's own command: an example that fails would say that the tool, or the example, is wrong."""
    (line,) = re.findall(r"^gnomon (verify midpoint:midpoint --depth low)$", README.read_text(), re.M)
    command = [str(Path(sys.executable).parent / "gnomon"), *shlex.split(line)]
    environment = os.environ | {"PYTHONPATH": str(project)}
    done = subprocess.run(command, cwd=project, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.search(r"mine:midpoint: [1-9]\d* claims checked", done.stdout)


def run(project: Path, named: str) -> pd.DataFrame:
    """The trials that succeeded, from the smallest setting on, of a run whose limit stops none of them."""
    from gnomon import load

    environment = os.environ | {"PYTHONPATH": str(project)}
    results = project / "mine.sqlite"
    command = [str(Path(sys.executable).parent / "gnomon")]
    command += [
        "run", "--suite", "quick", "--limit", "300", "--case", "pendulum_simple", "--integrator", named, "--out",
        str(results),
    ]  # fmt: skip
    done = subprocess.run(command, cwd=project, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    table = load(results)
    assert set(table["integrator_id"]) == {"mine:midpoint"}
    return table[table["status"] == "ok"].sort_values("setting")


def test_the_integrator_of_the_readme_is_found_by_its_entry_point(project: Path) -> None:
    assert len(run(project, "midpoint")) >= 1


def test_the_integrator_of_the_readme_runs_by_path_and_has_its_order(project: Path) -> None:
    good = run(project, "midpoint:midpoint")
    assert len(good) >= 4
    # second order: half the step, a quarter of the error, at the small steps
    ratio = good["error_max"].iloc[1] / good["error_max"].iloc[0]
    assert 3.5 < ratio < 4.5


def test_the_options_of_the_readme_exist(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from gnomon.harness.commands import cli

    monkeypatch.setenv("COLUMNS", "200")
    assert len(SHOWN) == 4
    for line in SHOWN:
        _, command, *arguments = shlex.split(line)
        monkeypatch.setattr("sys.argv", ["gnomon", command, "--help"])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        assert not ended.value.code
        text = capfd.readouterr().out
        for option in (word for word in arguments if word.startswith("--")):
            assert option in text


def test_the_files_of_the_readme_exist() -> None:
    for target in re.findall(r"\]\(([^)]+)\)", README.read_text()):
        assert (README.parent / target).is_file()


def _write_swing(path: Path) -> None:
    """The README's trajectory: a pendulum of 2 m by the classical Runge-Kutta method, 100 steps a second, in degrees."""

    def f(y: Any) -> Any:
        return np.array([y[1], -9.81 / 2 * math.sin(y[0])])

    y, h, lines = np.array([2.0, 0.0]), 0.01, ["time,phi,w"]
    for k in range(1001):
        lines.append(f"{k * h:.2f},{math.degrees(y[0]):.7f},{math.degrees(y[1]):.7f}")
        a = f(y)
        b = f(y + h / 2 * a)
        c = f(y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + f(y + h * c))
    path.write_text("\n".join(lines))


def _shown_lines(line: str) -> list[str]:
    """The lines that the README shows of the output of a command, without the marks of omitted lines."""
    found = [each for each in SHOWN[line].splitlines() if each != "..."]
    assert found
    return found


def _begin(line: str) -> str:
    """The part of a line before its first number: numbers, and the fastest method, differ from machine to machine."""
    return re.split(r"\d", line)[0]


def test_the_recommendation_of_the_readme_is_the_published_one(capfd: pytest.CaptureFixture[str]) -> None:
    """To the digit, as it comes from the table of the last publication."""
    (line,) = (each for each in SHOWN if each.startswith("gnomon recommend"))
    assert gnomon(*shlex.split(line)[1:]) == 0
    assert set(_shown_lines(line)) <= set(capfd.readouterr().out.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize("line", SHOWN)
def test_a_command_of_the_readme_prints_the_lines_that_it_shows(line: str, project: Path) -> None:
    """Up to their first numbers."""
    _write_swing(project / "swing.csv")
    command = [str(Path(sys.executable).parent / "gnomon"), *shlex.split(line)[1:]]
    environment = os.environ | {"COLUMNS": "120"}
    done = subprocess.run(command, cwd=project, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    printed = {_begin(each) for each in (done.stdout + done.stderr).splitlines()}
    assert {_begin(each) for each in _shown_lines(line)} <= printed, done.stdout + done.stderr

"""The README's integrator runs unchanged, by path and by entry point; its commands and files exist."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

README = Path(__file__).parent.parent / "README.md"
LONGEST = 30


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with the README's file and the metadata that installing it would leave."""
    (source,) = (block for block in re.findall(r"```python\n(.*?)```", README.read_text(), re.S) if "midpoint" in block)
    assert len(source.splitlines()) <= LONGEST
    (tmp_path / "midpoint.py").write_text(source)
    (entry,) = re.findall(r"```\n(\[project\.entry-points.*?)```", README.read_text(), re.S)
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


def _commands() -> list[list[str]]:
    """The commands of the section "Use", without their comments."""
    (block,) = re.findall(r"## Use\n\n```\n(.*?)```", README.read_text(), re.S)
    return [shlex.split(line, comments=True) for line in block.splitlines()]


def test_the_options_of_the_readme_exist(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from gnomon.harness.commands import cli

    monkeypatch.setenv("COLUMNS", "200")
    for _, command, *arguments in _commands():
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


@pytest.mark.slow
def test_the_commands_of_the_readme_run(tmp_path: Path) -> None:
    """In their order, unchanged; `compare` on the run of the command before it; suites, which take ten minutes, are left out."""
    for words in _commands():
        if "--suite" in words:
            continue
        named = {"BASE.sqlite": "runs/kepler.sqlite", "RUN.sqlite": "runs/kepler.sqlite"}
        command = [str(Path(sys.executable).parent / "gnomon"), *(named.get(word, word) for word in words[1:])]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
    for name in ("pendulum.svg", "runs/kepler/index.html", "runs/certificates.json", "results.csv"):
        assert (tmp_path / name).stat().st_size > 100

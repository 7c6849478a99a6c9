"""The command line: its output for people. tests/attacks/test_command_lines.py has wrong command lines."""

import json
import os
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
from command_line import gnomon
from gnomon.harness.results import store


@pytest.mark.parametrize("step", ["find_all", "missing"])
def test_an_interruption_is_quiet(
    step: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from gnomon.harness.registry import lookup

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(lookup, step, interrupt)
    assert gnomon("run", "--case", "pendulum_simple", "--integrator", "gnomon:RK4") == 130
    assert capfd.readouterr() == ("", "")


def test_alone_it_shows_its_help(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon() == 2
    captured = capfd.readouterr()
    assert "certify" in captured.out + captured.err


def test_run_export_and_compare_work_together(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    run = ("run", "--case", "planted:Short", "--integrator", "planted:Sound", "--suite", "quick", "--limit", "300")
    assert gnomon(*run, "--out", str(tmp_path)) == 0
    assert "measurements" in capfd.readouterr().out
    target = tmp_path / "rows.json"
    assert gnomon("export", str(tmp_path), "--format", "json", "--out", str(target)) == 0
    rows = json.loads(target.read_text())
    assert len(rows) == len(store.load(tmp_path))
    assert {row["integrator_id"] for row in rows} == {"planted:sound"}
    assert gnomon("compare", str(tmp_path), str(tmp_path)) == 0
    assert "0 regressions" in capfd.readouterr().out


def test_help_starts_without_heavy_libraries() -> None:
    """numpy, pandas and numba take most of a second to load, and help and usage errors are wanted at once."""
    program = "import sys; from gnomon.harness.commands import cli; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert "typer" in loaded
    assert not {"numpy", "scipy", "pandas", "numba", "mpmath", "altair"} & set(loaded)


@pytest.mark.parametrize("command", ["--help", "show bouncing_ball", "show pendulum_simple --latex"])
def test_a_reader_that_ends_first_ends_the_command_without_a_message(command: str) -> None:
    """As in `gnomon list | head`. The exit code is not 0: the result may not have been read.

    Typer prints the help, Rich tables, and Python some lines, which it holds back until its end.
    """
    program = "from gnomon.harness.commands import cli; cli.main()"
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as closed:
        arguments = [sys.executable, "-c", program, *command.split()]
        done = subprocess.run(arguments, stdout=closed, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (141, "")


def test_a_shell_completes_commands(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    for name, value in (("_GNOMON_COMPLETE", "complete_bash"), ("COMP_WORDS", "gnomon\nli"), ("COMP_CWORD", "1")):
        monkeypatch.setenv(name, value)
    assert gnomon() == 0
    assert capsys.readouterr() == ("list\n", "")


def test_the_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    assert gnomon("--version") == 0
    assert capsys.readouterr().out == f"gnomon {version('gnomon')}\n"


def test_every_command_takes_cases_and_integrators_by_the_same_options() -> None:
    """What a command is about is its argument, and has the option too; everything else has the option alone."""
    import typer
    from gnomon.harness.commands.cli import app

    group: Any = typer.main.get_command(app)
    commands = {name: each for name, each in group.commands.items() if name != "baseline"}
    commands["write"] = group.commands["baseline"].commands["write"]
    with_case = {"show", "exact", "scene", "run", "ensemble", "verify", "write", "certify", "check"}
    with_integrator = {"run", "ensemble", "verify", "write", "stability"}
    for name, command in commands.items():
        named = {option for each in command.params for option in each.opts}
        assert not {"--cases", "--integrators", "--method"} & named
        assert ("--to" in named) == (name == "check")  # a time; a file that is written is --out
        assert ("--integrator" in named) == (name in with_integrator)
        assert ("--case" in named) == (name in with_case | {"plot", "report"})  # of a report: code that may be imported
        for subject in {"case", "integrator"} & {each.name for each in command.params if each.opts == [each.name]}:
            assert f"--{subject}" in named

"""The command line: what people read, and one clear line with exit code 2 for what is wrong."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from command_line import gnomon
from gnomon.harness.results import schema, store


@pytest.fixture
def text_file(tmp_path: Path) -> str:
    path = tmp_path / "notes.sqlite"
    path.write_text("no database, though it is as long as the header of one would have to be, to be safe" * 5)
    return str(path)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["show", "pendulum_simpel"], "no case is named 'pendulum_simpel'; did you mean pendulum_simple"),
        (["show", "pendulum_simple/separatrx"], "has no variant 'separatrx'; did you mean separatrix"),
        (["show", "pendulum_simple", "--set", "g=-1"], "g = -1 is outside (0, inf)"),
        (["show", "pendulum_simple", "--set", "g=nan"], "g = nan is not finite"),
        (["show", "pendulum_simple", "--set", "g=1e400"], "g = 1e400 (about) is too large"),
        (["show", "euler_top", "--set", "I3=50"], "the triangle inequality"),
        (["show", "pendulum_simple", "--set", "length=1"], "has no parameter 'length'"),
        (["show", "pendulum_simple", "--set", "g"], "write name=value"),
        (["show", "pendulum_simple", "--plot", "motion.docx"], "motion.docx: the name must end in one of .svg, .png"),
        (["run", "--case", "pendulum_simple", "--integrator", "RK44"], "did you mean RK4 or RK45"),
        (["run", "--integrator", "no_such_module:Thing"], "give package.module:Class"),
        (["run", "--integrator", "folder/my_method.py:step"], "give the module and not its file: my_method:step"),
        (["run", "--integrator", "planted:SUITE"], "give package.module:Class"),
        (["run", "--integrator", ":X:"], ":X:: ValueError: Empty module name"),
        (["run", "--case", "moment_equipollent"], "is a check, without motion: `gnomon certify moment_equipollent`"),
        (["run", "--workers", "0"], "--workers 0: give a number of processes from 1 to"),
        (["run", "--no-such-option"], "No such option: --no-such-option (see gnomon run --help)"),
        (["export"], "Missing argument"),
        (["export", "x", "--format", "xls"], "is not one of 'csv', 'json', 'parquet'"),
        (["no_such_command"], "No such command 'no_such_command'. (see gnomon --help)"),
        (["run", "--suite", "slow"], "no suite is called 'slow'"),
        (["run", "--limit", "-1", "--case", "pendulum_simple"], "a trial needs a positive number of seconds"),
        (["report", "no_such_folder"], "no results here"),
        (["export", "no_such_folder"], "no results here"),
        (["compare", "no_such_folder", "no_such_folder"], "no results here"),
    ],
)
def test_wrong_usage_is_one_clear_line(arguments: list[str], message: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon(*arguments) == 2
    captured = capfd.readouterr()
    assert captured.out == ""
    (line,) = captured.err.strip().splitlines()
    assert line.startswith("error: ")
    assert message in line


def test_foreign_files_are_named(text_file: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    foreign = tmp_path / "foreign.sqlite"
    with sqlite3.connect(foreign) as db:
        db.execute("CREATE TABLE t (x)")
    for arguments in (
        ["report", text_file],
        ["export", str(foreign)],
        ["run", "--case", "pendulum_simple", "--out", text_file],
    ):
        assert gnomon(*arguments) == 2
        (line,) = capfd.readouterr().err.strip().splitlines()[-1:]
        assert line.startswith("error: ")
        assert "gnomon" in line


@pytest.mark.parametrize(
    ("application", "version", "message"),
    [
        (None, 0, "an empty file"),
        (schema.APPLICATION_ID, schema.SCHEMA_VERSION + 1, "upgrade gnomon"),
        (schema.APPLICATION_ID, schema.SCHEMA_VERSION, "damaged (it holds the table t, which gnomon does not make)"),
    ],
)
def test_results_that_cannot_be_read_are_one_line(
    application: int | None, version: int, message: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "results.sqlite"
    path.touch()
    if application is not None:
        with sqlite3.connect(path) as db:
            db.execute(f"PRAGMA application_id = {application}")
            db.execute(f"PRAGMA user_version = {version}")
            db.execute("CREATE TABLE t (x)")
    for arguments in (["report", str(path)], ["export", str(tmp_path)], ["compare", str(path), str(path)]):
        assert gnomon(*arguments) == 2
        (line,) = capfd.readouterr().err.strip().splitlines()
        assert line.startswith(f"error: {path}: ")
        assert message in line


@pytest.mark.parametrize("step", ["find_all", "missing"])
def test_an_interruption_is_quiet(
    step: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from gnomon.harness.registry import lookup

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(lookup, step, interrupt)
    assert gnomon("run", "--case", "pendulum_simple", "--integrator", "RK4") == 130
    assert capfd.readouterr() == ("", "")


def test_alone_it_shows_its_help(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon() == 2
    captured = capfd.readouterr()
    assert "certify" in captured.out + captured.err


def test_run_export_and_compare_work_together(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    run = ("run", "--case", "planted:Short", "--integrator", "planted:Sound", "--suite", "quick", "--limit", "0.05")
    assert gnomon(*run, "--out", str(tmp_path)) == 0
    assert "measurements" in capfd.readouterr().out
    target = tmp_path / "rows.json"
    assert gnomon("export", str(tmp_path), "--format", "json", "--to", str(target)) == 0
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


def test_a_reader_that_ends_first_ends_the_command_without_a_message() -> None:
    """As in `gnomon list | head`. The exit code is not 0: the result may not have been read."""
    program = "from gnomon.harness.commands import cli; cli.main()"
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as closed:
        arguments = [sys.executable, "-c", program, "show", "bouncing_ball"]
        done = subprocess.run(arguments, stdout=closed, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (141, "")


def test_a_shell_completes_commands(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    for name, value in (("_GNOMON_COMPLETE", "complete_bash"), ("COMP_WORDS", "gnomon li"), ("COMP_CWORD", "1")):
        monkeypatch.setenv(name, value)
    assert gnomon() == 0
    assert capsys.readouterr() == ("list\n", "")


def test_the_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    assert gnomon("--version") == 0
    assert capsys.readouterr().out == f"gnomon {version('gnomon')}\n"

"""The command line: what people read, and one clear line with exit code 2 for what is wrong."""

from __future__ import annotations

import json
import os
import sqlite3
import sys
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
        (["show", "pendulum_simple", "--plot", "motion.docx"], "motion.docx: a drawing is .svg, .png, .html"),
        (["run", "--case", "pendulum_simple", "--integrator", "RK44"], "did you mean RK4 or RK45"),
        (["run", "--integrator", "no_such_module:Thing"], "give package.module:Class"),
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


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs a folder in which nobody can write")
def test_results_that_cannot_be_written_are_one_line(capfd: pytest.CaptureFixture[str]) -> None:
    arguments = ("run", "--case", "planted:Short", "--integrator", "planted:Sound", "--suite", "quick")
    assert gnomon(*arguments, "--out", "/proc/results.sqlite") == 2
    line = capfd.readouterr().err.strip().splitlines()[-1]
    assert line.startswith("error: --out /proc/results.sqlite: cannot be written")


def test_where_a_folder_cannot_be_made_another_place_is_asked_for(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    arguments = ("run", "--case", "planted:Short", "--integrator", "planted:Sound", "--suite", "quick")
    assert gnomon(*arguments, "--out", str(tmp_path / "notes.txt")) == 2
    line = capfd.readouterr().err.strip().splitlines()[-1]
    assert (
        line
        == f"error: --out {tmp_path / 'notes.txt' / 'results.sqlite'}: cannot be written (File exists); name another place with --out"
    )
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_a_run_in_which_nothing_ran_says_why(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A method for attitudes on a pendulum; there is no report of it either."""
    out = str(tmp_path / "a.sqlite")
    arguments = ("run", "--case", "pendulum_simple", "--integrator", "RKMK 4", "--suite", "quick", "--out", out)
    assert gnomon(*arguments) == 1
    line = capfd.readouterr().err.strip().splitlines()[-1]
    assert line.startswith("nothing ran (unsupported: ")
    assert gnomon("report", out, "--to", str(tmp_path)) == 2
    line = capfd.readouterr().err.strip().splitlines()[-1]
    assert line.startswith(f"error: {out}: nothing in it ran, so there is nothing to report (unsupported: ")
    assert not (tmp_path / "index.html").exists()


@pytest.mark.parametrize("folder", ["kernels", "results"])
def test_a_cache_that_others_can_write_stops_a_run_before_it_begins(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str], folder: str
) -> None:
    """They could put code or numbers of their own there."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    cache = tmp_path / "gnomon" / folder
    cache.mkdir(parents=True, mode=0o700)
    cache.chmod(0o777)
    out = tmp_path / "a.sqlite"
    assert gnomon("run", "--case", "pendulum_simple", "--integrator", "RK4", "--out", str(out)) == 2
    line = capfd.readouterr().err.strip().splitlines()[-1]
    assert line.startswith(f"error: {cache} can be written by other users (mode 0777)")
    assert "set XDG_CACHE_HOME" in line
    assert not out.exists()


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs a folder in which nobody can write")
def test_a_cache_that_cannot_be_written_costs_one_warning(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """The run goes on without it; its workers, each of which compiles for itself, say nothing."""
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc/cache")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    arguments = ("run", "--suite", "quick", "--case", "pendulum_simple", "--integrator", "RK4", "--limit", "10")
    assert gnomon(*arguments, "--out", str(tmp_path / "a.sqlite")) == 0
    printed = capfd.readouterr()
    assert printed.err.count("cannot be written") == 2  # both folders, in one line
    assert printed.err.count("warning:") == 1
    statuses = set(store.load(tmp_path / "a.sqlite")["status"])
    assert statuses <= {"ok", "inaccurate", "skipped", "unsupported"}
    assert "ok" in statuses


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


def test_a_missing_library_that_is_named_is_wrong_usage(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from gnomon.harness.registry import lookup

    monkeypatch.setattr(lookup, "_importable", lambda library: library != "pybullet")
    assert gnomon("run", "--case", "pendulum_simple", "--integrator", "pybullet") == 2
    assert lookup.absent("pybullet") in capfd.readouterr().err


@pytest.mark.parametrize(
    ("library", "python", "told"),
    [
        ("rebound", (3, 13, 0), "rebound is not installed: pip install rebound"),
        ("heyoka", (3, 11, 0), "heyoka is optional: pip install heyoka"),
        ("pybullet", (3, 11, 9), "pybullet is not installed: pip install pybullet"),
        ("pybullet", (3, 12, 0), "pybullet has wheels up to CPython 3.11 only"),
    ],
)
def test_what_is_missing_is_named_with_what_installs_it(
    library: str, python: tuple[int, ...], told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from gnomon.harness.registry import lookup

    monkeypatch.setattr(lookup.sys, "version_info", python)
    assert lookup.absent(library) == told


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("raise RuntimeError('boom')", "RuntimeError: boom"),
        ("def f(:", "SyntaxError: "),
        ("import no_such_library", "ModuleNotFoundError: No module named 'no_such_library'"),
        (
            "from gnomon.harness.contract.integrator import Integrator\n\nclass Thing(Integrator): name = 'x'",
            "abstract",
        ),
        ("class Thing: pass", "is no gnomon.harness.contract.integrator.Integrator"),
    ],
)
def test_a_module_that_cannot_be_used_is_one_line(
    source: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "broken_module.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "broken_module", raising=False)
    assert gnomon("run", "--case", "pendulum_simple", "--integrator", "broken_module:Thing") == 2
    (line,) = capfd.readouterr().err.strip().splitlines()
    assert line.startswith("error: broken_module:Thing")
    assert message in line
    if "class Thing: pass" not in source:
        monkeypatch.delitem(sys.modules, "broken_module", raising=False)
        assert gnomon("show", "broken_module:Thing") == 2


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


def test_an_interrupted_run_says_how_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from gnomon.harness.running.pool import Pool

    run = ("run", "--case", "planted:Short", "--integrator", "planted:Sound", "--suite", "quick", "--limit", "0.05")

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Pool, "run", interrupt)
        assert gnomon(*run, "--out", str(tmp_path)) == 130
    assert "the same command goes on from here" in capfd.readouterr().err
    assert gnomon(*run, "--out", str(tmp_path)) == 0
    assert {"ok"} <= set(store.load(tmp_path)["status"]) <= {"ok", "timeout", "skipped"}, "slow in Python"


def test_alone_it_shows_its_help(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon() == 2
    captured = capfd.readouterr()
    assert "certify" in captured.out + captured.err


def test_list_names_every_case_and_integrator(capfd: pytest.CaptureFixture[str]) -> None:
    from gnomon.harness.registry import lookup

    from gnomon import cases

    assert gnomon("list") == 0
    text = capfd.readouterr().out
    for name in (*cases.names(), *lookup.everything()):
        assert name in text


def test_show_prints_equations_numbers_and_variants(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    drawing = tmp_path / "motion.svg"
    assert gnomon("show", "pendulum_simple", "--set", "L=2", "--plot", str(drawing)) == 0
    text = capfd.readouterr().out
    for part in ("-(g / length) * sin(theta)", "9.81", "period", "separatrix", "energy", "theta from the downward"):
        assert part in text
    assert drawing.read_text().startswith("<svg")


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


def test_doctor_says_what_is_here(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("doctor") == 0
    text = capfd.readouterr().out
    assert "numpy" in text
    assert "rebound" in text


def test_certify_takes_cases_and_checks_by_name(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "certificates.json"
    assert gnomon("certify", "projectile_parabola", "moment_equipollent", "--to", str(path)) == 0
    certificates = json.loads(path.read_text())
    assert [c["case"] for c in certificates] == ["projectile_parabola", "moment_equipollent"]
    assert all(c["passed"] and c["digits"] >= 40 for c in certificates)
    assert gnomon("certify", "no_such_thing", "--to", str(path)) == 2
    assert "no case is named 'no_such_thing'" in capfd.readouterr().err

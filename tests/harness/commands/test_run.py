"""`gnomon run`: what stops it before it begins, and what it says at its end."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from command_line import gnomon
from gnomon.harness.results import store


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


def test_a_missing_library_that_is_named_is_wrong_usage(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from gnomon.harness.registry import lookup

    monkeypatch.setattr(lookup, "_importable", lambda library: library != "pybullet")
    assert gnomon("run", "--case", "pendulum_simple", "--integrator", "pybullet") == 2
    assert lookup.absent("pybullet") in capfd.readouterr().err


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


def test_an_interrupted_run_says_how_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from gnomon.harness.running.pool import Pool

    run = ("run", "--case", "planted:Short", "--integrator", "planted:Sound", "--suite", "quick", "--limit", "2")

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Pool, "run", interrupt)
        assert gnomon(*run, "--out", str(tmp_path)) == 130
    assert "the same command resumes the run" in capfd.readouterr().err
    assert gnomon(*run, "--out", str(tmp_path)) == 0
    assert {"ok"} <= set(store.load(tmp_path)["status"]) <= {"ok", "timeout", "skipped"}, "slow in Python"

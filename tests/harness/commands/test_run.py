"""`gnomon run`: mistakes that stop it before it begins, and its words at the end."""

from pathlib import Path

import pytest
from command_line import gnomon
from gnomon.harness.results import store
from gnomon.harness.running import first_trials, planned_run


def test_a_run_in_which_nothing_ran_says_why(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A method for attitudes on a pendulum; the run writes no report either."""
    out = str(tmp_path / "a.sqlite")
    arguments = ("run", "--case", "pendulum_simple", "--integrator", "RKMK 4", "--suite", "quick", "--out", out)
    assert gnomon(*arguments) == 1
    line = capfd.readouterr().err.strip().splitlines()[-1]
    assert line.startswith("nothing ran (unsupported: ")
    assert gnomon("report", out, "--out", str(tmp_path)) == 2
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
    assert gnomon("run", "--case", "pendulum_simple", "--integrator", "gnomon:RK4", "--out", str(out)) == 2
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
    arguments = ("run", "--suite", "quick", "--case", "pendulum_simple", "--integrator", "gnomon:RK4", "--limit", "10")
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


def test_the_suite_of_engines_runs_near_duplicates_on_its_variants(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Nearly all of its scenes are variants: without this, an engine as shipped would not stand beside the configured one."""
    asked = []

    def planned(*given: object, near_duplicates: bool) -> None:
        asked.append(near_duplicates)
        raise KeyboardInterrupt

    monkeypatch.setattr(planned_run, "run", planned)
    monkeypatch.setattr(first_trials, "crashes", lambda *given: [])
    for suite in ("engines", "quick"):
        gnomon("run", "--suite", suite, "--out", str(tmp_path / "a.sqlite"))
    assert asked == [True, False]

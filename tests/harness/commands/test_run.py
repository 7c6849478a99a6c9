"""`gnomon run`: mistakes that stop it before it begins, and its words at the end."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from command_line import gnomon
from gnomon.harness.measuring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.registry import selection
from gnomon.harness.results import store
from gnomon.harness.running import first_trials, plan, planned_run
from gnomon.harness.running.pool import Pool
from gnomon.harness.running.sweep import Sweep

from gnomon import cases


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
    arguments = ("run", "--suite", "quick", "--case", "pendulum_simple", "--integrator", "gnomon:RK4", "--limit", "300")
    assert gnomon(*arguments, "--out", str(tmp_path / "a.sqlite")) == 0
    printed = capfd.readouterr()
    assert printed.err.count("cannot be written") == 2  # both folders, in one line
    assert printed.err.count("warning:") == 1
    assert "ok" in set(store.load(tmp_path / "a.sqlite")["status"]) <= {"ok", "inaccurate", "unsupported"}


def test_a_missing_library_that_is_named_is_wrong_usage(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from gnomon.harness.registry import lookup

    monkeypatch.setattr(lookup, "_is_importable", lambda library: library != "pybullet")
    assert gnomon("run", "--case", "pendulum_simple", "--integrator", "pybullet") == 2
    assert lookup.absent("pybullet") in capfd.readouterr().err


def test_an_interrupted_run_says_how_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from gnomon.harness.running.pool import Pool

    run = ("run", "--case", "planted:Short", "--integrator", "planted:Sound", "--suite", "quick", "--limit", "300")

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Pool, "run", interrupt)
        assert gnomon(*run, "--out", str(tmp_path)) == 130
    assert "the same command resumes the run" in capfd.readouterr().err
    assert gnomon(*run, "--out", str(tmp_path)) == 0
    assert set(store.load(tmp_path)["status"]) == {"ok"}


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


VARIANTS = selection.variants_of("kepler_orbit")
FORMULATIONS = {plan.STANDARD, *(one.name for one in cases.get("kepler_orbit").formulations)}


@pytest.mark.parametrize(
    ("words", "variants", "formulations"),
    [
        ("--case kepler_orbit", {"default"}, {plan.STANDARD}),
        ("--case kepler_orbit --formulations", {"default"}, FORMULATIONS),
        ("--case kepler_orbit/e09", {"e09"}, {plan.STANDARD}),
        ("--case kepler_orbit/*", {*VARIANTS}, {plan.STANDARD}),
        ("--case kepler_orbit --suite standard", {*VARIANTS}, FORMULATIONS),
        ("--case kepler_orbit --suite quick", {"default"}, FORMULATIONS),
    ],
)
def test_a_named_case_is_what_it_names_and_a_suite_adds_what_it_has(
    words: str, variants: set[str], formulations: set[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A user who names one case and one integrator waits for seconds, not for ten variants in every formulation."""
    planned: list[plan.Series] = []
    list_series = plan.list_series

    def spy(*given: Any, **named: Any) -> list[plan.Series]:
        planned.extend(list_series(*given, **named))
        raise KeyboardInterrupt

    monkeypatch.setattr(plan, "list_series", spy)
    asked = ["run", *words.split(), "--integrator", "gnomon:DOP853", "--out", str(tmp_path / "a.sqlite")]
    assert gnomon(*asked) == 130
    assert {one.variant for one in planned} == variants
    assert {one.formulation_name for one in planned} == formulations


def test_the_prediction_has_every_launch_and_the_exact_motions_that_are_not_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    summed: list[tuple[str, float]] = []

    def predicted(launches: Sequence[tuple[str, float]], workers: int) -> float:
        summed.extend(launches)
        return 1234.0

    def pool(_: object, sweeps: Iterator[Sweep], *__: object) -> None:
        next(sweeps)

    ready = CaseSpec.of(cases.get("harmonic_oscillator").rounded())
    solution = reference_solution(ready)
    monkeypatch.setattr(planned_run, "find_kept", lambda spec: solution if spec == ready else None)
    monkeypatch.setattr(planned_run, "run_seconds", predicted)
    monkeypatch.setattr(Pool, "run", pool)
    names = [f"--case={name}" for name in ("harmonic_oscillator", "projectile_parabola")]
    gnomon("run", *names, "--integrator", "gnomon:RK4", "--out", str(tmp_path / "a.sqlite"))
    text = " ".join(capfd.readouterr().err.split())
    assert "predicted: 2 series" in text
    assert "1 exact motion that no earlier run has kept" in text
    assert len({name for name, _ in summed}) == 2
    assert min(seconds for _, seconds in summed) > 0

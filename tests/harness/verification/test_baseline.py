"""Baselines: an unchanged integrator agrees with its baseline, a fault is a regression, and a file is data."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import planted_methods
import pytest
from command_line import gnomon
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.verification.baseline import Baseline, as_text, compare_with_baseline, measure, read

PENDULUM = ["pendulum_simple"]


def base_of(integrator: Integrator) -> Baseline:
    return measure(integrator, PENDULUM, "low", runs=4)


@pytest.fixture(scope="module")
def bases() -> dict[str, Baseline]:
    return {"RK4": base_of(planted_methods.good_rk4), "pair": base_of(planted_methods.good_pair)}


@pytest.mark.parametrize("name", ["RK4", "pair"])
def test_the_file_holds_all_that_was_measured(bases: dict[str, Baseline], name: str, tmp_path: Path) -> None:
    path = tmp_path / "baseline.txt"
    path.write_text(as_text(bases[name]))
    assert repr(read(path)) == repr(bases[name])  # nan is not equal to itself


@pytest.mark.parametrize(
    ("name", "make", "fault"),
    [
        *(("RK4", planted_methods.rk4, fault) for fault in ("", "coefficient_5", "float32")),
        *(("pair", planted_methods.pair, fault) for fault in ("", "float32")),
        pytest.param("pair", planted_methods.pair, "coefficient_5", marks=pytest.mark.slow),  # takes 8 s
    ],
)
def test_a_fault_is_a_regression_and_noise_is_not(
    bases: dict[str, Baseline], name: str, make: object, fault: str
) -> None:
    """Ulps at the start change the steps of the pair: a run from such starts is not worse than the baseline."""
    integrator = make(fault)  # type: ignore[operator]
    run = replace(measure(integrator, PENDULUM, "low", runs=1), integrator=bases[name].integrator)
    verdict = compare_with_baseline(bases[name], run)
    assert verdict.settings >= 4
    assert bool(verdict.regressions) == bool(fault), verdict.regressions


def test_more_work_for_the_same_error_is_a_regression(bases: dict[str, Baseline]) -> None:
    base = bases["pair"]
    more = replace(base, entries=tuple(replace(e, rhs_high=1.1 * e.rhs_high + 64) for e in base.entries))
    assert any("right-hand sides" in line for line in compare_with_baseline(base, more).regressions)
    assert compare_with_baseline(base, base).regressions == []


@pytest.mark.parametrize("name", ["RK4", "pair"])
def test_a_small_change_of_a_weight_is_named_with_either_sign(bases: dict[str, Baseline], name: str) -> None:
    """A change of a formula makes errors smaller as often as larger. It is as large as the change of the numbers."""
    base, widths = bases[name], [e.error_high - e.error_low + 10 * e.conditioning for e in bases[name].entries]
    for sign in (1, -1):
        moved = [e.error_high + sign * 4 * w for e, w in zip(base.entries, widths, strict=True)]
        entries = [replace(e, error_high=x, error_low=x) for e, x in zip(base.entries, moved, strict=True)]
        (line,) = [
            line
            for line in compare_with_baseline(base, replace(base, entries=tuple(entries))).regressions
            if "changed" in line
        ]
        relative = [x / ((e.error_low + e.error_high) / 2) - 1 for e, x in zip(base.entries, moved, strict=True)]
        assert f"{np.median(relative):+.1e}" in line


def test_a_bound_that_another_version_changed_is_named(bases: dict[str, Baseline]) -> None:
    base = bases["RK4"]
    older = replace(base, version="0.0.1", entries=tuple(replace(e, floor=2 * e.floor) for e in base.entries))
    (note,) = compare_with_baseline(older, base).notes
    assert note.startswith("pendulum_simple: floor ")
    assert "of gnomon 0.0.1" in note


def test_a_baseline_of_no_solution_is_refused() -> None:
    """Every setting crashes: a file of it would let every later fault pass."""
    with pytest.raises(ValueError, match=r"broken has no solution at any setting \(crashed\)"):
        base_of(planted_methods.broken)


def test_a_baseline_of_another_integrator_is_refused(bases: dict[str, Baseline]) -> None:
    with pytest.raises(ValueError, match="the baseline is of mine:RK4, not of mine:pair"):
        compare_with_baseline(bases["RK4"], bases["pair"])


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda text: "x" + text, "its first line is not"),
        (lambda text: text.replace("# depth low", "# depth deep"), "lines 2 to 5"),
        (lambda text: text.replace("variant", "variance", 1), "this version has other columns"),
        (lambda text: text.rstrip() + " 7\n", "columns, not"),
        (lambda text: text.replace(" step ", " step x", 1), "columns, not|could not convert"),
        (lambda text: text.replace(" ok ", " fine ", 1), "fine"),
        (lambda text: "", "its first line is not"),
    ],
)
def test_a_file_that_is_not_a_baseline_is_refused_in_one_line(
    bases: dict[str, Baseline], change: object, says: str, tmp_path: Path
) -> None:
    path = tmp_path / "baseline.txt"
    path.write_text(change(as_text(bases["RK4"])))  # type: ignore[operator]
    with pytest.raises(ValueError, match=says) as caught:
        read(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_the_commands_write_and_compare(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "baseline.txt"
    named = ("planted_methods:good_verlet", "--case", "pendulum_simple")
    assert gnomon("baseline", "write", *named, "--out", str(path)) == 0
    alone = ("--depth", "low", "--claim", "repeatable", "--baseline", str(path))
    assert gnomon("verify", *named, *alone) == 0
    assert "settings, 0 regressions" in capsys.readouterr().out
    entries = [replace(e, error_low=e.error_low / 9, error_high=e.error_high / 9) for e in read(path).entries]
    path.write_text(as_text(replace(read(path), entries=tuple(entries))))
    assert gnomon("verify", *named, *alone) == 1
    assert np.any(["errors are 9 times" in line for line in capsys.readouterr().out.splitlines()])

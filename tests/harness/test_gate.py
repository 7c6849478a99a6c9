"""The gate sees a lost order, larger errors, more work and a worse status, and nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from gnomon.harness import store
from gnomon.harness.gate import compare


@pytest.fixture
def base(synthetic_results: Path) -> Any:
    return store.load(synthetic_results)


def spoiled(frame: Any, column: str, change: Any, integrator: str = "RK4") -> Any:
    frame = frame.copy()
    chosen = (frame["integrator"] == integrator) & (frame["case"] == "kepler_orbit") & (frame["variant"] == "default")
    frame.loc[chosen, column] = change(frame[chosen])
    return frame


def test_a_run_is_no_worse_than_itself(base: Any) -> None:
    verdict = compare(base, base)
    assert verdict.compared == base.groupby(["case", "variant", "formulation", "integrator_id"]).ngroups
    assert verdict.regressions == []


@pytest.mark.parametrize(
    ("column", "change", "says"),
    [
        ("error_max", lambda rows: rows["error_max"] * 3, "3 times those of the base"),
        ("error_max", lambda rows: 0.3 * rows["setting"] ** 3, "order 4.00 became 3.00"),
        ("rhs_calls", lambda rows: rows["rhs_calls"] * 1.25, "1.25 times the right-hand sides"),
        ("status", lambda rows: "crashed", "became crashed"),
    ],
)
def test_what_got_worse_is_named(base: Any, column: str, change: Any, says: str) -> None:
    regressions = compare(base, spoiled(base, column, change)).regressions
    assert regressions
    assert all("kepler_orbit default standard gnomon:RK4" in line for line in regressions)
    assert any(says in line for line in regressions)


def test_slower_is_a_note(base: Any) -> None:
    verdict = compare(base, spoiled(base, "seconds_median", lambda rows: rows["seconds_median"] * 3))
    assert verdict.regressions == []
    assert any("3 times the time" in note for note in verdict.notes)


def test_round_off_is_no_regression(base: Any) -> None:
    def noise(rows: Any) -> Any:
        return rows["error_max"].where(rows["error_max"] > 1e-14, 9 * rows["error_max"])

    assert compare(base, spoiled(base, "error_max", noise)).regressions == []


def test_what_got_better_is_no_regression(base: Any) -> None:
    assert compare(base, spoiled(base, "error_max", lambda rows: rows["error_max"] / 100)).regressions == []


def test_nothing_in_common_is_an_error(base: Any) -> None:
    with pytest.raises(ValueError, match="in common"):
        compare(base, base.assign(case="another"))

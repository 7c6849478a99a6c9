"""Settings that a user chooses for a run: their texts, their kinds, and the trials that they plan."""

from pathlib import Path

import planted
import pytest
from command_line import gnomon
from gnomon.harness.contract.integrator import Tolerance
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.measuring.settings import choose_settings, read_settings, sweep_settings
from gnomon.harness.registry import lookup
from gnomon.harness.results import reading

from gnomon import cases

CASE = cases.get("pendulum_simple").rounded()
BOTH = lookup.find_all(["scipy:DOP853", "gnomon:RK4"])


def sweep(name: str, *texts: str) -> tuple[float, ...]:
    """The settings of an integrator with the texts of `--settings`."""
    (one,) = lookup.find_all([name])
    return sweep_settings(one, CASE, problem_of(CASE, one.accepts), choose_settings(read_settings(texts), [one]))


def test_chosen_tolerances_run_from_cheap_to_expensive_and_once() -> None:
    assert sweep("scipy:DOP853", "1e-12,1e-6", "1e-9,1e-6") == (1e-6, 1e-9, 1e-12)


def test_a_chosen_step_is_made_as_it_is_or_as_the_next_one_that_meets_the_samples() -> None:
    """Methods with fixed steps refuse a step that does not divide the sampling interval."""
    interval = float(CASE.times[0])
    found = sweep("gnomon:RK4", f"{interval / 3!r},0.1,{10 * interval!r}")
    assert found[0] == interval, "the longest step ends at the first sample"
    assert interval / 3 in found
    (other,) = [h for h in found if h not in (interval, interval / 3)]
    assert other <= 0.1 < interval / (round(interval / other) - 1)


@pytest.mark.parametrize("sweep", [Tolerance(1e-6, 1e-12), Tolerance(1e-3, 1e-5), Tolerance(1e-2, 1e-14, 2)])
def test_declared_tolerances_are_the_decades(sweep: Tolerance) -> None:
    """1e-6 to 1e-12 are seven tolerances, each a tenth of the one before: numbers that a reader knows."""
    swept = type("Swept", (planted.Sound,), {"sweep": sweep})()
    found = sweep_settings(swept, CASE, problem_of(CASE, swept.accepts))
    assert (found[0], found[-1]) == (sweep.loosest, sweep.tightest)
    for place, tolerance in enumerate(found):
        assert tolerance == pytest.approx(sweep.loosest * 10 ** (-place / sweep.per_decade), rel=1e-3)
        assert place % sweep.per_decade or tolerance == float(f"{tolerance:.0e}")


@pytest.mark.parametrize(
    ("texts", "named"),
    [
        (["1e-6,x"], "'1e-6,x'"), ([""], "''"), (["=1e-6"], "'=1e-6'"), (["1e-6", "step=0.1"], "1e-6 step=0.1"),
        (["1e-6"], "1e-06.*scipy:DOP853 takes tolerances and gnomon:RK4 step sizes"), (["order=4"], "order=4"),
        (["tolerance=nan"], "nan is not a tolerance"), (["tolerance=1.0"], "1.0 is not a tolerance"),
        (["step=-0.1"], "-0.1 is not a step"), (["step=inf"], "inf is not a step"),
    ],
)  # fmt: skip
def test_a_wrong_text_is_named_with_the_way_out(texts: list[str], named: str) -> None:
    with pytest.raises(ValueError, match=named) as raised:
        choose_settings(read_settings(texts), BOTH)
    assert "\n" not in str(raised.value)


def test_a_setting_of_a_kind_that_nothing_takes_is_refused() -> None:
    with pytest.raises(ValueError, match="no integrator of this run takes a step"):
        choose_settings({"step": [0.1]}, BOTH[:1])


def test_a_run_has_the_chosen_settings_of_each_kind(tmp_path: Path) -> None:
    """Those of the last run count, and a trial at a setting that the file has already is not repeated."""
    out, interval = tmp_path / "a.sqlite", float(CASE.times[0])
    asked = ["run", "--case", CASE.name, "--out", str(out), "--limit", "300"]
    for one in BOTH:
        asked += ["--integrator", one.id]

    def run(tolerances: str) -> dict[tuple[str, float], float]:
        assert gnomon(*asked, "--settings", f"tolerance={tolerances}", "--settings", f"step={interval / 8!r}") == 0
        return {(row["integrator"], row["setting"]): row["seconds_median"] for row in reading.rows(out)}

    first, second = run("1e-6,1e-9"), run("1e-9,1e-7")
    assert first.keys() == {("DOP853", 1e-6), ("DOP853", 1e-9), ("RK4", interval / 8)}
    assert second.keys() == {("DOP853", 1e-7), ("DOP853", 1e-9), ("RK4", interval / 8)}
    assert all(first[trial] == second[trial] for trial in first.keys() & second.keys())

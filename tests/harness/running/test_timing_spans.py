"""The time of one more period: which cases a suite runs over several spans, how often, and the difference of their times."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from gnomon.harness.registry import lookup, selection
from gnomon.harness.results.reading import APART
from gnomon.harness.results.store import export, load
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run
from gnomon.harness.running.timing_spans import LEAST, has_ended, suffices
from waiting import LONG_SECONDS

from gnomon import cases

FOUNDATION = plan.suite("foundation")
LONGER = [*plan.TIMING_FACTORS]


def test_every_foundation_case_has_a_factor_or_ends() -> None:
    assert sorted([*plan.TIMING_FACTORS, *plan.ENDS]) == sorted(plan.FOUNDATION)
    factors = plan.TIMING_FACTORS.values()
    assert all(factor & (factor - 1) == 0 and factor >= LEAST for factor in factors), "powers of two"


def test_default_variants_of_cases_with_a_factor_are_timed_over_a_longer_span() -> None:
    chosen = selection.choose([*plan.FOUNDATION, f"{LONGER[0]}/{cases.case_class(LONGER[0]).variants[0].name}"], False)
    found = plan.with_timing_spans(chosen, FOUNDATION)
    assert found[: len(chosen)] == chosen
    assert [case.name for case, _ in found[len(chosen) :]] == [name for name in plan.FOUNDATION if name in LONGER]
    for case, label in found[len(chosen) :]:
        default = cases.get(case.name).rounded()
        assert label == f"{plan.TIMING_SPAN}{plan.TIMING_FACTORS[case.name]}"
        assert float(case.span) == plan.TIMING_FACTORS[case.name] * float(default.span)
        assert case.numbers == default.numbers, "the same motion"
        assert len(case.times) == 64
        assert case.times[-1] == pytest.approx(float(case.span))
    assert plan.with_timing_spans(chosen, plan.suite("quick")) == chosen
    changed = [(case, " length=2") for case, _ in chosen]
    assert plan.with_timing_spans(changed, FOUNDATION) == changed, "a factor belongs to the default numbers"


def test_both_spans_have_the_same_launches_and_near_duplicates_have_none() -> None:
    """Times of one launch are subtracted. Ranks are by the default span, which has all launches; of another formulation one
    more period is not measured."""
    methods = lookup.own().values()
    primary, duplicate = (next(m for m in methods if m.primary is wanted and m.order == 4) for wanted in (True, False))
    chosen = plan.with_timing_spans(selection.choose(["kepler_orbit"], False), FOUNDATION)
    series = plan.list_series(chosen, [primary, duplicate], near_duplicates=False)
    longer = [one for one in series if one.over_timing_span]
    own = [one for one in series if not one.over_timing_span]
    assert {one.formulation for one in longer} == {None} < {one.formulation for one in own}
    assert {plan.launches(one, FOUNDATION, False) for one in series if one.integrator is primary} == {
        FOUNDATION.timing.launches
    }
    assert [one.left_out for one in longer if one.integrator is duplicate] == [plan.NEAR_DUPLICATE]
    named = plan.list_series(chosen, [duplicate], formulations=False)
    assert all(one.left_out is None for one in named if one.over_timing_span), "unless it is named"


def test_one_more_period_of_a_run_is_the_difference_of_its_times(tmp_path: Path) -> None:
    """At the settings of the default span, of which the step sizes are a part; the export has it. A run that is repeated
    measures nothing again."""
    suite = FOUNDATION.within(LONG_SECONDS).change(launches=2, block_seconds=0.0, repeats=2, formulations=False)
    case = cases.get("kepler_orbit")
    assert case.turning is not None
    chosen = plan.with_timing_spans([(case.rounded(), "")], suite)
    methods = lookup.find_all(["gnomon:Störmer-Verlet"])
    path = run(tmp_path, suite, chosen, methods)
    frame = load(path)
    longer = frame["variant"].str.contains("timing span")
    key = ["setting", "launch"]
    both = frame[~longer].merge(frame[longer], on=key, suffixes=("", "_longer"), how="left")
    factor = plan.TIMING_FACTORS["kepler_orbit"]
    np.testing.assert_allclose(both["span_longer"].dropna(), factor * float(case.rounded().span))
    assert both["turned_starts_longer"].isna().all()
    waits = both[["delay_seconds", "delay_seconds_longer"]].astype(float).fillna(0.0)
    once = both["seconds_median"] - waits["delay_seconds"]
    several = both["seconds_median_longer"] - waits["delay_seconds_longer"]
    difference = ((several - once) / (factor - 1)).where(several.ge(APART * once))
    np.testing.assert_array_equal(both["more_seconds"].astype(float), difference)
    assert both["more_seconds"].notna().any()
    assert both["span_longer"].notna().sum() >= len(both) / 2, "the settings are the same"
    assert both.loc[both["span_longer"].notna()].groupby("launch").size().nunique() == 1
    export(path, tmp_path / "results.csv", "csv")
    exported = pd.read_csv(tmp_path / "results.csv")["more_seconds"]
    np.testing.assert_allclose(exported, frame["more_seconds"].astype(float))
    assert set(load(run(tmp_path, suite, chosen, methods))["run"]) == {1}


def test_a_motion_that_settles_has_ended() -> None:
    """On the default span the oscillator still moves by more than the smallest error of the report; its e-folding time is a
    sixteenth of 32 spans, or less."""
    oscillator = cases.get("damped_oscillator")
    assert not has_ended(oscillator.rounded())
    assert has_ended(plan.lengthen(oscillator, 32)[0])
    assert not has_ended(plan.lengthen(cases.get("pendulum_simple"), 32)[0])


@pytest.mark.parametrize(
    ("shares", "found"), [((0.1, 0.05, 0.9), True), ((0.11, 0.05, 0.9), False), ((0.1, 0.2, 0.0), False)]
)
def test_a_span_suffices_where_the_null_call_of_every_contender_is_a_tenth(
    shares: tuple[float, ...], found: bool
) -> None:
    """The third takes three times as long as the first: it is not a contender."""
    times = pd.DataFrame({"ratio": [1.0, 1.9, 3.0], "null_share": shares})
    assert suffices(times) is found
    assert not suffices(times.iloc[:0]), "nothing was measured"

"""Spans for timing: which cases a suite lengthens, how often it launches what, and the one solve that error and time share."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from gnomon.harness.registry import lookup, selection
from gnomon.harness.results import analysis
from gnomon.harness.results.store import load
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run
from gnomon.harness.running.timing_spans import ended, suffices
from waiting import LONG_SECONDS

from gnomon import cases

FOUNDATION = plan.suite("foundation")
LONGER = [name for name, factor in plan.TIMING_FACTORS.items() if factor > 1]


def test_every_foundation_case_has_a_factor_or_ends() -> None:
    assert sorted([*plan.TIMING_FACTORS, *plan.ENDS]) == sorted(plan.FOUNDATION)
    assert all(factor & (factor - 1) == 0 < factor for factor in plan.TIMING_FACTORS.values()), "powers of two"
    assert LONGER


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
    assert plan.with_timing_spans(chosen, plan.suite("quick")) == chosen, "one launch ranks nothing"
    changed = [(case, " length=2") for case, _ in chosen]
    assert plan.with_timing_spans(changed, FOUNDATION) == changed, "a factor belongs to the default numbers"


def test_launches_go_to_the_timing_span_and_near_duplicates_have_none() -> None:
    """One launch of a near-duplicate would separate nothing. Cases that end, or whose span is long, keep their launches."""
    methods = lookup.own().values()
    primary, duplicate = (next(m for m in methods if m.primary is wanted and m.order == 4) for wanted in (True, False))
    ends = next(name for name in plan.ENDS if "projectile" in name)
    chosen = plan.with_timing_spans(selection.choose([LONGER[0], ends], False), FOUNDATION)
    series = plan.pairs(chosen, [primary, duplicate], formulations=False, near_duplicates=False)
    found = {(one.case.name, one.over_timing_span, one.integrator.id): one for one in series}
    launches = {key: plan.launches(one, FOUNDATION, near_duplicates=False) for key, one in found.items()}
    assert launches[LONGER[0], False, primary.id] == 1
    assert launches[LONGER[0], True, primary.id] == FOUNDATION.launches
    assert launches[ends, False, primary.id] == FOUNDATION.launches
    assert found[LONGER[0], True, duplicate.id].left_out == plan.NEAR_DUPLICATE
    named = plan.pairs(chosen, [duplicate], formulations=False)
    assert all(one.left_out is None for one in named if one.over_timing_span), "unless it is named"


def test_error_and_time_of_a_timing_span_are_of_one_solve(tmp_path: Path) -> None:
    """On a case with a symmetry the default variant has the median error over turned starts; a run that is repeated
    measures nothing again."""
    suite = replace(FOUNDATION.within(LONG_SECONDS), launches=2, block_seconds=0.0, repeats=2)
    case = cases.get("kepler_orbit")
    assert case.turning is not None
    chosen = plan.with_timing_spans([(case.rounded(), "")], suite)
    methods = lookup.find_all(["gnomon:Störmer-Verlet"])
    frame = load(run(tmp_path, suite, chosen, methods))
    frame = frame[frame["formulation"] == "standard"]
    longer = frame["variant"].str.contains("timing span")
    assert frame[longer]["launch"].max() == 2
    assert frame[~longer]["launch"].max() == 1
    assert frame[~longer]["turned_starts"].notna().any()
    assert frame[longer]["turned_starts"].isna().all()
    assert frame[longer]["error_max"].notna().any()
    assert frame[longer]["null_seconds"].notna().any()
    again = load(run(tmp_path, suite, chosen, methods))
    assert set(again["run"]) == {1}
    _, timed = analysis.over_timing_spans(analysis.tidy(frame))
    np.testing.assert_allclose(timed["span"], plan.TIMING_FACTORS["kepler_orbit"] * float(case.rounded().span))


def test_a_motion_that_settles_has_ended() -> None:
    """On the default span the oscillator still moves by more than the smallest error of the report; its e-folding time is a
    sixteenth of 32 spans, or less."""
    oscillator = cases.get("damped_oscillator")
    assert not ended(oscillator.rounded())
    assert ended(plan.lengthened(oscillator, 32)[0])
    assert not ended(plan.lengthened(cases.get("pendulum_simple"), 32)[0])


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

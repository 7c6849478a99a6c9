"""When a sweep stops, which trials it repeats, and which it skips."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import planted
import pytest
from gnomon.harness.contract.integrator import Integrator, Tolerance
from gnomon.harness.contract.status import Status
from gnomon.harness.registry.lookup import own
from gnomon.harness.results.store import Known
from gnomon.harness.running import plan
from gnomon.harness.running.sweep import REPEATED_SECONDS, SECONDS_EACH, Sweep
from gnomon.harness.running.worker import FEWEST_CALLS
from gnomon.harness.scoring.outcome import Outcome
from gnomon.harness.scoring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.scoring.score import Scorer

SUITE = replace(plan.suite("quick"), limit_seconds=1.0)
MOST = SUITE.limit_seconds / SECONDS_EACH["scipy"]
"""Right-hand sides that a trial of SciPy may take."""


class Priced(planted.Sound):
    """An integrator of a library whose time for a right-hand side is known."""

    library = "scipy"


class PricedTolerance(Priced):
    sweep = Tolerance()


@pytest.fixture(scope="module")
def scorer() -> Scorer:
    case = planted.Short().rounded()
    return Scorer(case, None, reference_solution(CaseSpec.of(case)))


class Log:
    """A sweep over eight settings, and the rows that it recorded."""

    def __init__(
        self, scorer: Scorer, launch: int = 1, history: Any = None, integrator: Integrator | None = None
    ) -> None:
        self.rows: list[Any] = []
        self.states: list[Any] = []
        self.finished = 0
        self.scorer = scorer
        series = plan.Series(scorer.case, None, integrator or planted.Sound())
        trials = [plan.Trial(str(k), 0.1 / 2**k) for k in range(8)]
        self.sweep = Sweep(series, trials, scorer, SUITE, launch, history or {}, self.record, self.finish)

    def record(self, row: Any, options: Any, states: Any) -> None:
        self.rows.append(row)
        self.states.append(states)

    def finish(self) -> None:
        self.finished += 1

    def answer(self, seconds: float, calls: int = 4) -> None:
        self.sweep.done(Outcome(self.scorer.reference.exact, None, None, 1, calls, (seconds,), 0.0, None))

    @property
    def statuses(self) -> list[str]:
        return [row["status"] for row in self.rows]


def test_settings_are_requested_in_sequence_and_every_outcome_is_recorded(scorer: Scorer) -> None:
    log = Log(scorer)
    settings = []
    while (request := log.sweep.next()) is not None:
        settings.append(request.setting)
        log.answer(0.001)
    assert settings == [0.1 / 2**k for k in range(8)]
    assert log.statuses == ["ok"] * 8
    assert log.finished == 1


def test_hard_variants_are_timed_in_a_few_calls_if_these_are_short(scorer: Scorer) -> None:
    default, hard = Log(scorer), Log(scorer)
    hard.sweep.series.case.variant = "hard"
    try:
        request = hard.sweep.next()
    finally:
        hard.sweep.series.case.variant = None
    assert request is not None
    assert (request.block_seconds, request.repeats, request.slow_seconds) == (0.0, FEWEST_CALLS, REPEATED_SECONDS)
    assert request.count is Log(scorer).sweep.next().count  # type: ignore[union-attr]
    usual = default.sweep.next()
    assert usual is not None
    assert (usual.block_seconds, usual.repeats, usual.slow_seconds) == (
        SUITE.block_seconds,
        SUITE.repeats,
        SUITE.slow_seconds,
    )


@pytest.mark.parametrize("ending", ["timeout", "not_installed"])
def test_a_timeout_or_a_missing_library_ends_the_series_and_a_crash_does_not(scorer: Scorer, ending: str) -> None:
    """A smaller step takes longer, and a library is missing at every setting."""
    log = Log(scorer)
    log.sweep.next()
    log.sweep.failed(Status.CRASHED, "planted", "")
    log.sweep.next()
    log.sweep.failed(Status(ending), "no answer", "")
    assert log.sweep.next() is None
    assert log.statuses == ["crashed", ending] + ["skipped"] * 6


def test_an_outcome_that_cannot_be_scored_is_a_crash_of_its_trial_only(scorer: Scorer) -> None:
    log = Log(scorer)
    log.sweep.next()
    log.sweep.done(Outcome(scorer.reference.exact[:, :1], None, None, 1, 4, (0.001,), 0.0, None))
    assert log.statuses == ["crashed"]
    assert "cannot be scored" in log.rows[0]["reason"]
    assert log.sweep.next() is not None


@pytest.mark.parametrize("clock", [0.001, 1.0, 1000.0], ids=lambda factor: f"clock x {factor:g}")
def test_what_is_skipped_follows_from_counts_and_never_from_the_clock(scorer: Scorer, clock: float) -> None:
    """A busy machine makes every time longer: the same settings must run, in later launches too."""
    log, calls = Log(scorer, integrator=Priced()), MOST / 20
    while log.sweep.next() is not None:
        log.answer(clock * calls * SECONDS_EACH["scipy"], round(calls))
        calls *= 2
    assert log.statuses == ["ok"] * 5 + ["skipped"] * 3, "20 / 2^4 is above 1"
    assert log.rows[-1]["reason"] == "predicted 8e+04 right-hand sides, above the 5e+04 of a limit of 1 s"
    history = {(str(k), 1): Known("ok", round(MOST / 40 * 2**k), 1.0) for k in range(5)}
    later = Log(scorer, launch=2, history=history, integrator=Priced())
    settings = []
    while (request := later.sweep.next()) is not None:
        assert not request.count
        settings.append(request.setting)
        later.answer(clock, 0)
    assert settings == [0.1, 0.05], "8 hundredths of a second are 4000 right-hand sides"


def test_each_estimate_is_for_right_hand_sides_or_for_steps() -> None:
    """A step of Taylor's method takes dozens of right-hand sides: integrators that share an estimate count the same."""
    counted: dict[str, set[bool]] = {}
    for integrator in own().values():
        key = integrator.id if integrator.id in SECONDS_EACH else integrator.library
        counted.setdefault(key, set()).add(integrator.counts_rhs)
    assert counted.keys() == SECONDS_EACH.keys(), "each is used, and none is missing"
    assert {key: kinds for key, kinds in counted.items() if len(kinds) > 1} == {}


def test_trials_without_an_estimate_are_run(scorer: Scorer) -> None:
    log = Log(scorer)
    for _ in range(8):
        assert log.sweep.next() is not None
        log.answer(0.9, 10**9)
    assert log.statuses == ["ok"] * 8


def test_known_trials_are_not_run_again_and_still_serve_for_prediction(scorer: Scorer) -> None:
    known = {(str(k), 1): Known("ok", round(MOST / 5 * 2**k), 1.0) for k in range(3)}
    log = Log(scorer, history=known, integrator=Priced())
    assert log.sweep.next() is None
    assert log.statuses == ["skipped"] * 5


def test_a_tolerance_is_predicted_by_the_smallest_growth_so_far(scorer: Scorer) -> None:
    log = Log(scorer, integrator=PricedTolerance())
    for share in (0.1, 0.12, 0.6):
        assert log.sweep.next() is not None
        log.answer(0.001, round(share * MOST))
    assert log.sweep.next() is not None, ".6 grows by 1.2 to .72"
    log.answer(0.001, round(0.95 * MOST))
    assert log.sweep.next() is None
    assert log.rows[-1]["reason"].startswith("predicted 7.5e+04 right-hand sides, above the 5e+04")


def test_each_setting_has_its_own_place(scorer: Scorer) -> None:
    """The start of its counting run must not depend on which trials an earlier run measured."""
    log = Log(scorer, history={("0", 1): Known("ok", 4, 1.0)})
    places = []
    while (request := log.sweep.next()) is not None:
        places.append(request.place)
        log.answer(0.001)
    assert places == list(range(1, 8))


def test_a_count_that_fell_predicts_none_below_it(scorer: Scorer) -> None:
    """A tighter tolerance takes at least as many right-hand sides: a count that falls is chance."""
    known = {(str(k), 1): Known(Status.OK, round(share * MOST), 1.0) for k, share in enumerate((4, 1.5))}
    log = Log(scorer, history=known, integrator=PricedTolerance())
    assert log.sweep.next() is None
    assert log.rows[0]["reason"].startswith("predicted 7.5e+04 right-hand sides, above the 5e+04")


@pytest.mark.parametrize("launch", [1, 2])
def test_later_launches_measure_times_alone(scorer: Scorer, launch: int) -> None:
    """States, right-hand sides and errors over turned starts are the same in every launch."""
    log = Log(scorer, launch=launch, history={("0", 1): Known(Status.OK, 4, 1.0)} if launch == 2 else {})
    log.sweep.suite = replace(SUITE, turned=True)
    log.sweep.task = replace(log.sweep.task, turned=np.ones((3, 2)))
    request = log.sweep.next()
    assert request is not None
    assert (request.turned, request.count) == (launch == 1, launch == 1)
    log.answer(0.001)
    assert [states is not None for states in log.states] == [launch == 1]

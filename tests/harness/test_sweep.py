"""When a sweep stops, what it repeats, and what it leaves alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import planted
import pytest
from gnomon.harness import plan
from gnomon.harness.judge import Judge
from gnomon.harness.store import Known
from gnomon.harness.sweep import RELAUNCHED_SECONDS, REPEATED_SECONDS, Sweep
from gnomon.harness.truth import CaseSpec, truth
from gnomon.harness.worker import FEWEST_CALLS, Outcome

SUITE = replace(plan.suite("quick"), limit_seconds=1.0)


@pytest.fixture(scope="module")
def judge() -> Judge:
    case = planted.Short().rounded()
    return Judge(case, None, truth(CaseSpec.of(case)))


class Log:
    """A sweep over eight settings, and what it recorded."""

    def __init__(self, judge: Judge, launch: int = 1, history: Any = None) -> None:
        self.rows: list[Any] = []
        self.finished = 0
        self.judge = judge
        series = plan.Series(judge.case, None, planted.Sound())
        trials = [plan.Trial(str(k), 0.1 / 2**k) for k in range(8)]
        self.sweep = Sweep(series, trials, judge, SUITE, launch, history or {}, self.record, self.finish)

    def record(self, row: Any, settings: Any, states: Any) -> None:
        self.rows.append(row)

    def finish(self) -> None:
        self.finished += 1

    def answer(self, seconds: float) -> None:
        self.sweep.done(Outcome(self.judge.truth.exact, None, None, 1, 4, (seconds,), 0.0, None))

    @property
    def statuses(self) -> list[str]:
        return [row["status"] for row in self.rows]


def test_settings_go_out_in_order_and_every_answer_is_recorded(judge: Judge) -> None:
    log = Log(judge)
    settings = []
    while (order := log.sweep.next()) is not None:
        settings.append(order.setting)
        log.answer(0.001)
    assert settings == [0.1 / 2**k for k in range(8)]
    assert log.statuses == ["ok"] * 8
    assert log.finished == 1


def test_what_would_pass_the_limit_is_skipped_with_the_prediction(judge: Judge) -> None:
    log = Log(judge)
    for seconds in (0.1, 0.2, 0.4):
        assert log.sweep.next() is not None
        log.answer(seconds)
    assert log.sweep.next() is not None, "0.8 s is within the limit"
    log.answer(0.8)
    assert log.sweep.next() is None
    assert log.statuses == ["ok"] * 4 + ["skipped"] * 4
    assert log.rows[-1]["reason"] == "predicted 1.6 s, above the limit of 1 s"


def test_hard_variants_are_timed_in_a_few_calls_where_that_costs_nothing(judge: Judge) -> None:
    default, hard = Log(judge), Log(judge)
    hard.sweep.series.case.variant = "hard"
    try:
        order = hard.sweep.next()
    finally:
        hard.sweep.series.case.variant = None
    assert order is not None
    assert (order.block_seconds, order.repeats, order.slow_seconds) == (0.0, FEWEST_CALLS, REPEATED_SECONDS)
    assert order.count is Log(judge).sweep.next().count  # type: ignore[union-attr]
    usual = default.sweep.next()
    assert usual is not None
    assert (usual.block_seconds, usual.repeats, usual.slow_seconds) == (
        SUITE.block_seconds,
        SUITE.repeats,
        SUITE.slow_seconds,
    )


def test_one_outlier_of_the_clock_is_no_growth(judge: Judge) -> None:
    log = Log(judge)
    for seconds in (0.1, 0.1, 0.4):
        log.sweep.next()
        log.answer(seconds)
    assert log.sweep.next() is not None


def test_a_timeout_ends_the_series_and_a_crash_does_not(judge: Judge) -> None:
    log = Log(judge)
    log.sweep.next()
    log.sweep.failed("crashed", "planted", "")
    log.sweep.next()
    log.sweep.failed("timeout", "no answer", "")
    assert log.sweep.next() is None
    assert log.statuses == ["crashed", "timeout"] + ["skipped"] * 6


def test_what_is_known_is_not_run_again_and_still_predicts(judge: Judge) -> None:
    known = {(str(k), 1): Known("ok", 0.2 * 2**k, 1.0) for k in range(3)}
    log = Log(judge, history=known)
    assert log.sweep.next() is None
    assert log.statuses == ["skipped"] * 5, "0.8 s doubles to 1.6 s"


def test_later_launches_repeat_what_was_quick(judge: Judge) -> None:
    seconds = [RELAUNCHED_SECONDS / 4 * 2**k for k in range(6)]
    known = {(str(k), 1): Known("ok", s, 1.0) for k, s in enumerate(seconds)}
    log = Log(judge, launch=2, history=known)
    settings = []
    while (order := log.sweep.next()) is not None:
        assert not order.count
        settings.append(order.setting)
        log.answer(0.001)
    assert settings == [0.1, 0.05, 0.025]
    assert log.statuses == ["ok"] * 3


def test_an_answer_that_cannot_be_judged_is_a_crash_of_its_own(judge: Judge) -> None:
    log = Log(judge)
    log.sweep.next()
    log.sweep.done(Outcome(judge.truth.exact[:, :1], None, None, 1, 4, (0.001,), 0.0, None))
    assert log.statuses == ["crashed"]
    assert "cannot be judged" in log.rows[0]["reason"]
    assert log.sweep.next() is not None


def test_the_work_of_a_step_size_is_known_from_one_before(judge: Judge) -> None:
    log = Log(judge)
    log.sweep.next()
    log.answer(0.6)
    assert log.sweep.next() is None
    assert log.rows[1]["reason"] == "predicted 1.2 s, above the limit of 1 s"

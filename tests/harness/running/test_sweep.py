"""When a sweep stops, which trials it repeats, and which it skips."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import planted
import pytest
from gnomon.harness.contract.integrator import Integrator, Tolerance
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.measuring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.results.store import Known
from gnomon.harness.running import plan
from gnomon.harness.running.sweep import REPEATED_SECONDS, TIMES_THE_LIMIT, Sweep
from gnomon.harness.running.worker import FEWEST_CALLS

from gnomon import cases

SUITE = plan.suite("quick").change(limit_seconds=1.0)
LIMIT = SUITE.limits.limit_seconds
FAR = TIMES_THE_LIMIT * LIMIT


class WithTolerance(planted.Sound):
    sweep = Tolerance()


@pytest.fixture(scope="module")
def scorer() -> Scorer:
    case = planted.Short().rounded()
    return Scorer(case, None, reference_solution(CaseSpec.of(case)))


def known(status: str, work: int | None = None, seconds: float | None = None) -> Known:
    return Known(Status(status), work, LIMIT, seconds)


class Log:
    """A sweep over eight settings, and the rows that it recorded."""

    def __init__(
        self,
        scorer: Scorer,
        launch: int = 1,
        history: Any = None,
        integrator: Integrator | None = None,
        suite: plan.Suite = SUITE,
    ) -> None:
        self.rows: list[Any] = []
        self.states: list[Any] = []
        self.finished = 0
        self.scorer = scorer
        series = plan.Series(scorer.case, None, integrator or planted.Sound())
        trials = [plan.Trial(str(k), 0.1 / 2**k) for k in range(8)]
        self.sweep = Sweep(series, trials, scorer, suite, launch, history or {}, self.record, self.finish)

    def record(self, row: Any, options: Any, states: Any) -> None:
        self.rows.append(row)
        self.states.append(states)

    def finish(self) -> None:
        self.finished += 1

    def answer(self, seconds: float, calls: int = 4) -> None:
        self.sweep.done(Outcome(self.scorer.reference.exact, None, None, 1, calls, (seconds,), 0.0, None))

    def run(self, cost: Callable[[float], tuple[float, int] | None]) -> list[float]:
        """The settings that were requested; `cost` is the seconds and right-hand sides of one, or None for a timeout."""
        settings = []
        while (request := self.sweep.next()) is not None:
            settings.append(request.setting)
            found = cost(request.setting)
            if found is None:
                self.sweep.failed(Status.TIMEOUT, "no answer", "")
            else:
                self.answer(*found)
        return settings

    @property
    def known(self) -> dict[tuple[str, int], Known]:
        """The rows as a later run knows them."""
        return {(row["trial_key"], row["launch"]): Known.of(row) for row in self.rows}

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
        SUITE.timing.block_seconds,
        SUITE.timing.repeats,
        SUITE.timing.slow_seconds,
    )


@pytest.mark.parametrize("ending", ["unsupported", "not_installed"])
def test_what_cannot_run_ends_the_series_and_a_crash_does_not(scorer: Scorer, ending: str) -> None:
    """A library is missing at every setting."""
    log = Log(scorer)
    log.sweep.next()
    log.sweep.failed(Status.CRASHED, "planted", "")
    log.sweep.next()
    log.sweep.failed(Status(ending), "no answer", "")
    assert log.sweep.next() is None
    assert log.statuses == ["crashed", ending] + ["skipped"] * 6


def test_a_timeout_does_not_end_a_series_and_three_in_a_row_do(scorer: Scorer) -> None:
    """A loose tolerance may be the one that hangs. The reason names the settings."""
    hangs = {0.1, 0.05, 0.1 / 8, 0.1 / 16, 0.1 / 32}
    log = Log(scorer, integrator=WithTolerance())
    log.run(lambda setting: None if setting in hangs else (0.001, 4))
    assert log.statuses == ["timeout"] * 2 + ["ok"] + ["timeout"] * 3 + ["skipped"] * 2
    assert {row["reason"] for row in log.rows[-2:]} == {
        "the 3 settings before it ended as timeout: 0.0125, 0.00625, 0.00313"
    }


def test_a_tolerance_that_hangs_near_a_pericentre_leaves_the_others() -> None:
    """On this orbit the loosest tolerance of an adaptive method may step over the pericentre and never come back."""
    case = cases.get("kepler_orbit", "e0999").rounded()
    close = Scorer(case, None, reference_solution(CaseSpec.of(case)))
    log = Log(close, integrator=WithTolerance(), suite=plan.suite("foundation"))
    assert log.sweep.limit_seconds == 0.08
    seconds = iter((0.016, 0.018, 0.021, 0.024, 0.027, 0.029, 0.031))
    log.run(lambda setting: None if setting == 0.1 else (next(seconds), 10**4))
    assert log.statuses == ["timeout"] + ["ok"] * 7


def test_an_outcome_that_cannot_be_scored_is_a_crash_of_its_trial_only(scorer: Scorer) -> None:
    log = Log(scorer)
    log.sweep.next()
    log.sweep.done(Outcome(scorer.reference.exact[:, :1], None, None, 1, 4, (0.001,), 0.0, None))
    assert log.statuses == ["crashed"]
    assert "cannot be scored" in log.rows[0]["reason"]
    assert log.sweep.next() is not None


@pytest.mark.parametrize("clock", [2.0**-10, 1.0, 2.0**10], ids=lambda factor: f"clock x {factor:g}")
def test_a_setting_is_left_out_at_three_times_the_limit_by_the_series_own_cost(scorer: Scorer, clock: float) -> None:
    """The measured cost of a right-hand side decides, and no constant. Both numbers stand in the reason."""
    each, first = clock * FAR * 2.0**-20, 2**15 / clock
    log = Log(scorer, integrator=planted.Sound())
    log.run(lambda setting: (0.1 / setting * first * each, round(0.1 / setting * first)))
    assert log.statuses == ["ok"] * 5 + ["skipped"] * 3, "the sixth takes 2^5 times as long as the first"
    (reason,) = {row["reason"] for row in log.rows[5:]}
    assert reason == (
        f"predicted 3 s, at least 3 times the limit of 1 s: {first * 2**5:.3g} right-hand sides, by their smallest"
        f" growth, of {each:.3g} s each, the fastest measured"
    )


def test_the_fastest_cost_decides(scorer: Scorer) -> None:
    """A call that waited, or that a compiler preceded, must not cut off the settings after it."""
    log = Log(scorer, integrator=planted.Sound())
    work = iter([100, 200, 400, 800, 1600, 3200, 6400, 12800])
    log.run(lambda setting: (0.0001 if setting == 0.05 else 0.9, next(work)))
    assert log.statuses == ["ok"] * 8


def test_a_series_without_counts_or_times_is_not_predicted(scorer: Scorer) -> None:
    log = Log(scorer)
    while log.sweep.next() is not None:
        log.sweep.done(Outcome(scorer.reference.exact, None, None, None, None, (0.9,), 0.0, None))
    assert log.statuses == ["ok"] * 8
    untimed = Log(scorer, suite=SUITE.untimed())
    untimed.run(lambda setting: (0.09 / setting, round(100 / setting)))
    assert untimed.statuses == ["ok"] * 8, "a file without times would decide otherwise when the run is resumed"


def test_a_tolerance_is_predicted_by_the_smallest_growth_so_far(scorer: Scorer) -> None:
    log = Log(scorer, integrator=WithTolerance())
    seconds = [FAR * share for share in (0.1, 0.12, 0.6, 0.9)]
    log.run(lambda setting: (s := seconds[len(log.rows)], round(s * 2**20)))
    assert log.statuses == ["ok"] * 4 + ["skipped"] * 4, ".6 grows by 1.2 to .72, and .9 by 1.5"


def test_a_jump_of_the_first_count_predicts_nothing(scorer: Scorer) -> None:
    """The loosest tolerance of an adaptive method may miss a pericentre: the next growth is not the method's."""
    log = Log(scorer, integrator=WithTolerance())
    work = [10, 1000, 1200, 1440, 1728, 2074, 2488, 2986]
    log.run(lambda _: (work[len(log.rows)] / 1000 * FAR / 10, work[len(log.rows)]))
    assert log.statuses == ["ok"] * 8


def test_a_count_that_fell_predicts_none_below_it(scorer: Scorer) -> None:
    """A tighter tolerance takes at least as many right-hand sides: a count that falls is chance."""
    history = {(str(k), 1): known("ok", n, n / 2000 * FAR) for k, n in enumerate((4000, 2000))}
    log = Log(scorer, history=history, integrator=WithTolerance())
    assert log.sweep.next() is None
    assert log.statuses == ["skipped"] * 6


@pytest.mark.parametrize("ended", range(8))
def test_a_resumed_run_decides_as_one_that_was_not_interrupted(scorer: Scorer, ended: int) -> None:
    """After any number of recorded settings: the measurements in the file alone decide which settings are skipped."""

    def cost(setting: float) -> tuple[float, int] | None:
        return None if setting in (0.1, 0.1 / 8) else (0.2 * FAR / setting / 80, round(100 / setting))

    whole = Log(scorer, integrator=planted.Sound())
    whole.run(cost)
    assert whole.statuses == ["timeout", "ok", "ok", "timeout", "ok", "ok", "skipped", "skipped"]
    rest = Log(scorer, history=dict(list(whole.known.items())[:ended]), integrator=planted.Sound())
    rest.run(cost)
    assert rest.statuses == whole.statuses[ended:]


def test_later_launches_repeat_what_the_first_one_scored_and_decide_nothing(scorer: Scorer) -> None:
    """On a busy machine too: a file is one comparison only if all launches have the same settings."""
    first = Log(scorer, integrator=planted.Sound())
    first.run(lambda setting: None if setting == 0.05 else (0.002 * FAR / setting, round(100 / setting)))
    ran = [k for k, status in enumerate(first.statuses) if status == "ok"]
    assert (len(ran), first.statuses[-1]) == (5, "skipped")
    for slow in (lambda _: (1000 * FAR, 0), lambda _: None):
        later = Log(scorer, launch=2, history=first.known, integrator=planted.Sound())
        assert later.run(slow) == [0.1 / 2**k for k in ran]
        assert "skipped" not in later.statuses


def test_each_setting_has_its_own_place(scorer: Scorer) -> None:
    """The start of its counting run must not depend on which trials an earlier run measured."""
    log = Log(scorer, history={("0", 1): known("ok", 4, 0.001)})
    places = []
    while (request := log.sweep.next()) is not None:
        places.append(request.place)
        log.answer(0.001)
    assert places == list(range(1, 8))


@pytest.mark.parametrize("launch", [1, 2])
def test_later_launches_measure_times_alone(scorer: Scorer, launch: int) -> None:
    """States, right-hand sides and errors over turned starts are the same in every launch."""
    log = Log(scorer, launch=launch, history={("0", 1): known("ok", 4, 0.001)} if launch == 2 else {})
    log.sweep.suite = SUITE.change(turned=True)
    log.sweep.task = replace(log.sweep.task, turned=np.ones((3, 2)))
    request = log.sweep.next()
    assert request is not None
    assert (request.turned, request.count) == (launch == 1, launch == 1)
    log.answer(0.001)
    assert [states is not None for states in log.states] == [launch == 1]

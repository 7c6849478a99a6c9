"""The time that the harness adds to a trial: scoring, storing, and messages to and from a worker process."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import planted
import pytest
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.measuring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.results.store import Store
from gnomon.harness.running import plan
from gnomon.harness.running.pool import Pool
from gnomon.harness.running.sweep import Sweep

pytestmark = pytest.mark.benchmark
TRIALS = 100


class Idle(planted.Sound):
    """Returns at once: the time of its trials is overhead."""

    name = "idle"
    counts_rhs = False

    def prepare(self, problem: Any, setting: float) -> Any:
        solve = super().prepare(problem, problem.interval)
        known = {}

        def idle(initial_states: Any) -> Any:
            if not known:
                known["solution"] = solve(initial_states)
            known["solution"].states[0, 0] = initial_states[0]
            return known["solution"]

        return idle


@pytest.fixture(scope="module")
def scorer() -> Scorer:
    case = planted.Short().rounded()
    return Scorer(case, None, reference_solution(CaseSpec.of(case)))


def outcome(scorer: Scorer) -> Outcome:
    states = scorer.reference.exact * (1 + 1e-9)
    return Outcome(states, None, None, 100, 400, (1e-5,) * 50, 1e-3, None)


def test_scoring_a_trial(benchmark: Callable[..., Any], scorer: Scorer) -> None:
    solved = outcome(scorer)
    row, _ = benchmark(scorer.measure, solved, 1e-9)
    assert row["status"] == "ok"


def test_storing_a_trial(benchmark: Callable[..., Any], scorer: Scorer, tmp_path: Path) -> None:
    row, states = scorer.measure(outcome(scorer), None)
    with Store(tmp_path / "results.sqlite") as results:
        run = results.begin_run("benchmark", "", {})
        series = plan.Series(scorer.case, None, planted.Sound())
        (trial, *_) = series.trials(scorer.problem(series.form))
        results.plan(run, [series.describe(trial)])
        benchmark(results.add, run, {"trial_key": trial.key, "launch": 1, **row}, {}, states)


def test_a_trial_through_a_worker(benchmark: Any, scorer: Scorer) -> None:
    """A hundred trials that take no time, through one worker: messages, set-up of the problem, scoring."""
    suite = plan.suite("quick").change(repeats=1, block_seconds=0.0)
    series = plan.Series(scorer.case, None, Idle())
    (first, *_) = series.trials(scorer.problem(series.form))
    trials = [plan.Trial(str(k), first.setting) for k in range(TRIALS)]
    statuses: list[str] = []

    def hundred() -> None:
        def record(row: Any, options: Any, states: Any) -> None:
            statuses.append(row["status"])

        Pool(1, "fork").run([Sweep(series, trials, scorer, suite, 1, {}, record, lambda: None)])

    benchmark.pedantic(hundred, rounds=3, warmup_rounds=1)
    assert statuses
    assert len(statuses) % TRIALS == 0

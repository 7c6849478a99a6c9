"""The first trial does not wait for the exact motions of other cases, and nothing is lost by that."""

from pathlib import Path
from typing import Any

import planted
import pytest
from gnomon.harness.contract.status import Status
from gnomon.harness.registry import selection
from gnomon.harness.results import store
from gnomon.harness.results.outstanding import outstanding
from gnomon.harness.running import plan, planned_run
from gnomon.harness.running.planned_run import run

SUITE = plan.suite("quick")
CASES = ["planted:Short", "harmonic_oscillator", "projectile_parabola"]


class NoProcesses:
    """A pool in whose trials every integrator declines."""

    def __init__(self, *_: Any) -> None: ...

    def run(self, jobs: Any, interlude: Any = None) -> None:
        for job in jobs:
            while job is not None and job.next() is not None:
                job.failed(Status.REFUSED, "planted", "")


@pytest.fixture
def done(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What a run does: computes exact motions, and records trials. Nothing is kept on disk."""
    found: list[str] = []
    compute, add = planned_run._reference_solutions, store.Store.add

    def computes(series: Any, progress: Any) -> Any:
        found.extend(f"exact {one.case.name}" for one in series)
        return compute(series, progress)

    def adds(self: Any, number: int, row: Any, *more: Any) -> None:
        found.append("trial")
        add(self, number, row, *more)

    monkeypatch.setattr(planned_run, "Pool", NoProcesses)
    monkeypatch.setattr(planned_run, "find_kept", lambda spec: None)
    monkeypatch.setattr(planned_run, "_reference_solutions", computes)
    monkeypatch.setattr(store.Store, "add", adds)
    return found


def test_the_first_trial_waits_for_its_own_exact_motion_only(tmp_path: Path, done: list[str]) -> None:
    path = run(tmp_path, SUITE, selection.choose(CASES, False), [planted.Sound()])
    first, *_ = selection.choose(CASES[:1], False)
    assert done[:2] == [f"exact {first[0].name}", "trial"]
    assert {name for name in done if name != "trial"} >= {"exact harmonic_oscillator", "exact projectile_parabola"}
    frame = store.load(path)
    assert set(frame["case"]) == {case.name for case, _ in selection.choose(CASES, False)}
    assert not outstanding(path).text


def test_a_file_says_that_its_run_has_not_ended_while_cases_are_not_planned(
    tmp_path: Path, done: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    compute = planned_run._reference_solutions

    def interrupted(series: Any, progress: Any) -> Any:
        if len(series) > 1:
            raise KeyboardInterrupt
        return compute(series, progress)

    monkeypatch.setattr(planned_run, "_reference_solutions", interrupted)
    chosen = selection.choose(CASES, False)
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, SUITE, chosen, [planted.Sound()])
    assert "not ended" in outstanding(tmp_path).text
    monkeypatch.setattr(planned_run, "_reference_solutions", compute)
    path = run(tmp_path, SUITE, chosen, [planted.Sound()])
    assert set(store.load(path)["case"]) == {case.name for case, _ in chosen}
    assert not outstanding(path).text


def test_launches_that_are_repeated_are_planned_at_once(tmp_path: Path, done: list[str]) -> None:
    """So that every series is launched once before one is repeated, and a drift of the machine meets all alike."""
    run(tmp_path, SUITE.change(launches=2), selection.choose(CASES, False), [planted.Sound()])
    assert "trial" not in done[:3]

"""The first use of an integrator is measured once, in a new process with empty caches, and disturbs nothing."""

import os
from pathlib import Path
from typing import Any

import planted
import pytest
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.registry import lookup, references, selection
from gnomon.harness.results import store
from gnomon.harness.running import first_use, plan
from gnomon.harness.running.first_use import CACHES, first_seconds
from gnomon.harness.running.planned_run import run
from waiting import LONG_SECONDS

from gnomon import cases

SUITE = plan.suite("quick").within(LONG_SECONDS).change(first_use=True)
SHORT = CaseSpec.of(planted.Short().rounded())


@pytest.fixture(autouse=True)
def first_case(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan, "_first_case", lambda _integrator: planted.Short().name)


def measured(folder: Path, suite: plan.Suite) -> Any:
    run(
        folder, suite, selection.choose(["planted:Short"], False), [planted.SlowAtFirst()], prepare_seconds=LONG_SECONDS
    )
    return store.load(folder, superseded=True)


def test_it_is_measured_at_the_first_trial_of_a_series_once(tmp_path: Path) -> None:
    """Without it first, as in a suite that does not measure it: only the first trial is run again, and no second time."""
    without = measured(tmp_path, SUITE.change(first_use=False))
    assert without["first_seconds"].isna().all()
    found = measured(tmp_path, SUITE)
    (again,) = found[found["first_seconds"].notna()].to_dict("records")
    assert len(found) == len(without) + 1
    assert again["setting"] == without["setting"].max()
    assert again["first_seconds"] >= planted.SlowAtFirst.seconds
    assert len(measured(tmp_path, SUITE)) == len(found)


def test_its_caches_are_empty_and_end_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The caches of this process are neither used nor changed."""
    monkeypatch.setattr(first_use, "MOST_SECONDS", LONG_SECONDS)
    for name in CACHES:
        monkeypatch.setenv(name, str(tmp_path / "kept"))
    seconds = [
        first_seconds(references.reference(planted.SlowAtFirst()), SHORT, planted.Short().rounded().times[0], tmp_path)
        for _ in range(2)
    ]
    assert all(each is not None and each >= planted.SlowAtFirst.seconds for each in seconds)
    assert not os.listdir(tmp_path)


def test_waits_for_a_processor_are_not_in_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """A compilation of 2 s took 20 s on a machine with load 14. Here the process waits for most of a simulated time."""
    readings = iter([5 * 10**9, 95 * 10**9])
    clock = iter([0, 100 * 10**9])
    monkeypatch.setattr(first_use, "perf_counter_ns", lambda: next(clock))
    monkeypatch.setattr(first_use, "run_delays", lambda: {str(os.getpid()): next(readings), "another": 7})
    assert first_use.measure_first_use(
        references.reference(planted.Sound()), SHORT, 0.08437502384185791
    ) == pytest.approx(10.0)


def test_what_fails_in_a_new_process_has_no_time(tmp_path: Path) -> None:
    for kind in (planted.Raises, planted.Aborts):
        assert first_seconds(references.reference(kind()), SHORT, 0.1, tmp_path) is None


@pytest.mark.parametrize("integrator", ["gnomon:RK4", "rebound:IAS15", "pybullet:stepSimulation [configured]"])
def test_the_case_of_an_integrator_is_one_that_it_takes(integrator: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    (found,) = lookup.find(integrator)
    if (reason := lookup.missing(found)) is not None:
        pytest.skip(reason)
    series = [one for one in plan.list_series(selection.choose(plan.FOUNDATION, True), [found]) if one.left_out is None]
    wanted = [one for one in series if plan.wants_first_use(one, SUITE, 1)]
    assert len(wanted) == 1
    assert wanted[0].case.variant is None
    assert wanted[0].case.name in cases.names()
    assert not any(plan.wants_first_use(one, SUITE, 2) for one in series)
    assert not any(plan.wants_first_use(one, SUITE.untimed(), 1) for one in series)

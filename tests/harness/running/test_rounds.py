"""Rounds of repeated launches, the order of a run, and complete problems."""

from pathlib import Path
from typing import Any

import planted
import pytest
from gnomon.harness.contract.status import Status
from gnomon.harness.registry import lookup, selection
from gnomon.harness.registry.kinds import KINDS
from gnomon.harness.results import outstanding, reading
from gnomon.harness.results.contenders import MOST_LAUNCHES
from gnomon.harness.results.store import Store
from gnomon.harness.running import order, plan, planned_run, rounds
from gnomon.harness.running.rounds import Rounds
from waiting import LONG_SECONDS

STANDARD = plan.suite("standard")


class File:
    """Timed rows of integrators in one case, whose launches scatter so much that no number of them separates two."""

    def __init__(self, **seconds: float) -> None:
        self.seconds, self.rows = seconds, list[dict[str, Any]]()
        self.launch(1, set())

    def launch(self, number: int, wanted: set[tuple[str, str, str]]) -> None:
        for name, seconds in self.seconds.items():
            for setting in (1e-4, 1e-8):
                row = {"case": "c", "variant": "default", "formulation": "standard", "library": name[0]}
                row |= {"integrator_id": name, "setting": setting, "machine": "m", "trial_key": f"{name} {setting}"}
                row |= {"run": 1, "launch": number, "status": Status.OK, "reason": None, "error_max": setting}
                row |= {"seconds_median": seconds * (1 + 0.3 * ((number * len(name)) % 3)), "null_seconds": 1e-9}
                row |= {"null_work": 0, "delay_seconds": 0.0, "rhs_calls": 9, "steps": 9, "turned_starts": None}
                if not wanted or ("c", "", name) in wanted:
                    self.rows.append(row)


def test_rounds_launch_those_near_the_fastest_and_end() -> None:
    file = File(x=1.0, yy=1.1, zz=9.0)
    further, launches = Rounds(lambda: file.rows, 60.0, rounds.monotonic()), list[int]()
    while (found := further.next()) is not None:
        launch, series = found
        assert series == {("c", "", "x"): {1e-4, 1e-8}, ("c", "", "yy"): {1e-4, 1e-8}}, "those beside the errors"
        file.launch(launch, set(series))
        launches.append(launch)
    assert launches == list(range(2, MOST_LAUNCHES + 1))
    assert rounds.EXHAUSTED in further.record()


def test_rounds_end_with_their_time_or_if_launches_fail() -> None:
    file = File(x=1.0, yy=1.1)
    spent = Rounds(lambda: file.rows, 0.0, rounds.monotonic() - 1)
    assert spent.next() is None
    assert rounds.SPENT in spent.record()
    failing = Rounds(lambda: file.rows, 60.0, rounds.monotonic())
    for number in range(2, rounds.LARGEST + 1):
        file.rows += [{**row, "launch": number, "seconds_median": None} for row in file.rows if row["launch"] == 1]
        if failing.next() is None:
            break
    assert failing.begun < rounds.LARGEST


@pytest.fixture(scope="module")
def case_run(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A run of two integrators whose calls take one time by the clock of the workers, so that comparisons are undecided, and
    no time for rounds; then the same commands again."""
    folder = tmp_path_factory.mktemp("rounds")
    chosen, equal = selection.choose(["planted:Short"], False), [planted.HalfAMillisecond(), planted.AsFast()]
    suite = plan.suite("quick").change(minutes=1e-9, repeats=3, block_seconds=0.001).within(LONG_SECONDS)

    def again(**changes: Any) -> tuple[set[int], str | None]:
        path = planned_run.run(folder, suite.change(**changes), chosen, equal)
        record = reading.runs(path)[-1]["environment"].get(rounds.NAME)
        return {row["launch"] for row in reading.rows(path)}, record

    return again


def test_an_equal_command_begins_no_round_unless_the_user_asks(case_run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A finished run says why it ended its rounds, and the same command takes its word."""
    monkeypatch.setattr(rounds.contenders, "MOST_LAUNCHES", 2)
    launches, record = case_run()
    assert launches == {1}
    assert rounds.SPENT in record
    assert case_run(minutes=LONG_SECONDS) == ({1}, record)
    launches, later = case_run(minutes=LONG_SECONDS, asked=True)
    assert launches == {1, 2}
    assert later.startswith("1 round ")


def test_cases_of_each_kind_come_first_and_hard_variants_last() -> None:
    """A page of an unfinished run has then cases of each kind on which everything ran."""
    one = lookup.find_all(["gnomon:RK4", "scipy:DOP853", "gnomon:RKMK 4", "gnomon:RK4 [events]", "rebound:IAS15"])
    found = plan.list_series(selection.choose(STANDARD.names(), False), one)
    places = order.places(found)
    ordered = sorted((series for series in found if series.left_out is None), key=lambda series: places[series.id])
    own = [series.case for series in ordered if series.case.variant is None]
    hard = [series.case.variant is not None for series in ordered]
    assert hard == sorted(hard)
    names = list(dict.fromkeys(case.name for case in own))
    assert len({places[series.id][2] for series in ordered if series.case.name in names[: len(KINDS)]}) >= 6
    blocks = [case.name for k, case in enumerate(own) if k == 0 or own[k - 1].name != case.name]
    assert len(blocks) == len(set(blocks)), "all integrators run on a case before the next case begins"


def test_a_problem_is_complete_once_everything_planned_on_it_was_measured(tmp_path: Path) -> None:
    chosen = selection.choose(["harmonic_oscillator", "projectile_parabola/vertical"], False)
    found = plan.list_series(chosen, lookup.find_all(["gnomon:RK4", "scipy:DOP853"]))
    path = tmp_path / "results.sqlite"
    with Store(path) as file:
        run = file.begin_run("standard", "", {})
        rows = [(series, trial) for series in found for trial in series_trials(series)]
        file.plan(run, [series.describe(trial) for series, trial in rows])
        assert outstanding.complete(path) == set()
        *first, last = [row for row in rows if row[0].case.name == "harmonic_oscillator"]
        for _, trial in first:
            file.add(run, {"trial_key": trial.key, "launch": 1, "status": "ok"})
        assert outstanding.complete(path) == set()
        file.add(run, {"trial_key": last[1].key, "launch": 1, "status": "interrupted"})
        file.add(run, {"trial_key": last[1].key, "launch": 2, "status": "ok"})
        assert outstanding.complete(path) == set()
        file.add(run, {"trial_key": last[1].key, "launch": 1, "status": "skipped"})
        assert outstanding.complete(path) == {("harmonic_oscillator", "default")}


def series_trials(series: plan.Series) -> tuple[plan.Trial, ...]:
    key = series.id
    return tuple(plan.Trial(f"{key} {setting}", setting) for setting in (0.1, 0.01))

"""The faults that `make verification` measures are there, of all kinds, and a few of them are found by a claim alone."""

import itertools
import json
import math
import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import family_faults
import measure
import mutants
import planted_faults
import pytest
import summary
from defects import DEFECTS
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.verification.claims import DEPTHS, Outcome
from gnomon.harness.verification.verify import CLAIMS
from waiting import LIMIT_SECONDS

from gnomon import cases

FOUND = (
    ("verlet", "the half kick at the end is left out", "reversible", "pendulum_simple"),
    ("dormand_prince", "the tolerance is a constant", "proportional", "forced_oscillator"),
    ("dormand_prince", "the step size is kept between runs", "repeatable", "forced_oscillator"),
    ("rk4_events", "an event is at the end of its step", "event_order", "bouncing_ball"),
    ("rk4_events", "the reset is left out", "event_order", "bouncing_ball"),
    ("rotation", "the rotation from the other side", "step_order", "symmetric_top_torque_free"),
    ("LeapfrogEngine", "a forgotten substep", "step_order", "projectile_parabola"),
    ("LeapfrogEngine", "forces a step late", "order_short", "two_body"),
    ("bogacki_shampine", "the second-order row is passed on", "work_order", "forced_oscillator"),
    ("rattle", "one iteration for the constraint", "constraint", "holonomic_constraint_dae"),
    ("rotation", "three terms of the exponential's series", "attitude", "euler_top"),
    ("radau3", "the iteration stops at 1e-4", "more_variables", "pendulum_simple"),
    ("rk4_events", "the guard has the time of the step's start", "event_order", "sliding_can"),
    ("LeapfrogEngine", "the third component of forces is left out", "scene", "projectile_parabola"),
    ("LeapfrogEngine", "forces of an earlier scene", "scene", "projectile_parabola"),
    ("LeapfrogEngine", "the clock does not advance", "scene", "projectile_parabola"),
    ("LeapfrogEngine", "position and velocity take turns: symplectic Euler", "scene", "projectile_parabola"),
)


ROW = {"condition": "plain", "depth": "normal", "load": 0, "changed": True, "claim": None, "case": None, "checked": 3,
       "seconds": 1.0, "error": None, "sources": "hash"}  # fmt: skip
"""A row of a mutant that no claim finds, without its kind and name."""


def test_there_are_as_many_faults_of_as_many_kinds_as_promised() -> None:
    drawn = mutants.drawn(measure.DRAWN)
    kinds = Counter(mutant.method.name for mutant in drawn)
    assert len({mutant.id for mutant in drawn}) == len(drawn) >= 200
    assert len(kinds) >= 6
    assert min(kinds.values()) >= 10
    assert [m.id for m in drawn] == [m.id for m in mutants.drawn(measure.DRAWN)], (
        "the draw is the same each time, so that a measurement can be resumed"
    )
    assert len({mutant.id for mutant in measure.faulty()}) == len(measure.faulty()) >= len(drawn) + 120
    assert len({defect.link for defect in DEFECTS}) == len(DEFECTS) >= 25


def test_every_reason_of_a_survivor_names_a_fault() -> None:
    """A name has the line of its fault: after an edit above it, the reason would explain nothing."""
    names = [m.id for m in [*mutants.mutants(), *planted_faults.planted(), *family_faults.family_planted()]]
    assert [begin for begin in summary.REASONS if not any(name.startswith(begin) for name in names)] == []


def test_every_defect_and_chosen_fault_can_be_built_and_differs_from_the_right_method() -> None:
    for defect in DEFECTS:
        defect.integrator()
    chosen = {fault for _, fault, _, _ in mutants.CHOSEN}
    for mutant in [*(each for each in mutants.mutants() if each.fault in chosen), *planted_faults.planted()]:
        assert mutant.text != planted_faults.source(mutant.method)
        mutant.integrator()
    for mutant in family_faults.family_planted():
        assert mutant.text != family_faults.source(mutant.method)
        mutant.integrator()
    for mutant in mutants.drawn(measure.DRAWN)[::20]:
        mutant.integrator()


@pytest.mark.parametrize(("method", "fault", "claim", "case"), FOUND)
def test_a_claim_alone_finds_a_fault_and_does_not_fail_the_right_method(
    method: str, fault: str, claim: str, case: str
) -> None:
    every = [*mutants.mutants(), *planted_faults.planted()]
    faulty = next(m for m in every if (m.method.name, m.fault) == (method, fault)).integrator()
    assert outcome(faulty, claim, case) == Outcome.FAILED
    assert outcome(measure.right()[method], claim, case) != Outcome.FAILED


def outcome(integrator: Any, claim: str, case: str) -> Outcome:
    trials = Trials.of(integrator, CaseSpec.of(cases.get(case).rounded()), DEPTHS["low"])
    return CLAIMS[claim].check(trials).outcome


@pytest.mark.parametrize("installed", [None, 0, 20, 50, 100, 400])
def test_runs_of_right_integrators_are_at_least_200_with_20_under_every_condition(
    installed: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With any set of extras, with as many integrators as they install: or as many runs as there can be."""
    if installed is not None:
        one = next(iter(measure.lookup.own().values()))
        named = {f"library:method {k}": one for k in range(installed)}
        monkeypatch.setattr(measure.lookup, "everything", lambda: named)
    runs = [task for task in measure.tasks() if task.kind == "right"]
    counts = Counter(task.condition for task in runs)
    names = {task.name for task in runs}
    assert len(names) == (len(names) if installed is None else installed + len(measure.right()))
    assert counts["plain"] == len(names)
    assert set(counts) == set(measure.CONDITIONS)
    assert min(counts.values()) >= min(20, len(names))
    assert len(set(runs)) == len(runs) >= min(200, len(measure.CONDITIONS) * len(names))


def test_the_bound_of_false_alarms_counts_integrators() -> None:
    """No alarm in n independent runs: (1 - rate)^n = 0.05. Four conditions of one integrator are not four such runs."""
    assert summary.most_alarms(0, 90) == pytest.approx(1 - math.exp(math.log(0.05) / 90))
    runs = [
        ROW | {"kind": "right", "name": f"integrator {k}", "condition": name, "depth": "low"}
        for k in range(50)
        for name in measure.CONDITIONS
    ]
    found = summary.published(runs, measure.FAULT_DEPTHS, "low")
    assert found["false_alarm_rate_at_most"] == round(summary.most_alarms(0, 50), 3)
    assert found["right_integrators"] == 50


def test_a_row_is_resumed_after_its_last_part(tmp_path: Path) -> None:
    """Parts make the same row as one verification, and a row that is begun goes on with the part after the last one."""
    faulty = next(m for m in mutants.mutants() if m.id == "verlet: the half kick at the end is left out").integrator()
    failure, _, done, whole = measure.first_failure(faulty, "low")
    assert failure is not None
    assert whole
    claims, case = measure.parts(faulty, "low")[done - 1]
    assert failure[0] in claims
    assert failure[1] == case
    right = mutants.right()["verlet"]
    first = measure.first_failure(right, "low", seconds=0.0)
    assert first[2:] == (1, False)
    assert measure.first_failure(right, "low", begin=1, seconds=0.0)[2:] == (2, False)
    task = measure.Task("right", "verlet of right_methods.py")
    begun = measure.Measured(**vars(task), sources="now", parts=1, checked=5)
    file = tmp_path / "rows.jsonl"
    file.write_text("".join(json.dumps(asdict(row)) + "\n" for row in (begun, replace(begun, parts=2))))
    assert measure.read(file, "now", keep_found=False)[task].parts == 2
    assert measure.read(file, "other sources", keep_found=True) == {}


def test_a_survivor_without_a_reason_and_a_false_alarm_are_published() -> None:
    rows = [ROW | {"kind": "mutant", "name": "rk4: sign, line 1 column 2: a + b"},
            ROW | {"kind": "mutant", "name": "rk4: sign, line 1 column 2: a + b", "depth": "low", "claim": "order"},
            ROW | {"kind": "defect", "name": "link", "claim": "order", "case": "two_body"},
            ROW | {"kind": "right", "name": "x", "claim": "order", "case": "two_body", "load": 8},
            ROW | {"kind": "right", "name": "scipy:LSODA [events]", "claim": "events", "case": "bouncing_ball"}]  # fmt: skip
    found = summary.published(rows, measure.FAULT_DEPTHS, "low")
    assert found["survivors_without_reason"] == ["rk4: sign, line 1 column 2: a + b"]
    assert found["false_alarms"] == ["x: order on two_body (plain, load 8)"]
    assert list(found["true_alarms"]) == ["scipy:LSODA [events]: events on bouncing_ball"]
    assert (found["mutants"]["share"], found["mutants_at_low"]["share"], found["defects"]["share"]) == (0.0, 1.0, 1.0)


def test_a_draw_of_mutants_is_the_same_each_time_and_is_published_with_its_interval() -> None:
    """A larger draw goes on with a smaller one. All defects and right integrators are measured with any draw."""
    few, more = (measure.tasks(count=count) for count in (5, 20))
    assert set(few) < set(more) < set(measure.tasks())
    assert {task for task in few if task.kind != "mutant"} == {
        task for task in measure.tasks() if task.kind != "mutant"
    }
    rows = [
        ROW
        | {
            "kind": "mutant",
            "name": f"rk4: sign, line {k} column 2: a",
            "depth": depth,
            "claim": "order" if k else None,
        }
        for k in range(20)
        for depth in measure.FAULT_DEPTHS
    ]
    draw = {"seed": measure.SEED, "mutants": 20, "of": 300}
    found = summary.published(rows, measure.FAULT_DEPTHS, "low", draw)["mutants"]
    assert found["draw"] == draw
    assert found["interval"] == pytest.approx([0.7513, 0.9987], abs=1e-4), "Clopper and Pearson for 19 of 20"
    assert "interval" not in summary.published(rows, measure.FAULT_DEPTHS, "low")["mutants"], "all are no sample"


def test_an_interruption_keeps_the_parts_that_have_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No part is begun after it, also of tasks that wait. It comes in the fourth part, which ends once it has arrived."""
    begun: list[measure.Measured] = []
    numbers, fourth, arrived = itertools.count(1), threading.Event(), threading.Event()

    def interrupt() -> None:
        assert fourth.wait(LIMIT_SECONDS)
        raise KeyboardInterrupt

    class Pool(ThreadPoolExecutor):
        def submit(self, *work: Any) -> Any:
            super().submit(*work)
            return SimpleNamespace(result=interrupt)

        def shutdown(self, *_: Any, **options: Any) -> None:
            arrived.set()
            super().shutdown(*_, **options)

    def part(row: measure.Measured) -> measure.Measured:
        begun.append(row)
        if next(numbers) >= 4:
            fourth.set()
            assert arrived.wait(LIMIT_SECONDS)
        return replace(row, parts=row.parts + 1)

    monkeypatch.setattr(measure, "in_process", part)
    monkeypatch.setattr(measure, "ThreadPoolExecutor", Pool)
    file = tmp_path / "rows.jsonl"
    file.touch()
    threads = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        measure.measure([measure.Task("right", f"integrator {k}") for k in range(5)], {}, file, "now", 2)
    assert threading.active_count() == threads, "none that could begin a part is left"
    assert {row.name for row in begun} <= {"integrator 0", "integrator 1"}
    assert 4 <= len(begun) <= 5
    assert len(file.read_text().splitlines()) == len(begun)

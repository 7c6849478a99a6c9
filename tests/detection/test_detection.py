"""The faults that `make verification` measures are there, of all kinds, and a few of them are found by a claim alone."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

import measure
import mutants
import planted
import pytest
import summary
from defects import DEFECTS
from gnomon.harness.scoring.reference_solution import CaseSpec
from gnomon.harness.verification.claims import Outcome
from gnomon.harness.verification.trials import DEPTHS, Trials
from gnomon.harness.verification.verify import CLAIMS

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
)


def test_there_are_as_many_faults_of_as_many_kinds_as_promised() -> None:
    drawn = mutants.drawn(measure.DRAWN)
    kinds = Counter(mutant.method.name for mutant in drawn)
    assert len({mutant.id for mutant in drawn}) == len(drawn) >= 200
    assert len(kinds) >= 6
    assert min(kinds.values()) >= 10
    assert [m.id for m in drawn] == [m.id for m in mutants.drawn(measure.DRAWN)], (
        "the draw is the same each time, so that a measurement can be resumed"
    )
    assert len({mutant.id for mutant in measure.faulty()}) == len(measure.faulty()) >= len(drawn) + 60
    assert len({defect.link for defect in DEFECTS}) == len(DEFECTS) >= 25


def test_every_defect_and_chosen_fault_can_be_built_and_differs_from_the_right_method() -> None:
    for defect in DEFECTS:
        defect.integrator()
    chosen = {fault for _, fault, _, _ in mutants.CHOSEN}
    for mutant in [*(each for each in mutants.mutants() if each.fault in chosen), *planted.planted()]:
        assert mutant.text != planted.source(mutant.method)
        mutant.integrator()
    for mutant in mutants.drawn(measure.DRAWN)[::20]:
        mutant.integrator()


@pytest.mark.parametrize(("method", "fault", "claim", "case"), FOUND)
def test_a_claim_alone_finds_a_fault_and_does_not_fail_the_right_method(
    method: str, fault: str, claim: str, case: str
) -> None:
    faulty = next(m for m in mutants.mutants() if (m.method.name, m.fault) == (method, fault)).integrator()
    assert outcome(faulty, claim, case) == Outcome.FAILED
    assert outcome(mutants.right()[method], claim, case) != Outcome.FAILED


def outcome(integrator: Any, claim: str, case: str) -> Outcome:
    trials = Trials.of(integrator, CaseSpec.of(cases.get(case).rounded()), DEPTHS["low"])
    return CLAIMS[claim].check(trials).outcome


def test_runs_of_right_integrators_are_at_least_200_under_every_condition() -> None:
    runs = [task for task in measure.tasks() if task.kind == "right"]
    assert len(set(runs)) == len(runs) >= 200
    assert {task.condition for task in runs} == set(measure.CONDITIONS)
    assert min(Counter(task.condition for task in runs).values()) >= 20


def test_intervals() -> None:
    """Wilson's interval has the roots of (share - p)^2 = z^2 p (1 - p) / n; no alarm in n runs: (1 - rate)^n = 0.05."""
    low, high = summary.wilson(45, 50)
    for p in (low, high):
        assert (0.9 - p) ** 2 == pytest.approx(summary.Z**2 * p * (1 - p) / 50)
    assert low < 0.9 < high
    assert summary.most_alarms(0, 200) == pytest.approx(1 - math.exp(math.log(0.05) / 200))


def test_a_survivor_without_a_reason_and_a_false_alarm_are_published() -> None:
    row = {
        "condition": "plain",
        "changed": True,
        "claim": None,
        "case": None,
        "checked": 3,
        "seconds": 1.0,
        "error": None,
        "sources": "hash",
    }
    rows = [row | {"kind": "mutant", "name": "rk4: sign, line 1 column 2: a + b"},
            row | {"kind": "defect", "name": "link", "claim": "order", "case": "two_body"},
            row | {"kind": "right", "name": "x", "claim": "order", "case": "two_body"},
            row | {"kind": "right", "name": "scipy:LSODA [events]", "claim": "events", "case": "bouncing_ball"}]  # fmt: skip
    found = summary.published(rows, "normal", "low")
    assert found["survivors_without_reason"] == ["rk4: sign, line 1 column 2: a + b"]
    assert found["false_alarms"] == ["x: order on two_body (plain)"]
    assert list(found["true_alarms"]) == ["scipy:LSODA [events]: events on bouncing_ball"]
    assert (found["mutants"]["share"], found["defects"]["share"]) == (0.0, 1.0)

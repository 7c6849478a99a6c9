"""The panel of relations: promises of methods about units, axes, frames and reversal, and faults that break each."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import right_methods
from gnomon.harness.contract import validation
from gnomon.harness.contract.integrator import Integrator, Steps
from gnomon.harness.registry.lookup import find_one
from gnomon.harness.stability.relations import (
    TEXTS,
    choose_setting,
    compare_solutions,
    list_related,
    relations,
    reversal,
)
from gnomon.harness.stability.subjects import trials_of
from gnomon.harness.verification.function_adapter import from_step
from planted_steps import drops_small_increments, first_component_by_euler, increment

STEP = 1 / 8
"""The step as a part of the sampling interval, in this file: the faults are far larger than the error."""


def right(f: Any, t: float, y: Any, h: float) -> Any:
    return y + increment(f, t, y, h)


def longest_step_in_seconds(f: Any, t: float, y: Any, h: float) -> Any:
    return y + increment(f, t, y, min(h, 0.06)) * (h / min(h, 0.06))


def rounds_downward(f: Any, t: float, y: Any, h: float) -> Any:
    found = y + increment(f, t, y, h)
    return np.floor(found * 2.0**30) / 2.0**30


def knows_the_clock(f: Any, t: float, y: Any, h: float) -> Any:
    return right(f, t, y, h) * (1 + 1e-8 * (t > 40))


def single_precision(f: Any, t: float, y: Any, h: float) -> Any:
    return right(f, t, y, h).astype(np.float32).astype(np.float64)


def made(step: Callable[..., Any]) -> Integrator:
    return from_step(step, name=step.__name__, order=4, sweep=Steps(0.25, 10))


def found(integrator: Integrator, name: str) -> dict[str, Any]:
    trials = trials_of(integrator, "two_body")
    setting = float(trials.problem().interval * STEP) if trials.steps else choose_setting(trials)
    return compare_solutions(trials, trials.whole(setting), list_related(trials, setting)[name])


@pytest.mark.parametrize(
    ("step", "relation"),
    [
        (drops_small_increments, "length_binary"),
        (drops_small_increments, "megametres"),
        (longest_step_in_seconds, "time_binary"),
        (rounds_downward, "mirrored"),
        (rounds_downward, "mirrored_axis"),
        (first_component_by_euler, "swapped_axes"),
        (first_component_by_euler, "quarter_turn"),
        (first_component_by_euler, "permuted"),
        (first_component_by_euler, "turned"),
        (knows_the_clock, "clock"),
        (single_precision, "shifted"),
        (single_precision, "boosted"),
    ],
)
def test_each_planted_fault_breaks_a_relation_that_the_right_method_keeps(
    step: Callable[..., Any], relation: str
) -> None:
    kept, broken = found(made(right), relation), found(made(step), relation)
    assert broken["found"] == "factor"
    assert broken["difference"] > 20 * kept["difference"]
    if relation not in ("shifted", "boosted"):  # these have larger numbers, whose rounding every method shows
        assert kept["found"] in ("same bits", "round-off")


BITS = ("length_binary", "time_binary", "mirrored", "mirrored_axis")


@pytest.mark.parametrize("name", ["gnomon:RK4", "gnomon:Störmer-Verlet", "rebound:leapfrog", "rebound:IAS15"])
def test_methods_without_an_absolute_size_keep_every_bit_in_binary_units_and_mirrored(name: str) -> None:
    """Multiplication by a power of two, or by -1, commutes with each rounding."""
    data = relations.measured(find_one(name), 5.0)
    assert {relation: data["relations"][relation]["found"] for relation in BITS} == dict.fromkeys(BITS, "same bits")
    assert data["relations"]["megametres"]["found"] == "round-off"
    assert set(data["relations"]) == set(TEXTS)


def test_absolute_numbers_in_the_step_control_show_in_other_units_and_frames() -> None:
    """SciPy's absolute tolerance is of the size of the state in metres: not of that in megametres. In a frame that moves
    the sizes of the state, and with them the allowed errors, are larger."""
    integrator = find_one("scipy:RK45")
    rows = {name: found(integrator, name) for name in ("megametres", "boosted")}
    assert rows["megametres"]["factor"] > 100
    assert rows["boosted"]["factor"] > 10
    said = relations.sentences({"relations": rows})
    assert [text.partition(":")[0] for text in said] == [f"Not for {TEXTS[name]}" for name in rows]


def test_errors_at_round_off_grow_with_the_numbers_far_from_the_origin() -> None:
    """IAS15 has errors of 1e-14; coordinates near 2^20 are rounded to 1e-10, whose effect grows over the span."""
    data = relations.measured(find_one("rebound:IAS15"), 2.0)
    assert data["relations"]["shifted"]["factor"] > 1e4
    assert data["relations"]["shifted"]["error"] < 100 * data["relations"]["shifted"]["rounding"]


@pytest.mark.parametrize(
    ("name", "returns"),
    [("gnomon:Störmer-Verlet", True), ("rebound:leapfrog", True), ("gnomon:RK4", False), ("gnomon:DOP853", False)],
)
def test_symmetric_methods_return_and_others_do_not(name: str, returns: bool) -> None:
    trials = trials_of(find_one(name), "two_body")
    assert (reversal(trials, choose_setting(trials)) or {})["round_off"] is returns


def test_a_fault_of_verlet_shows_when_the_motion_is_reversed() -> None:
    def verlet(more: float) -> Integrator:
        def step(f: Any, t: float, y: Any, h: float) -> Any:
            q, v = np.split(right_methods.verlet(f, t, y, h), 2)
            return np.concatenate([q, v + more * h * f(t + h, q)])

        return from_step(step, name="verlet", order=2, sweep=Steps(0.25, 10), accelerations=True)

    for more, returns in ((0.0, True), (1e-9, False)):
        trials = trials_of(verlet(more), "two_body")
        back = reversal(trials, float(trials.problem().interval * STEP)) or {}
        assert back["round_off"] is returns


def test_a_charge_has_the_relations_that_its_case_declares_and_events_have_none() -> None:
    data = relations.measured(find_one("gnomon:Boris"), 2.0)
    assert data["case"] == "charge_in_E_and_B"
    assert {"length_binary", "mirrored", "clock"} <= set(data["relations"])
    assert "not_applicable" in relations.measured(find_one("gnomon:RK4 [events]"), 1.0)


def test_a_method_that_does_not_move_is_refused_and_is_not_called_independent_of_the_clock() -> None:
    data = relations.measured(made(lambda f, t, y, h: 1.0 * y), 0.1)
    assert data["refused"].endswith(validation.DID_NOT_MOVE)

"""An integrator that returns invalid solutions or attacks other processes affects only its own trials."""

import math
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import planted
import planted_hostile as hostile
import pytest
from gnomon.harness.contract.integrator import Steps, Tolerance
from gnomon.harness.registry import lookup, selection
from gnomon.harness.registry.declaration import validate
from gnomon.harness.results import store
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run
from turned_clock import Clock
from waiting import LONG_SECONDS

SUITE = plan.suite("quick").change(block_seconds=0.002, repeats=5).within(LONG_SECONDS)
FAULTS = {
    hostile.HalfACharacter: ("crashed", r"ArithmeticError: \? planted"),
    hostile.OddOptions: ("crashed", "options = 3"),
    hostile.RaisesUnsupported: ("crashed", r"its unsupported\(\) raises LookupError: planted"),
    hostile.OddUnsupported: ("crashed", r"its unsupported\(\) returns 7"),
    hostile.KillsParent: ("interrupted", "SIGKILL"),
    hostile.EndedFromOutside: ("interrupted", "the process died of SIGKILL"),
    hostile.DiskFull: ("interrupted", r"the disk is full \(/somewhere/cache\)"),
    hostile.Pickles: ("crashed", "sent something that is not a message"),
    hostile.LeavesChildrenAndAborts: ("crashed", "SIGABRT"),
}
SOUND = (hostile.Forks, hostile.LeavesChildren)


def trials(*kinds: Any, folder: Path) -> Any:
    chosen = selection.choose(["planted:Short"], True)
    return store.load(run(folder, SUITE, chosen, [kind() for kind in kinds]))


@pytest.fixture(autouse=True, scope="module")
def folder_of_planted() -> Iterator[None]:
    shutil.rmtree(hostile.FOLDER, ignore_errors=True)
    hostile.FOLDER.mkdir()
    yield
    shutil.rmtree(hostile.FOLDER)


@pytest.fixture(scope="module")
def frame(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """One run of all faults, with a correct integrator first and last."""
    return trials(planted.Sound, *FAULTS, *SOUND, planted.NearDuplicate, folder=tmp_path_factory.mktemp("hostile"))


def of(frame: Any, kind: Any) -> Any:
    return frame[frame["integrator"] == kind.name].sort_values("setting", ascending=False).reset_index()


@pytest.mark.parametrize("kind", FAULTS, ids=lambda kind: str(kind.name))
def test_each_fault_has_its_status_and_reason(frame: Any, kind: Any) -> None:
    status, reason = FAULTS[kind]
    rows = of(frame, kind)
    assert set(rows["status"]) == {status}
    assert rows["reason"].str.contains(reason).all()


@pytest.mark.parametrize("kind", [*SOUND, planted.NearDuplicate], ids=lambda kind: str(kind.name))
def test_others_lose_nothing(frame: Any, kind: Any) -> None:
    """Their errors equal the correct method's errors, bit for bit: no solution of a forked process was accepted."""
    rows, sound = of(frame, kind), of(frame, planted.Sound)
    assert list(rows["status"]) == ["ok"] * 8
    assert (rows["error_max"] == sound["error_max"]).all()


def test_nothing_is_left_behind(frame: Any, tmp_path: Path, clock: Clock) -> None:
    """Neither by a trial that ended ok, nor by one that crashed, nor by one that was killed at its limit."""
    rows = trials(hostile.LeavesChildrenAndHangs, folder=tmp_path)
    assert rows["status"].iloc[0] == "timeout"
    assert not [command for command in hostile.commands() if f"sleep {hostile.SLEEP_SECONDS}" in command]


def test_a_pickle_from_a_worker_is_never_opened(frame: Any) -> None:
    assert not of(frame, hostile.Pickles).empty
    assert not (hostile.FOLDER / "unpickled").exists()


def test_the_loss_of_the_server_costs_nobody_a_trial(tmp_path: Path) -> None:
    rows = trials(hostile.KillsServer, planted.Sound, planted.NearDuplicate, folder=tmp_path)
    assert (hostile.FOLDER / "killed").exists()
    assert set(rows["status"]) == {"ok"}
    assert rows.groupby("integrator").size().eq(8).all()


def test_what_is_interrupted_runs_again_twice_and_is_then_a_crash(tmp_path: Path) -> None:
    found = [set(trials(hostile.EndedFromOutside, folder=tmp_path)["status"]) for _ in range(4)]
    assert found == [{"interrupted"}, {"interrupted"}, {"crashed"}, {"crashed"}]
    everything = store.load(tmp_path, superseded=True)
    assert len(everything) == 3 * 8, "the fourth call repeats nothing"
    assert everything["reason"].iloc[-1] == "the process died of SIGKILL, as 2 times before"


WRONG = {
    "name": [None, "", " ", 7, "a\nb"],
    "library": [None, 3],
    "policy": [None],
    "order": [0, -1, 2.5, True, "4"],
    "accepts": [(), None, ("FirstOrder",), [int]],
    "sampling": [None],
    "sweep": [
        None, Tolerance(1e-3, 0.0), Tolerance(math.nan, 1e-9), Tolerance(1e-9, 1e-3), Tolerance(1e-3, 1e-3),
        Tolerance(1e-3, 1e-9, 0), Steps(0.0), Steps(-1.0), Steps(math.inf), Steps(math.nan), Steps(0.5, -1),
    ],
    "counts_rhs": [None, 1],
    "primary": ["no"],
    "conserves": ["symplectic", (1,)],
}  # fmt: skip


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in WRONG.items() for value in values])
def test_a_wrong_declaration_is_named_before_anything_runs(tmp_path: Path, name: str, value: Any) -> None:
    wrong = hostile.with_(**{name: value})
    with pytest.raises(ValueError, match=rf"planted_hostile:Changed: {name} = .*") as caught:
        run(tmp_path, SUITE, selection.choose(["planted:Short"], True), [planted.Sound(), wrong])
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "results.sqlite").exists()


def test_versions_that_raise_and_attributes_that_raise_are_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"planted_hostile:RaisesVersions: versions\(\) raises LookupError: planted"):
        lookup.find("planted_hostile:RaisesVersions")

    def fail(_self: Any) -> Any:
        raise LookupError("planted")

    with pytest.raises(ValueError, match="sweep raises LookupError: planted; it is a Tolerance"):
        validate(hostile.with_(sweep=property(fail)))


def test_every_integrator_of_our_own_has_a_sound_declaration() -> None:
    for integrator in lookup.own().values():
        validate(integrator)

"""Outstanding trials are never lost without a word: in merged files, in comparisons, at the end of a run."""

import itertools
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from answering import answering
from command_line import gnomon
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting.report_missing import missing
from gnomon.harness.results import merging, schema, store
from gnomon.harness.results.outstanding import outstanding
from gnomon.harness.results.store import Store

PLAN = ("run", "--case", "planted:Short", "--suite", "quick")
METHODS = ("planted:Sound", "planted:NearDuplicate", "planted:Busy")
SETTINGS = 8
TRIALS = SETTINGS * len(METHODS)


def run(out: Path, *more: str, methods: tuple[str, ...] = METHODS) -> int:
    return gnomon(*PLAN, *(word for name in methods for word in ("--integrator", name)), "--out", str(out), *more)


def ends(*last: int, status: Status = Status.INTERRUPTED) -> Callable[[Any, float], Any]:
    """The settings at these places of each sweep end so, as if by SIGKILL from outside."""
    return lambda sweep, setting: (
        (status, "the process died of SIGKILL") if setting in [sweep.trials[k].setting for k in last] else None
    )


@pytest.fixture
def shards(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    answering(monkeypatch)
    parts = [tmp_path / f"part_{k}.sqlite" for k in (1, 2, 3)]
    assert [run(part, "--shard", f"{k}/3") for k, part in enumerate(parts, 1)] == [0, 0, 0]
    return parts


def test_a_shard_that_is_missing_is_named_by_merge_report_and_compare(
    shards: list[Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    whole, two = str(tmp_path / "whole.sqlite"), str(tmp_path / "two.sqlite")
    assert gnomon("merge", *map(str, shards), "--out", whole) == 0
    assert gnomon("compare", whole, whole) == 0
    assert missing(outstanding(whole)) is None
    capfd.readouterr()
    assert gnomon("merge", *map(str, shards[:2]), "--out", two) == 1
    assert "shard 3/3 is missing" in capfd.readouterr().err
    found = missing(outstanding(two))
    assert found is not None
    assert found["text"] == "shard 3/3 is missing"
    assert gnomon("compare", two, two) == 1
    assert "shard 3/3 is missing" in capfd.readouterr().out
    assert gnomon("compare", two, two, "--allow-missing") == 0
    again = str(tmp_path / "again.sqlite")
    assert gnomon("merge", *map(str, shards[:2]), "--out", again, "--allow-missing") == 0
    assert gnomon("merge", two, str(shards[2]), "--out", str(tmp_path / "late.sqlite")) == 0, "merged files merge"
    assert gnomon("merge", str(shards[0]), "--out", str(tmp_path / "one.sqlite")) == 1
    assert "shards 2/3, 3/3 are missing" in capfd.readouterr().err


def test_shards_of_different_plans_do_not_make_a_whole_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Another time limit, another method: the jobs divided different plans, and both lack a part."""
    answering(monkeypatch)
    first, second = tmp_path / "first.sqlite", tmp_path / "second.sqlite"
    run(first, "--shard", "1/2")
    run(second, "--shard", "2/2", methods=METHODS[:2])
    assert gnomon("merge", str(first), str(second), "--out", str(tmp_path / "both"), "--count") == 1
    told = capfd.readouterr().err
    assert "shard 2/2 of the plan" in told
    assert "shard 1/2 of the plan" in told


def test_only_a_run_of_the_whole_plan_makes_up_for_a_shard(shards: list[Path]) -> None:
    """A later run of something else into the same file does not."""
    part = shards[0]
    assert run(part, methods=("planted:Busier",)) == 0
    assert outstanding(part).shards == ["shards 2/3, 3/3 are missing"]
    assert run(part) == 0
    assert outstanding(part).shards == []


def test_a_merged_file_has_what_was_planned_and_what_was_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """A part of one shard was interrupted, another shard was killed: the merged file says so, and a run into it measures
    just that."""
    answering(monkeypatch, ends(3, 4))
    first, second, merged = (tmp_path / f"{name}.sqlite" for name in ("first", "second", "merged"))
    assert run(first, methods=METHODS[:1]) == 1
    count = itertools.count()

    def killed(*_: Any) -> None:
        if next(count) == 3:
            raise KeyboardInterrupt

    answering(monkeypatch, killed)
    assert run(second, methods=METHODS[1:]) == 130
    assert gnomon("merge", str(first), str(second), "--out", str(merged)) == 1
    told = capfd.readouterr()
    measured = SETTINGS - 2 + 3
    assert f"{measured} measurements of 2 files" in told.out
    assert f"{TRIALS - measured} of {TRIALS} planned trials have no measurement" in told.err
    assert (store.load(merged)["status"] == Status.INTERRUPTED).sum() == 2, "so that a third interruption is a crash"
    assert gnomon("compare", str(merged), str(merged)) == 1
    rest = answering(monkeypatch)
    assert run(merged) == 0
    assert len(rest.asked) == TRIALS - measured
    assert outstanding(merged).text == ""
    assert gnomon("compare", str(merged), str(merged)) == 0


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
@pytest.mark.parametrize("count", [False, True])
def test_what_one_file_lost_and_another_measured_is_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, order: tuple[int, int], count: bool
) -> None:
    """In any sequence of the files: an interrupted trial replaces no measurement."""
    files = [tmp_path / "lost.sqlite", tmp_path / "found.sqlite"]
    answering(monkeypatch, ends(*range(SETTINGS)))
    run(files[0], methods=METHODS[:1])
    answering(monkeypatch)
    run(files[1], methods=METHODS[:1])
    target = tmp_path / "both.sqlite"
    assert merging.merge([files[k] for k in order], target, count) == SETTINGS
    assert list(store.load(target)["status"]) == ["ok"] * SETTINGS
    assert outstanding(target).text == ""


def test_a_planned_trial_with_the_key_of_another_one_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would be believed to be the trial that another file measured."""
    files = [tmp_path / "planned.sqlite", tmp_path / "measured.sqlite"]
    answering(monkeypatch, ends(*range(SETTINGS)))
    run(files[0], methods=METHODS[:1])
    with sqlite3.connect(files[0]) as db:
        db.execute("UPDATE trials SET series = 'another'")
        db.execute("UPDATE planned SET series = 'another'")
        for table in ("trials", "planned"):
            schema.seal_all(schema.with_checksums(db), table)
    answering(monkeypatch)
    run(files[1], methods=METHODS[:1])
    for order in (files, files[::-1]):
        with pytest.raises(ValueError, match="has the key of another trial"):
            merging.merge(order, tmp_path / "both.sqlite")


def test_a_run_fails_while_its_trials_are_outstanding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "results.sqlite"
    answering(monkeypatch, ends(-1))
    assert run(out) == 1
    assert f"{len(METHODS)} trials were interrupted" in capfd.readouterr().err
    assert run(out, "--allow-missing") == 0
    answering(monkeypatch)
    assert run(out) == 0


def test_a_comparison_with_outstanding_trials_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whether trials of the base or of the run are outstanding: the comparison lacks planned trials."""
    whole, part = tmp_path / "whole.sqlite", tmp_path / "part.sqlite"
    answering(monkeypatch)
    run(whole)
    answering(monkeypatch, ends(-1))
    run(part)
    for files in ((whole, part), (part, whole)):
        assert gnomon("compare", *map(str, files)) == 1
        assert gnomon("compare", *map(str, files), "--allow-missing") == 0


def test_what_neither_machine_can_run_is_no_difference(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    answering(monkeypatch)
    out = tmp_path / "results.sqlite"
    run(out, methods=("planted:Sound", "gnomon:RKMK 4"))
    assert gnomon("compare", str(out), str(out)) == 0
    told = capfd.readouterr().out
    assert f"2 series compared at {SETTINGS + 1} settings, 0 regressions" in told
    assert "not compared" not in told


@pytest.mark.parametrize("last", [False, True])
def test_a_disk_that_becomes_full_during_a_merge_is_one_line(
    shards: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], last: bool
) -> None:
    """While rows are copied, or at the last checksums. The files that are read are sound, and no part of a file stays."""
    made, sealed = schema.create, schema.seal_all

    def full(db: sqlite3.Connection) -> None:
        ((pages,),) = db.execute("PRAGMA page_count")
        db.execute(f"PRAGMA max_page_count = {pages}")

    def create(db: sqlite3.Connection) -> None:
        made(db)
        if not last:
            full(db)

    def seal_all(db: sqlite3.Connection, table: str) -> None:
        full(db)
        db.execute("UPDATE runs SET command = zeroblob(1000000)")
        sealed(db, table)

    monkeypatch.setattr(schema, "create", create)
    if last:
        monkeypatch.setattr(schema, "seal_all", seal_all)
    folder = tmp_path / "there"
    assert gnomon("merge", *map(str, shards), "--out", str(folder / "merged.sqlite")) == 2
    (line,) = capfd.readouterr().err.strip().splitlines()
    assert line.startswith(f"error: --out {folder / 'merged.sqlite'}: cannot be written (database or disk is full)")
    assert list(folder.iterdir()) == []


def test_a_file_of_another_author_names_few_shards(shards: list[Path]) -> None:
    """However many it states, in time that does not grow with their number."""
    text = ", ".join(f"1/9999999 of {k:08x}" for k in range(5000))
    with sqlite3.connect(shards[0]) as db:
        db.execute("UPDATE environment SET value = ? WHERE name = 'shard'", (text,))
        schema.seal_all(schema.with_checksums(db), "environment")
    found = outstanding(shards[0])
    assert len(found.text) < 1000
    assert "shards of 4997 other plans are missing" in found.shards


@pytest.mark.slow
def test_the_page_says_what_is_missing(shards: list[Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "two.sqlite"
    gnomon("merge", *map(str, shards[:2]), "--out", str(target))
    assert gnomon("report", str(target), "--out", str(tmp_path / "page"), "--case", "planted:Short") == 0
    assert "shard 3/3 is missing" in capfd.readouterr().err
    for name in ("index.html", "summary.md"):
        assert "shard 3/3 is missing" in (tmp_path / "page" / name).read_text()


def test_a_launch_that_was_interrupted_is_outstanding_once_the_first_one_is_scored(tmp_path: Path) -> None:
    """Later launches repeat the settings that the first launch scored, and nothing else."""
    trial = {
        "series": "s", "case": "c", "variant": "default", "formulation": "standard", "library": "l", "integrator": "i",
        "policy": "", "integrator_id": "l:i", "setting_kind": "step", "machine": "m",
    }  # fmt: skip
    with Store(tmp_path / "results.sqlite") as db:
        number = db.begin_run("quick", "", {})
        db.plan(number, [trial | {"trial_key": key, "setting": k + 1.0} for k, key in enumerate("abc")])
        for key, launch, status in (
            ("a", 1, Status.OK), ("a", 2, Status.INTERRUPTED), ("b", 1, Status.CRASHED), ("b", 2, Status.INTERRUPTED),
            ("c", 1, Status.OK), ("c", 2, Status.INTERRUPTED), ("c", 2, Status.OK),
        ):  # fmt: skip
            db.add(number, {"trial_key": key, "launch": launch, "status": status})
        assert outstanding(tmp_path).text == "1 repeated launches were interrupted"
        db.end_run(number)
    assert outstanding(tmp_path).text == "1 repeated launches were interrupted"

"""Rows that cannot be compared do not pass; baselines and files of known failures are data, read to their end."""

import math
import os
import shutil
import sys
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest
import synthetic
from changes import changing
from command_line import gnomon
from gnomon.harness.contract.status import Status
from gnomon.harness.results import regression, schema, store
from gnomon.harness.results.regression import Verdict
from gnomon.harness.system.files import MOST_BYTES
from gnomon.harness.verification.baseline import Baseline, Entry, as_text, case_names, compare_with_baseline, read
from gnomon.harness.verification.verification_report import read_known

pytestmark = pytest.mark.usefixtures("no_hang")

NUMBERS = [field.name for field in fields(Entry) if field.type == "float"]


def entry(setting: float, case: str = "pendulum_simple") -> Entry:
    """A setting of a method of order 4."""
    error, steps = 0.1 * setting**4, round(10 / setting)
    known = (0.9 * error, error, 4 * steps, 4 * steps, steps, steps)
    return Entry(case, "default", "0" * 12, "step", setting, Status.OK, 5e-17, 3e-15, *map(float, known))


BASE = Baseline("mine:RK4", "low", "0", tuple(entry(0.5 / 2**k) for k in range(6)))
WORSE = replace(
    BASE, entries=tuple(replace(e, error_low=1e5 * e.error_low, error_high=1e5 * e.error_high) for e in BASE.entries)
)


def written(folder: Path, **columns: Any) -> Path:
    """A baseline file with other values in the columns of all its entries."""
    path = folder / "theirs.txt"
    path.write_text(as_text(replace(BASE, entries=tuple(replace(each, **columns) for each in BASE.entries))))
    return path


def test_a_sound_baseline_is_read(tmp_path: Path) -> None:
    """The others differ from it by the value that is named."""
    assert read(written(tmp_path)) == BASE
    assert not compare_with_baseline(BASE, BASE).failed
    assert compare_with_baseline(BASE, WORSE).failed


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, -1.0])
@pytest.mark.parametrize("column", NUMBERS)
def test_a_bound_that_is_not_finite_is_refused_with_its_line(tmp_path: Path, column: str, value: float) -> None:
    path = written(tmp_path, **{column: value})
    with pytest.raises(ValueError, match=rf"{path}:6: ") as caught:
        read(path)
    assert "\n" not in str(caught.value)


def test_a_range_in_the_wrong_order_is_refused(tmp_path: Path) -> None:
    """It has no inside, so that no number is outside of it."""
    with pytest.raises(ValueError, match=":6: "):
        read(written(tmp_path, rhs_low=5.0, rhs_high=4.0))


@pytest.mark.parametrize("counts", [("rhs_low", "rhs_high"), ("steps_low", "steps_high")])
@pytest.mark.parametrize("side", [0, 1])
def test_counts_that_one_of_the_two_lacks_are_not_compared(counts: tuple[str, ...], side: int) -> None:
    """Twice the work would be hidden so."""
    lost = replace(BASE, entries=tuple(replace(e, **dict.fromkeys(counts, math.nan)) for e in BASE.entries))
    pair = (lost, BASE) if side == 0 else (BASE, lost)
    if "rhs_low" in counts:
        with pytest.raises(ValueError, match="6 because right-hand sides are counted in one of the two alone"):
            compare_with_baseline(*pair)
    else:
        verdict = compare_with_baseline(*pair)
        assert verdict.failed
        assert verdict.not_compared == {"steps are counted in one of the two alone": 6}
    assert not compare_with_baseline(lost, lost).failed


def test_the_bounds_of_the_base_hide_no_error() -> None:
    """A floor of 1e300 is finite; the run has its own."""
    for bound in ("floor", "conditioning"):
        wide = replace(BASE, entries=tuple(replace(each, **{bound: 1e300}) for each in BASE.entries))
        assert any("errors are 1e+05 times" in line for line in compare_with_baseline(wide, WORSE).regressions)


def test_an_error_that_was_zero_and_is_not_any_more_is_named() -> None:
    """The relative change is infinite."""
    exact = replace(BASE, entries=tuple(replace(each, error_low=0.0, error_high=0.0) for each in BASE.entries))
    assert any("changed" in line for line in compare_with_baseline(exact, BASE).regressions)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return synthetic.write(tmp_path_factory.mktemp("invented") / "results.sqlite")


def compare(base: Any, run: Any, allow_missing: bool = False) -> Verdict:
    return regression.compare(base.to_dict("records"), run.to_dict("records"), allow_missing)


LACKING = ("floor", "conditioning", "error_max", "rhs_calls", "numbers", "span")


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("column", LACKING)
def test_a_null_in_either_file_hides_no_worse_error(results: Path, column: str, side: int) -> None:
    """One setting lacks a number, and is 1e5 times worse; its comparison fails even if rows may be missing."""
    frame = store.load(results)
    place = frame.index[(frame["status"] == "ok") & (frame["launch"] == 1) & (frame["error_max"] > 1e-12)][0]
    worse = frame.copy()
    worse.loc[place, "error_max"] *= 1e5
    assert not compare(frame, frame).failed
    assert compare(frame, worse).failed
    pair = [frame.copy(), worse]
    pair[side].loc[place, column] = None
    verdict = compare(*pair, allow_missing=True)
    assert verdict.failed
    assert verdict.not_compared.total() == 1


def test_numbers_that_both_lack_pass(results: Path) -> None:
    frame = store.load(results)
    assert not compare(*[frame.assign(rhs_calls=None)] * 2).failed
    ok = frame["status"] == "ok"
    stopped = frame.assign(
        status=frame["status"].where(~ok | (frame["setting"] > frame["setting"].median()), "timeout")
    )
    assert not compare(stopped, stopped).failed


def test_a_setting_without_a_result_fails_unless_it_is_allowed(results: Path) -> None:
    frame = store.load(results)
    place = frame.index[(frame["status"] == "ok") & (frame["launch"] == 1)][0]
    fewer = frame.drop(place)
    interrupted = frame.assign(status=frame["status"].where(frame.index != place, "interrupted"))
    for run in (fewer, interrupted):
        assert compare(frame, run).failed
        assert compare(frame, run).not_compared.total() == 1
        assert not compare(frame, run, allow_missing=True).failed


def test_compare_exits_with_1_where_a_bound_is_null_and_with_2_where_it_is_infinite(
    results: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    theirs = shutil.copy(results, tmp_path / "theirs.sqlite")
    for bound, code, said in (("NULL", 1, "settings of the base not compared"), ("9e999", 2, "inf is not allowed")):
        with changing(theirs) as db:
            schema.with_checksums(db)
            db.execute(f"UPDATE trials SET floor = {bound} WHERE variant = 'default'")
            schema.seal_all(db, "trials")
        assert gnomon("compare", str(theirs), str(results), "--allow-missing") == code
        assert said in "".join(capfd.readouterr())


EVIL = "import pathlib; pathlib.Path('owned').touch()\nfrom gnomon.cases.pendulums.pendulum_simple import PendulumSimple as Case"


@pytest.mark.parametrize("named", ["evilmod:Case", "evilmod:Case/x", "evilmod:*", "gnomon.cases.nothing:Case"])
def test_a_baseline_imports_nothing(
    named: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """The module that its column `case` names lies in the working directory, as in a repository that one has cloned."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    (tmp_path / "evilmod.py").write_text(EVIL)
    path = written(tmp_path, case=named)
    assert gnomon("verify", "gnomon:RK4", "--case", "pendulum_simple", "--baseline", str(path)) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert "a file cannot name code" in line
    assert "evilmod" not in sys.modules
    assert not (tmp_path / "owned").exists()


def test_a_case_that_is_not_installed_comes_from_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    (tmp_path / "my_own_case.py").write_text(
        "from gnomon.cases.pendulums.pendulum_simple import PendulumSimple\n\n\n"
        'class Mine(PendulumSimple):\n    name = "mine"\n'
    )
    base = read(written(tmp_path, case="mine"))
    with pytest.raises(ValueError, match="'mine', which is not installed"):
        case_names(base, ["pendulum_simple"])
    assert case_names(base, ["my_own_case:Mine/separatrix"]) == ["my_own_case:Mine"]
    assert case_names(BASE) == ["pendulum_simple"]


@pytest.mark.parametrize("reads", [read, read_known])
@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "large", "bytes", "absent"])
def test_what_is_no_text_file_of_a_limited_size_is_refused(
    kind: str, reads: Callable[[Path], object], tmp_path: Path
) -> None:
    """A pipe is never read to its end, nor is /dev/zero, which would fill the memory before. The large one is sound."""
    path = Path("/dev/zero") if kind == "device" else tmp_path / "theirs.txt"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "large":
        repeated = "# a comment\n" if reads is read_known else f"{as_text(BASE).splitlines()[-1]}\n"
        path.write_text(("" if reads is read_known else as_text(BASE)) + repeated * (1 + MOST_BYTES // len(repeated)))
    elif kind == "bytes":
        path.write_bytes(b"\xff\xfe")
    with pytest.raises(ValueError, match=str(path)) as caught:
        reads(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("option", ["--baseline", "--known-failures"])
def test_the_command_refuses_a_pipe(option: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "theirs")
    assert gnomon("verify", "gnomon:RK4", option, str(tmp_path / "theirs")) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert "a pipe" in line


def test_a_line_of_no_bound_gives_a_short_message(tmp_path: Path) -> None:
    """It is compared with the names of claims, and shown."""
    path = tmp_path / "theirs.txt"
    path.write_text("x" * (1 << 20) + " pendulum_simple reason\n")
    with pytest.raises(ValueError, match="no claim is called") as caught:
        read_known(path)
    assert len(str(caught.value)) < 1000
    path.write_text(as_text(BASE).replace(" 0.5 ", f" {'y' * (1 << 20)} "))
    with pytest.raises(ValueError, match=":6: ") as caught:
        read(path)
    assert len(str(caught.value)) < 1000

"""A run keeps all correct results, however single integrators fail, and records how they failed."""

import os
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import planted
import pytest
from gnomon.harness.registry import selection
from gnomon.harness.results import regression, store
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run
from gnomon.harness.running.pool import GRACE_SECONDS
from gnomon.harness.system.progress import Progress
from turned_clock import Clock, turned_clock
from waiting import LIMIT_SECONDS, LONG_SECONDS, wait_until, with_variable

SUITE = plan.suite("quick").change(block_seconds=0.002, repeats=5).within(LONG_SECONDS)
WITHIN_1 = SUITE.within(1.0)
"""For the turned clock, by which nothing takes time but what an integrator says."""
CASE = "planted:Short"
BAD = (
    planted.Aborts, planted.Exits, planted.NotANumber, planted.TooFew,
    planted.NoSolution, planted.Raises, planted.Declines, planted.DoesNothing, planted.TakesMemory,
    planted.MissingLibrary, planted.IntegratesInPrepare, planted.Memoises, planted.ChangesInput, planted.SharesOutput,
)  # fmt: skip


@pytest.fixture(scope="module")
def frame(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """One run of a sound integrator and of every planted one that ends."""
    return ran(tmp_path_factory.mktemp("planted"), planted.Sound, *BAD)


@pytest.fixture(scope="module")
def hanging(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """One run of integrators that hang, with a sound one first and last."""
    kinds = (planted.Sound, planted.Hangs, planted.HangsInPrepare, planted.NearDuplicate)
    with turned_clock():
        return ran(tmp_path_factory.mktemp("hanging"), *kinds, suite=WITHIN_1)


def ran(folder: Path, *kinds: type[planted.Sound], suite: plan.Suite = SUITE) -> Any:
    """The results of a run; a turned clock supervises one worker."""
    workers = 2 if suite is SUITE else 1
    return store.load(run(folder, suite, selection.choose([CASE], True), [kind() for kind in kinds], workers=workers))


def of(frame: Any, kind: type[planted.Sound]) -> Any:
    return frame[frame["integrator"] == kind.name].sort_values("setting", ascending=False).reset_index()


@pytest.mark.parametrize(
    ("kind", "status", "reason"),
    [
        (planted.Aborts, "crashed", "SIGABRT"),
        (planted.Exits, "crashed", "exit code 0"),
        (planted.NotANumber, "diverged", "not finite"),
        (planted.TooFew, "crashed", r"shape \(1, 63, 2\)"),
        (planted.NoSolution, "crashed", "NoneType"),
        (planted.Raises, "crashed", "ArithmeticError: planted"),
        (planted.Declines, "refused", "too beautiful"),
        (planted.DoesNothing, "refused", "initial state"),
        (planted.TakesMemory, "out_of_memory", r"needed more than [\d.]+ GiB"),
    ],
)
def test_each_fault_has_its_status_at_every_setting(frame: Any, kind: Any, status: str, reason: str) -> None:
    rows = of(frame, kind)
    assert len(rows) == 8
    assert set(rows["status"]) == {status}
    assert rows["reason"].str.contains(reason).all()


def test_hangs_are_timeouts_and_three_in_a_row_end_their_series(hanging: Any) -> None:
    rows = of(hanging, planted.Hangs)
    assert list(rows["status"]) == ["ok"] * 3 + ["timeout"] * 3 + ["skipped"] * 2
    assert set(rows["reason"][3:6]) == {"no answer within 1 s"}
    assert rows["reason"][6:].str.contains("the 3 settings before it ended as timeout").all()


def test_a_hang_while_preparing_is_a_timeout(hanging: Any) -> None:
    rows = of(hanging, planted.HangsInPrepare)
    assert list(rows["status"]) == ["timeout"] * 3 + ["skipped"] * 5
    assert "not prepared" in rows["reason"][0]


def test_hangs_cost_no_other_trial(hanging: Any, frame: Any) -> None:
    """By the clock of the workers nothing else takes time: no trial is left out."""
    for kind in (planted.Sound, planted.NearDuplicate):
        rows = of(hanging, kind)
        assert list(rows["status"]) == ["ok"] * 8
        assert (rows["error_max"] == of(frame, planted.Sound)["error_max"]).all()


def test_compiling_during_a_call_does_not_count_towards_the_limit(tmp_path: Path, clock: Clock) -> None:
    """Code that a method compiles only during a call would otherwise lose all settings after it."""
    rows = of(ran(tmp_path, planted.Compiles, suite=WITHIN_1), planted.Compiles)
    assert clock.now > WITHIN_1.limits.limit_seconds + GRACE_SECONDS
    assert set(rows["status"]) == {"ok"}
    np.testing.assert_array_equal(rows["rhs_calls"], 4 * rows["steps"])


def test_a_compilation_before_a_hang_neither_shortens_nor_extends_the_limit(tmp_path: Path, clock: Clock) -> None:
    rows = of(ran(tmp_path, planted.CompilesAndHangs, suite=WITHIN_1), planted.CompilesAndHangs)
    assert list(rows["status"]) == ["ok"] * 3 + ["timeout"] * 3 + ["skipped"] * 2
    assert rows["reason"][3] == "no answer within 1 s"
    assert clock.now == pytest.approx(3 * (1 + GRACE_SECONDS), abs=1e-3)


def test_a_hang_is_a_regression(tmp_path: Path, clock: Clock) -> None:
    """Even if every setting that both runs solved is as good as in the base. Under a limit below RETRY_SECONDS: a timeout
    is a regression once it was tried three times, which also keeps a stall of the machine from being one. A setting whose
    time in the base comes near the limit is not compared: by the workers' clock none does."""
    short, kinds = SUITE.within(0.4), (planted.HalfAMillisecond, planted.HalfAMillisecondAndHangs)
    sound, hangs = (ran(tmp_path / kind.name, kind, suite=short) for kind in kinds)
    hangs = hangs.assign(integrator_id=sound["integrator_id"].iloc[0])
    verdict = regression.compare(sound.to_dict("records"), hangs.to_dict("records"))
    assert verdict.settings == len(sound) == 8
    assert any("ok became timeout no answer within 0.4 s" in line for line in verdict.regressions)
    assert any("ok became skipped" in line for line in verdict.regressions)
    assert regression.compare(*[sound.to_dict("records")] * 2).regressions == []


def test_a_library_found_missing_in_a_trial_is_not_installed(frame: Any) -> None:
    rows = of(frame, planted.MissingLibrary)
    assert rows["status"][0] == "not_installed"
    assert "a_library_that_is_not_installed" in rows["reason"][0]
    assert set(rows["status"][1:]) == {"skipped"}


def test_printed_output_is_recorded(frame: Any) -> None:
    assert of(frame, planted.Raises)["output"].str.contains("what it printed last").all()


def test_the_sound_integrator_is_not_affected_by_the_others(frame: Any) -> None:
    rows = of(frame, planted.Sound)
    assert list(rows["status"]) == ["ok"] * 8
    np.testing.assert_array_equal(rows["rhs_calls"], 4 * rows["steps"])
    slopes = np.diff(np.log2(rows["error_max"])) / np.diff(np.log2(rows["setting"]))
    assert np.all(np.abs(slopes[3:5] - 4) < 0.3), "the order of the method, before round-off"


@pytest.mark.parametrize("kind", [planted.ChangesInput, planted.SharesOutput])
def test_writing_over_arrays_changes_nothing(frame: Any, kind: Any) -> None:
    rows, sound = of(frame, kind), of(frame, planted.Sound)
    assert list(rows["status"]) == ["ok"] * 8
    assert (rows["error_max"] == sound["error_max"]).all()


def test_integrating_while_preparing_gains_nothing(frame: Any) -> None:
    """From the second setting on it returns one solution for all starts, which is refused."""
    rows, sound = of(frame, planted.IntegratesInPrepare), of(frame, planted.Sound)
    assert set(rows["status"]) == {"refused"}
    assert rows["reason"].str.contains("different initial states").all()
    assert sound["status"][0] == "ok"


def test_memoising_gains_nothing(frame: Any) -> None:
    """All timed calls but the scored one start from new states, which it has to integrate; the scored one repeats the
    error of the coarsest setting."""
    rows, sound = of(frame, planted.Memoises), of(frame, planted.Sound)
    assert set(rows["status"]) == {"ok"}
    assert (rows["error_max"] == sound["error_max"][0]).all()
    assert (rows["steps"][1:] == sound["steps"][0]).all(), "the solution that it kept"
    kept, integrated = (rows["output"].str.count(word) for word in ("kept", "integrated"))
    assert list(kept) == [0] + [1] * 7
    assert (rows["repeats"] > 1).all()
    assert (integrated >= rows["repeats"] - kept).all()


def test_other_trials_are_kept(frame: Any) -> None:
    assert len(frame) == 8 * (1 + len(BAD))
    assert frame.groupby("trial_key").size().eq(1).all()


class Wants(planted.Sound):
    """Takes a form that no case offers."""

    name = "wants"
    accepts = (int,)


def test_pairs_that_are_left_out_have_a_reason(tmp_path: Path) -> None:
    rows = store.load(run(tmp_path, SUITE, selection.choose([CASE], False), [Wants()]))
    assert list(rows["status"]) == ["unsupported"]
    assert rows["reason"][0] == "takes int; the case offers Separable, FirstOrder, Scene"
    assert rows["setting"].isna().all()


def measurements(path: Path) -> list[tuple[str, int]]:
    with sqlite3.connect(path) as db:
        return list(db.execute("SELECT trial_key, launch FROM measurements ORDER BY measurement"))


def test_a_script_needs_no_main_guard(tmp_path: Path) -> None:
    """Its exact motion is not on disk yet, so both kinds of child processes are started."""
    script = tmp_path / "script.py"
    script.write_text(
        "from gnomon import cases\n"
        "import gnomon\n"
        f"case = cases.get('harmonic_oscillator', span='{tmp_path.stat().st_mtime_ns % 1000 + 5000}/1000')\n"
        "print(*(row['status'] for row in gnomon.compare(case, 'gnomon:RK4', limit_seconds=900.0).rows))\n"
    )
    ran = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=LIMIT_SECONDS, check=False)
    assert (ran.stdout.split(), ran.returncode) == (["ok"] * 11, 0), ran.stderr


def test_the_second_run_repeats_nothing(tmp_path: Path) -> None:
    chosen = selection.choose([CASE], False)
    path = run(tmp_path, SUITE, chosen, [planted.Sound()])
    before = measurements(path)
    assert measurements(run(tmp_path, SUITE, chosen, [planted.Sound()])) == before
    assert len(store.load(path)) == len(before)


def test_every_launch_of_a_series_repeats_the_first_one(tmp_path: Path) -> None:
    """Also with more workers than series: a launch that began beside the first one found nothing to repeat."""
    suite = SUITE.change(launches=3)
    path = run(tmp_path, suite, selection.choose([CASE], False), [planted.Sound()], workers=2)
    launches = {launch: [key for key, each in measurements(path) if each == launch] for launch in (1, 2, 3)}
    assert launches[1] == launches[2] == launches[3]
    assert len(launches[1]) == 8


@pytest.mark.parametrize(("slow_seconds", "repeats"), [(0.0, 1), (0.0004, 1), (0.0006, 4), (10.0, 4)])
def test_a_slow_trial_is_timed_once(tmp_path: Path, slow_seconds: float, repeats: int) -> None:
    """Each call takes half a millisecond: four calls fit into a block of two milliseconds."""
    suite = SUITE.change(slow_seconds=slow_seconds)
    frame = store.load(run(tmp_path, suite, selection.choose([CASE], False), [planted.HalfAMillisecond()]))
    assert set(frame["status"]) == {"ok"}
    assert set(frame["repeats"]) == {repeats}
    assert frame["seconds_median"].tolist() == pytest.approx([0.0005] * len(frame))


def test_near_duplicates_run_on_default_variants(tmp_path: Path) -> None:
    """On hard variants they run only if they are named: `test_plan` has that."""
    both = [planted.Sound(), planted.NearDuplicate()]
    path = run(tmp_path, SUITE, selection.choose([CASE], False), both, near_duplicates=False)
    assert set(store.load(path)["integrator"]) == {one.name for one in both}


SCRIPT = """
import sys
sys.path.insert(0, {folder!r})
import planted
from gnomon.harness.registry import selection
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run
if __name__ == "__main__":
    suite = plan.suite("quick").change(block_seconds=0.002, repeats=5).within(float(sys.argv[1]))
    kinds = [planted.Sound, planted.Raises, planted.Declines, planted.Hangs]
    run({out!r}, suite, selection.choose(["planted:Short"], False), [kind() for kind in kinds])
"""


def _hear_interrupts() -> None:
    """Restore the default: tests that a shell started in the background inherit an ignored SIGINT and pass it on."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.parametrize("how", [signal.SIGKILL, pytest.param(signal.SIGINT, marks=pytest.mark.slow)])
def test_a_run_that_is_killed_leaves_no_worker_and_continues_where_it_stopped(tmp_path: Path, how: int) -> None:
    """In `make test` by the signal that no process can answer; test_pool shows there that an interruption ends all workers.
    The first run cannot end by itself, as one of its integrators hangs; the second run ends it by a short limit."""
    script = tmp_path / "job.py"
    script.write_text(SCRIPT.format(folder=str(Path(planted.__file__).parent), out=str(tmp_path)))
    marker = {"GNOMON_TEST_RUN": str(tmp_path)}
    process = subprocess.Popen(
        [sys.executable, str(script), str(LONG_SECONDS)],
        env=os.environ | marker,
        stderr=subprocess.DEVNULL,
        preexec_fn=_hear_interrupts,
    )
    path = tmp_path / "results.sqlite"
    wait_until(lambda: process.poll() is not None or _count(path) >= 4, "the run has measured something")
    assert process.poll() is None, "the run ended before it could be killed"
    assert len(with_variable("GNOMON_TEST_RUN", tmp_path)) > 1, "the marker finds the workers"
    process.send_signal(how)
    assert process.wait(LIMIT_SECONDS) != 0
    wait_until(lambda: not with_variable("GNOMON_TEST_RUN", tmp_path), "all processes of the run have ended")
    with sqlite3.connect(path) as db:
        assert db.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    before = measurements(path)
    assert len(before) < 32
    command = [sys.executable, str(script), "0.05"]
    subprocess.run(command, env=os.environ | marker, check=True, capture_output=True, timeout=LIMIT_SECONDS)
    after = measurements(path)
    assert after[: len(before)] == before
    assert len(set(after)) == len(after) == 32, "every trial of four sweeps once"


def _count(path: Path) -> int:
    try:
        return len(measurements(path)) if path.exists() else 0
    except sqlite3.OperationalError:
        return 0  # the tables are not there yet


def test_a_run_takes_the_interlude_of_its_progress(tmp_path: Path) -> None:
    class Always:
        taken = 0

        def due(self) -> bool:
            return True

        def take(self) -> None:
            self.taken += 1

    interlude = Always()
    chosen = selection.choose([CASE], True)
    frame = store.load(run(tmp_path, SUITE, chosen, [planted.Sound()], Progress(quiet=True, interlude=interlude)))
    assert set(frame["status"]) == {"ok"}
    assert interlude.taken >= len(frame)

"""`run --repeat` measures named trials again, all or none; the key of a trial holds the versions below its code."""

import itertools
import platform
from collections.abc import Callable
from pathlib import Path
from typing import Any

import planted
import pytest
from answering import answering
from command_line import gnomon
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.status import Status
from gnomon.harness.registry import environment, lookup, selection
from gnomon.harness.results import store
from gnomon.harness.results.outstanding import outstanding
from gnomon.harness.running import plan
from gnomon.harness.running.plan import Repeat
from gnomon.harness.running.planned_run import run as run_

COMMAND = ("run", "--case", "planted:Short", "--suite", "quick")
BOTH = ("--integrator", "planted:Sound", "--integrator", "planted:NearDuplicate")
SETTINGS, LAUNCHES = 8, 3
SUITE = plan.suite("quick").change(launches=LAUNCHES)
KILLED = (Status.INTERRUPTED, "the process died of SIGKILL")


def run(out: Path, *more: str) -> int:
    return gnomon(*COMMAND, "--out", str(out), *more)


def launched(out: Path, suite: plan.Suite = SUITE) -> None:
    run_(out, suite, selection.choose(["planted:Short"], False), [planted.Sound()])


def stops(after: int) -> Callable[..., Any]:
    """Ctrl-C after so many trials."""
    count = itertools.count()

    def how(*_: Any) -> None:
        if next(count) == after:
            raise KeyboardInterrupt

    return how


def test_all_trials_of_the_named_integrators_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A library was rebuilt, which no key shows: nothing runs without the option; with it named trials run, once."""
    answering(monkeypatch)
    out = tmp_path / "results.sqlite"
    assert run(out, *BOTH) == 0
    for more, asked in ((BOTH[:2], 0), ((*BOTH[:2], "--repeat"), SETTINGS), (BOTH[:2], 0), (BOTH, 0)):
        pool = answering(monkeypatch)
        assert run(out, *more) == 0
        assert len(pool.asked) == asked, more
    frame = store.load(out)
    assert frame.groupby("integrator")["run"].unique().map(list).to_dict() == {"near_duplicate": [1], "sound": [3]}


def test_a_repetition_that_is_interrupted_leaves_no_old_measurement(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Else measurements of the old library would stand beside measurements of the new library. The next run, without
    --repeat, measures the rest."""
    answering(monkeypatch)
    out = tmp_path / "results.sqlite"
    run(out, *BOTH[:2])
    answering(monkeypatch, stops(3))
    assert run(out, *BOTH[:2], "--repeat") == 130
    assert "the same command without --repeat resumes the run" in capfd.readouterr().err
    frame = store.load(out)
    assert (frame["status"] == Status.OK).sum() == 3
    assert set(frame.loc[frame["status"] == Status.OK, "run"]) == {2}
    assert outstanding(out).trials == SETTINGS - 3
    rest = answering(monkeypatch)
    assert run(out, *BOTH[:2]) == 0
    assert len(rest.asked) == SETTINGS - 3
    assert set(store.load(out)["run"]) == {2, 3}


def test_all_launches_are_repeated_whatever_the_suite(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A median over launches of two libraries would be the median of neither."""
    answering(monkeypatch)
    launched(tmp_path)
    pool = answering(monkeypatch)
    launched(tmp_path, SUITE.change(launches=1, repeat=Repeat.ALL))
    assert len(pool.asked) == len(set(pool.asked)) == SETTINGS * LAUNCHES
    frame = store.load(tmp_path)
    assert set(frame["run"]) == {2}
    assert outstanding(tmp_path).text == ""


def test_a_repetition_that_fails_settles_its_later_launches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Later launches repeat the settings that the first launch scored: no trial is left that no run would measure."""
    answering(monkeypatch)
    launched(tmp_path)
    answering(monkeypatch, lambda *_: (Status.CRASHED, "the rebuilt library raises"))
    launched(tmp_path, SUITE.change(repeat=Repeat.ALL))
    assert outstanding(tmp_path).text == ""
    assert run(tmp_path, *BOTH[:2]) == 1, "an integrator of one's own that never succeeded"


def test_an_interrupted_launch_runs_again_whatever_the_suite(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else a run would say for ever that the same command measures it."""
    answering(monkeypatch, lambda job, setting: KILLED if job.launch == LAUNCHES else None)
    launched(tmp_path)
    assert outstanding(tmp_path).text == f"{SETTINGS} repeated launches were interrupted"
    pool = answering(monkeypatch)
    assert run(tmp_path, *BOTH[:2]) == 0
    assert {launch for _, _, launch in pool.asked} == {LAUNCHES}
    assert outstanding(tmp_path).text == ""


@pytest.mark.parametrize(
    "ended", [(Status.OUT_OF_MEMORY, "needed more than 1 GiB"), KILLED, (Status.INTERRUPTED, "the disk is full (/tmp)")]
)
def test_what_a_cause_outside_ended_is_named_and_runs_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], ended: tuple[Status, str]
) -> None:
    """Memory, or a signal or a full disk again and again. Its status does not tell whose fault it was: a run does not
    repeat it by itself, says so, and repeats it when it is asked. A crash of the integrator's own is not repeated."""

    def how(job: Any, setting: float) -> Any:
        last = [trial.setting for trial in job.trials][-2:]
        return {last[0]: (Status.CRASHED, "ArithmeticError: its own"), last[1]: ended}.get(setting)

    for _ in range(3):
        answering(monkeypatch, how)
        launched(tmp_path, SUITE.change(launches=1))
    pool = answering(monkeypatch)
    assert run(tmp_path, *BOTH[:2]) == 0
    assert pool.asked == []
    told = capfd.readouterr().err
    assert "a cause outside may have ended 1 trials" in told
    assert "with --repeat they run again" in told
    launched(tmp_path, SUITE.change(launches=1, repeat=Repeat.FROM_OUTSIDE))
    assert len(pool.asked) == 1
    assert store.load(tmp_path)["status"].value_counts().to_dict() == {"ok": SETTINGS - 1, "crashed": 1}


def test_repeat_without_names_is_for_what_a_cause_outside_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    suites = list[plan.Suite]()

    answering(monkeypatch)
    monkeypatch.setattr(
        "gnomon.harness.running.planned_run.run", lambda out, suite, *_, **__: suites.append(suite) or out
    )
    monkeypatch.setattr("gnomon.harness.commands.run._summarize", lambda *_: None)
    for more in ((), BOTH, ("--library", "scipy")):
        run(tmp_path, *more, "--repeat")
    assert [suite.repeat for suite in suites] == [Repeat.FROM_OUTSIDE, Repeat.ALL, Repeat.ALL]


def test_a_repetition_is_no_interruption(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Trials that were repeated often and are then interrupted once are not yet crashes; they were none before."""
    suite = SUITE.change(launches=1)
    answering(monkeypatch)
    for _ in range(4):
        launched(tmp_path, suite.change(repeat=Repeat.ALL))
    answering(monkeypatch, lambda *_: KILLED)
    for repeat in (Repeat.ALL, Repeat.NOTHING, Repeat.ALL, Repeat.NOTHING):
        launched(tmp_path, suite.change(repeat=repeat))
        assert set(store.load(tmp_path)["status"]) == {Status.INTERRUPTED}
    launched(tmp_path, suite)
    assert set(store.load(tmp_path)["status"]) == {Status.CRASHED}


@pytest.mark.parametrize("name", ["pybullet:stepSimulation [configured]", "rebound:IAS15", "gnomon:RK4", "scipy:RK45"])
def test_another_python_or_compiler_is_another_trial(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python calls every integrator, and numba and llvmlite compile equations, methods and the forces of engines."""
    one = lookup.find(name)[0]

    def versions() -> dict[str, str]:
        return plan.library_versions.__wrapped__(one)  # type: ignore[no-any-return]

    before = versions()
    with monkeypatch.context() as patched:
        patched.setattr(platform, "python_version", lambda: "4.0")
        assert versions() != before
    known = environment.library_version
    for compiler in ("numba", "llvmlite"):
        with monkeypatch.context() as patched:
            patched.setattr(
                environment, "library_version", lambda lib, one=compiler: "9.9" if lib == one else known(lib)
            )
            assert versions() != before


COMPILED = """
from gnomon.harness.contract.integrator import Integrator, Steps
from gnomon.cases.core.forms import FirstOrder
{imports}

class Mine(Integrator):
    name, accepts, sweep = "mine", (FirstOrder,), Steps()

    def prepare(self, problem, setting):
        raise NotImplementedError
"""


@pytest.mark.parametrize(
    "imports",
    [
        "from numba import njit",
        "import numba.core",
        "from llvmlite import ir",
        "from gnomon.harness.kernels.equations import right_hand_side",
    ],
)
def test_compilers_take_part_in_a_users_own_integrator_that_imports_them(
    imports: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Themselves, in a module beside it, or through gnomon's compiled equations."""
    monkeypatch.syspath_prepend(tmp_path)
    for name, text in (("plain", ""), ("direct", imports), ("beside", "import direct_alone")):
        (tmp_path / f"{name}_alone.py").write_text(COMPILED.format(imports=text))
    found = {name: lookup.find(f"{name}_alone:Mine")[0] for name in ("plain", "direct", "beside")}
    assert {name: {"numba", "llvmlite"} <= plan.library_versions(one).keys() for name, one in found.items()} == {
        "plain": False,
        "direct": True,
        "beside": True,
    }


class Rebuilt(planted.Sound):
    """A method whose native library states its build."""

    name = "rebuilt"
    built = "1"

    def versions(self) -> dict[str, str]:
        return {"library": self.built}


def test_versions_of_its_own_are_in_the_key(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """docs/integrator.md says so."""
    keys = []
    for built in ("1", "1", "2"):
        monkeypatch.setattr(Rebuilt, "built", built)
        one: Integrator = Rebuilt()
        keys.append(plan.library_versions(one))
    assert keys[0] == keys[1] != keys[2]

"""`pytest --gnomon`, `gnomon.verify.parametrize` and `assert_follows`, run by pytest itself as a user would."""

import os
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import planted_methods
import pytest
from gnomon.harness.verification.claims import Outcome

import gnomon
from gnomon.verify import assert_follows

HELPERS = Path(planted_methods.__file__).parent


def run(folder: Path, *arguments: str) -> tuple[int, str]:
    """The exit code and the output of pytest in a folder with no settings of its own."""
    (folder / "pytest.ini").touch()
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-rA", "-p", "no:cacheprovider", *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(HELPERS)},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout + done.stderr


def test_a_pytest_without_the_option_imports_nothing_more(tmp_path: Path) -> None:
    """The plugin is loaded by every pytest of an environment with gnomon."""
    (tmp_path / "test_alone.py").write_text(
        "import sys\ndef test_alone():\n    assert not {'numpy', 'numba', 'gnomon.cases'} & set(sys.modules)\n"
        "    assert 'gnomon.harness.verification.pytest_plugin' in sys.modules\n"
    )
    others = {point.name for point in entry_points(group="pytest11")} - {"gnomon"}  # some import numpy
    code, text = run(tmp_path, *(f"-pno:{name}" for name in others))
    assert code == 0, text


def test_one_test_for_each_claim_on_each_case_selectable_by_k(tmp_path: Path) -> None:
    """A planted sign fails the order, which -k selects with one more claim; the rest is deselected and not run."""
    chosen = ("--gnomon", "planted_methods:signed", "-k", "pendulum_simple and (step_order or repeatable)")
    code, text = run(tmp_path, *chosen)
    assert code == 1, text
    assert "1 failed, 1 passed" in text
    assert "FAILED gnomon::planted_methods:signed::step_order[pendulum_simple]" in text
    assert "expected: errors of a step proportional to h^3" in text
    known = tmp_path / "known.txt"
    known.write_text("step_order pendulum_simple a sign\nrepeatable pendulum_simple a clock\n")
    code, text = run(tmp_path, *chosen, "--gnomon-known-failures", str(known))
    assert code == 0, text
    assert "1 xfailed, 1 xpassed" in text


@pytest.mark.parametrize("workers", [(), ("-n", "2")])
def test_a_run_in_which_no_claim_applies_has_checked_nothing(tmp_path: Path, workers: tuple[str, ...]) -> None:
    """RK4 is not symplectic and does not declare it: the one claim chosen is skipped, and the run is not green."""
    (tmp_path / "test_none.py").write_text("")
    chosen = ("--gnomon", "planted_methods:good_rk4", "-k", "pendulum_simple and symplectic", *workers)
    code, text = run(tmp_path, *chosen)
    assert "1 skipped" in text, text
    assert code == pytest.ExitCode.NO_TESTS_COLLECTED, text


@pytest.mark.slow
def test_workers_of_xdist_collect_the_same_tests(tmp_path: Path) -> None:
    """In `make test` the run above with two workers shows it: xdist refuses workers that collect different tests."""
    chosen = ("--gnomon", "planted_methods:good_rk4", "-m", "gnomon", "-k", "repeatable or bad_start", "-n", "2")
    code, text = run(tmp_path, *chosen)
    assert code == 0, text
    assert "PASSED gnomon::planted_methods:good_rk4::repeatable[pendulum_simple]" in text


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--gnomon", "planted_methods:absent"), "absent"),
        (("--gnomon", "planted_methods:good_rk4", "--gnomon-depth", "deep"), "no depth is called 'deep'"),
        (("--gnomon", "planted_methods:good_rk4", "--gnomon-known-failures", "nowhere.txt"), "nowhere.txt"),
    ],
)
def test_a_wrong_option_is_an_error_of_use(tmp_path: Path, arguments: tuple[str, ...], says: str) -> None:
    code, text = run(tmp_path, *arguments)
    assert code == pytest.ExitCode.USAGE_ERROR, text
    assert says in text
    assert "Traceback" not in text


def test_a_test_of_the_user_is_parametrized_with_the_claims(tmp_path: Path) -> None:
    (tmp_path / "test_mine.py").write_text(
        "import gnomon.verify, planted_methods\n"
        "@gnomon.verify.parametrize(planted_methods.signed, cases=['pendulum_simple'])\n"
        "def test_mine(check):\n    check()\n"
    )
    code, text = run(tmp_path, "-k", "step_order or aliasing or tolerance_short")
    assert code == 1, text
    assert "FAILED test_mine.py::test_mine[step_order[pendulum_simple]]" in text
    assert "1 failed, 1 passed, 1 skipped" in text


def test_follows_the_exact_motion_within_an_error() -> None:
    """RK4 with 64 steps a sample errs by less than 1e-6 on the pendulum, and by more than 1e-14."""
    step = 2.0**-8
    assert_follows(planted_methods.good_rk4, "pendulum_simple", step, within=1e-4)
    with pytest.raises(AssertionError) as caught:
        assert_follows(planted_methods.good_rk4, "pendulum_simple", step, within=1e-15)
    text = str(caught.value)
    assert "allowed 1e-15, floor " in text
    assert "theta: exact " in text
    assert " rad, " in text
    assert " ulp" in text
    with pytest.raises(ValueError, match="give within=, the largest error"):
        assert_follows(planted_methods.good_rk4, "pendulum_simple", step)
    with pytest.raises(ValueError, match="give a positive error"):
        assert_follows(planted_methods.good_rk4, "pendulum_simple", step, within=0.0)


def test_a_tolerance_gives_its_own_bound() -> None:
    assert_follows(planted_methods.good_pair, "pendulum_simple", 1e-6)
    with pytest.raises(AssertionError, match=r"at tolerance 1e-06: error .*, allowed 1e-09"):
        assert_follows(planted_methods.good_pair, "pendulum_simple", 1e-6, within=1e-9)


def test_a_case_of_gnomon_case_is_taken_where_a_case_is() -> None:
    """With its own numbers: the bound holds for a small swing, and not at the coarse step for a large one."""
    small = gnomon.case("pendulum_simple", theta="0.01", span=8)
    assert_follows(planted_methods.good_rk4, small, setting=0.02, within=1e-4)
    with pytest.raises(AssertionError, match="computed"):
        assert_follows(planted_methods.good_rk4, gnomon.case("pendulum_simple", theta=3, span=9), 0.1, within=1e-4)
    report = gnomon.verify.verify(planted_methods.good_rk4, [small], "low", ["follows"], workers=1)
    assert [(row.case, row.finding.outcome) for row in report.rows] == [("pendulum_simple", Outcome.PASSED)]
    with pytest.raises(ValueError, match="one name and different numbers"):
        gnomon.verify.verify(planted_methods.good_rk4, [small, "pendulum_simple"], "low")
    with pytest.raises(ValueError, match="3 is not a case"):
        assert_follows(planted_methods.good_rk4, 3, setting=0.1, within=1e-4)  # type: ignore[arg-type]

"""States that are no motion of the case are never verified: not by a claim, a test, a baseline or a file."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from command_line import gnomon
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Floats, Integrator, Steps
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.verification.baseline import measure
from gnomon.harness.verification.claim_tests import claim_tests
from gnomon.harness.verification.claims import DEPTHS, Depth, Outcome
from gnomon.harness.verification.verify import CLAIMS
from planted_methods import good_pair, good_rk4, good_verlet

from gnomon.verify import Refused, assert_follows, from_solve, from_step

DEGREE = 180 / np.pi


def answering(change: Callable[[Floats], Any], name: str) -> Integrator:
    """The classical method of order 4, whose states (times, dim) are changed at the end."""

    def solve(f: Any, t0: float, y0: Floats, times: Floats, step: float) -> Any:
        found, t, y = [], t0, y0
        for end in times:
            count = max(1, round((end - t) / step))
            h = (end - t) / count
            for k in range(count):
                a = f(t + k * h, y)
                b = f(t + k * h + h / 2, y + h / 2 * a)
                c = f(t + k * h + h / 2, y + h / 2 * b)
                y = y + h / 6 * (a + 2 * b + 2 * c + f(t + (k + 1) * h, y + h * c))
            t = end
            found.append(y)
        return change(np.array(found))

    return from_solve(solve, name=name, order=4, sweep=Steps(0.25, 6))


WRONG = {
    "zeros": lambda y: 0 * y,
    "degrees": lambda y: DEGREE * y,
    "kilometres": lambda y: y / 1000,
    "sign": lambda y: y * np.where(np.arange(y.shape[1]) == 1, -1, 1),
    "halves": lambda y: np.roll(y, y.shape[1] // 2, axis=1),
    "late": lambda y: y[[0, *range(len(y) - 1)]],
    "early": lambda y: y[[*range(1, len(y)), -1]],
    "random": lambda y: np.random.default_rng(1).normal(size=y.shape) * np.max(np.abs(y)),
    "start repeated": lambda y: 0 * y + y[0],
    "backward": lambda y: y[::-1],
}
zero = answering(WRONG["zeros"], "zeros")
SHALLOW = Depth(64 * 8, 1.0, "shallow", 3, 2)
"""Four steps from sample to sample at the finest setting: states that are wrong are so at any step."""


def follows(integrator: Integrator, case: str, depth: Depth = DEPTHS["low"]) -> Outcome:
    trials = Trials.of(integrator, CaseSpec.of(get(*case.split("/")).rounded()), depth)
    return CLAIMS["follows"].check(trials).outcome


@pytest.mark.parametrize("case", ["pendulum_simple", "kepler_orbit", "forced_oscillator", "projectile_parabola"])
@pytest.mark.parametrize("fault", WRONG)
def test_wrong_states_fail_the_claim_that_always_applies(fault: str, case: str) -> None:
    assert follows(answering(WRONG[fault], fault), case, SHALLOW) == Outcome.FAILED


@pytest.mark.parametrize("depth", ["normal", "high"])
def test_no_depth_is_too_deep_or_too_shallow(depth: str) -> None:
    """States that are late by one sample are the closest of the wrong ones: 1/64 of the distance that is covered."""
    assert follows(answering(WRONG["late"], "late"), "pendulum_simple", DEPTHS[depth]) == Outcome.FAILED


def test_another_system_fails() -> None:
    """Gravity that is wrong by 3 %, whose motion begins as the right one and departs by the same share."""
    heavy = from_step(lambda f, t, y, h: y + h * np.array([y[1], 1.03 * f(t, y)[1]]), name="heavy", order=1)
    assert follows(heavy, "pendulum_simple") == Outcome.FAILED


@pytest.mark.parametrize(
    "case",
    [
        "pendulum_simple",
        "kepler_orbit",
        "forced_oscillator",
        "kepler_orbit/e09",
        "double_pendulum",
        "damped_oscillator",
    ],
)
def test_a_consistent_method_of_order_1_follows_every_motion(case: str) -> None:
    """The part of the span is so short that it must."""
    euler = from_step(lambda f, t, y, h: y + h * f(t, y), name="Euler", order=1)
    assert follows(euler, case) == Outcome.PASSED
    backward = from_step(lambda f, t, y, h: y + h * f(t + h, y + h * f(t, y)), name="predicted Euler", order=1)
    assert follows(backward, case) == Outcome.PASSED


@pytest.mark.parametrize("method", [good_rk4, good_verlet, good_pair], ids=lambda method: method.name)
def test_right_methods_follow(method: Integrator) -> None:
    assert follows(method, "pendulum_simple") == Outcome.PASSED


def test_a_method_without_a_solution_was_not_checked() -> None:
    def decline(f: Any, t: float, y: Floats, h: float) -> Floats:
        raise Refused("no problem is good enough")

    assert follows(from_step(decline, name="refuses", order=1), "pendulum_simple") == Outcome.NOT_CHECKED
    never = from_step(lambda f, t, y, h: y * np.nan, name="never", order=1)
    assert follows(never, "pendulum_simple") == Outcome.FAILED, "states that are not finite are no refusal"


def test_neither_tests_nor_baselines_accept_zeros() -> None:
    """The checks of `parametrize` and of the plugin are these; skipped checks alone would leave pytest green."""
    (check,) = [check for check in claim_tests(zero, "low", ["pendulum_simple"]) if check.claim == "follows"]
    with pytest.raises(AssertionError, match="FAILED follows on pendulum_simple"):
        check()
    with pytest.raises(AssertionError, match="zeros on pendulum_simple"):
        assert_follows(zero, "pendulum_simple", 0.01, within=0.5)
    with pytest.raises(ValueError, match="follows no exact motion at any setting"):
        measure(zero, ["pendulum_simple"], "low", runs=2)


def test_a_check_that_follows_without_a_known_accuracy_fails() -> None:
    """A solver that does what it likes with its step, and declares no order: nothing says how accurate it is."""
    fixed = from_solve(
        lambda f, t0, y0, times, step: type(good_rk4).function and _fixed(f, t0, y0, times),
        name="fixed",
        sweep=Steps(0.25, 6),
    )
    assert follows(fixed, "pendulum_simple") == Outcome.PASSED
    (check,) = [check for check in claim_tests(fixed, "low", ["pendulum_simple"]) if check.claim == "follows"]
    with pytest.raises(AssertionError, match="no claim about accuracy was checked"):
        check()


def test_a_method_without_a_declared_order_is_held_to_the_order_that_it_shows() -> None:
    midpoint = from_step(lambda f, t, y, h: y + h * f(t + h / 2, y + h / 2 * f(t, y)), name="midpoint")
    trials = Trials.of(midpoint, CaseSpec.of(get("pendulum_simple").rounded()), DEPTHS["low"])
    found = CLAIMS["error"].check(trials)
    assert found.outcome == Outcome.PASSED
    assert found.got.startswith(("order 2.0", "order 1.9"))


def test_a_closed_form_has_round_off_at_all_settings() -> None:
    """No order can be measured, and none is needed."""
    exact = from_step(_thrown, name="closed form")
    trials = Trials.of(exact, CaseSpec.of(get("projectile_parabola").rounded()), DEPTHS["low"])
    assert CLAIMS["error"].check(trials).got == "round-off at all settings"


def _thrown(f: Any, t: float, y: Floats, h: float) -> Floats:
    """Exact for a constant acceleration."""
    half = len(y) // 2
    acceleration = f(t, y)[half:]
    return np.concatenate([y[:half] + h * y[half:] + h * h / 2 * acceleration, y[half:] + h * acceleration])


def _fixed(f: Any, t0: float, y0: Floats, times: Floats) -> Floats:
    """Euler's method with 256 steps from sample to sample, whatever is asked for."""
    found, t, y = [], t0, y0
    for end in times:
        for k in range(256):
            y = y + (end - t) / 256 * f(t + k * (end - t) / 256, y)
        t = end
        found.append(y)
    return np.array(found)


PROGRAM = """
import json, sys
for line in sys.stdin:
    asked = json.loads(line)
    if asked["request"] == "describe":
        told = {"protocol": 1, "name": "zeros", "order": 4, "sweep": {"kind": "step"}}
    elif not isinstance(asked["setting"]["value"], float) or not asked["setting"]["value"] > 0:
        told = {"number": asked["number"], "status": "refused", "reason": "no step"}
    else:
        told = {"number": asked["number"], "status": "ok", "states": [[0.0] * 4 for _ in asked["times"]]}
    print(json.dumps(told), flush=True)
"""


def test_a_program_that_answers_zeros_is_red_in_every_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program, kinds = tmp_path / "zeros.py", ("json", "junit", "markdown", "badge")
    program.write_text(PROGRAM)
    files = [word for kind in kinds for word in (f"--{kind}", str(tmp_path / kind))]
    named = (
        "--command",
        f"{sys.executable} {program}",
        "--case",
        "kepler_orbit",
        "--depth",
        "low",
        "--claim",
        "follows",
    )
    assert gnomon("verify", *named, *files) == 1
    shown = capsys.readouterr().out
    assert "FAILED follows on kepler_orbit" in shown
    assert "likely cause: all samples are equal" in shown
    assert json.loads((tmp_path / "json").read_text())["verdict"] == "failed"
    assert int(ElementTree.parse(tmp_path / "junit").getroot().get("failures", "0")) > 0
    assert "| follows | kepler\\_orbit |" in (tmp_path / "markdown").read_text()
    assert json.loads((tmp_path / "badge").read_text())["color"] == "red"

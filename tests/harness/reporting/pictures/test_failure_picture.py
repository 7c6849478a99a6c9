"""The command that a failure names verifies it alone and draws it."""

import json
import math
import shlex
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import planted_methods
import pytest
from command_line import gnomon
from gnomon.cases.core.registry import get
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.reporting.pictures import failure_picture
from gnomon.harness.verification.claims import DEPTHS, fail_claim
from gnomon.harness.verification.verify import Row

SVG = "{http://www.w3.org/2000/svg}"
PENDULUM = ("--case", "pendulum_simple", "--depth", "low")


def texts(path: Path) -> str:
    return "\n".join(" ".join(element.itertext()) for element in ElementTree.parse(path).iter(f"{SVG}text"))


def test_the_command_that_a_failure_names_draws_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "a.json"
    named = ("verify", "planted_methods:signed", *PENDULUM, "--claim", "step_order", "--json", str(file))
    assert gnomon(*named) == 1
    ((row,),) = [json.loads(file.read_text())["rows"]]
    assert f"  command:  {row['command']}" in capsys.readouterr().out.splitlines()
    program, *words = shlex.split(row["command"])
    assert program == "gnomon"
    assert gnomon(*words) == 1
    shown = texts(tmp_path / "failure.svg")
    for part in (
        "FAILED step_order on pendulum_simple, drawn at h = ",
        row["expected"],
        "theta",
        "omega",
        "Error against",
    ):
        assert part in shown


def test_the_picture_holds_the_solution_at_the_setting_of_the_failure() -> None:
    """The circles are the states that the integrator returns there, and the errors are their distances."""
    trials = Trials.of(planted_methods.signed, CaseSpec.of(get("pendulum_simple").rounded()), DEPTHS["low"])
    for setting in trials.settings:
        found = failure_picture._measure(trials, f"{trials.named(setting)} to 1")
        answer = trials.whole(setting)
        assert answer.states is not None
        assert found["setting"] == setting
        assert found["states"] == answer.states.tolist()
        assert max(found["errors"]) == answer.error
    assert failure_picture._measure(trials, "start nan")["setting"] == trials.usual()
    assert failure_picture._measure(trials, "h = 1e-300 to 1")["setting"] == trials.settings[-1]


def test_a_solution_that_is_missing_or_not_finite_leaves_the_exact_motion() -> None:
    """The picture is drawn nevertheless, and says why nothing is computed; huge values do not change its scale."""
    trials = Trials.of(planted_methods.good_rk4, CaseSpec.of(get("pendulum_simple").rounded()), DEPTHS["low"])
    sound = failure_picture._measure(trials, "")
    row = Row("runs", "pendulum_simple", fail_claim("", "states", "none"))

    def drawn(found: dict[str, Any]) -> Any:
        return failure_picture._chart(trials.case, planted_methods.good_rk4, row, found).to_dict()

    usual = drawn(sound)
    assert len(usual["vconcat"]) == 4, "two groups of coordinates, errors against time, errors against setting"
    for value in (None, math.nan, 1e300):
        values = None if value is None else [[value, value] for _ in sound["times"]]
        errors = None if value is None else [value for _ in sound["times"]]
        found = drawn(sound | {"why": "it <gives> up", "states": values, "errors": errors, "sweep": []})
        assert f"At {sound['named']}: it <gives> up" in found["title"]["subtitle"]
        assert len(found["vconcat"]) == (3 if value == 1e300 else 2)
        for one, other in zip(found["vconcat"][:2], usual["vconcat"][:2], strict=True):
            assert one["layer"][0]["encoding"]["y"] == other["layer"][0]["encoding"]["y"]

"""`gnomon.case`: exact states with all their digits, in the numbers that integrators get; odd arguments are named."""

import json
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.cases import get

import gnomon


def test_digits_are_those_asked_for_and_those_of_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    """`gnomon exact` rounds the numbers of the case in the same way."""
    from command_line import gnomon as command

    assert command("exact", "pendulum_simple", "--times", "1.5,0.1", "--digits", "30", "--set", "L=2") == 0
    there = json.loads(capsys.readouterr().out)["states"]
    for state, row in zip(gnomon.case("pendulum_simple", L=2).exact(["1.5", "0.1"], 30), there, strict=True):
        for name, value in state.items():
            assert value == Decimal(row[name])
            assert len(value.as_tuple().digits) == 30
            assert str(value) in str(state)


def test_samples_are_the_nearest_doubles_of_the_exact_states() -> None:
    orbit = gnomon.case("kepler_orbit/e09")
    states = orbit.sample(orbit.times)
    exact = np.array([[float(x) for x in state.values()] for state in orbit.exact(orbit.times, 25)])
    assert np.abs(states - exact).max() <= np.spacing(np.abs(exact)).max()


def test_a_case_can_be_given_by_name_variant_class_or_object() -> None:
    kind = type(get("kepler_orbit"))
    named = gnomon.case("kepler_orbit", "e09")
    for other in (gnomon.case("kepler_orbit/e09"), gnomon.case(kind, "e09"), gnomon.case(get("kepler_orbit", "e09"))):
        assert other.exact(1, 20) == named.exact(1, 20)
    assert gnomon.case(named).case.id == named.case.id


@pytest.mark.parametrize("name", ["pendulum_simple", "bouncing_ball", "free_rigid_body", "kepler_two_body"])
def test_the_equations_of_each_kind_of_case_are_printed(name: str) -> None:
    name = name if name in gnomon.list_cases() else gnomon.list_cases(name.split("_")[0])[0]
    equations = gnomon.case(name).equations
    assert "=" in str(equations)
    assert "$$" in equations._repr_latex_()


def test_lists_take_parts_patterns_and_variants() -> None:
    assert "kepler_orbit" in gnomon.list_cases("KEPLER")
    assert "kepler_orbit/e09" in gnomon.list_cases("kepler_orbit/*")
    assert set(gnomon.list_integrators("gauss")) < set(gnomon.list_integrators())
    assert all(name.startswith("scipy:") for name in gnomon.list_integrators("scipy:*"))


SWING = gnomon.case("pendulum_simple")


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: SWING.exact(-1), "t=-1: the motion starts at 0"),
        (lambda: SWING.exact("x"), "t = 'x' is not a number"),
        (lambda: SWING.exact([0, None]), "t = None is not a number"),
        (lambda: SWING.exact(1, 0), "digits=0"),
        (lambda: SWING.exact(1, 2.5), "digits=2.5"),
        (lambda: SWING.sample(1), "times=1: give a sequence"),
        (lambda: SWING.sample([[1.0]]), "times="),
        (lambda: SWING.sample(["a"]), "times="),
        (lambda: gnomon.case(3), "name=3"),
        (lambda: gnomon.case("pendulum"), "did you mean"),
        (lambda: gnomon.case("kepler_orbit/e9"), "no variant 'e9'"),
        (lambda: gnomon.case("kepler_orbit/e09", "e09"), "variant='e09'"),
        (lambda: gnomon.case(SWING, L=2), "this case has its numbers"),
        (lambda: gnomon.list_cases("zzz"), "nothing matches 'zzz'"),
        (lambda: gnomon.list_cases(3), "pattern=3"),
        (lambda: gnomon.list_integrators(3), "pattern=3"),
    ],
)
def test_an_odd_argument_is_named(call: Any, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        call()


def test_starts_are_numbers_of_a_case_by_their_names() -> None:
    """The others stay as they are; a variant's too."""
    assert gnomon.case("pendulum_simple", theta="0.9").start.tolist() == [0.9, 0.0]
    orbit = gnomon.case("kepler_orbit/e09")
    assert gnomon.case("kepler_orbit/e09", vy=0.5).start.tolist() == [*orbit.start[:3].tolist(), 0.5]
    with pytest.raises(ValueError, match="theta is given, and an initial state"):
        gnomon.case("pendulum_simple", initial_state=(1, 0), theta=1)
    with pytest.raises(ValueError, match="no coordinate of this name; did you mean theta"):
        gnomon.case("pendulum_simple", tetha=1)


def test_the_commands_set_starts(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    from command_line import gnomon as command

    start = ("pendulum_simple", "--set", "theta=0.8125")
    assert command("show", *start) == 0
    assert "0.8125" in capfd.readouterr().out
    assert command("scene", *start, "--out", str(tmp_path)) == 0
    motion = next(tmp_path.glob("*.csv")).read_text()
    assert "0.8125" in motion
    report = tmp_path / "report.json"
    asked = ("verify", "gnomon:RK4", "--depth", "low", "--claim", "runs")
    assert command(*asked, "--case", *start, "--json", str(report)) == 0
    assert command(*asked, "--set", "theta=0.8125") == 2
    assert "--set changes the numbers of a --case" in capfd.readouterr().err

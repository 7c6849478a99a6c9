"""Sentences about the energy have the number of a known motion, and a program that hangs or ends takes none with it."""

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import planted_engines
import pytest
from command_line import gnomon
from gnomon.harness.registry import lookup
from gnomon.harness.studies.energy_at_practical_steps import (
    LATE,
    MOMENTS,
    PERIODS_LONG,
    TURNING,
    describe_energy,
    percent,
    say_change,
)
from gnomon.harness.studies.growth import STRETCH
from gnomon.harness.verification.function_adapter import from_step
from planted_engines import planted
from planted_methods import good_rk4


def per_cent(sentence: str) -> float:
    """The first number in per cent of a sentence."""
    found = re.search(r"([+-]?[\d.]+) %", sentence)
    assert found, sentence
    return float(found[1])


@pytest.mark.parametrize(
    ("engine", "axis", "moment"),
    [(planted_engines.Steady, "middle", 2), (planted_engines.AboutFirst, "least", 1), (planted_engines.AboutLast, "largest", 3)],
)  # fmt: skip
def test_the_energy_and_the_axis_of_a_free_body_are_named(engine: Any, axis: str, moment: float) -> None:
    """A body that keeps its angular momentum L and turns about an axis of moment I has the energy L^2 / 2I."""
    moments, spin = np.array(MOMENTS), np.array(TURNING)
    expected = np.sum((moments * spin) ** 2) / moment / np.sum(moments * spin**2) - 1
    (sentence,) = describe_energy(planted(engine, "gyroscopic"))
    assert per_cent(sentence) == pytest.approx(100 * expected, rel=0.05)
    assert axis in sentence
    assert "angular momentum" not in sentence
    assert sum(word in sentence for word in ("middle", "least", "largest")) == 1


def test_no_axis_is_named_where_the_energy_stays() -> None:
    (sentence,) = describe_energy(planted(planted_engines.Resting, "gyroscopic"))
    assert "kept" in sentence
    assert "axis" not in sentence


def test_the_height_of_a_ball_is_what_its_impacts_left() -> None:
    """It falls 1 m in 0.45 s and meets the plane every 0.9 s: 60 to 66 times before the last 5 s end."""
    found = {
        each: describe_energy(planted(each, "rigid_impact")) for each in (planted_engines.Ball, planted_engines.Leaky)
    }
    (whole,), (left,) = found.values()
    assert per_cent(whole) == 100
    assert 100 * 0.999 ** (2 * 68) - 0.5 < per_cent(left) < 100 * 0.999 ** (2 * 58) + 0.5
    (dead,) = describe_energy(planted(planted_engines.Dead, "rigid_impact"))
    assert "no height" in dead


def test_the_drift_of_a_method_is_that_of_its_map() -> None:
    """RK4 multiplies the energy of an oscillator by 1 - z^6/72 + z^8/576 in a step, z = 2 pi over the steps a period."""
    z = 2 * math.pi * STRETCH / 40
    middle = 4000 * (1 - LATE / 2 / PERIODS_LONG)
    expected = (1 - z**6 / 72 + z**8 / 576) ** middle - 1
    for method in (lookup.own()["gnomon:RK4"], good_rk4):
        (sentence,) = describe_energy(method, ["harmonic_oscillator"])
        assert per_cent(sentence) == pytest.approx(100 * expected, rel=0.06)
        assert sentence.startswith("harmonic_oscillator")


def test_an_oscillation_is_no_drift_and_growth_is() -> None:
    """The energy of a symplectic method oscillates; that of explicit Euler grows by far."""
    assert "within" in describe_energy(lookup.own()["gnomon:Störmer-Verlet"], ["pendulum_simple"])[0]
    t = np.linspace(0, 1, 400)
    wave = np.sin(300 * t)
    assert "within" in say_change(0.01 * wave, 20)
    assert "within" in say_change(0.01 * wave**2, 20)  # it starts where the energy is least
    assert per_cent(say_change(0.01 * np.tanh(50 * t), 20)) == pytest.approx(1, rel=0.05)  # it has come to an end
    assert per_cent(say_change(0.01 * wave - 0.1 * t, 20)) == pytest.approx(-10, rel=0.1)
    assert per_cent(say_change(1e-4 * np.exp(6 * t), 20)) == pytest.approx(100e-4 * math.exp(6), rel=0.2)
    assert "times" in say_change(np.exp(20 * t), 20)
    assert "not finite" in say_change(np.full(400, np.nan), 20)
    assert "kept" in say_change(1e-14 * wave, 20)


def test_tolerances_and_methods_without_cases_that_keep_their_energy() -> None:
    (sentence,) = describe_energy(lookup.own()["scipy:DOP853"], ["pendulum_simple"])
    assert "tolerance 1e-06" in sentence
    assert describe_energy(lookup.own()["gnomon:RK4"], ["damped_oscillator"]) == ()


def test_an_engine_that_ends_its_process_or_raises_is_named_and_the_other_sentence_stays() -> None:
    (ball,) = describe_energy(planted(planted_engines.Crashes, "rigid_impact"))
    assert "exit code 3" in ball
    body, other = describe_energy(planted(planted_engines.Raises, "gyroscopic", "rigid_impact"))
    assert "no solver" in body
    assert "no solver" in other


def test_a_method_is_shown_on_the_first_two_systems_that_it_takes() -> None:
    def euler(f: Any, t: float, y: Any, h: float) -> Any:
        return y + h * f(t, y)

    sentences = describe_energy(from_step(euler, name="Euler", order=1))
    assert [sentence.partition(":")[0] for sentence in sentences] == ["pendulum_simple", "kepler_orbit"]


def test_numbers_have_two_digits() -> None:
    assert percent(0.123456) == "12 %"
    assert percent(-1.23456e-5, sign=True) == "-0.0012 %"


def test_the_command_prints_the_sentences_before_its_last_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Also where the time is over, which it says; a single claim has none."""
    written, page = tmp_path / "found.json", tmp_path / "found.md"
    words = ("verify", "gnomon:RK4", "--case", "pendulum_simple", "--depth", "low", "--max-seconds", "1e-9")
    gnomon(*words, "--json", str(written), "--markdown", str(page))
    *_, note, _ = capfd.readouterr().out.splitlines()
    (text,) = json.loads(written.read_text())["notes"]
    assert text.startswith("pendulum_simple: energy")
    assert "--max-seconds" in text
    assert note.endswith(text)
    assert "pendulum" in page.read_text().splitlines()[-1]
    gnomon(*words, "--claim", "step_order", "--json", str(written))
    assert json.loads(written.read_text())["notes"] == []

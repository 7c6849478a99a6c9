"""`gnomon show` prints a case."""

import sys
from pathlib import Path

import pytest
from command_line import gnomon

BRANCHES = """
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple

def equations(t, y, p):
    return (y[1], -y[0] if y[0] > 0 else y[0])

class Branches(PendulumSimple):
    name = "branches"
    forms = (FirstOrder(equations),)
"""


def test_show_prints_formulas_numbers_and_variants_and_the_source_if_asked(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    drawing = tmp_path / "motion.svg"
    assert gnomon("show", "pendulum_simple", "--set", "L=2", "--plot", str(drawing)) == 0
    text = capfd.readouterr().out
    for part in ("omega' = -g/L sin(theta)", "9.81", "period", "separatrix", "energy", "theta from the downward"):
        assert part in text
    assert "return" not in text
    assert drawing.read_text().startswith("<svg")
    assert gnomon("show", "--case", "pendulum_simple", "--source") == 0
    assert "return (-(g / length) * sin(theta),)" in capfd.readouterr().out


def test_events_are_formulas_too(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("show", "bouncing_ball") == 0
    text = capfd.readouterr().out
    for line in ("v' = -g", "bounce ends flight, as y falls to 0", "v -> -e v"):
        assert f"  {line}\n" in text


def test_equations_that_have_no_formula_are_shown_as_they_are_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "branches_of_a_user.py").write_text(BRANCHES)
    monkeypatch.syspath_prepend(tmp_path)
    assert gnomon("show", "branches_of_a_user:Branches") == 0
    assert "if y[0] > 0" in capfd.readouterr().out
    sys.modules.pop("branches_of_a_user")


def test_latex_prints_the_equations_alone(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("show", "pendulum_simple", "--latex") == 0
    assert capfd.readouterr().out.split("\n") == [
        r"\begin{aligned}", r"\dot\theta &= \omega \\", r"\dot\omega &= -\frac{g}{L} \sin\theta", r"\end{aligned}", "",
    ]  # fmt: skip
    assert gnomon("show", "bouncing_ball", "--latex") == 0
    assert "% mode flight\n" in capfd.readouterr().out

"""`gnomon show` prints a case."""

from pathlib import Path

import pytest
from command_line import gnomon


def test_show_prints_equations_numbers_and_variants(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    drawing = tmp_path / "motion.svg"
    assert gnomon("show", "pendulum_simple", "--set", "L=2", "--plot", str(drawing)) == 0
    text = capfd.readouterr().out
    for part in ("-(g / length) * sin(theta)", "9.81", "period", "separatrix", "energy", "theta from the downward"):
        assert part in text
    assert drawing.read_text().startswith("<svg")


def test_latex_prints_the_equations_alone(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("show", "pendulum_simple", "--latex") == 0
    assert capfd.readouterr().out.split() == [
        r"\begin{aligned}", r"\dot{\theta}", "&=", r"\omega", r"\\",
        r"\dot{\omega}", "&=", r"-\frac{g}{L}", r"\sin\left(\theta\right)", r"\end{aligned}",
    ]  # fmt: skip
    assert gnomon("show", "bouncing_ball", "--latex") == 0
    assert "% mode flight\n" in capfd.readouterr().out

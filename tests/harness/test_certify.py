"""Every exact motion is confirmed by independent ways, and a wrong one is not."""

from __future__ import annotations

import json
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from gnomon.cases import get, names
from gnomon.cases.forms import SecondOrder, Values
from gnomon.cases.pendulum import PendulumSimple
from gnomon.harness.certify import certify, write
from gnomon.reference.motion import Motion


@pytest.mark.parametrize("name", names())
def test_default_case_is_certified(name: str) -> None:
    certificate = certify(get(name))
    assert certificate.digits >= certificate.required, certificate
    assert certificate.passed, certificate


def wrong_sign(t: Any, q: Values, parameters: Values) -> Values:
    (theta,) = q
    g, length = parameters
    return (g / length * theta,)


class WrongEquations(PendulumSimple):
    """The exact motion of one system with the equations of another."""

    @property
    def forms(self) -> tuple[Any, ...]:
        return (SecondOrder(wrong_sign),)


class NearlyRight(PendulumSimple):
    """An exact motion with an error of 1e-20 of its size."""

    def motion(self) -> Motion:
        right = super().motion()

        class Off(Motion):
            def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
                theta, omega = right._state(mp, t)
                return theta + mp.mpf(t) * mp.mpf(10) ** -20, omega

            def _guard(self, t: Fraction) -> float:
                return right._guard(t)

        return Off()


def test_wrong_equations_show_in_residual_and_integration() -> None:
    ways = certify(WrongEquations(span=2)).ways
    assert ways["residual"] < 2
    assert ways["taylor"] < 2


def test_an_error_in_the_twentieth_digit_shows_in_every_independent_way() -> None:
    certificate = certify(NearlyRight(span=2))
    assert not certificate.passed
    assert 18 < certificate.ways["residual"] < 22
    assert 18 < certificate.ways["taylor"] < 22
    assert 18 < certificate.ways["invariants"] < 22


def test_certificates_are_written_for_the_report(tmp_path: Path) -> None:
    certificate = certify(get("projectile_parabola"))
    write([certificate], tmp_path / "certificates.json")
    (row,) = json.loads((tmp_path / "certificates.json").read_text())
    assert row["case"] == "projectile_parabola"
    assert row["passed"] is True

"""The measured order of every fixed-step method is the declared one, and a wrong coefficient does not pass."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gnomon.cases.case import Case
from gnomon.cases.registry import get
from gnomon.harness.integrators import explicit, gauss, splitting
from gnomon.harness.integrators.dop853 import rows
from gnomon.harness.integrators.explicit import RK4, RungeKutta
from gnomon.harness.integrators.fixed_step import FixedStep, Table
from gnomon.harness.integrators.gauss import Gauss4
from gnomon.harness.integrators.splitting import KahanLi6, KahanLi8, Yoshida8
from gnomon.harness.order import fit_order, measure_order, measure_order_exactly

METHODS = tuple(m for m in (*explicit.INTEGRATORS, *splitting.INTEGRATORS, *gauss.INTEGRATORS) if m.order <= 8)
WITHIN = 0.1
"""The next term of the error is smaller by a factor of the step: at the finest steps it bends the slope by less."""


class Dop853Step(RungeKutta):
    """The twelve stages of DOP853 at a fixed step, without the controller."""

    name, order = "DOP853 at a fixed step", 8

    @classmethod
    def coefficients(cls, mp: Any) -> Table:
        table = rows(mp)
        return [*table[:12], [mp.mpf(0), *table[12][1:]]]

    def rows(self, form: Any) -> int:
        return 12


class WrongWeight(RK4):
    """RK4 with one weight off by 1e-5."""

    weights = ("1/6", "0.333343", "1/3", "1/6")


class MistypedLength(KahanLi6):
    """Kahan-Li 6 with two digits of one length exchanged, an error of 1e-8: the sum is still 1."""

    half = (*KahanLi6.half[:1], "0.332599146789359438599748629305934", *KahanLi6.half[2:])


class MistypedBelowBinary64(KahanLi8):
    """Kahan-Li 8 with one length off by 1e-16, which its binary64 rounding hardly shows."""

    @classmethod
    def lengths(cls, mp: Any) -> list[Any]:
        first = [mp.mpf(text) for text in cls.half]
        first[2] += mp.mpf(10) ** -16
        return [*first, 1 - 2 * mp.fsum(first), *reversed(first)]


def pendulum(order: int) -> Case:
    """Long enough for steps at which a method of high order stands clear of round-off, short for the others."""
    return get("pendulum_simple", span=16 if order >= 8 else 8 if order >= 6 else 3)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_order_in_binary64(method: type[FixedStep]) -> None:
    assert method.order is not None
    measured = measure_order(method(), pendulum(method.order))
    assert measured is not None
    assert measured[1] >= 4
    assert measured[0] == pytest.approx(method.order, abs=WITHIN)


@pytest.mark.parametrize(
    ("method", "counts"),
    [
        (KahanLi8, (48, 64, 96, 128)),
        (Yoshida8, (96, 128, 192, 256)),
        (Gauss4, (48, 64, 96, 128)),
        # Its error of order 8 is so small that the next one hides it until steps are far below those of binary64.
        (Dop853Step, (768, 1024, 1536, 2048)),
    ],
)
def test_order_in_sixty_digits(method: type[FixedStep], counts: tuple[int, ...]) -> None:
    assert method.order is not None
    measured = measure_order_exactly(method(), get("pendulum_simple", span=3), counts)
    assert measured is not None
    assert measured[0] == pytest.approx(method.order, abs=WITHIN)


@pytest.mark.parametrize("method", [m for m in gauss.INTEGRATORS if m.order > 8], ids=lambda method: method.name)
def test_order_above_8(method: type[FixedStep]) -> None:
    """So short a span that one step is a few hundredths of a radian: the leading term rules."""
    measured = measure_order_exactly(method(), get("pendulum_simple", span="0.25"), (8, 12, 16, 24))
    assert measured is not None
    assert measured[0] == pytest.approx(method.order, abs=0.1)


@pytest.mark.parametrize("method", [WrongWeight, MistypedLength])
def test_a_planted_coefficient_is_caught(method: type[FixedStep]) -> None:
    assert method.order is not None
    measured = measure_order(method(), pendulum(method.order))
    assert measured is None or abs(measured[0] - method.order) > WITHIN


def test_a_planted_coefficient_below_binary64_is_caught_in_sixty_digits() -> None:
    measured = measure_order_exactly(MistypedBelowBinary64(), get("pendulum_simple", span=3), (768, 1024, 1536, 2048))
    assert measured is not None
    assert abs(measured[0] - 8) > WITHIN


def test_fit_needs_four_points_in_the_range() -> None:
    steps = [2.0**-k for k in range(10)]
    assert fit_order(steps, [h**3 for h in steps]) == (pytest.approx(3.0), 6)
    assert fit_order(steps[:5], [h**3 for h in steps[:5]]) is None, "only h = 1/8 and 1/16 lie below 1e-2"


def test_fit_stops_at_the_floor() -> None:
    steps = [2.0**-k for k in range(20)]
    errors = np.maximum([h**4 for h in steps], 1e-12)
    measured = fit_order(steps, errors.tolist(), floor=1e-12)
    assert measured is not None
    assert measured[0] == pytest.approx(4.0, abs=1e-9)
    assert fit_order(steps, [h**4 for h in steps], floor=1e-3) is None

"""Two blocks and a wall: Galperin's count, energy in rational numbers, and the order of the impacts."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from gnomon.reference.two_blocks import TwoBlocks


def made(ratio):
    return TwoBlocks(*map(Fraction, (1, ratio, 1, 2, 0, -1)))


@pytest.mark.parametrize(
    ("ratio", "count"), [(1, 3), (100, 31), (10**4, 314), (7, math.ceil(math.pi / math.atan(math.sqrt(1 / 7))) - 1)]
)
def test_count_is_galperins(ratio, count):
    assert made(ratio).impacts == count


def test_energy_is_exactly_constant_and_the_last_leg_separates():
    motion = made(100)
    assert {leg.v1**2 + 100 * leg.v2**2 for leg in motion.legs} == {Fraction(100)}
    assert all(0 <= leg.x1 <= leg.x2 for leg in motion.legs)
    last = motion.legs[-1]
    assert 0 <= last.v1 <= last.v2
    assert {a.name for a in motion.legs[1::2]} == {"blocks"}
    assert {a.name for a in motion.legs[2::2]} == {"wall"}


def test_state_between_and_at_an_impact():
    motion = made(1)
    assert motion.state("0.5") == (1, 1.5, 0, -1)
    assert motion.state(1) == (1, 1, -1, 0)
    assert motion.state(5) == (1, 3, 0, 1)

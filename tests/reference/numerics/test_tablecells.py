"""The cells of a table: their error bounds hold, and the gaps between them are narrow."""

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from gnomon.reference.flight.projectile_parabola import Projectile
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.tablecells import NARROWEST, TooExpensiveError, _divided, _long, build
from gnomon.reference.oscillators.damped_oscillator import DampedMotion
from gnomon.reference.pendulums.pendulum_simple import Pendulum
from hypothesis import given
from hypothesis import strategies as st

BUDGET = 3000
MOTIONS = {
    "swing": Pendulum(*map(exact, (9.81, 1, 2.5, 0))),
    "near the separatrix": Pendulum(*map(exact, (9.81, 9.81, 0, 1.999999))),
    "stiff": DampedMotion(*map(exact, (1, 10001, 10000, 1, 0))),
    "polynomial": Projectile(*map(exact, (9.81, 0, 1, 2, 3))),
}


def polynomial(coefficients, s):
    value = Fraction(0)
    for c in reversed(coefficients):
        value = value * s + c
    return value


@pytest.mark.parametrize("motion", [pytest.param(motion, id=name) for name, motion in MOTIONS.items()])
def test_the_error_of_every_polynomial_is_within_its_bound(motion):
    """At random places of random cells, in exact arithmetic, against states of 60 digits."""
    cells = build(motion, [(Fraction(0), Fraction(10))], BUDGET)
    source = np.random.default_rng(3)
    for i in source.integers(0, len(cells.edges), 25):
        place = Fraction(float(source.uniform(-1, 1)))
        centre = Fraction(cells.centres[i, 0]) + Fraction(cells.centres[i, 1])
        expected = motion.state(centre + place / (Fraction(cells.inverses[i, 0]) + Fraction(cells.inverses[i, 1])), 60)
        for d, x in enumerate(expected):
            powers = [Fraction(c) for c in cells.high[i, :, d]]
            for j, c in enumerate(cells.low[i, :, d]):
                powers[j] += Fraction(c)
            # The bound covers the kernel's rounding too, which is absent here.
            assert abs(polynomial(powers, place) - exact(x)) <= Fraction(cells.errors[i, d])


def test_a_polynomial_motion_keeps_no_more_powers_than_it_has():
    assert build(MOTIONS["polynomial"], [(Fraction(0), Fraction(10))], BUDGET).high.shape[1] <= 4


@dataclass(frozen=True)
class Kink(Motion):
    """Smooth except at one time, which is not among the breaks."""

    at: Fraction

    def _state(self, mp, t):
        return (mp.cos(mp.mpf(t)) if t < self.at else mp.sin(mp.mpf(t)),)


def test_a_kink_that_is_no_break_leaves_a_narrow_gap():
    kink, reach = Fraction(1, 3), Fraction(1)
    cells = build(Kink(kink), [(Fraction(0), reach)], BUDGET)
    halves = 1 / cells.inverses[:, 0]
    covered = np.minimum(cells.centres[:, 0] + halves, np.append(cells.edges[1:], 1.0)) - cells.edges
    assert 0 < 1 - covered.sum() <= 2 * NARROWEST
    assert not np.any((cells.centres[:, 0] - halves < kink) & (kink < cells.centres[:, 0] + halves))


def test_a_kink_that_is_a_break_needs_few_cells():
    kink = Fraction(float(1 / 3))
    pieces = [(Fraction(0), kink - Fraction(1, 2**54)), (kink + Fraction(1, 2**54), Fraction(1))]
    assert len(build(Kink(Fraction(1, 3)), pieces, 2000).edges) <= 8 * 9
    with pytest.raises(TooExpensiveError):
        build(Kink(Fraction(1, 3)), [(Fraction(0), Fraction(1))], 500)


@given(st.floats(0, 1e6), st.floats(1e-6, 1e6), st.integers(1, 40))
def test_cells_cover_a_piece_and_stay_within_it(start, length, count):
    """No time before an event is read from a state after it."""
    piece = Fraction(start), Fraction(start + length)
    cells = _divided(piece, (piece[1] - piece[0]) / count)
    assert len(cells) == count
    assert [cell[0] for cell in cells] == [piece[0], *(cell[1] for cell in cells[:-1])]
    assert cells[-1][1] == piece[1]


def test_only_the_shortest_pieces_are_left_out():
    """Impacts that accumulate: the lengths fall by a half each."""
    ends = [1 - Fraction(1, 2**k) for k in range(60)]
    pieces = list(pairwise(ends))
    kept = _long(pieces, Fraction(1))
    assert kept == pieces[: len(kept)]
    assert 0 < 1 - sum(b - a for a, b in kept) <= Fraction(1, 2**13)

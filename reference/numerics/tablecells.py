"""Building a table: polynomials through high-precision states of a motion, on cells as wide as the accuracy allows.

A cell's polynomial goes through 32 states near Chebyshev's points. Its error bound has two independent parts: the
residuals at five further states, and its last two Chebyshev coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import flint
import numpy as np
from gnomon.reference.numerics.balls import as_ball, ball, precision
from gnomon.reference.numerics.pointwise import SAMPLE_DIGITS, Floats, Pointwise

NODES = 32
BITS = 400
GOAL = 2.0**-78
"""A cell is accepted if its error bound is below this fraction of its size."""
SAFETY = 16
"""Factor on the largest of the five residuals: the error is largest near cell ends and between nodes."""
ROUNDED = 2.0**-128
"""The relative error of states of 40 digits, and of their interpolation."""
NEGLIGIBLE = 1e-28
"""A component this far below the state's size has no certified digits; cells are not refined for it."""
PARTS = 8
"""An accepted cell is divided into this many: their polynomials are shorter, and need no further states."""
LEAST_CELLS = 8
LEAST_DISTANCE = 3.2
"""A cell is accepted, with a margin, if the nearest singularity is this many half widths from its centre."""
NARROWEST = Fraction(1, 2**24)
"""Fraction of the reach: where a cell this narrow is not accepted, a gap is left; its times are computed one by one."""
LEFT_OUT = Fraction(1, 2**14)
"""Fraction of the reach: the shortest pieces of this total length are gaps too. Impacts accumulate before rest."""

Piece = tuple[Fraction, Fraction]


class Cells(NamedTuple):
    """Cell i starts at edges[i] and holds times with |s| <= 1; its polynomial is in powers of s = (t - centre) / half.

    `centres`, `inverses` (of half) and `low` continue in a second double; `high` is (cells, powers, dimension), `low`
    ends at lower powers. `errors` and `rates` (cells, dimension) bound the polynomial's error and derivative by time.
    """

    edges: Floats
    centres: Floats
    inverses: Floats
    high: Floats
    low: Floats
    errors: Floats
    rates: Floats


class TooExpensiveError(Exception):
    """A table would cost more states than it saves."""


class Fit(NamedTuple):
    """Coefficients (NODES, dimension) of powers and bounds of their errors; whether they are good enough.

    `away` is the distance from the centre to the nearest singularity, estimated from the errors, in half widths.
    """

    powers: Any
    errors: Floats
    good: bool
    away: float


def build(motion: Pointwise, pieces: Sequence[Piece], budget: int) -> Cells:
    """The cells of all pieces, from left to right; raises TooExpensiveError beyond `budget` states."""
    reach = pieces[-1][1] - pieces[0][0]
    width = longest = reach / LEAST_CELLS
    cells = []
    cost = 0
    for start, stop in _long(pieces, reach):
        trouble = start
        while start < stop:
            # Slightly wider, so that rounded widths leave no tiny rest, which would be halved again and again.
            left = math.ceil((stop - start) / width * Fraction(63, 64))
            tried = (stop - start) / left if left <= LEAST_CELLS else width
            end = start + tried
            cost += NODES + len(_checks())
            if cost > budget + NODES:
                raise TooExpensiveError
            fit = _fit(motion, (start + end) / 2, (end - start) / 2)
            if fit is not None and fit.good:
                cells += _cut(start, end, fit.powers, fit.errors)
                start = end
                # Not wider before the end of the last rejected cell.
                grown = min(4.0 if start >= trouble else 1.0, fit.away / LEAST_DISTANCE)
            else:
                trouble = end
                grown = 0.5 if fit is None else min(0.75, (fit.away + 1) / (LEAST_DISTANCE + 1))
                if end - start <= reach * NARROWEST:
                    start, grown = end, 1.0
            width = min(longest, _short(tried * Fraction(grown)))
    if not cells:
        raise TooExpensiveError
    return _trimmed(cells)


def _short(value: Fraction) -> Fraction:
    """A nearby number of few bits, so that the ends of cells have few bits."""
    mantissa, exponent = math.frexp(float(value))
    return Fraction(round(mantissa * 2**10), 2**10) * Fraction(2) ** exponent


def _long(pieces: Sequence[Piece], reach: Fraction) -> list[Piece]:
    """All pieces but the shortest."""
    longest, left_out = list(pieces), Fraction(0)
    for piece in sorted(pieces, key=lambda piece: piece[1] - piece[0]):
        left_out += piece[1] - piece[0]
        if left_out > reach * LEFT_OUT:
            break
        longest.remove(piece)
    return longest


def _divided(piece: Piece, longest: Fraction) -> list[Piece]:
    """A piece in equal cells, none longer than `longest`."""
    start, stop = piece
    count = math.ceil((stop - start) / longest)
    return list(pairwise([start + (stop - start) * k / count for k in range(count + 1)]))


def _fit(motion: Pointwise, centre: Fraction, half: Fraction) -> Fit | None:
    """The polynomials of a cell; None where the motion ends within it."""
    with precision(BITS):
        try:
            states = _states(motion, [centre + half * s for s in _nodes()])
            powers = _inverse() * states
            beside = _states(motion, [centre + half * s for s in _checks()])
        except (ValueError, ArithmeticError):
            return None
        missed = _sizes(_rows(_checks()) * powers - beside)
        sizes = np.maximum(_sizes(states), _sizes(beside))
        last = [
            abs(float(powers[NODES - 1 - k, d].mid())) * 2.0 ** (2 + k - NODES)
            for k in (0, 1)
            for d in range(len(sizes))
        ]
    errors = SAFETY * missed + np.sum(np.reshape(last, (2, -1)), axis=0) + ROUNDED * sizes
    matters = sizes > NEGLIGIBLE * np.max(sizes)
    off = float(np.max(errors[matters] / sizes[matters], initial=ROUNDED))
    # Chebyshev coefficients fall by `fall` each where an ellipse whose half axes add up to that times half the width
    # touches a singularity.
    fall = max(1.0, off ** (-1 / NODES)) if math.isfinite(off) else 1.0
    # Negligible components get a bound so large that they are computed in high precision; exact zeros stay.
    return Fit(powers, np.where(matters, errors, sizes), off <= GOAL, (fall + 1 / fall) / 2)


def _cut(start: Fraction, stop: Fraction, powers: Any, errors: Floats) -> list[tuple[Any, ...]]:
    """A good cell in PARTS: edge, centre, inverse of half, coefficients high and low, error."""
    cells = []
    for (begin, end), matrix in zip(_divided((start, stop), (stop - start) / PARTS), _shifts(), strict=True):
        with precision(BITS):
            middles = [[x.mid() for x in row] for row in (matrix * powers).tolist()]
            high = [[float(x) for x in row] for row in middles]
            low = [
                [float(x - y) for x, y in zip(row, tops, strict=True)] for row, tops in zip(middles, high, strict=True)
            ]
        cells.append((_from(begin), _two_parts((begin + end) / 2), _two_parts(2 / (end - begin)), high, low, errors))
    return cells


def _from(moment: Fraction) -> float:
    """The first double at or after a moment."""
    nearest = float(moment)
    return nearest if Fraction(nearest) >= moment else math.nextafter(nearest, math.inf)


def _two_parts(value: Fraction) -> tuple[float, float]:
    """As the unevaluated sum of two doubles."""
    first = float(value)
    return first, float(value - Fraction(first))


def _trimmed(cells: list[tuple[Any, ...]]) -> Cells:
    """The cells without negligible powers and low parts, which are added to the errors."""
    edges, centres, inverses, high, low, errors = (np.array(column) for column in zip(*cells, strict=True))
    parts = np.abs(high)
    rates = np.einsum("cjd,j->cd", parts, np.arange(float(NODES))) * inverses[:, :1]
    # beyond[:, j]: the sum of all from j on
    beyond = np.cumsum(np.pad(parts, ((0, 0), (0, 1), (0, 0)))[:, ::-1], axis=1)[:, ::-1]
    sizes = beyond[:, 0]
    count = _first(beyond <= np.maximum(errors, 2.0**-90 * sizes)[:, None])
    doubled = min(_first(beyond * 2.0**-51 <= np.maximum(errors, 2.0**-82 * sizes)[:, None]), count)
    errors = errors + beyond[:, count] + beyond[:, doubled] * 2.0**-51 + sizes * 2.0**-97
    high, low = (np.ascontiguousarray(x) for x in (high[:, :count], low[:, :doubled]))
    return Cells(edges, centres, inverses, high, low, errors, rates)


def _first(good: Any) -> int:
    """The first power, at least one, from which on `good` holds for all cells and components."""
    return max(1, int(np.argmax(np.all(good, axis=(0, 2)))))


def _states(motion: Pointwise, moments: Sequence[Fraction]) -> Any:
    return flint.arb_mat([[as_ball(x) for x in motion.state(t, SAMPLE_DIGITS)] for t in moments])


def _sizes(matrix: Any) -> Floats:
    """The largest magnitude in each column."""
    rows, columns = matrix.nrows(), matrix.ncols()
    return np.array([max(abs(float(matrix[i, d].mid())) for i in range(rows)) for d in range(columns)])


@cache
def _nodes() -> tuple[Fraction, ...]:
    """Chebyshev's points as short dyadic fractions, so that times are exact."""
    return tuple(Fraction(round(math.cos((2 * k + 1) * math.pi / (2 * NODES)) * 2**20), 2**20) for k in range(NODES))


@cache
def _checks() -> tuple[Fraction, ...]:
    """The ends of a cell, which show layers too thin for the nodes, and points between nodes."""
    nodes = _nodes()
    between = [(nodes[k] + nodes[k + 1]) / 2 for k in (0, NODES // 2 - 1, NODES - 2)]
    return (Fraction(-1), Fraction(1), *between)


def _rows(places: Sequence[Fraction]) -> Any:
    """The matrix from coefficients of powers to values."""
    return flint.arb_mat([[ball(s**j) for j in range(NODES)] for s in places])


@cache
def _inverse() -> Any:
    """The matrix from values at the nodes to coefficients of powers."""
    with precision(BITS):
        return _rows(_nodes()).inv()


@cache
def _shifts() -> list[Any]:
    """For each part of a cell, the matrix that makes its coefficients from the coefficients of the whole."""
    matrices = []
    for k in range(PARTS):
        centre = Fraction(2 * k + 1 - PARTS, PARTS)
        rows = [
            [centre ** (m - j) * math.comb(m, j) / PARTS**j if m >= j else Fraction(0) for m in range(NODES)]
            for j in range(NODES)
        ]
        with precision(BITS):
            matrices.append(flint.arb_mat([[ball(x) for x in row] for row in rows]))
    return matrices

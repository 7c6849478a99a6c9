"""Exact states at a million times in about a second: the motion as polynomials in double-double, cell by cell.

The cells are dyadic intervals of time, halved until a polynomial through high-precision states of the motion is good
to 2**-80 of its size; a motion that repeats itself needs the cells of one cycle only, and the phase of a time in it is
taken in double-double. Every value comes with a bound of its error. Where that bound leaves the nearest double in
doubt (Ziv, ACM TOMS 17, 1991), which happens next to zeros, the value is computed in high precision instead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import flint
import numpy as np
from gnomon.reference.diskcache import Entry, cached, fingerprint
from gnomon.reference.motion import SAMPLE_DIGITS, Cycle, Motion
from gnomon.reference.precision import exact, working
from gnomon.reference.tablekernel import evaluate, products
from numpy.typing import NDArray

Floats = NDArray[np.float64]
NODES = 32
DOUBLED = 20
"""Coefficients of this power and above are plain doubles: a cell is accepted only where they are small enough."""
SMALL = 2.0**-30
GOAL = 2.0**-83
BOUND = 2.0**-78
"""A cell's error over its size: GOAL is asked for where it is tested, BOUND covers rounding and the points between."""
NEGLIGIBLE = 1e-28
"""A component this far below the state's size has no certified digits; its cells are not refined for its sake."""
LEAST_CELLS = 8
CYCLE_DIGITS = 70
BUDGET = 8000
"""States that a table may cost where no more times than that are asked for; else as many as the times."""
MAX_TURNS = 10**7
BITS = 400


@dataclass(frozen=True)
class Cells:
    """Cell i is [edges[i], edges[i+1]]; coefficients (cells, dimension, NODES) of powers of s in [-1, 1], high and low.

    `errors` and `rates` (cells, dimension) bound the polynomial's error and derivative by time.
    """

    edges: Floats
    high: Floats
    low: Floats
    errors: Floats
    rates: Floats


def sample(motion: Motion, times: Floats) -> Floats:
    """The nearest doubles to the states at `times`, by a table where one is worth its cost."""
    times = np.ascontiguousarray(times, dtype=np.float64)
    cycle = cycle_of(motion)
    reach = float(np.max(np.abs(times), initial=0.0)) if cycle is None else float(cycle.period) * (1 + 2.0**-40)
    if reach == 0.0:
        return motion.sample_each(times)
    cells = _cells(motion, reach, max(BUDGET, len(times)), cycle is not None)
    turns = np.zeros(len(times)) if cycle is None else np.floor(times / float(cycle.period))
    if cells is None or np.ptp(turns) > MAX_TURNS:
        return motion.sample_each(times)
    dimension = cells.high.shape[1]
    values = np.empty((len(times), dimension))
    sure = np.empty(len(times), dtype=np.bool_)
    period = np.zeros(3) if cycle is None else _parts(cycle.period, 3)
    shift = np.zeros((dimension, 2)) if cycle is None else np.array([_parts(x, 2) for x in cycle.shift])
    factors = _powers(cycle, turns)
    evaluate(
        times, turns, factors, cells.edges, cells.high, cells.low, DOUBLED, cells.errors, cells.rates, period, shift,
        values, sure,
    )  # fmt: skip
    doubtful = np.flatnonzero(~sure)
    if len(doubtful):
        values[doubtful] = motion.sample_each(times[doubtful])
    return values


def cycle_of(motion: Motion) -> Cycle | None:
    """How the motion repeats itself, to 70 digits."""
    with working(CYCLE_DIGITS) as mp:
        return motion._cycle(mp)


def _parts(value: Any, count: int) -> Floats:
    """An mpf as the unevaluated sum of `count` doubles."""
    rest = exact(value)
    parts = []
    for _ in range(count):
        parts.append(float(rest))
        rest -= Fraction(parts[-1])
    return np.array(parts)


def _powers(cycle: Cycle | None, turns: Floats) -> Floats:
    """The cycle's factor to each whole number of turns from the least (at most 0) to the largest, as double-doubles."""
    if cycle is None or cycle.factor == 1:
        return np.empty((0, 2))
    first, last = min(0, int(turns.min())), int(turns.max())
    stride = math.isqrt(last - first) + 1
    with working(CYCLE_DIGITS) as mp:
        steps = np.array([_parts(mp.mpf(cycle.factor) ** n, 2) for n in range(stride)])
        blocks = np.array([_parts(mp.mpf(cycle.factor) ** n, 2) for n in range(first, last + 1, stride)])
    return np.asarray(products(blocks, steps))


_kept: dict[tuple[Motion, int, bool], Cells] = {}
_too_dear: dict[tuple[Motion, int, bool], int] = {}
"""The largest budget that was not enough."""


def _cells(motion: Motion, reach: float, budget: int, cyclic: bool) -> Cells | None:
    """The cells from 0 to `reach`, kept in memory and on disk; None where they cost more than `budget` states."""
    exponent = math.frexp(reach)[1]
    key = (motion, exponent, cyclic)
    if budget <= _too_dear.get(key, -1):
        return None
    if key not in _kept:
        name = f"table {motion!r} {exponent} {cyclic} {fingerprint('gnomon.reference')}"
        try:
            entry = cached(name, lambda: Entry(vars(_build(motion, reach if cyclic else 2.0**exponent, budget))))
        except _TooDearError:
            _too_dear[key] = budget
            return None
        _kept[key] = Cells(**entry.arrays)
    return _kept[key]


class _TooDearError(Exception):
    """A table would cost more states than it saves."""


def _build(motion: Motion, reach: float, budget: int) -> Cells:
    """Halve the dyadic interval that holds [0, reach] until every cell that begins before `reach` is accepted."""
    width = Fraction(2) ** math.frexp(reach)[1] / LEAST_CELLS
    waiting = [(k * width, width) for k in reversed(range(LEAST_CELLS))]
    edges, rows = [0.0], []
    cost = 0
    while waiting:
        start, width = waiting.pop()
        if start >= reach:
            continue
        cost += NODES + len(_checks())
        if cost > budget + NODES:
            raise _TooDearError
        row = _cell(motion, start + width / 2, width / 2)
        if row is None:
            waiting += [(start + width / 2, width / 2), (start, width / 2)]
        else:
            rows.append(row)
            edges.append(float(start + width))
    high, low, errors, rates = (np.array(column) for column in zip(*rows, strict=True))
    return Cells(np.array(edges), high, low, errors, rates)


def _cell(motion: Motion, centre: Fraction, half: Fraction) -> tuple[Floats, Floats, Floats, Floats] | None:
    """The polynomials of one cell, None where they are not good enough."""
    before, flint.ctx.prec = flint.ctx.prec, BITS
    try:
        states = [[exact(x) for x in motion.state(centre + half * s, SAMPLE_DIGITS)] for s in _nodes()]
        solved = _inverse() * flint.arb_mat([[_ball(x) for x in row] for row in states])
    finally:
        flint.ctx.prec = before
    dimension = len(states[0])
    powers = [[_middle(solved[j, d]) for j in range(NODES)] for d in range(dimension)]
    sizes = [max(abs(row[d]) for row in states) for d in range(dimension)]
    largest = max(sizes)
    matters = [d for d in range(dimension) if sizes[d] > Fraction(NEGLIGIBLE) * largest]
    if any(sum(map(abs, powers[d][DOUBLED:])) > Fraction(SMALL) * sizes[d] for d in matters):
        return None
    for s in _checks():
        truth = motion.state(centre + half * s, SAMPLE_DIGITS)
        for d in matters:
            found = Fraction(0)
            for power in reversed(powers[d]):
                found = found * s + power
            if abs(found - exact(truth[d])) > Fraction(GOAL) * sizes[d]:
                return None
    high = np.array([[float(x) for x in row] for row in powers])
    low = np.array([[float(x - Fraction(float(x))) for x in row] for row in powers])
    # What does not matter gets a bound that sends its values to high precision; an exact zero stays one.
    errors = np.array([float(sizes[d]) * (BOUND if d in matters else 1.0) for d in range(dimension)])
    rates = np.array([float(sum(j * abs(x) for j, x in enumerate(row)) / half) for row in powers])
    return high, low, errors, rates


@cache
def _nodes() -> tuple[Fraction, ...]:
    """Chebyshev's points as short dyadic fractions, so that times are exact."""
    return tuple(Fraction(round(math.cos((2 * k + 1) * math.pi / (2 * NODES)) * 2**20), 2**20) for k in range(NODES))


@cache
def _checks() -> tuple[Fraction, ...]:
    """The ends of a cell, where a layer too thin for the nodes shows, and points between nodes."""
    nodes = _nodes()
    between = [(nodes[k] + nodes[k + 1]) / 2 for k in (0, NODES // 2 - 1, NODES - 2)]
    return (Fraction(-1), Fraction(1), *between)


@cache
def _inverse() -> Any:
    """The matrix from values at the nodes to coefficients of powers."""
    return flint.arb_mat([[_ball(s**j) for j in range(NODES)] for s in _nodes()]).inv()


def _ball(value: Fraction) -> Any:
    return flint.arb(flint.fmpq(value.numerator, value.denominator))


def _middle(value: Any) -> Fraction:
    mantissa, exponent = value.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)

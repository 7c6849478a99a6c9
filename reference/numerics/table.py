"""Exact states at a million times in about a second: the motion as polynomials in double-double, cell by cell.

A motion that repeats itself needs the cells of one cycle only: the phase of a time is computed in double-double, and
the change over each cycle (a shift, a rotation, a decay) is applied afterwards. Every value has an error bound. Where
the bound does not prove 0.51 ulp (after Ziv, ACM TOMS 17, 1991), which happens next to zeros and in the gaps around
events, the value is computed in high precision instead.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import flint
import numpy as np
from gnomon.reference.numerics.balls import as_ball, precision
from gnomon.reference.numerics.pointwise import Cycle, Floats, Pointwise
from gnomon.reference.numerics.precision import exact, working
from gnomon.reference.numerics.tablecells import BITS, Cells, TooExpensiveError, build
from gnomon.reference.numerics.tablekernel import evaluate
from gnomon.reference.storage.diskcache import Entry, load, store_or_warn
from gnomon.reference.storage.import_closure import closure, modules_of

CYCLE_DIGITS = 70
BUDGET = 8000
"""States that a table may cost; as many as there are times, if these are more."""
MAX_TURNS = 10**7
OVERLAP = Fraction(1, 2**40)
"""The cells reach beyond a cycle by this fraction of it, because the cycle of a time is decided in doubles."""
TIE = Fraction(1, 10**19)
"""A relative error that covers breaks known to 20 digits."""


def sample(motion: Pointwise, times: Floats, span: float | None = None, breaks: Sequence[Any] = ()) -> Floats:
    """Doubles within 0.51 ulp of the states at `times`, by a table where that is faster."""
    times = np.ascontiguousarray(times, dtype=np.float64)
    farthest = float(exact(float(np.max(np.abs(times), initial=0.0)), "t"))
    cycle = cycle_of(motion)
    if cycle is not None and max(farthest, span or 0.0) < cycle.period / 2:
        cycle = None  # less than half a cycle: only that part is tabulated
    turns = np.zeros(len(times)) if cycle is None else np.floor(times / float(cycle.period))
    if farthest == 0.0 or np.ptp(turns) > MAX_TURNS:
        return motion.sample_each(times)
    cells = _cells(motion, _pieces(cycle, farthest, span, breaks), max(BUDGET, len(times)))
    if cells is None:
        return motion.sample_each(times)
    dimension = cells.high.shape[2]
    values = np.zeros((len(times), dimension))
    proved = np.empty(len(times), dtype=np.bool_)
    period = np.zeros(3) if cycle is None else _parts(cycle.period, 3)
    shift = np.zeros((dimension, 2)) if cycle is None else np.array([_parts(x, 2) for x in cycle.shift])
    evaluate(times, turns, *cells, period, shift, *_powers(cycle, turns), values, proved)
    doubtful = np.flatnonzero(~proved)
    if len(doubtful):
        values[doubtful] = motion.sample_each(times[doubtful])
    return values


def cycle_of(motion: Pointwise) -> Cycle | None:
    """How the motion repeats itself, to 70 digits."""
    with working(CYCLE_DIGITS) as mp:
        return motion._cycle(mp)


Piece = tuple[Fraction, Fraction]


def _pieces(cycle: Cycle | None, farthest: float, span: float | None, breaks: Sequence[Any]) -> tuple[Piece, ...]:
    """The intervals of a table: those between the breaks, with doubles as ends."""
    if cycle is not None:
        period = Fraction(float(cycle.period))
        first, last = -period * OVERLAP, period * (1 + OVERLAP)
    elif span is not None and farthest <= span:
        first, last = Fraction(0), Fraction(span)
    else:  # up to a power of two, so that tables are used again
        first, last = Fraction(0), Fraction(2) ** math.frexp(farthest)[1]
    pieces = []
    for moment in breaks:
        if not first < exact(moment) < last:
            continue
        pieces.append((first, _double(exact(moment) * (1 - TIE), -math.inf)))
        first = _double(exact(moment) * (1 + TIE), math.inf)
    return tuple((a, b) for a, b in (*pieces, (first, last)) if a < b)


def _double(value: Fraction, toward: float) -> Fraction:
    """The double next to `value`, below or above it."""
    nearest = float(value)
    on_the_side = Fraction(nearest) <= value if toward < 0 else Fraction(nearest) >= value
    return Fraction(nearest if on_the_side else math.nextafter(nearest, toward))


_kept: dict[tuple[Pointwise, tuple[Piece, ...]], Cells] = {}
_too_expensive: dict[tuple[Pointwise, tuple[Piece, ...]], int] = {}
"""The largest budget that was not enough."""


def _cells(motion: Pointwise, pieces: tuple[Piece, ...], budget: int) -> Cells | None:
    """The cells of the pieces, kept in memory and on disk; None where they cost more than `budget` states."""
    key = (motion, pieces)
    if key in _kept:
        return _kept[key]
    sources = closure(__name__, *modules_of(motion))
    name = f"table {motion!r} {[(str(a), str(b)) for a, b in pieces]} {sources}"
    if sources is not None and key not in _too_expensive:
        entry = load(name)
        if entry is not None and entry.arrays:
            return _kept.setdefault(key, Cells(**entry.arrays))
        if entry is not None:
            _too_expensive[key] = int(entry.notes)
    if budget <= _too_expensive.get(key, 0):
        return None
    try:
        _kept[key] = build(motion, pieces, budget)
    except TooExpensiveError:
        _too_expensive[key] = budget
        if sources is not None:
            store_or_warn(name, Entry(notes=budget))
        return None
    if sources is not None:
        store_or_warn(name, Entry(_kept[key]._asdict()))
    return _kept[key]


def _parts(value: Any, count: int) -> Floats:
    """An mpf as the unevaluated sum of `count` doubles."""
    rest = exact(value)
    parts = []
    for _ in range(count):
        parts.append(float(rest))
        rest -= Fraction(parts[-1])
    return np.array(parts)


def _powers(cycle: Cycle | None, turns: Floats) -> tuple[Floats, Floats, Any]:
    """`blocks`, `steps` and `groups` of the kernel: the powers of the cycle's turns, in double-double."""
    stages = [] if cycle is None else cycle.turns
    first, last = (min(0, int(turns.min())), int(turns.max())) if stages else (0, 0)
    stride = math.isqrt(last - first) + 1
    size = max((len(stage.matrix) for stage in stages), default=1)
    most = max((len(stage.groups) for stage in stages), default=1)
    blocks = np.zeros((len(stages), (last - first) // stride + 1, size, size, 2))
    steps = np.zeros((len(stages), stride, size, size, 2))
    groups = np.full((len(stages), most, size), -1, dtype=np.int64)
    with working(CYCLE_DIGITS) as mp, precision(BITS):
        for k, stage in enumerate(stages):
            own = len(stage.matrix)
            matrix = mp.matrix(stage.matrix)
            for into, start, ratio in ((steps[k], 0, matrix), (blocks[k], first, matrix**stride)):
                power, factor = (flint.arb_mat(own, own, [as_ball(x) for x in m]) for m in (matrix**start, ratio))
                for place in into:
                    place[:own, :own] = [[_two_parts(x.mid()) for x in row] for row in power.tolist()]
                    power = power * factor
            for row, group in zip(groups[k], stage.groups, strict=False):
                row[:own] = group
    return blocks, steps, groups


def _two_parts(value: Any) -> tuple[float, float]:
    """An exact ball as the unevaluated sum of two doubles."""
    first = float(value)
    return first, float(value - first)

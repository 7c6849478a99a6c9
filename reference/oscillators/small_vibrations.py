"""Small vibrations of masses joined by springs and dampers: M q'' + C q' + K q = 0.

The motion is the matrix exponential of its first-order form. Coincident frequencies, zero modes and defective damping,
where a sum of modes divides by differences of rates, are therefore no special cases.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import dyadic, precision
from gnomon.reference.numerics.linear import LinearMotion, Row
from gnomon.reference.numerics.precision import publish, working

Matrix = tuple[tuple[Fraction, ...], ...]


def chain(ground: Sequence[Fraction], couplings: Sequence[Fraction]) -> Matrix:
    """The symmetric matrix of a row of masses, each coupled to the ground and to its next neighbour."""
    size = len(ground)
    rows = [[Fraction(0)] * size for _ in range(size)]
    for i, k in enumerate(ground):
        rows[i][i] += k
    for i, k in enumerate(couplings):
        rows[i][i] += k
        rows[i + 1][i + 1] += k
        rows[i][i + 1] -= k
        rows[i + 1][i] -= k
    return tuple(map(tuple, rows))


@dataclass(frozen=True)
class Vibrations(LinearMotion):
    """State (q..., q'...) of the masses; K and C row by row."""

    masses: tuple[Fraction, ...]
    stiffness: Matrix
    damping: Matrix
    positions: tuple[Fraction, ...]
    velocities: tuple[Fraction, ...]

    @property
    def dimension(self) -> int:  # type: ignore[override]
        return 2 * len(self.masses)

    def _system(self) -> tuple[Sequence[Row], Row]:
        return self._rows(), (*self.positions, *self.velocities)

    def _rows(self) -> list[list[Fraction]]:
        size = len(self.masses)
        unit = [[Fraction(0)] * size + [Fraction(int(i == j)) for j in range(size)] for i in range(size)]
        pulls = [
            [-k / m for k in springs] + [-c / m for c in dampers]
            for m, springs, dampers in zip(self.masses, self.stiffness, self.damping, strict=True)
        ]
        return unit + pulls

    def _rate(self) -> float:
        return max(float(frequency) for _, frequency in self.rates())

    def frequencies(self, digits: int = 15) -> tuple[Any, ...]:
        """Undamped angular frequencies (rad/s), the lowest first: the roots of det(K - w^2 M), zeros included."""
        rows = [[k / m for k in springs] for m, springs in zip(self.masses, self.stiffness, strict=True)]
        with working(digits + 10) as mp:
            squares = sorted(mp.mpf(x.real) for x in self._roots(mp, rows))
            return publish((mp.sqrt(max(w2, mp.zero)) for w2 in squares), digits)

    def rates(self, digits: int = 15) -> tuple[tuple[Any, Any], ...]:
        """(decay, angular frequency) of each mode, the slowest decay first; a pair of conjugates is one mode."""
        with working(digits + 10) as mp:
            roots = [r for r in self._roots(mp, self._rows()) if r.imag >= 0]
            pairs = sorted((-r.real, r.imag) for r in roots)
            return tuple((publish([a], digits)[0], publish([b], digits)[0]) for a, b in pairs)

    def _roots(self, mp: Any, rows: Sequence[Sequence[Fraction]]) -> list[Any]:
        """The eigenvalues with their multiplicity, isolated as roots of the exact characteristic polynomial."""
        size = len(rows)
        entries = [flint.fmpq(x.numerator, x.denominator) for row in rows for x in row]
        with precision(mp.prec + 30):
            roots = flint.fmpq_mat(size, size, entries).charpoly().complex_roots()
            return [
                mp.mpc(mp.mpf(dyadic(root.real)), mp.mpf(dyadic(root.imag)))
                for root, times in roots
                for _ in range(times)
            ]

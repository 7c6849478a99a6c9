"""A solution between its samples: polynomials through states of the method, whose error is estimated."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from gnomon.harness.contract.integrator import Floats

NODES = 16
"""States of the method for each polynomial, at Chebyshev's points, which leave out the ends."""
CHECKS, SAFETY = (-0.999, -0.61, -0.02, 0.55, 0.999), 2.0
"""The error of a polynomial on [-1, 1] is SAFETY times the largest of its errors at CHECKS."""
FIRST, MOST_HALVINGS = 8, 10
"""Polynomials of the first attempt over the whole span; halvings of each where its error is too large."""
SHORTEST = 1e-10
"""Pieces shorter than this share of the span, between accumulating events, are left out."""

POINTS = -np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
SAMPLED = np.sort([*POINTS, *CHECKS])
IS_NODE = np.isin(SAMPLED, POINTS)
TO_COEFFICIENTS = np.linalg.inv(np.polynomial.chebyshev.chebvander(POINTS, NODES - 1))
AT_CHECKS = np.polynomial.chebyshev.chebvander(np.array(CHECKS), NODES - 1)


@dataclass
class DenseSolution:
    """A solution at any time of its span, as SciPy's `OdeSolution`: a function of one time or of an array of times.

    Attributes
    ----------
    ends : ndarray, shape (m + 1,)
        The ends of the polynomials, ascending. At an event that changes the state it has the state before.
    error : float
        The estimated error of the polynomials against the states of the method, over the size of each component.

    Examples
    --------
    >>> import math
    >>> from gnomon import solve
    >>> sol = solve(lambda t, y: -y, (0, 1), [1.0], dense_output=True).sol
    >>> sol(0.5).round(8), sol([0.0, 1.0]).shape, sol.error < 1e-9
    (array([0.60653066]), (1, 2), True)
    """

    ends: Floats
    error: float
    _coefficients: Floats = field(repr=False)
    """Shape (m, NODES, dim)."""

    @property
    def t_min(self) -> float:
        return float(self.ends[0])

    @property
    def t_max(self) -> float:
        return float(self.ends[-1])

    def __call__(self, t: float | Sequence[float] | Floats) -> Floats:
        """The states (dim,) at one time, or (dim, n) at n times. Raises ValueError for a time outside of the span."""
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        if times.ndim != 1 or not np.all((times >= self.t_min) & (times <= self.t_max)):
            raise ValueError(f"sol({t!r}): give times from {self.t_min:g} to {self.t_max:g}")
        which = np.clip(np.searchsorted(self.ends, times, "left") - 1, 0, len(self._coefficients) - 1)
        low, high = self.ends[which], self.ends[which + 1]
        basis = np.polynomial.chebyshev.chebvander((2 * times - low - high) / (high - low), NODES - 1)
        values: Floats = np.einsum("tk,tkd->dt", basis, self._coefficients[which])
        return values[:, 0] if np.ndim(t) == 0 else values


def interpolate(
    states_at: Callable[[Floats], Floats], bounds: Sequence[float], sizes: Floats, tolerance: float, halvings: int
) -> DenseSolution:
    """Halve polynomials until their error is below `tolerance` times `sizes`, but each at most `halvings` times.

    `states_at` gives the states (n, dim) of the method at times from the first bound to the last, by a new integration.
    """
    direction = 1.0 if bounds[-1] > bounds[0] else -1.0
    span = abs(bounds[-1] - bounds[0])
    knots = [bounds[0]]
    for end in bounds[1:]:
        if abs(end - knots[-1]) > SHORTEST * span:
            knots.append(end)
    knots[-1] = bounds[-1]
    waiting = []
    for low, high in pairwise(knots):
        cuts = np.linspace(low, high, 1 + max(1, round(FIRST * abs(high - low) / span)))
        waiting += list(zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True))
    pieces: list[tuple[float, float, Floats]] = []
    worst = 0.0
    for halving in range(halvings + 1):
        pairs = np.array(waiting)
        times = (pairs.mean(axis=1)[:, None] + (pairs[:, 1] - pairs[:, 0])[:, None] / 2 * SAMPLED).ravel()
        states = states_at(times).reshape(len(waiting), len(SAMPLED), -1)
        coefficients = np.einsum("kn,pnd->pkd", TO_COEFFICIENTS, states[:, IS_NODE])
        wrong = np.einsum("cn,pnd->pcd", AT_CHECKS, coefficients) - states[:, ~IS_NODE]
        errors = SAFETY * (np.abs(wrong).max(axis=1) / sizes).max(axis=1)
        again = []
        for (low, high), each, error in zip(waiting, coefficients, errors, strict=True):
            if error <= tolerance or halving == halvings:
                pieces.append((low, high, each))
                worst = max(worst, float(error))
            else:
                again += [(low, (low + high) / 2), ((low + high) / 2, high)]
        waiting = again
        if not waiting:
            break
    if direction < 0:  # a polynomial backward in time: odd coefficients change their sign
        signs = (-1.0) ** np.arange(NODES)[:, None]
        pieces = [(high, low, signs * each) for low, high, each in pieces]
    pieces.sort(key=lambda each: each[0])
    return DenseSolution(
        np.array([pieces[0][0], *(high for _, high, _ in pieces)]), worst, np.array([each for *_, each in pieces])
    )

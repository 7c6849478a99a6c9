"""The growth of an error from one time of an exact motion to a later one."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.accuracy import DIGITS
from gnomon.reference.numerics.certified import CertifiedMotion
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SMALL = 2.0**-40
"""Relative change of a component. It may be small, because exact motions are subtracted in high precision."""


def growth(case: Case, times: Floats, sizes: Floats) -> Floats | None:
    """The largest growth of an error from the start, or from an earlier time, to each time, shape (len(times),).

    An error has the norm 1 in components over their `sizes` (dim,), and its effect is measured by the case's metric.
    With the fundamental solution F(t) of the variational equations, F(t) F(s)^-1 carries an error from s to t; the
    columns of F are differences of exact motions. None if no start near the case's own exists (constraints), if an
    event lies between, or if the exact motion is integrated, which takes too long.
    """
    if case.hybrid is not None or isinstance(case.motion(), CertifiedMotion):
        return None
    moments = [Fraction(t) for t in times.tolist()]
    own = [case.exact(moment, DIGITS) for moment in moments]
    columns = [_column(case, moments, own, index, float(size)) for index, size in enumerate(sizes)]
    if any(column is None for column in columns):
        return None
    carried = np.concatenate([np.eye(len(sizes))[None], np.stack(columns, axis=2) / sizes[:, None]])  # type: ignore[arg-type]
    groups = [list(group.indices) for group in case.metric.groups if group.scored]
    largest = np.ones(len(times))
    for k in range(1, len(carried)):
        try:
            ways = np.linalg.solve(carried[:k].transpose(0, 2, 1), carried[k].T).transpose(0, 2, 1)
        except np.linalg.LinAlgError:  # a motion that has ended: earlier errors have no effect
            return None
        largest[k - 1] = max(1.0, *(float(np.max(np.linalg.norm(ways[:, group], 2, axis=(1, 2)))) for group in groups))
    return largest


def _column(
    case: Case, moments: Sequence[Fraction], own: Sequence[Sequence[Any]], index: int, size: float
) -> Floats | None:
    """The change of the states, shape (len(moments), dim), over the relative change of one component of the start."""
    change = Fraction(size * SMALL)
    for sign in (1, -1):
        start = list(case.initial_state)
        start[index] += sign * change
        try:
            moved = case.with_numbers(start, case.parameters)
        except ValueError:  # outside the domain: the other side may be inside
            continue
        others = [moved.exact(moment, DIGITS) for moment in moments]
        rows = [[float(x - y) for x, y in zip(a, b, strict=True)] for a, b in zip(others, own, strict=True)]
        return np.array(rows) / (sign * SMALL)
    return None

"""Small dense linear systems, real or complex, without allocation: what compiled implicit methods solve."""

from __future__ import annotations

from typing import Any


def factor(a: Any, pivots: Any) -> bool:
    """LU factors of `a` in its place, rows exchanged (Golub and Van Loan, algorithm 3.4.1); False if singular.

    Written to give False, too, where a number is not finite.
    """
    n = pivots.size
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        pivots[k] = best
        if not 0.0 < abs(a[best, k]) < 1e300:
            return False
        for j in range(n):
            a[k, j], a[best, j] = a[best, j], a[k, j]
        for i in range(k + 1, n):
            a[i, k] = a[i, k] / a[k, k]
            for j in range(k + 1, n):
                a[i, j] -= a[i, k] * a[k, j]
    return True


def substitute(a: Any, pivots: Any, b: Any) -> None:
    """The solution of the factored system in the place of the right side `b`."""
    n = pivots.size
    # All exchanges first: `factor` exchanged the multipliers of earlier columns, too.
    for k in range(n):
        best = int(pivots[k])
        b[k], b[best] = b[best], b[k]
    for k in range(n):
        for i in range(k + 1, n):
            b[i] -= a[i, k] * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= a[k, j] * b[j]
        b[k] = b[k] / a[k, k]

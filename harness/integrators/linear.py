"""Small dense linear systems, real or complex, without allocation: what compiled implicit methods solve."""

from __future__ import annotations

from typing import Any


def factor(a: Any, pivots: Any) -> bool:
    """LU factors of `a` in its place, rows exchanged (Golub and Van Loan, algorithm 3.4.1); False if singular.

    The diagonal holds reciprocals: several right sides are solved for, and a complex division is as dear as all the rest.
    Written to give False, too, where a number is not finite.
    """
    n = pivots.size
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if magnitude(a[i, k]) > magnitude(a[best, k]):
                best = i
        pivots[k] = best
        if not 0.0 < magnitude(a[best, k]) < 1e300:
            return False
        for j in range(n):
            a[k, j], a[best, j] = a[best, j], a[k, j]
        a[k, k] = 1.0 / a[k, k]
        for i in range(k + 1, n):
            a[i, k] = a[i, k] * a[k, k]
            for j in range(k + 1, n):
                a[i, j] -= a[i, k] * a[k, j]
    return True


def magnitude(x: Any) -> Any:
    """|Re x| + |Im x|: what LAPACK, too, chooses pivots by."""
    return abs(x.real) + abs(x.imag)


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
        b[k] = b[k] * a[k, k]

"""Small dense linear systems, real or complex, without allocation: what compiled implicit methods solve."""

from __future__ import annotations

from typing import Any

DIMENSION = 0
"""Of each problem, where a method is compiled for one dimension; 0 where the systems say how large they are."""

LEAST, MOST = 1e-150, 1e150
"""Between these a pivot has a square: what is smaller is singular, what is larger has overflowed."""


def factor(a: Any, pivots: Any) -> bool:
    """LU factors of `a` in its place, rows exchanged (Golub and Van Loan, algorithm 3.4.1); False if singular.

    The diagonal holds reciprocals, made with one division of real numbers: several right sides are solved for, and each
    next column waits for its pivot's. Where no rows are exchanged nothing is moved: the processor foresees that, and need
    not wait for where the rows stand.
    Written to give False, too, where a number is not finite.
    """
    n = DIMENSION or pivots.size
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if magnitude(a[i, k]) > magnitude(a[best, k]):
                best = i
        pivots[k] = best
        if not LEAST < magnitude(a[best, k]) < MOST:
            return False
        if best != k:
            for j in range(n):
                a[k, j], a[best, j] = a[best, j], a[k, j]
        pivot = a[k, k]
        # Twice the real part less the number is its conjugate, whatever kind of number it is.
        a[k, k] = (2.0 * pivot.real - pivot) * (1.0 / (pivot.real * pivot.real + pivot.imag * pivot.imag))
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
    n = DIMENSION or pivots.size
    # All exchanges first: `factor` exchanged the multipliers of earlier columns, too.
    for k in range(n):
        best = int(pivots[k])
        if best != k:
            b[k], b[best] = b[best], b[k]
    for k in range(n):
        for i in range(k + 1, n):
            b[i] -= a[i, k] * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= a[k, j] * b[j]
        b[k] = b[k] * a[k, k]

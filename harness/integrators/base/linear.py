"""Small dense linear systems, real or complex, solved without allocation, for compiled implicit methods."""

from typing import Any

DIMENSION = 0
"""Set when a method is compiled for the dimension of one problem; 0: the arrays give the size."""

LEAST, MOST = 1e-150, 1e150
"""Limits of a pivot: its square must neither underflow nor overflow. Beyond them the matrix counts as singular."""


def factor(a: Any, pivots: Any) -> bool:
    """LU factors of `a` in place, with exchange of rows (Golub and Van Loan, algorithm 3.4.1); False if singular.

    The diagonal holds reciprocals, each from one division of real numbers: several right sides use them, and each
    column waits for the pivot before it. Rows are exchanged in a branch, not by an index: the processor predicts the
    branch and does not wait for the index. Returns False also if a number is not finite.
    """
    n = DIMENSION or pivots.size
    for k in range(n):
        best, most = k, magnitude(a[k, k])
        for i in range(k + 1, n):
            size = magnitude(a[i, k])
            if size > most:
                best, most = i, size
        pivots[k] = best
        if not LEAST < most < MOST:
            return False
        if best != k:
            upper, lower = a[k], a[best]
            for j in range(n):
                upper[j], lower[j] = lower[j], upper[j]
        pivot = a[k, k]
        # Twice the real part minus the number is its conjugate, for real and complex types.
        a[k, k] = (2.0 * pivot.real - pivot) * (1.0 / (pivot.real * pivot.real + pivot.imag * pivot.imag))
        for i in range(k + 1, n):
            a[i, k] = a[i, k] * a[k, k]
            for j in range(k + 1, n):
                a[i, j] -= a[i, k] * a[k, j]
    return True


def magnitude(x: Any) -> Any:
    """|Re x| + |Im x|, by which LAPACK also chooses pivots."""
    return abs(x.real) + abs(x.imag)


def substitute(a: Any, pivots: Any, b: Any) -> None:
    """Solve the factored system; the solution replaces the right side `b`."""
    n = DIMENSION or pivots.size
    # All exchanges come first, because `factor` exchanged the multipliers of earlier columns, too.
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

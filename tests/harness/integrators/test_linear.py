"""Small dense systems solved in place: rows are exchanged, and what is singular or not finite is noticed."""

from __future__ import annotations

import numpy as np
import pytest
from gnomon.harness.integrators.linear import factor, substitute


@pytest.mark.parametrize("unit", [1, 1j, 0.6 + 0.8j])
@pytest.mark.parametrize("n", [1, 2, 3, 5, 8])
def test_systems_are_solved_whatever_rows_are_exchanged(n: int, unit: complex) -> None:
    """Real, imaginary and complex ones: a pivot may have no real part."""
    random = np.random.default_rng(n)
    exchanged = 0
    for _ in range(20):
        matrix, right = unit * random.normal(size=(n, n)), random.normal(size=n) * np.conj(unit)
        if unit.real and unit.imag:
            matrix += random.normal(size=(n, n))
        factors, pivots, found = matrix.copy(), np.zeros(n, dtype=np.int64), right.copy()
        assert factor(factors, pivots)
        substitute(factors, pivots, found)
        exchanged += int(np.sum(pivots != np.arange(n)))
        # Partial pivoting is backward stable: n^2 roundings of products of factors and solution.
        assert np.max(np.abs(matrix @ found - right)) < 1e-15 * n**2 * np.max(np.abs(matrix)) * np.max(np.abs(found))
    assert n == 1 or exchanged > 5


@pytest.mark.parametrize("value", [0.0, np.nan, np.inf])
def test_singular_and_not_finite_are_noticed(value: float) -> None:
    matrix = np.array([[1.0, 2.0], [2.0, 4.0]]) if value == 0.0 else np.full((2, 2), value)
    assert not factor(matrix, np.zeros(2, dtype=np.int64))

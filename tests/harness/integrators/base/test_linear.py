"""Small dense systems solved in place: rows are exchanged; singular and not finite matrices are detected."""

import numpy as np
import pytest
from gnomon.harness.integrators.base.linear import factor, substitute


@pytest.mark.parametrize("unit", [1, 1j, 0.6 + 0.8j])
@pytest.mark.parametrize("n", [1, 2, 3, 5, 8])
def test_systems_are_solved_with_any_exchange_of_rows(n: int, unit: complex) -> None:
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
def test_singular_and_not_finite_matrices_are_detected(value: float) -> None:
    matrix = np.array([[1.0, 2.0], [2.0, 4.0]]) if value == 0.0 else np.full((2, 2), value)
    assert not factor(matrix, np.zeros(2, dtype=np.int64))


@pytest.mark.parametrize("kind", [np.float64, np.complex128])
def test_the_size_of_the_numbers_does_not_matter_until_squares_overflow(kind: type) -> None:
    matrix = np.array([[2.0, 1.0, 0.5], [1.0, 3.0, 1.0], [0.25, 1.0, 4.0]]).astype(kind)
    if kind is np.complex128:
        matrix += 1j * np.eye(3)
    for exponent, solved in ((-480, True), (480, True), (-510, False), (510, False)):
        factors, pivots, found = matrix * 2.0**exponent, np.zeros(3, dtype=np.int64), matrix @ np.ones(3)
        assert factor(factors, pivots) is solved
        if solved:
            substitute(factors, pivots, found)
            # A power of two as factor does not change the arithmetic: a few roundings of a well-conditioned system.
            assert np.max(np.abs(found * 2.0**exponent - 1)) < 1e-14

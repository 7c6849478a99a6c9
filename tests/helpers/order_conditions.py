"""The order conditions of Runge-Kutta and Nyström methods, over all rooted trees up to an order.

Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.2 and II.14; a tree is the tuple of its branches.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from itertools import combinations_with_replacement
from math import prod
from typing import Any

import numpy as np
from gnomon.harness.integrators.base.tableau import ButcherTableau, full

Tree = tuple[Any, ...]
LEAF = ("velocity",)
"""In the trees of q'' = a(q): a branch that is the derivative q' alone, of order 1."""


def formulas(mp: Any, tableau: ButcherTableau) -> Iterator[tuple[int, Any, list[Any]]]:
    """(order, matrix, weights) of a method and of its embedded formulas, over the slope at the end of the step and the extra
    stages too where it has errors."""
    table = tableau.rows(mp)
    width = len(table[0]) - 1
    a = matrix(mp, [row[1:] for row in table[:width]])
    errors = [full(mp, row, width) for row in ({}, *tableau.errors)]
    for order, error in zip(tableau.orders, errors, strict=True):
        yield order, a, [b - e for b, e in zip(full(mp, tableau.b, width), error, strict=True)]


def has_order(residuals: Iterator[tuple[int, Any]], order: int, below: float) -> bool:
    """Whether all conditions up to `order` hold to `below`, and one of the next order does not."""
    for n, value in residuals:
        if n <= order and abs(value) >= below:
            return False
        if n > order and abs(value) > 1e-9:
            return True
    return False


def rk_residuals(a: Any, weights: Sequence[Any], order: int, at: Any) -> Iterator[tuple[int, Any]]:
    """(order of the tree, sum of b_i Phi_i minus at^order / gamma) for every rooted tree up to an order.

    `a`: an object array (s, s); `weights`: of the interpolant at the fraction `at` of the step, of the step itself at 1; `at`
    is a number of the context, as the others, so that no residual is rounded to binary64.
    """
    one = np.full(len(weights), at**0, dtype=object)
    vectors: dict[Tree, Any] = {}

    def vector(tree: Tree) -> Any:
        if tree not in vectors:
            vectors[tree] = prod((a.dot(vector(branch)) for branch in tree), start=one)
        return vectors[tree]

    for n in range(1, order + 1):
        for tree in trees(n):
            yield n, np.dot(np.array(weights, dtype=object), vector(tree)) - at**n / (at**0 * density(tree))


def nystrom_residuals(
    a: Any, c: Sequence[Any], positions: Sequence[Any], velocities: Sequence[Any], order: int
) -> Iterator[tuple[int, Any]]:
    """(order, residual) of the conditions on the velocity and on the position, for q'' = a(q), up to an order.

    `a`: the matrix of the Nyström method, `positions` and `velocities` its weights b and b'.
    """
    b, d = np.array(positions, dtype=object), np.array(velocities, dtype=object)
    nodes, one = np.array(c, dtype=object), np.array(c, dtype=object) * 0 + 1
    vectors: dict[Tree, Any] = {}

    def vector(tree: Tree) -> Any:
        if tree not in vectors:
            factors = [nodes if branch == LEAF else a.dot(vector(branch)) for branch in tree]
            vectors[tree] = prod(factors, start=one)
        return vectors[tree]

    for n in range(1, order + 1):
        for tree in nystrom_trees(n):
            found, density_of = vector(tree), nystrom_density(tree)
            yield n, d.dot(found) - one[0] / density_of
            if n < order:
                yield n + 1, b.dot(found) - one[0] / ((n + 1) * density_of)


@cache
def trees(order: int) -> tuple[Tree, ...]:
    """All rooted trees with `order` vertices: 1, 1, 2, 4, 9, 20, 48, 115, 286, ..."""
    return _forests(order - 1, order - 1, lambda size: trees(size))


@cache
def nystrom_trees(order: int) -> tuple[Tree, ...]:
    """All trees of q'' = a(q) of an order: a branch is q' alone, or q' over one more a: 1, 1, 2, 3, 6, 10, 20, 36, ..."""
    return _forests(order - 1, order - 1, lambda size: (LEAF,) if size == 1 else nystrom_trees(size - 1))


def _forests(total: int, largest: int, branches: Callable[[int], tuple[Tree, ...]]) -> tuple[Tree, ...]:
    """All multisets of branches whose sizes, none above `largest`, sum to `total`."""
    if total == 0:
        return ((),)
    if largest == 0:
        return ()
    return tuple(
        (*chosen, *rest)
        for count in range(total // largest + 1)
        for chosen in combinations_with_replacement(branches(largest), count)
        for rest in _forests(total - count * largest, largest - 1, branches)
    )


@cache
def _size(tree: Tree) -> int:
    return 1 + sum(map(_size, tree))


@cache
def density(tree: Tree) -> int:
    return _size(tree) * prod(map(density, tree))


@cache
def _nystrom_size(tree: Tree) -> int:
    return 1 + sum(1 if branch == LEAF else 1 + _nystrom_size(branch) for branch in tree)


@cache
def nystrom_density(tree: Tree) -> int:
    below = (1 if b == LEAF else (1 + _nystrom_size(b)) * nystrom_density(b) for b in tree)
    return _nystrom_size(tree) * prod(below)


def matrix(mp: Any, rows: Sequence[Sequence[Any]], size: int | None = None) -> Any:
    """Rows of a lower triangle as a square object array, shorter rows filled with zeros."""
    size = len(rows) if size is None else size
    found = np.full((size, size), mp.mpf(0), dtype=object)
    for row, values in zip(found, rows, strict=False):
        row[: min(size, len(values))] = list(values)[:size]
    return found

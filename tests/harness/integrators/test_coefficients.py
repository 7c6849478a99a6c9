"""Coefficient tables: sums, symmetry, order conditions, to the 60 digits in which they are given."""

from collections.abc import Callable, Sequence
from itertools import product
from math import factorial
from typing import Any

import pytest
from gnomon.cases.core.forms import FirstOrder, SecondOrder
from gnomon.harness.integrators.base.fixed_step import round_table
from gnomon.harness.integrators.gauss import gauss
from gnomon.harness.integrators.gauss.gauss import Gauss
from gnomon.harness.integrators.geometric import splitting
from gnomon.harness.integrators.geometric.splitting import Composition, Splitting
from gnomon.harness.integrators.runge_kutta.dop853_table import DOP853
from gnomon.reference.numerics.precision import working
from order_conditions import matrix, nystrom_residuals, nystrom_trees, trees

SIXTY = 1e-57
"""Coefficients are given to 60 digits; sums of up to seventeen of size 1 and their products lose two or three."""

THIRTY = 1e-26
"""DOP853's are published to 30 digits, of size up to 50 (D: 400); products of eight of them lose three more."""

Word = tuple[int, ...]


def exponential_products(factors: Sequence[dict[int, Any]], weight: int, one: Any) -> dict[Word, Any]:
    """Coefficients of the words up to a weight in the product of exp(sum of X_k), a factor's {letter k: coefficient}.

    A letter's weight is itself, so words in the generators of different orders in h are told apart.
    """
    series: dict[Word, Any] = {(): one}
    for factor in factors:
        exponential, term = {(): one}, {(): one}
        for n in range(1, weight + 1):
            following: dict[Word, Any] = {}
            for (word, value), (letter, c) in product(term.items(), factor.items()):
                if sum(word) + letter <= weight:
                    following[*word, letter] = following.get((*word, letter), 0) + value * c / n
            term = following
            for word, value in term.items():
                exponential[word] = exponential.get(word, 0) + value
        result: dict[Word, Any] = {}
        for (left, a), (right, b) in product(series.items(), exponential.items()):
            if sum(left) + sum(right) <= weight:
                result[left + right] = result.get(left + right, 0) + a * b
        series = result
    return series


@pytest.mark.parametrize("method", [m for m in splitting.INTEGRATORS if issubclass(m, Composition)])
def test_compositions_meet_the_order_conditions(method: type[Composition]) -> None:
    """A symmetric method is exp(h X1 + h^3 X3 + ...): the product over gamma must be exp(h X1) up to its order."""
    with working(62) as mp:
        gamma = method.lengths(mp)
        assert gamma == gamma[::-1]
        assert abs(mp.fsum(gamma) - 1) < SIXTY
        odd = [{k: g**k for k in range(1, method.order + 1, 2)} for g in gamma]
        for word, value in exponential_products(odd, method.order, mp.mpf(1)).items():
            wanted = mp.mpf(1) / factorial(len(word)) if set(word) <= {1} else 0
            assert abs(value - wanted) < SIXTY, word


@pytest.mark.parametrize("method", splitting.INTEGRATORS, ids=lambda method: method.name)
def test_splittings_are_nystrom_methods_of_their_order_and_no_more(method: type[Splitting]) -> None:
    """Kick m, at the time c_m, has moved q by (c_j - c_m) h^2 b_m when kick j comes: a matrix of a Nyström method."""
    with working(62) as mp:
        kicks, drifts = method.coefficients(mp)
        drifts = list(drifts)
        if "reversible" in method.conserves:
            if drifts[-1] == 0:
                assert [list(kicks), drifts[:-1]] == [list(kicks)[::-1], drifts[-2::-1]]
            else:
                assert [list(kicks[1:]), drifts] == [list(kicks)[:0:-1], drifts[::-1]]
        c = [mp.fsum(drifts[:j]) for j in range(len(kicks))]
        a = matrix(mp, [[kicks[m] * (c[j] - c[m]) for m in range(j)] for j in range(len(c))])
        positions = [kick * (1 - node) for kick, node in zip(kicks, c, strict=True)]
        found = [(n, abs(v)) for n, v in nystrom_residuals(a, c, positions, kicks, method.order + 1)]
        assert abs(mp.fsum(drifts) - 1) < SIXTY
        assert max(value for n, value in found if n <= method.order) < SIXTY
        assert max(value for n, value in found if n > method.order) > 1e-6


@pytest.mark.parametrize("method", gauss.INTEGRATORS, ids=lambda method: method.name)
def test_gauss_tableaus(method: type[Gauss]) -> None:
    """B(2s), C(s), symmetry and the condition of symplectic Runge-Kutta methods (Sanz-Serna, BIT 28, 1988)."""
    s = range(method.stages)
    with working(62) as mp:
        *stages, (_, *b) = method.tableau(mp).rows(mp)
        c, a = [row[0] for row in stages], [row[1:] for row in stages]
        for q in range(1, 2 * method.stages + 1):
            assert abs(mp.fsum(b[i] * c[i] ** (q - 1) for i in s) - mp.mpf(1) / q) < SIXTY
        for q in range(1, method.stages + 1):
            for i in s:
                assert abs(mp.fsum(a[i][j] * c[j] ** (q - 1) for j in s) - c[i] ** q / q) < SIXTY
        for i in s:
            assert abs(c[i] + c[-1 - i] - 1) < SIXTY
            for j in s:
                assert abs(b[i] * a[i][j] + b[j] * a[j][i] - b[i] * b[j]) < SIXTY


@pytest.mark.parametrize("form", [FirstOrder, SecondOrder])
@pytest.mark.parametrize("method", gauss.INTEGRATORS, ids=lambda method: method.name)
def test_gauss_starting_values_extrapolate_polynomials(method: type[Gauss], form: Callable[..., Any]) -> None:
    with working(62) as mp:
        s = range(method.stages)
        table = method().table(mp, form(len), (), mp.eps)
        c, b = [row[0] for row in table[: len(s)]], table[2 * len(s)][1:]
        steps = gauss.STEPS_BACK.get(len(s), 1)
        known = [(c[j] - back, b[j]) for back in range(steps) for j in s]
        for q in range(len(known)):
            for i in s:
                row = table[len(s) + i][1:]
                value = mp.fsum(x * weight * node**q for x, (node, weight) in zip(row, known, strict=True))
                wanted = b[i] * (1 + c[i]) ** q
                assert abs(value - wanted) < 1000 * SIXTY, "the polynomial is evaluated up to x = 2"


def test_the_number_of_trees_is_the_known_one() -> None:
    """Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, tables II.2.1 and II.14.3."""
    assert [len(trees(n)) for n in range(1, 11)] == [1, 1, 2, 4, 9, 20, 48, 115, 286, 719]
    assert [len(nystrom_trees(n)) for n in range(1, 11)] == [1, 1, 2, 3, 6, 10, 20, 36, 72, 137]


def test_dop853_dense_output_is_of_order_7() -> None:
    """With y' = t^q on [0, 1] all stages are c^q: the interpolant must give x^(q+1)/(q+1) for q up to 6."""
    with working(40) as mp:
        table = DOP853.rows(mp)
        c = [row[0] for row in table[:16]]
        for q in range(7):
            k = [node**q for node in c]
            end = mp.fsum(b * slope for b, slope in zip(table[12][1:], k, strict=True))
            d = [mp.fsum(w * slope for w, slope in zip(table[18 + r][1:], k, strict=True)) for r in range(4)]
            for x in (mp.mpf(1) / 3, mp.mpf(4) / 5):
                y = 1 - x
                inner = d[0] + x * (d[1] + y * (d[2] + x * d[3]))
                found = x * (end + y * (k[0] - end + x * (2 * end - k[12] - k[0] + y * inner)))
                assert abs(found - x ** (q + 1) / (q + 1)) < 100 * THIRTY


def test_dop853_rows_sum_to_the_nodes() -> None:
    nodes = {5: "1/3", 6: "1/4", 7: "4/13", 8: "127/195", 9: "3/5", 10: "6/7", 11: "1", 12: "1", 13: "1/10", 14: "1/5"}
    with working(40) as mp:
        for row, text in nodes.items():
            numerator, _, denominator = text.partition("/")
            assert abs(DOP853.rows(mp)[row][0] - mp.mpf(numerator) / int(denominator or 1)) < THIRTY


def test_the_binary_table_is_the_rounding() -> None:
    with working(60) as mp:
        third = mp.mpf(1) / 3
        table = round_table([[third, third], [third * 0]])
    assert table.tolist() == [[1 / 3, 1 / 3], [0.0, 0.0]]

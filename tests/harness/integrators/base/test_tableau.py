"""Butcher tableaux of all kinds: the order conditions of every formula, a wrong coefficient, numbers as the source has them."""

from dataclasses import replace
from typing import Any

import pytest
from gnomon.harness.integrators.base.tableau import ButcherTableau, parse_rows
from gnomon.harness.integrators.gauss import gauss
from gnomon.harness.integrators.gauss.radau import Radau5
from gnomon.harness.integrators.runge_kutta.explicit import RK4
from gnomon.harness.registry import lookup
from gnomon.reference.numerics.precision import working
from order_conditions import formulas, has_order, rk_residuals

OWN = lookup.own().values()
GIVEN: dict[ButcherTableau, Any] = {
    m.tableau: m for m in OWN if isinstance(getattr(m, "tableau", None), ButcherTableau)
}
METHODS: tuple[Any, ...] = (*GIVEN.values(), *gauss.INTEGRATORS[:4], Radau5)
"""All explicit methods of the registry, and implicit ones. Gauss methods of more stages have too many trees: for them
`test_gauss_tableaus` verifies the simplifying assumptions."""

SIXTY = 1e-57
PRINTED = {"DOP853": 1e-26, "Verner 9(8)": 1e-37}
"""Exact coefficients leave 1e-58. DOP853's are printed to 30 digits and up to 50 in size, Verner 9(8)'s to 40 digits
and up to 36; products of eight coefficients lose three digits."""


def tableau_of(mp: Any, method: Any) -> ButcherTableau:
    found = method.tableau
    return found if isinstance(found, ButcherTableau) else found(mp)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_every_formula_meets_the_conditions_of_its_order_and_no_more(method: Any) -> None:
    below = PRINTED.get(method.name, SIXTY)
    with working(62) as mp:
        tableau = tableau_of(mp, method)
        assert tableau.orders[0] == method.order
        for order, a, weights in formulas(mp, tableau):
            assert has_order(rk_residuals(a, weights, order + 1, mp.mpf(1)), order, below)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_the_nodes_are_the_sums_of_the_rows(method: Any) -> None:
    """Else the conditions for y' = f(y) say nothing about y' = f(t, y)."""
    with working(62) as mp:
        table = tableau_of(mp, method).rows(mp)
        stages = len(table[0]) - 1
        assert all(abs(mp.fsum(a) - c) < PRINTED.get(method.name, SIXTY) for c, *a in table[: stages + 1])


@pytest.mark.parametrize("method", [RK4, gauss.Gauss3], ids=lambda method: method.name)
def test_a_wrong_digit_is_caught(method: Any) -> None:
    """A coefficient `a`, or a weight, that is wrong by 1e-30."""
    with working(62) as mp:
        right = tableau_of(mp, method)
        last, wrong = right.a[-1], mp.mpf("1e-30")
        row, column = {**last, 0: last.get(0, mp.zero) + wrong}, {**right.b, 0: mp.mpf(1) / 6 + wrong}
        for mistyped in (replace(right, a=(*right.a[:-1], row)), replace(right, b=column)):
            for order, a, weights in formulas(mp, mistyped):
                assert not has_order(rk_residuals(a, weights, order + 1, mp.mpf(1)), order, SIXTY)


def test_fractions_decimals_and_numbers_mix() -> None:
    """Columns that are left out are 0, errors have two rows or none, and c that is not given is the sum of a."""
    with working(30) as mp:
        plain = ButcherTableau((1,), ({}, {0: "1/4", 1: mp.mpf(1)}), {1: "0.5"})
        assert plain.rows(mp) == [[0, 0, 0], [1.25, 0.25, 1], [1, 0, 0.5]]
        embedded = replace(plain, c=("0", "1/2"), errors=({2: "1"},), extra=({2: "3"},), dense=({3: "7"},))
        assert embedded.rows(mp) == [
            [0, 0, 0, 0, 0], [0.5, 0.25, 1, 0, 0], [1, 0, 0.5, 0, 0], [3, 0, 0, 3, 0],
            [0, 0, 0, 1, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 7],
        ]  # fmt: skip


def test_rows_as_papers_print_them() -> None:
    """Columns count from 0, also those that are 0; a row may take several lines, and one without its end is not lost."""
    assert parse_rows("; 1/2; 0 -3 0\n 4;") == ({}, {0: "1/2"}, {1: "-3", 3: "4"})
    with pytest.raises(ValueError, match=r"^'3 4' has no semicolon after it"):
        parse_rows("1 2; 3 4")

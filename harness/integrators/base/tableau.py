"""Tableaux of coefficients, with the digits of their source, for Runge-Kutta and Nyström methods."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gnomon.harness.integrators.base.fixed_step import Table

Row = Mapping[int, Any]
"""Coefficients by column: '1/3', '0.25' or a number of a context. Columns that are left out are 0."""


@dataclass(frozen=True, eq=False)
class ButcherTableau:
    """A Runge-Kutta method of s stages: explicit, implicit or embedded.

    `orders`: the order of the method, then of each embedded formula. `a`, `b`, `c`: the matrix by rows, the weights and
    the nodes; if c is None, the nodes are the sums of the rows of a.

    For error control, `errors`: b minus the weights of one or two embedded formulas; column s belongs to the slope at
    the end of the step. For dense output, `extra`: the rows of further stages, which have the columns from s + 1 on;
    `dense`: coefficients d_0, d_1, ... of the interpolant

        u(x) = y + x (D + x' (h k_0 - D + x (2 D - h (k_0 + k_s) + x' (h d_0 + x (h d_1 + x' ...))))),   x' = 1 - x

    with D the change in the step. Every interpolant whose values and slopes agree with the step at both ends has this
    form. `dense` is None if a method has no interpolant.

    Butcher, J. Australian Mathematical Society 4, 1964; Hairer, Norsett, Wanner, Solving Ordinary Differential
    Equations I, 1993, II.1, II.4 and II.6.
    """

    orders: tuple[int, ...]
    a: tuple[Row, ...]
    b: Row
    c: tuple[Any, ...] | None = None
    errors: tuple[Row, ...] = ()
    extra: tuple[Row, ...] = ()
    dense: tuple[Row, ...] | None = None

    def rows(self, mp: Any) -> Table:
        """The table of coefficients, in numbers of `mp`, an mpmath context or `step_control.Decimals`.

        Rows: c_j, a_j1, ... of each stage; 1 and b; c_j, a_j1, ... of each extra stage; 0 and each row of errors; 0 and
        each row of dense output. An embedded method has two rows of errors; the second is 0 if it has one embedded
        formula.
        """
        width = len(self.a) + (1 + len(self.extra) if self.errors else 0)
        stages, extra = ([full(mp, row, width) for row in rows] for rows in (self.a, self.extra))
        c = [mp.fsum(row) for row in stages] if self.c is None else [number(mp, node) for node in self.c]
        errors = (*self.errors, {})[:2] if self.errors else ()
        return [
            *([node, *row] for node, row in zip(c, stages, strict=True)),
            [mp.mpf(1), *full(mp, self.b, width)],
            *([mp.fsum(row), *row] for row in extra),
            *([mp.mpf(0), *full(mp, row, width)] for row in (*errors, *(self.dense or ()))),
        ]


@dataclass(frozen=True, eq=False)
class NystromTableau:
    """An explicit Runge-Kutta-Nyström pair of s stages for q'' = a(t, q).

    It differs from a Butcher tableau: it has two rows of weights, and its nodes are not sums of rows. `orders`: the
    orders of the formula that gives the next state and of the embedded formula. `c`, `a`: nodes and matrix. `b`, `d`:
    weights of the position and of the velocity (b' in the literature); column s belongs to the acceleration at the end
    of the step. `embedded`: both rows of weights of the embedded formula.
    """

    orders: tuple[int, int]
    c: tuple[str, ...]
    a: tuple[Row, ...]
    b: Row
    d: Row
    embedded: tuple[Row, ...]

    @property
    def uses_end(self) -> bool:
        """Whether the acceleration at the end of the step has a weight."""
        return len(self.a) in self.d

    def rows(self, mp: Any) -> Table:
        """Rows c_j, a_j1, ... of the stages; 0 and b; 0 and d; 0 and the differences to the embedded weights, twice."""
        width = len(self.a) + 1
        weights, others = ([full(mp, row, width) for row in rows] for rows in ((self.b, self.d), self.embedded))
        errors = [[x - y for x, y in zip(*rows, strict=True)] for rows in zip(weights, others, strict=True)]
        stages = [[number(mp, c), *full(mp, row, width)] for c, row in zip(self.c, self.a, strict=True)]
        return [*stages, *([mp.mpf(0), *row] for row in (*weights, *errors))]

    def fixed_rows(self, mp: Any) -> Table:
        """Rows c_j, a_j1, ... of all stages, also of the end of the step if it has a weight; 0 and b; 0 and d."""
        table, stages = self.rows(mp), len(self.a)
        last = [[mp.mpf(1), *table[stages][1:]]] if self.uses_end else []
        return [*table[:stages], *last, *table[stages : stages + 2]]


def parse_rows(text: str) -> tuple[Row, ...]:
    """Rows of coefficients from text, as papers print them: numbers from column 0 on, a semicolon after each row.

    Raises ValueError if the last row has no semicolon.
    """
    *rows, rest = text.split(";")
    if rest.strip():
        raise ValueError(f"{rest.strip()[:60]!r} has no semicolon after it; end each row with one")
    return tuple({j: value for j, value in enumerate(row.split()) if value != "0"} for row in rows)


def full(mp: Any, row: Row, length: int) -> list[Any]:
    """All coefficients of a row, zeros included, as numbers of the context."""
    return [number(mp, row[j]) if j in row else mp.zero for j in range(length)]


def number(mp: Any, value: Any) -> Any:
    """Convert '1/3' or '0.25' to a number of the context; numbers are returned as they are."""
    if not isinstance(value, str):
        return value
    numerator, _, denominator = value.partition("/")
    return mp.mpf(numerator) / mp.mpf(denominator or 1)

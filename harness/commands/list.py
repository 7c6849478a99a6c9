"""`gnomon list`: cases, checks and integrators."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer
from gnomon.harness.commands.options import Output, out
from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    from gnomon.cases import Case, Check

INTEGRATORS_WIDTH = 96
"""Columns for ids of full length, so that they can be copied."""


class Listed(StrEnum):
    """What `gnomon list` lists."""

    cases = "cases"
    checks = "checks"
    integrators = "integrators"


def list_(what: Annotated[Listed | None, typer.Argument(help="What to list; by default everything.")] = None) -> None:
    """List cases, checks (rows without motion) and integrators."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon import cases

    if what in (None, Listed.cases):
        out.print(_variants_table("Cases", "case", [cases.case_class(name) for name in cases.names()]))
    if what in (None, Listed.checks):
        kinds = [cases.check_class(name) for name in cases.check_names()]
        out.print(_variants_table("Checks, without motion", "check", kinds))
    if what in (None, Listed.integrators):
        Output(width=max(out.width, INTEGRATORS_WIDTH), emoji=False).print(integrators_table())


def _variants_table(title: str, column: str, kinds: Iterable[type[Case] | type[Check]]) -> Table:
    """Cases, or checks: name, title and variants of each."""
    table = Table(title=title, box=SIMPLE_HEAD, padding=(0, 1))
    table.add_column(column, no_wrap=True)
    table.add_column("title")
    table.add_column("variants")
    for kind in kinds:
        table.add_row(kind.name, kind.title, ", ".join(variant.name for variant in kind.variants))
    return table


def integrators_table() -> Table:
    from gnomon.harness.registry import lookup

    table = Table(title="Integrators", box=SIMPLE_HEAD, padding=(0, 1))
    table.add_column("id", no_wrap=True)
    table.add_column("order", justify="right")
    table.add_column("accepts", no_wrap=True)
    for identity, one in lookup.everything().items():
        accepted = ", ".join(kind.__name__ for kind in one.accepts)
        table.add_row(escape(identity), "" if one.order is None else str(one.order), accepted)
    return table

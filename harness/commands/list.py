"""`gnomon list`: cases, checks and integrators."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import Output, out
from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Column, Table

if TYPE_CHECKING:
    from gnomon.cases.core.registry import Entry
    from gnomon.harness.contract.integrator import Integrator

INTEGRATORS_WIDTH = 96
"""Columns for ids of full length, so that they can be copied."""


class Listed(StrEnum):
    """The things that `gnomon list` can list."""

    cases = "cases"
    checks = "checks"
    integrators = "integrators"


def list_(
    what: Annotated[Listed | None, typer.Argument(help="What to list; by default everything.")] = None,
    pattern: Annotated[str, typer.Argument(help="A name, or a pattern with * and ?, as 'kepler*' or 'scipy:*'.")] = "*",
    library: options.Libraries = None,
    family: options.Families = None,
    kind: options.Kinds = None,
) -> None:
    """List cases, checks (rows without motion) and integrators."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.cases.core.numbers import matching
    from gnomon.cases.core.registry import entry

    from gnomon import cases

    if pattern != "*" and what is None:
        raise ValueError(f"{pattern!r}: say what to list, cases, checks or integrators, before the pattern")
    narrowed = {Listed.cases: family or kind, Listed.checks: None, Listed.integrators: library or kind}
    shown = [what] if what else [each for each in narrowed if narrowed[each]] or list(narrowed)
    if what and (library or family or kind) and not narrowed[what]:
        raise ValueError(f"{what}: --family narrows cases, --library integrators, --kind both; leave out the others")
    if Listed.cases in shown:
        named = matching(pattern, cases.names())
        if family or kind:
            from gnomon.harness.registry import selection  # imports the cases, whose forms it reads

            found = selection.cases_of([(cases.get(name), name) for name in named], family, kind)
            named = [name for _, name in found]
        out.print(_variants_table("Cases", "case", map(entry, named)))
    if Listed.checks in shown:
        checks = map(entry, matching(pattern, cases.check_names()))
        out.print(_variants_table("Checks, without motion", "check", checks))
    if Listed.integrators in shown:
        from gnomon.harness.registry import lookup, selection

        known = lookup.everything()
        chosen = selection.integrators_of([known[name] for name in matching(pattern, known)], library, kind)
        Output(width=max(out.width, INTEGRATORS_WIDTH), emoji=False).print(integrators_table(chosen))


def _variants_table(title: str, column: str, entries: Iterable[Entry]) -> Table:
    """A table of cases or checks with their names, titles and variants."""
    columns = Column(column, no_wrap=True), "title", "variants"
    table = Table(*columns, title=title, box=SIMPLE_HEAD, padding=(0, 1))
    for each in entries:
        table.add_row(each.name, each.title, ", ".join(each.variants))
    return table


def integrators_table(found: Iterable[Integrator]) -> Table:
    columns = Column("id", no_wrap=True), Column("order", justify="right"), Column("accepts", no_wrap=True)
    table = Table(*columns, title="Integrators", box=SIMPLE_HEAD, padding=(0, 1))
    for one in found:
        accepted = ", ".join(kind.__name__ for kind in one.accepts)
        table.add_row(escape(one.id), "" if one.order is None else str(one.order), accepted)
    return table

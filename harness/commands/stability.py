"""`gnomon stability`: measure limits, resonances and robustness of integrators through their public contract."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out, problems
from gnomon.harness.registry.completion import complete_integrator
from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Column, Table

if TYPE_CHECKING:
    from gnomon.harness.stability.panel_run import Row

NOTHING = 2
"""The exit code if nothing was measured."""
WRITE_SECONDS = 60.0
"""Seconds between two writings of the result, so that little is lost."""


def stability(
    integrator: Annotated[
        list[str] | None,
        typer.Argument(help=f"{options.INTEGRATOR}; several. By default all.", autocompletion=complete_integrator),
    ] = None,
    named: options.Integrators = None,
    panel: Annotated[list[str] | None, typer.Option(help="A panel by its id; repeatable. By default all.")] = None,
    depth: Annotated[
        str, typer.Option(help="normal (about 2 s a panel and method) or high (the full grids).")
    ] = "normal",
    to: Annotated[Path | None, options.path_option("Write the result as JSON, and resume from it.", "--out")] = None,
    update: Annotated[
        bool, typer.Option("--update", help="Measure named panels of --out again, and write all sentences anew.")
    ] = False,
    workers: Annotated[int, typer.Option(help="Integrators at a time, each in a process.")] = 2,
) -> None:
    """Measure the numerical stability of integrators. Exit code 2 if nothing was measured.

    The same command resumes an interrupted measurement that has --out; for other integrators it adds to the file.
    """
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.registry import lookup
    from gnomon.harness.stability import panel_run
    from gnomon.harness.system.progress import Progress

    options.validate_workers(workers)
    if update and to is None:
        raise ValueError("--update: name the file with --out")
    panel_run.seconds_of(depth)
    chosen = panel_run.choose_panels(panel)
    integrators = lookup.find_all(
        [*(integrator or ()), *(named or ())] or [*(lookup.general() | lookup.list_registered()).values()]
    )
    if to is not None:
        options.ensure_writable(to, "--out")
    again = {(each.id, name) for each in integrators for name in panel or ()} if update else None
    rows = panel_run.keep_rows(to, depth, again) if to is not None else []
    written = monotonic()

    def add(row: Row) -> None:
        nonlocal written
        rows.append(row)
        progress.advance()
        if to is not None and monotonic() - written > WRITE_SECONDS:
            panel_run.write(rows, depth, to)
            written = monotonic()

    measured = {(row.integrator, row.panel) for row in rows}
    with Progress() as progress:
        progress.begin("panels", sum((each.id, name) not in measured for each in integrators for name in chosen))
        try:
            rows = panel_run.measure_panels(integrators, panel, depth, workers, add, former=list(rows))
        finally:
            if to is not None and rows:
                panel_run.write(rows, depth, to)
    rows = [row for row in rows if row.integrator in {each.id for each in integrators} and row.panel in chosen]
    _show(rows, {name: each.title for name, each in chosen.items()}, panel_run.tiers_of(rows))
    if all(row.reason is not None for row in rows):
        problems.print("nothing was measured: no panel applies, or every integrator refused")
        raise typer.Exit(NOTHING)


def _show(rows: Sequence[Row], titles: Mapping[str, str], tiers: Mapping[str, Any]) -> None:
    """A table for each panel, then the tiers."""
    for name, title in titles.items():
        out.print(panel_table(title, [row for row in rows if row.panel == name]))
    for what, ranking in tiers.items():
        for place, tier in enumerate(ranking["tiers"], 1):
            out.print(escape(f"tier {place} by {what.replace('_', ' ')}: {', '.join(tier)}"), highlight=False)


def panel_table(title: str, rows: Iterable[Row]) -> Table:
    """A table with a row for each integrator: the sentences from its numbers, or the reason for their absence."""
    columns = Column("integrator", no_wrap=True), "conclusion"
    table = Table(*columns, title=title, box=SIMPLE_HEAD, padding=(0, 1))
    for row in rows:
        table.add_row(escape(row.integrator), escape("\n".join(row.sentences) if row.reason is None else row.reason))
    return table

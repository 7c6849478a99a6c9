"""`gnomon export`: the measurements of a run as a table for other programs."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out
from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Column, Table

TYPES = {"TEXT": "text", "REAL": "number", "INTEGER": "integer"}


class ExportFormat(StrEnum):
    """The formats that `gnomon export` writes."""

    csv = "csv"
    json = "json"
    parquet = "parquet"


def export(
    run: Annotated[
        Path | None, typer.Argument(help="A results file or its folder.", parser=options.as_path, show_default=False)
    ] = None,
    form: Annotated[ExportFormat, typer.Option("--format", help="What to write.")] = ExportFormat.csv,
    to: Annotated[Path | None, options.path_option("The file to write; by default results.FORMAT.", "--out")] = None,
    raw: Annotated[
        bool, typer.Option("--raw", help="Do not mark texts in a csv that a spreadsheet would read as formulas.")
    ] = False,
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the columns of an export: type, unit and meaning. Needs no run.")
    ] = False,
) -> None:
    """Write the measurements of a run as a table, one row each."""
    if schema:
        out.print(columns_table())
        return
    if run is None:
        raise ValueError("name a results file, or --schema for the columns of an export")
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.results import store

    target = to or Path(f"results.{form.value}")
    database = store.results_file(run)
    options.ensure_writable(target, "--out")
    if target.exists() and target.samefile(database):
        raise ValueError(f"--out {target}: these are the results; name another file")
    store.export(database, target, form.value, raw)
    out.print(f"wrote {target}")


def columns_table() -> Table:
    """The columns of an export in their sequence."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.contract.declared import read_declared
    from gnomon.harness.results.export import kind_of

    table = Table(Column("column", no_wrap=True), "type", "unit", "meaning", box=SIMPLE_HEAD, padding=(0, 1))
    for name, (unit, meaning) in read_declared("results", "columns.toml").items():
        table.add_row(name, TYPES[kind_of(name)], unit, escape(meaning))
    return table

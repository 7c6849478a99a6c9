"""`gnomon export`: the measurements of a run as a table for other programs."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out


class ExportFormat(StrEnum):
    """The formats that `gnomon export` writes."""

    csv = "csv"
    json = "json"
    parquet = "parquet"


def export(
    run: options.ResultsFile,
    form: Annotated[ExportFormat, typer.Option("--format", help="What to write.")] = ExportFormat.csv,
    to: Annotated[Path | None, options.path_option("The file to write; by default results.FORMAT.", "--out")] = None,
    raw: Annotated[
        bool, typer.Option("--raw", help="Do not mark texts in a csv that a spreadsheet would read as formulas.")
    ] = False,
) -> None:
    """Write the measurements of a run as a table, one row each."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.results import store

    target = to or Path(f"results.{form.value}")
    database = store.results_file(run)
    options.ensure_writable(target, "--out")
    if target.exists() and target.samefile(database):
        raise ValueError(f"--out {target}: these are the results; name another file")
    store.export(database, target, form.value, raw)
    out.print(f"wrote {target}")

"""`gnomon plot`: the error against time of the integrators of a run, a diagram for each case."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out
from rich.markup import escape


def plot(
    run: options.ResultsFile,
    case: Annotated[
        list[str] | None,
        typer.Option(
            help="A case of the run, case/variant or 'pattern*'; repeatable. By default all default variants."
        ),
    ] = None,
    out_path: Annotated[
        Path | None,
        options.path_option("The picture: .html, .svg or .png; by default beside the results, as .html.", "--out"),
    ] = None,
) -> None:
    """Draw the error against the time of the integrators of a run: a diagram for each case."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.results.store import results_file

    database = results_file(run)
    target = out_path or database.with_suffix(".html")
    options.ensure_drawing(target, "--out")
    from gnomon.harness.reporting.images import save
    from gnomon.harness.reporting.pictures.work_pictures import specification

    save(specification(database, case), target)
    out.print(f"drawn: {escape(str(target))}", highlight=False)

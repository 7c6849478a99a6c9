"""`gnomon report`: write the page of a run."""

from pathlib import Path
from typing import Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out, problems
from rich.markup import escape


def report(
    run: options.ResultsFile,
    to: Annotated[Path, options.path_option("The folder to write to.", "--out")] = Path("reports/local"),
    case: Annotated[
        list[str] | None,
        typer.Option(
            help="A case that is not installed, package.module:Class; a results file cannot name code to import."
        ),
    ] = None,
    figures: Annotated[bool, typer.Option("--figures", help="Write every figure as SVG and PNG too: slower.")] = False,
) -> None:
    """Write the report of a run: one offline page and a summary."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.system import extras

    extras.require("report", "gnomon report")
    from gnomon.cases.core.registry import case_class
    from gnomon.harness.reporting.up_to_date import refreshed
    from gnomon.harness.results import opening
    from gnomon.harness.results.outstanding import outstanding
    from gnomon.harness.results.store import results_file

    database, given = results_file(run), {name: case_class(name) for name in case or ()}
    with opening.reading(database, ()):
        pass  # raises, before a folder is made, if the file does not hold results of gnomon
    options.ensure_folder(to, "--out")
    if figures:
        from gnomon.harness.reporting.report import write_report

        page = write_report(database, to, given, figures=True)
    else:
        page = refreshed(database, to, given)
    out.print(f"The report is {page}")
    lacking = outstanding(database).text
    if lacking:
        problems.print(escape(f"{database}: {lacking}"), highlight=False)

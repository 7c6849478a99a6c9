"""`gnomon report`: write the page of a run."""

from pathlib import Path
from typing import Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out, problems
from rich.markup import escape


def report(
    run: options.ResultsFile,
    to: Annotated[
        Path, options.path_option("The folder to write to; with --pdf also the file, FILE.pdf.", "--out")
    ] = Path("reports/local"),
    case: Annotated[
        list[str] | None,
        typer.Option(
            help="A case that is not installed, package.module:Class; a results file cannot name code to import."
        ),
    ] = None,
    figures: Annotated[bool, typer.Option("--figures", help="Write every figure as SVG and PNG too: slower.")] = False,
    pdf: Annotated[
        str | None,
        typer.Option(
            "--pdf", metavar="INTEGRATOR", help="Write only the accuracy report of this integrator of the run, as PDF."
        ),
    ] = None,
) -> None:
    """Write the report of a run: one offline page and a summary; or, as a PDF, the accuracy of one integrator."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.system import extras

    extras.require("report", "gnomon report")
    from gnomon.cases.core.registry import case_class
    from gnomon.harness.reporting.up_to_date import refresh
    from gnomon.harness.results import opening
    from gnomon.harness.results.outstanding import outstanding
    from gnomon.harness.results.store import results_file

    database, classes = results_file(run), {name: case_class(name) for name in case or ()}
    with opening.reading(database, ()):
        pass  # raises, before a folder is made, if the file does not hold results of gnomon
    file = pdf is not None and to.suffix.lower() == ".pdf"
    options.ensure_folder(to.parent if file else to, "--out", to if file else None)
    if pdf is not None:
        if figures:
            raise ValueError("--figures: a PDF has its figures in it; give --figures or --pdf")
        from gnomon.harness.reporting.pdf.accuracy import write_accuracy

        page = write_accuracy(database, pdf, to, classes)
    elif figures:
        from gnomon.harness.reporting.report import write_report

        page = write_report(database, to, classes, figures=True)
    else:
        page = refresh(database, to, classes)
    out.print(f"The report is {page}")
    lacking = outstanding(database).text
    if lacking:
        problems.print(escape(f"{database}: {lacking}"), highlight=False)

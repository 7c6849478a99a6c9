"""`gnomon compare`: find out whether a run is worse than an earlier one."""

from pathlib import Path
from typing import Annotated, Any

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out
from rich.markup import escape


def compare(
    base: Annotated[Path, typer.Argument(help="The earlier results.", parser=options.as_path)],
    run: Annotated[Path, typer.Argument(help="The results to compare with the base.", parser=options.as_path)],
    allow_missing: Annotated[
        bool,
        typer.Option(
            "--allow-missing",
            help="Series and settings without a result in the run, and outstanding trials, do not fail.",
        ),
    ] = False,
) -> None:
    """Compare a run with an earlier one: status, order, errors and right-hand sides.

    Exit code 1 if the run is worse, if trials of one of the two are outstanding (planned, and interrupted or not run
    yet), or if a setting of the base is not compared: it has no result in the run, unless --allow-missing is given, or
    an error, a bound or a count is missing. 2 if nothing can be compared. A timeout counts as worse only after three
    tries, which limits below half a second allow.
    """
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.results.regression import compare as compare_

    (before, lacking), (after, lacked) = _read(base), _read(run)
    verdict = compare_(before, after, allow_missing)
    for line in verdict.notes:
        out.print(escape(line))
    for line in verdict.regressions:
        out.print(f"[red]worse[/] {escape(line)}")
    for path, text in ((base, lacking), (run, lacked)):
        if text:
            out.print(escape(f"outstanding in {path}: {text}"), highlight=False)
    for line in verdict.summary():
        out.print(escape(line), highlight=False)
    if verdict.failed or ((lacking or lacked) and not allow_missing):
        raise typer.Exit(1)


def _read(path: Path) -> tuple[list[dict[str, Any]], str]:
    """The measurements of one state of a file, and its outstanding trials, in words."""
    from gnomon.harness.results import opening
    from gnomon.harness.results.outstanding import outstanding
    from gnomon.harness.results.reading import rows

    with opening.one_state(path):
        return rows(path), outstanding(path).text

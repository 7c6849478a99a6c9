"""`gnomon compare`: whether a run got worse."""

from pathlib import Path
from typing import Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out
from rich.markup import escape


def compare(
    base: Annotated[Path, typer.Argument(help="The earlier results.", parser=options.as_path)],
    run: Annotated[Path, typer.Argument(help="The results to compare with the base.", parser=options.as_path)],
    allow_missing: Annotated[
        bool, typer.Option("--allow-missing", help="Series and settings without a result in the run do not fail.")
    ] = False,
) -> None:
    """Compare a run with an earlier one: status, order, errors and right-hand sides.

    Exit code 1 if the run is worse, or if a setting of the base is not compared: it has no result in the run, unless
    --allow-missing is given, or an error, a bound or a count is missing. 2 if nothing can be compared. A timeout counts
    as worse only after three tries, which limits below half a second allow.
    """
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.results.regression import compare as compare_
    from gnomon.harness.results.store import load

    verdict = compare_(load(base), load(run), allow_missing)
    for line in verdict.notes:
        out.print(escape(line))
    for line in verdict.regressions:
        out.print(f"[red]worse[/] {escape(line)}")
    for line in verdict.summary():
        out.print(escape(line), highlight=False)
    if verdict.failed:
        raise typer.Exit(1)

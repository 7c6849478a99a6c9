"""`gnomon merge`: put results files of one plan, such as the files of shards, into one file."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out, problems
from rich.markup import escape


def merge(
    runs: Annotated[list[Path], typer.Argument(help="Results files or their folders.", parser=options.as_path)],
    to: Annotated[Path, options.path_option("The new file.sqlite or folder.", "--out")],
    count: Annotated[
        bool, typer.Option("--count", help="Count a trial that two files measured as a further launch of it.")
    ] = False,
    allow_missing: Annotated[bool, typer.Option("--allow-missing", help=options.OUTSTANDING)] = False,
) -> None:
    """Merge results files into a new one. A trial that two of them measured is refused, unless --count is given.

    Exit code 1 if trials are outstanding in the new file: planned, and interrupted or not run yet.
    """
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.results.merging import merge as merge_
    from gnomon.harness.results.outstanding import outstanding

    target = to if to.suffix == ".sqlite" else to / "results.sqlite"
    options.ensure_writable(target, "--out")
    measurements = merge_(runs, target, count, shlex.join(sys.argv))
    out.print(f"{measurements} measurements of {len(runs)} files: {target}", highlight=False)
    lacking = outstanding(target).text
    if lacking:
        problems.print(escape(f"{target}: {lacking}"), highlight=False)
        if not allow_missing:
            raise typer.Exit(1)

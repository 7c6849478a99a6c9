"""`gnomon baseline write`: the present results of an integrator, as a text file to commit and to compare with."""

from pathlib import Path
from typing import Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out
from rich.markup import escape

baseline = typer.Typer(no_args_is_help=True, help="Baselines for `gnomon verify --baseline`.")


@baseline.callback()
def _group() -> None:
    """Without it Typer would make `write` the command itself."""


@baseline.command()
def write(
    to: Annotated[Path, options.path_option("The text file to write.", "--out")],
    integrator: options.IntegratorArgument = None,
    named: options.IntegratorOption = None,
    command: options.Programs = None,
    case: options.Cases = None,
    depth: Annotated[str, typer.Option(help="low, normal or high: how many cases, and how short the steps.")] = "low",
    workers: Annotated[int, typer.Option(help="Cases at a time, each in a process.")] = 2,
) -> None:
    """Write the status of each setting, and the ranges of error, right-hand sides and steps over 16 runs whose starts
    are perturbed by units in the last place."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.verification.baseline import RUNS, as_text, measure

    options.validate_workers(workers)
    options.ensure_writable(to, "--out")
    chosen, _ = options.integrator_or_program(options.one_of(integrator, named, "integrator"), command)
    measured = measure(chosen, case, depth, RUNS, workers, lambda name: out.print(escape(name)))
    to.write_text(as_text(measured), encoding="utf-8")
    out.print(f"{len(measured.entries)} settings of {escape(measured.integrator)}: {escape(str(to))}", highlight=False)

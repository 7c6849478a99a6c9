"""`gnomon exact`: exact states of a case, for comparison in any language."""

from enum import StrEnum
from typing import Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out, problems
from rich.markup import escape


class ExactFormat(StrEnum):
    """The formats that `gnomon exact` prints."""

    json = "json"
    csv = "csv"


def exact(
    case: options.CaseArgument = None,
    named: options.CaseOption = None,
    times: Annotated[
        str | None,
        typer.Option(
            help="Times in seconds: a list as 0.5,1,1.5 or a file, whose header may name a column t or time. Decimals are exact, 0x1.8p+1 is a double. By default"
            " the 64 sample times of the case."
        ),
    ] = None,
    digits: Annotated[int, typer.Option(help="Significant digits, relative to the size of the motion.")] = 40,
    form: Annotated[ExactFormat, typer.Option("--format", help="What to print.")] = ExactFormat.json,
    parameters: options.Parameters = None,
) -> None:
    """Print exact states, their certificate and a hash. The numbers of the case are rounded to doubles first.

    Exit code 1 if the certificate confirms fewer digits than required.
    """
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.trajectories.exact_states import exact_states, times_of

    from gnomon import cases

    name = options.one_case(case, named)
    if name.partition("/")[0] in cases.check_names():
        raise ValueError(f"{name} is a check, without motion: `gnomon show {name}` prints its results")
    chosen = options.choose_one(name, parameters)
    states = exact_states(chosen, times_of(times, chosen), digits)
    out.out(states.as_json() if form == ExactFormat.json else states.as_csv(), end="", highlight=False)
    certificate = states.certificate
    if not certificate.passed:
        reason = certificate.note or f"{certificate.worst} agrees to {certificate.digits:.0f}"
        problems.print(escape(f"not confirmed to {certificate.required} digits: {reason}"), highlight=False)
        raise typer.Exit(1)

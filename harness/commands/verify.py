"""`gnomon verify`: the claims about an integrator, against exact motions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out, problems
from rich.markup import escape

if TYPE_CHECKING:
    from gnomon.harness.contract.integrator import Integrator
    from gnomon.harness.verification.verify import Report, Row


def verify(
    integrator: Annotated[str, typer.Argument(help="package.module:object, an id or a name.")],
    case: Annotated[
        list[str] | None, typer.Option(help="A case, or case/variant for a hard variant; repeatable.")
    ] = None,
    claim: Annotated[list[str] | None, typer.Option(help="A claim by its id; repeatable. By default all.")] = None,
    depth: Annotated[
        str, typer.Option(help="low, normal or high: how many cases, and how short the steps.")
    ] = "normal",
    max_seconds: Annotated[
        float | None, typer.Option(help="Claims that are not verified within this time do not apply.")
    ] = None,
    json_path: Annotated[
        Path | None, typer.Option("--json", help="Write the result as JSON.", parser=options.as_path)
    ] = None,
    junit: Annotated[Path | None, typer.Option(help="Write the result as JUnit XML.", parser=options.as_path)] = None,
    known_failures: Annotated[
        Path | None,
        typer.Option(
            help="A text file of failures that are known, a line each: CLAIM CASE REASON.", exists=True, dir_okay=False
        ),
    ] = None,
    workers: Annotated[int, typer.Option(help="Cases at a time, each in a process.")] = 2,
) -> None:
    """Verify an integrator: order, error, conservation, repeatability, bad input, hard variants, events.

    Exit code 1 if a claim failed whose failure is not known, or if the first trial raises; 2 if no claim was checked.
    """
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.registry import lookup
    from gnomon.harness.verification import verification_report as report_

    options.validate_workers(workers)
    if max_seconds is not None and not max_seconds > 0:
        raise ValueError(f"--max-seconds {max_seconds:g}: give a positive number of seconds")
    known = report_.read_known(known_failures) if known_failures is not None else {}
    for path, option in ((json_path, "--json"), (junit, "--junit")):
        if path is not None:
            options.ensure_writable(path, option)
    found = lookup.find(integrator)
    if len(found) > 1:
        raise ValueError(f"{integrator} names {', '.join(one.id for one in found)}; give one id")
    report = _report(found[0], case, depth, claim, max_seconds, workers)
    for line in report_.lines(report, known, integrator):
        out.print(escape(line), highlight=False)
    if json_path is not None:
        json_path.write_text(report_.as_json(report, known, integrator), encoding="utf-8")
    if junit is not None:
        junit.write_text(report_.as_junit(report, known, integrator), encoding="utf-8")
    code = report_.exit_code(report, known)
    if code == report_.NOTHING:
        problems.print("no claim was checked: no case takes this integrator, or no claim applies")
    if code:
        raise typer.Exit(code)


def _report(
    integrator: Integrator,
    cases: list[str] | None,
    depth: str,
    claims: list[str] | None,
    max_seconds: float | None,
    workers: int,
) -> Report:
    """The report of a verification, with a line for each claim as it ends; exit code 1 if the first trial raises."""
    from gnomon.harness.verification.claims import Outcome
    from gnomon.harness.verification.verification_report import FAILED
    from gnomon.harness.verification.verify import FirstTrialError, verify

    def show(row: Row) -> None:
        if row.finding.outcome != Outcome.NOT_APPLICABLE:
            out.print(escape(f"{row.finding.outcome:6} {row.claim} on {row.case}"), highlight=False)

    try:
        return verify(integrator, cases, depth, claims, max_seconds, workers, show)
    except FirstTrialError as error:
        problems.print(escape(str(error).rstrip()), highlight=False)
        problems.print("nothing was verified: the first trial raised")
        raise typer.Exit(FAILED) from None

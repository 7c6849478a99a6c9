"""`gnomon certify`: exact motions, confirmed in independent ways."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out
from gnomon.harness.registry.completion import complete_subject
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    from gnomon.harness.certification.certify import Certificate


def certify(
    case: Annotated[
        list[str] | None,
        typer.Argument(help=f"{options.CASE}, or a check; several. By default all.", autocompletion=complete_subject),
    ] = None,
    named: options.Cases = None,
    to: Annotated[Path, options.path_option("Where the certificates go, as JSON.", "--out")] = Path(
        "runs/certificates.json"
    ),
    suite: Annotated[str | None, typer.Option(help="Only the cases of this suite.")] = None,
    everything: Annotated[bool, typer.Option("--all", help="All variants too.")] = False,
    independent: Annotated[
        Path | None,
        options.path_option("Measure the independent computations of the checks too, and write them here, as JSON."),
    ] = None,
    workers: Annotated[int, typer.Option(help="Processes at a time.")] = 2,
) -> None:
    """Confirm exact motions in independent ways. Exit code 1 if one agrees to fewer digits than required."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.certification import certify_all
    from gnomon.harness.certification.certify import write
    from gnomon.harness.registry import selection
    from gnomon.harness.running import plan
    from gnomon.harness.system.progress import Progress

    options.validate_workers(workers)
    wanted = selection.expand([*(case or ()), *(named or ())], checks=True)
    if suite is not None and wanted:
        raise ValueError(f"--suite {suite}: name cases or a suite, not both")
    subjects = certify_all.subjects(wanted or (() if suite is None else plan.suite(suite).scope.cases), everything)
    if independent is not None:
        if independent.resolve() == to.resolve():
            raise ValueError(f"--independent {independent}: the certificates go there; name another file")
        options.ensure_writable(independent, "--independent")  # before minutes of work, not after
    options.ensure_writable(to, "--out")
    certificates: list[Certificate] = []
    with Progress() as progress:
        progress.begin("certificates", len(subjects))
        for certificate in certify_all.certificates(subjects, workers):
            certificates.append(certificate)
            progress.advance()
    out.print(certificates_table(certificates))
    seconds = sum(certificate.seconds for certificate in certificates)
    out.print(f"{len(certificates)} certificates in {seconds / 60:.1f} minutes of processor time", highlight=False)
    write(certificates, to)
    if independent is not None:
        from gnomon.harness.certification import independent_checks

        names = {name for name, _ in subjects}
        checks = [check for check in independent_checks.everything() if check.name in names]
        # One at a time: their times are compared.
        independent_checks.write(independent_checks.run_checks(checks), independent)
        out.print(f"independent computations of the checks: {independent}", highlight=False)
    failed = [certificate for certificate in certificates if not certificate.passed]
    if failed:
        out.print(f"{len(failed)} agree to fewer digits than required")
        raise typer.Exit(1)


def certificates_table(certificates: Iterable[Certificate]) -> Table:
    """The digits of each certificate: in total and by each way of confirmation."""
    table = Table("case", "variant", "digits agreed", "by", title="Exact motions, confirmed")
    for certificate in certificates:
        ways = ", ".join(f"{way} {digits:.0f}" for way, digits in certificate.ways.items())
        colour = "green" if certificate.passed else "red"
        digits = f"[{colour}]{certificate.digits:.0f}[/]"
        table.add_row(certificate.case, certificate.variant, digits, ways or escape(certificate.note))
    return table

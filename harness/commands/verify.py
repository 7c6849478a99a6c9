"""`gnomon verify`: test the claims about an integrator against exact motions."""

from __future__ import annotations

import math
import os
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out, problems
from gnomon.harness.results.visible import visible
from rich.markup import escape

if TYPE_CHECKING:
    from gnomon.harness.contract.integrator import Integrator
    from gnomon.harness.registry.selection import CaseLike
    from gnomon.harness.verification.baseline import Baseline
    from gnomon.harness.verification.other_version import Other
    from gnomon.harness.verification.verification_report import Known
    from gnomon.harness.verification.verify import Report, Row


KnownFailures = Annotated[
    Path | None,
    typer.Option(help="A text file of known failures, a line each: CLAIM CASE REASON.", exists=True, dir_okay=False),
]
BaselineFile = Annotated[
    Path | None, typer.Option(help="Compare with a file of `gnomon baseline write`.", exists=True, dir_okay=False)
]
Against = Annotated[
    str | None, typer.Option(help="Compare the time with another version of a package, as mypackage==1.2.")
]
Fmu = Annotated[
    Path | None,
    options.path_option(
        "An FMU for one --case: co-simulation at several communication steps, model exchange by --integrator."
    ),
]
Columns = Annotated[
    list[str] | None, typer.Option(help="Variables of the FMU, as phi=theta:deg,length=L:m; by default by their names.")
]
Picture = Annotated[
    Path | None, options.path_option("Draw the one --claim on the one --case to this file: .svg, .png or .html.")
]


def verify(
    integrator: options.IntegratorArgument = None,
    named: options.IntegratorOption = None,
    command: options.Programs = None,
    engine: options.Engine = None,
    fmu: Fmu = None,
    columns: Columns = None,
    order: options.FmuOrder = None,
    case: options.Cases = None,
    parameters: options.Parameters = None,
    claim: options.Claims = None,
    depth: options.Depth = "normal",
    max_seconds: options.MaxSeconds = None,
    every: options.Every = False,
    json_path: Annotated[Path | None, options.path_option("Write the result as JSON.", "--json")] = None,
    junit: Annotated[Path | None, options.path_option("Write the result as JUnit XML.")] = None,
    markdown: Annotated[Path | None, options.path_option("Write a summary for a pull request in Markdown.")] = None,
    badge: Annotated[Path | None, options.path_option("Write a badge as JSON for shields.io's endpoint.")] = None,
    known_failures: KnownFailures = None,
    baseline: BaselineFile = None,
    against: Against = None,
    picture: Picture = None,
    workers: Annotated[int, typer.Option(help="Cases at a time, each in a process.")] = 2,
) -> None:
    """Verify an integrator: order, error, conservation, repeatability, bad input, hard variants, events.

    With --engine also the pre-flights of a physics engine: damping, limits, sleeping, frames, joints, contacts.
    Exit code 1 if a claim failed whose failure is not known, if the first trial raises, if it is worse than the
    baseline or slower than another version; 2 if nothing failed, but on some case it was not checked that the integrator
    follows the exact motion with the accuracy that it declares, or a named claim was not checked.
    """
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.verification import verification_report
    from gnomon.harness.verification.baseline import case_names, read

    integrator = options.one_of(options.one_of(integrator, named, "integrator"), engine, "engine")
    if parameters and (not case or baseline or against):
        raise ValueError("--set changes the numbers of a --case, and goes neither with --baseline nor with --against")
    on: list[CaseLike] = [c for c, _ in options.choose(case, False, parameters)] if parameters else [*(case or ())]
    asked = _Asked(on, depth, claim, max_seconds, workers, every)
    _validate(integrator, against, picture, asked)
    _validate_fmu(fmu, columns, order, (command, engine, against, baseline))
    known = verification_report.read_known(known_failures) if known_failures is not None else {}
    base = read(baseline) if baseline is not None else None
    names = case_names(base, case or ()) if base is not None else []
    files = {"json": json_path, "junit": junit, "markdown": markdown, "badge": badge}
    for kind, path in files.items():
        if path is not None:
            options.ensure_writable(path, f"--{kind}")
    chosen, how = (
        options.integrator_or_program(integrator, command)
        if fmu is None
        else _read_fmu(fmu, asked, columns, order, integrator)
    )
    how = how if engine is None else f"--engine {how}"
    how += "".join(f" --set {shlex.quote(text)}" for text in parameters or ())
    report = _verify(chosen, asked, known, (integrator, against), engine is not None)
    _show(report, known, how)
    if picture is not None:
        _draw(chosen, on[0], report, picture)
    for kind, path in files.items():
        if path is not None:
            path.write_text(verification_report.WRITERS[kind](report, known, how), encoding="utf-8")
    worse = base is not None and _is_worse(base, names, chosen, workers)
    if code := verification_report.exit_code(report, known) or int(worse):
        raise typer.Exit(code)


@dataclass(frozen=True)
class _Asked:
    """The options that say what is verified, as in `verify`."""

    case: list[CaseLike]
    depth: str
    claim: list[str] | None
    seconds: float | None
    workers: int
    every: bool


def _validate(integrator: str | None, against: str | None, picture: Path | None, asked: _Asked) -> None:
    """Raise ValueError for options that do not fit together."""
    from gnomon.harness.studies import preflight
    from gnomon.harness.verification.claims import TIME

    case, claim, seconds = asked.case, asked.claim, asked.seconds
    options.validate_workers(asked.workers)
    if seconds is not None and not seconds > 0:
        raise ValueError(f"--max-seconds {seconds:g}: give a positive number of seconds")
    if picture is not None and any(name in preflight.TEXTS for name in claim or ()):
        raise ValueError(f"--picture {picture}: a pre-flight has no picture")
    if against is not None and integrator is None:
        raise ValueError("--against compares versions of a Python package; a program of --command has none")
    if against is None and TIME in (claim or ()):
        raise ValueError(f"--claim {TIME} needs the other version: --against mypackage==1.2")
    if picture is not None:
        options.ensure_drawing(picture, "--picture")
        if len(case) != 1 or len(claim or ()) != 1 or against is not None:
            raise ValueError(f"--picture {picture} draws one claim on one case; give one --case and one --claim")


def _validate_fmu(
    fmu: Path | None, columns: list[str] | None, order: int | None, others: tuple[str | Path | None, ...]
) -> None:
    """Raise ValueError for options that go with --fmu only, or not with it."""
    if fmu is None:
        for name, value in (("columns", columns), ("order", order)):
            if value is not None:
                raise ValueError(f"--{name} is about the FMU of --fmu; name one, as --fmu model.fmu")
        return
    for name, other in zip(("command", "engine", "against", "baseline"), others, strict=True):
        if other is not None:
            raise ValueError(f"--fmu {fmu} does not go with --{name} {other}; leave one out")


def _read_fmu(
    path: Path, asked: _Asked, columns: list[str] | None, order: int | None, method: str | None
) -> tuple[Integrator, str]:
    """The integrator of an FMU on the one case that was asked for, and the words that name it; prints the mapping."""
    from gnomon.harness.registry import selection
    from gnomon.harness.trajectories.fmu_columns import from_fmu

    cases = selection.find_cases(asked.case)
    if len(cases) != 1:
        raise ValueError(f"--fmu {path} is a model of one case; name it, as --case pendulum_simple")
    chosen, mapping = from_fmu(path, cases[0], columns, order=order, method=method)
    problems.print(
        escape(f"an FMU is a program: {path} runs in a process of its own, with your rights"), highlight=False
    )
    for line in mapping:
        out.print(escape(visible(line)), highlight=False)
    words = [f"--fmu {shlex.quote(str(path))}", *(f"--columns {shlex.quote(text)}" for text in columns or ())]
    words += [f"--order {order}"] if order is not None else []
    words += [f"--integrator {shlex.quote(method)}"] if method is not None else []
    return chosen, " ".join(words)


def _verify(
    chosen: Integrator, asked: _Asked, known: Known, versions: tuple[str | None, str | None], engine: bool
) -> Report:
    """Verify and give the report; prints each row as soon as it is measured, a failure with its detail.

    Exits with 1 and the traceback if the first trial raises. `versions`: the integrator as it was named, and the
    requirement of the other version, None if time is not compared. `engine`: whether pre-flights run too.
    """
    from gnomon.harness.studies import preflight
    from gnomon.harness.studies.energy_at_practical_steps import describe_energy
    from gnomon.harness.verification.claims import Outcome
    from gnomon.harness.verification.diagnosis import ENDLESS
    from gnomon.harness.verification.engine_preflights import preflight_rows
    from gnomon.harness.verification.other_version import install
    from gnomon.harness.verification.verify import SETTLED, FirstTrialError, Report
    from gnomon.harness.verification.verify import verify as verify_

    def show(row: Row) -> None:
        if row.finding.outcome not in SETTLED:
            return
        finding, detail = row.finding, ""
        if finding.outcome == Outcome.FAILED and (row.claim, row.case) not in known:
            detail = f"{', ' * bool(finding.setting)}{finding.setting}: {finding.got}, expected {finding.expected}"
        out.print(escape(visible(f"{finding.outcome:6} {row.claim} on {row.case}{detail}")), highlight=False)

    named, against = versions
    other = None if against is None else install(against)
    ends = math.inf if asked.seconds is None else monotonic() + asked.seconds
    rows = []
    if engine:
        rows = preflight_rows(chosen, asked.case, asked.depth, asked.claim, asked.workers, show, ends)
    claims = [name for name in asked.claim or () if not (engine and name in preflight.TEXTS)]
    if asked.claim and not claims:
        return Report(chosen.id, asked.depth, rows, claims=tuple(asked.claim))
    left = None if asked.seconds is None else max(ends - monotonic(), 0.0)
    try:
        report = verify_(chosen, asked.case, asked.depth, claims, left, asked.workers, show, asked.every)
    except FirstTrialError as error:
        problems.print(escape(str(error).rstrip()), highlight=False)
        problems.print("nothing was verified: the first trial raised")
        raise typer.Exit(1) from None
    report.rows[:0] = rows
    report.claims = tuple(asked.claim or ())
    if not asked.claim and not (report.diagnosis or "").startswith(ENDLESS):
        report.notes += describe_energy(chosen, asked.case, ends)
    if named is not None and against is not None and other is not None:
        _compare(chosen, asked.case, report, (named, against), other, show)
    return report


def _compare(
    chosen: Integrator,
    case: list[CaseLike],
    report: Report,
    against: tuple[str, str],
    other: Other,
    show: Callable[[Row], None],
) -> None:
    """Add to a report the claim that the integrator needs no more time than another version, on default variants."""
    from gnomon.harness.verification.against import compare_versions
    from gnomon.harness.verification.claims import TIME
    from gnomon.harness.verification.verify import Row, plan_verification

    names = [each.id for each, _ in plan_verification(chosen, case, report.depth)]
    named, requirement = against
    versions, findings = compare_versions(
        named, [name for name in names if "/" not in name] or names, report.depth, other
    )
    report.against = requirement, versions
    for name, finding in findings.items():
        report.rows.append(Row(TIME, name, finding))
        show(report.rows[-1])


def _draw(chosen: Integrator, case: CaseLike, report: Report, path: Path) -> None:
    """Draw the only row of a report."""
    from gnomon.harness.reporting.pictures.failure_picture import draw

    if report.rows:
        draw(chosen, report.depth, report.rows[0], case, path)
        out.print(f"drawn: {escape(str(path))}", highlight=False)


def _show(report: Report, known: Known, how: str) -> None:
    """Print a report, and for GitHub Actions its annotations."""
    from gnomon.harness.verification.verification_report import lines, workflow_commands

    for line in lines(report, known, how):
        out.print(escape(line), highlight=False)
    for line in workflow_commands(report, known, how) if os.environ.get("GITHUB_ACTIONS") == "true" else []:
        print(line)


def _is_worse(base: Baseline, names: list[str], integrator: Integrator, workers: int) -> bool:
    """Run an integrator on the cases of a baseline and print the differences; True if it is worse or not compared."""
    from gnomon.harness.verification.baseline import compare_with_baseline, measure

    verdict = compare_with_baseline(base, measure(integrator, names, base.depth, runs=1, workers=workers))
    for line in verdict.notes:
        out.print(escape(line), highlight=False)
    for line in verdict.regressions:
        out.print(f"[red]worse[/] {escape(line)}", highlight=False)
    for line in verdict.summary():
        out.print(escape(f"baseline: {line}"), highlight=False)
    return verdict.failed

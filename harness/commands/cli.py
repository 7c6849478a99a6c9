"""The command line. Exit codes: 0 passed, 1 a check failed, 2 wrong usage, 130 interrupted."""

from __future__ import annotations

import errno
import os
import shlex
import sys
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from gnomon.harness.commands import interruption, listing
from gnomon.harness.results.visible import visible

if TYPE_CHECKING:
    from gnomon.cases import Case, Check
    from gnomon.harness.contract.integrator import Integrator
from rich.console import Console
from rich.markup import escape

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Reads integrators of classical mechanics against exact motions, in error and in speed.",
)
TABLE_WIDTH = 150
INTEGRATORS_WIDTH = 96
"""The ids are to be copied, so they are never cut."""
out = Console(soft_wrap=True, emoji=False)
problems = Console(stderr=True, soft_wrap=True, emoji=False)


class Listed(StrEnum):
    """What `gnomon list` lists."""

    cases = "cases"
    checks = "checks"
    integrators = "integrators"


class ExportFormat(StrEnum):
    """What `gnomon export` writes."""

    csv = "csv"
    json = "json"
    parquet = "parquet"


USAGE: Any = typer.BadParameter.__mro__[1]
"""What the parser raises for a command line that it does not understand, wherever this release of Typer keeps it."""

FULL = (errno.ENOSPC, errno.EDQUOT)
WRITING = (*FULL, errno.EACCES, errno.EROFS, errno.ENOENT, errno.EEXIST, errno.ENOTDIR, errno.EISDIR)

SHORTEST_LIMIT, LONGEST_LIMIT = 1e-6, 1e6
"""Seconds: below, no clock tells two calls apart; above are eleven days."""
MOST_WORKERS = 256
PART = ".part.1234567.123456789012345."
"""As long as the beginning of the name under which a file is written until it is whole."""


def _path(given: str | Path) -> Path:
    """A path of the command line, or a default; wrong usage where no file can have this name."""
    text = str(given)
    if not text.strip():
        raise typer.BadParameter("an empty name; give a path")
    try:
        os.stat(text)
    except FileNotFoundError:
        pass
    except OSError as error:
        if error.errno in (errno.ENAMETOOLONG, errno.ELOOP):
            raise typer.BadParameter(f"{_cut(text)}: {error.strerror}; give another path") from None
    except ValueError as error:  # a zero byte, half a surrogate pair
        raise typer.BadParameter(f"{_cut(text)}: {error}; give another path") from None
    return Path(text)


def _cut(text: str) -> str:
    """A long text by its ends: a path is known by its last part."""
    return text if len(text) <= 160 else f"{text[:60]}...{text[-60:]}"


Settings = Annotated[list[str] | None, typer.Option("--set", help="A parameter of the case, name=value; repeatable.")]


def main() -> None:
    """Run the command line; wrong usage is one line and exit code 2, never a traceback; Ctrl-C ends it with 130."""
    sys.path.append(os.getcwd())  # so that a user's own module:Class is found where they stand
    warnings.showwarning = _warning
    with interruption.acknowledged() as asked:
        code = _exit_code()
        sys.exit(interruption.INTERRUPTED if asked.is_set() else code)


def _exit_code() -> int:
    try:
        return int(app(prog_name="gnomon", standalone_mode=False) or 0)
    except SystemExit as end:  # none of ours: those of Typer end as a result
        told = (
            f"SystemExit: what was imported or called ended with sys.exit({end.code!r}); nothing vouches for its result"
        )
    except (ValueError, OSError, ArithmeticError) as error:
        told = f"{type(error).__name__}: {error}" if isinstance(error, ArithmeticError) else str(error)
        if isinstance(error, OSError) and error.errno in WRITING:
            way_out = "free some space or name" if error.errno in FULL else "name"
            told = f"{error.filename or 'the disk'}: {error.strerror}; {way_out} another place to write to"
    except (KeyboardInterrupt, typer.Abort):
        return interruption.INTERRUPTED
    except USAGE as error:
        if len(sys.argv) == 1:
            error.show()  # `gnomon` alone: its help
            return 2
        message = error.format_message().replace("Value error, ", "")  # words of a library beneath, for nobody
        told = f"{message} (see {error.ctx.command_path if error.ctx else 'gnomon'} --help)"
    problems.print(f"[bold red]error:[/] {escape(_line(told))}")
    return 2


def _line(text: str) -> str:
    """On one line, with nothing that a terminal would obey."""
    return visible(" ".join(text.split()))


def _warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """A warning as one line, without the line of code that it comes from."""
    problems.print(f"[bold yellow]warning:[/] {escape(_line(str(message)))}", highlight=False)


@app.command("list")
def list_(what: Annotated[Listed | None, typer.Argument(help="One of these; all without it.")] = None) -> None:
    """List cases, checks (rows without motion) and integrators."""
    if what in (None, Listed.cases):
        out.print(listing.cases_table())
    if what in (None, Listed.checks):
        out.print(listing.checks_table())
    if what in (None, Listed.integrators):
        Console(width=max(out.width, INTEGRATORS_WIDTH), emoji=False).print(listing.integrators_table())


@app.command()
def show(
    case: Annotated[str, typer.Argument(help="A case, case/variant or package.module:Case; a check or check/variant.")],
    parameters: Settings = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw the motion to this file: .svg, .png or .html.", parser=_path)
    ] = None,
) -> None:
    """Print a case: equations, parameters, quantities, variants; draw its motion to a file."""
    # slow to load: each command imports what it runs, `gnomon --help` none of it
    from gnomon.harness.commands.show import DRAWINGS, describe, draw
    from gnomon.harness.commands.show_check import describe_check

    from gnomon import cases

    if plot is not None and plot.suffix not in DRAWINGS:
        raise ValueError(f"--plot {plot}: a drawing is {', '.join(DRAWINGS)}")
    if case.partition("/")[0] in cases.check_names():
        if plot is not None:
            raise ValueError(f"{case} is a check, without motion: there is nothing to draw")
        describe_check(_chosen_check(case, parameters), out)
        return
    (chosen,) = _chosen([case], False, parameters, rounded=False)
    if plot is not None:
        _check_writable(plot, "--plot")
    describe(chosen[0], out)
    if plot is not None:
        draw(chosen[0], plot)
        out.print(f"The motion is drawn in {plot}.")


@app.command()
def run(
    case: Annotated[
        list[str] | None, typer.Option(help="A case, case/variant or package.module:Case; repeatable.")
    ] = None,
    integrator: Annotated[
        list[str] | None, typer.Option(help="An id, name, library or package.module:Class; repeatable.")
    ] = None,
    suite: Annotated[str, typer.Option(help="standard, foundation, quick or catalogue.")] = "standard",
    out_path: Annotated[
        Path, typer.Option("--out", help="The results: a folder or a file.sqlite.", parser=_path)
    ] = Path("runs"),
    limit: Annotated[
        float | None,
        typer.Option(
            help="Seconds that one trial may take, without waiting for a busy processor; by default 1 on default"
            " settings, .08 on hard variants (up to .4 on long ones), .12 in the suite quick."
        ),
    ] = None,
    workers: Annotated[
        int,
        typer.Option(
            help="Trials at a time. Together they may take 80 % of the memory of the machine or of its cgroup, each an"
            " equal share.",
        ),
    ] = 2,
    parameters: Settings = None,
) -> None:
    """Run cases through integrators. The same command goes on where an interrupted run stopped.

    Exit code 1 where nothing was measured or an integrator of your own never succeeded.
    """
    from gnomon.harness.registry import lookup
    from gnomon.harness.running import first_trials, plan
    from gnomon.harness.running.progress import Progress
    from gnomon.harness.running.run import run as run_

    from gnomon import cases

    _check_workers(workers)
    chosen_suite = plan.suite(suite)
    if case:
        chosen_suite = replace(chosen_suite, rest=None)  # who names a case wants the whole of it
    without = [name for name in case or () if name.partition("/")[0] in cases.check_names()]
    if without:
        raise ValueError(f"{without[0]} is a check, without motion: `gnomon certify {without[0]}` confirms it")
    if limit is not None:
        if not SHORTEST_LIMIT <= limit <= LONGEST_LIMIT:
            raise ValueError(
                f"--limit {limit:g}: a trial needs a positive number of seconds,"
                f" from {SHORTEST_LIMIT:g} to {LONGEST_LIMIT:g}"
            )
        chosen_suite = chosen_suite.within(limit)
    integrators = lookup.find_all(integrator)
    if integrator:
        chosen_suite = replace(chosen_suite, near_duplicates=True)
    for one in integrators if integrator else ():
        reason = lookup.missing(one)
        if reason is not None:
            raise ValueError(f"{one.id} cannot run here: {reason}")
    chosen = _chosen(case or list(chosen_suite.cases), chosen_suite.variants, parameters)
    if not case:
        chosen = [one for one in chosen if chosen_suite.takes(one[0])]
    _check_results(out_path)
    try:
        crashes = first_trials.crashes(chosen, integrators, chosen_suite)
        if crashes:
            for text in crashes:
                problems.print(escape(text), highlight=False)
            problems.print("nothing was run: the first trials of these integrators crashed")
            raise typer.Exit(1)
        path = run_(
            out_path, chosen_suite, chosen, integrators, Progress(), workers, near_duplicates=bool(case or integrator)
        )
    except KeyboardInterrupt:
        problems.print("interrupted; the same command goes on from here")
        raise typer.Exit(130) from None
    _summarize(path, {one.name for one, _ in chosen}, integrators)


@app.command()
def report(
    run: Annotated[Path, typer.Argument(help="A results file or its folder.", parser=_path)],
    to: Annotated[Path, typer.Option(help="The folder to write to.", parser=_path)] = Path("reports/local"),
    case: Annotated[
        list[str] | None,
        typer.Option(
            help="A case that is not installed, package.module:Class; a results file never says what to import."
        ),
    ] = None,
) -> None:
    """Write the report of a run: one offline page, a summary and the figures."""
    from gnomon.cases.core.registry import case_class
    from gnomon.harness.reporting.report import write_report
    from gnomon.harness.results import opening
    from gnomon.harness.results.store import results_file

    database, given = results_file(run), {name: case_class(name) for name in case or ()}
    with opening.reading(database, ()):
        pass  # results of gnomon's, else no folder is made
    _check_folder(to, "--to")
    page = write_report(database, to, given)
    out.print(f"The report is {page}")


@app.command()
def compare(
    base: Annotated[Path, typer.Argument(help="The results to compare with.", parser=_path)],
    run: Annotated[Path, typer.Argument(help="The results to check.", parser=_path)],
    allow_missing: Annotated[
        bool, typer.Option("--allow-missing", help="Series of the base that the run lacks are no regression.")
    ] = False,
) -> None:
    """Check a run against a base: status, order, errors and right-hand sides.

    Exit code 1 where it got worse, where a series of the base is missing, has no setting left that is ok or none that
    can be compared; 2 where nothing can be compared. A timeout counts once the trial was tried three times, as limits
    below half a second have it.
    """
    from gnomon.harness.results.regression import compare as compare_
    from gnomon.harness.results.regression import reasons
    from gnomon.harness.results.store import load

    verdict = compare_(load(base), load(run), allow_missing)
    for line in verdict.notes:
        out.print(escape(line))
    for line in verdict.regressions:
        out.print(f"[red]worse[/] {escape(line)}")
    left_out = verdict.not_compared
    if left_out:
        out.print(f"{left_out.total()} settings of the base not compared: {escape(reasons(left_out))}", highlight=False)
    compared = f"{verdict.compared} series compared at {verdict.settings} settings"
    out.print(f"{compared}, {len(verdict.regressions)} regressions")
    if verdict.regressions:
        raise typer.Exit(1)


@app.command()
def certify(
    case: Annotated[
        list[str] | None, typer.Argument(help="Cases, case/variant or checks; all cases and checks without it.")
    ] = None,
    to: Annotated[Path, typer.Option(help="Where the certificates go, as JSON.", parser=_path)] = Path(
        "runs/certificates.json"
    ),
    suite: Annotated[str | None, typer.Option(help="Only the cases of this suite.")] = None,
    everything: Annotated[bool, typer.Option("--all", help="All variants too.")] = False,
    independent: Annotated[
        Path | None,
        typer.Option(
            help="Measure the independent computations of the checks too, and write them here, as JSON.", parser=_path
        ),
    ] = None,
    workers: Annotated[int, typer.Option(help="Processes at a time.")] = 2,
) -> None:
    """Confirm exact motions by independent ways. Exit code 1 below the required digits."""
    from gnomon.harness.certification import certify_all
    from gnomon.harness.certification.certify import Certificate, write
    from gnomon.harness.running import plan
    from gnomon.harness.running.progress import Progress

    _check_workers(workers)
    if suite is not None and case:
        raise ValueError(f"--suite {suite}: name cases or a suite, not both")
    settings = certify_all.settings(case or (() if suite is None else plan.suite(suite).cases), everything)
    if independent is not None:
        if independent.resolve() == to.resolve():
            raise ValueError(f"--independent {independent}: the certificates go there; name another file")
        _check_writable(independent, "--independent")  # before minutes of work, not after
    _check_writable(to, "--to")
    progress = Progress()
    certificates: list[Certificate] = []
    with progress:
        progress.begin("certificates", len(settings))
        for certificate in certify_all.certificates(settings, workers):
            certificates.append(certificate)
            progress.advance()
    out.print(listing.certificates_table(certificates))
    seconds = sum(certificate.seconds for certificate in certificates)
    out.print(f"{len(certificates)} certificates in {seconds / 60:.1f} minutes of processor time", highlight=False)
    write(certificates, to)
    if independent is not None:
        _measure_computations({name for name, _ in settings}, independent)
    failed = [certificate for certificate in certificates if not certificate.passed]
    if failed:
        out.print(f"{len(failed)} below the digits required of them")
        raise typer.Exit(1)


@app.command()
def export(
    run: Annotated[Path, typer.Argument(help="A results file or its folder.", parser=_path)],
    form: Annotated[ExportFormat, typer.Option("--format", help="What to write.")] = ExportFormat.csv,
    to: Annotated[Path | None, typer.Option(help="The file to write; results.FORMAT without it.", parser=_path)] = None,
    raw: Annotated[
        bool, typer.Option("--raw", help="Leave texts in a csv that a spreadsheet would take for formulas.")
    ] = False,
) -> None:
    """Write the measurements of a run as a table, one row each."""
    from gnomon.harness.results import store

    target = to or Path(f"results.{form.value}")
    database = store.results_file(run)
    _check_writable(target, "--to")
    if target.exists() and target.samefile(database):
        raise ValueError(f"--to {target}: these are the results; name another file")
    store.export(database, target, form.value, raw)
    out.print(f"wrote {target}")


@app.command()
def doctor() -> None:
    """Show what gnomon finds here: machine, libraries, and why an integrator is missing."""
    out.print(listing.environment_table())
    out.print(listing.libraries_table())


def _chosen(
    names: list[str] | None, variants: bool, parameters: list[str] | None, rounded: bool = True
) -> list[tuple[Case, str]]:
    from gnomon.harness.running import plan

    for position, name in enumerate(names or ()):
        if name in (names or ())[:position]:
            raise ValueError(f"--case {name}: named twice; name it once")
    given = _given(parameters)
    for reserved in {"variant", "initial_state", "span"} & set(given):
        raise ValueError(f"--set {reserved}: not a parameter; a variant is chosen by case/variant")
    return plan.choose(names, variants, rounded=rounded, **given)


def _check_workers(workers: int) -> None:
    if not 1 <= workers <= MOST_WORKERS:
        raise ValueError(f"--workers {_cut(str(workers))}: give a number of processes from 1 to {MOST_WORKERS}")


def _check_writable(path: Path, option: str) -> None:
    """Make the folder of a file to write; raise ValueError where the file could not be written."""
    if path.is_dir():
        raise ValueError(f"{option} {path} is a folder; name a file in it")
    if path.exists() and not path.is_file():  # it would be replaced
        raise ValueError(f"{option} {path} is a device or a pipe; name a file")
    _check_folder(path.parent, option, path)


def _check_folder(folder: Path, option: str, file: Path | None = None) -> None:
    """Make a folder to write to; raise ValueError where nothing, or not `file`, can be written in it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Permissions alone do not tell: of a system's own folders, of a medium that is full.
        with tempfile.NamedTemporaryFile(dir=folder, prefix=PART, suffix=f".{file.name}" if file else ""):
            pass
    except OSError as error:
        raise ValueError(
            f"{option} {file or folder}: cannot be written ({error.strerror}); name another place with {option}"
        ) from None


def _check_results(path: Path) -> None:
    """Raise ValueError where the results of a run could not be written, or would go into a file that holds others."""
    from gnomon.harness.results import opening

    file = path if path.suffix == ".sqlite" else path / "results.sqlite"
    if file.is_file() and file.stat().st_size:
        with opening.reading(file, ()):
            pass  # results of gnomon's
    else:
        _check_writable(file, "--out")


def _measure_computations(names: set[str], to: Path) -> None:
    """All settings of the checks among the names, alone on the machine: their times are compared."""
    from gnomon.harness.certification import independent_checks

    chosen = [check for check in independent_checks.everything() if check.name in names]
    independent_checks.write(independent_checks.run_checks(chosen), to)
    out.print(f"independent computations of the checks: {to}", highlight=False)


def _given(parameters: list[str] | None) -> dict[str, str]:
    """The numbers of `--set name=value`."""
    given: dict[str, str] = {}
    for text in parameters or ():
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise ValueError(f"--set {text!r}: write name=value")
        if name in given:
            raise ValueError(f"--set {name}: given twice, {given[name]} and {value}; give it once")
        given[name] = value
    return given


def _chosen_check(name: str, parameters: list[str] | None) -> Check:
    from gnomon import cases

    check, _, variant = name.partition("/")
    return cases.get_check(check, variant or None, **_given(parameters))


def _summarize(path: Path, names: set[str], integrators: Sequence[Integrator]) -> None:
    from gnomon.harness.commands.run_table import run_table, shortcomings
    from gnomon.harness.registry.lookup import users_own
    from gnomon.harness.results.store import load
    from gnomon.harness.results.values import SCORED

    frame = load(path)
    frame = frame[frame["case"].isin(names) & frame["integrator_id"].isin([one.id for one in integrators])]
    if not frame.empty:
        Console(width=max(out.width, TABLE_WIDTH), emoji=False).print(run_table(frame))
    counts = ", ".join(f"{count} {status}" for status, count in frame["status"].value_counts().items())
    out.print(f"{len(frame)} measurements: {counts}", highlight=False)
    interrupted = frame[frame["status"] == "interrupted"]
    if len(interrupted):
        reasons = ", ".join(interrupted["reason"].unique()[:3])
        text = f"{len(interrupted)} trials were interrupted ({reasons}); the same command runs them again"
        problems.print(escape(text), highlight=False)
    out.print(f"results: {path}", highlight=False)
    if frame["status"].isin(SCORED).any():
        out.print(f"its report: gnomon report {shlex.quote(str(path))}", highlight=False)
    failed = shortcomings(frame, [one for one in integrators if users_own(one)])
    for text in failed:
        problems.print(escape(text), highlight=False)
    if failed:
        raise typer.Exit(1)

"""`gnomon run`: run integrators on cases and write a results file."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

import typer
from gnomon.harness.commands import interruption, options
from gnomon.harness.commands.cluster_options import Dask, Shard, TimingChoice, TimingOption, part
from gnomon.harness.commands.equations import best_after, read_problem, refuse_beside
from gnomon.harness.commands.options import Shown, out, problems
from gnomon.harness.contract.status import SCORED
from rich.markup import escape

if TYPE_CHECKING:
    from gnomon.cases import Case
    from gnomon.harness.contract.integrator import Integrator
    from gnomon.harness.reporting.live_page import LivePage
    from gnomon.harness.running.plan import Suite

Row = Mapping[str, Any]
TABLE_WIDTH = 150
LAST_PAGE_SECONDS = 120.0
"""Seconds that the page of an interrupted run may take; for a standard run it takes some 10 s of processor time."""
SHORTEST_LIMIT, LONGEST_LIMIT = 1e-6, 1e6
"""Seconds: about the resolution of a clock, and eleven days."""
SUITE = (
    "standard (the default), quick, foundation, hard, full, catalogue or engines. With it, a case that --case names runs as"
    " in the suite; without it, on its default variant in its own formulation, and case/* on all variants."
)
FORMULATIONS = "Run cases that --case names without --suite in their other formulations too."
WORKERS = "Trials at a time. Together they may use 80 % of the memory of the machine or of its cgroup, in equal shares."
MINUTES = (
    "Minutes within which open comparisons are launched again, up to eight launches, after all else; 0 for none. By default"
    " those of the suite if no case and no integrator is named, once for a file."
)
REPEAT = (
    "Run again all trials, also those in the file, of the integrators that --integrator, --command or --library names; with"
    " none named, those that a cause outside ended (memory, again and again a signal)."
)
SETTINGS = (
    "Tolerances, or step sizes in the unit of time, to run at, as 1e-6,1e-9; by default the sweeps of the methods. In a run"
    " of methods of both kinds name the kind, repeatably: tolerance=1e-6,1e-9, then step=0.1,0.05."
)
Commands = Annotated[
    list[str] | None,
    typer.Option(help="A program that reads problems and writes states, as './mysolver --fast'; repeatable."),
]
TrialLimit = Annotated[
    float | None,
    typer.Option(
        help="Seconds that one trial may take, without waits for a busy processor; by default 1 on default variants, .08 on"
        " hard variants (up to .4 on long ones), .12 in the suite quick."
    ),
]


def run(
    case: options.Cases = None,
    integrator: options.Integrators = None,
    command: Commands = None,
    library: options.Libraries = None,
    family: options.Families = None,
    kind: options.Kinds = None,
    suite: Annotated[str | None, typer.Option(help=SUITE)] = None,
    formulations: Annotated[bool, typer.Option("--formulations", help=FORMULATIONS)] = False,
    out_path: Annotated[Path, options.path_option("The results: a folder or a file.sqlite.", "--out")] = Path("runs"),
    limit: TrialLimit = None,
    workers: Annotated[int, typer.Option(help=WORKERS)] = 2,
    parameters: options.Parameters = None,
    shard: Shard = None,
    timing: TimingOption = TimingChoice.full,
    dask: Dask = None,
    report: options.Report = None,
    minutes: Annotated[float | None, typer.Option(help=MINUTES, min=0.0)] = None,
    repeat: Annotated[bool, typer.Option("--repeat", help=REPEAT)] = False,
    settings: Annotated[list[str] | None, typer.Option("--settings", help=SETTINGS)] = None,
    allow_missing: Annotated[bool, typer.Option("--allow-missing", help=options.OUTSTANDING)] = False,
    equations: options.Equations = None,
    span: options.Span = None,
    start: options.Start = None,
    numbers: options.Numbers = None,
    event: options.Events = None,
    accelerations: options.Accelerations = False,
    error: options.Error = 1e-9,
) -> None:
    """Run integrators on cases, or on your own equations. The same command resumes an interrupted run.

    Exit code 1 if nothing was measured, if trials are outstanding, or if an integrator of your own never succeeded.
    """
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.measuring.settings import choose_settings, read_settings
    from gnomon.harness.registry import selection
    from gnomon.harness.running import plan

    began = monotonic()
    options.validate_workers(workers)
    named = bool(case or integrator or command or equations)
    if equations is not None:
        refuse_beside({"--case": case, "--suite": suite, "--set": parameters, "--shard": shard, "--dask": dask})
        suite = "foundation"
    chosen_suite = _further(_suite(suite, case, limit, formulations), minutes, named, bool(shard or dask))
    chosen_suite = part(chosen_suite, shard, timing)
    chosen_suite = _adapt(chosen_suite, bool(case or integrator), repeat, bool(integrator or command or library))
    integrators = selection.integrators_of(_integrators(integrator or [], command or [], chosen_suite), library, kind)
    if settings:
        chosen_suite = chosen_suite.change(settings=choose_settings(read_settings(settings), integrators))
    if equations is not None:
        stated = (span, start, numbers), event, accelerations
        chosen, chosen_suite, integrators = read_problem(equations, *stated, chosen_suite, integrators, out_path)
    else:
        chosen = options.choose(case or chosen_suite.names(), bool(case) and chosen_suite.scope.variants, parameters)
        chosen = plan.with_timing_spans(selection.cases_of(chosen, family, kind), chosen_suite)
    options.ensure_results(out_path)
    page = _page(report, out_path, chosen)
    # The scenes of the suite `engines` are variants, on which all ways to drive an engine are compared.
    every = named or chosen_suite.scope.engines
    path = _measure(out_path, chosen_suite, chosen, integrators, workers, dask, every, page)
    with best_after(path, chosen, error if equations is not None else None):
        wanted = error if equations is not None else None
        _summarize(path, chosen, integrators, chosen_suite, page, allow_missing, began, wanted)


def _adapt(suite: Suite, by_name: bool, repeat: bool, are_named: bool) -> Suite:
    """The suite for cases and integrators `by_name`, which run with all methods that take them, and for --repeat.

    Repeated are all trials if their integrators `are_named`, else those that a cause outside ended.
    """
    from gnomon.harness.running import plan

    suite = suite.change(for_stiff=()) if by_name else suite
    again = plan.Repeat.ALL if are_named else plan.Repeat.FROM_OUTSIDE
    return suite.change(repeat=again) if repeat else suite


def _integrators(names: Sequence[str], commands: Sequence[str], suite: Suite) -> tuple[Integrator, ...]:
    """The integrators that are named, or else the suite's; ValueError for a named integrator that cannot run here."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.registry import lookup
    from gnomon.harness.verification.function_adapter import from_name

    named = (
        lookup.find_all([from_name(name) or name for name in names] or suite.scope.integrators)
        if names or not commands
        else ()
    )
    if not names:
        named = suite.methods(named)
    integrators = (*named, *_programs(commands))
    for integrator in integrators if names else ():
        reason = lookup.missing(integrator)
        if reason is not None:
            raise ValueError(f"{integrator.id} cannot run here: {reason}")
    return integrators


def _measure(
    out_path: Path,
    suite: Suite,
    chosen: Sequence[tuple[Case, str]],
    integrators: Sequence[Integrator],
    workers: int,
    dask: str | None,
    near_duplicates: bool,
    page: LivePage | None,
) -> Path:
    """Run the trials and write the page, also after Ctrl-C or an error; returns the file of the results.

    Nothing runs if one of the first trials crashes.
    """
    from gnomon.harness.cluster.connection import Lost
    from gnomon.harness.cluster.dask_run import run as run_on_cluster
    from gnomon.harness.running import first_trials
    from gnomon.harness.running.planned_run import run as run_
    from gnomon.harness.system.progress import Progress

    try:
        crashes = first_trials.crashes(chosen, integrators, suite)
        if crashes:
            for text in crashes:
                problems.print(escape(text), highlight=False)
            problems.print("nothing was run: the first trials of these integrators crashed")
            raise typer.Exit(1)
        if dask is not None:
            return run_on_cluster(out_path, suite, chosen, integrators, dask, Progress(), workers, near_duplicates)
        progress = Progress(interlude=page)
        return run_(out_path, suite, chosen, integrators, progress, workers, near_duplicates=near_duplicates)
    except Lost as error:
        problems.print(escape(f"{error}; {_same_command(suite)} resumes the run"), highlight=False)
        raise typer.Exit(1) from None
    except KeyboardInterrupt:
        problems.print(f"interrupted; {_same_command(suite)} resumes the run")
        if page is not None:
            problems.print("writing the report of the trials so far; Ctrl-C again ends at once")
            interruption.allow(LAST_PAGE_SECONDS)
        raise typer.Exit(130) from None
    finally:
        if page is not None:
            page.write()


def _page(folder: Path | None, out_path: Path, chosen: Sequence[tuple[Case, str]]) -> LivePage | None:
    """The page that the run writes into `folder`."""
    if folder is None:
        return None
    from gnomon.harness.system import extras

    extras.require("report", "--report")
    from gnomon.harness.reporting.live_page import LivePage

    options.ensure_folder(folder, "--report")
    cases = {case.name: type(case) for case, _ in chosen if not type(case).__module__.startswith("gnomon.cases.")}
    return LivePage(out_path, folder, lambda text: problems.print(escape(text), highlight=False), cases)


def _programs(commands: Sequence[str]) -> list[Integrator]:
    """The integrators that are programs; ValueError for two programs with one name."""
    from gnomon.harness.verification.program_adapter import from_command

    programs: dict[str, Integrator] = {}
    for command in commands:
        program = from_command(command)
        if program.id in programs:
            raise ValueError(
                f"--command {command!r}: the name {program.name} belongs to another one; give each its own name"
            )
        programs[program.id] = program
    return list(programs.values())


def _suite(name: str | None, cases_named: list[str] | None, limit: float | None, formulations: bool) -> Suite:
    """The suite with the changes of the command line; ValueError for checks and for an invalid limit."""
    from gnomon.harness.running import plan

    from gnomon import cases

    suite = plan.suite("standard" if name is None else name)
    if cases_named:
        suite = suite.change(rest=None)  # a case that is named has the limits of a foundation case
        if name is None:
            suite = suite.change(variants=False, formulations=formulations)
    without = [name for name in cases_named or () if name.partition("/")[0] in cases.check_names()]
    if without:
        raise ValueError(f"{without[0]} is a check, without motion: `gnomon certify {without[0]}` confirms it")
    if limit is None:
        return suite
    if not SHORTEST_LIMIT <= limit <= LONGEST_LIMIT:
        raise ValueError(
            f"--limit {limit:g}: a trial needs a positive number of seconds,"
            f" from {SHORTEST_LIMIT:g} to {LONGEST_LIMIT:g}"
        )
    return suite.within(limit)


def _same_command(suite: Suite) -> str:
    """The words for the command that resumes an interrupted run; --repeat would make it begin again."""
    return f"the same command{' without --repeat' if suite.repeat else ''}"


def _further(suite: Suite, minutes: float | None, named: bool, divided: bool) -> Suite:
    """The suite with the minutes that the user gave; without any, a run of named cases or integrators repeats nothing.

    Raises ValueError for minutes in a divided run.
    """
    if minutes and divided:
        raise ValueError(
            f"--minutes {minutes:g}: repeated launches need all series on one machine; give it without --shard and"
            " --dask, with --out for the merged file"
        )
    if minutes is not None:
        return suite.change(minutes=minutes, minutes_with_peers=minutes, asked=True)
    return suite.once() if named or divided else suite


def _tell_end(path: Path, rows: Sequence[Row], suite: Suite, page: LivePage | None, began: float) -> None:
    """Print how many comparisons are open, whether the machine was under load, and the times of the run."""
    from gnomon.harness.results import reading, summary
    from gnomon.harness.results.number_text import duration_text, load_text
    from gnomon.harness.running import rounds

    record = reading.runs(path)[-1]["environment"].get(rounds.NAME) if suite.limits.minutes else None
    if record is not None:
        out.print(escape(record), highlight=False)
    load = load_text(summary.load_of((row["seconds_median"], row["delay_seconds"]) for row in rows))
    if load is not None:
        problems.print(load, highlight=False)
    first = page.first_seconds if page is not None else None
    text = "" if first is None else f"first page after {duration_text(first)}; "
    out.print(f"{text}complete after {duration_text(monotonic() - began)}", highlight=False)


def _summarize(
    path: Path,
    chosen: Sequence[tuple[Case, str]],
    integrators: Sequence[Integrator],
    suite: Suite,
    page: LivePage | None,
    allow_missing: bool,
    began: float,
    error: float | None,
) -> None:
    """Print the results of the run, and its missing trials; the exit code says whether the run failed."""
    from gnomon.harness.commands.run_table import (
        explain_outside_end,
        list_interrupted,
        run_table,
        shortcomings,
        statuses,
    )
    from gnomon.harness.registry.lookup import is_users_own
    from gnomon.harness.registry.selection import DEFAULT
    from gnomon.harness.results import reading, summary
    from gnomon.harness.results.number_text import tell_waits
    from gnomon.harness.system import extras

    wanted = {(c.name, (c.variant or DEFAULT) + label, method.id) for c, label in chosen for method in integrators}
    rows = [row for row in reading.rows(path) if (row["case"], row["variant"], row["integrator_id"]) in wanted]
    if rows:
        Shown(width=options.columns(TABLE_WIDTH), emoji=False).print(run_table(rows, error))
    counts = ", ".join(f"{count} {status}" for status, count in statuses(rows))
    out.print(f"{len(rows)} measurements: {counts}", highlight=False)
    waits = summary.count_waits((row["seconds_median"], row["delay_seconds"]) for row in rows)
    out.print(tell_waits(*waits), highlight=False)
    _tell_end(path, rows, suite, page, began)
    outstanding, outside = list_interrupted(rows), explain_outside_end(rows)
    if outstanding:
        reasons = ", ".join([*dict.fromkeys(str(row["reason"]) for row in outstanding)][:3])
        text = f"{len(outstanding)} trials were interrupted ({reasons}); {_same_command(suite)} runs them again"
        problems.print(escape(text), highlight=False)
    if outside is not None:
        problems.print(escape(f"{outside}; with --repeat they run again"), highlight=False)
    out.print(f"results: {path}", highlight=False)
    if page is not None and page.written is not None:
        out.print(f"its report: {page.written}", highlight=False)
    elif any(row["status"] in SCORED for row in rows):
        first = f"{extras.install('report')}, then " if extras.lacking("report") else ""
        out.print(escape(f"its report: {first}gnomon report {shlex.quote(str(path))}"), highlight=False)
    part_ = suite.shard != (1, 1)
    if part_:  # another shard may have the series of an integrator, or all series
        integrators = [method for method in integrators if method.id in {row["integrator_id"] for row in rows}]
    failed = [] if part_ and not rows else shortcomings(rows, [o for o in integrators if is_users_own(o)])
    for text in failed:
        problems.print(escape(text), highlight=False)
    if failed or (len(outstanding) and not allow_missing):
        raise typer.Exit(1)

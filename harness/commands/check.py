"""`gnomon check`: how wrong the trajectory in a file is."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out
from gnomon.harness.results.visible import visible
from rich.markup import escape

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gnomon.cases import Case
    from gnomon.harness.trajectories.check import Bound, Span, TrajectoryCheck

Files = Annotated[
    list[Path] | None,
    typer.Argument(
        help="A file with times and coordinates: CSV or other text, NPZ, MAT, HDF5, Parquet, JSON lines; several with --step.",
        parser=options.as_path,
    ),
]
Columns = Annotated[
    list[str] | None,
    typer.Option(help="What columns are, as time=t,phi=theta:deg,w=omega:deg/s; by default by their names."),
]
Within = Annotated[
    str | None,
    typer.Option(help="The largest error: of the size of the motion, or by coordinate as theta=1e-6,omega=1e-5."),
]


def check(
    files: Files = None,
    case: options.CaseOption = None,
    parameters: options.Parameters = None,
    columns: Columns = None,
    within: Within = None,
    first: Annotated[
        float | None, typer.Option("--from", help="The motion must be there from this time on (s).")
    ] = None,
    last: Annotated[float | None, typer.Option("--to", help="The motion must be there up to this time (s).")] = None,
    step: Annotated[
        list[float] | None, typer.Option(help="The step size of each file (s); repeatable: gives the order.")
    ] = None,
    sort: Annotated[bool, typer.Option("--sort", help="Sort rows whose times do not rise.")] = False,
    sparse: Annotated[bool, typer.Option("--sparse", help="Accept gaps longer than 2 pi time scales.")] = False,
    partial: Annotated[
        bool, typer.Option("--partial", help="Compare the coordinates that have a column, without the others.")
    ] = False,
    template: Annotated[
        str | None, typer.Option(help="Print what is needed to make a file for this case, as TOML, and end.")
    ] = None,
    json_path: Annotated[Path | None, options.path_option("Write the result as JSON.", "--json")] = None,
    junit: Annotated[Path | None, options.path_option("Write the result as JUnit XML.")] = None,
    markdown: Annotated[Path | None, options.path_option("Write a summary for a pull request in Markdown.")] = None,
    picture: Annotated[
        Path | None, options.path_option("Draw motion and error of the one file to this file: .svg, .png or .html.")
    ] = None,
) -> None:
    """Compare a trajectory from a file with the exact motion: errors, phase, period, drifts, events, digits.

    Exit code 0 if the error is within --within, 1 if it is not; 2 if that was not checked, or without --within.
    """
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.trajectories import check_report
    from gnomon.harness.trajectories.check import ACCEPTED

    if template is not None:
        _print_template(template, files, parameters)
        return
    steps = list(step or ())
    _validate(files, steps, picture)
    assert files
    written = {"json": json_path, "junit": junit, "markdown": markdown}
    for kind, path in written.items():
        if path is not None:
            options.ensure_writable(path, f"--{kind}")
    if case is None:
        raise ValueError(f"--case: with which motion is {files[0]} compared? give a case, as --case pendulum_simple")
    chosen = _choose(case, parameters, "--case")
    accepted = [word for word, is_given in zip(ACCEPTED, (sort, sparse, partial), strict=True) if is_given]
    results = _check_files(files, chosen, columns, within, (first, last), accepted)
    for result in results:
        for line in check_report.lines(result):
            out.print(escape(line), highlight=False)
    if steps:
        for line in check_report.order_lines(results, steps):
            out.print(escape(line), highlight=False)
    if picture is not None:
        _draw(results[0], picture)
    for kind, path in written.items():
        if path is not None:
            path.write_text(check_report.WRITERS[kind](results, steps), encoding="utf-8")
    _end(results)


def _print_template(name: str, files: Sequence[Path] | None, parameters: list[str] | None) -> None:
    from gnomon.harness.trajectories.template import template  # as above

    if files:
        raise ValueError(f"--template {name}: it reads no file; leave {files[0]} out")
    out.out(template(_choose(name, parameters, "--template"), tuple(parameters or ())), end="", highlight=False)


def _validate(files: Sequence[Path] | None, steps: Sequence[float], picture: Path | None) -> None:
    """Raise ValueError for options that do not fit together."""
    if not files:
        raise ValueError("name a file with a motion, as trajectory.csv; --template CASE prints what it needs")
    if steps and len(steps) != len(files):
        raise ValueError(f"--step: {len(steps)} steps for {len(files)} files; give one for each, in the same sequence")
    if len(files) > 1 and not steps:
        raise ValueError(f"{files[1]}: a second file; give the step size of each with --step, or check one at a time")
    for each in steps:
        if not each > 0 or each == float("inf"):
            raise ValueError(f"--step {each:g}: give a positive step size")
    if len(set(steps)) < len(steps):
        raise ValueError(f"--step {max(steps, key=steps.count):g}: given twice; give a file for each step")
    if picture is not None:
        if len(files) > 1:
            raise ValueError(f"--picture {picture} draws one file; check one at a time")
        options.ensure_drawing(picture, "--picture")


def _choose(name: str, parameters: list[str] | None, option: str) -> Case:
    from gnomon import cases  # as above

    if name.partition("/")[0] in cases.check_names():
        raise ValueError(f"{option} {name}: a check of the catalogue has no motion; give a case, as pendulum_simple")
    return options.choose_one(name, parameters)


def _check_files(
    files: Sequence[Path],
    case: Case,
    columns: list[str] | None,
    within: str | None,
    span: Span,
    accepted: Sequence[str],
) -> list[TrajectoryCheck]:
    from gnomon.harness.trajectories.check import check as check_  # as above
    from gnomon.harness.trajectories.check import validate_bound

    bound = None if within is None else _bound(within)
    if bound is not None:
        validate_bound(bound, case)
    return [check_(case, file, columns=columns, within=bound, span=span, accept=accepted) for file in files]


def _bound(text: str) -> Bound:
    """The bound of `--within`: a number, or numbers by coordinate."""
    bounds: dict[str, float] = {}
    for part in text.split(","):
        name, equals, value = (each.strip() for each in part.rpartition("="))
        try:
            number = float(value)
        except ValueError:
            raise ValueError(f"--within {part.strip()!r}: write an error as 1e-6, or theta=1e-6,omega=1e-5") from None
        if not equals and "," not in text:
            return number
        if not name or name in bounds:
            raise ValueError(f"--within {text!r}: write each coordinate once, as theta=1e-6,omega=1e-5")
        bounds[name] = number
    return bounds


def _draw(result: TrajectoryCheck, path: Path) -> None:
    from gnomon.harness.reporting.images import save  # as above

    if result.comparison is None:
        out.print("nothing is drawn: the file was not compared", highlight=False)
        return
    save(result.plot().to_dict(validate=False), path)
    out.print(f"drawn: {escape(str(path))}", highlight=False)


def _end(results: Sequence[TrajectoryCheck]) -> None:
    """End with the exit code of the worst result; for GitHub Actions with an annotation for each."""
    codes = [result.verdict.code for result in results]
    if os.environ.get("GITHUB_ACTIONS") == "true":
        for result in results:
            if result.verdict.code or (result.comparison is not None and result.comparison.part):
                text = visible(f"{result.trajectory.source}: {result.verdict.text}").replace("%", "%25")
                print(f"::{'error' if result.verdict.code else 'warning'} title=gnomon check::{text}")
    if any(codes):
        raise typer.Exit(1 if 1 in codes else 2)

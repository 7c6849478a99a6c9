"""`gnomon compare`: the changes of a run since an earlier one, and whether it is worse."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import Shown, out
from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    from gnomon.harness.results.regression import SeriesChange

TABLE_WIDTH = 150
NOTE = (
    "settings: those that both runs solved, to the finest; base, run: at the finest; ratio: run/base, the median over them; of"
    " times the geometric mean over those that one machine timed, with its 95 % interval; calls: right-hand sides"
)


def compare(
    base: Annotated[Path, typer.Argument(help="The earlier results.", parser=options.as_path)],
    run: Annotated[Path, typer.Argument(help="The results to compare with the base.", parser=options.as_path)],
    allow_missing: Annotated[
        bool,
        typer.Option(
            "--allow-missing",
            help="Series and settings without a result in the run, and outstanding trials, do not fail.",
        ),
    ] = False,
) -> None:
    """Compare a run with an earlier one: error, right-hand sides and time of every series, then status and order.

    Exit code 1 if the run is worse, if trials of one of the two are outstanding (planned, and interrupted or not run
    yet), or if a setting of the base is not compared: it has no result in the run, unless --allow-missing is given, or
    an error, a bound or a count is missing. 2 if nothing can be compared. A timeout counts as worse only after three
    tries, which limits below half a second allow.
    """
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.results import regression

    (before, lacking), (after, lacked) = _read(base), _read(run)
    verdict = regression.compare(before, after, allow_missing)
    changes = regression.changes(before, after)
    Shown(width=options.columns(TABLE_WIDTH), emoji=False).print(_table(changes))
    out.print(NOTE, highlight=False)
    for series in changes:
        if series.why:
            out.print(escape(f"{_name(series)}: no setting that both solved; {series.why}"), highlight=False)
    for line in (*verdict.notes, *regression.slower(changes)):
        out.print(escape(line))
    for line in verdict.regressions:
        out.print(f"[red]worse[/] {escape(line)}")
    for path, text in ((base, lacking), (run, lacked)):
        if text:
            out.print(escape(f"outstanding in {path}: {text}"), highlight=False)
    for line in verdict.summary():
        out.print(escape(line), highlight=False)
    if verdict.failed or ((lacking or lacked) and not allow_missing):
        raise typer.Exit(1)


def _table(changes: Sequence[SeriesChange]) -> Table:
    """Three rows a series: error, right-hand sides and time in both runs, and their ratios."""
    from gnomon.harness.results.number_text import error_text, figures_text, group_digits, time_text
    from gnomon.harness.results.regression import Change, TimeChange

    table = Table(box=SIMPLE_HEAD, padding=(0, 1))
    table.add_column("series", overflow="fold")
    table.add_column("settings", no_wrap=True)
    table.add_column("", no_wrap=True)
    for name in ("base", "run", "ratio"):
        table.add_column(name, justify="right", no_wrap=True)

    def count_text(count: float) -> str:
        return group_digits(round(count)) if math.isfinite(count) else "–"

    def ratio_text(ratio: float) -> str:
        return figures_text(ratio, 3) if 0.00995 <= ratio < 999.5 else error_text(ratio)

    def interval(change: Change) -> str:
        if not isinstance(change, TimeChange) or math.isnan(change.ratio):
            return ""
        return f" ({ratio_text(change.low)} – {ratio_text(change.high)}) {change.state}"

    for series in (each for each in changes if each.settings):
        settings = f"{series.settings}" + (f" to {series.setting:.3g}" if math.isfinite(series.setting) else "")
        lines = [
            (name, text(change.base), text(change.run), ratio_text(change.ratio) + interval(change))
            for name, text, change in (
                ("error", error_text, series.error), ("calls", count_text, series.calls), ("time", time_text, series.seconds)
            )
        ]  # fmt: skip
        table.add_row(escape(_name(series)), settings, *("\n".join(column) for column in zip(*lines, strict=True)))
    return table


def _name(series: SeriesChange) -> str:
    """The problem and the integrator of a series."""
    from gnomon.harness.results.number_text import problem_name
    from gnomon.harness.results.summary import OWN_NAMES

    case, variant, formulation, integrator = series.name
    own = OWN_NAMES["variant"], OWN_NAMES["formulation"]
    return f"{problem_name(case, *('' if name in own else name for name in (variant, formulation)))} {integrator}"


def _read(path: Path) -> tuple[list[dict[str, Any]], str]:
    """The measurements of one state of a file, and its outstanding trials, in words."""
    from gnomon.harness.results import opening
    from gnomon.harness.results.outstanding import outstanding
    from gnomon.harness.results.reading import rows

    with opening.one_state(path):
        return rows(path), outstanding(path).text

"""`gnomon recommend`: a method, its setting and its cost for a need or a kind of system, from published measurements."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer
from gnomon.harness.commands.options import out
from rich.markup import escape

if TYPE_CHECKING:
    from gnomon.harness.results.advice.recommendations import Table


def recommend(
    subject: Annotated[
        str | None,
        typer.Argument(help="A need or a kind of system, as stiff or gravitation; without one they are listed."),
    ] = None,
    error: Annotated[float | None, typer.Option("--error", help="The largest error wanted, as 1e-6.")] = None,
    library: Annotated[
        list[str] | None, typer.Option("--library", help="Only this library, as scipy; repeatable.")
    ] = None,
) -> None:
    """Recommend a method of each library, with its setting, its cost and the lines that run it.

    Each library answers with the method that its own manual names, chosen before the measurements. Nothing is
    recommended below five independent systems.
    """
    # Imported here and not above: `gnomon --help` starts without the modules that read the table.
    from gnomon.harness.adapters import libraries
    from gnomon.harness.results.advice import recommendations

    if subject is None:
        for key, (title, about) in recommendations.subjects().items():
            out.print(f"{key:12} {title}: {about}", highlight=False, markup=False)
        out.print("Next: gnomon recommend stiff --error 1e-6 --library scipy", highlight=False)
        return
    found = recommendations.find(subject, error, library or ())
    table = recommendations.read()
    out.print(f"[bold]{escape(found.title)}, error at most {found.error:g}[/]", highlight=False)
    out.print(found.about, highlight=False, markup=False)
    for row in found.rows:
        own = row["library"] == recommendations.OURS
        if own and len(found.rows) > 1:
            out.print("\ngnomon's own methods, which are not compared with the libraries above", highlight=False)
        for line in described(row, libraries.title(row["library"])):
            out.print(line, highlight=False, markup=False)
    out.print(f"\n{measured_by(table)}", highlight=False, markup=False)
    named = [row for row in found.rows if row["methods"] and not row["why"]]
    if len(named) == 1:
        _print_lines(table, named[0])
    elif named:
        out.print(
            f"Lines of code: gnomon recommend {found.subject} --error {found.error:g} --library {named[0]['library']}",
            highlight=False,
            markup=False,
        )


def described(row: Mapping[str, Any], title: str) -> Iterator[str]:
    """The lines on one answer."""
    if row["why"]:
        yield f"\n{title}: nothing is recommended: {row['why']}"
        if not row["systems"]:
            return
        yield f"    measured: {', '.join(row['methods'])}, {setting_text(row)}"
    else:
        yield f"\n{title}: {', '.join(row['methods'])}, {setting_text(row)}"
    yield f"    {cost_text(row)}, on {row['systems']} of {row['tried']} independent systems"
    if "better" in row:
        better = row["better"]
        yield (
            f"    the best of its {better['among']} methods, found after the run: {', '.join(better['methods'])},"
            f" {setting_text(better)}: {better['how']}"
        )


def setting_text(row: Mapping[str, Any]) -> str:
    """The setting that is enough on half of the problems, and the one that is enough on all."""
    one, step = row["setting"], row["setting"]["kind"] == "step"
    of = "" if len(row["methods"]) < 2 else f" of {one['method']}"
    unit = " of the time in which the motion changes" if step else ""
    text = f"{argument(one)}{of}{unit}"
    if row["loosest"] == row["tightest"]:
        return text
    return f"{text} (enough on half of the problems, {row['tightest']:g} on all; the median one is {one['problem']})"


def argument(setting: Mapping[str, Any]) -> str:
    """The argument of `gnomon.solve` for a setting."""
    return f"step={setting['relative']:g}" if setting["kind"] == "step" else f"rtol={setting['value']:g}"


def cost_text(row: Mapping[str, Any]) -> str:
    """The time of a solve with its range, and the evaluations of the equations."""
    from gnomon.harness.results.number_text import grouped, time_text

    text = f"{time_text(row['seconds'])} a solve ({time_text(row['low'])} to {time_text(row['high'])})"
    calls = row.get("evaluations", math.nan)
    return text + (f", {grouped(round(calls))} evaluations of the equations" if math.isfinite(calls) else "")


def measured_by(table: Table) -> str:
    """Whose measurements these are, and what they can bear."""
    head = table.head
    one = head["launches"] <= 1
    bears = "one launch: two times are not separated" if one else f"{head['launches']} launches or more"
    waited = f"{100 * head['delayed'] / max(head['timed'], 1):.0f} % of the calls waited for a processor"
    lacks = f"this run is not complete: {head['lacks']}" if head["lacks"] else "the run is complete"
    suites = f"suite{'s' * (len(head['suites']) > 1)} {', '.join(head['suites'])}"
    return (
        f"Measured by gnomon's authors at revision {head['revision']} on {head['date']}, {suites}, on {head['cores']} cores of"
        f" one processor model, {head['cpu']}, Python {head['python']}"
        f" ({'; '.join(filter(None, (bears, head['rounds'], waited, lacks)))}). Medians over the systems that each method"
        " reaches: not a ranking. Times are of motions of the catalogue with 64 samples; on your machine and system they"
        " differ."
    )


def _print_lines(table: Table, row: Mapping[str, Any]) -> None:
    """The lines that run the method on equations like the reader's."""
    one = row["setting"]
    code = table.lines.get(one["method"])
    if code is None:
        out.print(f"\n{one['method']} takes a scene in place of equations: see docs/engine.md", highlight=False)
        return
    out.print(f"\n{code.replace('{setting}', argument(one))}", highlight=False, markup=False)

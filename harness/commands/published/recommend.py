"""`gnomon recommend`: a method, its setting and its cost for a need or a kind of system, from published measurements."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out
from gnomon.harness.results.advice.code_lines import argument, code_for
from rich.markup import escape

if TYPE_CHECKING:
    from gnomon.harness.results.advice.recommendations import Table

CHOICE = "The method is the one that the library's manual names, chosen before the measurements."


def recommend(
    words: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SUBJECT]",
            help="A need or a kind of system, as stiff or gravitation, or words for one, as double pendulum; without one"
            " they are listed, or with --equations one is found.",
        ),
    ] = None,
    error: Annotated[float | None, typer.Option("--error", help="The largest error wanted, as 1e-6.")] = None,
    library: Annotated[
        list[str] | None, typer.Option("--library", help="Only this library, as scipy; repeatable.")
    ] = None,
    equations: options.Equations = None,
    span: options.Span = None,
    start: options.Start = None,
    numbers: options.Numbers = None,
    event: options.Events = None,
    accelerations: options.Accelerations = False,
    out_path: Annotated[
        Path | None, options.path_option("With --equations, keep the measurements: a folder or a file.sqlite.", "--out")
    ] = None,
) -> None:
    """Recommend a method of each library, with its setting, its cost and the lines that run it.

    With --equations the methods are measured on your own equations, and the published advice is compared with the
    result; exit code 1 if no method reaches the error.

    Each library answers with the method that its own manual names, chosen before the measurements, with the share of
    the systems on which it reaches the error.
    """
    subject = " ".join(words or ())
    if equations is not None:
        # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
        from gnomon.harness.commands.published.recommend_own import Request, recommend_own

        stated = equations, (span, start, numbers), event, accelerations
        recommend_own(Request(subject, error, library or (), *stated, out_path))
        return
    _refuse_without_equations(
        {"--span": span, "--start": start, "--parameters": numbers, "--event": event, "--accelerations": accelerations}
        | {"--out": out_path}
    )
    _recommend(subject, error, library or ())


def _recommend(subject: str, error: float | None, chosen: Sequence[str]) -> None:
    """Print the published advice for a subject, or the subjects if it is empty."""
    # Imported here and not above: `gnomon --help` starts without the modules that read the table.
    from gnomon.harness.adapters import libraries
    from gnomon.harness.results.advice import recommendations

    if not subject:
        for key, (title, about) in recommendations.subjects().items():
            out.print(f"{key:12} {title}: {about}", highlight=False, markup=False)
        out.print("Next: gnomon recommend stiff --error 1e-6 --library scipy", highlight=False)
        return
    advice = recommendations.find(subject, error, chosen)
    table = recommendations.read()
    out.print(f"[bold]{escape(advice.title)}, error at most {advice.error:g}[/]", highlight=False)
    out.print(f"{advice.about}\n{CHOICE}", highlight=False, markup=False)
    for word, other in advice.further.items():
        out.print(f"For {word!r} see also: gnomon recommend {other}", highlight=False, markup=False)
    for row in advice.rows:
        own = row["library"] == recommendations.OURS
        if own and len(advice.rows) > 1:
            out.print("\ngnomon's own methods, which are not compared with the libraries above", highlight=False)
        outside = recommendations.outside_share(table.head["outside"], advice.subject, row["library"])
        for line in describe(row, libraries.title(row["library"]), outside):
            out.print(line, highlight=False, markup=False)
    named = [row for row in advice.rows if row["systems"]]
    if len(named) == 1:
        _print_lines(table, advice.subject, named[0])
    elif named:
        out.print(
            f"\nLines of code: gnomon recommend {advice.subject} --error {advice.error:g} --library {named[0]['library']}",
            highlight=False,
            markup=False,
        )
    subject = advice.subject if len(advice.rows) > 1 else ""  # one library has its own share above
    out.print(f"\n{tell_origin(table, subject)}", highlight=False, markup=False)


def describe(row: Mapping[str, Any], title: str, outside: Mapping[str, Any] | None = None) -> Iterator[str]:
    """The lines on one answer. `outside`: the share of trials outside of the catalogue in which it held."""
    from gnomon.harness.results.advice.recommendations import percent_text

    if row["why"]:
        yield f"\n{title}: nothing is recommended: {row['why']}"
    elif not row["systems"]:
        yield f"\n{title}: nothing is recommended: {', '.join(row['methods'])} reaches the error on {share_text(row)}"
        yield f"    {least_text(row)}"
    else:
        first = row["reliable"]
        yield f"\n{title}: {', '.join(row['methods'])}, {argument(first)}{_unit(first)}{_of(row, first)}"
        for reliable in (first, *first.get("others", ())):
            yield f"    {_for(row, reliable)}{reliable_text(reliable)}"
        if row["systems"] > 1:
            yield f"    {_for(row, row['setting'])}{median_text(row)}"
        if outside is not None:
            yield f"    on systems outside of the catalogue its recommended settings reached their error in {percent_text(outside)}"
        yield f"    at some setting it reaches the error on {share_text(row)}"
        yield f"    {rests_text(row['rests_on'])}"
    if "better" in row:
        better, at = row["better"], "at equal errors " * ("time" in row["better"]["how"])
        yield (
            f"    the best of its {better['among']} methods in these measurements: {', '.join(better['methods'])};"
            f" {at}it {better['how']}; {reliable_text(better['reliable'])}"
        )


def share_text(row: Mapping[str, Any]) -> str:
    """The systems that a method reaches, with the 95 % interval of the share of all such systems."""
    low, high = (round(100 * row[name]) for name in ("share_low", "share_high"))
    if row["systems"] == row["tried"]:
        share = f"at least {low} %"
    elif not row["systems"]:
        share = f"at most {high} %"
    else:
        share = f"{low} to {high} %"
    return f"{row['systems']} of {row['tried']} systems; with 95 % confidence on {share} of such systems"


def least_text(row: Mapping[str, Any]) -> str:
    """The error that a method reaches in place of the one that was asked for."""
    if "best_error" not in row:
        return "on half of them it gives no answer in time"
    from gnomon.harness.results.number_text import error_text

    return f"it reaches an error of {error_text(row['best_error'])} on half of them"


def reliable_text(row: Mapping[str, Any]) -> str:
    """The recommended setting of a method, the systems on which it reaches the error, and its cost."""
    from gnomon.harness.results.number_text import count_text, time_text

    on = f"on {'all ' if row['of'] > 1 else ''}{count_text(row['of'], 'system')} of the catalogue"
    if row["systems"] < row["of"]:
        on = f"on {row['systems']} of {row['of']} systems (on the others it took too long, or round-off is above the error)"
    cost = f", {time_text(row['seconds'])} a solve" if "seconds" in row else ""
    return f"{argument(row)}{_unit(row)} reached the error {on}{cost}"


def median_text(row: Mapping[str, Any]) -> str:
    """The setting that is enough on half of the problems, with its cost."""
    setting = row["setting"]
    enough = f"{argument(setting)}{_unit(setting)} is enough on half of them"
    return f"{enough}, {cost_text(row)}; the middle one is {setting['problem']}"


def rests_text(basis: Mapping[str, Any]) -> str:
    """The systems that an answer rests on, outside of which its settings were not tried."""
    low, high = (f"{end:.3g}" for end in basis["spans"])
    limits = [f"spans of {low} to {high} time scales" if low != high else f"a span of {low} time scales"]
    limits += [f"eccentricities up to {basis['eccentricity']:.3g}"] if "eccentricity" in basis else []
    if "conditioning" in basis:
        limits.append(f"motions that rounding of the input changes by {basis['conditioning']:.1g} at most")
    return f"tried only on {', '.join(limits)} (time scale: a period over 2 pi, or a decay time)"


def _of(row: Mapping[str, Any], setting: Mapping[str, Any]) -> str:
    """The method of a setting, if there are several."""
    return f" for {setting['method']}" if len(row["methods"]) > 1 else ""


def _for(row: Mapping[str, Any], setting: Mapping[str, Any]) -> str:
    """The method of a setting before it, if there are several."""
    return f"{setting['method']}: " if len(row["methods"]) > 1 else ""


def _unit(setting: Mapping[str, Any]) -> str:
    return " of the time in which the motion changes" if setting["kind"] == "step" else ""


def cost_text(row: Mapping[str, Any]) -> str:
    """The time of a solve with its range, and the evaluations of the equations."""
    from gnomon.harness.results.number_text import group_digits, time_text

    text = f"{time_text(row['seconds'])} a solve ({time_text(row['low'])} to {time_text(row['high'])})"
    calls = row.get("evaluations", math.nan)
    return text + (f", {group_digits(round(calls))} evaluations of the equations" if math.isfinite(calls) else "")


def tell_origin(table: Table, subject: str) -> str:
    """Whose measurements these are, and what they can bear."""
    from gnomon.harness.results.advice import recommendations

    head = table.head
    waited = f"{100 * head['delayed'] / max(head['timed'], 1):.0f} % of the calls waited for a processor"
    lacks = f"; this run is not complete: {head['lacks']}" if head["lacks"] else ""
    suites = f"suite{'s' * (len(head['suites']) > 1)} {', '.join(head['suites'])}"
    return (
        f"Measured by gnomon's authors at revision {head['revision']} on {head['date']}, {suites}, on {head['cores']} cores of"
        f" {head['cpu']}, Python {head['python']} ({waited}{lacks}). A time is the median over the systems of the catalogue that"
        " the method reaches, with 64 samples: it does not rank libraries, and differs on your machine and system."
        f" {margin_text(head['margin'])} {recommendations.outside_text(head['outside'], subject)}"
    )


def margin_text(margin: float) -> str:
    """How a recommended setting is chosen."""
    if margin == 1:
        return "The recommended setting is the tightest that any of the systems needs, without a margin."
    return (
        f"The recommended tolerance is {margin:g} times the tightest that any of the systems needs; the recommended step is"
        " the shortest, without a margin."
    )


def _refuse_without_equations(values: Mapping[str, Any]) -> None:
    """Raise ValueError for an option that belongs to --equations."""
    for option, value in values.items():
        if value:
            raise ValueError(f"{option} belongs to own equations: give --equations mine.py:f too")


def _print_lines(table: Table, subject: str, row: Mapping[str, Any]) -> None:
    """The lines that run the method on a system of the subject, with the reliable setting."""
    setting = row["reliable"]
    method = setting["method"]
    lines = code_for(table.forms[method], method, subject, setting)
    if lines is None:
        out.print(f"\n{method} takes a scene in place of equations: see docs/engine.md", highlight=False)
        return
    out.print(f"\n{lines.rstrip()}", highlight=False, markup=False)

"""The figures and tables of an accuracy report."""

import math
import re
from typing import Any

import pandas as pd
from gnomon.harness.contract.status import CANNOT_RUN, Status
from gnomon.harness.reporting.pdf import pictures
from gnomon.harness.reporting.pdf.answers import (
    digits_text,
    growth_words,
    join_names,
    range_text,
    size_text,
    solve_text,
    time_at,
)
from gnomon.harness.reporting.pdf.parts import Part, chapter, figures, table
from gnomon.harness.reporting.pdf.pictures import shorten
from gnomon.harness.reporting.pdf.subject import Subject
from gnomon.harness.reporting.tables import LAWS
from gnomon.harness.results import analysis
from gnomon.harness.results.contenders import ALONE, OWN
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.number_text import count_text, order_text, power_text, short_text
from gnomon.harness.results.time_ratios import EQUAL, EQUAL_WITHIN, FASTEST, OPEN, SLOWER
from gnomon.harness.studies.drift import CLEAR

MOST_ROWS = 140
"""Of the table by case: it fills three pages."""
MOST_FAILURES = 16
NOTHING = "–"
RANGE = "range (orientations)"
NUMBER = re.compile(r"(?<![\w.])-?[0-9][0-9.]*(e[+-]?[0-9]+)?(?!\w)")


def chapters(subject: Subject) -> list[dict[str, Any]]:
    """The figures and the tables."""
    return [
        # Without stored states there is no figure of growth to share the page of the method.
        chapter(
            "Growth and cost of the error", _growth(subject), _work(subject), begins="" if subject.grown else "page"
        ),
        chapter("Digits and failures", _digits(subject), _kinds(subject), begins="page"),
        chapter("Tables", _describe_speed(subject), _failures(subject), _cases(subject), begins="page"),
    ]


def _work(subject: Subject) -> Part:
    drawings = pictures.drawings(pictures.work_diagrams(subject))
    number = len(subject.telling)
    chosen = (
        "All cases with at least three errors."
        if number == len(subject.answered) or number < 6
        else f"Six of {count_text(len(subject.answered), 'case')}, evenly spaced in the order of digits, the most first: they"
        " are not chosen by eye."
    )
    caption = (
        f"{chosen} One mark is one setting: its largest error against the exact motion, and its time (right-hand sides where"
        f" no time was recorded); lower and further left is better. In colour {shorten(subject.name, 60)}, in grey the other"
        " integrators of the run that gave an answer. Letters in the upper margin are failed settings, with their number if several are close: I inaccurate, D"
        " diverged, R refused, T over the time limit, S not started, C crashed. Dotted: the floor and the conditioning of"
        " the case."
    )
    across = 1 if number == 1 else 2
    heads = [(shorten(subject.run.titles[case], 52), shorten(case)) for case in subject.telling]
    return figures(drawings, caption, across, 0.7 if across == 1 else 1.0, "Error against cost", heads)


def _growth(subject: Subject) -> Part:
    caption = (
        f"The error over the span of the motion on the cases of the diagrams that follow, at the setting with an error nearest"
        f" {power_text(CLEAR)}. {growth_words(subject)}"
    )
    return figures(pictures.drawings([pictures.growth_chart(subject)]), caption, 1, 0.92, "Growth of the error")


def _digits(subject: Subject) -> Part:
    charts = pictures.digit_charts(subject)
    drawn = min(len(subject.cases), 2 * pictures.ROWS)
    spread = (
        " A line through a point is the range over turned orientations."
        if (subject.cases["turned_starts"] > 0).any()
        else ""
    )
    caption = (
        f"{count_text(drawn, 'case')} with default numbers, the most digits first. Point: digits of the largest error at the"
        " best setting. Tick: the digits that half a unit in the last place of input or output leaves; a point right of it"
        f" is better than the input deserves.{spread} A word stands where no setting is ok."
    )
    if drawn < len(subject.cases):
        caption += f" The {len(subject.cases) - drawn} cases that follow are left out."
    return figures(pictures.drawings(charts), caption, len(charts), 1.0 if len(charts) == 2 else 0.72, "Digits by case")


def _kinds(subject: Subject) -> Part:
    caption = (
        "Problems (a case with its default or with hard numbers, in one formulation) by kind of system. Problems that it"
        " does not accept are no failures."
    )
    return figures(pictures.drawings([pictures.failure_chart(subject)]), caption, 1, 0.85, "Failures by kind of system")


def _describe_speed(subject: Subject) -> Part:
    rows = []
    for target in TARGETS:
        own = [row for (_, level), row in subject.times.items() if level == target]
        if not own:
            continue
        seconds = pd.Series([row["seconds"] for row in own], dtype=float)
        at = subject.equal[(subject.equal["target"] == target) & (subject.equal["cell"] != ALONE)]
        counts = [str(len(at)), *(str(int((at["state"] == state).sum())) for state in (FASTEST, EQUAL, OPEN, SLOWER))]
        spread = range_text(seconds, solve_text)
        rows.append([power_text(target), str(len(own)), spread, *(counts if len(at) else ["0", "–", "–", "–", "–"])])
    heads = [">error", ">cases that reach it", "<>time of one solve, least – greatest case", ">compared cases", ">fastest", ">equal",
             ">open", ">slower"]  # fmt: skip
    note = (
        "Times at equal error, interpolated between settings, against the least time of the same division (gnomon's own, or"
        f" all others). Slower: the launches separate the two (false discovery rate 5 %); equal: within {EQUAL_WITHIN:g} times"
        f" with 95 % confidence; open: neither. {subject.run.scatter[OWN].text().capitalize()}."
    )
    return table(heads, rows, note, "Time at equal error")


def _cases(subject: Subject) -> Part:
    shown = [_case_row(subject, str(case), row) for case, row in subject.cases.head(MOST_ROWS).iterrows()]
    # A column in which no case has a value, as the range over orientations, is left out.
    heads = [head for head in shown[0] if any(row[head] != NOTHING for row in shown)]
    meaning = (
        "Error / tolerance: median over the settings, and the worst."
        if subject.by_tolerance
        else "Order: slope of the error with the step, and half of its 95 % interval, rounded up; – where errors lie on no line or do not fall."
    )
    note = (
        "Digits and error: at the best ok setting, the largest error over 64 samples; “≥” where the error is below the floor."
        " Attainable: the larger effect of half a unit in the last place of input (the conditioning) or output (the floor)."
        f" {meaning} Growth: the law of the error over time, if the 95 % interval of its power, in brackets, admits one"
        " only. Time: of one solve at this error, with the range over launches if there are several; “≤” where the loosest"
        " setting reaches it already."
    )
    if RANGE in heads:
        note += " Range: the smallest and the largest error over turned starts, with their number."
    if len(subject.cases) > MOST_ROWS:
        note += f" {len(subject.cases) - MOST_ROWS} cases are left out: they follow in the order of digits."
    sides = ["<>case", *(f">{head}" for head in heads[1:])]
    return table(sides, [[row[head] for head in heads] for row in shown], note, "Every case", 7)


def _case_row(subject: Subject, case: str, row: pd.Series) -> dict[str, str]:
    """The cells of a case by their heads."""
    answered, turned = math.isfinite(row["best"]), row["turned_starts"] > 0
    law = subject.grown[case][1] if case in subject.grown else None
    grows = NOTHING if law is None else LAWS.get(law.law, law.law) or "unclear"
    if law is not None and law.law and math.isfinite(law.power):
        grows += f" ({law.low:z.1f} to {law.high:z.1f})".replace("-", "−")
    over, at = row["over_tolerance"], NOTHING
    if subject.by_tolerance:
        knob, by = "tolerance", f"{short_text(over)}, {short_text(row['worst_over_tolerance'])}"
        head, known = "error / tolerance", math.isfinite(over)
    else:
        knob, by = "step", order_text(row["order"], row["margin"])
        head, known = "order", math.isfinite(row["order"])
    if answered:
        at = power_text(row["at"]) if subject.by_tolerance else f"{short_text(row['at'])} s"
    spread = f"{size_text(row['error_low'])} – {size_text(row['error_high'])} ({row['turned_starts']:.0f})"
    return {
        "case": shorten(case + (f" ({row['formulation']})" if row["formulation"] else "")),
        "digits": digits_text(row),
        "error": size_text(row["best"]) if answered else str(row["verdict"]).replace("_", " ") or "left out",
        RANGE: spread if answered and turned else NOTHING,
        f"at {knob}": at,
        "attainable": size_text(row["attainable"]),
        head: by if known else NOTHING,
        "growth": grows,
        f"time at {power_text(1e-6)}": time_at(subject, case, 1e-6) or NOTHING,
    }


def _failures(subject: Subject) -> Part:
    lost = subject.reduced[~subject.reduced["status"].isin([*CANNOT_RUN, Status.SKIPPED])]
    first: dict[tuple[str, str], str] = {}  # reasons that differ in their numbers alone are one row
    pairs = zip(lost["status"], lost["reason"], strict=True)
    alike = [first.setdefault((status, NUMBER.sub("…", reason)), reason) for status, reason in pairs]
    failed = analysis.failures(lost.assign(reason=alike))
    failed = failed.sort_values("trials", ascending=False, kind="stable")
    rows = [
        [
            str(row["status"]).replace("_", " "),
            str(row["trials"]),
            shorten(row["reason"] or NOTHING, 150),
            join_names(row["where"], 3),
        ]
        for row in failed.head(MOST_FAILURES).to_dict("records")
    ]
    note = (
        "Settings that are not ok, of default and hard variants, without those that the time limit kept from starting;"
        " reasons that differ in their numbers alone are one row, with those of the first."
    )
    if len(failed) > MOST_FAILURES:
        note += f" {len(failed) - MOST_FAILURES} rarer reasons are in the results file (gnomon export)."
    refused = analysis.failures(subject.reduced[subject.reduced["status"].isin(CANNOT_RUN)])
    refused = refused.sort_values("trials", ascending=False, kind="stable")
    for row in refused.head(3).to_dict("records"):
        note += f" Not accepted ({shorten(row['reason'], 120)}): {count_text(row['trials'], 'problem')}."
    return table(["status", ">settings", "<>reason", "<>where"], rows, note, "Failures", 8)

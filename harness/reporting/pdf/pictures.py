"""The figures of an accuracy report, as SVG through Altair: small, in the font that the document has."""

import math
from collections.abc import Sequence
from typing import Any

import altair as alt
import numpy as np
import pandas as pd
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting.figures_work import ERRORS, draw, work_points, work_precision
from gnomon.harness.reporting.images import leaner
from gnomon.harness.reporting.pdf.subject import Subject
from gnomon.harness.reporting.style import COLOURS, INK, LINES, QUIET, STATUS_COLOURS, dress

FONT = "Libertinus Serif"
DASHES = ([1, 0], [6, 3], [2, 2], [8, 2, 2, 2], [4, 4], [10, 3])
ROWS = 64
"""Largest number of cases in one column of the figure of digits."""
LONGEST = 44


def svg(specification: dict[str, Any]) -> str:
    """The drawing of a specification; the document embeds it as vectors."""
    import vl_convert  # many megabytes, which a page does not need

    return leaner(vl_convert.vegalite_to_svg(specification | {"config": specification["config"] | {"font": FONT}}))


def shorten(text: str, most: int = LONGEST) -> str:
    """A text shortened to a number of characters."""
    return text if len(text) <= most else text[: most - 1] + "…"


def work_diagrams(subject: Subject) -> list[dict[str, Any]]:
    """Error against time, or right-hand sides if no time was recorded, on the telling cases; others are grey."""
    run, names = subject.run, set(subject.telling)
    if not names:
        return []
    rows = subject.used(run.reduced[run.reduced["case"].isin(names)])
    look = run.look.assign(colour=LINES[0])  # that of the others is not shown
    points = work_points(rows, look)
    mine = points["series"] == subject.name
    axis = "time" if np.isfinite(points.loc[mine, "time"]).any() else "calls"
    points = points[mine | ~points["failed"]].assign(front=lambda table: table["series"] == subject.name)
    diagrams, specification = [], work_precision(look, axis)
    for case in subject.telling:
        own = points[points["case"] == case].drop(columns=["case", "variant", "formulation"])
        place = subject.cases.loc[case]
        limits = {"floor": float(place["floor"])}
        if place["attainable"] > place["floor"]:
            limits["conditioning"] = float(place["attainable"])
        diagram = draw(specification, own, limits)
        diagrams.append(_without_legend(diagram | {"width": 300, "height": 205}))
    return diagrams


def _without_legend(node: Any) -> Any:
    """A copy of a specification without legends; its configuration stays."""
    if isinstance(node, list):
        return [_without_legend(each) for each in node]
    if not isinstance(node, dict):
        return node
    return {
        name: None if name == "legend" else value if name in ("config", "datasets") else _without_legend(value)
        for name, value in node.items()
    }


def growth_chart(subject: Subject) -> dict[str, Any] | None:
    """The error over time on the telling cases, both in decades; None if no states were stored."""
    cases = [case for case in subject.telling if case in subject.grown]
    rows = []
    for case in cases:
        trial, _ = subject.grown[case]
        rows += [
            {"case": shorten(case), "time": math.log10(t / trial.times[-1]), "error": math.log10(size)}
            for t, size in zip(trial.times, trial.sizes["error"], strict=True)
            if math.isfinite(size) and size > 1e-17
        ]
    if not rows:
        return None
    names = [shorten(case) for case in cases]
    looks = {"color": (alt.Color, LINES), "strokeDash": (alt.StrokeDash, DASHES)}
    legend = alt.Legend(title=None, orient="right", symbolStrokeWidth=2, symbolType="stroke")
    encoded = {
        channel: kind("case:N", legend=legend, scale=alt.Scale(domain=names, range=list(values[: len(names)])))
        for channel, (kind, values) in looks.items()
    }
    halves = "datum.value == 0 ? 'span' : datum.value == -1 ? 'span / 10' : ''"
    x = alt.X("time:Q", title="time", axis=alt.Axis(values=[-1, 0], labelExpr=halves, labelFlush=False))
    y = alt.Y(
        "error:Q",
        title="error",
        scale=alt.Scale(zero=False),
        axis=alt.Axis(tickMinStep=1, tickCount=6, labelExpr=ERRORS),
    )
    chart = alt.Chart(alt.NamedData("points")).mark_line(strokeWidth=1.6).encode(x, y, **encoded)
    return dict(dress(chart.properties(width=400, height=190), {"points": rows}).to_dict(validate=False))


def digit_charts(subject: Subject) -> list[dict[str, Any]]:
    """Digits at the best setting by case, in one column, or in two of equal length."""
    table = subject.cases
    columns = 1 if len(table) <= ROWS // 2 else 2
    each = math.ceil(min(len(table), 2 * ROWS) / columns)
    parts = [table.iloc[i * each : (i + 1) * each] for i in range(columns)]
    return [_digits(part, subject, 190 if columns == 2 else 330) for part in parts]


def _digits(part: pd.DataFrame, subject: Subject, width: int) -> dict[str, Any]:
    with np.errstate(divide="ignore"):
        data = [
            {
                "case": shorten(str(case)),
                "digits": row["digits"],
                "low": -math.log10(max(row["error_high"], 1e-17)) if row["turned_starts"] > 0 else None,
                "high": -math.log10(max(row["error_low"], 1e-17)) if row["turned_starts"] > 0 else None,
                "limit": min(-math.log10(max(row["attainable"], 1e-17)), 17.0),
                "verdict": "" if math.isfinite(row["digits"]) else str(row["verdict"]).replace("_", " "),
            }
            for case, row in part.iterrows()
        ]
    for row in data:
        if not math.isfinite(row["digits"]):
            row["digits"] = None
    wide = 5.0 * max(len(shorten(str(case))) for case in subject.cases.index) + 8
    extent = {"minExtent": wide, "maxExtent": wide, "labelLimit": 0}  # both columns have one scale
    base = alt.Chart(alt.NamedData("rows")).encode(
        y=alt.Y(
            "case:N",
            title=None,
            sort=None,
            axis=alt.Axis(grid=True, ticks=False, domain=False, labelFontSize=10.5, labelColor=INK, **extent),
        )
    )
    axis = alt.Axis(values=[0, 5, 10, 15], orient="top", titlePadding=4, labelOverlap=False)
    scale = alt.Scale(domain=[0, 17], nice=False)
    layers = [
        base.mark_tick(color=QUIET, thickness=1.2, size=9).encode(x=alt.X("limit:Q")),
        base.mark_rule(color=LINES[0], strokeWidth=2).encode(x="low:Q", x2="high:Q"),
        base.mark_point(color=LINES[0], filled=True, size=34, opacity=1).encode(
            x=alt.X("digits:Q", title="correct digits", axis=axis, scale=scale)
        ),
        base.transform_filter("datum.verdict")
        .mark_text(align="left", color=STATUS_COLOURS[Status.CRASHED], fontSize=10.5, dx=3)
        .encode(x=alt.datum(0), text="verdict:N"),
    ]
    chart = alt.layer(*layers).properties(width=width, height={"step": 12})
    return dict(dress(chart, {"rows": data}).to_dict(validate=False))


def failure_chart(subject: Subject) -> dict[str, Any]:
    """The number of problems of each kind of system by verdict."""
    table = subject.matrix.assign(kind=[subject.kind(case) for case in subject.matrix["case"]])
    present = [name for name in STATUS_COLOURS if name in set(table["verdict"])]
    counts = table.groupby(["kind", "verdict"]).size().rename("problems").reset_index()
    rows = [
        {"kind": kind, "verdict": verdict_words(str(verdict)), "place": present.index(verdict), "problems": int(number)}
        for kind, verdict, number in counts.itertuples(index=False)
    ]
    order = [kind for kind in subject.kinds if kind in set(table["kind"])]
    colour = alt.Color(
        "verdict:N",
        legend=alt.Legend(title=None, orient="top", columns=3, symbolType="square"),
        scale=alt.Scale(domain=[verdict_words(name) for name in present], range=[STATUS_COLOURS[n] for n in present]),
    )
    most = int(counts.groupby("kind")["problems"].sum().max())
    whole = {"values": list(range(most + 1))} if most < 8 else {"tickMinStep": 1}
    bars = (
        alt.Chart(alt.NamedData("rows"))
        .mark_bar(stroke=COLOURS["outline"], strokeWidth=0.5, size=14)
        .encode(
            x=alt.X("problems:Q", title="problems", axis=alt.Axis(format="d", **whole)),
            y=alt.Y("kind:N", title=None, sort=order, axis=alt.Axis(labelLimit=300, labelColor=INK, ticks=False)),
            color=colour,
            order=alt.Order("place:Q"),
        )
    )
    return dict(dress(bars.properties(width=360, height={"step": 22}), {"rows": rows}).to_dict(validate=False))


def verdict_words(verdict: str) -> str:
    """The words of a verdict on a sweep."""
    words = {
        Status.OK.value: "every setting ok",
        "partly": "some settings ok",
        Status.UNSUPPORTED.value: "not accepted",
    }
    return words.get(verdict, "no setting ok: " + verdict.replace("_", " "))


def drawings(specifications: Sequence[dict[str, Any] | None]) -> list[str]:
    """The drawings of those specifications that there are."""
    return [svg(specification) for specification in specifications if specification is not None]

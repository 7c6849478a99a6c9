"""Charts as Vega-Lite specifications through Altair: one specification is the interactive and the printed figure.

Logarithmic axes are drawn as decades, the logarithm taken here, so that every tick is a power of ten with a readable
name. Data are named (`points`, `limits`, ...), so that the page can put another scene's in their place.
"""

from __future__ import annotations

import math
from typing import Any

import altair as alt
import numpy as np
import pandas as pd
from gnomon.harness.style import GRID, INK, LETTERS, PALE, QUIET, STATUS_COLOURS, dressed, records
from gnomon.harness.tables import short_text

SECONDS = {-9: "1 ns", -8: "10 ns", -7: "100 ns", -6: "1 µs", -5: "10 µs", -4: "100 µs", -3: "1 ms", -2: "10 ms"}
SECONDS |= {-1: "0.1 s", 0: "1 s", 1: "10 s", 2: "100 s", 3: "1000 s"}
COUNTS = {k: str(10**k) if k < 4 else f"1e{k}" for k in range(13)}
ERRORS = "datum.value > 0 ? '' : datum.value == 0 ? '1' : '1e' + datum.value"

MARGIN = 0.45
"""Errors above 10**MARGIN (nearly 3: nothing of the motion is left) are shown in the margin of failed trials."""
TOP = 2.6


def work_points(reduced: pd.DataFrame, look: pd.DataFrame) -> pd.DataFrame:
    """The points of one work-precision diagram: one row a setting of a series, decades on both axes.

    A failed trial stands in the margin above the diagram, in its library's lane, at its own work where that was
    measured, else at the work of the nearest setting of its series that was.
    """
    lanes = dict(zip(look["series"], look["lane"], strict=True))
    rows = reduced[reduced["setting"].notna()]
    with np.errstate(divide="ignore", invalid="ignore"):
        table = pd.DataFrame(
            {
                "series": rows["integrator_id"],
                "setting": rows["setting"],
                "status": rows["status"],
                "time": np.log10(rows["seconds"].astype(float)),
                "calls": np.log10(rows["rhs_calls"].astype(float)),
                "error": np.log10(rows["error_max"].astype(float)),
            }
        )
    failed = ~table["status"].isin(["ok", "inaccurate"]) | ~(table["error"] <= MARGIN)
    for axis in ("time", "calls"):
        table[axis] = table[axis].where(np.isfinite(table[axis]))
        nearest = table.groupby("series")[axis].transform(lambda column: column.ffill().bfill())
        table[axis] = table[axis].where(~failed, nearest)
    heights = (TOP - MARGIN) * (0.75 - 0.6 * table["series"].map(lanes).astype(float) / max(*lanes.values(), 1))
    return table.assign(failed=failed, error=table["error"].where(~failed, MARGIN + heights))


def work_precision(points: pd.DataFrame, look: pd.DataFrame, limits: dict[str, float], axis: str) -> alt.LayerChart:
    """Error against time or right-hand sides (`axis` "time" or "calls"), failed trials in the margin above.

    `look` holds the integrators of the legend, in its order.
    """
    names = {"time": SECONDS, "calls": COUNTS}[axis]
    title = {"time": "time of one solve", "calls": "right-hand sides evaluated"}[axis]
    domain = list(look["series"])
    legend = alt.Legend(title=None)
    colour = alt.Color("series:N", legend=legend, scale=alt.Scale(domain=domain, range=list(look["colour"])))
    shape = alt.Shape("series:N", legend=legend, scale=alt.Scale(domain=domain, range=list(look["shape"])))
    dash = alt.StrokeDash("series:N", legend=legend, scale=alt.Scale(domain=domain, range=list(look["dash"])))
    pick = alt.selection_point(name="pick", fields=["series"], bind="legend")
    hover = alt.selection_point(name="hover", fields=["series"], on="pointerover", clear="pointerout")
    shown = alt.condition(pick & hover, alt.value(1.0), alt.value(0.12))
    x = alt.X(
        f"{axis}:Q",
        title=title,
        scale=alt.Scale(zero=False, nice=True, padding=14),
        axis=alt.Axis(tickMinStep=1, labelOverlap=True, labelExpr=f"({_table(names)})[datum.value] || ''"),
    )
    only_errors = alt.condition("datum.value > 0", alt.value("transparent"), alt.value(GRID))
    y = alt.Y(
        "error:Q",
        title="error (largest over the samples)",
        scale=alt.Scale(zero=False, nice=False, domainMax=TOP, padding=6),
        axis=alt.Axis(tickMinStep=1, tickCount=9, labelExpr=ERRORS, gridColor=only_errors, tickColor=only_errors),
    )
    base = alt.Chart(alt.NamedData("points")).transform_filter(f"isValid(datum.{axis}) && isValid(datum.error)")
    tooltip = [
        alt.Tooltip("series:N", title="integrator"),
        alt.Tooltip("setting:Q", title="setting", format=".3g"),
        alt.Tooltip("status:N"),
        alt.Tooltip("e:N", title="error"),
        alt.Tooltip("w:N", title=title),
    ]
    worded = {
        "e": "datum.failed ? 'failed' : format(pow(10, datum.error), '.2e')",
        "w": f"format(pow(10, datum.{axis}), '.3s')" + (" + 's'" if axis == "time" else ""),
    }
    kept, lost = base.transform_filter("!datum.failed"), base.transform_filter("datum.failed")
    lines = kept.mark_line(strokeWidth=1.7).encode(
        x, y, colour, strokeDash=dash, opacity=shown, order=alt.Order("setting:Q", sort="descending")
    )
    dots = (
        kept.transform_calculate(**worded)
        .mark_point(size=46, filled=True)
        .encode(x, y, colour, shape, opacity=shown, tooltip=tooltip)
        .add_params(pick, hover)
    )
    letters = (
        lost.transform_calculate(letter=f"({_table(LETTERS)})[datum.status] || '?'", **worded)
        .mark_text(fontSize=10, fontWeight="bold")
        .encode(x, y, colour, text="letter:N", opacity=shown, tooltip=tooltip)
    )
    margin = alt.Chart(alt.NamedData("margin"))
    band = margin.mark_rect(color=PALE).encode(y=alt.Y("low:Q"), y2="high:Q")
    heading = margin.mark_text(align="left", baseline="bottom", dx=1, dy=-3, color=QUIET, fontSize=10.5).encode(
        y="high:Q", x=alt.value(0), text="text:N"
    )
    rules = alt.Chart(alt.NamedData("limits"))
    lines_at = rules.mark_rule(color=QUIET, strokeDash=[2, 3], strokeWidth=1.3).encode(y="at:Q")
    words_at = rules.mark_text(align="left", baseline="bottom", dx=5, dy=-2, color=QUIET, fontSize=10.5).encode(
        y="at:Q", x=alt.value(0), text="limit:N"
    )
    chart = alt.layer(band, heading, lines_at, words_at, lines, dots, letters)
    data = {
        "points": records(points),
        "limits": [{"limit": name, "at": math.log10(value)} for name, value in limits.items() if value > 0],
        "margin": [{"low": MARGIN, "high": TOP, "text": "failed trials"}],
    }
    return dressed(chart.properties(width=640, height=440, datasets=data))


def _kept(table: pd.DataFrame, *columns: str) -> list[dict[str, Any]]:
    """The rows with these columns only, numbers to four figures: data travel with the page."""
    short = table[list(columns)].copy()
    for name in short.select_dtypes("float"):
        short[name] = [float(f"{value:.4g}") for value in short[name]]
    return records(short)


def _table(names: dict[Any, str]) -> str:
    return "{" + ", ".join(f"'{key}': '{value}'" for key, value in names.items()) + "}"


def status_map(matrix: pd.DataFrame, look: pd.DataFrame, scenes: list[str]) -> alt.LayerChart:
    """Scene x integrator: colour and letter say the verdict over the sweep, a number the digits reached at best.

    `matrix` has the columns scene, integrator_id, verdict, best, ok, settings, reason.
    """
    table = matrix.assign(
        cell=[
            _digits(best) if best > 0 else LETTERS.get(v, "16")
            for best, v in zip(matrix["best"], matrix["verdict"], strict=True)
        ]
    )
    present = [name for name in STATUS_COLOURS if name in set(table["verdict"])]
    base = _grid(table, look, scenes)
    colour = alt.Color(
        "verdict:N",
        title="over the sweep",
        scale=alt.Scale(domain=present, range=[STATUS_COLOURS[name] for name in present]),
        legend=alt.Legend(orient="top", direction="horizontal", columns=len(present), titleOrient="left"),
    )
    tooltip = [
        alt.Tooltip("scene:N"),
        alt.Tooltip("integrator_id:N", title="integrator"),
        alt.Tooltip("verdict:N"),
        alt.Tooltip("ok:Q", title="settings ok"),
        alt.Tooltip("settings:Q", title="settings tried"),
        alt.Tooltip("best:Q", title="smallest error", format=".2e"),
        alt.Tooltip("reason:N", title="first failure"),
    ]
    cells = base.mark_rect(stroke="white", strokeWidth=1).encode(color=colour, tooltip=tooltip)
    dark = alt.condition("datum.verdict == 'crashed'", alt.value("white"), alt.value(INK))
    words = base.mark_text(fontSize=10).encode(text="cell:N", color=dark)
    return dressed(
        alt.layer(cells, words).properties(
            width={"step": _step(table)},
            height={"step": 18},
            datasets={
                "cells": _kept(table, "scene", "integrator_id", "verdict", "cell", "ok", "settings", "best", "reason")
            },
        )
    )


def trust_map(table: pd.DataFrame, look: pd.DataFrame, scenes: list[str]) -> alt.LayerChart:
    """Scene x integrator: the digits reached at best, coloured by how many more the arithmetic would have allowed.

    `table` has the columns scene, integrator_id, best, attainable.
    """
    reached = table[table["best"] > 0]
    lost = np.log10(reached["best"]) - np.log10(np.maximum(reached["attainable"], 1e-17))
    reached = reached.assign(cell=[_digits(best) for best in reached["best"]], lost=np.clip(lost, 0, 12))
    base = _grid(reached, look, scenes)
    colour = alt.Color(
        "lost:Q",
        title="digits short of the attainable",
        scale=alt.Scale(scheme="blues", reverse=True, domain=[0, 12]),
        legend=alt.Legend(orient="top", direction="horizontal", titleOrient="left", gradientLength=220, titleLimit=260),
    )
    tooltip = [
        alt.Tooltip("scene:N"),
        alt.Tooltip("integrator_id:N", title="integrator"),
        alt.Tooltip("best:Q", title="smallest error", format=".2e"),
        alt.Tooltip("attainable:Q", format=".2e"),
    ]
    cells = base.mark_rect(stroke="white", strokeWidth=1).encode(color=colour, tooltip=tooltip)
    ink = alt.condition("datum.lost < 5", alt.value("white"), alt.value(INK))
    words = base.mark_text(fontSize=10.5).encode(text="cell:N", color=ink)
    return dressed(
        alt.layer(cells, words).properties(
            width={"step": _step(table)},
            height={"step": 21},
            datasets={"cells": _kept(reached, "scene", "integrator_id", "cell", "lost", "best", "attainable")},
        )
    )


def _step(table: pd.DataFrame) -> int:
    """Width of a column of a map: as wide as all of them fit beside the names of the scenes, and readable."""
    return max(21, min(27, 850 // max(len(set(table["integrator_id"])), 1)))


def _digits(error: float) -> str:
    return str(max(math.floor(-math.log10(error)), 0))


def _grid(table: pd.DataFrame, look: pd.DataFrame, scenes: list[str]) -> alt.Chart:
    """Integrators across, scenes down, in their given order; hard variants stand indented under their case."""
    cases = [name for name in scenes if "/" not in name]
    under = f"indexof({cases}, split(datum.value, '/')[0]) >= 0 && indexof(datum.value, '/') >= 0"
    indented = f"{under} ? slice(datum.value, indexof(datum.value, '/') + 1) : datum.value"
    bold = alt.condition(under, alt.value(400), alt.value(600))
    ink = alt.condition(under, alt.value(QUIET), alt.value(INK))
    return alt.Chart(alt.NamedData("cells")).encode(
        x=alt.X(
            "integrator_id:N",
            title=None,
            sort=[name for name in look["series"] if name in set(table["integrator_id"])],
            axis=alt.Axis(orient="top", labelAngle=-60, labelLimit=220, ticks=False, domain=False, grid=False),
        ),
        y=alt.Y(
            "scene:N",
            title=None,
            sort=[name for name in scenes if name in set(table["scene"])],
            axis=alt.Axis(
                labelExpr=indented,
                labelFontWeight=bold,
                labelColor=ink,
                labelLimit=230,
                ticks=False,
                domain=False,
                grid=False,
            ),
        ),
    )


def tolerance_strip(points: pd.DataFrame, look: pd.DataFrame) -> alt.LayerChart:
    """Achieved error over tolerance of every adaptive trial. `points`: integrator_id, scene, setting, over."""
    table = points.assign(decades=np.clip(np.log10(points["over"]), -6, 10))
    look = look[look["series"].isin(set(table["integrator_id"]))]
    base = alt.Chart(alt.NamedData("points")).encode(
        y=alt.Y("integrator_id:N", title=None, sort=list(look["series"]), axis=alt.Axis(grid=True, labelLimit=220))
    )
    x = alt.X(
        "decades:Q",
        title="achieved error / tolerance",
        axis=alt.Axis(tickMinStep=1, labelExpr="datum.value == 0 ? 'as asked' : '1e' + datum.value"),
    )
    colour = alt.Color(
        "integrator_id:N", legend=None, scale=alt.Scale(domain=list(look["series"]), range=list(look["colour"]))
    )
    tooltip = [
        alt.Tooltip("integrator_id:N", title="integrator"),
        alt.Tooltip("scene:N"),
        alt.Tooltip("setting:Q", title="tolerance", format=".0e"),
        alt.Tooltip("over:Q", title="error / tolerance", format=".2g"),
    ]
    strip = base.mark_tick(thickness=1.6, size=13, opacity=0.55).encode(x, color=colour, tooltip=tooltip)
    middle = base.mark_point(shape="diamond", size=80, filled=True, color=INK).encode(alt.X("median(decades):Q"))
    asked = alt.Chart(alt.NamedData("asked")).mark_rule(color=INK, strokeDash=[3, 3]).encode(x="decades:Q")
    data = {"points": _kept(table, "integrator_id", "scene", "setting", "over", "decades"), "asked": [{"decades": 0}]}
    return dressed(alt.layer(asked, strip, middle).properties(width=640, height=24 * len(look), datasets=data))


def ladder_chart(rungs: pd.DataFrame) -> alt.LayerChart:
    """What each simpler model errs by, over one period and over the span; crudest first.

    `rungs`: ladder (the full case), effect, lacks, error, early.
    """
    spans = {"error": "over the whole span", "early": "over the first period"}
    long = rungs.melt(["ladder", "effect", "lacks"], list(spans), "over", "size")
    table = long[long["size"] > 0].assign(
        decades=lambda rows: np.log10(rows["size"]),
        place=lambda rows: rows["ladder"] + ": " + rows["effect"],
        words=lambda rows: [short_text(error) for error in rows["size"]],
        over=lambda rows: rows["over"].map(spans),
    )
    base = alt.Chart(alt.NamedData("rungs"))
    places = list(dict.fromkeys(rungs["ladder"] + ": " + rungs["effect"]))
    y = alt.Y("place:N", title=None, sort=places, axis=alt.Axis(labelLimit=480, ticks=False, domain=False))
    x = alt.X(
        "decades:Q",
        title="error of the simpler model against the full one",
        scale=alt.Scale(zero=False, nice=True, padding=40),
        axis=alt.Axis(tickMinStep=1, labelExpr="datum.value % 1 ? '' : datum.value == 0 ? '1' : '1e' + datum.value"),
    )
    legend = alt.Legend(title=None, orient="top")
    domain = [spans["early"], spans["error"]]
    colour = alt.Color("over:N", legend=legend, scale=alt.Scale(domain=domain, range=["#56B4E9", "#12324a"]))
    shape = alt.Shape("over:N", legend=legend, scale=alt.Scale(domain=domain, range=["circle", "diamond"]))
    tooltip = [
        alt.Tooltip("place:N", title="model"),
        alt.Tooltip("lacks:N"),
        alt.Tooltip("over:N"),
        alt.Tooltip("words:N", title="error"),
    ]
    lines = base.mark_line(color="#b9b6ae", strokeWidth=2).encode(x, y, detail="place:N")
    dots = base.mark_point(size=120, filled=True, opacity=1).encode(x, y, color=colour, shape=shape, tooltip=tooltip)
    words = base.mark_text(baseline="bottom", dy=-8, color=INK, fontSize=11).encode(x, y, text="words:N")
    data = {"rungs": _kept(table, "place", "lacks", "over", "words", "decades")}
    return dressed(alt.layer(lines, dots, words).properties(width=640, height=38 * len(places), datasets=data))


def policy_chart(points: pd.DataFrame) -> alt.LayerChart:
    """Engines as shipped, configured and staggered at equal step. `points`: scene, engine, policy, step, error."""
    table = points.assign(
        decades=np.clip(np.log10(points["error"].fillna(np.inf).clip(1e-17, 1e3)), -16, 1.5),
        place=[
            scene + (f"  {step:g} s" if step else "")
            for scene, step in zip(points["scene"], points["step"], strict=True)
        ],
    )
    names = [name for name in ("as shipped", "configured", "staggered") if name in set(table["policy"])]
    names += sorted(set(table["policy"]) - set(names))
    colours = ["#8c2d3a", "#0072B2", "#009E73", "#8a6d00", "#56B4E9"]
    shapes = ["cross", "circle", "diamond", "square", "triangle-up"]
    base = alt.Chart(alt.NamedData("points")).encode(
        y=alt.Y("place:N", title=None, sort=None, axis=alt.Axis(labelLimit=320, grid=True)),
    )
    x = alt.X(
        "decades:Q", title="error", axis=alt.Axis(tickMinStep=1, labelExpr="datum.value > 1 ? 'lost' : " + ERRORS)
    )
    lines = base.mark_line(color="#b9b6ae", strokeWidth=2).encode(x=x, detail="place:N")
    legend = alt.Legend(title=None, orient="top")
    dots = base.mark_point(size=90, filled=True, opacity=1).encode(
        x,
        color=alt.Color("policy:N", legend=legend, scale=alt.Scale(domain=names, range=colours[: len(names)])),
        shape=alt.Shape("policy:N", legend=legend, scale=alt.Scale(domain=names, range=shapes[: len(names)])),
        tooltip=["scene:N", "engine:N", "policy:N", "step:Q", alt.Tooltip("error:Q", format=".2e"), "status:N"],
    )
    data = {"points": _kept(table, "place", "scene", "engine", "policy", "step", "error", "status", "decades")}
    return dressed(alt.layer(lines, dots).properties(width=640, height=20 * table["place"].nunique(), datasets=data))

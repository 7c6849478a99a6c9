"""Charts as Vega-Lite specifications through Altair: one specification is the interactive and the printed figure.

A logarithmic axis is a linear axis of logarithms that are taken here, so that every tick is a power of ten with a
readable label. Data are aggregated here, so that the number of marks does not grow with the run.
"""

from collections.abc import Sequence
from typing import Any

import altair as alt
import numpy as np
import pandas as pd
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting.figures_work import ERRORS
from gnomon.harness.reporting.style import EDGE, INK, LINES, dress, find_colour, records
from gnomon.harness.results.number_text import short_text


def colour_lines(field: str, names: Sequence[str], colours: Sequence[str] = LINES) -> alt.Color:
    """The colours of named lines, in turn, with strokes in the legend."""
    scale = alt.Scale(domain=[*names], range=[colours[k % len(colours)] for k in range(len(names))])
    return alt.Color(field, scale=scale, legend=alt.Legend(title=None, symbolType="stroke", symbolStrokeWidth=2.5))


def _keep_columns(table: pd.DataFrame, *columns: str) -> list[dict[str, Any]]:
    """The rows with these columns only, numbers to four figures, because the page contains the data."""
    short = table[list(columns)].copy()
    for name in short.select_dtypes("float"):
        short[name] = [float(f"{value:.4g}") for value in short[name]]
    return records(short)


def tolerance_spread(points: pd.DataFrame) -> pd.DataFrame:
    """Achieved error over tolerance of each adaptive integrator: 10, 25, 50, 75 and 90 % quantiles, in decades.

    `points`: integrator_id and over, a row a trial.
    """
    decades = np.log10(np.maximum(points["over"].to_numpy(float), 1e-12))
    grouped = pd.Series(decades, points.index).groupby(points["integrator_id"])
    quantiles = {f"q{share}": grouped.quantile(share / 100) for share in (10, 25, 50, 75, 90)}
    return pd.DataFrame(quantiles | {"trials": grouped.size()}).reset_index()


def tolerance_chart(spread: pd.DataFrame, look: pd.DataFrame) -> alt.LayerChart:
    """Achieved error over tolerance of each adaptive integrator. `spread`: from `tolerance_spread`."""
    look = look[look["series"].isin(set(spread["integrator_id"]))]
    base = alt.Chart(alt.NamedData("spread")).encode(
        y=alt.Y("integrator_id:N", title=None, sort=list(look["series"]), axis=alt.Axis(grid=True, labelLimit=220))
    )
    scale = alt.Scale(domain=list(look["series"]), range=list(look["colour"]))
    colour = alt.Color("integrator_id:N", legend=None, scale=scale)
    axis = alt.Axis(tickMinStep=1, labelFlush=False, labelExpr="datum.value == 0 ? 'as asked' : '1e' + datum.value")
    worded = {name: f"format(pow(10, datum.{name}), '.1e')" for name in ("q10", "q50", "q90")}
    tooltip = [
        alt.Tooltip("integrator_id:N", title="integrator"),
        *(alt.Tooltip(f"{name}_:N", title=f"{name[1:]} % of trials below") for name in worded),
        alt.Tooltip("trials:Q"),
    ]
    base = base.transform_calculate(**{f"{name}_": text for name, text in worded.items()})
    title = "achieved error / tolerance"
    wide = base.mark_rule(strokeWidth=2).encode(
        x=alt.X("q10:Q", title=title, axis=axis), x2="q90:Q", color=colour, tooltip=tooltip
    )
    half = base.mark_rule(strokeWidth=9, opacity=0.75).encode(x="q25:Q", x2="q75:Q", color=colour, tooltip=tooltip)
    middle = base.mark_point(shape="diamond", size=80, filled=True, color=INK, opacity=1).encode(
        x="q50:Q", tooltip=tooltip
    )
    asked = alt.Chart(alt.NamedData("asked")).mark_rule(color=INK, strokeDash=[3, 3]).encode(x="decades:Q")
    data = {"spread": _keep_columns(spread, *spread.columns), "asked": [{"decades": 0}]}
    chart = alt.layer(asked, wide, half, middle)
    return dress(chart.properties(width=640, height=24 * len(look)), data)


def hierarchy_chart(levels: pd.DataFrame) -> alt.LayerChart:
    """The error of each simpler model over one period and over the span; crudest first.

    `levels`: hierarchy (the full case), effect, lacks, error, early.
    """
    spans = {"error": "over the whole span", "early": "over the first period"}
    long = levels.melt(["hierarchy", "effect", "lacks"], list(spans), "over", "size")
    # Where the span ends within the first period, the two are one number.
    twice = (long["over"] == "early") & np.tile(levels["early"] == levels["error"], len(spans))
    table = long[(long["size"] > 0) & ~twice].assign(
        decades=lambda rows: np.log10(rows["size"]),
        place=lambda rows: rows["hierarchy"] + ": " + rows["effect"],
        words=lambda rows: [short_text(error) for error in rows["size"]],
        over=lambda rows: rows["over"].map(spans),
    )
    base = alt.Chart(alt.NamedData("levels"))
    places = list(dict.fromkeys(levels["hierarchy"] + ": " + levels["effect"]))
    # The case and the effect are on two lines: on one line a narrow page has no room for the points.
    split = "indexof(datum.label, ': ')"
    lines_of = f"[slice(datum.label, 0, {split} + 1), slice(datum.label, {split} + 2)]"
    two = {"labelFontSize": 10.5, "labelOffset": -6}  # Vega aligns the first line as if it were the only one
    axis = alt.Axis(labelLimit=340, labelExpr=lines_of, ticks=False, domain=False, **two)
    y = alt.Y("place:N", title=None, sort=places, axis=axis)
    x = alt.X(
        "decades:Q",
        title=["error of the simpler model", "against the full one"],
        scale=alt.Scale(zero=False, nice=True, padding=40),
        axis=alt.Axis(
            tickMinStep=1,
            labelFlush=False,
            labelExpr="datum.value % 1 ? '' : datum.value == 0 ? '1' : '1e' + datum.value",
        ),
    )
    legend = alt.Legend(title=None, orient="top")
    domain = [spans["early"], spans["error"]]
    colour = alt.Color("over:N", legend=legend, scale=alt.Scale(domain=domain, range=[EDGE, INK]))
    shape = alt.Shape("over:N", legend=legend, scale=alt.Scale(domain=domain, range=["circle", "diamond"]))
    tooltip = [alt.Tooltip("place:N", title="model"), "lacks:N", "over:N", alt.Tooltip("words:N", title="error")]
    lines = base.mark_line(color=EDGE, strokeWidth=2).encode(x, y, detail="place:N")
    dots = base.mark_point(size=120, filled=True, opacity=1).encode(x, y, color=colour, shape=shape, tooltip=tooltip)
    # Labels left and right of the points: the error over the first period is never the larger one.
    early = base.transform_filter(f"datum.over === '{spans['early']}'")
    late = base.transform_filter(f"datum.over !== '{spans['early']}'")
    small = {"baseline": "middle", "color": INK, "fontSize": 11}
    words = [
        early.mark_text(**small, align="right", dx=-9).encode(x, y, text="words:N"),
        late.mark_text(**small, align="left", dx=9).encode(x, y, text="words:N"),
    ]
    data = {"levels": _keep_columns(table, "place", "lacks", "over", "words", "decades")}
    return dress(alt.layer(lines, dots, *words).properties(width=640, height=30 * len(places)), data)


def policy_chart(points: pd.DataFrame) -> alt.LayerChart:
    """Engines as shipped, configured and staggered at equal step. `points`: problem, engine, policy, step, error."""
    table = points.assign(
        decades=np.clip(np.log10(points["error"].fillna(np.inf).clip(1e-17, 1e3)), -16, 1.5),
        place=[
            problem + (f"  {step:g} s" if step else "")
            for problem, step in zip(points["problem"], points["step"], strict=True)
        ],
    )
    names = [name for name in ("as shipped", "configured", "staggered") if name in set(table["policy"])]
    names += sorted(set(table["policy"]) - set(names))
    colours = [find_colour(name) for name in ("orange", "blue", "green", "ochre", "violet")]
    shapes = ["cross", "circle", "diamond", "square", "triangle-up"]
    base = alt.Chart(alt.NamedData("points")).encode(
        y=alt.Y("place:N", title=None, sort=None, axis=alt.Axis(labelLimit=320, grid=True))
    )
    x = alt.X(
        "decades:Q",
        title="error",
        axis=alt.Axis(
            tickMinStep=1,
            labelOverlap=True,
            labelFlush=False,
            labelExpr=f"datum.value > 1 ? '{Status.DIVERGED}' : {ERRORS}",
        ),
    )
    lines = base.mark_line(color=EDGE, strokeWidth=2).encode(x=x, detail="place:N")
    legend = alt.Legend(title=None, orient="top")
    dots = base.mark_point(size=90, filled=True, opacity=1).encode(
        x,
        color=alt.Color("policy:N", legend=legend, scale=alt.Scale(domain=names, range=colours[: len(names)])),
        shape=alt.Shape("policy:N", legend=legend, scale=alt.Scale(domain=names, range=shapes[: len(names)])),
        tooltip=["problem:N", "engine:N", "policy:N", "step:Q", alt.Tooltip("error:Q", format=".2e"), "status:N"],
    )
    data = {
        "points": _keep_columns(table, "place", "problem", "engine", "policy", "step", "error", "status", "decades")
    }
    return dress(alt.layer(lines, dots).properties(width=640, height=20 * table["place"].nunique()), data)

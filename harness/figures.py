"""Charts as Vega-Lite specifications through Altair: one specification is the interactive and the printed figure.

Logarithmic axes are drawn as decades, the logarithm taken here, so that every tick is a power of ten with a readable
name. Colour says the library, lightness the order within a family, shape and stroke the family: all told apart without
colour vision.
"""

from __future__ import annotations

import colorsys
import math
from pathlib import Path
from typing import Any

import altair as alt
import numpy as np
import pandas as pd
import vl_convert
from gnomon.harness.analysis import STATUSES

INK, QUIET, PALE, GRID = "#1f2933", "#5f6b7a", "#f4f2ec", "#e4e2dc"
FONT = "Helvetica Neue, Helvetica, Arial, Liberation Sans, sans-serif"

# Okabe and Ito's palette, distinct under the common colour-vision deficiencies.
HUES = {"gnomon": "#0072B2", "scipy": "#D55E00", "rebound": "#009E73", "pybullet": "#B0508A"}
OTHER_HUES = ("#8a6d00", "#56B4E9", "#4b4b4b", "#E69F00")

FAMILIES = {
    "adaptive step": ("circle", [1, 0]),
    "fixed step": ("square", [6, 3]),
    "fixed step, geometric": ("diamond", [6, 2, 1, 2]),
    "physics engine": ("triangle-up", [2, 2]),
}

STATUS_COLOURS = {
    "ok": "#7fb6a0",
    "partly": "#d8e6c3",
    "inaccurate": "#f2cf63",
    "diverged": "#e08a4a",
    "refused": "#b79ad1",
    "timeout": "#7aa6d8",
    "crashed": "#8c2d3a",
    "skipped": "#c3d6ea",
    "unsupported": "#efedE8".lower(),
    "not_installed": "#ffffff",
}
LETTERS = {
    "inaccurate": "I",
    "diverged": "D",
    "refused": "R",
    "timeout": "T",
    "crashed": "C",
    "skipped": "S",
    "unsupported": "·",
    "not_installed": "",
}

SECONDS = {-9: "1 ns", -8: "10 ns", -7: "100 ns", -6: "1 µs", -5: "10 µs", -4: "100 µs", -3: "1 ms", -2: "10 ms"}
SECONDS |= {-1: "0.1 s", 0: "1 s", 1: "10 s", 2: "100 s", 3: "1000 s"}
COUNTS = {k: str(10**k) if k < 4 else f"1e{k}" for k in range(13)}
ERRORS = "datum.value > 0 ? '' : datum.value == 0 ? '1' : '1e' + datum.value"

MARGIN = 0.45
"""Errors above 10**MARGIN (nearly 3: nothing of the motion is left) are shown in the margin of failed trials."""
TOP = 2.6


def family(row: pd.Series) -> str:
    """What kind of method a series is, from what its integrator declared."""
    if row["policy"]:
        return "physics engine"
    if row["setting_kind"] == "tolerance":
        return "adaptive step"
    claims = str(row.get("conserves", ""))
    return "fixed step, geometric" if any(word in claims for word in ("symplectic", "attitude")) else "fixed step"


def styles(frame: pd.DataFrame) -> pd.DataFrame:
    """Label, colour, shape and dash of each integrator, well ordered: by library, family and order."""
    one = frame.drop_duplicates("integrator_id").copy()
    one["family"] = one.apply(family, axis=1)
    libraries = [name for name in HUES if name in set(one["library"])]
    libraries += sorted(set(one["library"]) - set(HUES))
    hues = HUES | dict(zip([name for name in libraries if name not in HUES], OTHER_HUES * 9, strict=False))
    place = {name: i for i, name in enumerate(libraries)}
    kind = {name: i for i, name in enumerate(FAMILIES)}
    one = one.sort_values(
        ["library", "family", "order_declared", "integrator_id"],
        key=lambda column: column.map(place if column.name == "library" else kind)
        if column.name in ("library", "family")
        else column,
        na_position="last",
    )
    shades = {}
    for (library, _), members in one.groupby(["library", "family"], sort=False):
        for i, name in enumerate(members["integrator_id"]):
            share = i / max(len(members) - 1, 1) if len(members) > 1 else 0.6
            shades[name] = _shade(hues[library], share)
    return pd.DataFrame(
        {
            "series": one["integrator_id"],
            "library": one["library"],
            "family": one["family"],
            "colour": [shades[name] for name in one["integrator_id"]],
            "shape": [FAMILIES[name][0] for name in one["family"]],
            "dash": [FAMILIES[name][1] for name in one["family"]],
            "lane": [place[name] for name in one["library"]],
        }
    ).reset_index(drop=True)


def _shade(colour: str, share: float) -> str:
    """The colour lighter (share 0) to darker (share 1)."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    hue, light, saturation = colorsys.rgb_to_hls(red, green, blue)
    light = 0.66 + (0.24 - 0.66) * share
    return "#" + "".join(f"{round(255 * x):02x}" for x in colorsys.hls_to_rgb(hue, light, min(saturation, 0.85)))


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
    heights = (TOP - MARGIN) * (0.75 - 0.6 * table["series"].map(lanes) / max(*lanes.values(), 1))
    return table.assign(failed=failed, error=table["error"].where(~failed, MARGIN + heights))


def work_precision(points: pd.DataFrame, look: pd.DataFrame, limits: dict[str, float], axis: str) -> alt.LayerChart:
    """Error against time or right-hand sides (`axis` "time" or "calls"), failed trials in the margin above."""
    look = look[look["series"].isin(set(points["series"]))]
    names = {"time": SECONDS, "calls": COUNTS}[axis]
    title = {"time": "time of one solve", "calls": "right-hand sides evaluated"}[axis]
    domain = list(look["series"])
    legend = alt.Legend(title=None, symbolSize=90, labelLimit=230, rowPadding=3, symbolStrokeWidth=0)
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
        axis=alt.Axis(tickMinStep=1, labelExpr=f"({_table(names)})[datum.value] || ''"),
    )
    only_errors = alt.condition("datum.value > 0", alt.value("transparent"), alt.value(GRID))
    y = alt.Y(
        "error:Q",
        title="error (largest over the samples)",
        scale=alt.Scale(zero=False, nice=False, domainMax=TOP, padding=6),
        axis=alt.Axis(tickMinStep=1, tickCount=9, labelExpr=ERRORS, gridColor=only_errors, tickColor=only_errors),
    )
    base = alt.Chart(points.assign(**{axis: points[axis]}).dropna(subset=[axis, "error"]))
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
    margin = alt.Chart(pd.DataFrame({"low": [MARGIN], "high": [TOP], "text": ["failed trials"]}))
    band = margin.mark_rect(color=PALE).encode(y=alt.Y("low:Q"), y2="high:Q")
    heading = margin.mark_text(align="left", baseline="top", dx=5, dy=4, color=QUIET, fontSize=10.5).encode(
        y="high:Q", x=alt.value(0), text="text:N"
    )
    rules = pd.DataFrame({"limit": list(limits), "at": [_log(value) for value in limits.values()]})
    lines_at = alt.Chart(rules).mark_rule(color=QUIET, strokeDash=[2, 3], strokeWidth=1.3).encode(y="at:Q")
    words_at = (
        alt.Chart(rules)
        .mark_text(align="left", baseline="bottom", dx=5, dy=-2, color=QUIET, fontSize=10.5)
        .encode(y="at:Q", x=alt.value(0), text="limit:N")
    )
    return _dressed(alt.layer(band, heading, lines_at, words_at, lines, dots, letters)).properties(width=640, height=440)


def _log(value: float) -> float:
    return math.log10(value) if value > 0 else math.nan


def _table(names: dict[Any, str]) -> str:
    return "{" + ", ".join(f"'{key}': '{value}'" for key, value in names.items()) + "}"


def _dressed(chart: Any) -> Any:
    """The house style: quiet axes, no frame, one font."""
    return (
        chart.configure(font=FONT, background="white")
        .configure_view(stroke=None)
        .configure_axis(
            gridColor=GRID,
            domainColor="#b9b6ae",
            tickColor="#b9b6ae",
            labelColor=QUIET,
            titleColor=INK,
            titleFontWeight="normal",
            titleFontSize=12.5,
            labelFontSize=11.5,
            titlePadding=10,
        )
        .configure_legend(labelColor=INK, labelFontSize=11.5, titleColor=INK, titleFontSize=12)
        .configure_title(color=INK, fontSize=15, anchor="start", fontWeight=600, subtitleColor=QUIET, subtitleFontSize=12)
    )


def write_images(chart: Any, folder: Path, name: str) -> None:
    """The printed figure: `name`.svg and `name`.png, twice the size in pixels."""
    folder.mkdir(parents=True, exist_ok=True)
    spec = chart.to_dict()
    (folder / f"{name}.svg").write_text(vl_convert.vegalite_to_svg(spec))
    (folder / f"{name}.png").write_bytes(vl_convert.vegalite_to_png(spec, scale=2))

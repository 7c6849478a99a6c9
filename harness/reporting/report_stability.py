"""The result of `gnomon stability` on the page: sentences by panel and by integrator, and a figure for each panel.

A figure has a row for each integrator and a column for each quantity.
"""

import math
import textwrap
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import altair as alt
import numpy as np
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting import sidecars
from gnomon.harness.reporting.style import INK, QUIET, SHARE, dress, hue
from gnomon.harness.results.profiles import OURS

ROW, WIDTH, CELL = 18, 170, 46
"""Pixels: the height of a row, the width of a column, the width of a cell."""
REGIONS_IN_A_ROW, REGION_WIDTH = 4, 150
DECADES = "datum.value % 1 ? '' : datum.value < -2 || datum.value > 3 ? '1e' + datum.value : format(pow(10, datum.value), '~g')"
TOOLTIP = [alt.Tooltip("integrator:N"), alt.Tooltip("text:N", title="found")]


def stability(*folders: Path) -> dict[str, Any] | None:
    """The panels with their rows, from the first folder that has `stability.json`; None without a file."""
    contents: dict[str, Any] | None = sidecars.first("stability.json", *folders)
    if contents is None:
        return None
    panels = [
        {"id": name, "title": title, **_rows([row for row in contents["rows"] if row["panel"] == name])}
        for name, title in contents["panels"].items()
    ]
    return {"tiers": {}, "figures": {}} | contents | {"panels": panels, "cards": _cards(contents)}


def _cards(contents: Mapping[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """A card for each integrator, by library: for each panel its sentences, or the reason why it has none."""
    cards: dict[str, dict[str, Any]] = {}
    for row in contents["rows"]:
        panel = {"id": row["panel"], "title": contents["panels"].get(row["panel"], row["panel"])}
        panel |= {"sentences": row["sentences"], "reason": _reason(row) or "nothing to say"}
        cards.setdefault(row["integrator"], {"name": row["integrator"], "panels": []})["panels"].append(panel)
    by_library: dict[str, list[dict[str, Any]]] = {}
    for card in cards.values():
        by_library.setdefault(card["name"].split(":")[0], []).append(card)
    return by_library


def _reason(row: Mapping[str, Any]) -> str | None:
    words = [word for word in ("not_applicable", Status.REFUSED) if word in row["data"]]
    return f"{words[0].replace('_', ' ')}: {row['data'][words[0]]}" if words else None


def _rows(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The integrators that were measured, and the number of the others by reason."""
    left_out = Counter(reason for row in rows if (reason := _reason(row)) is not None)
    measured = [row for row in rows if _reason(row) is None]
    return {
        "rows": [{"name": row["integrator"], "sentences": row["sentences"]} for row in measured],
        "left_out": [f"{reason} ({count})" for reason, count in left_out.most_common()],
    }


def stability_charts(contents: Mapping[str, Any] | None) -> dict[str, alt.TopLevelMixin]:
    """The figures of `stability.json` by name, `stability_` and the panel; figures without marks are left out."""
    if contents is None:
        return {}
    third_first = sorted(contents["rows"], key=lambda row: row["integrator"].startswith(f"{OURS}:"))
    return _charts(contents.get("figures", {}), third_first)


def _charts(figures: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> dict[str, alt.TopLevelMixin]:
    charts: dict[str, alt.TopLevelMixin] = {}
    for panel, figure in figures.items():
        own = [row for row in rows if row["panel"] == panel]
        marks = [mark | {"integrator": row["integrator"]} for row in own for mark in row.get("marks", ())]
        columns = [column for column in figure["columns"] if any(mark["column"] == column["id"] for mark in marks)]
        if columns:
            charts[f"stability_{panel}"] = (_cells if figure["cells"] else intervals)(columns, marks)
    regions = _regions([row for row in rows if row["panel"] == "linear"])
    if regions is not None:
        charts["stability_regions"] = regions
    return charts


def _integrators(marks: Sequence[Mapping[str, Any]]) -> list[str]:
    return list(dict.fromkeys(mark["integrator"] for mark in marks))


def _colour(names: Sequence[str], channel: Any = alt.Color) -> Any:
    """The hue of the library of each integrator."""
    scale = alt.Scale(domain=list(names), range=[hue(name.split(":")[0]) for name in names])
    return channel("integrator:N", scale=scale, legend=None)


def _names(names: Sequence[str], labels: bool = True, grid: bool = True) -> alt.Y:
    axis = alt.Axis(labels=labels, labelLimit=340, labelColor=INK, labelPadding=8, ticks=False, domain=False, grid=grid)
    return alt.Y("integrator:N", title=None, sort=list(names), axis=axis, scale=alt.Scale(domain=list(names)))


def intervals(
    columns: Sequence[Mapping[str, Any]], marks: Sequence[Mapping[str, Any]], width: int = WIDTH
) -> alt.HConcatChart:
    """A row for each integrator: points with intervals, or text alone if there is no number.

    `columns` and `marks` as in `stability.panel`, each mark with its "integrator"; `width` in pixels of a column.
    """
    names = _integrators(marks)
    parts: list[alt.LayerChart] = []
    data: dict[str, list[dict[str, Any]]] = {}
    for column in columns:
        own = [mark for mark in marks if mark["column"] == column["id"]]
        low, high = _ends(column, own)
        data[column["id"]] = [_row(column, mark, low, high) for mark in own]
        parts.append(_column(column, low, high, names, width, labels=not parts))
    return dress(alt.hconcat(*parts, spacing=14), data)


def _row(column: Mapping[str, Any], mark: Mapping[str, Any], low: float, high: float) -> dict[str, Any]:
    """A mark as a row of the figure's data: its places on the axis from low to high, or its text without a place."""
    numbers = {key: _place_on_axis(column, mark[key], low, high) for key in ("at", "low", "high")}
    words = _short(mark["text"]) if all(value is None for value in numbers.values()) else ""
    return {"integrator": mark["integrator"], "text": mark["text"], "told": words, "edge": low} | numbers


def _column(
    column: Mapping[str, Any], low: float, high: float, names: Sequence[str], width: int, labels: bool
) -> alt.LayerChart:
    scale = alt.Scale(domain=[low, high], nice=False, zero=False)
    ticks = {"tickMinStep": 1, "labelExpr": DECADES} if column["decades"] else {"tickCount": 5}
    axis = alt.Axis(titleLimit=width + 10, titleFontSize=11, labelFlush=False, labelSeparation=5, orient="top", **ticks)
    x = alt.X("at:Q", title=_lines(column["title"], width), scale=scale, axis=axis)
    base = alt.Chart(alt.NamedData(column["id"])).encode(y=_names(names, labels), tooltip=TOOLTIP)
    colour = _colour(names)
    bars = base.transform_filter("isValid(datum.low)").mark_rule(strokeWidth=5, opacity=0.45)
    points = base.transform_filter("isValid(datum.at)").mark_point(filled=True, size=44, opacity=1)
    words = base.transform_filter("datum.told").mark_text(align="left", dx=3, fontSize=9.5, color=QUIET)
    layers = (
        bars.encode(x=alt.X("low:Q", scale=scale), x2=alt.X2("high:Q"), color=colour),
        points.encode(x=x, color=colour),
        words.encode(x=alt.X("edge:Q", scale=scale), text=alt.Text("told:N")),
    )
    return alt.layer(*layers).properties(width=width, height=ROW * len(names))


def _ends(column: Mapping[str, Any], marks: Sequence[Mapping[str, Any]]) -> tuple[float, float]:
    """The ends of the axis, in decades if it is logarithmic."""
    decades = column["decades"]
    if column["ends"] is not None:
        low, high = column["ends"]
        if decades and low > 0:
            return math.log10(low), math.log10(high)
        if not decades and low < high:
            return low, high
    values = [mark[key] for mark in marks for key in ("at", "low", "high") if mark[key] is not None]
    values = [math.log10(value) for value in values if value > 0] if decades else values
    if not values:
        return 0.0, 1.0
    if decades:  # at least two labelled ticks
        low, high = math.floor(min(values)), math.ceil(max(values))
        return float(low), float(max(high, low + 1))
    margin = 0.05 * (max(values) - min(values)) or 0.5
    return min(values) - margin, max(values) + margin


def _place_on_axis(column: Mapping[str, Any], value: float | None, low: float, high: float) -> float | None:
    """The value on the axis; a value beyond the axis is at its end."""
    if value is None:
        return None
    if column["decades"]:
        value = math.log10(value) if value > 0 else low
    return float(f"{min(max(value, low), high):.4g}")


def _short(text: str) -> str:
    return text if len(text) <= 30 else text[:29] + "…"


def _lines(title: str, width: int) -> list[str]:
    """A title in lines of about equal length that fit into a column of `width` pixels, with 6.5 pixels a letter."""
    count = len(textwrap.wrap(title, int(width / 6.5)))
    return next(
        lines
        for letters in range(len(title) // count, len(title) + 1)
        if len(lines := textwrap.wrap(title, max(letters, 1))) <= count
    )


def _cells(columns: Sequence[Mapping[str, Any]], marks: Sequence[Mapping[str, Any]]) -> alt.LayerChart:
    """Cells from pale, no objection, to dark, each with its text."""
    names, titles = _integrators(marks), {column["id"]: column["title"] for column in columns}
    rows = [
        {
            "integrator": mark["integrator"],
            "column": titles[mark["column"]],
            "shade": mark["at"],
            "text": mark["text"],
            "told": mark["text"].split(" at ")[0],
        }
        for mark in marks
        if mark["column"] in titles
    ]
    axis = alt.Axis(orient="top", labelAngle=-50, labelLimit=260, ticks=False, domain=False, grid=False)
    x = alt.X("column:N", title=None, sort=list(titles.values()), axis=axis)
    base = alt.Chart(alt.NamedData("cells")).encode(
        x=x, y=_names(names, grid=False), tooltip=[*TOOLTIP, alt.Tooltip("column:N")]
    )
    scale = alt.Scale(domain=[0, 1], range=SHARE)
    cells = base.mark_rect(stroke="white").encode(color=alt.Color("shade:Q", scale=scale, legend=None))
    ink = alt.condition("datum.shade > 0.75", alt.value("white"), alt.value(INK))
    words = base.mark_text(fontSize=9).encode(text="told:N", color=ink)
    size = {"width": {"step": CELL}, "height": {"step": ROW}}
    return dress(alt.layer(cells, words).properties(**size), {"cells": rows})


def _regions(rows: Sequence[Mapping[str, Any]]) -> alt.FacetChart | None:
    """Small multiples: the region |R(z)| <= 1 in the upper half-plane, with a bar for each Im z."""
    bars = [{"integrator": row["integrator"]} | bar for row in rows for bar in _bars(row["data"].get("region"))]
    if not bars:
        return None
    names = _integrators(bars)
    ticks = {"tickCount": 4, "grid": True}
    chart = (
        alt.Chart()
        .mark_rect(strokeWidth=0.7)
        .encode(
            stroke=_colour(names, alt.Stroke),
            x=alt.X("from:Q", title="Re z", scale=alt.Scale(domain=[-6, 2], nice=False), axis=alt.Axis(**ticks)),
            x2="to:Q",
            y=alt.Y("low:Q", title="Im z", scale=alt.Scale(domain=[0, 6], nice=False), axis=alt.Axis(**ticks)),
            y2="high:Q",
            color=_colour(names),
        )
        .properties(width=REGION_WIDTH, height=REGION_WIDTH * 6 / 8)
    )
    header = alt.Header(title=None, labelFontSize=11.5, labelColor=INK, labelPadding=4)
    facet = alt.Facet("integrator:N", header=header, sort=names)
    faceted = chart.facet(facet, columns=REGIONS_IN_A_ROW, spacing=18, data=alt.NamedData("bars"))
    return dress(faceted, {"bars": bars})


def _bars(region: Any) -> list[dict[str, float]]:
    """The stable intervals of Re z in each row of a grid of |R|, with interpolated edges; empty for anything else."""
    try:
        modulus = np.array(region["modulus"], dtype=float)
        (left, right), (_, top), spacing = region["real"], region["imaginary"], float(region["spacing"])
        real, heights = np.linspace(left, right, modulus.shape[1]), np.linspace(0, top, modulus.shape[0])
    except (TypeError, ValueError, KeyError, IndexError):
        return []
    bars = []
    for height, row in zip(heights.tolist(), modulus, strict=True):
        inside = np.concatenate([[False], row <= 1 + 1e-9, [False]])
        firsts, lasts = np.flatnonzero(inside[1:-1] & ~inside[:-2]), np.flatnonzero(inside[1:-1] & ~inside[2:])
        for first, last in zip(firsts.tolist(), lasts.tolist(), strict=True):
            ends = _crossing(real, row, first, first - 1), _crossing(real, row, last, last + 1)
            low, high = max(height - spacing / 2, 0.0), min(height + spacing / 2, top)
            bars.append({"from": ends[0], "to": ends[1], "low": round(low, 3), "high": round(high, 3)})
    return bars


def _crossing(real: Any, row: Any, inside: int, outside: int) -> float:
    """The place where |R| is 1 between a point inside and the next one outside; at the grid's edge the point inside."""
    if not 0 <= outside < len(real) or not math.isfinite(row[outside]) or row[outside] <= row[inside]:
        return round(float(real[inside]), 3)
    part = min(max((1 - row[inside]) / (row[outside] - row[inside]), 0.0), 1.0)
    return round(float(real[inside] + part * (real[outside] - real[inside])), 3)

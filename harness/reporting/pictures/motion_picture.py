"""The picture of an exact motion: the orbit, where a plane has one, and every group of coordinates over time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.harness.measuring.drawn_motion import curve, planes
from gnomon.harness.reporting.images import save
from gnomon.harness.reporting.style import INK, dress

WIDTH, HEIGHT = 640, 180
"""Pixels of a panel over time."""
ORBIT = 420
"""Pixels of the longer side of an orbit."""
NARROW = 60
"""Pixels that the shorter side has at least."""
LEAST = 1e-9
"""The smallest ratio of the shorter side to the longer one of an orbit that is drawn."""


def draw(case: Case, path: Path) -> None:
    """Draw the exact motion to a file whose name ends in .svg, .png or .html."""
    picture, data = _charts(case)
    save(picture.to_dict(validate=False) | {"datasets": data}, path)


def chart(case: Case) -> Any:
    """The exact motion as a chart of Altair: an orbit with equal scales, then a panel for each group over time."""
    picture, data = _charts(case)
    picture.datasets = data
    return picture


def _charts(case: Case) -> tuple[Any, dict[str, Any]]:
    """The chart without its data, and the data by name."""
    import altair  # slow to load: only a drawing needs it

    times, states = curve(case)
    names = [coordinate.name for coordinate in case.state]
    rows = [
        {"n": n, "t": t} | dict(zip(names, state, strict=True))
        for n, (t, *state) in enumerate(_short(np.column_stack([times, states])))
    ]
    panels = _orbit(case, states)
    for group in dict.fromkeys(coordinate.group for coordinate in case.state):
        members = [coordinate for coordinate in case.state if coordinate.group == group]
        several = [member.name for member in members]
        title = f"{several[0] if len(several) == 1 else group} ({members[0].unit})"
        legend = altair.Legend(symbolType="stroke", symbolStrokeWidth=2) if len(several) > 1 else None
        panels.append(
            altair.Chart(altair.NamedData("motion"), width=WIDTH, height=HEIGHT)
            .transform_fold(several, ("coordinate", "value"))
            .mark_line(strokeWidth=1.5)
            .encode(
                x=altair.X("t:Q", title="t (s)", scale=altair.Scale(nice=False)),
                y=altair.Y("value:Q", title=title, scale=altair.Scale(zero=False)),
                color=altair.Color("coordinate:N", title=None, sort=several, legend=legend),
                order="n:Q",
            )
        )
    above = altair.Title(case.title, subtitle=case.id, anchor="start")
    return dress(altair.vconcat(*panels, title=above).resolve_scale(color="independent")), {"motion": rows}


def _orbit(case: Case, states: Any) -> list[Any]:
    """The panel of x against y with equal scales, with a point at the start of each body; none without a plane."""
    import altair  # slow to load: only a drawing needs it

    bodies = planes(case)
    if not bodies:
        return []
    sides = [states[:, [pair[side] for pair in bodies.values()]] for side in (0, 1)]
    middle = [float(side.max() + side.min()) / 2 for side in sides]
    half = [float(side.max() - side.min()) / 2 for side in sides]
    if min(half) <= LEAST * max(half):
        return []  # a motion along an axis is no more than its panel over time
    scale = ORBIT / (2 * max(half))
    pixels = [max(NARROW, 2 * each * scale) for each in half]
    x, y = (
        {"scale": altair.Scale(domain=[m - p / scale * 0.52, m + p / scale * 0.52], nice=False, zero=False), "title": t}
        for m, p, t in zip(middle, pixels, ("x (m)", "y (m)"), strict=True)
    )
    layers = []
    for body, (first, second) in bodies.items():
        base = altair.Chart(altair.NamedData("motion")).encode(
            x=altair.X(f"{case.state[first].name}:Q", **x),
            y=altair.Y(f"{case.state[second].name}:Q", **y),
            order="n:Q",
        )
        if len(bodies) > 1:
            base = base.encode(color=altair.ColorDatum(f"body {body}", title=None))
        start = base.transform_filter("datum.n == 0").mark_point(filled=True, size=60, stroke=INK, opacity=1)
        layers += [base.mark_line(strokeWidth=1.5), start]
    return [altair.layer(*layers, width=pixels[0], height=pixels[1])]


def _short(values: Any) -> list[list[float]]:
    """Numbers to seven figures: a picture has fewer."""
    return [[float(f"{value:.7g}") for value in row] for row in values.tolist()]

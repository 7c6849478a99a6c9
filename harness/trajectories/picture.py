"""The picture of a checked trajectory: the exact motion with the rows of the file on it, and the error by time."""

from __future__ import annotations

from typing import Any

import altair as alt
import numpy as np
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.reporting.figures import colour_lines
from gnomon.harness.reporting.style import LINES, QUIET, dress
from gnomon.harness.results.visible import visible
from gnomon.harness.trajectories.comparison import Comparison, pick_evenly

WIDTH, HEIGHT = 640, 150
MOST_POINTS = 600
"""Points of a line; more cannot be told apart."""
LEAST = 1e-17
"""Smaller errors, as the zero at the start, are not drawn."""


def chart(comparison: Comparison, verdict: str, bound: float | None) -> Any:
    """The chart of a comparison, with the bound of the error as a line if it is one number."""
    panels = [*_motion(comparison), _error(comparison, bound)]
    time = comparison.times[comparison.worst]
    title = alt.TitleParams(
        visible(f"{comparison.trajectory.source} on {comparison.case.id}"),
        subtitle=visible(f"largest error {comparison.error:.3g} of the size at t = {time:.6g} s; {verdict}"[:160]),
        offset=14,
        anchor="start",
    )
    return dress(alt.vconcat(*panels, title=title, spacing=18).resolve_scale(color="independent"))


def _time(comparison: Comparison) -> Any:
    return alt.X("t:Q", title="t (s)", scale=alt.Scale(domain=[0.0, float(comparison.times[-1])], nice=False))


def _motion(comparison: Comparison) -> list[Any]:
    """A panel for each group of coordinates: the exact motion as lines, rows of the file as circles."""
    end, case, present = float(comparison.times[-1]), comparison.case, comparison.trajectory.present
    fine = np.linspace(0.0, end, MOST_POINTS)
    exact = case.sample(fine)
    places = pick_evenly(len(comparison.times), MOST_POINTS // 4)
    panels = []
    for group in dict.fromkeys(coordinate.group for coordinate in case.state):
        members = [(i, c.name) for i, c in enumerate(case.state) if c.group == group and present[i]]
        if not members:
            continue
        unit = case.state[members[0][0]].unit
        names = [name for _, name in members]
        colour = colour_lines("coordinate:N", names)
        value = alt.Y("value:Q", title=f"{group} ({unit})", scale=alt.Scale(zero=False))
        base = alt.Chart(width=WIDTH, height=HEIGHT).encode(x=_time(comparison), y=value, color=colour)
        lines = base.mark_line(strokeWidth=1.5).properties(data=alt.InlineData(_rows(fine, exact, members)))
        states = comparison.exact[places] + comparison.differences[places]  # angles in the turn of the exact motion
        rows = alt.InlineData(_rows(comparison.times[places], states, members))
        points = base.mark_point(shape="circle", size=22, filled=False, strokeWidth=1.2, opacity=1).properties(
            data=rows
        )
        panels.append(alt.layer(lines, points))
    panels[0] = panels[0].properties(
        title=alt.TitleParams("Motion: exact (lines), rows of the file (circles)", fontSize=12.5)
    )
    return panels


def _rows(times: Floats, states: Floats, members: list[tuple[int, str]]) -> list[dict[str, Any]]:
    return [
        {"t": float(f"{t:.7g}"), "value": float(f"{value:.7g}"), "coordinate": name}
        for index, name in members
        for t, value in zip(times.tolist(), states[:, index].tolist(), strict=True)
        if np.isfinite(value)
    ]


def _error(comparison: Comparison, bound: float | None) -> Any:
    """The largest error around each of many times, by group of coordinates, and the bound."""
    places = np.linspace(0, len(comparison.times), min(len(comparison.times), MOST_POINTS // 2) + 1).astype(int)
    rows = [
        {"t": float(comparison.times[low]), "error": float(np.max(errors[low:high])), "line": group}
        for group, errors in comparison.errors_by_group.items()
        for low, high in zip(places[:-1].tolist(), places[1:].tolist(), strict=True)
        if np.max(errors[low:high]) > LEAST
    ]
    names = list(comparison.errors_by_group)
    if bound is not None:
        rows += [{"t": t, "error": bound, "line": "allowed"} for t in (0.0, float(comparison.times[-1]))]
        names.append("allowed")
    colours = [QUIET if name == "allowed" else LINES[k % len(LINES)] for k, name in enumerate(names)]
    return (
        alt.Chart(
            alt.InlineData(rows), width=WIDTH, height=HEIGHT, title=alt.TitleParams("Error by time", fontSize=12.5)
        )
        .mark_line(strokeWidth=1.5)
        .encode(
            x=_time(comparison),
            y=alt.Y(
                "error:Q", title="error / size", scale=alt.Scale(type="log"), axis=alt.Axis(format=".0e", tickCount=6)
            ),
            color=colour_lines("line:N", names, colours),
        )
    )

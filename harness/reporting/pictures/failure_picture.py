"""The picture of one claim on one case: exact and computed motion, error against time, error at each setting."""

from __future__ import annotations

import json
import math
import re
import textwrap
from collections import Counter
from functools import partial
from pathlib import Path
from typing import Any

import altair as alt
import numpy as np
import pandas as pd
from gnomon.cases import Case
from gnomon.harness.contract.integrator import Integrator, Tolerance
from gnomon.harness.measuring.trials import HALF_ULP, Trials
from gnomon.harness.registry import selection
from gnomon.harness.reporting.figures import colour_lines
from gnomon.harness.reporting.images import save
from gnomon.harness.reporting.style import INK, LINES, QUIET, dress
from gnomon.harness.results.convergence_order import LARGEST_ERROR
from gnomon.harness.results.visible import visible
from gnomon.harness.system.supervisor import run
from gnomon.harness.verification.claims import DEPTHS, TEXTS, Finding, Outcome
from gnomon.harness.verification.verify import CaseJob, Row

POINTS = 1200
"""The largest number of points of a line of the exact motion."""
MOST_ROWS = 5000
"""Altair refuses longer tables."""
WIDTH, MARGIN = 640, 48
"""Pixels of a panel, and of the labels to its left."""
LEAST = 1e-17
"""Errors of zero are drawn at this value, which is below every floor."""
DRAWN_SCALES = 400.0
"""Over more time scales the exact motion is drawn as points, as the oscillations of a line would merge."""
TICKS = 6
"""The largest number of labels on an axis of decades."""


def draw(integrator: Integrator, depth: str, row: Row, on: selection.CaseLike, path: Path) -> None:
    """Draw the motion and the errors behind a claim on the case `on`, at the setting that the row names.

    `path`: a file whose name ends in .svg, .png or .html. The integrator runs in its own process. Raises ValueError if this
    process hangs or ends.
    """
    (case,) = selection.find_cases([on])
    rows: list[Row] = []

    measure = partial(_find, row.finding.setting)
    run([CaseJob(integrator, case, DEPTHS[depth], rows.append, ["picture"], measure)], workers=1)
    if rows[0].finding.outcome != Outcome.PASSED:
        raise ValueError(
            f"--picture {path}: {integrator.id} on {row.case} gave {rows[0].finding.got}, nothing is drawn"
        )
    save(_chart(case, integrator, row, json.loads(rows[0].finding.got)).to_dict(validate=False), path)


def _find(setting: str, trials: Trials) -> Finding:
    return Finding(Outcome.PASSED, got=json.dumps(_measure(trials, setting)))


def _measure(trials: Trials, text: str) -> dict[str, Any]:
    """The solution at the setting of a finding, and the errors at all settings, as data for JSON."""
    setting = _setting(trials, text)
    answers = trials.answers()
    answer = trials.whole(setting)
    return {
        "setting": setting,
        "named": trials.named(setting),
        "why": answer.why if answer.states is None or math.isnan(answer.error) else answer.stopped or "",
        "times": trials.reference.times.tolist(),
        "exact": trials.reference.exact.tolist(),
        "states": None if answer.states is None else answer.states.tolist(),
        "errors": None if answer.states is None else answer.errors.tolist(),
        "conditioning": np.maximum(trials.reference.conditioning, HALF_ULP).tolist(),
        "sweep": [(each.setting, each.error) for each in answers if not each.declined],
    }


def _setting(trials: Trials, text: str) -> float:
    """The setting of the sweep nearest to the first setting that a finding names; without one the usual setting."""
    named = re.search(r"(?:h =|tolerances?) ([0-9.]+(?:e[+-]?[0-9]+)?)", text)
    if named is None:
        return trials.usual()
    return min(trials.settings, key=lambda setting: abs(math.log(setting / float(named[1]))))


def _chart(case: Case, integrator: Integrator, row: Row, data: dict[str, Any]) -> Any:
    finding = row.finding
    title = f"{finding.outcome.value.upper()} {row.claim} on {row.case}, drawn at {data['named']}"
    lines = [
        f"{integrator.id}. {TEXTS[row.claim]['states']}",
        *([f"Expected: {finding.expected}"] if finding.expected else []),
        *([f"Got{f' at {finding.setting}' if finding.setting else ''}: {finding.got}"] if finding.expected else []),
        *([f"At {data['named']}: {data['why']}"] if data["why"] else []),
    ]
    wrapped = [part for line in lines for part in textwrap.wrap(visible(line), 105)]
    panels = [*_motion(case, data), *_over_time(data), *_over_settings(integrator, data)]
    heading = alt.TitleParams(visible(title), subtitle=wrapped, offset=14)
    return dress(alt.vconcat(*panels, title=heading, spacing=18).resolve_scale(color="independent"))


def _motion(case: Case, data: dict[str, Any]) -> list[Any]:
    """A panel for each group of coordinates: the exact motion as lines, the computed samples as circles."""
    times, exact = np.array(data["times"]), np.array(data["exact"])
    long = times[-1] > DRAWN_SCALES * case.time_scale
    groups = Counter(coordinate.group for coordinate in case.state)
    fine = times if long else np.linspace(0.0, times[-1], min(POINTS, MOST_ROWS // max(groups.values())))
    lines = exact if long else case.sample(fine)
    panels = []
    for group in groups:
        members = [(i, c) for i, c in enumerate(case.state) if c.group == group]
        values = lines[:, [i for i, _ in members]]
        low, high = float(values.min()), float(values.max())
        margin = 0.25 * (high - low) or 0.25 * abs(high) or 1.0
        y = alt.Y(
            "value:Q",
            title=f"{group} ({members[0][1].unit})",
            axis=alt.Axis(minExtent=MARGIN, maxExtent=MARGIN),
            scale=alt.Scale(domain=[low - margin, high + margin], nice=False),
        )
        base = alt.Chart(width=WIDTH, height=150).encode(
            x=_time(times), y=y, color=colour_lines("coordinate:N", [c.name for _, c in members])
        )
        mark = base.mark_point(size=9, filled=True, clip=True) if long else base.mark_line(strokeWidth=1.5, clip=True)
        drawn = [mark.properties(data=_long(fine, lines, members))]
        if data["states"] is not None:
            points = base.mark_point(shape="circle", size=26, filled=False, strokeWidth=1.3, opacity=1, clip=True)
            drawn.append(points.properties(data=_long(times, np.array(data["states"]), members)))
        panels.append(alt.layer(*drawn))
    kind = "dots" if long else "lines"
    panels[0] = panels[0].properties(title=_small(f"Motion: exact ({kind}) and computed (circles)"))
    return panels


def _time(times: Any) -> Any:
    return alt.X("t:Q", title="t (s)", scale=alt.Scale(domain=[0.0, float(times[-1])], nice=False))


def _long(times: Any, states: Any, members: list[tuple[int, Any]]) -> Any:
    """A row for each finite value of the coordinates of a group."""
    columns = [pd.DataFrame({"t": times, "value": states[:, i], "coordinate": c.name}) for i, c in members]
    table = pd.concat(columns)
    return table[np.isfinite(table["value"])]


def _small(text: str) -> Any:
    return alt.TitleParams(text, fontSize=12.5, fontWeight="normal", color=INK)


def _decades(values: Any) -> Any:
    return np.log10(np.maximum(np.array(values, float), LEAST))


def _axis(values: Any, extent: int = 0) -> dict[str, Any]:
    """Axis and scale between whole decades, with powers of ten as labels."""
    low, high = math.floor(np.min(values)), math.ceil(np.max(values) + 1e-9)
    labels = list(range(low, high + 1, math.ceil((high - low) / TICKS)))
    text = "datum.value == 0 ? '1' : '1e' + datum.value"
    axis = alt.Axis(values=labels, labelExpr=text, **({"minExtent": extent, "maxExtent": extent} if extent else {}))
    return {"axis": axis, "scale": alt.Scale(domain=[low, high], nice=False)}


def _errors(table: Any, x: Any) -> Any:
    """Lines of errors, named in the column `line`: the first in colour, the other lines grey."""
    names = list(dict.fromkeys(table["line"]))
    y = alt.Y("decades:Q", title="error / size", **_axis(table["decades"], MARGIN))
    chart = alt.Chart(table, width=WIDTH, height=150)
    colour = colour_lines("line:N", names, (LINES[1], QUIET))
    return chart.mark_line(strokeWidth=1.5, point={"size": 16}).encode(x=x, y=y, color=colour)


def _lines(over: str, lines: dict[str, list[tuple[float, float]]]) -> Any:
    """A row for each finite error of each line, by time or setting."""
    rows = [(x, error, name) for name, each in lines.items() for x, error in each if math.isfinite(error)]
    table = pd.DataFrame(rows, columns=[over, "error", "line"])
    return table.assign(decades=_decades(table["error"]))


def _over_time(data: dict[str, Any]) -> list[Any]:
    """The error at each sample, with the conditioning below it."""
    if data["errors"] is None or not np.isfinite(data["errors"]).any():
        return []
    table = _lines(
        "t",
        {
            "computed": list(zip(data["times"], data["errors"], strict=True)),
            "effect of half an ulp": list(zip(data["times"], data["conditioning"], strict=True)),
        },
    )
    return [_errors(table, _time(data["times"])).properties(title=_small(f"Error against time, {data['named']}"))]


def _over_settings(integrator: Integrator, data: dict[str, Any]) -> list[Any]:
    """The largest error at each setting, with the line of the declared order, or of errors equal to the tolerance."""
    sweep = [(setting, error) for setting, error in data["sweep"] if math.isfinite(error)]
    if len(sweep) < 2:
        return []
    adaptive = isinstance(integrator.sweep, Tolerance)
    lines = {"computed": sweep}
    small = next(((h, e) for h, e in sweep if 0 < e < LARGEST_ERROR), None)
    if adaptive:
        lines["error = tolerance"] = [(setting, setting) for setting, _ in sweep]
    elif integrator.order is not None and small is not None:
        ideal = [(h, small[1] * (h / small[0]) ** integrator.order) for h, _ in sweep if h <= small[0]]
        lines[f"order {integrator.order} as declared"] = [(h, e) for h, e in ideal if e >= LEAST]
    table = _lines("setting", lines)
    table["setting"] = _decades(table["setting"])
    x = alt.X("setting:Q", title="tolerance" if adaptive else "step size (s)", **_axis(table["setting"]))
    place = pd.DataFrame({"setting": [math.log10(data["setting"])]})
    drawn = alt.Chart(place).mark_rule(strokeDash=[3, 3], color=INK).encode(x="setting:Q")
    title = _small("Largest error against setting; dashed: the setting drawn above")
    return [alt.layer(_errors(table, x), drawn).properties(title=title)]

"""The work-precision diagram: error against time or right-hand sides, one line an integrator.

Where many integrators ran, only the fastest of each kind (`front`) are in colour and in the legend. The others are thin
grey lines with a tooltip.
"""

import math
from collections.abc import Collection
from typing import Any

import altair as alt
import numpy as np
import pandas as pd
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting.style import COLOURS, GRID, INK, LETTERS, PALE, QUIET, dress, records
from gnomon.harness.results.equal_error import TARGETS, credit_errors, crossing

SECONDS = {-9: "1 ns", -8: "10 ns", -7: "100 ns", -6: "1 µs", -5: "10 µs", -4: "100 µs", -3: "1 ms", -2: "10 ms"}
SECONDS |= {-1: "0.1 s", 0: "1 s", 1: "10 s", 2: "100 s", 3: "1000 s"}
COUNTS = {k: str(10**k) if k < 4 else f"1e{k}" for k in range(13)}
ERRORS = "datum.value > 0 ? '' : datum.value == 0 ? '1' : '1e' + datum.value"

MARGIN = 0.45
"""Errors above 10**MARGIN (nearly 3 times the motion) are drawn in the margin of failed trials."""
TOP = 2.6
EXACT = -17.0
"""The decade at which an error of exactly zero is drawn, below every floor."""
OTHERS = COLOURS["faint"]
TENTHS = 8
"""Marks of failed trials that are closer than one over this number of decades are one mark."""
PROBLEM = ["case", "variant", "formulation"]


def work_points(reduced: pd.DataFrame, look: pd.DataFrame) -> pd.DataFrame:
    """The points of work-precision diagrams: one row a setting of a series, decades on both axes, and its PROBLEM.

    A failed trial is drawn in the margin above the diagram, in the row of its library, at its own work if that was
    measured, else at the work of the nearest measured setting of its series. `front` marks the integrators in colour.
    """
    lanes = dict(zip(look["series"], look["lane"], strict=True))
    rows = reduced[reduced["setting"].notna()]
    with np.errstate(divide="ignore", invalid="ignore"):
        table = pd.DataFrame(
            {
                **{name: rows[name] for name in PROBLEM},
                "series": rows["integrator_id"],
                "setting": rows["setting"],
                "status": rows["status"],
                "time": np.log10(rows["seconds"].astype(float).to_numpy()),
                "calls": np.log10(rows["rhs_calls"].astype(float).to_numpy()),
                "error": np.maximum(np.log10(rows["error_max"].astype(float).to_numpy()), EXACT),
            }
        )
    failed = ~table["status"].isin([Status.OK, Status.INACCURATE]) | ~(table["error"] <= MARGIN)
    sweep = table.groupby([*PROBLEM, "series"], sort=False).ngroup()
    for axis in ("time", "calls"):
        table[axis] = table[axis].where(np.isfinite(table[axis]))
        nearest = table[axis].groupby(sweep).ffill().groupby(sweep).bfill()
        table[axis] = table[axis].where(~failed, nearest)
    heights = (TOP - MARGIN) * (0.75 - 0.6 * table["series"].map(lanes).astype(float) / max(*lanes.values(), 1))
    kinds = dict(zip(look["series"], look["library"] + look["family"], strict=True))
    answered = table.assign(error=table["error"].where(~failed, math.inf))
    answered = answered[~failed | (table["status"] == Status.DIVERGED)]
    chosen = {problem: front(part, kinds) for problem, part in answered.groupby(PROBLEM, sort=False)}
    names = zip(*(table[name] for name in PROBLEM), table["series"], strict=True)
    return table.assign(
        failed=failed,
        error=table["error"].where(~failed, MARGIN + heights),
        front=[name in chosen.get(tuple(problem), ()) for *problem, name in names],
    )


def front(rows: pd.DataFrame, kinds: dict[str, str]) -> set[str]:
    """The fastest integrators of each kind at each of the errors 1e-3 to 1e-12.

    `kinds`: the library and family of each integrator. A kind that reaches no error shows its most accurate integrator.
    `rows`: series, time and error in decades (infinite where it diverged), the loosest setting of a series first.
    """
    sweeps: dict[str, list[tuple[float, float]]] = {}
    for name, time, error in zip(rows["series"], rows["time"], rows["error"], strict=True):
        if math.isfinite(time):
            sweeps.setdefault(name, []).append((10.0**error, 10.0**time))
    fastest: dict[tuple[str, float], tuple[float, str]] = {}
    most_accurate: dict[str, tuple[float, str]] = {}
    for name, points in sweeps.items():
        errors, seconds = zip(*points, strict=True)
        if math.isinf(min(errors)):
            continue
        kind, held = kinds[name], credit_errors(errors)
        most_accurate[kind] = min(most_accurate.get(kind, (math.inf, "")), (min(errors), name))
        for target in TARGETS:
            time, _ = crossing(held, seconds, target)
            if math.isfinite(time):
                fastest[kind, target] = min(fastest.get((kind, target), (math.inf, "")), (time, name))
    there = {kind for kind, _ in fastest}
    return {name for _, name in fastest.values()} | {
        name for kind, (_, name) in most_accurate.items() if kind not in there
    }


def work_precision(look: pd.DataFrame, axis: str) -> dict[str, Any]:
    """Error against time or right-hand sides (`axis` "time" or "calls"), failed trials in the margin above.

    The specification has no data; its scales name the integrators of `look`, in that order. `draw` makes a diagram
    from it, as the page does.
    """
    title = {"time": "time of one solve", "calls": "right-hand sides evaluated"}[axis]
    domain = list(look["series"])
    legend = alt.Legend(title=None)
    colour = alt.Color("series:N", legend=legend, scale=alt.Scale(domain=domain, range=list(look["colour"])))
    shape = alt.Shape("series:N", legend=legend, scale=alt.Scale(domain=domain, range=list(look["shape"])))
    dash = alt.StrokeDash("series:N", legend=legend, scale=alt.Scale(domain=domain, range=list(look["dash"])))
    pick = alt.selection_point(name="pick", fields=["series"], bind="legend")
    hover = alt.selection_point(name="hover", fields=["series"], on="pointerover", clear="pointerout")
    strength = alt.condition(pick & hover, alt.value(1.0), alt.value(0.15))
    x, y = _axes(axis, title)
    base = alt.Chart(alt.NamedData("points")).transform_filter(f"isValid(datum.{axis}) && isValid(datum.error)")
    tooltip = [
        alt.Tooltip("series:N", title="integrator"),
        alt.Tooltip("setting:Q", title="setting", format=".3g"),
        alt.Tooltip("status:N"),
        alt.Tooltip("e:N", title="error"),
        alt.Tooltip("w:N", title=title),
    ]
    worded = {
        "e": f"datum.failed ? 'failed' : datum.error <= {EXACT} ? '0' : format(pow(10, datum.error), '.1e')",
        "w": f"format(pow(10, datum.{axis}), '.3s')" + (" + 's'" if axis == "time" else ""),
        "letter": f"({expression(LETTERS)})[datum.status] || '?'",
    }
    base = base.transform_calculate(**worded)
    answered, lost = base.transform_filter("!datum.failed"), base.transform_filter("datum.failed")
    order = alt.Order("setting:Q", sort="descending")
    others, first = answered.transform_filter("!datum.front"), answered.transform_filter("datum.front")
    # Failed trials of a library that are close are one mark with their number: single ones would cover each other.
    close = {"near": f"round({TENTHS} * datum.{axis}) / {TENTHS}"}
    piles = lost.transform_calculate(**close).transform_aggregate(
        trials="count()", groupby=["near", "error", "letter", "status"]
    )
    piles = piles.transform_calculate(mark="datum.letter + (datum.trials > 1 ? datum.trials : '')")
    pointed = alt.selection_point(name="pointed", fields=["series"], on="pointerover", clear="pointerout", empty=False)
    grey = alt.condition(pointed, alt.value(INK), alt.value(OTHERS))
    margin = alt.Chart(alt.NamedData("margin"))
    rules = alt.Chart(alt.NamedData("limits"))
    small = {"align": "left", "baseline": "bottom", "color": QUIET, "fontSize": 10.5}
    pile_text = [alt.Tooltip("status:N"), alt.Tooltip("trials:Q", title="trials near here")]
    chart = alt.layer(
        margin.mark_rect(color=PALE).encode(y=alt.Y("low:Q"), y2="high:Q"),
        margin.mark_text(**small, dx=1, dy=-3).encode(y="high:Q", x=alt.value(0), text="text:N"),
        rules.mark_rule(color=QUIET, strokeDash=[2, 3], strokeWidth=1.3).encode(y="at:Q"),
        others.mark_line(strokeWidth=1).encode(x, y, detail="series:N", order=order, color=grey),
        others.mark_point(size=14, filled=True, opacity=1)
        .encode(x, y, color=grey, tooltip=tooltip)
        .add_params(pointed),
        first.mark_line(strokeWidth=2).encode(x, y, colour, strokeDash=dash, opacity=strength, order=order),
        first.mark_point(size=52, filled=True)
        .encode(x, y, colour, shape, opacity=strength, tooltip=tooltip)
        .add_params(pick, hover),
        piles.mark_text(fontSize=9.5, color=QUIET).encode(alt.X("near:Q"), y, text="mark:N", tooltip=pile_text),
        *(_limit_words(rules, small, floor, halo) for halo in (True, False) for floor in (True, False)),
    )
    margin_text = [{"low": MARGIN, "high": TOP, "text": "failed trials, with their number"}]
    data: dict[str, Any] = {"points": [], "limits": [], "margin": margin_text}
    return dict(dress(chart.properties(width=640, height=440, datasets=data)).to_dict(validate=False))


def _axes(axis: str, title: str) -> tuple[alt.X, alt.Y]:
    """Time or right-hand sides across, the error up to the margin of failed trials."""
    names = {"time": SECONDS, "calls": COUNTS}[axis]
    x = alt.X(
        f"{axis}:Q",
        title=title,
        scale=alt.Scale(zero=False, nice=True, padding=14),
        axis=alt.Axis(tickMinStep=1, labelOverlap=True, labelExpr=f"({expression(names)})[datum.value] || ''"),
    )
    only_errors = alt.condition("datum.value > 0", alt.value("transparent"), alt.value(GRID))
    y = alt.Y(
        "error:Q",
        title="error (largest over the samples)",
        scale=alt.Scale(zero=False, nice=False, domainMax=TOP, padding=14),
        axis=alt.Axis(tickMinStep=1, tickCount=9, labelExpr=ERRORS, gridColor=only_errors, tickColor=only_errors),
    )
    return x, y


def _limit_words(rules: alt.Chart, small: dict[str, Any], floor: bool, halo: bool) -> alt.Chart:
    """The label of a limit; the floor's label is below its line, because both lines may be close.

    A pale edge (`halo`) separates letters from lines.
    """
    place = {"baseline": "top", "dy": 4} if floor else {"baseline": "bottom", "dy": -2}
    edge = {"stroke": COLOURS["paper"], "strokeWidth": 3, "strokeOpacity": 0.85} if halo else {}
    chosen = rules.transform_filter(f"(indexof(datum.limit, 'floor') == 0) == {str(floor).lower()}")
    words = chosen.mark_text(**small | {"align": "right", "dx": -4} | place | edge)
    return words.encode(y="at:Q", x=alt.value("width"), text="limit:N")


def draw(specification: dict[str, Any], points: pd.DataFrame, limits: dict[str, float]) -> dict[str, Any]:
    """A diagram from the `specification` of `work_precision`; the legend has the integrators in colour.

    If all failed, and so no integrator is in colour, the legend has all, as on the page: a figure with an empty legend
    has no width.
    """
    data = {
        "points": records(points),
        "limits": [{"limit": name, "at": math.log10(value)} for name, value in limits.items() if value > 0],
    }
    shown = set(points.loc[points["front"], "series"]) or set(points["series"])
    cut: dict[str, Any] = _restrict_scales(specification, shown)
    return cut | {"datasets": specification["datasets"] | data}


def _restrict_scales(node: Any, shown: Collection[str]) -> Any:
    """A copy whose scales of integrators have only the names in `shown`."""
    if isinstance(node, list):
        return [_restrict_scales(each, shown) for each in node]
    if not isinstance(node, dict):
        return node
    restricted = {name: _restrict_scales(value, shown) for name, value in node.items()}
    scale = restricted.get("scale")
    if restricted.get("field") == "series" and scale and "domain" in scale:
        pairs = [pair for pair in zip(scale["domain"], scale["range"], strict=True) if pair[0] in shown]
        restricted["scale"] = scale | {"domain": [name for name, _ in pairs], "range": [look for _, look in pairs]}
    return restricted


def expression(names: dict[int, str] | dict[str, str]) -> str:
    """The names by value as an object of Vega's expressions."""
    return "{" + ", ".join(f"'{key}': '{value}'" for key, value in names.items()) + "}"

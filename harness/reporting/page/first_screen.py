"""The pictures that open the page: one motion with its work-precision diagram, the libraries over all cases, and where each fails."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.contract.status import CANNOT_RUN, Status
from gnomon.harness.reporting.figures_work import COUNTS, ERRORS, EXACT, MARGIN, SECONDS, expression
from gnomon.harness.reporting.kept_parts import keep_result
from gnomon.harness.reporting.page import moving
from gnomon.harness.reporting.page.kind_table import kind_table
from gnomon.harness.reporting.page.representing import NAMED, Representatives, choose_for, label
from gnomon.harness.reporting.page.stills import NARROW, WIDE, figure, stills
from gnomon.harness.reporting.style import DRESS, INK, OWN_GREY, QUIET, find_colour, hue, records
from gnomon.harness.results import analysis, number_text, profiles
from gnomon.harness.results.contenders import OWN, THIRD, YOURS, division
from gnomon.harness.results.number_text import error_text, join_words, power_text, time_text
from markupsafe import Markup

LEAD = "pendulum_simple"
"""The case whose diagram opens the page, if it was run."""
AT = 1e-6
TARGETS = (1e-3, 1e-6, 1e-9)
FACTORS = 10 ** np.linspace(0, 3, 61)
FEWEST = 12
"""Smallest number of cases in a profile."""
AXES = {"time": "seconds", "calls": "calls"}
FAILS = {
    "reaches": "reaches 1e-6",
    "rough": "runs, but not to 1e-6",
    "fails": "fails at every setting",
    "cannot": "cannot state the case",
    "unrun": "not in this run",
}


def first_screen(libraries: Representatives) -> dict[str, Any]:
    """The parts of the first screen: `lead`, `kinds`, `profiles` (None with few cases), `fails`, `faster`."""
    by_axis = {"time": libraries.rows(libraries.run.equal), "calls": libraries.rows(libraries.run.counted)}
    return {
        "lead": _lead(libraries),
        "profiles": _profiles(libraries, by_axis),
        "kinds": kind_table(libraries, libraries.measured, libraries.limits) if len(libraries.complete) > 1 else None,
        "fails": _fails(libraries) if len(libraries.complete) > 1 else None,
        "stands": [stand._asdict() for stand in libraries.stands],
        "faster": [row._asdict() for row in libraries.faster(AT)],
        "complete": len(libraries.complete),
    }


def _lead(libraries: Representatives) -> dict[str, Any] | None:
    """One case with its moving picture, its diagram and the times to 1e-6 in a sentence; None without a default variant."""
    run = libraries.run
    rows = analysis.own(analysis.settings(run.frame))
    rows = rows[~rows["status"].isin([*CANNOT_RUN, Status.SKIPPED])]
    present = list(dict.fromkeys(rows["case"].tolist()))
    ready = [name for name in libraries.complete if name in present] or present
    if not ready:
        return None
    case = LEAD if LEAD in ready else ready[0]
    rows = rows[rows["case"] == case]
    least, several = {axis: _least(libraries, case, axis) for axis in AXES}, list(rows["integrator_id"].unique())
    if case in run.own:  # the user asks for the fastest; no library is judged
        several = _order_divisions(several, least["time"])[:NAMED]
    names = choose_for(libraries, case, several)
    rows = rows[rows["integrator_id"].isin(names)]
    if rows.empty:
        return None
    specs = [
        _diagram(rows, [label(name) for name in _order_divisions(names, least[axis])], axis, width)
        for axis in AXES
        for width in (WIDE, NARROW)
    ]
    drawn = iter(stills(specs))
    drawings = {axis: {width: next(drawn) for width in (WIDE, NARROW)} for axis in AXES}
    known = next((motion for motion in run.cases if motion.name == case), None)
    return {
        "case": case,
        "title": run.titles[case],
        "figure": figure(drawings, f"Work-precision diagram of the case {case}: error against time or evaluations"),
        "said": {axis: _say_case(libraries, case, _order_divisions(names, least[axis]), axis) for axis in AXES},
        "conditioning": error_text(float(rows["conditioning"].max())),
        "moving": None
        if known is None
        else Markup(keep_result((moving.__name__,), repr(known.numbers) + case, lambda: str(moving.moving(known)))),
    }


def _least(libraries: Representatives, case: str, axis: str) -> dict[str, float]:
    """The time or count to 1e-6 of each integrator that reaches it on a case; nan of one that reaches only other errors."""
    equal = libraries.run.equal if axis == "time" else libraries.run.counted
    rows = analysis.own(equal[equal["case"] == case])
    at = rows[rows["target"] == AT].set_index("integrator_id")[AXES[axis]]
    return {name: float(at.get(name, math.nan)) for name in rows["integrator_id"].unique()}


def _order_divisions(names: Sequence[str], least: Mapping[str, float]) -> list[str]:
    """The divisions in their order; in each the least first, last those that do not reach the error."""
    value = {name: at for name, at in least.items() if math.isfinite(at)}
    places = (YOURS, THIRD, OWN)
    return sorted(names, key=lambda name: (places.index(division(name.partition(":")[0])), value.get(name, math.inf)))


def _say_case(libraries: Representatives, case: str, names: Sequence[str], axis: str) -> str:
    """The times or counts of a case at 1e-6 in one sentence, third parties first. `names`: in the order of the sentence."""
    known = _least(libraries, case, axis)
    clauses: dict[str, list[str]] = {THIRD: [], YOURS: [], OWN: []}
    for name in names:
        of = division(name.partition(":")[0])
        shown = label(name).removeprefix("gnomon ") if of == OWN else label(name)
        value = known.get(name, math.nan)
        if math.isfinite(value):
            clauses[of].append(f"{shown} {time_text(value) if axis == 'time' else f'{value:.0f}'}")
        elif case in libraries.complete and (axis == "time" or name in known):
            clauses[of].append(f"{shown} does not reach it")
    text = "; ".join(", ".join(clauses[of]) for of in (YOURS, THIRD) if clauses[of])
    if clauses[OWN]:
        text += ("; and of gnomon’s own: " if text else "") + ", ".join(clauses[OWN])
    what = "on" if axis == "time" else "evaluations of the equations on"
    title = number_text.lower_first(libraries.run.titles[case])
    limits = f" “Does not reach it”: within {libraries.limits_of(case)}." if "does not reach it" in text else ""
    words = f"{what} “{title}” at an error of {power_text(AT)}: {text or 'not counted'}.{limits}"
    return words[0].upper() + words[1:]


def _diagram(rows: pd.DataFrame, order: Sequence[str], axis: str, width: str) -> dict[str, Any]:
    """Error against time or evaluations: a line an integrator, a point a setting that gave an answer.

    `order`: the names of the integrators as the legend lists them.
    """
    column = {"time": "seconds", "calls": "rhs_calls"}[axis]
    answered = rows[rows["status"].isin([Status.OK, Status.INACCURATE]) & (rows[column] > 0)]
    points = pd.DataFrame(
        {
            "name": [label(name) for name in answered["integrator_id"]],
            "own": (answered["library"] == profiles.OURS).to_numpy(),
            "x": np.log10(answered[column].to_numpy(float)),
            "y": np.clip(np.log10(np.maximum(answered["error_max"].to_numpy(float), 1e-300)), EXACT, MARGIN),
            "setting": answered["setting"].to_numpy(float),
        }
    ).sort_values("setting", ascending=False)
    names = {label(row.integrator_id): row.library for row in rows.drop_duplicates("integrator_id").itertuples()}
    present = set(points["name"])
    domain = [name for name in order if name in present]
    limit = float(rows["conditioning"].max())
    at = [{"y": math.log10(limit)}] if limit > 0 else []
    lowest = math.floor(min([*points["y"], *(mark["y"] for mark in at), -12.0])) - 0.5
    low, high = (float(points["x"].min()), float(points["x"].max())) if len(points) else (0.0, 1.0)
    what = {"time": "time of one solve (less is better)", "calls": "evaluations of the equations (less is better)"}
    named = f"({expression({'time': SECONDS, 'calls': COUNTS}[axis])})[datum.value] || ''"
    x = _axis("x", what[axis], [low - 0.15, high + 0.15], {"tickMinStep": 1, "labelOverlap": True, "labelExpr": named})
    y = _axis(
        "y",
        "largest error (lower is better)",
        [lowest, MARGIN],
        {"tickMinStep": 1, "tickCount": 6, "labelExpr": ERRORS},
    )
    legend = {"columns": 1 if width == NARROW else 3, "symbolType": "circle", "labelLimit": 320}
    hues = dict(zip(names, _distinct(list(names.values())), strict=True))
    colour = _colours(domain, [hues[name] for name in domain], legend)
    colour["sort"] = None  # else the legend is in the order of the alphabet
    lines = {
        "mark": {"type": "line", "strokeWidth": 2},
        "encoding": {"x": x, "y": y, "color": colour, "order": {"field": "setting", "sort": "descending"}},
    }
    dots = {
        "mark": {"type": "point", "size": 40, "filled": True, "opacity": 1},
        "encoding": {"x": x, "y": y, "color": colour},
    }
    rule = {
        "mark": {"type": "rule", "color": QUIET, "strokeDash": [4, 4]},
        "encoding": {"y": y},
        "data": {"values": at},
    }
    size = {"width": 560, "height": 300} if width == WIDE else {"width": 270, "height": 280}
    return {"layer": [rule, lines, dots], "data": {"values": records(points)}, "config": DRESS, **size}


def _axis(field: str, title: str | None, domain: Sequence[float], axis: Mapping[str, Any]) -> dict[str, Any]:
    scale = {"domain": list(domain), "nice": False, "zero": False}
    return {"field": field, "type": "quantitative", "title": title, "scale": scale, "axis": axis}


def _colours(names: Sequence[str], colours: Sequence[str], legend: Mapping[str, Any] | None) -> dict[str, Any]:
    shown = None if legend is None else {"title": None, "orient": "bottom", **legend}
    return {
        "field": "name",
        "type": "nominal",
        "scale": {"domain": list(names), "range": list(colours)},
        "legend": shown,
    }


def _distinct(libraries: Sequence[str]) -> list[str]:
    """A colour a line: of its library, if each library has one line here; else one of the hues in turn."""
    if len(set(libraries)) == len(libraries):
        return [hue(library) for library in libraries]
    others = [find_colour(name) for name in ("orange", "green", "blue", "pink", "ochre", "violet", "ink")]
    return [
        OWN_GREY if library == profiles.OURS and len(set(libraries)) > 1 else others[k % len(others)]
        for k, library in enumerate(libraries)
    ]


def _profiles(libraries: Representatives, by_axis: Mapping[str, pd.DataFrame]) -> dict[str, Any] | None:
    """Performance profiles of the libraries at three errors, with the shares at their right ends.

    None with few cases, or without a third party, which sets the scale.
    """
    if len(libraries.complete) < FEWEST or not libraries.third:
        return None
    specs, shares = [], {}
    for axis, column in AXES.items():
        parts = {target: _shares(libraries, by_axis[axis], target, column) for target in TARGETS}
        shares[axis] = parts
        specs += [_profile_chart(parts, axis, width) for width in (WIDE, NARROW)]
    drawn = iter(stills(specs))
    drawings = {axis: {width: next(drawn) for width in (WIDE, NARROW)} for axis in AXES}
    return {
        "figure": figure(
            drawings,
            "Performance profiles of the libraries at errors of 1e-3, 1e-6 and 1e-9; the sentence below has the numbers",
        ),
        "said": _say_reach(libraries, shares["time"][AT]),
    }


def _shares(libraries: Representatives, rows: pd.DataFrame, target: float, column: str) -> list[dict[str, Any]]:
    """For each stand its share of all complete cases within each factor of the least third-party value, with its band.

    gnomon's own methods never set the scale: where they take less than all third parties, they are at a factor of 1.
    """
    table = libraries.times(rows, target, column)
    least = table[libraries.third].min(axis=1)
    ratio = table.div(least, axis=0).where(np.isfinite(table), np.inf).clip(lower=1.0)
    ratio = ratio.mask(np.isinf(least), table.where(np.isinf(table), 1.0), axis=0)
    known = {stand.name: stand for stand in libraries.stands}
    some = [name for name in ratio if np.isfinite(ratio[name]).any() or column == "seconds"]
    return [
        {"stand": known[profile.name], "share": profile.share, "low": profile.low, "high": profile.high}
        for profile in profiles.profiles(ratio[some], FACTORS.tolist())
    ]


def _profile_chart(parts: Mapping[float, Sequence[Mapping[str, Any]]], axis: str, width: str) -> dict[str, Any]:
    """A diagram an error, beside each other or below: a line a library with its band, its name and share at the end."""
    titles = [row["stand"].title for part in parts.values() for row in part]
    domain = list(dict.fromkeys(titles))
    stand = {row["stand"].title: row["stand"] for part in parts.values() for row in part}
    colours = [hue(stand[name].name.partition(":")[0]) for name in domain]
    what = {"time": "time", "calls": "evaluations"}[axis] + " / least third-party"
    x = _axis(
        "x", what, [0, 3], {"values": [0, 1, 2, 3], "labelExpr": "pow(10, datum.value) + ' ×'", "labelFlush": True}
    )
    charts: list[dict[str, Any]] = []
    for target, part in parts.items():
        title = None if charts and width == WIDE else "share of the cases"
        named = title is not None  # beside each other, the diagrams share the words of one axis
        y = _axis("share", title, [0, 1], {"format": ".0%", "values": [0, 0.25, 0.5, 0.75, 1], "labels": named})
        step = {"interpolate": "step-after"}
        encoding = {
            "x": x,
            "y": y | {"field": "low"},
            "y2": {"field": "high"},
            "color": _colours(domain, colours, None),
        }
        band = {"mark": {"type": "area", "opacity": 0.14, **step}, "encoding": encoding}
        line = {
            "mark": {"type": "line", "strokeWidth": 2.2, **step},
            "encoding": {"x": x, "y": y, "color": _colours(domain, colours, None)},
        }
        rows = [
            {"name": row["stand"].title, "x": at, "share": round(s, 4), "low": round(low, 4), "high": round(high, 4)}
            for row in part
            for at, s, low, high in zip(
                np.log10(FACTORS).round(3).tolist(), *(row[n].tolist() for n in ("share", "low", "high")), strict=True
            )
        ]
        size = {"width": 165, "height": 200} if width == WIDE else {"width": 205, "height": 150}
        layers = [band, line, *_ends(part, x, y, _colours(domain, colours, None), size["height"])]
        charts.append(
            {"title": f"to an error of {power_text(target)}", "layer": layers, "data": {"values": rows}, **size}
        )
    config = DRESS | {"title": DRESS["title"] | {"fontSize": 13}}
    return {"hconcat" if width == WIDE else "vconcat": charts, "spacing": 18, "config": config}


def _ends(
    part: Sequence[Mapping[str, Any]],
    x: Mapping[str, Any],
    y: Mapping[str, Any],
    colour: Mapping[str, Any],
    height: int,
) -> list[dict[str, Any]]:
    """Layers with the name and the share of each line at its right end, apart also where lines cover each other."""
    gap = 12 / height
    ordered = sorted(part, key=lambda row: -row["share"][-1])
    places = [float(row["share"][-1]) for row in ordered]
    for k in range(1, len(places)):
        places[k] = min(places[k], places[k - 1] - gap)
    for k in reversed(range(len(places))):  # none below the axis
        places[k] = max(places[k], gap * (len(places) - 1 - k))
    rows = [
        {"name": row["stand"].title, "share": round(float(row["share"][-1]), 4), "at": round(at, 4), "x": 3, "end": 3.2}
        | {"text": f"{row['stand'].title} {row['share'][-1]:.0%}"}
        for row, at in zip(ordered, places, strict=True)
    ]
    to = {"x2": {"field": "end"}, "y2": {"field": "at"}, "color": colour}
    leader = {"mark": {"type": "rule", "strokeWidth": 1.4}, "encoding": {"x": x, "y": y, **to}}
    at = {"x": {**x, "field": "end"}, "y": {**y, "field": "at"}, "text": {"field": "text"}}
    words = {"mark": {"type": "text", "align": "left", "dx": 3, "fontSize": 10.5, "color": INK}, "encoding": at}
    return [layer | {"data": {"values": rows}} for layer in (leader, words)]


def _say_reach(libraries: Representatives, part: Sequence[Mapping[str, Any]]) -> str:
    """On how many of the cases that it can state each library reaches an error of 1e-6, third parties first, in falling order."""
    able = {
        stand.name: sum(_can_state(libraries, case, libraries.method(stand, case)) for case in libraries.complete)
        for stand in libraries.whole
    }
    stands = [row["stand"] for row in part]
    count = {
        stand.name: sum(libraries.reaches(case, str(libraries.method(stand, case)), AT) for case in libraries.complete)
        for stand in stands
    }
    stands.sort(key=lambda stand: (stand.division == OWN, -count[stand.name]))
    words = [f"{stand.title} on {count[stand.name]} of {able[stand.name]}" for stand in stands]
    others = sum(stand.division != OWN for stand in stands)
    text = "; ".join(join_words(part) for part in (words[:others], words[others:]) if part)
    return f"Of the cases that a library can state, it reaches {power_text(AT)} within {libraries.limits}: {text}."


def _fails(libraries: Representatives) -> dict[str, Any]:
    """By kind of system and library, on how many complete cases its method reaches 1e-6, runs, fails or cannot run."""
    rows = []
    for kind, cases in libraries.run.kinds.items():
        inside = [case for case in cases if case in libraries.complete]
        if not inside:
            continue
        cells = [
            {"stand": stand, "method": method, "counts": _counts(libraries, inside, method)}
            for stand in libraries.stands
            for method in [stand.methods.get(kind)]
        ]
        rows.append({"kind": kind, "cases": inside, "cells": cells})
    return {"rows": rows, "meanings": FAILS}


def _can_state(libraries: Representatives, case: str, method: str | None) -> bool:
    """Whether a method can state a case, as far as is known."""
    row = libraries.known.get((case, method or ""))
    return method is not None and (row is None or row["verdict"] not in CANNOT_RUN)


def _counts(libraries: Representatives, cases: Sequence[str], method: str | None) -> list[tuple[str, int]]:
    counts: Counter[str] = Counter()
    for case in cases:
        row = libraries.known.get((case, method or ""))
        if not _can_state(libraries, case, method):
            counts["cannot"] += 1
        elif row is None:
            counts["unrun"] += 1
        elif libraries.reaches(case, str(method), AT):
            counts["reaches"] += 1
        else:
            counts["rough" if row["settings_ok"] else "fails"] += 1
    return [(kind, counts[kind]) for kind in FAILS if counts[kind]]

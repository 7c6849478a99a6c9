"""The league of physics engines on the page: a figure for each scene, and tables of what each engine does and costs."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gnomon.harness.adapters.libraries import title
from gnomon.harness.registry.representatives import representative
from gnomon.harness.reporting import sidecars
from gnomon.harness.reporting.page.stills import stills
from gnomon.harness.reporting.style import DRESS, QUIET, hue
from gnomon.harness.results.advice import engine_facts
from gnomon.harness.results.number_text import error_text, figures_text, join_words, short_text
from markupsafe import Markup

LOWEST, HIGHEST = -14.0, 0.5
"""The decades of error that a figure shows; what is beyond is drawn at the edge."""
SIZE = {"width": 232, "height": 190}


def league(*folders: Path) -> dict[str, Any] | None:
    """The parts of the section, from the first folder that has engines.json; None without a file."""
    facts = sidecars.first(sidecars.LEAGUE, *folders)
    if facts is None:
        return None
    engines = {engine["id"]: engine for engine in facts["engines"]}
    rows: dict[str, list[dict[str, Any]]] = {scene["scene"]: [] for scene in facts["scenes"]}
    for row in facts["rows"]:
        engine = engines[row["integrator"]]
        rows[row["scene"]].append(row | {"library": engine["library"], "order_declared": engine["order"]})
    libraries = list(dict.fromkeys(engine["library"] for engine in facts["engines"]))
    drawn = stills([_figure(scene, rows[scene["scene"]]) for scene in facts["scenes"]])
    return {
        "environment": facts["environment"],
        "absent": facts["absent"],
        "lines": {title(name): lines for name, lines in facts["lines"].items() if lines},
        "libraries": [
            {"name": name, "title": title(name), "version": _version(engines.values(), name)} for name in libraries
        ],
        "scenes": [
            {
                "name": scene["scene"],
                "title": scene["title"],
                "picture": Markup(svg),
                "rows": [_parts(row) for row in rows[scene["scene"]]],
            }
            for scene, svg in zip(facts["scenes"], drawn, strict=True)
        ],
        "ways": [_way(engine, facts) for engine in facts["engines"]],
        "table": _table(facts["table"]),
        "failed": [_describe_failure(row) for row in facts["preflights"] if row.get("verdict", "failed") == "failed"],
    }


def _version(engines: Any, library: str) -> str:
    return next((", ".join(map(str, row["versions"].values())) for row in engines if row["library"] == library), "")


def stands_for(library: str) -> set[str]:
    """The integrators of an engine that its manual names: their lines are thick."""
    chosen = (
        representative(library, kind)
        for kind in ("Forces of position and time alone", "Impact, friction and changing contact")
    )
    return {method.integrator for method in chosen if method is not None}


def _figure(scene: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Error against step: a line for each way to drive an engine, what remains of its error, and the two floors."""
    points, rests = [], []
    thick = {name for row in rows for name in stands_for(row["library"])}
    for row in rows:
        kind = "shipped" if row["policy"] == engine_facts.SHIPPED else "best" if row["integrator"] in thick else "other"
        own = {"name": row["integrator"], "colour": hue(row["library"]), "kind": kind}
        points += [own | {"x": math.log10(h), "y": _decades(e)} for h, e, _ in row["points"]]
        if row.get("rest_is") == "model":
            rests.append(own | {"y": _decades(row["rest"])})
    floors = [
        {"y": max(LOWEST, math.log10(scene[name])), "text": name}
        for name in ("binary32", "binary64")
        if scene[name] > 0
    ]
    x = _axis("x", "step (s)", {"tickMinStep": 1, "labelExpr": "datum.value % 1 ? '' : '1e' + datum.value"})
    y = _axis(
        "y", None, {"tickMinStep": 2, "labelExpr": "datum.value == 0 ? '1' : '1e' + datum.value"}, [LOWEST, HIGHEST]
    )
    colour = {"field": "colour", "type": "nominal", "scale": None}
    line = {
        "mark": {"type": "line", "interpolate": "linear"},
        "data": {"values": points},
        "encoding": {
            "x": x, "y": y, "color": colour, "detail": {"field": "name"}, "order": {"field": "x"},
            "strokeWidth": {"field": "kind", "scale": {"domain": ["best", "other", "shipped"], "range": [2.4, 1, 1]}, "legend": None},
            "strokeDash": {"field": "kind", "scale": {"domain": ["best", "other", "shipped"], "range": [[1, 0], [1, 0], [3, 3]]}, "legend": None},
        },
    }  # fmt: skip
    rest = {
        "mark": {"type": "tick", "orient": "horizontal", "thickness": 3, "size": 14},
        "data": {"values": rests},
        "encoding": {"y": y, "x": {"value": 7}, "color": colour},
    }
    rule = {
        "mark": {"type": "rule", "color": QUIET, "strokeDash": [4, 4]},
        "data": {"values": floors},
        "encoding": {"y": y},
    }
    words = {
        "mark": {"type": "text", "color": QUIET, "align": "right", "baseline": "bottom", "fontSize": 10, "dy": -2},
        "data": {"values": floors},
        "encoding": {"y": y, "x": {"value": SIZE["width"]}, "text": {"field": "text"}},
    }
    return {"layer": [rule, words, line, rest], "config": DRESS, **SIZE}


def _decades(error: float | None) -> float:
    return HIGHEST if error is None else min(HIGHEST, max(LOWEST, math.log10(error) if error > 0 else LOWEST))


def _axis(
    field: str, name: str | None, axis: Mapping[str, Any], domain: Sequence[float] | None = None
) -> dict[str, Any]:
    scale = {"zero": False, "nice": False} | ({"domain": list(domain)} if domain else {})
    return {
        "field": field,
        "type": "quantitative",
        "title": name,
        "scale": scale,
        "axis": {**axis, "labelOverlap": True},
    }


def _parts(row: Mapping[str, Any]) -> dict[str, str]:
    """A row of the table of a scene: the four parts of the error in words."""
    parts = {"integrator": row["integrator"]}
    if row["status"] != "ran":
        return parts | {"reason": f"{row['status'].replace('_', ' ')}: {row['reason']}"}
    order, declared = row["order"], row["order_declared"]
    off = order is not None and declared is not None and abs(order - declared) > 0.3
    steps = [f"{float(target):.0e}: {step:g} s" for target, step in row["steps"].items() if step is not None]
    return parts | {
        "reason": "",
        "integration": "no steady order"
        if order is None
        else f"order {order:.2f}" + (f" (declared {declared})" if off else ""),
        "constant": "" if row["constant"] is None else figures_text(row["constant"]),
        "model": error_text(row["rest"]) if row["rest_is"] == "model" else "none seen",
        "solver": "" if row["solver"] is None else error_text(row["solver"]),
        "precision": error_text(row["precision"]),
        "steps": ", ".join(steps) or "none",
    }


def _way(engine: Mapping[str, Any], facts: Mapping[str, Any]) -> dict[str, Any]:
    """One way to drive an engine: pre-flights, orders, time of a step by part, memory, bits."""
    name = engine["id"]
    checks = Counter(row.get("verdict", "failed") for row in facts["preflights"] if row["integrator"] == name)
    cost = next((row for row in facts["costs"] if row["integrator"] == name), {"reason": "as configured"})
    orders = sorted(row["order"] for row in facts["rows"] if row["integrator"] == name and row.get("order") is not None)
    takes = facts["table"].get(name)
    return {
        "name": name,
        "takes": "" if takes is None else f"{sum(not why for why in takes.values())} of {len(takes)}",
        "passed": f"{checks['passed']} of {checks['passed'] + checks['failed']}",
        "order": "" if not orders else f"{orders[len(orders) // 2]:.2f} (median of {len(orders)})",
        "declared": "" if engine["order"] is None else str(engine["order"]),
        "cost": _cost(cost),
        "changed": "; ".join(f"{name} = {value}" for name, value in engine["changed"].items()),
    }


def _cost(row: Mapping[str, Any]) -> dict[str, str]:
    if "step_us" not in row:
        return {"reason": row.get("reason", "not measured")}
    parts = {"step": "step_us", "engine": "engine_us", "forces": "forces_us", "read": "read_us", "call": "call_us"}
    different = [where for where, same in row["same_bits"].items() if not same]
    return {
        "reason": "",
        **{word: "" if row[key] is None else f"{row[key]:.3g}" for word, key in parts.items()},
        "python": engine_facts.python_text(row),
        "scene": row["scene"],
        "world": _kilobytes(row["world_kilobytes"]),
        "grown": _kilobytes(row["grown_kilobytes"]),
        "bits": f"differ {join_words(different)}" if different else "same",
        "energy": "" if row["energy_an_hour"] is None else short_text(row["energy_an_hour"]),
    }


def _kilobytes(value: float | None) -> str:
    if value is None:
        return "unknown"
    return f"{value / 1024:.1f} MB" if abs(value) >= 1024 else f"{value:.0f} kB"


def _describe_failure(row: Mapping[str, Any]) -> dict[str, str]:
    """A pre-flight that failed; of an engine that crashed in its pre-flights the reason."""
    return {
        "integrator": row["integrator"],
        "name": row.get("name", "all"),
        "text": engine_facts.failure_text(row),
    }


def _table(table: Mapping[str, Mapping[str, str]]) -> list[dict[str, Any]]:
    """A row for each scene: the engines of which a way runs it, and of the others the reasons."""
    rows = []
    for scene in dict.fromkeys(name for column in table.values() for name in column):
        runs: dict[str, None] = {}
        lacks: dict[str, dict[str, None]] = {}
        for way, column in table.items():
            engine = title(way.partition(":")[0])
            if not column.get(scene):
                runs[engine] = None
            else:
                lacks.setdefault(engine, {})[column[scene]] = None
        without = [(engine, "; or ".join(why)) for engine, why in lacks.items() if engine not in runs]
        rows.append({"scene": scene, "runs": list(runs), "lacks": without})
    return rows

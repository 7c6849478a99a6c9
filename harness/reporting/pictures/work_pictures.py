"""The diagrams of error against time of a results file in one picture, one under the other."""

from __future__ import annotations

import warnings
from collections.abc import Set
from pathlib import Path
from typing import Any

from gnomon.cases.core.numbers import is_pattern, matching, nearest
from gnomon.harness.registry.selection import DEFAULT
from gnomon.harness.reporting.figures_work import draw, work_precision
from gnomon.harness.reporting.report_charts import Problems, work_problems
from gnomon.harness.reporting.report_run import Run

MOST = 24
"""The largest number of diagrams in one picture."""


def specification(database: Path, names: list[str] | None = None) -> dict[str, Any]:
    """The diagrams of a results file, of the cases with these names, as a specification of Vega-Lite."""
    run = Run.read(database)
    chosen = _choose(work_problems(run), names)
    if len(chosen) > MOST:
        warnings.warn(f"{len(chosen)} diagrams, of which {MOST} are drawn; --case draws others", stacklevel=2)
    return together(work_precision(run.look, "time"), dict(list(chosen.items())[:MOST]))


def _choose(work: dict[str, Problems], names: list[str] | None) -> dict[str, Any]:
    """The problems to draw, by their titles."""
    every: dict[str, dict[str, Any]] = {}
    for case, labelled in work.items():
        for label, problem in labelled.items():
            variant = label.split(" · ")[0]
            name = case if variant == DEFAULT else f"{case}/{variant}"
            every.setdefault(name, {})[f"{case}, {label}"] = problem
    if not names:
        defaults = {
            f"{name}, {DEFAULT}": problem
            for name, each in work.items()
            for label, problem in each.items()
            if label == DEFAULT
        }
        return defaults or {title: problem for each in every.values() for title, problem in each.items()}
    chosen: dict[str, Any] = {}
    for name in names:
        if not is_pattern(name) and name not in every:
            raise ValueError(f"--case {name}: the run has no such case; {nearest(name, every)}")
        for key in matching(name, every) if is_pattern(name) else [name]:
            chosen |= every[key]
    return chosen


def together(specification: dict[str, Any], chosen: dict[str, Any]) -> dict[str, Any]:
    """One specification with a diagram under the other, from the common one of a diagram and the data of each."""
    panels: list[dict[str, Any]] = []
    params: list[dict[str, Any]] = []
    data: dict[str, Any] = {}
    own = {
        *specification["datasets"],
        *(name for each in specification["params"] for name in (each["name"], *each["views"])),
    }
    for number, (title, problem) in enumerate(chosen.items()):
        diagram = draw(specification, problem["points"], problem["limits"])
        data |= {f"{name}_{number}": rows for name, rows in diagram["datasets"].items()}
        words = {"text": title, "subtitle": problem["stresses"], "anchor": "start"}
        panels.append({"title": words, "width": diagram["width"], "height": diagram["height"]})
        panels[-1]["layer"] = _rename(diagram["layer"], own, f"_{number}")
        params += _rename(diagram["params"], own, f"_{number}")
    common = {name: specification[name] for name in ("$schema", "config") if name in specification}
    apart = {"scale": {name: "independent" for name in ("x", "y", "color", "shape", "strokeDash")}}
    return common | {"datasets": data, "params": params, "vconcat": panels, "resolve": apart}


def _rename(node: Any, own: Set[str], ending: str) -> Any:
    """A copy in which the names of a diagram's `own` data, parameters and views have an ending."""
    if isinstance(node, list):
        return [_rename(each, own, ending) for each in node]
    if isinstance(node, dict):
        return {key: _rename(value, own, ending) for key, value in node.items()}
    return f"{node}{ending}" if isinstance(node, str) and node in own else node

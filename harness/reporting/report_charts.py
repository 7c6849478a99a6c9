"""The charts of a report: their data, their specifications for the page, and their files."""

import hashlib
import json
import math
import re
from collections.abc import Mapping, Set
from pathlib import Path
from typing import Any

import altair as alt
import numpy as np
import pandas as pd
from altair.utils import schemapi
from gnomon.harness.contract.status import SCORED
from gnomon.harness.reporting import figures, report_stability, style, tables
from gnomon.harness.reporting.figures_work import PROBLEM, draw, work_points, work_precision
from gnomon.harness.reporting.images import write_images
from gnomon.harness.reporting.kept_parts import keep_result
from gnomon.harness.reporting.report_pack import columnar, columns, differences
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.reporting.report_stability import stability_charts

FLOOR, CONDITIONING = (
    "floor: half an ulp of the output, or the error of the reference",
    "conditioning: half an ulp of the input",
)

MANIFEST = "figures.json"
"""Lists the figures that a report wrote into its folder."""
SUFFIXES = (".svg", ".png")

Problems = dict[str, dict[str, Any]]


def work_problems(run: Run) -> dict[str, Problems]:
    """The work-precision data of every problem by case: points, limits and stress; default variants first."""
    reduced = run.reduced
    rows = reduced.assign(stresses=reduced.get("stresses", ""))
    problems = rows.groupby(PROBLEM, sort=False)[["conditioning", "floor", "stresses"]].agg(
        {"conditioning": "max", "floor": "max", "stresses": "first"}
    )
    points = {problem: part.drop(columns=PROBLEM) for problem, part in work_points(reduced, run.look).groupby(PROBLEM)}
    by_case: dict[str, Problems] = {name: {} for name in run.names}
    for (case, variant, formulation), limits in problems.to_dict("index").items():
        if (case, variant, formulation) not in points:
            continue
        label = (variant or "default") + (f" · {formulation}" if formulation else "")
        lines = {CONDITIONING: limits["conditioning"], FLOOR: limits["floor"]}
        by_case[case][label] = {
            "points": points[case, variant, formulation],
            "limits": {word: value for word, value in lines.items() if value > 0},
            "stresses": str(limits["stresses"] or ""),
        }
    return {
        name: dict(sorted(problems.items(), key=lambda problem: not problem[0].startswith("default")))
        for name, problems in by_case.items()
    }


Specifications = dict[str, dict[str, Any]]
"""Vega-Lite specifications of charts, by name."""


def specifications(charts: Mapping[str, alt.TopLevelMixin]) -> Specifications:
    """The specifications of charts by name, not validated against Vega-Lite's schema, which would take longest."""
    return {name: chart.to_dict(validate=False) for name, chart in charts.items()}


def run_charts(run: Run) -> Specifications:
    """All charts of a run except the work-precision diagrams; charts without data are left out."""
    with schemapi.debug_mode(False):  # else Altair validates every part of a chart
        return specifications(_run_charts(run))


def _run_charts(run: Run) -> dict[str, alt.TopLevelMixin]:
    charts: dict[str, alt.TopLevelMixin] = {}
    asked = run.reduced[(run.reduced["setting_kind"] == "tolerance") & run.reduced["status"].isin(SCORED)]
    asked = asked[(asked["setting"] > asked["conditioning"].fillna(0)) & asked["error_max"].notna()]
    if len(asked):
        over = asked.assign(over=asked["error_max"] / asked["setting"])
        charts["tolerance"] = figures.tolerance_chart(figures.tolerance_spread(over), run.look)
    levels = run.hierarchies
    if len(levels):
        charts["hierarchy"] = figures.hierarchy_chart(levels[levels["error"] > 0])
    if len(run.policies):
        charts["policies"] = figures.policy_chart(run.policies)
    return charts


def panel_charts(contents: Mapping[str, Any] | None) -> Specifications:
    """`stability_charts`, kept on disk because Altair takes seconds for them."""
    if contents is None:
        return {}
    inputs = json.dumps([alt.__version__, contents.get("figures"), contents["rows"]])
    charts: Specifications = keep_result(
        (report_stability.__name__,), inputs, lambda: specifications(stability_charts(contents))
    )
    return charts


def page_charts(run: Run, work: dict[str, Problems], charts: Specifications) -> dict[str, Any]:
    """The data of the page's script: specifications, the points of each problem, and the digits of all pairs.

    The two work-precision specifications have all integrators; the page reduces them to the integrators of a problem.
    """
    specs = {axis: columnar(_work_precision(run.look, axis)) for axis in ("time", "calls")}
    cases = {
        name: {
            label: {
                "points": columns(_hundredths(problem["points"])),
                "limits": [
                    {"limit": word, "at": round(float(np.log10(at)), 3)} for word, at in problem["limits"].items()
                ],
            }
            for label, problem in problems.items()
        }
        for name, problems in work.items()
    }
    others = {name: columnar(chart) for name, chart in charts.items()}
    return {"work": {"specs": specs, "cases": cases}, "others": others, "map": _map(run)}


def _work_precision(look: pd.DataFrame, axis: str) -> dict[str, Any]:
    """`work_precision`, kept on disk because Altair takes half a second for it."""
    inputs = json.dumps(
        [axis, alt.__version__, style.STYLE, style.DRESS, style.STATUSES, style.STATUS_COLOURS, look.to_dict("list")]
    )
    modules = (work_precision.__module__, style.__name__)
    specification: dict[str, Any] = keep_result(modules, inputs, lambda: work_precision(look, axis))
    return specification


def _hundredths(points: pd.DataFrame) -> dict[str, list[Any]]:
    """Columns with positions in whole hundredths of a decade, a fifth of the size of a mark, each less the one before."""
    by_name = {name: column.tolist() for name, column in points.items()}
    for name in ("time", "calls", "error"):
        by_name[name] = differences([None if math.isnan(value) else round(100 * value) for value in by_name[name]])
    return by_name


def _map(run: Run) -> dict[str, Any]:
    """The digits that each integrator reaches on every problem, and None without an ok setting: for the download."""
    series = list(run.look["series"])
    table = run.matrix.drop_duplicates(["problem", "integrator_id"]).pivot(
        index="problem", columns="integrator_id", values="best"
    )
    table = table.reindex(columns=series)
    rows = []
    for problem in run.problems.to_dict("records"):
        label = (problem["variant"] or "default") + (f" ({problem['formulation']})" if problem["formulation"] else "")
        best = table.loc[problem["problem"]].tolist() if problem["problem"] in table.index else []
        rows.append(
            [problem["case"], label, [None if math.isnan(error) else round(tables.digits(error), 1) for error in best]]
        )
    return {"series": series, "rows": rows}


def write_figures(run: Run, work: dict[str, Problems], charts: Specifications, folder: Path) -> None:
    """Write every chart as SVG and PNG: work-precision of the default variants against time, and all others.

    Figures that only an earlier report has are removed, if its manifest lists them.
    """
    specification = work_precision(run.look, "time")
    wanted = dict(charts)
    for name, problems in work.items():
        for label, problem in problems.items():
            if not label.startswith("default"):
                continue
            subtitle = label.removeprefix("default").removeprefix(" · ")
            title = {"text": run.titles[name], "subtitle": subtitle or "default variant"}
            wanted[slug(name) + (f"_{slug(subtitle)}" if subtitle else "")] = draw(
                specification, problem["points"], problem["limits"]
            ) | {"title": title}
    remove_figures(folder, set(wanted))
    write_images(wanted, folder)
    (folder / MANIFEST).write_text(json.dumps(sorted(wanted), indent=0), encoding="utf-8")


def remove_figures(folder: Path, but: Set[str] = frozenset()) -> None:
    """Remove the figures of an earlier report, which its manifest lists, from a folder, except the names `but`."""
    for name in _read_manifest(folder) - but:
        for suffix in SUFFIXES:
            (folder / (name + suffix)).unlink(missing_ok=True)
    (folder / MANIFEST).unlink(missing_ok=True)


def keep_figures_of_manifest(folder: Path) -> None:
    """Remove all figures but those that the manifest in a folder lists: of earlier reports some have none."""
    known = _read_manifest(folder)
    for path in [*folder.iterdir()] if folder.is_dir() else []:
        if path.suffix in SUFFIXES and path.stem not in known:
            path.unlink()


def slug(text: str) -> str:
    """A file name for any text: its lower-case letters, digits and underscores, with a hash if the text has others."""
    plain = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")
    if plain == text.replace(" ", "_") and 0 < len(plain) <= 60:
        return plain
    return f"{plain[:60] or 'unnamed'}_{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def _read_manifest(folder: Path) -> set[str]:
    """The figures that the manifest in a folder names; empty if it is missing or is not a list of plain names."""
    try:
        names = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return set()
    if not isinstance(names, list):
        return set()
    return {name for name in names if isinstance(name, str) and re.fullmatch(r"[A-Za-z0-9_]+", name)}

"""The report of a run: one self-contained page, a summary for CI, and the figures as files."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import Any

import altair as alt
import numpy as np
import pandas as pd
import vl_convert
from gnomon.cases.case import Case
from gnomon.harness import analysis, figures, findings, ladders, store, style, tables
from gnomon.harness.drift import laws, rebuilt
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup, escape

DECIMAL_STEPS = (1e-2, 1e-3, 1e-4)
"""The steps at which engines are compared under their policies."""
FLOOR, CONDITIONING = "floor: half an ulp of the output", "conditioning: half an ulp of the input"


@dataclass(frozen=True)
class Run:
    """A results file, loaded and reduced once."""

    path: Path
    frame: pd.DataFrame
    reduced: pd.DataFrame

    @classmethod
    def read(cls, path: Path) -> Run:
        frame = analysis.tidy(store.load(path))
        if frame.empty:
            raise ValueError(f"{path}: holds no measurement yet; run `gnomon run` first")
        return cls(path, frame, analysis.settings(frame))

    @cached_property
    def look(self) -> pd.DataFrame:
        return style.styles(self.frame)

    @cached_property
    def equal(self) -> pd.DataFrame:
        return analysis.equal_error(self.frame)

    @cached_property
    def matrix(self) -> pd.DataFrame:
        return tables.with_scenes(analysis.status_matrix(self.reduced))

    @cached_property
    def trusted(self) -> pd.DataFrame:
        return tables.with_scenes(analysis.trust(self.reduced))

    @cached_property
    def names(self) -> list[str]:
        return list(dict.fromkeys(self.frame["case"]))

    @cached_property
    def scenes(self) -> list[str]:
        """Every scene that was run, in the order of the plan, a case's variants together."""
        ran = tables.with_scenes(self.frame.drop_duplicates(["case", "variant", "formulation"]))
        return [scene for name in self.names for scene in ran.loc[ran["case"] == name, "scene"]]

    @cached_property
    def cases(self) -> list[Case]:
        """The default cases of the run, rebuilt from their stored numbers; what cannot be imported here is left out."""
        found = []
        for row in self.frame[self.frame["variant"] == ""].drop_duplicates("case").to_dict("records"):
            try:
                found.append(rebuilt(row["case"], "", json.loads(row["numbers"]), float(row["span"])))
            except ValueError:
                continue
        return found

    @cached_property
    def ladders(self) -> pd.DataFrame:
        return ladders.ladders(self.cases, self.equal, self.reduced)


def write_report(database: Path, folder: Path) -> Path:
    """Write index.html, summary.md and figures/ into `folder` and return the page's path.

    `database` is a results file, or a folder that holds one. The tables of certificates.json and benchmarks.json are
    shown where the folder, or that of the results, holds these. Raises ValueError for a file that is no results file,
    or an empty one.
    """
    run = Run.read(store.results_file(database))
    folder.mkdir(parents=True, exist_ok=True)
    work = {name: work_scenes(run, name) for name in run.names}
    charts = other_charts(run)
    context = page_context(run, folder, work, charts)
    templates = Environment(undefined=StrictUndefined, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    templates.filters["breakable"] = _breakable
    page = folder / "index.html"
    page.write_text(templates.from_string(_source("report.html.j2")).render(context), encoding="utf-8")
    plain = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    (folder / "summary.md").write_text(plain.from_string(_source("summary.md.j2")).render(context), encoding="utf-8")
    write_figures(run, work, charts, folder / "figures")
    return page


def work_scenes(run: Run, name: str) -> dict[str, dict[str, Any]]:
    """The work-precision data of each scene of a case: points, limits, and what the scene stresses."""
    found = {}
    for (variant, formulation), part in run.reduced[run.reduced["case"] == name].groupby(
        ["variant", "formulation"], sort=False
    ):
        points = figures.work_points(part, run.look)
        if points.empty:
            continue
        label = (variant or "default") + (f" · {formulation}" if formulation else "")
        limits = {CONDITIONING: float(part["conditioning"].max()), FLOOR: float(part["floor"].max())}
        found[label] = {
            "points": points,
            "limits": {word: value for word, value in limits.items() if value > 0},
            "stresses": str(part["stresses"].iloc[0] or "") if "stresses" in part else "",
        }
    ordered = sorted(found, key=lambda label: not label.startswith("default"))
    return {label: found[label] for label in ordered}


def other_charts(run: Run) -> dict[str, alt.TopLevelMixin]:
    """Every chart but the work-precision diagrams, by name; charts without data are left out."""
    charts: dict[str, alt.TopLevelMixin] = {"status": figures.status_map(run.matrix, run.look, run.scenes)}
    default = run.trusted[(run.trusted["variant"] == "") & (run.trusted["best"] > 0)]
    if len(default):
        charts["trust"] = figures.trust_map(default, run.look, run.scenes)
    asked = run.reduced[(run.reduced["setting_kind"] == "tolerance") & (run.reduced["status"] == "ok")]
    asked = tables.with_scenes(asked[asked["setting"] > asked["conditioning"].fillna(0)])
    if len(asked):
        over = asked.assign(over=asked["error_max"] / asked["setting"])
        charts["tolerance"] = figures.tolerance_strip(over[["integrator_id", "scene", "setting", "over"]], run.look)
    rungs = run.ladders
    if len(rungs):
        charts["ladder"] = figures.ladder_chart(rungs[rungs["error"] > 0])
    policies = policy_points(run)
    if len(policies):
        charts["policies"] = figures.policy_chart(policies)
    return charts


def policy_points(run: Run) -> pd.DataFrame:
    """Engines under each policy at the decimal steps, where two policies gave an answer (diverged is one)."""
    found = tables.with_scenes(analysis.policies(run.reduced).assign(formulation=""))
    near = np.zeros(len(found), dtype=bool)
    for step in DECIMAL_STEPS:
        near |= np.isclose(found["setting"].to_numpy(float), step, rtol=1e-9)
    answered = found[near & (found["error"].notna() | (found["status"] == "diverged"))]
    several = answered.groupby(["scene", "library", "setting"])["policy"].transform("nunique") > 1
    return answered[several].rename(columns={"library": "engine", "setting": "step"})


def page_context(
    run: Run, folder: Path, work: dict[str, dict[str, Any]], charts: dict[str, alt.TopLevelMixin]
) -> dict[str, Any]:
    """Everything that the page and the summary say."""
    chosen = run.frame["variant"] == ""
    grown = laws(run.path, run.frame, chosen)
    orders = analysis.orders(run.reduced)
    titles = dict(run.frame.drop_duplicates("case")[["case", "title"]].to_numpy())
    sections = dict(run.frame.drop_duplicates("case")[["case", "section"]].to_numpy())
    ran = run.reduced[~run.reduced["status"].isin(analysis.NEVER_RAN)]
    own = ran[ran["variant"] == ""].drop_duplicates(["case", "formulation"])
    scenes = [(name, formulation) for name in run.names for formulation in own.loc[own["case"] == name, "formulation"]]
    case_list = [
        {
            "name": name,
            "title": titles[name],
            "section": sections[name],
            "scenes": [{"label": label, "stresses": scene["stresses"]} for label, scene in work[name].items()],
            "times": tables.equal_error_rows(run.equal, run.reduced, name),
            "stability": tables.stability_rows(run.matrix, run.trusted, orders, grown, name),
        }
        for name in run.names
    ]
    history = store.runs(run.path)
    return {
        "results": run.path.name,
        "history": history[-1],
        "environment": history[-1]["environment"],
        "findings": findings.findings(run.equal, policy_points(run)),
        "targets": [tables.error_text(target).replace("1.0e", "1e") for target in analysis.TARGETS],
        "cases": case_list,
        "counts": {
            "cases": len(run.names),
            "scenes": len(run.scenes),
            "integrators": run.frame["integrator_id"].nunique(),
            "libraries": run.frame["library"].nunique(),
            "trials": len(ran),
            "measurements": len(run.frame),
        },
        "shares": tables.status_shares(run.reduced),
        "fastest": tables.fastest(run.equal, scenes),
        "libraries": tables.libraries(run.equal),
        "failures": tables.failure_groups(analysis.failures(run.reduced)),
        "ladders": ladder_rows(run.ladders),
        "engine_settings": engine_settings(run.frame),
        "meanings": tables.MEANINGS,
        "letters": {name: letter for name, letter in style.LETTERS.items() if letter.strip()},
        "colours": style.STATUS_COLOURS,
        "chart_names": list(charts),
        "certificates": _extra("certificates.json", folder, run.path.parent),
        "benchmarks": _benchmarks(_extra("benchmarks.json", folder, run.path.parent)),
        "css": _source("report.css"),
        "script": _source("report.js"),
        "vega": vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;").replace("</script", "<\\/script"),
        "charts": _json(
            {
                "work": _work_data(run, work),
                "others": {n: _packed(c.to_dict(validate=False)) for n, c in charts.items()},
            }
        ),
    }


def ladder_rows(rungs: pd.DataFrame) -> list[dict[str, Any]]:
    """Ladders in words: error without each effect and time with it."""
    rows = []
    for rung in rungs.to_dict("records"):
        cost = f"{rung['ratio']:.2f}" if np.isfinite(rung["ratio"]) else "–"
        rows.append(
            rung
            | {
                "error": tables.short_text(rung["error"]) if rung["error"] else "0",
                "early": tables.short_text(rung["early"]) if rung["early"] else "0",
                "cost": cost,
                "seconds": tables.time_text(rung["seconds"]),
            }
        )
    return rows


def engine_settings(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Engine settings changed, gathered by engine and setting: values and the policies that set them."""
    changed = analysis.changed_settings(frame)
    grouped = changed.groupby(["library", "setting", "value"], sort=False)
    return [
        {
            "library": library,
            "setting": setting,
            "value": value,
            "integrators": list(dict.fromkeys(part["integrator_id"])),
            "cases": list(dict.fromkeys(case for cases in part["case"] for case in cases)),
        }
        for (library, setting, value), part in grouped
    ]


def write_figures(
    run: Run, work: dict[str, dict[str, Any]], charts: dict[str, alt.TopLevelMixin], folder: Path
) -> None:
    """Every chart as SVG and PNG: work-precision of the default scenes against time, and all others."""
    titles = dict(run.frame.drop_duplicates("case")[["case", "title"]].to_numpy())
    for name, scenes in work.items():
        for label, scene in scenes.items():
            if not label.startswith("default"):
                continue
            look = style.present(run.look, scene["points"]["series"])
            chart = figures.work_precision(scene["points"], look, scene["limits"], "time")
            subtitle = label.removeprefix("default").removeprefix(" · ") or "default numbers"
            file = name + ("" if label == "default" else "_" + label.removeprefix("default · ").replace(" ", "_"))
            style.write_images(chart.properties(title={"text": titles[name], "subtitle": subtitle}), folder, file)
    for name, chart in charts.items():
        style.write_images(chart, folder, name)


def _work_data(run: Run, work: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Two specifications with all integrators, which the page cuts down to those of a scene, and the scenes' data."""
    specs = {
        axis: _packed(figures.work_precision(pd.DataFrame(), run.look, {}, axis).to_dict(validate=False))
        for axis in ("time", "calls")
    }
    cases = {
        name: {
            label: {
                "points": _columns(style.records(scene["points"])),
                "limits": [
                    {"limit": word, "at": round(float(np.log10(at)), 3)} for word, at in scene["limits"].items()
                ],
            }
            for label, scene in scenes.items()
        }
        for name, scenes in work.items()
    }
    return {"specs": specs, "cases": cases}


def _packed(spec: dict[str, Any]) -> dict[str, Any]:
    """The specification with its data as columns."""
    return spec | {"datasets": {name: _columns(rows) for name, rows in spec["datasets"].items()}}


def _columns(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Rows as columns in few characters: words as their numbers in a list, floats to five figures."""
    columns: dict[str, Any] = {}
    for name in rows[0] if rows else ():
        values = [row[name] for row in rows]
        if any(isinstance(value, str) for value in values):
            codes, words = pd.factorize(pd.Series(values, dtype=object))
            columns[name] = {"words": list(words), "codes": codes.tolist()}
        else:
            columns[name] = [float(f"{value:.5g}") if isinstance(value, float) else value for value in values]
    return columns


def _json(value: Any) -> str:
    """JSON that may stand inside a script element."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False).replace("</", "<\\/")


def _breakable(name: str) -> Markup:
    """A name that may break after its separators on a narrow page."""
    text = str(escape(name))
    for separator in (":", "_", "/"):
        text = text.replace(separator, separator + "<wbr>")
    return Markup(text)


def _extra(name: str, *folders: Path) -> Any:
    """The content of a JSON file beside the report or the results, None where there is none."""
    for folder in folders:
        if (folder / name).is_file():
            return json.loads((folder / name).read_text(encoding="utf-8"))
    return None


def _benchmarks(found: Any) -> list[dict[str, Any]]:
    """Rows of a pytest-benchmark file: name, group, median and range."""
    if not found:
        return []
    return [
        {
            "name": item["name"],
            "group": item.get("group") or "",
            "median": tables.time_text(item["stats"]["median"]),
            "low": tables.time_text(item["stats"]["min"]),
            "high": tables.time_text(item["stats"]["max"]),
            "rounds": item["stats"]["rounds"],
        }
        for item in found["benchmarks"]
    ]


def _source(name: str) -> str:
    return (files("gnomon.harness") / name).read_text(encoding="utf-8")

"""The league of physics engines: what the run of the suite `engines` says of each, with pre-flights and costs of a step.

`gnomon run --suite engines --out runs/engines.sqlite`, then
`python -m gnomon.harness.studies.league runs/engines.sqlite --out reports/local/engines.json`.
"""

import argparse
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import Any

import pandas as pd
from gnomon.cases.core.case import Case
from gnomon.cases.core.registry import get, names
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.engine_lines import setting_lines
from gnomon.harness.adapters.engines.scene_run import TIGHTER, SceneIntegrator
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Integrator, Refused, Steps
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.contract.status import SCORED
from gnomon.harness.registry import environment, lookup
from gnomon.harness.results import analysis, store, study_file
from gnomon.harness.results.advice import engine_facts
from gnomon.harness.studies import engine_costs, preflight
from gnomon.harness.studies.error_parts import BINARY32, floor_of, parts
from gnomon.harness.system.supervisor import calls

SCENES: tuple[str, ...] = tuple(read_declared("running", "suites.toml")["engines"]["cases"])
"""The scenes of the suite, in its order."""
ON = tuple(dict.fromkeys(name for name in SCENES if get(*name.split("/")).hybrid is None))
"""The cases of the pre-flight of accelerations."""
SHIPPED, CONFIGURED = engine_facts.SHIPPED, SceneIntegrator.policy
TIGHT = TIGHTER
"""The policy of an engine whose solver has more iterations and a smaller tolerance, for the part of the solver."""


def league(path: Path) -> dict[str, Any]:
    """The contents of engines.json, from a results file."""
    reduced = analysis.settings(analysis.tidy(store.load(path)))
    engines = lookup.own().values()
    shown = [engine for engine in choose_shown(engines) if lookup.missing(engine) is None]
    ran = reduced[reduced["integrator_id"].isin({engine.id for engine in shown})]
    place = {name: k for k, name in enumerate(SCENES)}
    ran = ran.assign(place=[place.get(scene_name(row), len(place)) for row in ran.to_dict("records")])
    return {
        "environment": environment.record() | {"run": str(store.runs(path)[-1]["started"])[:10]},
        "engines": [engine_row(engine, reduced) for engine in shown],
        "lines": dict(write_lines(dict.fromkeys(engine.library for engine in shown))),
        "absent": {
            engine.library: reason for engine in choose_shown(engines) if (reason := lookup.missing(engine)) is not None
        },
        "scenes": [scene_row(part) for _, part in ran.groupby(["place", "case", "variant"], sort=True)],
        "rows": [*result_rows(ran, reduced, {engine.id: engine for engine in shown})],
        "table": {engine.id: explain_declined(engine) for engine in shown if engine.policy != SHIPPED},
        "preflights": [*measure_study(preflights_of, shown, os.cpu_count() or 1)],
        "costs": [*costs([engine for engine in shown if engine.policy != SHIPPED])],
    }


def choose_shown(integrators: Iterable[Integrator]) -> list[SceneIntegrator]:
    """The ways to drive engines that have rows of their own: all are compared at equal fixed steps."""
    engines = [engine for engine in integrators if isinstance(engine, SceneIntegrator) and engine.policy != TIGHT]
    return [engine for engine in engines if isinstance(engine.sweep, Steps)]


def engine_row(engine: SceneIntegrator, reduced: pd.DataFrame) -> dict[str, Any]:
    """The declaration of an engine, driven in one way, and the options that it changes from the engine's defaults."""
    try:
        versions = dict(engine.versions())
    except PackageNotFoundError:
        versions = {}
    own = reduced[reduced["integrator_id"] == engine.id]
    return {
        "id": engine.id,
        "library": engine.library,
        "title": LIBRARIES[engine.library].title,
        "policy": engine.policy,
        "order": engine.order,
        "bits": engine.bits,
        "versions": versions,
        "changed": list_options(own["settings_changed"]),
        "lacks": dict(engine.lacks),
    }


def list_options(texts: Iterable[str]) -> dict[str, str]:
    """Each option that a trial recorded, with its value; of several values their number, as they follow scene and step."""
    values: dict[str, dict[str, None]] = {}
    for text in dict.fromkeys(texts):
        for name, value in json.loads(text or "{}").items():
            values.setdefault(name, {})[str(value)] = None
    return {name: next(iter(seen)) if len(seen) == 1 else f"{len(seen)} values" for name, seen in values.items()}


def lines_of(library: str) -> list[str]:
    """The lines of code that set an engine, from what its adapter records on the scenes of the suite."""
    kinds: dict[str, tuple[str, Case]] = {}
    for name in SCENES:
        case = get(*name.split("/"))
        if case.scene is not None:
            kinds[name] = engine_facts.kind_of(case.scene.needs), case
    return setting_lines(lookup.own(), library, kinds)


def write_lines(libraries: Iterable[str]) -> Iterator[tuple[str, list[str]]]:
    """The lines of each engine, each in a process of its own; none for one that crashes."""
    for library, lines in calls(lines_of, libraries, 1, "spawn"):
        yield library, [] if isinstance(lines, BaseException) else lines


def scene_row(part: pd.DataFrame) -> dict[str, Any]:
    """A scene with its precision floors: the effects of half an ulp of binary64 and of binary32 in start, parameters and time."""
    row = part.iloc[0]
    floor = float(max(part["conditioning"].max(), part["floor"].max()))
    return {
        "scene": scene_name(row),
        "title": row["title"],
        "span": float(row["span"]),
        "time_scale": float(row["time_scale"]),
        "binary64": floor,
        "binary32": floor_of(BINARY32, floor),
    }


def scene_name(row: Mapping[str, Any]) -> str:
    return f"{row['case']}/{row['variant']}" if row["variant"] else str(row["case"])


def result_rows(
    ran: pd.DataFrame, reduced: pd.DataFrame, engines: Mapping[str, SceneIntegrator]
) -> Iterator[dict[str, Any]]:
    """A row for each scene and each way to drive an engine: its points (step, error, seconds a step) and its four parts."""
    tight = reduced[reduced["policy"] == TIGHT]
    for (case, variant, name), part in ran.groupby(["case", "variant", "integrator_id"], sort=False):
        engine = engines[str(name)]
        row = {"scene": scene_name(part.iloc[0]), "integrator": name, "policy": engine.policy}
        scored = part[part["status"].isin(SCORED) & part["setting"].notna()]
        if scored.empty:
            yield row | {"status": part["status"].iloc[0], "reason": part["reason"].iloc[0], "points": []}
            continue
        beside = tight[(tight["case"] == case) & (tight["variant"] == variant) & (tight["library"] == engine.library)]
        beside = beside[(beside["integrator"] == engine.name) & (engine.policy == CONFIGURED)]
        errors = [float(e) for e in scored["error_max"].fillna(math.inf)]
        steps = [float(h) for h in scored["setting"]]
        floor = floor_of(engine.bits, float(max(part["conditioning"].max(), part["floor"].max())))
        pairs = zip(beside["setting"].tolist(), beside["error_max"].tolist(), strict=True)
        tighter = {float(h): float(e) for h, e in pairs if math.isfinite(e)}
        each = scored["seconds"] / scored["steps"]
        yield row | {
            "status": "ran",
            "reason": "",
            "points": [
                [h, e if math.isfinite(e) else None, s if math.isfinite(s) else None]
                for h, e, s in zip(steps, errors, each.tolist(), strict=True)
            ],
            **parts(steps, errors, float(part["time_scale"].iloc[0]), floor, tighter).row(),
        }


def explain_declined(engine: SceneIntegrator) -> dict[str, str]:
    """For every case with a scene the reason why the engine does not take it; empty if it does."""
    reasons = {}
    for name in names():
        case = get(name)
        if case.scene is not None:
            reasons[name] = engine.unsupported(case.scene) or _explain_scene(engine, name)
    return reasons


def _explain_scene(engine: SceneIntegrator, name: str) -> str:
    """The reason that depends on the numbers of a scene, such as a motion that is not planar; empty without one."""
    problem = problem_of(get(name).rounded(), engine.accepts)
    if not isinstance(problem.form, SceneForm):
        return "no scene"
    try:
        engine.prepare(problem, problem.interval).close()
    except Refused as error:
        return str(error)
    return ""


def measure_study(study: Any, engines: Sequence[SceneIntegrator], workers: int) -> Iterator[dict[str, Any]]:
    """The rows of a study of each engine, in child processes; a crash is a row too."""
    results = dict(calls(study, [engine.id for engine in engines], workers, "spawn"))
    for engine in engines:
        result = results[engine.id]
        if isinstance(result, BaseException):
            yield {"integrator": engine.id, "reason": f"{type(result).__name__}: {result}"}
        else:
            yield from result if isinstance(result, list) else [result]


def costs(engines: Sequence[SceneIntegrator]) -> Iterator[dict[str, Any]]:
    """Rows of costs, one engine at a time, as these are times. A way as shipped steps as the same engine does configured."""
    threads = dict(calls(threads_of, [engine.id for engine in engines], 1, "spawn"))
    for engine in engines:  # each in a new process, since memory that another engine has freed would be taken again
        for row in measure_study(costs_of, [engine], 1):
            if "same_bits" in row:
                row["same_bits"]["in two threads"] = threads[row["integrator"]] is True
            yield row


def threads_of(name: str) -> bool:
    engine = lookup.own()[name]
    assert isinstance(engine, SceneIntegrator)
    return engine_costs.is_same_in_threads(engine)


def preflights_of(name: str) -> list[dict[str, Any]]:
    """A row for each pre-flight on a scene that the engine accepts; `text` has the measured value, its bound and its meaning."""
    rows = preflight.preflights(lookup.own()[name], on=[get(*case.split("/")) for case in ON])
    return [
        {
            "integrator": name,
            "name": row.name,
            "scene": row.scene,
            "verdict": row.verdict,
            "measured": row.measured if math.isfinite(row.measured) else None,
            "bound": row.bound if math.isfinite(row.bound) else None,
            "text": row.note,
        }
        for row in rows
        if row.verdict != preflight.UNSUPPORTED
    ]


def costs_of(name: str) -> dict[str, Any]:
    engine = lookup.own()[name]
    assert isinstance(engine, SceneIntegrator)
    return engine_costs.costs(engine)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    study_file.write(league(arguments.results), arguments.out)


if __name__ == "__main__":
    main()

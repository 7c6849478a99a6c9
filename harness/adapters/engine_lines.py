"""The lines of code that set an engine as its adapter does, from the options that the adapter records on scenes."""

import math
from collections.abc import Mapping
from typing import Any

from gnomon.cases.core.case import Case
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator
from gnomon.harness.contract.integrator import Integrator, Refused
from gnomon.harness.contract.problem import problem_of

DT = 1e-3
"""A step, and half of it, tell how values depend on the step."""
Scenes = Mapping[str, tuple[str, Case]]
"""Cases by name, each with the kind of its scene."""


def setting_lines(integrators: Mapping[str, Integrator], library: str, scenes: Scenes) -> list[str]:
    """The lines that set an engine as its configured policy does on these scenes, below the scenes that need them.

    Without the library the values are unknown, and `...` stands for them.
    """
    own = [x for x in integrators.values() if isinstance(x, SceneIntegrator) and x.library == library]
    ways = {engine.name: engine for engine in own if engine.policy == "configured"}
    ran, places = set(), dict[str, set[tuple[str, str]]]()
    for way, engine in ways.items():
        for scene, (_, case) in scenes.items():
            try:
                options = on_scene(engine, case)
            except ImportError:
                return [line.format("...", upper="...") for line in engine.lines.values()]
            if options is None:
                continue
            ran.add((way, scene))
            for option, value in options.items():
                places.setdefault(line_of(engine, option, value), set()).add((way, scene))
    groups = dict[str, list[str]]()
    for line, where in sorted(places.items(), key=lambda item: -len(item[1])):
        groups.setdefault(_title(where, ran, scenes), []).append(line)
    return [line for title, lines in groups.items() for line in (f"# {title}", *lines)]


def on_scene(engine: SceneIntegrator, case: Case) -> dict[str, str] | None:
    """The options that are recorded on a scene, with their values as code; None if the engine does not take the scene."""
    if case.scene is None or engine.unsupported(case.scene) is not None:
        return None
    try:
        whole, half = record_options(engine, case, DT), record_options(engine, case, DT / 2)
    except Refused:
        return None
    return {option: code(value, half[option], DT) for option, value in whole.items()}


def record_options(engine: SceneIntegrator, case: Case, dt: float) -> dict[str, Any]:
    """The options that are recorded once the scene is built."""
    problem = problem_of(case.rounded(), engine.accepts).since_start()
    assert isinstance(problem.form, SceneForm)
    world = engine.world(problem.form, dt)
    try:
        world.build(problem.form.build((0.0,) * problem.dimension, tuple(map(float, problem.parameters))))
        return dict(world.options)
    finally:
        world.close()


def code(whole: Any, half: Any, dt: float) -> str:
    """A value as code, from its values at the steps dt and dt/2: a constant or a multiple of a power of dt."""
    if isinstance(whole, tuple):
        return ", ".join(code(a, b, dt) for a, b in zip(whole, half, strict=True))
    if whole == half:
        return str(whole)
    for power, written in ((1, "{:.6g} * dt"), (-1, "{:.6g} / dt"), (-2, "{:.6g} / dt**2")):
        if math.isclose(whole, half * 2.0**power, rel_tol=1e-9):
            return written.format(whole / dt**power)
    return "..."


def line_of(engine: SceneIntegrator, option: str, value: str) -> str:
    """The line for an option; what follows its name in brackets is said in a comment."""
    name, bracket, detail = option.partition(" (")
    line = engine.lines.get(name, f"# {name}: {{}}").format(value, upper=value.upper())
    return f"{line}{bracket}{detail}" if "#" in line or not bracket else f"{line}  #{bracket}{detail}"


def _title(where: set[tuple[str, str]], ran: set[tuple[str, str]], scenes: Scenes) -> str:
    """The methods and kinds of scenes that have a line; scenes by name if it is not all of a kind, "always" if it is all."""
    ways, own = {way for way, _ in where}, {scene for _, scene in where}
    known = {scene for way, scene in ran if way in ways}
    parts = [] if ways == {way for way, _ in ran} else [", ".join(sorted(ways))]
    kinds = dict.fromkeys(kind for name, (kind, _) in scenes.items() if name in own)
    if own != known:
        texts = []
        for kind in kinds:
            all_of, some = ({n for n in names if scenes[n][0] == kind} for names in (known, own))
            texts.append(kind if all_of == some else f"{kind} ({', '.join(n for n in scenes if n in some)})")
        parts.append("; ".join(texts))
    return ": ".join(parts) or "always"

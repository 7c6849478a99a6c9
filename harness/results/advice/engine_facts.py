"""The published results of a physics engine by kind of scene: order, constant, steps, effects that it cannot model.

The file is a part of the league (`reduce_to_installed`); the assembly of a publication writes it.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from statistics import median
from typing import Any

from gnomon.cases.core.numbers import nearest

FILE = "engines.json"
KINDS = {
    "impact": frozenset({"rigid_impact"}),
    "friction and rolling": frozenset({"coulomb_isotropic"}),
    "joints and ropes": frozenset(
        {"hinge", "slider", "ball_joint", "rod", "rope", "linked_joint", "chained_hinges", "pulley"}
    ),
    "rotating free bodies": frozenset({"gyroscopic"}),
}
"""Kinds of scenes by the tokens that make them so, the first that fits; all others are free points under forces."""
POINTS = "free points under forces"
TARGETS = ("0.01", "0.001", "0.0001")
SHIPPED = "as shipped"


@dataclass(frozen=True)
class Kind:
    """The results of one way to drive an engine on the scenes of a kind: medians over `ordered` of `scenes` scenes.

    `steps`: by error, the largest step over the time scale that is enough on all scenes that reach it, and their number.
    """

    name: str
    scenes: int
    ordered: int
    order: float
    constant: float
    steps: Mapping[str, tuple[float, int]]
    binary32: Mapping[str, int]


def read() -> dict[str, Any]:
    """The published league. Before the first publication, raises FileNotFoundError with the way out."""
    path = files("gnomon.harness.results.advice") / FILE
    if not path.is_file():
        raise FileNotFoundError(
            "no league of engines is published with this version; measure it: gnomon run --suite engines, then"
            " python -m gnomon.harness.studies.league RUN --out engines.json, and name it: gnomon engine NAME --from engines.json"
        )
    league: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return league


def python_text(row: Mapping[str, Any]) -> str:
    """The share of Python in a step with a force, from a row of the costs; empty where it was not measured."""
    share = row.get("python_share")
    if share is None:
        return ""
    return f"Python {100 * share:.0f}\N{NO-BREAK SPACE}% of a step with a force" if share else "forces compiled"


@cache
def python_texts() -> dict[str, str]:
    """`python_text` of each way to drive an engine in the published league."""
    try:
        return {row["integrator"]: python_text(row) for row in read()["costs"]}
    except FileNotFoundError:
        return {}


def reduce_to_installed(league: Mapping[str, Any]) -> dict[str, Any]:
    """The league as it is installed: without the points of figures, the table of all scenes, and pre-flights that passed."""
    rows = [{key: value for key, value in row.items() if key != "points"} for row in league["rows"]]
    failed = [row for row in league["preflights"] if row.get("verdict", "failed") == "failed"]
    return {**league, "rows": rows, "table": {}, "preflights": failed}


def library_of(league: Mapping[str, Any], name: str) -> str:
    """The library of an engine by its name or title. Raises ValueError, which names the nearest, for another name."""
    known = {key: way["library"] for way in league["engines"] for key in (way["library"], way["title"].lower())}
    if name.lower() not in known:
        raise ValueError(f"no engine of the league is called {name!r}; {nearest(name, known)}")
    return str(known[name.lower()])


def failure_text(row: Mapping[str, Any]) -> str:
    """The measured result of a pre-flight that failed, or the reason if the engine crashed, in words."""
    text = row.get("text") or row.get("reason") or ""
    if row.get("measured") is None or row.get("bound") is None:
        return str(text)
    return f"{row['scene']}: {row['measured']:.2g}, at most {row['bound']:.2g} passes ({text})"


def ways(league: Mapping[str, Any], library: str) -> list[dict[str, Any]]:
    return [way for way in league["engines"] if way["library"] == library]


def kinds(league: Mapping[str, Any], way: str, needs: Mapping[str, frozenset[str]]) -> Iterator[Kind]:
    """The kinds of scenes that a way to drive an engine ran. `needs`: the tokens of the scene of each case."""
    scenes = {scene["scene"]: scene for scene in league["scenes"]}
    rows = [row for row in league["rows"] if row["integrator"] == way and row["status"] == "ran"]
    for name in (POINTS, *reversed(KINDS)):
        own = [row for row in rows if kind_of(needs[row["scene"].partition("/")[0]]) == name]
        if own:
            yield _kind(name, own, scenes)


def kind_of(tokens: frozenset[str]) -> str:
    return next((name for name, makes in KINDS.items() if tokens & makes), POINTS)


def _kind(name: str, rows: Sequence[Mapping[str, Any]], scenes: Mapping[str, Mapping[str, Any]]) -> Kind:
    ordered = [row for row in rows if row["order"] is not None]
    return Kind(
        name,
        len(rows),
        len(ordered),
        median(row["order"] for row in ordered) if ordered else math.nan,
        median(row["constant"] for row in ordered) if ordered else math.nan,
        {target: _step(rows, scenes, target) for target in TARGETS},
        {target: sum(scenes[row["scene"]]["binary32"] < float(target) for row in rows) for target in TARGETS},
    )


def _step(rows: Sequence[Mapping[str, Any]], scenes: Mapping[str, Mapping[str, Any]], target: str) -> tuple[float, int]:
    steps = [
        row["steps"][target] / scenes[row["scene"]]["time_scale"] for row in rows if row["steps"][target] is not None
    ]
    return (min(steps), len(steps)) if steps else (math.nan, 0)

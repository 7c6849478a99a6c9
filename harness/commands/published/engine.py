"""`gnomon engine`: how to set a physics engine, what it cannot model, its order and its steps, from the published league."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import out

if TYPE_CHECKING:
    from gnomon.harness.results.advice.engine_facts import Kind

WIDTH = 100
"""The most columns of the answer."""


def engine(
    name: Annotated[str | None, typer.Argument(help="An engine, as mujoco; without one they are listed.")] = None,
    league: Annotated[
        Path | None, options.path_option("A league of your own, in place of the published one.", "--from")
    ] = None,
) -> None:
    """Say how to set a physics engine so that it models a scene and nothing else, and what it reaches then.

    Order and constant by kind of scene, the largest step for an error of 1e-2, 1e-3 and 1e-4, the drift of energy in an hour,
    and whether single precision is enough: all of it measured on exact motions.
    """
    # Imported here and not above: `gnomon --help` starts without the modules that read the league.
    from gnomon.harness.results.advice import engine_facts

    facts = engine_facts.read() if league is None else _read_given(league)
    if name is None:
        for row in {row["library"]: row for row in facts["engines"]}.values():
            own = engine_facts.ways(facts, row["library"])
            out.print(f"{row['library']:10} {row['title']}, driven in {len(own)} ways", highlight=False, markup=False)
        out.print("Next: gnomon engine mujoco", highlight=False)
        return
    library = engine_facts.library_of(facts, name)
    width = min(WIDTH, options.columns(WIDTH))
    for text in describe(facts, library, width):
        for line in _wrap(text, width):
            out.print(line, highlight=False, markup=False)


def _wrap(text: str, width: int) -> list[str]:
    """Wrap a text: the lines that continue a long line have its indent and either `# `, for a comment, or 4 spaces more."""
    if len(text) <= width:
        return text.split("\n")
    indent = text[: len(text) - len(text.lstrip(" "))]
    further = indent + ("# " if text.startswith(f"{indent}# ") else "    ")
    how: dict[str, Any] = {"subsequent_indent": further, "break_on_hyphens": False, "break_long_words": False}
    return [piece for line in text.split("\n") for piece in textwrap.wrap(line, width, **how) or [""]]


def _code(line: str, width: int) -> Iterator[str]:
    """Code for a program in lines of this width, where brackets allow a break; a comment without a place comes first."""
    statements, mark, comment = line.partition("  # ")
    if len(line) <= width or line.startswith("#"):
        yield line
        return
    if mark:
        yield f"# {comment}"
    for statement in statements.split("; "):
        pieces = textwrap.wrap(
            statement, width, subsequent_indent="    ", break_on_hyphens=False, break_long_words=False
        )
        within = all(_depth(" ".join(pieces[:n])) for n in range(1, len(pieces)))
        yield from pieces if within else [statement]


def _depth(code: str) -> int:
    """The number of brackets that are open at the end."""
    return sum((letter in "([{") - (letter in ")]}") for letter in code)


def _read_given(path: Path) -> dict[str, Any]:
    from gnomon.harness.reporting import sidecars

    if path.name != "engines.json":
        raise ValueError(f"--from {path}: the file of a league is called engines.json")
    facts: dict[str, Any] = sidecars.read(path)
    return facts


def describe(facts: Mapping[str, Any], library: str, width: int) -> Iterator[str]:
    """The text on an engine."""
    from gnomon.harness.results.advice import engine_facts

    from gnomon import cases

    ways = engine_facts.ways(facts, library)
    needs = {name: case.scene.needs for name in cases.names() if (case := cases.get(name)).scene is not None}
    versions = ", ".join(f"{key} {value}" for key, value in ways[0]["versions"].items())
    yield f"{ways[0]['title']} ({versions})"
    lines = facts["lines"].get(library)
    if lines:
        yield "\nTo model a scene and nothing else, set:"
        yield from (f"    {piece}" for line in lines for piece in _code(line, width - 4))
    for way in ways:
        if way["policy"] != engine_facts.SHIPPED:
            yield from _way(facts, way, [*engine_facts.kinds(facts, way["id"], needs)])
    in_all = {token: why for token, why in ways[0]["lacks"].items() if all(token in way["lacks"] for way in ways)}
    yield from _lacks(in_all, needs)
    yield from _describe_failed(facts, ways)
    made_by = facts["environment"]
    yield (
        f"\nMeasured by gnomon's authors at revision {made_by.get('revision', 'unknown')} on {made_by.get('run', '')}: errors relative to"
        " the size of the motion, largest at 64 times; steps relative to the time in which the motion changes by its own size."
    )


def _way(facts: Mapping[str, Any], way: Mapping[str, Any], kinds: list[Kind]) -> Iterator[str]:
    declared = "" if way["order"] is None else f", order {way['order']} declared"
    yield f"\n{way['id']}{declared}"
    for kind in kinds:
        law = (
            f"error {kind.constant:.2g} (step / time scale)^{kind.order:.2f} on {kind.ordered} of {kind.scenes}"
            if kind.ordered
            else f"no steady order on {kind.scenes}"
        )
        yield f"    {kind.name}: {law} scene{'s' if kind.scenes > 1 else ''}"
        steps = [f"{float(at):.0e}: {step:.2g} ({of})" for at, (step, of) in kind.steps.items() if of]
        if steps:
            yield f"        step / time scale that is enough for an error of {', '.join(steps)}; in brackets the scenes that reach it"
        enough = [f"{float(at):.0e} on {of}" for at, of in kind.binary32.items()]
        yield f"        single precision can reach {', '.join(enough)} of {kind.scenes}"
    drift = next((row.get("energy_an_hour") for row in facts["costs"] if row["integrator"] == way["id"]), None)
    if drift is not None and math.isfinite(drift):
        yield f"    energy of a pendulum over an hour with steps of 10 ms: off by {drift:.2g} of the depth of its potential"


def _lacks(lacks: Mapping[str, str], needs: Mapping[str, frozenset[str]]) -> Iterator[str]:
    if not lacks:
        return
    yield f"\nIt cannot model (scenes of {len(needs)} that need it):"
    for token, reason in lacks.items():
        yield f"    {token.replace('_', ' ')} ({sum(token in each for each in needs.values())}): {reason}"


def _describe_failed(facts: Mapping[str, Any], ways: list[dict[str, Any]]) -> Iterator[str]:
    from gnomon.harness.results.advice.engine_facts import failure_text

    failed: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for row in facts["preflights"]:
        if row["integrator"] in {way["id"] for way in ways} and row.get("verdict", "failed") == "failed":
            failed.setdefault((row["integrator"], row.get("name", "all")), []).append(row)
    if failed:
        yield "\nPre-flights that failed, each with the worst of its scenes:"
    for (way, name), rows in failed.items():
        worst = max(rows, key=lambda row: (row.get("measured") or math.inf) / (row.get("bound") or 1))
        yield f"    {way}: {name}, {len(rows)} scene{'s' if len(rows) > 1 else ''}: {failure_text(worst)}"

"""What `gnomon show` prints of a case, and the drawing of its motion."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.forms import (
    Charged,
    Constrained,
    FirstOrder,
    Friction,
    Hybrid,
    Impact,
    NBody,
    RigidBody,
    SecondOrder,
    SemiLinear,
    Separable,
)
from gnomon.cases.core.numbers import show as number
from gnomon.harness.commands.source_file import source_file
from gnomon.reference.storage import diskcache
from rich.console import Console
from rich.markup import escape
from rich.syntax import Syntax
from rich.table import Table

DRAWINGS = (".svg", ".png", ".html")
POINTS = 1200
DRAWN_SCALES = 80.0
"""A drawing covers at most this many time scales; more oscillations could not be told apart."""


def describe(case: Case, out: Console) -> None:
    """Print title, conventions, equations, parameters, quantities, variants, forms and formulations."""
    out.print(f"[bold]{escape(case.title)}[/]  {escape(case.id)}   (Beatty, Dynamics, {escape(case.section)})")
    out.print(f"Case: {escape(source_file(type(case)))}", soft_wrap=True)
    out.print(f"Exact motion: {escape(source_file(type(case.motion())))}", soft_wrap=True)
    if case.conventions:
        out.print(escape(case.conventions))
    _equations(case, out)
    _numbers(case, out)
    _quantities(case, out)
    if case.variants:
        table = Table("variant", "what it stresses", title="Variants", title_justify="left")
        for variant in case.variants:
            table.add_row(variant.name, escape(variant.stresses))
        out.print(table)
    forms = [type(form).__name__ for form in case.all_forms()] + (["Scene"] if case.scene is not None else [])
    out.print(f"Forms: {', '.join(forms)}")
    for formulation in case.formulations:
        out.print(f"Formulation: {formulation.name}")
    laws = ", ".join(f"{name} ({invariant.law})" for name, invariant in case.invariants.items())
    if laws:
        out.print(f"Invariants: {laws}")


def draw(case: Case, path: Path) -> None:
    """Draw the exact motion over time, one panel a group of coordinates, to a file with an ending of `DRAWINGS`."""
    import altair  # slow to load: only a drawing needs it
    import pandas

    span = min(float(case.times[-1]), DRAWN_SCALES * case.time_scale)
    times = np.linspace(0.0, span, POINTS)
    states = case.sample(times)
    panels = []
    for group in dict.fromkeys(coordinate.group for coordinate in case.state):
        members = [(i, c) for i, c in enumerate(case.state) if c.group == group]
        columns = [pandas.DataFrame({"t": times, "value": states[:, i], "coordinate": c.name}) for i, c in members]
        panels.append(
            altair.Chart(pandas.concat(columns), width=640, height=180)
            .mark_line(strokeWidth=1.5)
            .encode(
                x=altair.X("t:Q", title="t (s)"),
                y=altair.Y("value:Q", title=f"{group} ({members[0][1].unit})", scale=altair.Scale(zero=False)),
                color=altair.Color("coordinate:N", title=None),
            )
        )
    chart = altair.vconcat(*panels, title=f"{case.title}: {case.id}").resolve_scale(color="independent")
    path.parent.mkdir(parents=True, exist_ok=True)
    with diskcache.whole(path) as part:
        chart.save(str(part), **({"scale_factor": 2} if path.suffix == ".png" else {}))


def _equations(case: Case, out: Console) -> None:
    out.print("\n[bold]Equations of motion[/]")
    for title, function in _functions(case):
        text = inspect.getsource(function).rstrip()
        out.print(f"[italic]{escape(title)}[/]")
        out.print(Syntax(textwrap.dedent(text), "python", background_color="default", word_wrap=True))


def _functions(case: Case) -> Iterator[tuple[str, Callable[..., Any]]]:
    """The functions that state the dynamics of the most structured form."""
    form: Any = case.forms[0]
    if isinstance(form, SecondOrder):
        yield "q'' = acceleration(t, q, parameters)", form.acceleration
        if isinstance(form, Separable):
            yield "potential energy per unit mass", form.potential
    elif isinstance(form, RigidBody):
        yield "principal moments", form.inertia
        yield "torque in the body; Euler's equations and R' = R hat(w) follow", form.torque
    elif isinstance(form, NBody):
        yield "G m of each body; gravitation follows", form.masses
        yield from _others(case, form)
    elif isinstance(form, Hybrid):
        for mode in form.modes:
            yield f"mode {mode.name}: y' = equations(t, y, parameters)", mode.equations
        for transition in form.transitions:
            yield f"{transition.name}: ends {transition.mode} where this crosses zero", transition.guard
            yield f"{transition.name}: the state after", transition.reset
        if isinstance(form, Impact):
            yield "distance from the wall, for time stepping", form.gap
        elif isinstance(form, Friction):
            yield "kinetic and static friction over mass, for time stepping", form.bounds
    elif isinstance(form, FirstOrder):
        yield "y' = equations(t, y, parameters)", form.equations
        if isinstance(form, Charged):
            yield "a and w of u' = a + v x w; for a charge q E/m and q B/m", form.fields
        elif isinstance(form, Constrained):
            yield "force over mass, without that of the constraint", form.force
            yield "constraint, constant on the motion", form.constraint
        elif isinstance(form, SemiLinear):
            yield "y' = L y + rest: L, row by row", form.linear
            yield "the rest", form.rest


def _others(case: Case, form: Any) -> Iterator[tuple[str, Callable[..., Any]]]:
    for other in case.forms:
        if isinstance(other, SecondOrder) and other is not form:
            yield "q'' = acceleration(t, q, parameters)", other.acceleration


def _numbers(case: Case, out: Console) -> None:
    table = Table("name", "value", "unit", "meaning", "domain", title="Parameters and start", title_justify="left")
    for parameter in case.parameter_list:
        domain = str(case.domain.ranges.get(parameter.name, ""))
        text = number(case.parameters[parameter.name])
        table.add_row(parameter.name, text, parameter.unit, escape(parameter.meaning), escape(domain))
    for coordinate, value in zip(case.state, case.initial_state, strict=True):
        domain = str(case.domain.ranges.get(coordinate.name, ""))
        table.add_row(f"{coordinate.name}(0)", number(value), coordinate.unit, coordinate.kind, escape(domain))
    table.add_row("span", number(case.span), "s", "", "")
    out.print(table)
    for rule in case.domain.rules:
        out.print(f"Rule: {escape(rule.statement)}")


def _quantities(case: Case, out: Console) -> None:
    found = case.quantities(15)
    if not found:
        return
    table = Table("quantity", "value", title="Derived quantities, 15 digits", title_justify="left")
    for name, value in found.items():
        table.add_row(name, escape(str(value)))
    out.print(table)

"""Print a case or a check for `gnomon show`."""

import inspect
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction
from typing import Any

from gnomon.cases import Case, Check
from gnomon.cases.core import forms
from gnomon.cases.core.numbers import show as number
from gnomon.harness.kernels.case_equations import formulas
from gnomon.harness.registry.selection import source_file
from rich.console import Console
from rich.markup import escape
from rich.syntax import Syntax
from rich.table import Table

FUNCTIONS = (
    (forms.SecondOrder, "acceleration", "q'' = acceleration(t, q, parameters)"),
    (forms.Separable, "potential", "potential energy per unit mass"),
    (forms.RigidBody, "inertia", "principal moments"),
    (forms.RigidBody, "torque", "torque in the body; Euler's equations and R' = R hat(w) follow"),
    (forms.NBody, "masses", "G m of each body; gravitation follows"),
    (forms.Impact, "gap", "distance from the wall, for time stepping"),
    (forms.Friction, "bounds", "kinetic and static friction over mass, for time stepping"),
    (forms.FirstOrder, "equations", "y' = equations(t, y, parameters)"),
    (forms.Charged, "fields", "a and w of u' = a + v x w; for a charge q E/m and q B/m"),
    (forms.Constrained, "force", "force over mass, without the constraint's"),
    (forms.Constrained, "constraint", "constraint, constant on the motion"),
    (forms.SemiLinear, "linear", "y' = L y + rest: L, row by row"),
    (forms.SemiLinear, "rest", "the rest"),
)
"""The functions that state each form, with their meanings."""


def describe(case: Case, out: Console, source: bool = False) -> None:
    """Print title, conventions, equations, parameters, quantities, variants, forms and formulations.

    `source`: the functions that state the dynamics instead of formulas.
    """
    _head(case, {"Case": type(case), "Exact motion": type(case.motion())}, out)
    lines = None if source else formulas(case)
    if lines is None:
        _code("Equations of motion", _functions(case), out)
    else:
        out.print("\n[bold]Equations of motion[/]")
        for line in lines:
            out.print(f"  {line}", markup=False, highlight=False)
    _numbers(case, out)
    _quantities("Derived quantities, 15 digits", case.quantities(15), out)
    _variants(case, out)
    offered = [type(form).__name__ for form in case.all_forms()] + (["Scene"] if case.scene is not None else [])
    out.print(f"Forms: {', '.join(offered)}")
    for formulation in case.formulations:
        out.print(f"Formulation: {formulation.name}")
    laws = ", ".join(f"{name} ({invariant.law})" for name, invariant in case.invariants.items())
    if laws:
        out.print(f"Invariants: {laws}")


def describe_check(check: Check, out: Console) -> None:
    """Print title, conventions, closed forms, parameters, results and variants."""
    _head(check, {"Check": type(check)}, out)
    _code("Closed forms", [("", type(check).formulas)], out)
    _numbers(check, out)
    _quantities("Results, 15 digits", check.exact(15), out)
    _variants(check, out)


def _head(shown: Case | Check, kinds: Mapping[str, type], out: Console) -> None:
    out.print(f"[bold]{escape(shown.title)}[/]  {escape(shown.id)}   (Beatty, Dynamics, {escape(shown.section)})")
    for word, kind in kinds.items():
        out.print(f"{word}: {escape(source_file(kind))}", soft_wrap=True)
    if shown.conventions:
        out.print(escape(shown.conventions))


def _code(title: str, functions: Iterable[tuple[str, Callable[..., Any]]], out: Console) -> None:
    out.print(f"\n[bold]{title}[/]")
    for words, function in functions:
        if words:
            out.print(f"[italic]{escape(words)}[/]")
        text = textwrap.dedent(inspect.getsource(function).rstrip())
        out.print(Syntax(text, "python", background_color="default", word_wrap=True))


def _functions(case: Case) -> Iterator[tuple[str, Callable[..., Any]]]:
    """The functions that state the dynamics of the most structured form."""
    form = case.forms[0]
    if isinstance(form, forms.Hybrid):
        for mode in form.modes:
            yield f"mode {mode.name}: y' = equations(t, y, parameters)", mode.equations
        for transition in form.transitions:
            yield f"{transition.name}: ends {transition.mode} where this crosses zero", transition.guard
            yield f"{transition.name}: the state after", transition.reset
    for kind, name, words in FUNCTIONS:
        if isinstance(form, kind):
            yield words, getattr(form, name)
    if isinstance(form, forms.NBody):
        for other in case.forms[1:]:
            if isinstance(other, forms.SecondOrder):
                yield FUNCTIONS[0][2], other.acceleration


def _numbers(shown: Case | Check, out: Console) -> None:
    """The table of parameters and, of a case, of initial values and span; the rules of the domain."""

    def row(label: str, value: Any, unit: str, meaning: str, name: str = "") -> None:
        domain = str(shown.domain.ranges.get(name, ""))
        table.add_row(label, number(value), unit, escape(meaning), escape(domain))

    title = "Parameters and start" if isinstance(shown, Case) else "Parameters"
    table = Table("name", "value", "unit", "meaning", "domain", title=title, title_justify="left")
    for each in shown.parameter_list:
        row(each.name, shown.parameters[each.name], each.unit, each.meaning, each.name)
    if isinstance(shown, Case):
        for coordinate, value in zip(shown.state, shown.initial_state, strict=True):
            row(f"{coordinate.name}(0)", value, coordinate.unit, coordinate.kind, coordinate.name)
        row("span", shown.span, "s", "")
        if shown.horizon is not None:
            row("horizon", Fraction(shown.horizon), "s", "where the conditioning reaches 1")
    out.print(table)
    for rule in shown.domain.rules:
        out.print(f"Rule: {escape(rule.statement)}")


def _quantities(title: str, values: Mapping[str, Any], out: Console) -> None:
    _print_pairs(Table("quantity", "value", title=title, title_justify="left"), values.items(), out)


def _variants(shown: Case | Check, out: Console) -> None:
    table = Table("variant", "difficulty", title="Variants", title_justify="left")
    _print_pairs(table, ((variant.name, variant.stresses) for variant in shown.variants), out)


def _print_pairs(table: Table, rows: Iterable[tuple[str, Any]], out: Console) -> None:
    """Print a table of names and values, unless it is empty."""
    for name, value in rows:
        table.add_row(name, escape(str(value)))
    if table.rows:
        out.print(table)

"""Print a case or a check for `gnomon show`; write a drawing."""

import inspect
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from gnomon.cases import Case, Check
from gnomon.cases.core import forms
from gnomon.cases.core.numbers import show as number
from gnomon.harness.kernels.equation_text import EquationText, equation_text, function_text
from gnomon.harness.kernels.formula import plain
from gnomon.harness.kernels.latex import latex
from gnomon.reference.storage import diskcache
from rich.console import Console
from rich.markup import escape
from rich.syntax import Syntax
from rich.table import Table

POINTS = 1200


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


def save(specification: dict[str, Any], path: Path) -> None:
    """Write a drawing, a specification of Vega-Lite with its data, to a file with an ending of `options.DRAWINGS`.

    Altair's own way to a file takes seconds to copy and to validate the data.
    """
    import vl_convert  # slow to load: only a drawing needs it

    if path.suffix == ".html":
        written = vl_convert.vegalite_to_html(specification, bundle=True).encode()
    else:
        svg = vl_convert.vegalite_to_svg(specification)
        written = svg.encode() if path.suffix == ".svg" else vl_convert.svg_to_png(svg, scale=2)
    path.parent.mkdir(parents=True, exist_ok=True)
    diskcache.replace(path, written)


def source_file(kind: type) -> str:
    """The file of a class: below the root of the repository if it is gnomon's own, as `cases/orbits/two_body.py`."""
    package, _, rest = kind.__module__.partition(".")
    if package == "gnomon":
        return f"{rest.replace('.', '/')}.py"
    return getattr(sys.modules[kind.__module__], "__file__", None) or kind.__module__


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


def equations_in_latex(case: Case) -> Iterator[str]:
    """The equations of motion as LaTeX; for a hybrid case, the equations of each mode after a comment with its name."""
    coordinates = [x.name for x in case.state]
    for mode, text in _equations(case):
        yield (f"% mode {mode}\n" if mode else "") + latex(text, coordinates)


def _equations(case: Case) -> Iterator[tuple[str, EquationText]]:
    """The equations of motion, or the equations of each mode of a hybrid case with its name."""
    coordinates, parameters = [x.name for x in case.state], [x.name for x in case.parameter_list]
    if case.hybrid is None:
        traceable = (forms.FirstOrder, forms.SecondOrder, forms.RigidBody)
        form = next(form for form in case.all_forms() if isinstance(form, traceable))
        yield "", equation_text(form, coordinates, parameters)
        return
    for mode in case.hybrid.modes:
        names = [*parameters, *(f"({value!r})" for value in mode.constants)]
        yield mode.name, equation_text(forms.FirstOrder(mode.equations), coordinates, names)


def formulas(case: Case) -> list[str] | None:
    """The equations of motion as formulas, a line each; None if they cannot be traced, as equations that branch."""
    coordinates, parameters = ([x.name for x in each] for each in (case.state, case.parameter_list))
    lines: list[str] = []
    try:
        for mode, text in _equations(case):
            found = plain(text, [f"{name}' =" for name in coordinates])
            lines += [f"{mode}:", *(f"  {line}" for line in found)] if mode else found
        for transition in case.hybrid.transitions if case.hybrid is not None else ():
            lines += _transition(transition, coordinates, parameters)
    except (ValueError, StopIteration):
        return None
    return lines


def _transition(transition: forms.Transition, coordinates: list[str], parameters: list[str]) -> Iterator[str]:
    """The condition under which a mode ends, and the numbers that change then."""
    crosses = "rises" if transition.direction > 0 else "falls"
    guard, *named = plain(function_text(transition.guard, coordinates, parameters), ["as"])
    yield f"{transition.name} ends {transition.mode}, {guard} {crosses} to 0"
    changes = plain(function_text(transition.reset, coordinates, parameters), [f"{name} ->" for name in coordinates])
    kept = {f"{name} -> {name}" for name in coordinates}
    yield from (f"  {line}" for line in (*named, *changes) if line not in kept)


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


def _quantities(title: str, found: Mapping[str, Any], out: Console) -> None:
    _print_pairs(Table("quantity", "value", title=title, title_justify="left"), found.items(), out)


def _variants(shown: Case | Check, out: Console) -> None:
    table = Table("variant", "difficulty", title="Variants", title_justify="left")
    _print_pairs(table, ((variant.name, variant.stresses) for variant in shown.variants), out)


def _print_pairs(table: Table, rows: Iterable[tuple[str, Any]], out: Console) -> None:
    """Print a table of names and values, unless it is empty."""
    for name, value in rows:
        table.add_row(name, escape(str(value)))
    if table.rows:
        out.print(table)

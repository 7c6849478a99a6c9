"""`gnomon list`: cases, checks, integrators and needs."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import Shown, out
from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Column, Table

if TYPE_CHECKING:
    from gnomon.harness.contract.integrator import Integrator

WIDTH = 100
"""Columns of a table where the output is not a terminal."""
LONGEST = 40
"""Letters of an id that has one line."""
PURPOSES = {"symplectic": "symplectic", "volume": "volume", "attitude": "rotations", "constraint": "constraints"}
"""The words for what a method declares in `conserves`; the others follow from the form or go with these."""


class Listed(StrEnum):
    """The things that `gnomon list` can list."""

    cases = "cases"
    checks = "checks"
    integrators = "integrators"
    needs = "needs"


def list_(
    what: Annotated[Listed | None, typer.Argument(help="What to list; by default everything.")] = None,
    pattern: Annotated[
        str,
        typer.Argument(help="A part of a name, as kepler or gauss, or a pattern, as 'scipy:*' or 'kepler_orbit/*'."),
    ] = "*",
    library: options.Libraries = None,
    family: options.Families = None,
    kind: options.Kinds = None,
) -> None:
    """List cases, checks (rows without motion), integrators, and the needs and kinds of systems of `gnomon recommend`."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.registry import selection

    from gnomon import cases

    if pattern != "*" and what is None:
        raise ValueError(f"{pattern!r}: say what to list, cases, checks, integrators or needs, before the pattern")
    narrowed = {Listed.cases: family or kind, Listed.integrators: library or kind}
    shown = [what] if what else [each for each in narrowed if narrowed[each]] or list(Listed)
    if what and (library or family or kind) and not narrowed.get(what):
        raise ValueError(f"{what}: --family narrows cases, --library integrators, --kind both; leave out the others")
    case, integrator = "pendulum_simple", "gnomon:DOP853"
    if Listed.cases in shown:
        case = _list_cases("Cases", cases.names(), pattern, family, kind)
    if Listed.checks in shown:
        check = _list_cases("Checks, without motion", cases.check_names(), pattern)
    if Listed.integrators in shown:
        from gnomon.harness.registry import lookup

        known = lookup.everything()
        named = [known[name] for name in selection.containing(pattern, known)]
        integrators = selection.integrators_of(named, library, kind)
        _wide().print(integrators_table(integrators))
        integrator = integrators[0].id
    if Listed.needs in shown:
        need = _list_needs(pattern)
    if shown == [Listed.needs]:
        following = f"gnomon recommend {need} --error 1e-6 --library scipy"
    elif shown == [Listed.checks]:
        following = f"gnomon show {check}, gnomon certify {check}"
    elif shown == [Listed.integrators]:
        following = f"gnomon run --case pendulum_simple --integrator {shlex.quote(integrator)}"
    else:
        following = f"gnomon show {case}, gnomon list cases '{case.partition('/')[0]}/*', gnomon run --case {case}"
    out.print(f"Next: {following}", highlight=False, markup=False)


def _wide() -> Shown:
    """A console for tables."""
    return Shown(width=options.columns(WIDTH), emoji=False)


def _list_cases(
    title: str, known: Sequence[str], pattern: str, families: list[str] | None = None, kinds: list[str] | None = None
) -> str:
    """Print the cases or checks that a part of a name or a pattern selects; returns the first name.

    With a slash in the pattern these are variants.
    """
    from gnomon.cases.core.registry import entry
    from gnomon.harness.registry import selection

    from gnomon import cases

    base, slash, _ = pattern.partition("/")
    named = selection.containing(base, known)
    if slash:
        every = [f"{name}/{variant}" for name in named for variant in selection.variants_of(name)]
        named = selection.containing(pattern, every)
    if families or kinds:  # imports the cases, whose forms it reads
        pairs = [(cases.get(*name.split("/")), name) for name in named]
        named = [name for _, name in selection.cases_of(pairs, families, kinds)]
    columns = Column("name", no_wrap=True), "difficulty" if slash else "title and variants"
    table = Table(*columns, title=title, box=SIMPLE_HEAD, padding=(0, 1))
    for name in named:
        case, _, variant = name.partition("/")
        if slash:
            table.add_row(name, escape(selection.variants_of(case)[variant]))
        else:
            stated = entry(name)
            variants = f"\nvariants: {', '.join(stated.variants)}" if stated.variants else ""
            table.add_row(name, escape(stated.title) + variants)
    _wide().print(table)
    return named[0]


def _list_needs(pattern: str) -> str:
    """Print the needs and kinds of systems that a part of a name or a pattern selects; returns the first name."""
    from gnomon.harness.registry import selection
    from gnomon.harness.results.advice import recommendations

    known = recommendations.subjects()
    named = selection.containing(pattern, tuple(known))
    columns = Column("name", no_wrap=True), "systems"
    table = Table(*columns, title="Needs and kinds of systems", box=SIMPLE_HEAD, padding=(0, 1))
    for name in named:
        title, about = known[name]
        table.add_row(name, escape(f"{title}: {about}"))
    _wide().print(table)
    return named[0]


def integrators_table(integrators: Iterable[Integrator]) -> Table:
    """A row for each integrator: its order, the forms that it accepts, and what it is for."""
    columns = (
        Column("id", no_wrap=True),
        Column("order", justify="right"),
        *(Column(each, min_width=11) for each in ("accepts", "for")),
    )
    table = Table(*columns, title="Integrators", box=SIMPLE_HEAD, padding=(0, 1))
    for integrator in integrators:
        accepted = ", ".join(kind.__name__ for kind in integrator.accepts)
        order = "" if integrator.order is None else str(integrator.order)
        name = integrator.id if len(integrator.id) <= LONGEST else integrator.id.replace(" [", "\n [", 1)
        table.add_row(escape(name), order, accepted, ", ".join(purposes(integrator)))
    return table


def purposes(integrator: Integrator) -> list[str]:
    """What a method is for, from its declaration: stiff equations, events, and the structure that it conserves."""
    from gnomon.cases.core.forms import Hybrid
    from gnomon.harness.registry.lookup import STIFF

    words = ["stiff"] if integrator.id in STIFF else []
    words += ["events"] if any(issubclass(kind, Hybrid) or kind is Hybrid for kind in integrator.accepts) else []
    return words + [word for name, word in PURPOSES.items() if name in integrator.conserves]

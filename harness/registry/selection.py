"""Selects cases by name, and cases and integrators by the options --library, --family and --kind."""

from collections.abc import Iterator, Sequence
from typing import TypeVar, get_args

from gnomon.cases import Case
from gnomon.cases.core.forms import Form
from gnomon.cases.core.numbers import is_pattern, matching, nearest
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Integrator

from gnomon import cases

Item = TypeVar("Item")
DEFAULT = "default"
"""The name of a case's default variant in results."""


def choose(
    names: Sequence[str] | None, variants: bool, rounded: bool = True, **parameters: str
) -> list[tuple[Case, str]]:
    """The cases with these names, each with a label for changed parameters; numbers are binary64 if `rounded`.

    A name is a case (with all its variants if `variants`), a pattern of case names with * and ?, `case/variant`, or
    `package.module:Case`. Without names all cases are chosen.
    """
    label = "".join(f" {name}={value}" for name, value in parameters.items())
    found = []
    given = [each for name in names or () for each in (matching(name, cases.names()) if is_pattern(name) else [name])]
    for name in dict.fromkeys(given) or cases.names():
        base, slash, variant = name.partition("/")
        listed: list[str | None] = [None]
        if slash:
            listed = [None if variant == DEFAULT else variant]
        elif variants:
            listed += [v.name for v in cases.case_class(base).variants]
        made = [cases.get(base, v, **parameters) for v in listed]
        found += [(case.rounded() if rounded else case, label) for case in made]
    return found


def family(case: type[Case]) -> str:
    """The folder of cases/ that a case is in; its module for a user's own."""
    parts = case.__module__.split(".")
    return parts[2] if parts[:2] == ["gnomon", "cases"] else case.__module__


def cases_of(
    found: Sequence[tuple[Case, str]], families: Sequence[str] | None, kinds: Sequence[str] | None
) -> list[tuple[Case, str]]:
    """The cases, each with its label, of these families that offer one of these forms; all without a restriction.

    Raises ValueError for a word that fits no case.
    """
    left = _kept("--family", families, [(pair, {family(type(pair[0]))}) for pair in found])
    if not kinds:
        return left
    return _kept("--kind", kinds, [(pair, {kind.__name__ for kind in _offered(pair[0])}) for pair in left])


def integrators_of(
    found: Sequence[Integrator], libraries: Sequence[str] | None, kinds: Sequence[str] | None
) -> list[Integrator]:
    """The integrators of these libraries that accept one of these forms. Raises ValueError as `cases_of`."""
    left = _kept("--library", libraries, [(one, {one.library}) for one in found])
    forms: tuple[type, ...] = (*get_args(Form), SceneForm)
    every = [kind for form in forms for kind in _descendants(form)]
    return _kept("--kind", kinds, [(one, {f.__name__ for f in every if issubclass(f, one.accepts)}) for one in left])


def _offered(case: Case) -> Iterator[type]:
    """The types of a case's forms, and their base types: a Separable form is SecondOrder too."""
    for form in case.all_forms() if case.scene is None else (*case.all_forms(), case.scene):
        yield from type(form).__mro__[:-1]


def _descendants(form: type) -> Iterator[type]:
    yield form
    subclasses: list[type] = form.__subclasses__()
    for kind in subclasses:
        yield from _descendants(kind)


def _kept(option: str, wanted: Sequence[str] | None, found: Sequence[tuple[Item, set[str]]]) -> list[Item]:
    if not wanted:
        return [item for item, _ in found]
    valid = {name.lower(): name for _, names in found for name in names}
    for word in wanted:
        if word.lower() not in valid:
            raise ValueError(f"{option} {word}: no integrator that is named has it; {nearest(word, valid.values())}")
    chosen = {valid[word.lower()] for word in wanted}
    return [item for item, names in found if chosen & names]

"""Selects cases by name, and cases and integrators by the options --library, --family and --kind."""

import sys
from collections.abc import Iterable, Iterator, Sequence
from typing import Protocol, TypeVar, get_args

from gnomon.cases import Case
from gnomon.cases.core.forms import Form
from gnomon.cases.core.numbers import is_pattern, matching, nearest
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.validation import short

from gnomon import cases

Item = TypeVar("Item")


class HasCase(Protocol):
    """What `gnomon.case` gives."""

    case: Case


CaseLike = str | Case | HasCase
"""A case, or the name of one or several."""
DEFAULT = "default"
"""The name of a case's default variant in results."""


def choose(
    names: Sequence[str] | None, variants: bool, rounded: bool = True, **parameters: str
) -> list[tuple[Case, str]]:
    """The cases with these names, each with a label for changed parameters; numbers are binary64 if `rounded`.

    A name is a case (with all its variants if `variants`), `case/variant`, `package.module:Case`, or a pattern of these
    with * and ?. Without names all cases are chosen.
    """
    label = "".join(f" {name}={value}" for name, value in parameters.items())
    chosen: dict[tuple[str, str | None], Case] = {}
    for name in expand(names or cases.names()):
        base, slash, variant = name.partition("/")
        listed: list[str | None] = [None]
        if slash:
            listed = [None if variant == DEFAULT else variant]
        elif variants:
            listed += [v.name for v in cases.case_class(base).variants]
        chosen |= {(base, v): cases.get(base, v, **parameters) for v in listed if (base, v) not in chosen}
    return [(case.rounded() if rounded else case, label) for case in chosen.values()]


def find_cases(items: Sequence[CaseLike]) -> list[Case]:
    """The cases: each by its name as in `choose`, as it is, or as `gnomon.case` gives it. Their ids must differ."""
    chosen: list[Case] = []
    for item in items:
        case = getattr(item, "case", item)
        if isinstance(case, str):
            chosen += [each for each, _ in choose([case], variants=False)]
        elif isinstance(case, Case):
            chosen.append(case.rounded())
        else:
            raise ValueError(f"{short(item)} is not a case; give a name, as pendulum_simple, or gnomon.case(...)")
    by_id = {case.id: case for case in chosen}
    if len(by_id) < len({(case.id, case.span, *case.numbers.values()) for case in chosen}):
        raise ValueError("two cases have one name and different numbers; give one of them")
    return list(by_id.values())


def expand(names: Iterable[str], checks: bool = False) -> list[str]:
    """The names, each once, with the names that a pattern matches in its place: of cases, and of checks if `checks`.

    A pattern with a slash, as kepler_orbit/*, matches variants, `default` among them. Raises ValueError for a pattern
    that matches nothing.
    """
    known = (*cases.names(), *(cases.check_names() if checks else ()))
    expanded: list[str] = []
    for name in names:
        base, slash, _ = name.partition("/")
        bases = matching(base, known) if is_pattern(base) else [base]
        if not is_pattern(name):
            expanded.append(name)
        elif not slash:
            expanded += bases
        else:
            expanded += matching(name, [f"{case}/{variant}" for case in bases for variant in variants_of(case)])
    return list(dict.fromkeys(expanded))


def variants_of(name: str) -> dict[str, str]:
    """The variants of a case or a check, each with its difficulty."""
    kind = cases.check_class(name) if name in cases.check_names() else cases.case_class(name)
    return {DEFAULT: ""} | {variant.name: variant.stresses for variant in kind.variants}


def containing(part: str, names: Iterable[str]) -> list[str]:
    """The names with this part, in either case of letters, or that match it if it is a pattern; ValueError for none."""
    names = list(names)
    parts = [] if is_pattern(part) else [name for name in names if part.lower() in name.lower()]
    return parts or matching(part, names)


def family(case: type[Case]) -> str:
    """The folder of cases/ that a case is in; its module for a user's own."""
    parts = case.__module__.split(".")
    return parts[2] if parts[:2] == ["gnomon", "cases"] else case.__module__


def source_file(kind: type) -> str:
    """The file of a class: below the root of the repository if it is gnomon's own, as `cases/orbits/two_body.py`."""
    package, _, rest = kind.__module__.partition(".")
    if package == "gnomon":
        return f"{rest.replace('.', '/')}.py"
    return getattr(sys.modules[kind.__module__], "__file__", None) or kind.__module__


def cases_of(
    pairs: Sequence[tuple[Case, str]], families: Sequence[str] | None, kinds: Sequence[str] | None
) -> list[tuple[Case, str]]:
    """The cases, each with its label, of these families that offer one of these forms; all without a restriction.

    Raises ValueError for a word that fits no case.
    """
    left = _keep("--family", families, [(pair, {family(type(pair[0]))}) for pair in pairs])
    if not kinds:
        return left
    return _keep("--kind", kinds, [(pair, {kind.__name__ for kind in _list_offered(pair[0])}) for pair in left])


def integrators_of(
    integrators: Sequence[Integrator], libraries: Sequence[str] | None, kinds: Sequence[str] | None
) -> list[Integrator]:
    """The integrators of these libraries that accept one of these forms. Raises ValueError as `cases_of`."""
    left = _keep("--library", libraries, [(integrator, {integrator.library}) for integrator in integrators])
    forms: tuple[type, ...] = (*get_args(Form), SceneForm)
    every = [kind for form in forms for kind in _descendants(form)]
    return _keep("--kind", kinds, [(x, {f.__name__ for f in every if issubclass(f, x.accepts)}) for x in left])


def _list_offered(case: Case) -> Iterator[type]:
    """The types of a case's forms, and their base types: a Separable form is SecondOrder too."""
    for form in case.all_forms() if case.scene is None else (*case.all_forms(), case.scene):
        yield from type(form).__mro__[:-1]


def _descendants(form: type) -> Iterator[type]:
    yield form
    subclasses: list[type] = form.__subclasses__()
    for kind in subclasses:
        yield from _descendants(kind)


def _keep(option: str, wanted: Sequence[str] | None, items: Sequence[tuple[Item, set[str]]]) -> list[Item]:
    if not wanted:
        return [item for item, _ in items]
    valid = {name.lower(): name for _, names in items for name in names}
    for word in wanted:
        if word.lower() not in valid:
            raise ValueError(f"{option} {word}: no integrator that is named has it; {nearest(word, valid.values())}")
    chosen = {valid[word.lower()] for word in wanted}
    return [item for item, names in items if chosen & names]

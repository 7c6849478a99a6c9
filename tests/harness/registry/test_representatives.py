"""The file of representatives: every library answers for every kind, with a method that exists and takes such systems."""

from collections import Counter
from pathlib import Path

import pytest
from gnomon.cases.core.forms import Constrained
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.registry import lookup, representatives
from gnomon.harness.registry.representatives import ROUGH, STIFF

from gnomon import cases

KINDS: dict[str, list[str]] = read_declared("reporting", "templates/page.toml")["kinds"]
EVERY = (*LIBRARIES, "gnomon")
ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def offered() -> dict[str, list[tuple[type, ...]]]:
    """By kind, the types of the forms of each of its cases."""
    found: dict[str, list[tuple[type, ...]]] = {}
    for name in cases.names():
        case = cases.get(name)
        types = tuple(type(form) for form in (*case.all_forms(), case.scene) if form is not None)
        marks = {kind.__name__ for kind in types}
        found.setdefault(next(kind for kind, forms in KINDS.items() if marks & set(forms)), []).append(types)
    return found


def test_the_kinds_are_those_of_the_page():
    assert Counter(representatives.kinds()) == Counter([*KINDS, STIFF, ROUGH])


@pytest.mark.parametrize("library", EVERY)
def test_each_library_answers_for_each_kind_or_says_why_not(library):
    for kind in (*KINDS, STIFF):
        found, why = representatives.representative(library, kind), representatives.reason(library, kind)
        told = f"{library}, {kind}: write one [[choice]] or [[none]] into harness/registry/representatives.toml"
        assert (found is None) != (why is None), f"{told}; now {found}, {why}"


def test_a_new_library_needs_no_choice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its manual may be read later: until then no method stands for it, and the tables say so."""
    monkeypatch.setitem(LIBRARIES, "newest", LIBRARIES["scipy"])
    representatives._read.cache_clear()
    try:
        for kind in (*KINDS, STIFF):
            assert representatives.representative("newest", kind) is None
            assert representatives.reason("newest", kind) == representatives.NOT_CHOSEN
        assert representatives.reason("scipy", STIFF) is None
    finally:
        representatives._read.cache_clear()


def test_every_representative_is_declared_and_takes_systems_of_its_kind(offered):
    """Of an integrator that takes no form of any case of a kind, no measurement can exist."""
    known = lookup.own()
    for (library, kind), one in representatives.representatives().items():
        integrator = known[one.integrator]
        assert integrator.library == library
        forms = offered.get(kind, [types for every in offered.values() for types in every])
        assert any(issubclass(form, integrator.accepts) for types in forms for form in types), (kind, one.integrator)
        if kind == STIFF:
            assert one.integrator in lookup.STIFF


def test_a_solver_of_differential_algebraic_equations_stands_for_constraints():
    """Coordinates that are tied together are what such solvers are for; it stands on its own form alone."""
    kind = "Constraints and their reactions"
    standing = [one.integrator for (_, of), one in representatives.representatives().items() if of == kind]
    solvers = [name for name in standing if lookup.own()[name].accepts == (Constrained,)]
    assert solvers
    smooth = [one.integrator for (_, of), one in representatives.representatives().items() if of != kind]
    assert not {*solvers} & {*smooth}


def test_quotes_and_sources_are_given():
    """A choice without a place to look it up cannot be judged."""
    for one in representatives.representatives().values():
        assert one.quote.strip() == one.quote != ""
        assert one.source.startswith("https://") or (ROOT / one.source).is_file(), one.source


def test_gnomons_own_quotations_stand_in_its_documents():
    own = {one for (library, _), one in representatives.representatives().items() if library == "gnomon"}
    assert own
    for one in own:
        assert one.quote in " ".join((ROOT / one.source).read_text("utf-8").split())


def test_scipys_quotations_stand_in_its_manual():
    """SciPy's manual is made from the docstring of the installed function."""
    from scipy.integrate import solve_ivp

    manual = " ".join(str(solve_ivp.__doc__).split())
    for (library, _), one in representatives.representatives().items():
        assert library != "scipy" or one.quote in manual


def test_a_users_own_integrator_has_none():
    assert representatives.representative("mine", STIFF) is None
    assert representatives.reason("mine", STIFF) is None


def test_an_unknown_kind_is_refused_with_the_near_ones():
    with pytest.raises(ValueError, match=r"no kind of system is called 'stif'.*stiff"):
        representatives.representative("scipy", "stif")

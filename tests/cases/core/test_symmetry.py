"""Symmetries that cases declare hold for their equations, and relations can be undone."""

import random

import numpy as np
import pytest
from gnomon.cases import Case
from gnomon.cases.core.forms import NBody, first_order
from gnomon.cases.core.registry import get, names
from gnomon.cases.core.symmetry import Relation, defect, in_units, mirrored, permuted

ROUNDING = 1e-11
"""A few hundred roundings of terms that may be a hundred times larger than their sum."""
SYMMETRIC = [(name, kind) for name in names() for kind in (mirrored, permuted) if kind(get(name)) is not None]


def worst(case: Case, relation: Relation) -> float:
    """The defect of all forms that are equations, at random numbers of the domain."""
    draw, found = random.Random(case.name).random, []
    coordinates, parameters = [c.name for c in case.state], [p.name for p in case.parameter_list]
    for _ in range(5):
        numbers = case.domain.draw((*coordinates, *parameters), draw)
        # Draws fall on 0 where a joint rule needs it; a small addition leaves no symmetry by chance.
        state = np.array([numbers[name] + 0.1 * draw() for name in coordinates])
        values = np.array([numbers[name] for name in parameters])
        for form in filter(None, map(first_order, case.all_forms())):
            found.append(defect(case, form.equations, relation, [(draw(), state)], values))
    return max(found)


@pytest.mark.parametrize(("name", "kind"), SYMMETRIC, ids=lambda value: getattr(value, "__name__", value))
def test_equations_keep_the_symmetries_declared(name: str, kind: object) -> None:
    case = get(name)
    relation = kind(case)  # type: ignore[operator]
    assert worst(case, relation) < ROUNDING
    known = {number.name for number in (*case.state, *case.parameter_list)}
    assert {*relation.factors, *relation.sources} <= known
    groups = {coordinate.name: coordinate.group for coordinate in case.state}
    pairs = {(groups[a], groups[b]) for a, b in relation.sources.items() if a in groups}
    assert len(pairs) == len({a for a, _ in pairs}) == len({b for _, b in pairs}), "one size becomes one size"


def test_what_is_no_symmetry_has_a_defect() -> None:
    """Kepler's orbit with one sign changed, an oscillator whose force keeps its sign, springs that are not exchanged."""
    assert worst(get("kepler_orbit"), Relation({"x": -1.0})) > 0.1
    assert worst(get("forced_oscillator"), Relation({"x": -1.0, "v": -1.0})) > 0.1
    exchanged = {"x1": "x3", "x3": "x1", "v1": "v3", "v3": "v1"}
    assert worst(get("small_vibrations_mdof"), Relation(sources=exchanged)) > 0.1


@pytest.mark.parametrize("name", ["pendulum_simple", "kepler_orbit", "charge_in_E_and_B", "euler_top", "two_body"])
def test_equations_hold_in_other_units(name: str) -> None:
    """Of all these with derived units; a stiffness that is only a number holds in one system of units."""
    case = get(name)
    relation = in_units(case, 1024.0, 1 / 32)
    assert relation is not None
    assert worst(case, relation) < ROUNDING


def test_units_have_powers_of_length_and_time() -> None:
    def factor(case: str, name: str) -> float:
        relation = in_units(get(case), 1024.0, 0.5)
        assert relation is not None
        return relation.factors[name]

    assert factor("kepler_orbit", "mu") == 1024.0**3 * 4
    assert factor("two_body", "G") == 1024.0**3 * 4
    assert factor("damped_oscillator", "c") == 2
    assert factor("charge_in_E_and_B", "Ex") == 1024 * 4
    assert factor("projectile_parabolic_coordinates", "xi_rate") == 64


def test_a_relation_is_undone() -> None:
    names_, values = ("a", "b", "c", "d"), np.arange(8.0).reshape(2, 4)
    relation = Relation({"a": 2.0, "d": -1.0}, {"a": "b", "b": "c", "c": "a"})
    applied = relation.applied(names_, values)
    np.testing.assert_array_equal(applied[0], [2.0, 2.0, 0.0, -3.0])
    np.testing.assert_array_equal(relation.undone(names_, applied), values)


def test_bodies_of_an_n_body_form_are_those_of_its_equations() -> None:
    """Where bodies exchange their numbers, the masses of the form are exchanged too."""
    case = get("two_body")
    form = next(form for form in case.forms if isinstance(form, NBody))
    relation = permuted(case)
    assert relation is not None
    values = np.array([float(value) for value in case.parameter_values()])
    after = relation.applied([p.name for p in case.parameter_list], values)
    assert form.masses(tuple(after)) == form.masses(tuple(values))[::-1]

"""A start that violates its constraints is refused, with the residual and the nearest start that does not."""

import re
from typing import Any

import numpy as np
import pytest
from constrained_forms import CHAIN, DRAGGED, FORMS, SHAKEN, masses
from gnomon.cases.core.consistent import nearest_place, nearest_velocity, violation
from gnomon.cases.core.elimination import rows_of

import gnomon

P = (1.0, 2.0, 0.5, 9.0)
PLACE = (0.6, -0.75, 1.5, -1.4, 1.3, -2.5)
VELOCITY = (0.5, -1.0, 0.25, 2.0, 1.0, -0.5)


def numbers_in(text: str) -> list[float]:
    """The numbers of the start in brackets."""
    found = re.search(r"\[(.*)\]", text)
    assert found
    return [float(x) for x in found[1].split(",")]


@pytest.mark.parametrize("name", FORMS)
def test_the_nearest_velocities_are_consistent_and_named(name: str) -> None:
    text = violation(FORMS[name], 0.5, (*PLACE, *VELOCITY), P)
    assert text is not None
    assert "constraint 1 changes at the rate" in text
    assert violation(FORMS[name], 0.5, (*PLACE, *numbers_in(text)), P) is None


@pytest.mark.parametrize("form", [CHAIN, SHAKEN, DRAGGED])
def test_no_consistent_velocity_is_nearer_in_the_metric_of_the_masses(form: Any) -> None:
    """The change is M-orthogonal to every velocity that leaves the constraints as they are."""
    change = np.subtract(VELOCITY, nearest_velocity(form, 0.5, PLACE, VELOCITY, P))
    inertia = np.array(rows_of((form.mass or masses)(0.5, PLACE, P), 6))
    normals = np.array(rows_of(form.gradient(0.5, PLACE, P), 6))
    free = np.linalg.svd(normals)[2][3:]
    assert np.max(np.abs(free @ inertia @ change)) < 1e-13


def test_places_are_moved_onto_constraints_with_constants() -> None:
    constants = (0.5, 0.5, 0.5)
    place = nearest_place(SHAKEN, 0.5, PLACE, P, constants)
    assert SHAKEN.constraint(0.5, place, P) == pytest.approx(constants, abs=1e-15)
    text = violation(SHAKEN, 0.5, (*PLACE, *VELOCITY), P, constants)
    assert text is not None
    assert "constraint 2 is off by" in text
    assert violation(SHAKEN, 0.5, numbers_in(text), P, constants) is None


def test_dependent_gradients_are_said() -> None:
    text = violation(CHAIN, 0.0, (0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 1, 0), P)
    assert text is not None
    assert "not independent" in text


def test_a_case_names_the_nearest_start() -> None:
    with pytest.raises(
        ValueError, match="constraint 1 changes at the rate 2; the nearest consistent velocities"
    ) as error:
        gnomon.case("holonomic_constraint_dae", initial_state=(1, 0, 1, 3))
    assert numbers_in(str(error.value)) == [0, 3]


def test_solve_refuses_an_inconsistent_start_of_a_form() -> None:
    start = [*PLACE, *nearest_velocity(SHAKEN, 0.5, PLACE, VELOCITY, P)]
    assert gnomon.solve(SHAKEN, (0.5, 0.75), start, "RATTLE", step=2**-6, args=P).success
    with pytest.raises(ValueError, match="y0 violates its constraints: constraint 1 changes at the rate"):
        gnomon.solve(SHAKEN, (0.5, 0.75), [*PLACE, *VELOCITY], "RATTLE", step=2**-6, args=P)

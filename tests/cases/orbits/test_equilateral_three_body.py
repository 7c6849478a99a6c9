"""The closed form of the triangle agrees with the integration that is used for starts close to it."""

import math

import numpy as np
import pytest
from gnomon.cases import case_class, get
from gnomon.cases.core.integrated import IntegratedCase
from mpmath import mpf

NAME = "equilateral_three_body"


@pytest.mark.parametrize("variant", [v.name for v in case_class(NAME).variants if v.name != "beside"])
def test_rounding_to_doubles_keeps_the_triangle(variant):
    case = get(NAME, variant).rounded()
    assert case.triangle is not None
    assert case.initial_state == get(NAME, variant).initial_state


def test_the_closed_form_agrees_with_the_integrated_equations():
    case = get(NAME, span=3)
    integrated = IntegratedCase.motion(case)
    for t in (1, 3):
        pairs = zip(case.exact(t, 33), integrated.state(t, 33), strict=True)
        assert max(abs(a - b) for a, b in pairs) < mpf("1e-30")


@pytest.mark.slow
def test_a_start_close_to_the_triangle_leaves_it():
    """Errors grow by e^(2 pi/sqrt 2) in each turn of a triangle of equal masses."""
    triangle, turn = get(NAME, "equal"), 6.100852
    growth = float(triangle.quantities()["growth_a_turn"])
    assert math.isclose(growth, math.exp(2 * math.pi / math.sqrt(2)), rel_tol=1e-12)
    start = list(triangle.initial_state)
    start[0] += 2.0**-40
    times = np.array([2 * turn, 3 * turn])
    perturbed = triangle.with_numbers(start, triangle.parameters).with_span(3 * turn)
    apart = np.linalg.norm((perturbed.sample(times) - triangle.sample(times))[:, :9], axis=1)
    # The other parts of the error, a drift and a change of the period, are then a thousandth of the growing one.
    assert math.isclose(apart[1] / apart[0], growth, rel_tol=0.005)

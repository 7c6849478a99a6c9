"""The traced Jacobian of every case against central differences in high precision, and the declared ones."""

from __future__ import annotations

from math import acos, acosh, asin, asinh, atan, atanh, cos, cosh, exp, hypot, log, sin, sinh, sqrt, tan, tanh
from typing import Any

import pytest
from gnomon.cases.core import registry
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.harness.contract.problem import accepted_form
from gnomon.harness.kernels.graph import UNARY, Graph, jacobian_text
from gnomon.reference.numerics.precision import working


def every_function(t: Any, state: Values, parameters: Values) -> Values:
    x, y = state
    (a,) = parameters
    first = sin(x) * cos(y) + tan(x / 2) - asin(y / 2) + acos(x / 3) / (2 + atan(x * y))
    second = sinh(x) - cosh(y) * tanh(x + t) + asinh(x) + acosh(2 + y) - atanh(x / 4)
    third = sqrt(x + y) ** 3 - exp(-x) * log(1 + y) + hypot(x, y) * a + (x + 1) ** 2.5 - 3 / (y + a) ** 2
    return first + second, second * third / (sin(a) + 2) - (x + 1) ** -2 + (x + 1) ** a


FORMS = {name: accepted_form(registry.get(name), (FirstOrder,)) for name in registry.names()}


def worst_difference(mp: Any, form: FirstOrder, t: Any, state: list[Any], parameters: list[Any]) -> Any:
    """The difference of the traced Jacobian and central differences, relative to the largest entry of a row."""
    n = len(state)
    space: dict[str, Any] = {name: getattr(mp, name) for name in UNARY} | {"ONE": mp.mpf(1)}
    exec(jacobian_text(form, n, len(parameters)), space)
    found = [mp.mpf(0)] * (n * n)
    space["kernel"](t, state, parameters, found)
    equations = rebind(form.equations, mpmath_arithmetic(mp))
    tiny = mp.mpf(10) ** -25
    worst = mp.mpf(0)
    for j in range(n):
        step = tiny * max(1, abs(state[j]))
        ahead, behind = ([x + s * step * (i == j) for i, x in enumerate(state)] for s in (1, -1))
        pairs = zip(
            equations(t, tuple(ahead), tuple(parameters)), equations(t, tuple(behind), tuple(parameters)), strict=True
        )
        for i, (a, b) in enumerate(pairs):
            worst = max(worst, abs(found[i * n + j] - (a - b) / (2 * step)) / (1 + abs(found[i * n + j])))
    return worst


def test_jacobian_of_every_function() -> None:
    with working(90) as mp:
        state, parameters = [mp.mpf(1) / 2, mp.mpf(2) / 5], [mp.mpf(3) / 4]
        assert worst_difference(mp, FirstOrder(every_function), mp.mpf(1) / 8, state, parameters) < 1e-40


@pytest.mark.parametrize("name", [name for name, form in FORMS.items() if form is not None])
def test_jacobian_of_every_case(name: str) -> None:
    case, form = registry.get(name), FORMS[name]
    assert isinstance(form, FirstOrder)
    with working(90) as mp:
        # Near the start, perturbed so that no velocity is exactly zero.
        state = [mp.mpf(x.numerator) / x.denominator + mp.mpf(k + 1) / 1000 for k, x in enumerate(case.initial_state)]
        parameters = [mp.mpf(x.numerator) / x.denominator for x in case.parameter_values()]
        # Differences of 1e-25 err by 1e-50 times third derivatives, which stiff cases have up to 1e20.
        assert worst_difference(mp, form, mp.mpf(1) / 8, state, parameters) < 1e-30


@pytest.mark.parametrize("name", [name for name, form in FORMS.items() if getattr(form, "jacobian", None)])
def test_declared_jacobians_are_the_traced_ones(name: str) -> None:
    case, form = registry.get(name).rounded(), FORMS[name]
    assert isinstance(form, FirstOrder)
    assert form.jacobian is not None
    with working(40) as mp:
        state = [mp.mpf(x.numerator) / x.denominator + mp.mpf(1) / 1000 for x in case.initial_state]
        parameters = [mp.mpf(x.numerator) / x.denominator for x in case.parameter_values()]
        found = [mp.mpf(0)] * len(state) ** 2
        space: dict[str, Any] = {name: getattr(mp, name) for name in UNARY} | {"ONE": mp.mpf(1)}
        exec(jacobian_text(form, len(state), len(parameters)), space)
        space["kernel"](mp.mpf(1) / 8, state, parameters, found)
        declared = rebind(form.jacobian, mpmath_arithmetic(mp))(mp.mpf(1) / 8, tuple(state), tuple(parameters))
        for a, b in zip(found, declared, strict=True):
            assert abs(a - b) <= 1e-30 * (1 + abs(a))


def test_equal_nodes_are_one_and_zeros_and_ones_fold() -> None:
    graph = Graph()
    x, y = graph.variables("y", 2)
    assert (x * y).index == (y * x).index
    assert (0 * x + y * 1 - 0).index == y.index
    assert (x * graph.arithmetic()["sqrt"](x)).index == (x**1.5).index


def test_a_branch_is_an_error() -> None:
    with pytest.raises(ValueError, match="must not branch"):
        bool(Graph().node("t"))

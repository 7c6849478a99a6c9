"""Traced equations give the same numbers as the functions that were traced."""

import math
from typing import Any

import numpy as np
import pytest
from bad_equations import scalar
from case_equations import EVERY
from gnomon.harness.adapters import scipy_ivp
from gnomon.harness.contract.integrator import Integrator, Refused
from gnomon.harness.integrators.gauss.gauss_fast import GaussFast
from gnomon.harness.integrators.gauss.radau import Radau5
from gnomon.harness.integrators.taylor.taylor import Taylor
from gnomon.harness.kernels.straight_line import compute
from gnomon.harness.kernels.traced import Node, ReducedTrace, Trace, is_number, trace_form


@pytest.mark.parametrize("name", EVERY)
def test_the_nodes_and_the_function_give_the_same_bits(name: str) -> None:
    """Operations are kept as written: only + 0, * 1, * 0, / 1 and x - x are removed, which are exact."""
    equations = EVERY[name]
    trace = Trace(equations.dimension, equations.parameters)
    values = trace_form(equations.form, trace)
    for seed in range(3):
        t, state, parameters = equations.at_random(seed)
        assert tuple(compute(values, trace, t, state, parameters, vars(math))) == equations.form.equations(
            t, tuple(state), tuple(parameters)
        )


def test_zeros_are_removed_and_equal_values_computed_once() -> None:
    for kind in (Trace, ReducedTrace):
        trace = kind(2, 1)
        x, y = trace.state
        assert (x * y) + (x * y) is (x * y) + (x * y)
        assert is_number(0 * x, 0)
        assert is_number(x * y - x * y, 0)
        assert x * 1 is x
        assert x - 0 is x
        assert 0 * x + y * 1 - 0 is y


def test_a_reduced_trace_has_fewer_operations() -> None:
    """Each is a recurrence of Taylor's method. The other keeps the sequence of operations, which determines their bits."""
    for kind, fewer in ((ReducedTrace, True), (Trace, False)):
        x, y = kind(2, 0).state
        root = x.trace.functions["sqrt"](x)
        pairs = [(y * x, x * y), (x * root, x**1.5), (y / (x * root), y * x**-1.5), (x**3, x * x * x)]
        assert [a is b for a, b in pairs] == [fewer] * 4


def absolute(t: Any, state: Any, parameters: Any) -> Any:
    (x,) = state
    return (-abs(x),)


@pytest.mark.parametrize("method", [GaussFast, Radau5, Taylor])
def test_methods_that_need_traced_equations_refuse_others(method: type[Integrator]) -> None:
    with pytest.raises(Refused, match="cannot be traced: bad operand type for abs"):
        method().prepare(scalar(absolute), 1e-6)


@pytest.mark.parametrize("method", [scipy_ivp.Radau, scipy_ivp.LSODA])
def test_methods_of_scipy_take_finite_differences_where_equations_cannot_be_traced(method: type[Integrator]) -> None:
    problem = scalar(absolute)
    solve = method().prepare(problem, 1e-8)
    assert solve.options["jac"] is None  # type: ignore[attr-defined]
    assert solve(np.array([[1.0]])).states[0, :, 0] == pytest.approx(np.exp(-problem.times), rel=1e-5)


def test_a_branch_is_an_error() -> None:
    for branch in (bool, lambda x: x < 1, lambda x: x == 1):
        with pytest.raises(ValueError, match="must not branch"):
            branch(Trace(1, 0).t)  # type: ignore[operator]


def test_variables_are_nodes_without_arguments() -> None:
    trace = Trace(3, 1, frozen=(1,))
    assert [x.operation for x in trace.state] == ["y[0]", "p[1]", "y[1]"]
    assert all(isinstance(x, Node) and not x.arguments for x in (trace.t, *trace.state, *trace.parameters))

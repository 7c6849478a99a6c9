"""Exact derivatives of traced equations, against a complex step in high precision: f'(x) = Im f(x + ih)/h + O(h^2)."""

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from case_equations import EVERY, every_function
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.kernels.derivatives import jacobian
from gnomon.harness.kernels.straight_line import compute, derivatives, derivatives_kernel
from gnomon.harness.kernels.traced import ReducedTrace, Trace, is_number, trace_form
from gnomon.reference.numerics.precision import working

DIGITS, STEP = 120, 40
"""A step of 1e-40: it errs by 1e-80 times third derivatives, and rounding in 120 digits by 1e-80 too."""


def by_complex_step(mp: Any, form: FirstOrder, t: Any, state: list[Any], parameters: list[Any]) -> list[Any]:
    """df/dy, row by row."""
    arithmetic = mpmath_arithmetic(mp) | {"hypot": lambda x, y: mp.sqrt(x * x + y * y)}  # mpmath's hypot is real
    equations, h, columns = rebind(form.equations, arithmetic), mp.mpf(10) ** -STEP, []
    for j in range(len(state)):
        aside = [x + mp.mpc(0, h) * (i == j) for i, x in enumerate(state)]
        columns.append([mp.mpc(x).imag / h for x in equations(t, tuple(aside), tuple(parameters))])
    return [x for row in zip(*columns, strict=True) for x in row]


def assert_derivatives(mp: Any, kind: type[Trace], form: FirstOrder, t: Any, state: Any, parameters: Any) -> None:
    trace = kind(len(state), len(parameters))
    found = jacobian(trace_form(form, trace), trace.state)
    numbers = compute(found, trace, t, state, parameters, mpmath_arithmetic(mp))
    for a, b in zip(numbers, by_complex_step(mp, form, t, state, parameters), strict=True):
        # Stiff cases have third derivatives of 1e20, and terms may cancel. A `Trace` has the inverse of 3 as a float.
        assert abs(a - b) <= (mp.mpf(10) ** -50 if kind is ReducedTrace else 1e-15) * (1 + abs(b))


@pytest.mark.parametrize("kind", [Trace, ReducedTrace])
def test_derivatives_of_every_function(kind: type[Trace]) -> None:
    with working(DIGITS) as mp:
        state, parameters = [mp.mpf(1) / 2, mp.mpf(2) / 5], [mp.mpf(3) / 4]
        assert_derivatives(mp, kind, FirstOrder(every_function), mp.mpf(1) / 8, state, parameters)


@pytest.mark.parametrize("name", EVERY)
def test_derivatives_of_the_equations_of_every_case(name: str) -> None:
    """At a random place in the domain of the case, with operations as written and reduced."""
    equations = EVERY[name]
    t, state, parameters = equations.at_random(1)
    with working(DIGITS) as mp:
        at = mp.mpf(t), [mp.mpf(x) for x in state], [mp.mpf(x) for x in parameters]
        for kind in (Trace, ReducedTrace):
            assert_derivatives(mp, kind, equations.form, *at)


def test_derivatives_of_functions_and_powers_of_two_arguments() -> None:
    for kind in (Trace, ReducedTrace):
        trace = kind(2, 0)
        x, y = trace.state
        f = trace.functions
        values = [f["atan2"](x, y), f["hypot"](x, y), x**y, x**3 / y**2, 2**x - y]
        plain = [mpmath.atan2, mpmath.hypot, lambda a, b: a**b, lambda a, b: a**3 / b**2, lambda a, b: 2**a - b]
        with working(30) as mp:
            at = [mp.mpf("1.25"), mp.mpf("0.75")]
            found = compute(jacobian(values, (x, y)), trace, mp.mpf(0), at, [], mpmath_arithmetic(mp))
        with mpmath.workdps(40):
            exact = [mpmath.diff(function, (1.25, 0.75), n) for function in plain for n in ((1, 0), (0, 1))]
        assert [float(a) for a in found] == pytest.approx([float(b) for b in exact], rel=1e-15)


def test_derivatives_of_hypot_of_three_arguments_and_of_a_logarithm_to_a_base() -> None:
    for kind in (Trace, ReducedTrace):
        trace = kind(2, 0)
        x, y = trace.state
        values = [trace.functions["hypot"](x, y, 3.0), trace.functions["log"](x, y)]
        with working(30) as mp:
            at = [mp.mpf("1.25"), mp.mpf("0.75")]
            found = compute(jacobian(values, (x, y)), trace, mp.mpf(0), at, [], mpmath_arithmetic(mp))
        length, log = math.hypot(1.25, 0.75, 3.0), math.log(0.75)
        exact = [1.25 / length, 0.75 / length, 1 / (1.25 * log), -math.log(1.25) / (0.75 * log**2)]
        assert [float(a) for a in found] == pytest.approx(exact, rel=1e-14)


def test_zero_derivatives_are_numbers() -> None:
    """So that the compiled code leaves them out."""
    trace = Trace(2, 1)
    (x, y), (p,) = trace.state, trace.parameters
    first, second, third, fourth = jacobian([p * y, trace.functions["sin"](trace.t) + x], (x, y))
    assert is_number(first, 0)
    assert second is p
    assert is_number(third, 1)
    assert is_number(fourth, 0)


@pytest.mark.parametrize("name", ["kepler_orbit", "pendulum_on_cart", "lagrange_top"])
def test_the_kernel_with_both_has_the_equations_and_the_jacobian(name: str) -> None:
    """The compiled function of Newton's iteration: f, then df/dy, and a count in the place after the parameters."""
    equations = EVERY[name]
    n, sizes = equations.dimension, (equations.dimension, equations.parameters)
    t, state, parameters = equations.at_random(2)
    both, p, y = np.empty(n + n * n), np.array([*parameters, 4.0]), np.array(state)
    derivatives_kernel(equations.form, *sizes, True).counted().pointer(t, y, p, both)
    assert p[-1] == 5
    assert both[:n] == pytest.approx(equations.form.equations(t, tuple(state), tuple(parameters)), rel=1e-12, abs=1e-12)
    assert both[n:].tolist() == derivatives_kernel(equations.form, *sizes).array(t, y, p).tolist()
    with working(50) as mp:
        exact = by_complex_step(mp, equations.form, mp.mpf(t), [*map(mp.mpf, state)], [*map(mp.mpf, parameters)])
    assert both[n:] == pytest.approx([float(x) for x in exact], rel=1e-11, abs=1e-11)


def test_derivatives_in_time_are_a_last_column() -> None:
    """Implicit methods of equations that depend on time lose their order without it; a constant has derivative 0 there."""

    def driven(t: Any, y: Any, p: Any) -> Any:
        return y[1] * t * t, p[0] * t - y[0], p[0]

    trace = ReducedTrace(3, 1)
    found = derivatives(FirstOrder(driven), trace, by_time=True)
    numbers = compute(found, trace, 3.0, [5.0, 7.0, 1.0], [11.0], {"sqrt": np.sqrt})
    assert numbers == [0, 9, 0, 42, -1, 0, 0, 11, 0, 0, 0, 0]

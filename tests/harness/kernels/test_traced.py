"""Traced equations: the same numbers as the case's own, and derivatives that mpmath confirms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mpmath
import pytest
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.core.registry import get
from gnomon.harness.kernels.traced import Trace, code, number, poles, sign, traced

CASES = (
    "pendulum_simple", "kepler_orbit", "forced_oscillator", "lagrange_top", "euler_top", "relativistic_charge",
    "pendulum_on_cart", "foucault_pendulum_linear", "cycloidal_pendulum",
)  # fmt: skip


def case_and_form(name: str) -> tuple[Case, FirstOrder]:
    case = get(name).rounded()
    return case, next(form for form in case.all_forms() if isinstance(form, FirstOrder))


def stand_ins() -> dict[str, Any]:
    """The functions that generated code calls, on numbers instead of lanes."""
    return {
        "math": math, "lanes": float, "njit": lambda **_: lambda f: f, "sin_and_cos": lambda x: (math.sin(x), math.cos(x)),
        "turned_first": lambda x: (math.sin(x), math.cos(x), (x, math.sin(x), math.cos(x))),
        "over": lambda a, b, c: a / b,
    }  # fmt: skip


def evaluated(
    values: Sequence[Any],
    t: float,
    state: Sequence[float],
    parameters: Sequence[float],
    groups: Sequence[Sequence[int]] = (),
) -> tuple[float, ...]:
    """The generated code run on floats; with groups, their values one group after the other."""
    generated = "".join(code(values, groups)).replace(", INNER", "")
    space = stand_ins()
    exec(generated, space)
    k = space["constants"](parameters)
    w = space["forcing"](t, k)
    names = [f"slopes_{n}" for n in range(len(groups))] or ["slopes"]
    return tuple(x for name in names for x in space[name](state, w, k))


def scene(case: Case) -> tuple[float, list[float], list[float]]:
    """A time, a state without special values, parameters."""
    state = [float(x) + 0.0625 * (i + 1) / 8 for i, x in enumerate(case.initial_state)]
    return 0.375, state, [float(x) for x in case.parameter_values()]


@pytest.mark.parametrize("name", CASES)
def test_the_code_gives_the_same_numbers(name: str) -> None:
    case, form = case_and_form(name)
    t, state, parameters = scene(case)
    _, values = traced(FirstOrder(form.equations), len(state), len(parameters))
    expected = form.equations(t, tuple(state), tuple(parameters))
    assert evaluated(values, t, state, parameters) == tuple(float(x) for x in expected)


@pytest.mark.parametrize("name", CASES)
def test_groups_give_the_same_numbers(name: str) -> None:
    case, form = case_and_form(name)
    t, state, parameters = scene(case)
    _, values = traced(FirstOrder(form.equations), len(state), len(parameters))
    groups = [range(1, len(values), 2), range(0, len(values), 2)]
    whole = evaluated(values, t, state, parameters)
    assert evaluated(values, t, state, parameters, groups) == tuple(whole[i] for group in groups for i in group)


@pytest.mark.parametrize(
    ("name", "place"), [("pendulum_simple", 0), ("pendulum_on_cart", 1), ("forced_oscillator", None)]
)
def test_later_rounds_compute_sine_and_cosine_from_those_of_the_first(name: str, place: int | None) -> None:
    """One angle in the state, or none: the angle of a force may depend only on time."""
    case, form = case_and_form(name)
    t, state, parameters = scene(case)
    trace, values = traced(FirstOrder(form.equations), len(state), len(parameters))
    values += tuple(trace.derivative(value, trace.state[place or 0], {}) for value in values)
    generated = "".join(code(values)).replace(", INNER", "")
    asked = []

    def turned(angle: float, near: tuple[float, float, float]) -> tuple[float, float, str]:
        asked.append((angle, *near))
        return math.sin(angle), math.cos(angle), "for the next"

    space = stand_ins() | {"turned": turned}
    exec(generated, space)
    k = space["constants"](parameters)
    w = space["forcing"](t, k)
    assert ("slopes_again" in space) == (place is not None)
    if place is None:
        return
    found, near = space["slopes_first"](state, w, k)
    assert found == space["slopes"](state, w, k)
    moved = [x + 0.01 for x in state]
    assert space["slopes_again"](moved, w, k, near) == (space["slopes"](moved, w, k), ("for the next",))
    assert asked == [(moved[place], state[place], math.sin(state[place]), math.cos(state[place]))]


@pytest.mark.parametrize("name", CASES)
def test_derivatives(name: str) -> None:
    """Against central differences in fifty digits, whose error is of the order of their step squared, 1e-30."""
    case, form = case_and_form(name)
    t, state, parameters = scene(case)
    trace, values = traced(FirstOrder(form.equations), len(state), len(parameters))
    found = [trace.derivative(value, y, {}) for y in trace.state for value in values]
    numbers = iter(evaluated(found, t, state, parameters))
    with mpmath.workdps(50):
        equations, h = rebind(form.equations, mpmath_arithmetic(mpmath.mp)), mpmath.mpf(10) ** -15
        for j in range(len(state)):
            sides = []
            for sign in (1, -1):
                moved = [mpmath.mpf(x) + sign * h * (i == j) for i, x in enumerate(state)]
                sides.append(equations(mpmath.mpf(t), tuple(moved), tuple(mpmath.mpf(x) for x in parameters)))
            for plus, minus in zip(*sides, strict=True):
                exact = (plus - minus) / (2 * h)
                # Some twenty roundings of binary64, of terms that may cancel to a hundredth.
                assert abs(next(numbers) - exact) < 1e-12 * (1 + abs(exact))


def test_rules_of_every_function() -> None:
    """Each function's derivative at a place inside its domain, by mpmath's own numerical one."""
    names = (
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "sinh",
        "cosh",
        "tanh",
        "asinh",
        "atanh",
        "sqrt",
        "exp",
        "log",
    )
    for name in (*names, "acosh"):
        trace = Trace(1, 0)
        value = trace.function(name)(trace.state[0])
        at = 1.5 if name == "acosh" else 0.375
        (found,) = evaluated([trace.derivative(value, trace.state[0], {})], 0.0, [at], [])
        assert found == pytest.approx(float(mpmath.diff(getattr(mpmath, name), at)), rel=1e-9), name


def test_functions_and_powers_of_two_arguments() -> None:
    trace = Trace(2, 0)
    x, y = trace.state
    for value, plain in (
        (trace.function("atan2")(x, y), mpmath.atan2),
        (trace.function("hypot")(x, y), mpmath.hypot),
        (x**y, lambda a, b: a**b),
        (x**3 / y**2, lambda a, b: a**3 / b**2),
        (2**x - y, lambda a, b: 2**a - b),
    ):
        found = evaluated([trace.derivative(value, by, {}) for by in (x, y)], 0.0, [1.25, 0.75], [])
        for n, derivative in zip(((1, 0), (0, 1)), found, strict=True):
            assert derivative == pytest.approx(float(mpmath.diff(plain, (1.25, 0.75), n)), rel=1e-9)


def test_zeros_are_removed_and_equal_values_computed_once() -> None:
    trace = Trace(2, 1)
    x, y = trace.state
    assert (x * y) + (x * y) is (x * y) + (x * y)
    assert number(0 * x, 0)
    assert x * 1 is x
    assert x - 0 is x
    assert number(trace.derivative(trace.parameters[0] * y, x, {}), 0)


def test_poles_are_divisors_that_may_change_their_sign() -> None:
    trace = Trace(2, 1)
    (x, y), (p,), t = trace.state, trace.parameters, trace.t
    sine, root = trace.function("sin")(x), trace.function("sqrt")(x * x + y * y)
    assert poles([1 / (x * x * x), y / sine]) == (x * x * x, sine)
    assert poles([x**-3, 1 / (x * trace.function("cos")(t))]) == (x, x * trace.function("cos")(t))
    kept = (x * x + y**2, root * root * root, p * root, -(x * x), 1 + trace.function("cosh")(y), 2.0, p, (x * x) ** 3)
    assert poles([y / z for z in kept]) == ()
    assert poles([x**3 + y * sine, root**-3]) == ()
    below = poles([1 / x, 1 / (y - p)])
    generated = "".join(code([1 / x, 1 / (y - p)], (), below)).replace(", INNER", "")
    space = stand_ins()
    exec(generated, space)
    k = space["constants"]([0.25])
    assert space["poles"]([2.0, 3.0], space["forcing"](0.0, k), k) == (2.0, 2.75)


def test_signs_that_are_known() -> None:
    trace = Trace(2, 1)
    (x, y), (p,) = trace.state, trace.parameters
    square = x * x
    known = {
        1: (square, 3, square + y * y, square / (y * y)),
        0: (p, -1, -square, p * square, p + p),
        None: (x, x + square, square - y),
    }
    for expected, values in known.items():
        assert [sign(value, {}) for value in values] == [expected] * len(values)

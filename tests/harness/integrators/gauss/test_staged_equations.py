"""Traced equations in stages, computed on floats instead of lanes: the same numbers as the case's own functions."""

import math
from collections.abc import Sequence
from typing import Any

import pytest
from case_equations import EVERY
from gnomon.harness.integrators.gauss.staged_equations import Staged, is_expensive, poles, sign
from gnomon.harness.kernels.derivatives import jacobian
from gnomon.harness.kernels.traced import Trace, trace_form


def staged(values: Sequence[Any], poles: Sequence[Any] = ()) -> Staged:
    """The equations with the functions of Python in place of the functions of lanes."""
    found = Staged(values, poles)
    found.lanes, found.power, found.over, found.on_lanes = float, pow, lambda a, b, c: a / b, {}
    found.each = lambda name, *given: getattr(math, name)(*given)
    found.turned_first = lambda x: (math.sin(x), math.cos(x), (x, math.sin(x), math.cos(x)))
    return found


def evaluated(
    values: Sequence[Any],
    t: float,
    state: Sequence[float],
    parameters: Sequence[float],
    groups: Sequence[Sequence[int]] = (),
) -> tuple[float, ...]:
    """The values at a state; with groups, one group after the other."""
    equations = staged(values)
    k = equations.constants(parameters)
    w = equations.forcing(t, k)
    return tuple(x for group in groups or [()] for x in equations.slopes(state, w, k, group))


def traced_case(name: str) -> tuple[Trace, tuple[Any, ...]]:
    trace = Trace(EVERY[name].dimension, EVERY[name].parameters)
    return trace, trace_form(EVERY[name].form, trace)


@pytest.mark.parametrize("name", EVERY)
def test_stages_and_function_give_the_same_bits(name: str) -> None:
    """In one part, and in groups."""
    _, values = traced_case(name)
    groups = [range(1, len(values), 2), range(0, len(values), 2)]
    for seed in range(2):
        t, state, parameters = EVERY[name].at_random(seed)
        expected = tuple(map(float, EVERY[name].form.equations(t, tuple(state), tuple(parameters))))
        assert evaluated(values, t, state, parameters) == expected
        in_groups = tuple(expected[i] for group in groups for i in group)
        assert evaluated(values, t, state, parameters, groups) == in_groups


@pytest.mark.parametrize(
    ("name", "place"), [("pendulum_simple", 0), ("pendulum_on_cart", 1), ("forced_oscillator", None)]
)
def test_later_rounds_compute_sine_and_cosine_from_the_first_round(name: str, place: int | None) -> None:
    """One angle in the state, or none: the angle of a force may depend only on time."""
    trace, values = traced_case(name)
    t, state, parameters = EVERY[name].at_random(0)
    values += jacobian(values, [trace.state[place or 0]])
    equations, asked = staged(values), []

    def turned(angle: float, near: tuple[float, float, float]) -> tuple[float, float, str]:
        asked.append((angle, *near))
        return math.sin(angle), math.cos(angle), "for the next"

    equations.turned = turned
    k = equations.constants(parameters)
    w = equations.forcing(t, k)
    found, near = equations.slopes_first(state, w, k)
    assert found == equations.slopes(state, w, k)
    moved = [x + 0.01 for x in state]
    expected = equations.slopes(moved, w, k)
    if place is None:
        assert (near, equations.slopes_again(moved, w, k, near), asked) == ((), (expected, ()), [])
        return
    assert equations.slopes_again(moved, w, k, near) == (expected, ("for the next",))
    assert asked == [(moved[place], state[place], math.sin(state[place]), math.cos(state[place]))]


def test_poles_are_divisors_that_may_change_their_sign() -> None:
    trace = Trace(2, 1)
    (x, y), (p,), t = trace.state, trace.parameters, trace.t
    sine, root = trace.functions["sin"](x), trace.functions["sqrt"](x * x + y * y)
    assert poles([1 / (x * x * x), y / sine]) == (x * x * x, sine)
    assert poles([x**-3, 1 / (x * trace.functions["cos"](t))]) == (x, x * trace.functions["cos"](t))
    kept = (x * x + y**2, root * root * root, p * root, -(x * x), 1 + trace.functions["cosh"](y), 2.0, p, (x * x) ** 3)
    assert poles([y / z for z in kept]) == ()
    assert poles([x**3 + y * sine, root**-3]) == ()
    below = poles([1 / x, 1 / (y - p)])
    equations = staged([1 / x, 1 / (y - p)], below)
    k = equations.constants([0.25])
    assert equations.poles([2.0, 3.0], equations.forcing(0.0, k), k) == (2.0, 2.75)


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


def test_a_vector_is_divided_by_a_number_with_its_inverse_of_an_earlier_stage() -> None:
    """So a round has no division. Numbers of the text, and vectors, are divided as they are."""
    trace = Trace(2, 1)
    (x, y), (p,) = trace.state, trace.parameters
    equations = staged([x / p, y / trace.t, (x + y) / p])
    divided = [[node.operation for node in stage].count("/") for stage in equations.stages]
    assert divided == [1, 1, 3]
    asked = []
    equations.over = lambda a, b, c: asked.append((b, c)) or a / b
    k = equations.constants([0.25])
    assert equations.slopes([2.0, 3.0], equations.forcing(5.0, k), k) == (8.0, 3.0 / 5.0, 20.0)
    assert asked == [(0.25, 4.0), (5.0, 0.2), (0.25, 4.0)]
    assert [is_expensive(z) for z in (x / p, x / 3, x / y, x * y, x**2)] == [False, True, True, False, True]

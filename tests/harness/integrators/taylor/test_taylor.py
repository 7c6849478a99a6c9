"""Taylor's method: its coefficients satisfy the equations of every case; errors follow the tolerance."""

import math
from fractions import Fraction
from math import atan2, cos, exp
from typing import Any

import numpy as np
import pytest
from bad_equations import scalar, squared
from case_equations import every_function
from gnomon.cases.core import registry
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.harness.contract.integrator import Problem, Refused
from gnomon.harness.contract.problem import find_accepted_form
from gnomon.harness.integrators.taylor import recurrences
from gnomon.harness.integrators.taylor.recurrences import STRIDE
from gnomon.harness.integrators.taylor.taylor import Taylor, order_for, start_sizes
from gnomon.harness.studies.fixed_step_formulas import taylor_steps
from gnomon.harness.studies.orders import fit_order_exactly
from gnomon.reference.numerics.precision import working
from on_cases import of_order, solved

ORDER = 12


def constants(t: Any, state: Values, parameters: Values) -> Values:
    """A derivative without a variable, one that is a literal, one of t alone."""
    (a,) = parameters
    return a * a, 1, t * t - exp(t)


def coefficients(mp: Any, form: FirstOrder, t: Any, state: Any, parameters: Any, order: int) -> list[list[Any]]:
    """The recurrences run in mpmath: rows of coefficients of orders 0 to `order`."""
    found = recurrences.Recurrences(form, len(state), len(parameters))
    w = [mp.mpf(0)] * found.length
    recurrences.coefficients(found, mpmath_arithmetic(mp), t, [*state, order], parameters, w)
    return [w[STRIDE * i : STRIDE * i + order + 1] for i in range(len(state))]


def residual(mp: Any, form: FirstOrder, t: Any, state: Any, parameters: Any, order: int, h: Any) -> Any:
    """The largest component of P'(h) - f(t + h, P(h)) over h^order, P the polynomial: bounded if P is right."""
    rows = coefficients(mp, form, t, state, parameters, order)
    value = [mp.fsum(c * h**k for k, c in enumerate(row)) for row in rows]
    change = [mp.fsum(k * c * h ** (k - 1) for k, c in enumerate(row) if k) for row in rows]
    slopes = rebind(form.equations, mpmath_arithmetic(mp))(t + h, tuple(value), tuple(parameters))
    sizes = [1 + max(abs(x), abs(v)) for x, v in zip(change, value, strict=True)]
    return max(abs(a - b) / s for a, b, s in zip(change, slopes, sizes, strict=True)) / h**order


@pytest.mark.parametrize("equations", [every_function, constants])
def test_coefficients_of_every_function(equations: Any) -> None:
    form, state = FirstOrder(equations), (Fraction(1, 2), Fraction(2, 5), 1)
    with working(400) as mp:
        start = [mp.mpf(x.numerator) / x.denominator for x in state[: 2 + (equations is constants)]]
        found = [residual(mp, form, mp.mpf(1) / 8, start, [mp.mpf(3) / 4], ORDER, mp.mpf(10) ** -k) for k in (12, 14)]
    assert abs(found[0] - found[1]) <= 1e-9 * found[0], "C h^order (1 + O(h)), in 400 digits of which h^order takes 168"


@pytest.mark.parametrize(("order", "coarsest"), [(4, 96), (12, 12)])
def test_order_at_fixed_order_and_step(order: int, coarsest: int) -> None:
    """The recurrences of the compiled method, run in sixty digits over steps of the same length."""
    case = registry.get("kepler_orbit", span="0.5")
    counts = [coarsest * n // 12 for n in (12, 16, 24, 32)]
    with working(60) as mp:
        measured = fit_order_exactly(lambda count: taylor_steps(mp, case, order, count), case, counts)
    assert measured == of_order(order)


def first_order_cases() -> list[str]:
    return [name for name in registry.names() if find_accepted_form(registry.get(name), (FirstOrder,)) is not None]


@pytest.mark.parametrize("name", first_order_cases())
def test_coefficients_of_every_case(name: str) -> None:
    """The residual is C h^order; an error in the coefficient of order k would leave one of order k - 1."""
    case = registry.get(name)
    form = find_accepted_form(case, (FirstOrder,))
    assert isinstance(form, FirstOrder)
    with working(500) as mp:
        state = [mp.mpf(x.numerator) / x.denominator for x in case.initial_state]
        parameters = [mp.mpf(x.numerator) / x.denominator for x in case.parameter_values()]
        steps = [mp.mpf(case.fastest_time) / 10**k for k in (20, 22)]
        found = [residual(mp, form, mp.mpf(0), state, parameters, ORDER, h) for h in steps]
        assert abs(found[0] - found[1]) <= 1e-6 * found[0] + mp.mpf(10) ** -200


def error(name: str, variant: str | None, tolerance: float) -> tuple[float, float]:
    """Error and the case's conditioning."""
    case = registry.get(name, variant).rounded()
    return solved(Taylor(), case, tolerance).error, float(np.max(case.conditioning(case.times)))


@pytest.mark.parametrize(
    ("name", "variant"),
    [("pendulum_simple", None), ("kepler_orbit", None), ("damped_oscillator", None), ("projectile_parabola", None)],
)
def test_errors_fall_with_the_tolerance_to_the_conditioning(name: str, variant: str | None) -> None:
    errors = {tolerance: error(name, variant, tolerance) for tolerance in (1e-4, 1e-8, 1e-16)}
    # Local errors of a tolerance add up over some hundred steps, and grow with the motion's own conditioning.
    for tolerance, (found, attainable) in errors.items():
        assert found < 1e3 * tolerance + 10 * attainable


def test_a_start_at_a_pericentre_does_not_set_the_size_of_the_velocity() -> None:
    """e = 0.999: the acceleration there times a time scale is 5e4 times any velocity, and would allow as large an error."""
    found, attainable = error("kepler_orbit", "e0999", 1e-16)
    assert found < attainable


def test_order_follows_from_the_tolerance() -> None:
    assert [order_for(10.0**-k) for k in (3, 6, 9, 12, 16)] == [5, 8, 12, 15, 20]
    assert order_for(0.9) == 3, "of lower ones no second radius of convergence is left"


def angle(t: Any, state: Values, parameters: Values) -> Values:
    (x,) = state
    return (atan2(x, 2),)


def test_functions_without_a_recurrence_are_refused() -> None:
    with pytest.raises(Refused, match="atan2 has no recurrence"):
        Taylor().prepare(scalar(angle), 1e-9)


def test_the_polynomial_between_steps_is_as_good_as_the_step() -> None:
    """x' = x^2 from -1 is -1/(1 + t)."""
    problem = scalar(squared)
    found = Taylor().prepare(problem, 1e-15)(np.array([[-1.0]])).states[0, :, 0]
    assert np.max(np.abs(found * (1 + problem.times) + 1)) < 4 * np.finfo(float).eps


@pytest.mark.parametrize(("time_scale", "reach"), [(1.0, 1 / 3), (0.25, 0.25)])
def test_a_component_that_starts_at_zero_is_as_large_as_its_motion_within_reach(
    time_scale: float, reach: float
) -> None:
    """Two components start elsewhere, with radii of convergence of 1/3 and 1/2; the third has a speed of 5."""
    order, y, sizes = 12, np.array([4.0, -0.5, 0.0]), np.zeros(3)
    w = np.zeros(3 * STRIDE)
    w[order], w[STRIDE + order] = 4.0 * 3**order, 0.5 * 2**order
    w[2 * STRIDE + 1], w[2 * STRIDE + order] = -5.0, 1e9
    start_sizes(w, order, time_scale, y, sizes)
    assert sizes == pytest.approx([0, 0, 5 * reach])


def growing(t: Any, state: Values, parameters: Values) -> Values:
    return state


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-16])
def test_steps_are_those_of_jorba_and_zou(tolerance: float) -> None:
    """x' = x has the coefficients x/k!, so every step is the root of the smaller radius, over e^2 and their margin."""
    order = order_for(tolerance)
    radius = min(math.factorial(k) ** (1 / k) for k in (order - 1, order))
    h = radius * math.exp(-2 - 0.7 / (order - 1))
    span = 100.5 * h
    problem = Problem(FirstOrder(growing), 1, np.zeros(0), np.arange(1, 65) * (span / 64), 1.0)
    assert Taylor().prepare(problem, tolerance)(np.array([[1.0]])).steps == 101


def swinging(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    return v / 3, -3 * x


def driven(t: Any, state: Values, parameters: Values) -> Values:
    _, y = state
    return cos(t), y / 8


def derivatives_of_swinging(k: int, t: float) -> list[float]:
    """The derivatives of x = cos t and v = -3 sin t."""
    return [math.cos(t + k * math.pi / 2), 3 * math.cos(t + (k + 1) * math.pi / 2)]


def derivatives_of_driven(k: int, t: float) -> list[float]:
    """The derivatives of x = sin t and y = exp(t/8)."""
    return [math.sin(t + k * math.pi / 2), math.exp(t / 8) / 8**k]


@pytest.mark.parametrize("tolerance", [1e-4, 1e-9, 1e-16])
@pytest.mark.parametrize(
    ("equations", "derivatives"), [(swinging, derivatives_of_swinging), (driven, derivatives_of_driven)]
)
def test_the_remainder_is_relative_to_the_largest_size_of_each_component_so_far(
    equations: Any, derivatives: Any, tolerance: float
) -> None:
    """The same steps from known derivatives. A component that starts at zero first has the size of its change in 1/4 s."""
    order, span, scale = order_for(tolerance), 30.0, 0.25
    start = np.array(derivatives(0, 0.0))
    sizes = np.where(np.abs(start) > 1e-15, np.abs(start), scale * np.abs(derivatives(1, 0.0)))
    t, steps = 0.0, 0
    while t < span:
        sizes = np.maximum(sizes, np.abs(derivatives(0, t)))
        largest = {k: np.max(np.abs(derivatives(k, t)) / sizes) for k in (order - 1, order)}
        radius = min((math.factorial(k) / value) ** (1 / k) for k, value in largest.items())
        t, steps = t + radius * math.exp(-2 - 0.7 / (order - 1)), steps + 1
    problem = Problem(FirstOrder(equations), 2, np.zeros(0), np.arange(1, 65) * (span / 64), scale)
    assert Taylor().prepare(problem, tolerance)(np.where(np.abs(start) > 1e-15, start, 0.0)[None]).steps == steps

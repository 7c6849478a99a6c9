"""Gauss methods on stiff equations: Newton's iteration against Padé's approximants, the fixed point and exact motions."""

import math
from fractions import Fraction
from math import sin
from typing import Any

import mpmath
import numpy as np
import pytest
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.forms import FirstOrder, Form, SecondOrder, Values
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.integrators.base.fixed_step import FixedStep
from gnomon.harness.integrators.base.stepping import StepData
from gnomon.harness.integrators.gauss.gauss import (
    INTEGRATORS,
    STEPS_BACK,
    Gauss,
    Gauss2,
    Gauss4,
    ImplicitMidpoint,
    newton_rows,
)
from gnomon.harness.integrators.gauss.gauss_steps import newton_numbers, newton_step, start_stages
from gnomon.harness.studies.orders import solve_exactly
from gnomon.reference.numerics.precision import nearest_double, working
from on_cases import exact_states, solved

METHODS = [method for method in INTEGRATORS if issubclass(method, Gauss)]
TIMES = np.arange(1.0, 65.0)
ROUNDOFF = 2.0**-52


def decay(t: Any, state: Values, parameters: Values) -> Values:
    (x,) = state
    (rate,) = parameters
    return (-rate * x,)


def oscillate(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    (w,) = parameters
    return v, -w * w * x


def pull_back(t: Any, place: Values, parameters: Values) -> Values:
    (x,) = place
    (w,) = parameters
    return (-w * w * x,)


def problem(form: Form, dimension: int, *parameters: float, times: Any = TIMES) -> Problem:
    return Problem(form, dimension, np.array(parameters), times, 1.0)


def pade(stages: int, z: Any) -> Any:
    """The diagonal approximant of exp: the result of the method for y' = z y over a step of 1."""
    above, below = mpmath.mpf(0), mpmath.mpf(0)
    for j in range(stages + 1):
        c = Fraction(math.comb(stages, j), math.perm(2 * stages, j))
        above += z**j * c.numerator / c.denominator
        below += (-z) ** j * c.numerator / c.denominator
    return above / below


@pytest.mark.parametrize("rate", [1e3, 1e6, 1e12])
@pytest.mark.parametrize("method", METHODS)
def test_stiff_decay_follows_the_approximant_of_pade(method: type[Gauss], rate: float) -> None:
    """At 1e6 the midpoint rule gives (1 - 5e5)/(1 + 5e5), and so on 64 times."""
    solution = method().prepare(problem(FirstOrder(decay), 1, rate), 1.0)(np.array([[1.0]]))
    with mpmath.workdps(40):
        factor = pade(method.stages, -mpmath.mpf(rate))
        # The weights of the stages' increments add up to 9 in size with 8 stages; 64 steps walk.
        worst = max(abs(x / factor ** (k + 1) - 1) for k, x in enumerate(solution.states[0, :, 0]))
    assert worst < 10 * math.sqrt(64) * ROUNDOFF


@pytest.mark.parametrize("frequency", [1e4, 1e8])
@pytest.mark.parametrize(("form", "kind"), [(FirstOrder(oscillate), 1), (SecondOrder(pull_back), 2)])
@pytest.mark.parametrize("method", METHODS)
def test_stiff_oscillators_follow_it_and_keep_their_energy(
    method: type[Gauss], form: Form, kind: int, frequency: float
) -> None:
    solution = method().prepare(problem(form, 2, frequency), 1.0)(np.array([[1.0, frequency / 2]]))
    x, v = solution.states[0, :, 0], solution.states[0, :, 1] / frequency
    with mpmath.workdps(40):
        turn = pade(method.stages, mpmath.mpc(0, frequency))
        exact = np.array([complex(mpmath.mpc(1, -0.5) * turn ** (k + 1)) for k in range(64)])
    assert np.max(np.abs(x - 1j * v - exact)) < 10 * math.sqrt(64) * ROUNDOFF
    assert np.max(np.abs(x * x + v * v - 1.25)) < 10 * math.sqrt(64) * ROUNDOFF


def henon_heiles(t: Any, q: Values, parameters: Values) -> Values:
    """Two coupled degrees of freedom with a cubic potential, and its second derivatives row by row."""
    x, y = q
    return -x - 2 * x * y, -y - x * x + y * y, -1 - 2 * y, -2 * x, -2 * x, -1 + 2 * y


def henon_heiles_first_order(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    ax, ay, *rows = henon_heiles(t, (x, y), parameters)
    return vx, vy, ax, ay, 0, 0, 1, 0, 0, 0, 0, 1, *rows[:2], 0, 0, *rows[2:], 0, 0


class ByNewton(FixedStep):
    """Newton's step as a separate method, on equations with their derivatives, for any arithmetic."""

    def __init__(self, stages: int, width: int) -> None:
        self.stages, self.width = stages, width

    @classmethod
    def coefficients(cls, mp: Any) -> Any:
        raise NotImplementedError

    def table(self, mp: Any, form: Form, parameters: Any, roundoff: Any) -> Any:
        return newton_rows(mp, self.stages, isinstance(form, SecondOrder), roundoff)

    def step_for(self, form: Form) -> Any:
        return newton_step

    def widths(self, form: Form, dimension: int) -> tuple[int, int]:
        return self.width, self.width * (1 + self.width)

    def rows(self, form: Form) -> int:
        return newton_numbers(self.stages, self.width)


@pytest.mark.parametrize("form", [SecondOrder(henon_heiles), FirstOrder(henon_heiles_first_order)])
@pytest.mark.parametrize("method", [ImplicitMidpoint, Gauss2, Gauss4])
def test_newton_and_the_fixed_point_solve_the_same_equations(method: type[Gauss], form: Form) -> None:
    """In sixty digits: so both have the same properties (order, symplectic, reversible, invariants)."""
    start = (Fraction(3, 10), Fraction(-1, 5), Fraction(1, 4), Fraction(2, 5))
    width = 2 if isinstance(form, SecondOrder) else 4
    plain = FirstOrder(without_derivatives) if width == 4 else SecondOrder(acceleration)
    with working(60):
        newton = solve_exactly(ByNewton(method.stages, width), form, (), start, Fraction(1), 4)
        fixed_point = solve_exactly(method(), plain, (), start, Fraction(1), 4)
        assert max(abs(a - b) for a, b in zip(newton, fixed_point, strict=True)) < 1e-55


def without_derivatives(t: Any, state: Values, parameters: Values) -> Values:
    return henon_heiles_first_order(t, state, parameters)[:4]


def acceleration(t: Any, place: Values, parameters: Values) -> Values:
    return henon_heiles(t, place, parameters)[:2]


def drift(t: Any, state: Values, parameters: Values) -> Values:
    """x = t, y = t^2/2, and the derivatives."""
    x, _ = state
    return 1, x, 0, 0, 1, 0


def fall(t: Any, place: Values, parameters: Values) -> Values:
    """At a velocity of 1 and 0: x = t, y = t^3/6."""
    x, _ = place
    return 0, x, 0, 0, 1, 0


def drift_without_derivatives(t: Any, state: Values, parameters: Values) -> Values:
    return drift(t, state, parameters)[:2]


def fall_without_derivatives(t: Any, place: Values, parameters: Values) -> Values:
    return fall(t, place, parameters)[:2]


@pytest.mark.parametrize("newton", [True, False])
@pytest.mark.parametrize("second_order", [True, False])
@pytest.mark.parametrize("method", METHODS)
def test_the_rounding_residuals_of_coefficients_are_added(
    method: type[Gauss], second_order: bool, newton: bool
) -> None:
    """A step of 1 in sixty digits with the numbers of binary64. Without the residuals of weights, nodes or sums it errs by
    some 1e-17, the same in every step. Only y of second order keeps such an error: by moments of weights and nodes."""
    start = (0, 0, 1, 0) if second_order else (0, 0)
    width, kind = 2, SecondOrder if second_order else FirstOrder
    equations = (
        (fall if second_order else drift)
        if newton
        else (fall_without_derivatives if second_order else drift_without_derivatives)
    )
    form = kind(equations)
    stepping = ByNewton(method.stages, width) if newton else method()
    with working(60) as mp:
        rows = stepping.table(mp, form, (), mp.mpf(2) ** -52)
        table = np.full((len(rows), max(map(len, rows))), mp.mpf(0), dtype=object)
        for row, values in zip(table, rows, strict=True):
            row[: len(values)] = [mp.mpf(nearest_double(value)) for value in values]
        y = np.array([mp.mpf(x) for x in start], dtype=object)
        x, slope, increment, store = (
            np.full(shape, mp.mpf(0), dtype=object)
            for shape in (width, stepping.widths(form, len(y))[1], len(y), (stepping.rows(form), len(y)))
        )
        arithmetic = mpmath_arithmetic(mp)
        step, f = rebind(stepping.step_for(form), arithmetic), rebind(stepping.equations(form), arithmetic)
        assert step(StepData(f, y, (), table, x, slope, store, increment), mp.mpf(0), mp.mpf(1))
        exact = [1, mp.mpf(1) / 6, 0, mp.mpf(1) / 2] if second_order else [1, mp.mpf(1) / 2]
        # One stage has a weight of 1: it does not integrate t (1 - t), which is of degree 2.
        if second_order and method.stages == 1:
            exact[1] = mp.mpf(1) / 4
        off = [abs(a - b) for a, b in zip(increment, exact, strict=True)]
        rounded = [1, 3] if newton and second_order else [1] if newton or second_order else []
        # By Newton both parts of a coefficient have 42 + 53 bits, 2.5e-29; without the second one, 1e-13.
        assert all(error < (1e-15 if i in rounded else 1e-27) for i, error in enumerate(off))


@pytest.mark.parametrize("second_order", [True, False])
@pytest.mark.parametrize("method", METHODS)
def test_rounded_coefficients_are_exactly_symplectic(method: type[Gauss], second_order: bool) -> None:
    """In rational arithmetic, of the numbers in the table. Rounded one by one they are not, by some 1e-17, and the energy
    would drift as t: at steps of one radian by .01 units of round-off in each step."""
    s, form = range(method.stages), SecondOrder(pull_back) if second_order else FirstOrder(oscillate)
    with working(60) as mp:
        table = [[Fraction(nearest_double(x)) for x in row] for row in method().table(mp, form, (), mp.mpf(2) ** -52)]
        *stages, (_, *weights) = method.tableau(mp).rows(mp)
        nodes = [row[0] for row in stages]
    c, b = [row[0] for row in table[: len(s)]], table[2 * len(s)][1:]
    m = [row[1:] for row in table[: len(s)]]
    assert sum(b) == 1
    assert all(c[j] + c[-1 - j] == 1 and b[j] == b[-1 - j] for j in s)
    if second_order:
        assert table[-1][1:] == [1 - node for node in c]
    for i in s:
        for j in range(i):
            assert (m[i][j] - m[j][i] == c[i] - c[j]) if second_order else (m[i][j] + m[j][i] == 1)
        assert second_order or m[i][i] == Fraction(1, 2)
    assert all(abs(x - float(y)) < 2**-51 for x, y in zip([*c, *b], [*nodes, *weights], strict=True))


def tumble(t: Any, state: Values, parameters: Values) -> Values:
    """A free rigid body with moments 1, 2, 3."""
    a, b, c = state
    return -b * c, c * a, -a * b / 3


def tumble_back(t: Any, state: Values, parameters: Values) -> Values:
    a, b, c = tumble(t, state, parameters)
    return -a, -b, -c


@pytest.mark.parametrize("method", METHODS)
def test_newton_keeps_quadratic_invariants_and_returns(method: type[Gauss], newton_steps: list[int]) -> None:
    """A spin about the last axis turns the others by 10 rad a step, where no fixed point converges."""
    start = np.array([[0.01, 0.02, 10.0]])
    there = method().prepare(problem(FirstOrder(tumble), 3), 1.0)(start)
    back = method().prepare(problem(FirstOrder(tumble_back), 3), 1.0)(there.states[:, -1])
    assert newton_steps == [64, 64]
    a, b, c = there.states[0].T
    for moments in ((1, 2, 3), (1, 4, 9)):
        kept = moments[0] * a * a + moments[1] * b * b + moments[2] * c * c
        first = float(np.dot(moments, start[0] ** 2))
        assert np.max(np.abs(kept / first - 1)) < 10 * math.sqrt(64) * ROUNDOFF
    # An error in the last component rotates the others by as much in each step: 64^2/2 roundings of 10.
    assert np.max(np.abs(back.states[0, -1] - start[0])) < 64**2 * ROUNDOFF * 10


@pytest.fixture
def newton_steps(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The numbers of steps that the trajectories took by Newton's iteration."""
    found: list[int] = []
    by_newton = Gauss.by_newton

    def watched(self: Gauss, given: Problem, h: float, substeps: int) -> Any:
        run = by_newton(self, given, h, substeps)

        def counted(*arrays: Any) -> int:
            assert run is not None
            found.append(run(*arrays))
            return found[-1]

        return None if run is None else counted

    monkeypatch.setattr(Gauss, "by_newton", watched)
    return found


def test_nothing_is_differentiated_where_the_fixed_point_converges(newton_steps: list[int]) -> None:
    for name in ("pendulum_simple", "kepler_orbit"):
        solved(Gauss4(), get(name).rounded(), steps=16)
    assert newton_steps == []


@pytest.mark.parametrize("variant", ["stiff_1e6", "stiff_1e9", "stiff_1e12"])
@pytest.mark.parametrize("method", METHODS)
def test_the_slow_part_of_a_stiff_motion(method: type[Gauss], variant: str) -> None:
    """x'' + (r + 1) x' + r x = 0: x + x'/r decays as exp(-t), independent of the fast part, also in these methods.

    Two steps to a sample of 5/32 s: the method's approximant to round-off, the exact motion to the error of the order.
    """
    case = get("damped_oscillator", variant).rounded()
    found = solved(method(), case, steps=2)
    interval = found.problem.interval
    rate = float(case.parameters["k"])
    exact = exact_states(case)
    slow = found.states[:, 0] + found.states[:, 1] / rate
    with mpmath.workdps(40):
        factor = pade(method.stages, -mpmath.mpf(interval) / 2) ** 2
        expected = np.array([float(factor ** (k + 1)) for k in range(64)])
    assert np.max(np.abs(slow - expected)) < 4 * ROUNDOFF
    # R(z) - exp(z) begins with s!^2 z^(2s+1) / (2s)! (2s+1)!: that over h a unit of time, and t exp(-t) is 0.37 at most.
    s, h = method.stages, interval / 2
    leading = math.factorial(s) ** 2 / (math.factorial(2 * s) * math.factorial(2 * s + 1))
    error = np.max(np.abs(slow - (exact[:, 0] + exact[:, 1] / rate)))
    assert error < 0.4 * leading * h ** (2 * s) + 4 * ROUNDOFF
    assert s > 3 or error > 0.3 * leading * h ** (2 * s), "the sampled maximum"


def test_small_vibrations_with_a_coupling_of_1e12() -> None:
    """Second-order form, frequencies 1e6 apart: the fast mode starts at rest, and the error falls with the order."""
    case = get("small_vibrations_mdof", "stiff_1e12").rounded()
    found = [solved(Gauss2(), case, steps=count) for count in (4, 8, 16)]
    assert isinstance(found[0].problem.form, SecondOrder)
    errors = [one.error for one in found]
    # The fast mode that rounding the initial state excites, 3e-7, is 4 % of the last error.
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(16, rel=0.1)


def decay_above_0(t: Any, state: Values, parameters: Values) -> Values:
    (x,) = state
    return (-100000000 * x if x > 0 else 0,)


@pytest.mark.parametrize("method", METHODS)
def test_without_a_jacobian_the_failure_is_clear(method: type[Gauss]) -> None:
    solution = method().prepare(problem(FirstOrder(decay_above_0), 1), 1.0)(np.array([[1.0]]))
    assert solution.stopped == "the stages of a step did not converge before sample 1; take shorter steps"
    assert np.all(np.isnan(solution.states))


def test_the_first_trajectory_that_newton_cannot_do_either_is_named() -> None:
    solution = Gauss4().prepare(problem(FirstOrder(decay), 1, 1e6), 1.0)(np.array([[1.0], [math.nan], [math.nan]]))
    assert "did not converge before sample 1 of trajectory 2;" in str(solution.stopped)
    assert np.all(np.isfinite(solution.states), axis=(1, 2)).tolist() == [True, False, False]
    assert solution.steps == 64


def roll_off(t: Any, state: Values, parameters: Values) -> Values:
    """From the top at 0 to the bottom at pi, which no motion leaves."""
    (x,) = state
    (rate,) = parameters
    return (rate * sin(x),)


@pytest.mark.parametrize(("method", "rate", "start"), [(Gauss2, 8.0, 0.62), (Gauss4, 12.0, 0.21)])
def test_the_stages_of_another_solution_are_refused(method: type[Gauss], rate: float, start: float) -> None:
    """Newton's iteration, left to go on, converges to stages that lead across the top, to -3.04 and -2.80."""
    solution = method().prepare(problem(FirstOrder(roll_off), 1, rate), 1.0)(np.array([[start]]))
    assert solution.stopped == "the stages of a step did not converge before sample 1; take shorter steps"


def test_the_second_change_may_be_large() -> None:
    solution = Gauss4().prepare(problem(FirstOrder(roll_off), 1, 8.0), 1.0)(np.array([[1.89]]))
    assert solution.states[0, 0, 0] == pytest.approx(math.pi, abs=0.02), "a step of eight times the fall"


def decay_ever_faster(t: Any, state: Values, parameters: Values) -> Values:
    (x,) = state
    return (-t * x,)


def test_a_trajectory_that_becomes_stiff_is_integrated_again_from_its_start(newton_steps: list[int]) -> None:
    solution = Gauss4().prepare(problem(FirstOrder(decay_ever_faster), 1), 1.0)(np.array([[1.0]]))
    assert newton_steps == [64]
    assert (solution.stopped, np.all(np.isfinite(solution.states))) == (None, True)
    # Order 8: f^(8) is up to 1e3, times 4!^4 / (8!^3 9) = 6e-10, and stages add a few of these.
    assert solution.states[0, 0, 0] == pytest.approx(math.exp(-0.5), rel=1e-5)


def relax(t: Any, state: Values, parameters: Values) -> Values:
    """Stiff far from the origin: at a rate of 3 x^2."""
    (x,) = state
    return (-x * x * x,)


def test_a_trajectory_is_the_same_alone_in_any_company_and_again(newton_steps: list[int]) -> None:
    solve = Gauss4().prepare(problem(FirstOrder(relax), 1), 1.0)
    start = np.array([[0.1], [5.0], [0.2], [4.0]])
    together = solve(start)
    assert len(newton_steps) == 2, "two are stiff"
    assert together.stopped is None
    assert np.array_equal(together.states, solve(start).states)
    for k in range(4):
        assert np.array_equal(together.states[k], solve(start[k : k + 1]).states[0])


def settle_down(t: Any, state: Values, parameters: Values) -> Values:
    (x,) = state
    return (1000000 * (1 - x * x),)


def test_a_first_step_that_hardly_moves_is_iterated_like_any_other() -> None:
    """From 1 + d Newton's first change is 2 d, its error then d^2: 6e-14. The midpoint u solves a u^2 + u = x + a."""
    start = 1 + 2.0**-22
    solution = ImplicitMidpoint().prepare(problem(FirstOrder(settle_down), 1), 1.0)(np.array([[start]]))
    with mpmath.workdps(40):
        x, a = mpmath.mpf(start), mpmath.mpf(500000)
        for found in solution.states[0, :, 0]:
            x = (mpmath.sqrt(1 + 4 * a * (x + a)) - 1) / a - x
            # A rounding of u is doubled and comes back with the other sign in the next step: 64 of them walk.
            assert abs(found - x) < 2 * math.sqrt(64) * ROUNDOFF


def grow(t: Any, state: Values, parameters: Values) -> Values:
    (x,) = state
    return (x * x,)


def test_a_step_that_has_no_solution_ends_its_trajectory_alone() -> None:
    """The midpoint rule's x + u^2 with u = x + u^2/2 has none from x = 10; from -1 on the nearer root is 1 - sqrt(1 - 2 x)."""
    solution = ImplicitMidpoint().prepare(problem(FirstOrder(grow), 1), 1.0)(np.array([[-1.0], [10.0]]))
    assert (
        solution.stopped == "the stages of a step did not converge before sample 1 of trajectory 2; take shorter steps"
    )
    assert np.all(np.isnan(solution.states[1]))
    x = -1.0
    for found in solution.states[0, :, 0]:
        x += (1 - math.sqrt(1 - 2 * x)) ** 2
        # Each step errs by some 2^-53 of its x: x falls as 1 / (1 + t), and earlier errors fall as its square.
        assert found == pytest.approx(x, rel=64 * ROUNDOFF)


def test_right_hand_sides_are_counted_and_a_linear_step_takes_few() -> None:
    """The factors are kept: two or three rounds a step, the last of which changes only round-off."""
    case = get("damped_oscillator", "stiff_1e6").rounded()
    found = solved(Gauss4(), case, steps=1, counted=True)
    assert found.steps == 64
    rounds = found.calls / (4 * 64)
    assert 2 <= rounds < 3, "with the rounds of the fixed point before it gave up"


@pytest.mark.parametrize("second_order", [True, False])
@pytest.mark.parametrize("method", METHODS)
def test_the_iteration_starts_from_a_polynomial_of_the_last_steps(method: type[Gauss], second_order: bool) -> None:
    """Slopes that are a polynomial of lower degree than the number of kept slopes are then extrapolated exactly; the slopes
    of the last step, or the slopes of its start, would cost several more rounds in each step."""
    form = SecondOrder(pull_back) if second_order else FirstOrder(oscillate)
    stages, steps = method.stages, STEPS_BACK.get(method.stages, 1)
    table = method().binary64(form, (), 1.0)
    c, b, count = table[:stages, 0], table[2 * stages, 1 : stages + 1], steps * stages
    assert method().rows(form) == 1 + stages + count
    times = np.concatenate([c - back for back in range(-1, steps)])
    slopes = np.tile(b, steps + 1) * np.polyval(np.arange(count, 0, -1), times)
    store = np.concatenate([[0.1], slopes[stages:], np.full(stages, np.nan)])[:, np.newaxis]
    start_stages(StepData(None, np.zeros(1), (), table, np.zeros(1), None, store, None), 0.0, stages)
    # The weights of an extrapolation by a whole step are up to 1e6 with 8 stages.
    np.testing.assert_allclose(store[1 : stages + 1, 0], slopes[:stages], rtol=1e-8)
    np.testing.assert_array_equal(store[stages + 1 :, 0], slopes[stages:])

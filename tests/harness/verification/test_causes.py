"""A planted mistake is named with the error that is left; the plain error of a right method has no cause."""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case, get
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.verification.causes import NEAR, Cause, causes, name_low_order
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

States = Callable[[Case], Floats]
"""The states of a program with a mistake, at the sample times of a case."""
SWING, TOP, THROW, ARM, CHARGE = (
    "pendulum_simple", "euler_top", "projectile_parabola", "rotation_fixed_axis_compound_pendulum", "charge_in_E_and_B",
)  # fmt: skip


@cache
def case_of(name: str) -> Case:
    return get(name).rounded()


def right(case: Case) -> Floats:
    return case.sample(case.times)


def after(change: Callable[[Floats], Floats]) -> States:
    return lambda case: change(right(case))


def at(times: Callable[[Floats], Floats]) -> States:
    return lambda case: case.sample(times(case.times))


def with_numbers(**numbers: float) -> States:
    return lambda case: get(case.name, span=float(case.span), **numbers).sample(case.times)  # type: ignore[arg-type]


def equations_of(case: Case, **numbers: float) -> Callable[[float, Floats], Floats]:
    form = next(form for form in case.all_forms() if isinstance(form, FirstOrder))
    values = tuple((({name: float(x) for name, x in case.parameters.items()}) | numbers).values())
    return lambda t, y: np.array(form.equations(t, tuple(y.tolist()), values), dtype=float)


def solved(damping: float = 0.0, **numbers: float) -> States:
    """Another motion, by SciPy, whose parameters the case may refuse."""

    def states(case: Case) -> Floats:
        rates, half = equations_of(case, **numbers), len(case.state) // 2
        start = [float(x) for x in case.initial_state]

        def damped(t: float, y: Floats) -> Floats:
            return rates(t, y) - damping * np.where(np.arange(len(y)) < half, 0.0, y)

        found = solve_ivp(damped, (0, float(case.times[-1])), start, "DOP853", case.times, rtol=1e-9, atol=1e-12)
        return np.array(found.y.T)

    return states


def turned(change: Callable[[Any, Floats], tuple[Any, Floats]]) -> States:
    """A top whose attitude (a Rotation) and angular velocity along its axes are changed."""

    def states(case: Case) -> Floats:
        exact = right(case)
        attitude, spin = change(Rotation.from_matrix(exact[:, 3:].reshape(-1, 3, 3)), exact[:, :3])
        return np.concatenate([spin, attitude.as_matrix().reshape(-1, 9)], axis=1)

    return states


def taken_as(order: Callable[[Floats], Floats]) -> States:
    """A top whose quaternions x, y, z, w are read in another way."""
    return turned(lambda attitude, spin: (Rotation.from_quat(order(attitude.as_quat())), spin))


def late(states: Floats) -> Floats:
    return np.concatenate([[[2.0, 0.0]], states[:-1]])


Y_UP = Rotation.from_matrix([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
"""From a frame whose z axis is up to one whose y axis is up."""
PLANTED: dict[str, tuple[str, States, str, str]] = {
    "degrees": (SWING, after(lambda y: y * 180 / math.pi), "factor", "theta, omega: degrees"),
    "an angle in degrees": (SWING, after(lambda y: y * [180 / math.pi, 1]), "factor", "theta: degrees"),
    "kilometres": (THROW, after(lambda y: y / [1000, 1000, 1, 1]), "factor", "x, y: a factor 1/1000"),
    "a minus": (THROW, after(lambda y: y * [1, -1, 1, -1]), "factor", "y, vy: the other sign"),
    "turns a second": (SWING, after(lambda y: y / [1, 2 * math.pi]), "factor", "omega: a factor 1/(2 pi)"),
    "another factor": (SWING, after(lambda y: y * [1, 1.3]), "factor", "omega 1.3"),
    "velocities first": (SWING, after(lambda y: y[:, ::-1]), "order", "velocities stand before"),
    "velocities beside": (THROW, after(lambda y: y[:, [0, 2, 1, 3]]), "order", "beside its position"),
    "velocities first, in degrees": (
        SWING, after(lambda y: y[:, ::-1] * 180 / math.pi), "order", "theta, omega: degrees"),
    "exchanged axes": (THROW, after(lambda y: y[:, [1, 0, 3, 2]]), "order", "y, x, vy, vx"),
    "another origin": (SWING, after(lambda y: y - [math.pi, 0]), "offset", "theta -3.14159"),
    "a sample late": (SWING, after(late), "shift", "t - a sample"),
    "a sample early": (SWING, at(lambda t: t + t[0]), "shift", "t + a sample"),
    "milliseconds": (SWING, at(lambda t: t / 1000), "time", "in ms"),
    "another period": (SWING, at(lambda t: t / 1.2), "period", "1.2 times"),
    "9.8": (SWING, with_numbers(g=9.8), "parameter", "g is 9.8,"),
    "gravity upwards": (THROW, solved(g=-9.81), "parameter", "g is -9.81"),
    "a diameter": (SWING, with_numbers(L=2), "parameter", "L is 2"),
    "exchanged masses": ("atwood_pulley_systems", solved(m1=1.5, m2=2), "exchanged", "m1 and m2"),
    "exchanged moments": (TOP, with_numbers(I1=3, I2=2), "exchanged", "I1 and I2"),
    "inertia about the centre": (ARM, solved(I=0.1), "inertia", "another point"),
    "degrees at the start": (SWING, with_numbers(theta=2 * math.pi / 180), "start", "angles at the start"),
    "damping": (SWING, solved(damping=0.02), "damping", "-0.02/s"),
    "w, x, y, z": (TOP, taken_as(lambda q: np.roll(q, 1, axis=1)), "convention", "w, x, y, z"),
    "a conjugate": (TOP, taken_as(lambda q: q * [-1, -1, -1, 1]), "convention", "conjugate"),
    "rates in space": (TOP, turned(lambda turn, w: (turn, turn.apply(w))), "convention", "is in space"),
    "y up": (TOP, turned(lambda turn, w: (Y_UP * turn, w)), "axes", "y axis is up"),
    "axes of the body": (TOP, turned(lambda turn, w: (turn * Y_UP.inv(), Y_UP.apply(w))), "axes", "axes of the body"),
    "y up of a charge": (
        CHARGE, after(lambda y: np.concatenate([Y_UP.apply(y[:, :3]), Y_UP.apply(y[:, 3:])], axis=1)), "o", "z, -y"),
}  # fmt: skip
"""Case, states, kind of the cause (its beginning), and a part of its text that says what to change."""


@pytest.mark.parametrize("mistake", PLANTED)
def test_a_planted_mistake_is_named(mistake: str) -> None:
    name, states, kind, part = PLANTED[mistake]
    case = case_of(name)
    found = causes(case, case.times, states(case))
    assert [each for each in found if each.kind.startswith(kind) and part in each.text], list(map(str, found))
    assert all(each.left < NEAR * each.error for each in found)


def test_velocities_between_steps_fit_a_shift_by_half_a_step() -> None:
    case = case_of(SWING)
    states = np.stack([right(case)[:, 0], case.sample(case.times + 0.01)[:, 1]], axis=1)
    (found,) = causes(case, case.times, states, {"h": 0.02, "h / 2": 0.01})
    assert found.kind == "shift"
    assert "velocities" in found.text
    assert "t + h / 2" in found.text
    assert not causes(case, case.times, states, own_equations=False)


def euler(f: Any, t: float, y: Floats, h: float) -> Floats:
    return np.asarray(y + h * f(t, y))


def heun(f: Any, t: float, y: Floats, h: float) -> Floats:
    a = f(t, y)
    return np.asarray(y + h / 2 * (a + f(t + h, y + h * a)))


def rk4(f: Any, t: float, y: Floats, h: float) -> Floats:
    a = f(t, y)
    b = f(t + h / 2, y + h / 2 * a)
    c = f(t + h / 2, y + h / 2 * b)
    return np.asarray(y + h / 6 * (a + 2 * b + 2 * c + f(t + h, y + h * c)))


def midpoint(f: Any, t: float, y: Floats, h: float) -> Floats:
    """The implicit midpoint rule."""
    after = y
    for _ in range(40):
        after = y + h * f(t + h / 2, (y + after) / 2)
    return np.asarray(after)


def kick(f: Any, t: float, y: Floats, h: float) -> Floats:
    """Symplectic Euler."""
    n = len(y) // 2
    v = y[n:] + h * f(t, y)[n:]
    return np.concatenate([y[:n] + h * v, v])


def verlet(f: Any, t: float, y: Floats, h: float) -> Floats:
    n = len(y) // 2
    v = y[n:] + h / 2 * f(t, y)[n:]
    q = y[:n] + h * v
    return np.concatenate([q, v + h / 2 * f(t + h, np.concatenate([q, v]))[n:]])


RIGHT = [
    *((SWING, method, 4) for method in (euler, heun, rk4, midpoint, kick, verlet)),
    *(("harmonic_oscillator", method, steps) for method in (midpoint, kick, verlet, rk4) for steps in (2, 8)),
    *(("damped_oscillator", method, 4) for method in (euler, heun, rk4, midpoint)),
    *((THROW, method, 2) for method in (euler, kick)),
    (TOP, rk4, 2),
]


@pytest.mark.parametrize(("name", "method", "steps"), RIGHT)
def test_the_error_of_a_right_method_has_no_cause(name: str, method: Any, steps: int) -> None:
    """Methods of orders 1, 2 and 4, dissipative and symplectic, with 2 to 8 steps a sample: errors of 1e-5 to 1."""
    case = case_of(name)
    rates, t, y, states = equations_of(case), 0.0, np.array([float(x) for x in case.initial_state]), []
    for end in case.times.tolist():
        h = (end - t) / steps
        for k in range(steps):
            y = method(rates, t + k * h, y, h)
        t = end
        states.append(y)
    error = float(np.max(case.metric.distance(np.array(states), right(case))))
    assert error > 1e-8
    assert not causes(case, case.times, np.array(states))


def test_right_states_and_states_that_are_not_numbers_have_no_cause() -> None:
    case = case_of(SWING)
    assert not causes(case, case.times, right(case))
    assert not causes(case, case.times, np.full((64, 2), math.nan))
    assert not causes(case, case.times, np.zeros((64, 2)))


def test_random_states_have_no_cause() -> None:
    case = case_of(SWING)
    assert not causes(case, case.times, np.random.default_rng(1).normal(size=(64, 2)))


def test_an_order_that_is_lower_than_declared_is_named() -> None:
    """What would be left is the error that the declared order gives at the finest step."""
    assert name_low_order([(0.1, 1e-3), (0.05, 2.5e-4)], 2) is None
    found = name_low_order([(0.1, 1e-3), (0.05, 5e-4)], 4)
    assert found == Cause("order", found.text if found else "", 1e-3 / 16, 5e-4)
    assert "order 1.0 where 4" in found.text

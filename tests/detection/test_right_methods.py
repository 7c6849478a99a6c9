"""The methods that are taken for right have the order that they declare, forward and backward, by no claim of gnomon.

Each solves equations whose solution was chosen: y' = g'(t) + N(y) - N(g(t)) has the solution g, whatever N is.
"""

import math
from typing import Any

import numpy as np
import pytest
from families import FreeBodies, frame
from family_faults import FAMILIES, family_right
from gnomon.cases import get
from gnomon.cases.core.forms import FirstOrder, Hybrid, Mode, SecondOrder, SemiLinear, Transition
from gnomon.cases.core.scene import Body, Contact, Scene
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Tolerance, solver_of
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.verification.claims import DEPTHS, Outcome
from gnomon.harness.verification.function_adapter import FunctionAdapter, Stepped, right_hand_side
from gnomon.harness.verification.verify import CLAIMS
from scipy.integrate import solve_ivp

RIGHT = family_right()
LEAST, MOST = 1e-12, 1e-2
"""Errors that are well above round-off, and small enough for the leading term."""
calls = 0


def chosen(t: Any) -> tuple[Any, Any]:
    return 1 / (1 + t), t / (2 + t * t)


def change(t: Any) -> tuple[Any, Any]:
    return -1 / (1 + t) ** 2, (2 - t * t) / (2 + t * t) ** 2


def second_change(t: Any) -> tuple[Any, Any]:
    return 2 / (1 + t) ** 3, 2 * t * (t * t - 6) / (2 + t * t) ** 3


def coupled(x: Any, y: Any) -> tuple[Any, Any]:
    return 2 * x * y - y, x - 3 * x * y * y


def equations(t: Any, state: Any, parameters: Any = ()) -> tuple[Any, Any]:
    global calls
    calls += 1
    ours, theirs = coupled(*state), coupled(*chosen(t))
    return tuple(c + a - b for c, a, b in zip(change(t), ours, theirs, strict=True))  # type: ignore[return-value]


def force(t: Any, place: Any, parameters: Any) -> tuple[Any, Any]:
    global calls
    calls += 1
    ours, theirs = coupled(*place), coupled(*chosen(t))
    return tuple(c + a - b for c, a, b in zip(second_change(t), ours, theirs, strict=True))  # type: ignore[return-value]


LINEAR = (-1.0, 2.0, -2.0, 0.5)


def rest(t: Any, state: Any, parameters: Any) -> tuple[Any, Any]:
    x, y = equations(t, state)
    return x - LINEAR[0] * state[0] - LINEAR[1] * state[1], y - LINEAR[2] * state[0] - LINEAR[3] * state[1]


WALL = 0.2
HALF = math.acos(WALL)
"""A quarter oscillation that a wall at x = 0.2 ends: from rest at x = 1 the motion has the period 2 HALF."""
OSCILLATOR = Hybrid(
    modes=(Mode("swings", lambda t, y, p: (y[1], -y[0])),),
    start=lambda t, y, p: "swings",
    transitions=(
        Transition("hits", "swings", lambda t, y, p: (y[0] - WALL,), -1, lambda t, y, p: (y[0], -y[1]), "swings"),
    ),
)


def bounced(t: float) -> tuple[float, float]:
    rest = t % (2 * HALF)
    return (math.cos(rest), -math.sin(rest)) if rest < HALF else (math.cos(2 * HALF - rest), math.sin(2 * HALF - rest))


def problem_of(integrator: Integrator, t0: float, t1: float) -> tuple[Problem, np.ndarray, np.ndarray]:
    """(problem, start, exact states) of the equations that an integrator takes."""
    times = t0 + (t1 - t0) * np.arange(1, 5) / 4
    form: Any = FirstOrder(equations)
    exact = np.array([chosen(t) for t in (t0, *times)])
    if Hybrid in integrator.accepts:
        form, exact = OSCILLATOR, np.array([bounced(t) for t in (t0, *times)])
    elif SemiLinear in integrator.accepts:
        form = SemiLinear(equations, linear=lambda p: LINEAR, rest=rest)
    elif SecondOrder in integrator.accepts:
        form, exact = SecondOrder(force), np.array([[*chosen(t), *change(t)] for t in (t0, *times)])
    return Problem(form, exact.shape[1], np.empty(0), times, abs(t1 - t0), t0=t0), exact[0], exact[1:]


def states_of(integrator: Integrator, problem: Problem, setting: float, start: np.ndarray) -> np.ndarray:
    """The states of a function without the adapter's limits of settings, of other integrators by their solver."""
    function = getattr(type(integrator), "function", None)
    if isinstance(integrator, Stepped):
        f, y, t, found = right_hand_side(problem), start, problem.t0, []
        for end in problem.times:
            count = max(1, math.ceil(abs(end - t) / setting - 1e-9))
            for k in range(count):
                y = function(f, t + k * (end - t) / count, y, (end - t) / count)
            t = end
            found.append(y)
        return np.array(found)
    if isinstance(integrator, FunctionAdapter):
        return np.asarray(function(right_hand_side(problem), problem.t0, start, problem.times, setting))
    if function is not None:
        return np.asarray(function(problem.form, (), problem.t0, start, problem.times, setting)[0])
    return solver_of(integrator, problem, setting)(start[None]).states[0]


def points(integrator: Integrator, t0: float, t1: float) -> np.ndarray:
    """(log of steps or calls, log of the error) at finer and finer settings, until the slopes of neighbours agree."""
    global calls
    problem, start, exact = problem_of(integrator, t0, t1)
    settings, found = 2.0 ** -np.arange(10), []
    if isinstance(integrator.sweep, Tolerance):
        settings = np.geomspace(1e-3, 10.0 ** -min(10, 3 * integrator.order), 6)
    for setting in settings:
        calls = 0
        try:
            error = np.max(np.abs(states_of(integrator, problem, setting, start) - exact))
        except Refused:  # an iteration may not converge for long steps
            continue
        if LEAST < error < MOST:
            work = calls if isinstance(integrator.sweep, Tolerance) else 1 / setting
            found.append((math.log(work), math.log(error)))
        steep = np.diff(found, axis=0)[-2:] if len(found) > 2 else []
        if error < LEAST or (settings[1] == 0.5 and len(steep) and abs(np.diff(steep[:, 1] / steep[:, 0])[0]) < 0.2):
            break
    return np.array(found)


@pytest.mark.parametrize("name", [method.name for method in FAMILIES if method.name != "FreeBodies"])
def test_a_right_method_has_its_order_forward_and_backward(name: str) -> None:
    integrator = RIGHT[name]
    assert integrator.order is not None
    order = min(integrator.order, (integrator.dense_order or 99) + 1)
    for t0, t1 in [(0.0, 6.0)] if Hybrid in integrator.accepts else [(0.3, 4.3), (4.3, 0.3)]:
        found = points(integrator, t0, t1)
        assert len(found) >= 3, f"too few errors above round-off: {found}"
        by_tolerance = isinstance(integrator.sweep, Tolerance)
        slope = -np.polyfit(*(found if by_tolerance else found[-3:]).T, 1)[0]
        # With a tolerance few steps grow to more of them: the line is rough, and may be too steep.
        assert order - 0.5 < slope < (math.inf if by_tolerance else order + 0.8), f"{slope} from {t0}: {np.exp(found)}"


MOMENTS, SPIN = np.array([1.0, 2.0, 3.0]), np.array([0.3, 1.0, 0.2])


def euler(t: float, y: np.ndarray) -> np.ndarray:
    """Of the angular velocity in the body's axes, and of the columns of its rotation."""
    spin, rows = y[:3], y[3:].reshape(3, 3)
    return np.concatenate([np.cross(MOMENTS * spin, spin) / MOMENTS, np.cross(rows, spin).ravel()])


def test_the_engine_has_order_2_and_keeps_the_energy() -> None:
    """Against SciPy's solution of Euler's equations; a row of the rotation is an axis of space in the body's axes."""
    exact = solve_ivp(euler, (0, 4), [*SPIN, *np.eye(3).ravel()], "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    expected, errors = exact[3:].reshape(3, 3) @ exact[:3], []
    for count in (40, 80):
        engine = FreeBodies()
        engine.load(Scene((0, 0, 0), (Body("top", 1.0, (1.0, 2.0, 3.0), angular_velocity=(0.3, 1.0, 0.2)),)))
        for _ in range(count):
            engine.step(4 / count)
        _, quaternion, _, spin = engine.read().bodies["top"]
        inside = frame(quaternion).T @ spin
        errors.append(np.max(np.abs(spin - expected)))
        assert inside @ (MOMENTS * inside) == pytest.approx(SPIN @ (MOMENTS * SPIN), rel=1e-13 * count)
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.2)


@pytest.mark.parametrize("e", [0.5, 1.0])
def test_a_ball_of_the_engine_bounces_as_high_as_the_restitution_says(e: float) -> None:
    """Each rebound has e^2 of the height before; in all steps the ball is above the plane."""
    engine = FreeBodies()
    ball = Body("ball", 1.0, (0.0, 0.0, 0.0), (0.0, 0.0, 1.1), radius=0.1)
    engine.load(Scene((0, 0, -9.81), (ball,), contacts=(Contact("ball", (0, 0, 1), e),)))
    fall = math.sqrt(2 / 9.81)
    energies = []
    for _ in range(round(20 / 0.01)):
        engine.step(0.01)
        place, _, velocity, _ = engine.read().bodies["ball"]
        assert place[2] >= 0.1 - 1e-12
        energies.append(9.81 * (place[2] - 0.1) + velocity[2] ** 2 / 2)
    bounces, time = 0, fall
    for k, energy in enumerate(energies, 1):
        while 0.01 * k > time + 1e-9 and bounces < 20:
            bounces, time = bounces + 1, time + 2 * fall * e ** (bounces + 1)
        if bounces < 20 and abs(0.01 * k - time) > 1e-6:
            assert energy == pytest.approx(9.81 * e ** (2 * bounces), rel=1e-9)
    assert e == 1 or energies[-1] < 1e-9


def test_velocities_of_an_interpolant_round_as_positions_over_a_step() -> None:
    """At 5e-8 s this is 1e-9, and grows as steps become shorter."""
    trials = Trials.of(RIGHT["adaptive_verlet"], CaseSpec.of(get("pendulum_simple").rounded()), DEPTHS["low"])
    assert CLAIMS["step_order"].check(trials).outcome == Outcome.PASSED

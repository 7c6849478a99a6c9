"""SciPy's methods on the simple pendulum: they converge, count correctly and report failures."""

from dataclasses import replace
from math import log, sin
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, Hybrid, Values
from gnomon.cases.core.registry import get
from gnomon.harness.adapters import scipy_events, scipy_ivp, scipy_ode, scipy_odeint
from gnomon.harness.adapters.scipy_events import PROBE, Guard, set_latch
from gnomon.harness.contract.integrator import Integrator, Problem, Refused
from gnomon.harness.contract.problem import counting, initial_state, problem_of
from on_cases import count_python_calls, exact_states, solved
from scipy.integrate import _odepack_py, ode, odeint, solve_ivp
from scipy.integrate._ivp.ivp import METHODS

ALL = (*scipy_ivp.INTEGRATORS, *scipy_ode.INTEGRATORS, *scipy_odeint.INTEGRATORS)
every = pytest.mark.parametrize("integrator", ALL, ids=lambda kind: kind.name)
ENDING = tuple(kind for kind in ALL if kind is not scipy_ode.Adams)
ending = pytest.mark.parametrize("integrator", ENDING, ids=lambda kind: kind.name)
"""VODE halves its step without end where values are not finite: the time limit of the trial ends it."""
explicit = pytest.mark.parametrize("integrator", [scipy_ivp.RK45, scipy_ivp.DOP853], ids=lambda kind: kind.name)

CASE = get("pendulum_simple").rounded()
PROBLEM = problem_of(CASE, (FirstOrder,))
START = initial_state(CASE)[None]


def linear(t: Any, state: Values, parameters: Values) -> Values:
    """x'' = -k x."""
    x, v = state
    (k,) = parameters
    return v, -k * x


def hopeless(t: Any, state: Values, parameters: Values) -> Values:
    """Not finite from time 0.5 on, the start included where x starts below zero."""
    x, v = state
    (k,) = parameters
    return v, log(1 - 2 * t) - k * sin(x) + 0 * log(x)


def toy(equations: Any, counted: bool = False) -> Problem:
    times = np.arange(1, 65) / 16
    return Problem(FirstOrder(equations), 2, np.array([1.0]), times, 1.0, counted)


@every
def test_converges_to_the_exact_motion(integrator: type[Integrator]) -> None:
    """1e3 steps (LSODA), each allowed rtol of a state of size 6: at most about 1e4 rtol. BDF, of order 5, takes 1e5."""
    exact = exact_states(CASE)
    errors = []
    for rtol in (1e-4, 1e-7, 1e-10):
        states = integrator().prepare(PROBLEM, rtol)(START).states[0]
        errors.append(float(np.abs(states - exact).max()))
    assert errors[0] > 10 * errors[1] > 100 * errors[2]
    assert errors[2] < (1e6 if integrator is scipy_ivp.BDF else 1e4) * 1e-10


@every
def test_many_trajectories_are_solved_one_by_one(integrator: type[Integrator]) -> None:
    starts = np.array([[0.1, 0.0], [2.0, 0.0], [0.5, 7.0]])
    solve = integrator().prepare(PROBLEM, 1e-6)
    together = solve(starts)
    assert together.states.shape == (3, 64, 2)
    for start, states in zip(starts, together.states, strict=True):
        assert np.array_equal(solve(start[None]).states[0], states)
    assert np.array_equal(starts, [[0.1, 0.0], [2.0, 0.0], [0.5, 7.0]])


@pytest.mark.parametrize("integrator", scipy_ivp.INTEGRATORS, ids=lambda kind: kind.name)
def test_counts_equal_scipys_own(integrator: type[scipy_ivp.SolveIvp]) -> None:
    problem = toy(linear, counted=True)
    integrator().prepare(problem, 1e-6)(np.array([[1.0, 0.0]]))
    options = {"jac": lambda t, y: np.array([[0.0, 1.0], [-1.0, 0.0]])} if integrator.takes_jacobian else {}
    own = solve_ivp(
        lambda t, y: np.array([y[1], -y[0]]),
        (0, problem.times[-1]),
        [1.0, 0.0],
        integrator.method,
        problem.times,
        rtol=1e-6,
        atol=1e-9,
        **options,
    )
    assert problem.buffer[-1] == own.nfev > 0


IMPLICIT = (scipy_ivp.Radau, scipy_ivp.BDF, scipy_ivp.LSODA, scipy_odeint.Odeint)


def stiff(t: Any, state: Values, parameters: Values) -> Values:
    """x relaxes to sin v a thousand times faster than v changes."""
    x, v = state
    (k,) = parameters
    return -1000 * k * (x - sin(v)), k


def stiff_opaque(t: Any, state: Values, parameters: Values) -> Values:
    """The stiff equations above, with a function that has no expression."""
    x, v = state
    (k,) = parameters
    return -1000 * k * (x - sin(v)), k + 0 * abs(x)


@pytest.mark.parametrize("integrator", IMPLICIT, ids=lambda kind: kind.name)
def test_implicit_methods_get_the_compiled_jacobian(integrator: type[Integrator]) -> None:
    """It saves the right-hand sides of finite differences, one for each variable."""
    with_jacobian, without = toy(stiff, counted=True), toy(stiff_opaque, counted=True)
    for problem, said in ((with_jacobian, "compiled"), (without, None)):
        solve = integrator().prepare(problem, 1e-6)
        states = solve(np.array([[0.0, 0.0]])).states[0]
        assert states[:, 0] == pytest.approx(np.sin(problem.times), abs=2e-3)
        options = solve.options
        assert options["Dfun" if integrator is scipy_odeint.Odeint else "jac"] == said
    assert with_jacobian.buffer[-1] < without.buffer[-1]


def test_methods_without_equations_to_solve_get_no_jacobian() -> None:
    for integrator in (scipy_ivp.RK45, scipy_ivp.DOP853, scipy_ode.Dop853, scipy_ode.Adams):
        assert "jac" not in integrator().prepare(toy(stiff), 1e-6).options


@pytest.mark.parametrize("name", ["pendulum_simple", "kepler_orbit", "euler_top"])
def test_the_jacobian_is_that_of_the_equations(name: str) -> None:
    """Against central differences of step 1e-6: their error is its square, and round-off over the step."""
    case = get(name).rounded()
    problem, y = problem_of(case, (FirstOrder,)), initial_state(case)
    assert isinstance(problem.form, FirstOrder)
    jacobian = scipy_ivp.jacobian_of(problem.form, problem.dimension, problem.buffer)
    assert jacobian is not None
    function = scipy_ivp.right_hand_side_of(problem)
    columns = [(function(0.0, y + d) - function(0.0, y - d)) / 2e-6 for d in 1e-6 * np.eye(problem.dimension)]
    assert jacobian(0.0, y) == pytest.approx(np.transpose(columns), abs=1e-8)


@pytest.mark.parametrize("integrator", [scipy_events.Radau, scipy_events.LSODA], ids=lambda kind: kind.name)
def test_implicit_methods_get_the_jacobian_of_each_mode(integrator: type[Integrator]) -> None:
    case = get("bouncing_ball").rounded()
    solve = integrator().prepare(problem_of(case, integrator.accepts), 1e-6)
    found = {key: value for key, value in solve.options.items() if key.startswith("jac")}
    assert found
    assert set(found.values()) == {"compiled"}


def test_ode_counts_right_hand_sides_and_steps() -> None:
    """12 right-hand sides an accepted step, 11 a rejected one."""
    problem = counting(PROBLEM)
    solution = scipy_ode.Dop853().prepare(problem, 1e-8)(START)
    assert 64 <= (solution.steps or 0) <= problem.buffer[-1] / 12


def test_ode_counts_the_steps_that_it_accepts() -> None:
    """The number that SciPy passes to a `solout`, less the start of each call; other steps are rejected."""
    case = get("kepler_orbit").rounded()
    problem = problem_of(case, (FirstOrder,))
    shown, tried = 0, 0

    def solout(t: float, y: Any) -> int:
        nonlocal shown
        shown += 1
        return 0

    solver = ode(scipy_ivp.right_hand_side_of(problem))
    solver.set_integrator("dop853", rtol=1e-6, atol=1e-12)
    solver.set_solout(solout)
    solver.set_initial_value(initial_state(case), 0.0)
    for time in problem.times.tolist():
        solver.integrate(time)
        tried += int(solver._integrator.iwork[17])
    steps = scipy_ode.Dop853().prepare(problem, 1e-6)(initial_state(case)[None]).steps
    assert steps == shown - 64
    assert steps < tried


def test_ode_takes_as_many_steps_as_it_needs() -> None:
    """Its own limit is 500 between two samples: 80 turns at 1e-12 need more."""
    problem = replace(toy(linear), times=np.array([512.0]))
    solution = scipy_ode.Dop853().prepare(problem, 1e-12)(np.array([[1.0, 0.0]]))
    assert solution.stopped is None
    assert (solution.steps or 0) > 500
    assert solution.states[0, 0, 0] == pytest.approx(np.cos(512.0), abs=1e-9)


@every
def test_plain_run_leaves_the_count_alone(integrator: type[Integrator]) -> None:
    problem = toy(linear)
    integrator().prepare(problem, 1e-4)(np.array([[1.0, 0.0]]))
    assert problem.buffer[-1] == 0


@ending
def test_a_right_hand_side_that_is_not_finite_ends_the_run(integrator: type[Integrator]) -> None:
    """Later than the start: samples up to there are kept. At the start RK45 and DOP853 would never return."""
    solve = integrator().prepare(toy(hopeless), 1e-6)
    late = solve(np.array([[1.0, 0.0]]))
    assert np.isnan(late.states[0, -1]).any()
    at_once = solve(np.array([[-1.0, 0.0]]))
    assert np.isnan(at_once.states[0]).any(axis=1).all()
    if integrator not in (scipy_ivp.LSODA, scipy_odeint.Odeint):
        assert late.stopped
        assert np.isfinite(late.states[0, :7]).all()
    assert at_once.stopped


def one_sided(t: Any, state: Values, parameters: Values) -> Values:
    """Not finite below x = -1/2."""
    x, v = state
    (k,) = parameters
    return v, 0 * log(x + 1 / 2) - k * sin(x)


@ending
def test_a_trajectory_that_fails_is_reported_in_an_ensemble(integrator: type[Integrator]) -> None:
    solution = integrator().prepare(toy(one_sided), 1e-6)(np.array([[-1.0, 0.0], [0.25, 0.0]]))
    assert solution.stopped
    assert np.isnan(solution.states[0, -1]).any()
    assert np.isfinite(solution.states[1]).all()


LIMITED = (*scipy_ivp.INTEGRATORS, *scipy_odeint.INTEGRATORS)


@pytest.mark.parametrize("integrator", LIMITED, ids=lambda kind: kind.name)
def test_a_tolerance_that_scipy_would_replace_is_refused(integrator: type[Integrator]) -> None:
    with pytest.raises(Refused, match=r"1e-14: .* 2\.2e-14"):
        integrator().prepare(PROBLEM, 1e-14)


def test_ode_reports_where_and_why_it_stopped() -> None:
    solution = scipy_ode.Dop853().prepare(toy(hopeless), 1e-6)(np.array([[1.0, 0.0]]))
    assert "step size becomes too small at t = 0.5" in str(solution.stopped)
    assert np.isfinite(solution.states[0, :7]).all()
    assert np.isnan(solution.states[0, 8:]).all()


@pytest.mark.filterwarnings("ignore:Illegal input")
def test_odeint_at_a_refused_tolerance_would_return_the_start() -> None:
    """The trap itself: over whole periods the error is 0, from a solver that took no step."""
    function = scipy_ivp.right_hand_side_of(toy(linear))
    found, facts = odeint(function, [1.0, 0.0], [0.0, 1.0], rtol=1e-14, atol=1e-17, tfirst=True, full_output=True)
    assert facts["message"] != scipy_odeint.SUCCESS
    assert np.array_equal(found[1], [1.0, 0.0])


def test_odeint_keeps_the_samples_that_it_reached_and_reports_where_it_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    """With its own limit of steps between two samples; the samples that it returns from there on are uninitialised."""
    monkeypatch.setattr(scipy_odeint, "STEPS", 500)
    problem = replace(toy(linear), times=np.array([1.0, 2.0, 2000.0, 2001.0]))
    solution = scipy_odeint.Odeint().prepare(problem, 1e-10)(np.array([[1.0, 0.0]]))
    assert solution.states[0, :2, 0] == pytest.approx(np.cos([1.0, 2.0]), abs=1e-8)
    assert np.isnan(solution.states[0, 2:]).all()
    assert "Excess work done on this call" in str(solution.stopped)


def test_odeint_does_not_take_the_pendulum_for_stiff() -> None:
    """Its methods of order 8 and more need at most 10^(2/8) = 1.8 times the steps at a hundredth of the tolerance. In BDF,
    of order 5 at most, it took 5.4 times as many, and the error shrank by less than 3."""
    case = get("pendulum_simple", "speed").rounded()
    coarse, fine = (solved(scipy_odeint.Odeint(), case, rtol) for rtol in (1e-11, 1e-13))
    assert fine.steps < 1.8 * coarse.steps


def options_used(integrator: type[Integrator], monkeypatch: pytest.MonkeyPatch) -> tuple[dict[str, Any], Any]:
    """The options that a trial at 1e-5 recorded, and the object of the library's solver, which has the used options."""
    used: list[Any] = []
    if issubclass(integrator, scipy_ivp.SolveIvp):
        kind = METHODS[integrator.method]

        class Noted(kind):  # type: ignore[misc, valid-type]
            def __init__(self, *arguments: Any, **named: Any) -> None:
                super().__init__(*arguments, **named)
                used.append(self._lsoda_solver._integrator if integrator is scipy_ivp.LSODA else self)

        monkeypatch.setitem(METHODS, integrator.method, Noted)
    elif issubclass(integrator, scipy_ode.Ode):
        original = ode.set_integrator
        monkeypatch.setattr(
            ode, "set_integrator", lambda self, *a, **k: used.append(original(self, *a, **k)._integrator)
        )
    else:
        inner = _odepack_py._odepack.odeint  # no object of SciPy has these values
        rtol, atol, mxstep = 9, 10, 16

        def noted(*arguments: Any) -> Any:
            used.append(SimpleNamespace(rtol=arguments[rtol], atol=arguments[atol], mxstep=arguments[mxstep]))
            return inner(*arguments)

        monkeypatch.setattr(_odepack_py, "_odepack", SimpleNamespace(odeint=noted))
    solve = integrator().prepare(PROBLEM, 1e-5)
    solve(START)
    return dict(solve.options), used[-1]


@pytest.mark.parametrize("integrator", scipy_events.INTEGRATORS, ids=lambda kind: kind.name)
def test_with_events_right_hand_sides_are_called_as_without(
    integrator: type[scipy_events.SolveIvpEvents], monkeypatch: pytest.MonkeyPatch
) -> None:
    """SciPy is given a function of C both ways: a frame of Python around it would take as long as the equations."""
    given: list[Any] = []

    def noted(function: Any, *arguments: Any, **options: Any) -> Any:
        given.append(function)
        return solve_ivp(function, *arguments, **options)

    monkeypatch.setattr("scipy.integrate.solve_ivp", noted)
    (without,) = (kind for kind in scipy_ivp.INTEGRATORS if kind.name == integrator.name)
    for kind, name in ((without, "pendulum_simple"), (integrator, "bouncing_ball")):
        solved(kind(), get(name).rounded(), 1e-4)
    assert {count_python_calls(function, 0.0, START[0]) for function in given} == {count_python_calls(abs, 0.0)}
    assert len(given) > 1


@pytest.mark.parametrize("integrator", scipy_events.INTEGRATORS, ids=lambda kind: kind.name)
@pytest.mark.parametrize(
    ("name", "tolerance"), [("chattering_ball", 1e-5), ("oblique_impact", 1e-10), ("oblique_impact", 1e-7)]
)
def test_no_event_is_missed_where_forces_do_not_depend_on_the_state(
    integrator: type[Integrator], name: str, tolerance: float
) -> None:
    """The tolerance bounds no step there, and in a long one a guard falls and rises: at rest, and past the other disc."""
    case = get(name).rounded()
    found = solved(integrator(), case, tolerance)
    assert float(np.max(case.metric.distance(found.states, exact_states(case)))) < 0.01


def test_a_mode_whose_steps_the_tolerance_bounds_has_no_other_limit() -> None:
    """It would cost time: the flights of these are free, the swinging and the sliding with the spring are not."""
    for name, limited in (("bouncing_ball", True), ("pendulum_quadratic_damping", False), ("planet_tunnel", False)):
        options = scipy_events.DOP853().prepare(problem_of(get(name).rounded(), (Hybrid,)), 1e-6).options
        assert ("max_step" in options) == limited, name


@pytest.mark.parametrize("integrator", scipy_events.INTEGRATORS, ids=lambda kind: kind.name)
def test_the_options_recorded_with_events_are_those_of_each_segment(
    integrator: type[scipy_events.SolveIvpEvents], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A new solver is made after each event: all of them have the options that the trial recorded."""
    made: list[Any] = []
    kind = METHODS[integrator.method]

    class Noted(kind):  # type: ignore[misc, valid-type]
        def __init__(self, *arguments: Any, jac: Any = None, **named: Any) -> None:
            super().__init__(*arguments, **named, **({} if jac is None else {"jac": jac}))
            inner = self._lsoda_solver._integrator if integrator is scipy_events.LSODA else self
            made.append((inner.rtol, np.unique(inner.atol).item(), callable(jac), float(inner.max_step)))

    monkeypatch.setitem(METHODS, integrator.method, Noted)
    case = get("bouncing_ball", span=2).rounded()
    solve = integrator().prepare(problem_of(case, integrator.accepts), 1e-5)
    solution = solve(initial_state(case)[None])
    recorded = dict(solve.options)
    jacobians = {value == "compiled" for name, value in recorded.items() if name.startswith("jac in ")} or {False}
    assert recorded["rtol"] == 1e-5
    assert {each[:3] for each in made} == {(1e-5, recorded["atol"], jacobian) for jacobian in jacobians}
    unlimited = 0.0 if integrator is scipy_events.LSODA else np.inf
    assert recorded["max_step"] in {each[3] for each in made} <= {recorded["max_step"], unlimited}
    assert len(made) > len(solution.events) > 2


@every
def test_the_options_recorded_are_the_options_used(
    integrator: type[Integrator], monkeypatch: pytest.MonkeyPatch
) -> None:
    recorded, used = options_used(integrator, monkeypatch)
    assert recorded["rtol"] == used.rtol == 1e-5
    assert recorded["atol"] == used.atol <= 1e-5
    for name in recorded.keys() & {"nsteps", "mxstep"}:
        assert recorded[name] == getattr(used, name), name


@explicit
def test_samples_follow_the_given_times(integrator: type[Integrator]) -> None:
    uneven = replace(toy(linear), times=np.sqrt(np.arange(1, 65)))
    states = integrator().prepare(uneven, 1e-9)(np.array([[1.0, 0.0]])).states[0]
    assert states[:, 0] == pytest.approx(np.cos(uneven.times), abs=1e-7)


def latched(direction: int, place: float, speed: float, fired: bool, after_event: bool) -> float:
    """The value at the start of a segment of a guard that is the position itself."""
    guard = Guard(SimpleNamespace(direction=direction), lambda t, y: y[:1])  # type: ignore[arg-type]
    side = SimpleNamespace(equations=lambda t, y: np.array([speed]))
    y = np.array([place])
    set_latch(guard, side, 0.0, y, fired, after_event, PROBE)  # type: ignore[arg-type]
    assert guard(1.0, y) == place, "only at the start itself"
    return float(np.sign(guard(0.0, y)))


@pytest.mark.parametrize("direction", [-1, 1])
def test_a_guard_at_zero_where_a_segment_starts(direction: int) -> None:
    """Not yet crossed, sign -direction, or crossed already, sign direction."""
    before, crossed = -direction, direction
    at_the_start = {speed: latched(direction, 0.0, speed, False, False) for speed in (-1.0, 1.0)}
    assert at_the_start == {float(before): before, float(crossed): crossed}, "where the motion goes"
    assert latched(direction, 0.0, 1.0, False, True) == before
    assert latched(direction, 0.0, -1.0, True, True) == before
    assert latched(direction, crossed * 1e-17, 1.0, True, True) == before, "round-off of the event just located"
    assert latched(direction, crossed * 1e-17, 1.0, False, True) == crossed
    assert latched(direction, before * 1e-17, 1.0, True, True) == before

"""REBOUND on Kepler's orbit, native and in ODE mode: convergence, sample times, independent runs, counts, refusals."""

import os
import signal
from dataclasses import replace
from math import log, sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, NBody, Values
from gnomon.cases.core.registry import get
from gnomon.cases.orbits.kepler_orbit import KeplerOrbit
from gnomon.harness.adapters import rebound_nbody, rebound_ode
from gnomon.harness.adapters.rebound_nbody import (
    IAS15,
    BulirschStoer,
    CorrectedWHFast,
    FixedSteps,
    Leapfrog,
    Native,
    Trace,
    WHFast,
    step_counts,
)
from gnomon.harness.adapters.rebound_ode import OdeMode
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused
from gnomon.harness.contract.problem import counting, initial_state, problem_of
from on_cases import count_python_calls, exact_states, solved

pytestmark = pytest.mark.filterwarnings("ignore:At least 10 predictor corrector loops:RuntimeWarning")

CASE = KeplerOrbit().rounded()
PROBLEM = problem_of(CASE, (NBody,))
START = initial_state(CASE)[None]
ALL = (*rebound_nbody.INTEGRATORS, *rebound_ode.INTEGRATORS)
native = pytest.mark.parametrize("integrator", rebound_nbody.INTEGRATORS, ids=lambda kind: kind.name)
fixed = pytest.mark.parametrize("integrator", [Leapfrog, WHFast, CorrectedWHFast], ids=lambda kind: kind.name)
every = pytest.mark.parametrize("integrator", ALL, ids=lambda kind: kind().id)


def lost_above(t: Any, state: Values, parameters: Values) -> Values:
    """The velocity's derivative, the last component, is not finite from time 0.5 on."""
    x, v = state
    return v, 0 * log(1 / 2 - t) - sin(x)


def lost_below(t: Any, state: Values, parameters: Values) -> Values:
    """Only the first component is not finite from time 0.5 on."""
    x, v = state
    return v + 0 * log(1 / 2 - t), -sin(x)


def toy(equations: Any) -> Problem:
    return Problem(FirstOrder(equations), 2, np.array([1.0]), np.arange(1, 65) / 16, 1.0)


def problem_for(integrator: type[Integrator]) -> Problem:
    return problem_of(CASE, integrator.accepts)


def setting_for(integrator: type[Integrator]) -> float:
    return PROBLEM.interval / 64 if issubclass(integrator, FixedSteps) else 1e-9


def error(integrator: type[Integrator], setting: float) -> float:
    states = integrator().prepare(problem_for(integrator), setting)(START).states[0]
    return float(np.abs(states - exact()).max())


def exact() -> Floats:
    return exact_states(CASE)


def test_ias15_reaches_1e_12_over_10_37_periods() -> None:
    assert error(IAS15, 1e-9) < 1e-12


def test_leapfrog_is_of_order_2() -> None:
    """Four halvings where the phase error is below 0.1 rad; its next term is O(h^2) smaller."""
    errors = [error(Leapfrog, PROBLEM.interval / 2**k) for k in (9, 10, 11, 12)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(2, abs=0.05)


def test_whfast_is_exact_for_two_bodies_at_any_step() -> None:
    """The error is round-off, with 64 steps or 65536 (half an ulp each step, growing as steps^1/2 in energy)."""
    assert error(WHFast, PROBLEM.interval) < 1e-11
    assert error(WHFast, PROBLEM.interval / 1024) < 1e-10


THREE = get("equilateral_three_body").rounded()
MASSES = np.array([1.0, 0.625, 0.375])
NEAR = initial_state(THREE) + np.random.default_rng(3).uniform(-0.125, 0.125, 18)
"""Three bodies of similar masses, nearly in a triangle: no method here is exact for them."""


def three_bodies(integrator: type[Integrator], starts: Floats) -> Floats:
    """Steps of 1/8, some fiftieth of a turn, or a tolerance of 1e-3; (n, 64, 2, 3, 3): places and velocities."""
    problem = replace(problem_of(THREE, (NBody,)), times=np.arange(1, 65) * 0.125)
    setting = 0.125 if issubclass(integrator, FixedSteps) else 1e-3
    return integrator().prepare(problem, setting)(starts).states.reshape(-1, 64, 2, 3, 3)


@fixed
def test_steps_are_symplectic(integrator: type[Native]) -> None:
    """J^T S J = S, S of the bodies' momenta, J by central differences of 1e-5: off by their square and an ulp over them."""
    assert {"symplectic", "reversible", "momentum"} == set(integrator.conserves)
    tiny = 1e-5
    ahead, behind = (three_bodies(integrator, NEAR + s * tiny * np.eye(18))[:, 0].reshape(18, 18) for s in (1, -1))
    derivative = ((ahead - behind) / (2 * tiny)).T
    weights, zero = np.diag(np.repeat(MASSES, 3)), np.zeros((9, 9))
    canonical = np.block([[zero, weights], [-weights, zero]])
    assert np.abs(derivative.T @ canonical @ derivative - canonical).max() < 1e-10
    middle, reference = (three_bodies(kind, NEAR[None])[0, 0] for kind in (integrator, IAS15))
    assert np.abs(middle - reference).max() > 1e-6, "where the step is as good as exact the motion itself is symplectic"


@pytest.mark.parametrize("integrator", [Leapfrog, WHFast, BulirschStoer], ids=lambda kind: kind.name)
def test_fixed_steps_are_reversible_and_conserve_momentum(integrator: type[Native]) -> None:
    """To the round-off of 64 steps, amplified by encounters; errors of a tolerance would exceed it."""
    there = three_bodies(integrator, NEAR[None])[0]
    turn = np.array([1.0, -1.0])[:, None, None]
    back = three_bodies(integrator, (there[-1] * turn).reshape(1, 18))[0, -1] * turn
    returned = np.abs(back.ravel() - NEAR).max()
    spins = np.einsum("b,tbi->ti", MASSES, np.cross(there[:, 0], there[:, 1]))
    places, velocities = NEAR.reshape(2, 3, 3)
    turned = np.abs(spins - MASSES @ np.cross(places, velocities)).max()
    moved = np.abs(np.einsum("b,tbi->ti", MASSES, there[:, 1]) - MASSES @ velocities).max()
    assert moved < 1e-12
    if integrator.conserves:
        assert returned < 1e-8
        assert turned < 1e-12
    else:
        assert returned > 1e-4
        assert turned > 1e-7


@pytest.mark.parametrize("integrator", [BulirschStoer, OdeMode], ids=lambda kind: kind().id)
def test_bs_converges_with_its_tolerance(integrator: type[Integrator]) -> None:
    """Position gains 1e3 over speed errors in 65 rad: global error at most 1e3 tolerances."""
    errors = [error(integrator, tolerance) for tolerance in (1e-4, 1e-7, 1e-10)]
    assert errors[0] > 10 * errors[1] > 100 * errors[2]
    assert errors[2] < 1e3 * 1e-10


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_ode_mode_on_the_pendulum(tolerance: float) -> None:
    case = get("pendulum_simple").rounded()
    assert np.abs(solved(OdeMode(), case, tolerance).states - exact_states(case)).max() < 100 * tolerance


def test_ode_mode_takes_a_formulation_with_a_clock() -> None:
    (sundman,) = CASE.formulations
    found = solved(OdeMode(), CASE, 1e-11, formulation=sundman)
    states = found.states
    assert not found.problem.uniform
    assert np.abs(states[:, :4] - exact()).max() < 1e3 * 1e-11
    assert np.abs(states[:, 4] - CASE.times).max() < 1e3 * 1e-11


@every
def test_runs_are_independent(integrator: type[Integrator]) -> None:
    starts = np.array([[0.4, 0.0, 0.0, 2.0], [1.0, 0.0, 0.25, 1.0], [0.4, 0.0, 0.0, 2.0]])
    solve = integrator().prepare(problem_for(integrator), setting_for(integrator))
    together, alone = solve(starts).states, solve(starts[:1]).states
    assert together.shape == (3, 64, 4)
    assert np.array_equal(together[0], alone[0])
    assert np.array_equal(together[2], alone[0])
    assert not np.array_equal(together[1], alone[0])


@every
def test_steps_are_those_of_this_call(integrator: type[Integrator]) -> None:
    solve = integrator().prepare(problem_for(integrator), setting_for(integrator))
    first, second = solve(START).steps, solve(START).steps
    assert first == second
    assert first is not None
    assert first >= 64
    if issubclass(integrator, FixedSteps):
        assert first == 64 * 64


@pytest.mark.parametrize("integrator", [IAS15, BulirschStoer], ids=lambda kind: kind.name)
def test_the_first_step_is_a_part_of_the_time_scale(integrator: type[Native]) -> None:
    """So a motion takes the same steps in every unit of time."""
    first, longer = (integrator().first_dt(replace(PROBLEM, time_scale=scale), 1e-9) for scale in (1.0, 8.0))
    assert longer == 8 * first > 0


@every
def test_simulation_meets_each_sample_time_to_the_bit(
    integrator: type[Integrator], monkeypatch: pytest.MonkeyPatch
) -> None:
    """REBOUND may end within 1e-12 of the requested time; at our times it ends exactly."""
    seen: list[float] = []
    solve = watched(integrator, lambda simulation: seen.append(simulation.contents.t), monkeypatch)
    solve(START)
    assert {*CASE.times.tolist()} <= {*seen}


@every
def test_python_is_entered_once_a_motion(integrator: type[Integrator]) -> None:
    """A call of Python at each sample takes microseconds, more than a step: no user of REBOUND's C interface pays them."""
    problem = problem_for(integrator)
    few, many = (
        count_python_calls(integrator().prepare(replace(problem, times=times), setting_for(integrator)), START)
        for times in (problem.times[:8], problem.times)
    )
    assert few == many > 0


@fixed
def test_a_step_that_does_not_divide_the_interval_is_refused(integrator: type[Native]) -> None:
    with pytest.raises(Refused, match=r"a step of 0\.299.* does not divide the sampling interval"):
        integrator().prepare(PROBLEM, 0.3)


@pytest.mark.parametrize("step", [0.0, -0.5, float("nan"), 3.0])
def test_impossible_steps_are_refused(step: float) -> None:
    with pytest.raises(Refused):
        step_counts(np.arange(1, 65) * 1.0, step)


def test_decimal_steps_between_unequal_times() -> None:
    """Engine variants have samples at multiples of 0.01 s, which binary64 rounds."""
    times = np.array([0.31, 0.63, 0.94])
    assert step_counts(times, 0.01) == [31, 32, 31]


def test_ode_mode_counts_right_hand_sides_in_compiled_code() -> None:
    """Each BS step takes at least two columns of the table (2 + 6 substeps) and the derivative at its start."""
    problem = counting(problem_for(OdeMode))
    solution = OdeMode().prepare(problem, 1e-9)(START)
    assert solution.steps is not None
    assert problem.buffer[-1] >= 9 * solution.steps
    plain = problem_for(OdeMode)
    OdeMode().prepare(plain, 1e-9)(START)
    assert plain.buffer[-1] == 0


def test_right_hand_side_stays_a_c_function() -> None:
    """The structure holds the address of the compiled function itself, not of a callback into Python."""
    import ctypes

    function, again = rebound_ode.c_pointer(), rebound_ode.c_pointer()
    addresses = {ctypes.cast(pointer, ctypes.c_void_p).value for pointer in (function, again)}
    assert len(addresses) == 1
    import rebound

    simulation = rebound.Simulation()
    simulation.integrator = "bs"
    ode = simulation.create_ode(length=4, needs_nbody=False)
    ode._derivatives = function
    assert {ctypes.cast(ode._derivatives, ctypes.c_void_p).value} == addresses


@pytest.mark.parametrize("equations", [lost_above, lost_below])
def test_a_right_hand_side_that_is_not_finite_ends_the_run(equations: Any) -> None:
    solution = OdeMode().prepare(toy(equations), 1e-6)(np.array([[1.0, 0.0]]))
    assert np.isfinite(solution.states[0, :7]).all()
    assert np.isnan(solution.states[0, 8:]).any(axis=1).all()
    assert "NaN" in str(solution.stopped)


@native
def test_a_start_that_is_not_finite_gives_no_finite_sample(integrator: type[Native]) -> None:
    start = np.array([[np.nan, 0.0, 0.0, 2.0]])
    solution = integrator().prepare(PROBLEM, setting_for(integrator))(start)
    assert np.isnan(solution.states).any(axis=2).all()


@every
def test_interrupts_still_reach_python(integrator: type[Integrator]) -> None:
    """`integrate` leaves its own handler of SIGINT behind: unless ours is put back the signal is lost."""
    caught: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: caught.append(number))
    try:
        integrator().prepare(problem_for(integrator), setting_for(integrator))(START)
        os.kill(os.getpid(), signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)
    assert caught == [signal.SIGINT]


@pytest.mark.parametrize("integrator", [IAS15, BulirschStoer, OdeMode], ids=lambda kind: kind().id)
def test_an_interrupt_ends_a_motion(integrator: type[Integrator], monkeypatch: pytest.MonkeyPatch) -> None:
    """The loop over samples is one call of Python, and these methods may take steps without end."""
    steps: list[int] = []

    def interrupt(simulation: Any) -> None:
        steps.append(1)
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        watched(integrator, interrupt, monkeypatch)(START)
    assert len(steps) < 64


def watched(integrator: type[Integrator], heartbeat: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A solver whose simulation calls a function before and after each step."""
    import rebound

    made: list[Any] = []
    original = rebound.Simulation
    monkeypatch.setattr(rebound, "Simulation", lambda: made.append(original()) or made[-1])
    solve = integrator().prepare(problem_for(integrator), setting_for(integrator))
    made[0].heartbeat = heartbeat
    return solve


@every
def test_options_name_what_differs_from_the_defaults(integrator: type[Integrator]) -> None:
    import rebound

    setting = setting_for(integrator) if issubclass(integrator, FixedSteps) else 1e-7
    solve = integrator().prepare(problem_for(integrator), setting)
    default = rebound.Simulation()
    default.integrator = getattr(integrator, "engine", "bs")
    for name, value in solve.options.items():
        holder = default if hasattr(default, name) else default.integrator
        assert getattr(holder, name) != value


@pytest.mark.parametrize(
    ("integrator", "setting", "given"),
    [(WHFast, 0, {"safe_mode": 0}), (CorrectedWHFast, 0, {"safe_mode": 0, "corrector": 17}), (Trace, 0, {}),
     (IAS15, 1e-5, {"epsilon": 1e-5}), (BulirschStoer, 1e-5, {"eps_rel": 1e-5, "eps_abs": 1e-5}),
     (OdeMode, 1e-5, {"eps_rel": 1e-5, "eps_abs": 1e-5})],
    ids=lambda x: getattr(x, "name", ""),
)  # fmt: skip
def test_the_options_of_each_method(integrator: type[Integrator], setting: float, given: dict[str, float]) -> None:
    solve = integrator().prepare(problem_for(integrator), setting or setting_for(integrator))
    options = dict(solve.options)
    options.pop("N_active", None)
    first = setting_for(integrator) if issubclass(integrator, FixedSteps) else 0.01 * PROBLEM.time_scale
    assert options.pop("dt") == first
    assert options == given


@every
def test_the_options_recorded_are_the_options_used(
    integrator: type[Integrator], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Read from the simulation after the trial; `dt` of adaptive methods is then the size of a later step."""
    import rebound

    made: list[Any] = []
    original = rebound.Simulation
    monkeypatch.setattr(rebound, "Simulation", lambda: made.append(original()) or made[-1])
    problem, setting = problem_for(integrator), setting_for(integrator)
    solve = integrator().prepare(problem, setting)
    solve(START)
    (simulation,) = made
    recorded = dict(solve.options)
    first = recorded.pop("dt")
    if issubclass(integrator, FixedSteps):
        assert simulation.dt == first == setting
    for name, value in recorded.items():
        holder = simulation if hasattr(simulation, name) else simulation.integrator
        assert getattr(holder, name) == value, name
    assert setting in (first, *recorded.values())


def test_versions_name_the_library() -> None:
    import rebound

    assert IAS15().versions() == OdeMode().versions() == {"rebound": rebound.__version__}


def test_an_unaligned_interval_is_no_problem_for_adaptive_methods() -> None:
    problem = replace(PROBLEM, times=CASE.times * np.sqrt(np.arange(1, 65) / 64))
    states = IAS15().prepare(problem, 1e-9)(START).states[0]
    assert np.abs(states - CASE.sample(problem.times)).max() < 1e-12


def on(name: str, integrator: type[Integrator], steps: int) -> float:
    """The error on a case with so many steps in each sampling interval."""
    case = get(name).rounded()
    problem = problem_of(case, integrator.accepts)
    states = integrator().prepare(problem, problem.interval / steps)(initial_state(case)[None]).states[0]
    return float(np.max(case.metric.distance(states, exact_states(case))))


def test_correctors_remove_most_of_the_error_of_planets() -> None:
    """Their masses are a thousandth of the star's: so is what is left. Without the option both would be equal."""
    assert on("outer_solar_system", CorrectedWHFast, 4) < on("outer_solar_system", WHFast, 4) / 10


def test_trace_passes_the_encounters_at_which_whfast_fails() -> None:
    assert on("three_body_pythagorean", WHFast, 256) > 0.1
    assert on("three_body_pythagorean", Trace, 256) < 1e-5

"""GSL, Boost's odeint, ARKODE, the codes of Hairer and Wanner: errors, samples, counts, derivatives, messages, closing."""

from math import cos, log, sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.core.registry import get
from gnomon.harness.adapters import arkode, gsl, hairer, odeint
from gnomon.harness.contract.integrator import Problem, Refused, solver_of
from gnomon.harness.contract.problem import counting
from gnomon.harness.registry import lookup
from gnomon.harness.registry.lookup import STIFF
from on_cases import exact_states, solved

ALL = [kind for module in (gsl, odeint, arkode, hairer) for kind in module.INTEGRATORS]


def over(kinds: Any) -> Any:
    """A parameter `kind`; a kind whose library is missing is skipped, with the reason."""
    lacking = [(kind, lookup.missing(kind())) for kind in kinds]
    return pytest.mark.parametrize(
        "kind",
        [pytest.param(kind, marks=pytest.mark.skipif(reason is not None, reason=f"{reason}"), id=kind().id)
         for kind, reason in lacking],
    )  # fmt: skip


each = over(ALL)
with_jacobian = over([kind for kind in ALL if kind().id in STIFF])
limited = over([kind for kind in ALL if "max_step" in kind.takes])
LOOSE: dict[Any, float] = {arkode.Dirk5: 300}
"""The error of a turn in tolerances for each step, where it is not within 2: the estimate of the method errs by as much."""


def turning(t: Any, y: Any, p: Any) -> Any:
    return y[1], -p[0] * y[0]


def fading(t: Any, y: Any, p: Any) -> Any:
    return (-p[0] * y[0],)


def escaping(t: Any, y: Any, p: Any) -> Any:
    return (y[0] * y[0],)


def stiff(t: Any, y: Any, p: Any) -> Any:
    """x relaxes to sin t, a million times faster than sin t changes."""
    return -1e6 * p[0] * (y[0] - sin(y[1])) + cos(y[1]), 1.0


def opaque(t: Any, y: Any, p: Any) -> Any:
    """A function that has no expression."""
    return (-p[0] * abs(y[0]),)


def ending(t: Any, y: Any, p: Any) -> Any:
    """Not finite from time 1/2 on."""
    return (-y[0] + 0 * log(1 / 2 - t),)


def problem(equations: Any, dimension: int, times: Any) -> Problem:
    return Problem(FirstOrder(equations), dimension, np.array([1.0]), np.array(times), 1.0)


def run(kind: Any, given: Problem, setting: float, start: Any) -> Any:
    return solver_of(kind(), given, setting)(np.array([start], dtype=float))


@each
def test_the_error_follows_the_tolerance(kind: Any) -> None:
    """Each step is allowed the absolute and the relative tolerance, 2 in all for a state of size 1, and a turn keeps errors."""
    times = np.linspace(3.2, 6.4, 2)
    exact = np.column_stack([np.cos(times), -np.sin(times)])
    errors = []
    for tolerance in (1e-4, 1e-9):
        found = run(kind, problem(turning, 2, times), tolerance, [1, 0])
        errors.append(float(np.max(np.abs(found.states[0] - exact))))
        assert errors[-1] < LOOSE.get(kind, 2) * found.steps * tolerance
    assert kind is gsl.Bsimp or errors[1] < errors[0] / 100, (
        "extrapolation is more accurate than a loose tolerance asks"
    )


@each
def test_samples_between_steps_are_as_accurate_as_those_at_the_end_of_steps(kind: Any) -> None:
    """Where steps go past samples, the interpolant must keep the order: one of a lower degree errs by much more."""
    times = np.linspace(0.05, 6.4, 128)
    exact = np.column_stack([np.cos(times), -np.sin(times)])
    found = run(kind, problem(turning, 2, times), 1e-8, [1, 0])
    assert np.max(np.abs(found.states[0] - exact)) < LOOSE.get(kind, 2) * max(found.steps, 128) * 1e-8


@each
def test_two_starts_are_two_motions(kind: Any) -> None:
    """A driver keeps steps and derivatives of the motion before: each motion begins as the first one of a driver."""
    solve = solver_of(kind(), problem(turning, 2, [0.7, 1.3]), 1e-9)
    starts = np.array([[1.0, 0.0], [0.0, 1.0]])
    alone = [solver_of(kind(), problem(turning, 2, [0.7, 1.3]), 1e-9)(start[None]).states[0] for start in starts]
    assert np.array_equal(solve(starts).states, np.array(alone))


@each
def test_follows_the_exact_motion(kind: Any) -> None:
    """Each step is allowed the tolerance, and over ten revolutions phase errors grow by up to a thousand."""
    for name in ("pendulum_simple", "kepler_orbit", "forced_oscillator"):
        if kind is odeint.Rosenbrock4 and name == "forced_oscillator":
            continue  # its order is 1 where equations depend on time: docs/libraries.md
        case = get(name).rounded()
        found = solved(kind(), case, 1e-9)
        assert np.max(np.abs(found.states - exact_states(case))) < 1e3 * found.steps * 1e-9, name


@each
def test_samples_that_were_not_reached_are_nan_with_the_reason(kind: Any) -> None:
    """The limit of steps is ten millions; a motion whose steps no longer advance ends long before it."""
    found = run(kind, problem(ending, 1, [0.2, 0.8]), 1e-6, [1.0])
    assert found.states[0, 0, 0] == pytest.approx(np.exp(-0.2), rel=1e-3)
    assert np.isnan(found.states[0, 1, 0])
    assert found.stopped
    assert "not finite" in found.stopped or kind.library == "arkode"
    assert (found.steps or 0) < 100_000


@each
def test_counts_are_those_of_right_hand_sides(kind: Any) -> None:
    plain = problem(turning, 2, np.linspace(0.1, 6.4, 64))
    counted = counting(plain)
    plain_run, counted_run = (run(kind, one, 1e-6, [1, 0]) for one in (plain, counted))
    assert plain.buffer[-1] == 0
    assert plain_run.steps == counted_run.steps
    assert counted.buffer[-1] >= counted_run.steps > 0


@over([kind for kind in ALL if kind.library != "odeint"])  # it takes ever smaller steps, without a limit
def test_a_motion_that_escapes_ends_with_a_reason(kind: Any) -> None:
    """y' = y^2 from 1 is infinite at t = 1, and no step goes past it."""
    found = run(kind, problem(escaping, 1, [0.5, 0.9, 2.0]), 1e-6, [1.0])
    assert found.states[0, :2, 0] == pytest.approx([2.0, 10.0], rel=1e-2)
    assert np.isnan(found.states[0, 2, 0])
    assert found.stopped
    assert (found.steps or 0) < 100_000


@over(hairer.INTEGRATORS)
def test_a_last_step_that_rounding_ends_before_the_sample_reaches_it(kind: Any) -> None:
    """x + (end - x) is less than `end` by rounding for some ends, where the last step is the longest."""
    for end in np.linspace(0.5, 2, 1000):
        found = run(kind, problem(fading, 1, [end]), 1e-2, [1.0])
        assert found.stopped is None
        assert found.states[0, 0, 0] == pytest.approx(np.exp(-end), abs=0.1)


@limited
def test_no_step_is_longer_than_the_longest(kind: Any) -> None:
    one = kind()
    one.max_step = 0.01
    found = solver_of(one, problem(turning, 2, [1.0, 2.0]), 1e-3)(np.array([[1.0, 0.0]]))
    assert found.steps >= 200


@with_jacobian
def test_stiff_equations_take_few_steps(kind: Any) -> None:
    """An explicit method needs a million. Where the steps could be far longer than the distance of samples, no interpolant
    would keep the tolerance: they are limited."""
    one = kind()
    if "max_step" in kind.takes:
        one.max_step = 0.05
    times = np.linspace(0.05, 3.2, 64)
    found = solver_of(one, problem(stiff, 2, times), 1e-7)(np.array([[0.0, 0.0]]))
    assert found.steps < 20_000
    assert found.states[0, :, 0] == pytest.approx(np.sin(times), abs=1e-5)


def driven(t: Any, y: Any, p: Any) -> Any:
    return (-p[0] * y[0] + sin(9 * t),)


def with_time(t: Any, y: Any, p: Any) -> Any:
    """The equations of `driven`, with time as a component."""
    return -p[0] * y[0] + sin(9 * y[1]), 1.0


def driven_twice(kind: Any, setting: float) -> tuple[Any, Any]:
    """The motions of `driven` and of `with_time`."""
    alone, both = (run(kind, problem(f, len(at), [5.0]), setting, at) for f, at in ((driven, [1]), (with_time, [1, 0])))
    return alone, both


@over([gsl.Bsimp, hairer.Rodas])
def test_time_may_be_a_component_of_the_state(kind: Any) -> None:
    """With the right df/dt a linearly implicit method takes the same steps either way; without, the error at 1e-2 changes."""
    alone, both = driven_twice(kind, 1e-2)
    if kind is gsl.Bsimp:  # its norm is a maximum, so that a component without error changes no step
        assert alone.steps == both.steps
    assert alone.states[0, :, 0] == pytest.approx(both.states[0, :, 0], rel=0, abs=1e-14 if kind is gsl.Bsimp else 1e-3)


@over([odeint.Rosenbrock4])
def test_rosenbrock4_has_the_fault_that_its_documentation_names(kind: Any) -> None:
    """With order 1 it needs many more steps where time is no component. If a newer Boost has the right coefficient, the
    sentences in docs/libraries.md and in the adapter are due."""
    alone, both = driven_twice(kind, 1e-7)
    assert alone.steps > 4 * both.steps


@with_jacobian
def test_equations_without_derivatives_are_refused_or_differenced(kind: Any) -> None:
    if kind.library in ("gsl", "odeint"):
        with pytest.raises(Refused, match=r"msadams|dopri5"):
            solver_of(kind(), problem(opaque, 1, [1.0]), 1e-6)
    else:
        found = run(kind, problem(opaque, 1, [1.0]), 1e-6, [1.0])
        assert found.states[0, 0, 0] == pytest.approx(np.exp(-1), rel=1e-4)


@over([gsl.Rkf45, arkode.Erk4])
def test_a_closed_solver_is_not_called(kind: Any) -> None:
    """Its driver was freed: a call would read memory of others."""
    prepared = kind().prepare(problem(turning, 2, [1.0]), 1e-6)
    prepared.close()
    with pytest.raises(RuntimeError, match="after close"):
        prepared.solve(np.array([[1.0, 0.0]]))


def test_a_folder_without_the_files_of_a_code_is_named(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hairer.shutil, "which", lambda name: f"/usr/bin/{name}")
    monkeypatch.setenv(hairer.FOLDER, str(tmp_path))
    (tmp_path / "rodas.f").write_text("      END\n")
    reason = lookup.missing(hairer.Rodas())
    assert reason is not None
    assert f"{tmp_path}" in reason
    assert "decsol.f" in reason

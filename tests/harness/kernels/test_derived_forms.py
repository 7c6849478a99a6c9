"""Forms that tracing derives: each has the values of the user's function, and those that do not exist are refused with why."""

from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, Hybrid, SecondOrder, SemiLinear
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.kernels.derived_forms import DerivedForms, derive_forms
from gnomon.harness.running.own_functions import Arguments, Clock, OwnEquations
from hypothesis import given
from hypothesis import strategies as st

import gnomon

NUMBERS = st.floats(-3, 3).filter(lambda x: abs(x) > 1e-3)


def kepler(t: float, y: Floats, mu: float) -> list[Any]:
    """Coordinates and rates in turn."""
    x, vx, z, vz = y
    r3 = (x * x + z * z) ** 1.5
    return [vx, -mu * x / r3, vz, -mu * z / r3]


def damped(t: float, y: Floats, k: float) -> list[Any]:
    return [y[1], -k * y[0] - 0.1 * y[1] + np.cos(t)]


def cyclic(t: float, y: Floats) -> list[Any]:
    """Each rate is a coordinate: pairs of a position and its velocity among three components do not exist."""
    return [y[1], y[2], y[0]]


def derived(fun: Any, size: int, *args: float) -> DerivedForms:
    own = OwnEquations(fun, Clock(0.0, 1.0), Arguments(args), np.linspace(1.0, 2.0, size), False)
    return derive_forms(own.forms[-1], size, len(args))  # type: ignore[arg-type]


KEPLER, DAMPED = derived(kepler, 4, 1.5), derived(damped, 2, 4.0)


@given(st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS))
def test_accelerations_are_those_of_the_function(y: tuple[float, ...]) -> None:
    second, first = KEPLER.forms[:2]
    assert isinstance(second, SecondOrder)
    assert isinstance(first, FirstOrder)
    wanted = kepler(0.0, np.array(y), 1.5)
    state = tuple(y[i] for i in KEPLER.order)
    assert second.acceleration(0.0, state[:2], (1.5,)) == pytest.approx([wanted[1], wanted[3]], rel=1e-14)
    assert first.equations(0.0, state, (1.5,)) == pytest.approx([wanted[i] for i in KEPLER.order], rel=1e-14)


@given(NUMBERS, NUMBERS, NUMBERS)
def test_the_linear_part_and_the_rest_are_the_whole(t: float, x: float, v: float) -> None:
    form = next(each for each in DAMPED.forms if isinstance(each, SemiLinear))
    matrix = np.array(form.linear((4.0,))).reshape(2, 2)
    assert matrix.tolist() == [[0.0, 1.0], [-4.0, -0.1]]
    whole = matrix @ [x, v] + form.rest(t, (x, v), (4.0,))
    assert whole == pytest.approx(np.array(damped(t, np.array([x, v]), 4.0), float), abs=1e-13)


def test_forms_that_do_not_exist_are_told_with_the_reason() -> None:
    assert "y[1]' depends on the velocity y[1]" in DAMPED.lacking
    assert not any(isinstance(form, SecondOrder) for form in DAMPED.forms)
    assert "y[" in derived(cyclic, 3).lacking


def test_a_motion_without_events_has_one_mode() -> None:
    (hybrid,) = (form for form in KEPLER.forms if isinstance(form, Hybrid))
    assert [mode.name for mode in hybrid.modes] == ["motion"]
    assert hybrid.start(0.0, (), ()) == "motion"
    assert KEPLER.autonomous
    assert not DAMPED.autonomous


@pytest.mark.parametrize(
    ("method", "setting"),
    [
        ("gnomon:Blanes-Moan 6", {"step": 2.0**-7}),
        ("gnomon:RKN 12(10)", {"rtol": 1e-11}),
        ("gnomon:DOP853 [events]", {"rtol": 1e-11}),
    ],
)
def test_solve_takes_methods_of_a_form_that_the_function_does_not_state(method: str, setting: dict[str, float]) -> None:
    """Also where the state has coordinates and rates in turn: the states come back in the user's sequence."""
    start, args = [1.0, 0.0, 0.0, 1.2], (1.0,)
    found = gnomon.solve(kepler, (0, 5), start, method, args=args, **setting)  # type: ignore[arg-type]
    wanted = gnomon.solve(kepler, (0, 5), start, "gnomon:DOP853", args=args, rtol=1e-12)
    assert np.max(np.abs(found.y - wanted.y)) < 1e-9


def test_solve_says_why_accelerations_do_not_exist() -> None:
    with pytest.raises(ValueError, match=r"needs equations as SecondOrder.*depends on the velocity y\[1\]"):
        gnomon.solve(damped, (0, 1), [1.0, 0.0], "gnomon:Störmer-Verlet", step=0.1, args=(4.0,))


def test_solve_says_that_rounding_is_above_the_tolerance() -> None:
    """Lorenz's system over 20 time units loses 8 digits; over 1 it does not."""

    def lorenz(t: float, y: Floats) -> list[Any]:
        return [10 * (y[1] - y[0]), y[0] * (28 - y[2]) - y[1], y[0] * y[1] - 8 / 3 * y[2]]

    start = [-13.76, -19.58, 27.0]
    assert "cannot be reached" in gnomon.solve(lorenz, (0, 20), start, rtol=1e-12).message
    assert "cannot be reached" not in gnomon.solve(lorenz, (0, 1), start, rtol=1e-12).message
    assert "cannot be reached" not in gnomon.solve(lorenz, (0, 20), start, rtol=1e-6).message


def hamilton(t: float, y: Floats, m: float, k: float) -> list[Any]:
    """A mass on a spring and a rotor, in positions and momenta."""
    x, a, p, j = y
    return [p / m, 0.5 * j, -k * x + np.sin(a), -np.sin(a)]


def test_momenta_become_velocities() -> None:
    """Methods for accelerations take Hamilton's equations of unit or other masses; states come back as momenta."""
    forms = derived(hamilton, 4, 2.0, 3.0)
    assert isinstance(forms.forms[0], SecondOrder)
    assert forms.factors is not None
    assert forms.factors((2.0, 3.0)) == (1, 1, 0.5, 0.5)
    assert forms.forms[0].acceleration(0.0, (0.3, 0.4), (2.0, 3.0)) == pytest.approx(
        [(-0.9 + np.sin(0.4)) / 2, -0.5 * np.sin(0.4)]
    )
    start, args = [0.3, 0.4, 1.0, -1.0], (2.0, 3.0)
    found = gnomon.solve(hamilton, (0, 5), start, "gnomon:Blanes-Moan 6", args=args, step=2.0**-7)
    wanted = gnomon.solve(hamilton, (0, 5), start, args=args, rtol=1e-12)
    assert np.max(np.abs(found.y - wanted.y)) < 1e-9


def test_gravitating_bodies_have_equations_of_first_order() -> None:
    """Two bodies on circles about each other: after a turn they are where they began."""

    def masses(p: Any) -> tuple[float, ...]:
        return 0.75, 0.25

    def bodies(state: Any) -> tuple[Any, ...]:
        return state[:6], state[6:]

    def state(bodies: Any) -> tuple[Any, ...]:
        return (*bodies[0], *bodies[1])

    start = [-0.25, 0.0, 0.0, 0.0, -0.25, 0.0, 0.75, 0.0, 0.0, 0.0, 0.75, 0.0]
    turn = gnomon.solve(gnomon.NBody(masses, bodies, state), (0, 2 * np.pi), start, t_eval=[2 * np.pi], rtol=1e-12)
    assert np.max(np.abs(turn.y[:, 0] - start)) < 1e-10

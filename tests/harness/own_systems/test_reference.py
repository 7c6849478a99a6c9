"""The reference of a user's equations: its bound holds on systems whose end is known, and its two ways share nothing."""

import math
from collections.abc import Callable
from fractions import Fraction
from math import atan2
from typing import Any

import numpy as np
import pytest
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.own_systems import smooth_reference
from gnomon.harness.own_systems.own_system import OwnSystem, make_system
from gnomon.harness.running.own_functions import Arguments
from gnomon.harness.running.pieces import Stated
from published_systems import SYSTEMS

import gnomon

SLOW = {"pleiades", "van_der_pol", "hires", "e5", "lorenz_ten_revolutions"}
"""Systems whose references take seconds and more on a quiet machine."""
ULP = 2.0**-53


def system(fun: Any, span: tuple[float, float], start: Any, args: tuple[Any, ...] = (), events: Any = ()) -> OwnSystem:
    return make_system(Stated(fun, Arguments(args), tuple(events)), span, start)


@pytest.mark.filterwarnings("ignore:.*has no formulas")
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n in SLOW else ()) for n in SYSTEMS if n != "beam"]
)
def test_the_bound_holds_on_published_systems(name: str) -> None:
    """The digits were derived by code that shares nothing with gnomon, for the numbers as they are rounded.

    The beam is left out: a call of its 80 equations from Python takes a millisecond, and its reference more than 7 minutes.
    """
    known = SYSTEMS[name]
    found = system(known.f, known.t_span, known.start, tuple(known.args))
    sizes = np.empty(len(known.start))
    sizes[list(found.order)] = found.rough.sizes
    apart = np.abs(found.end - np.array(known.end, float)) / sizes
    assert np.max(apart) <= found.reference_error + 4 * ULP
    if name != "eulr":  # it branches on the time: two methods in binary64
        assert found.reference_error < 1e-14


def swing(t: float, y: Floats, g: float) -> list[Any]:
    return [y[1], -g * np.sin(y[0])]


def test_it_equals_the_exact_motion_of_the_same_equations() -> None:
    exact = gnomon.case("pendulum_simple", g=9.81, L=1.0)
    start = list(map(float, exact.start))
    found = system(swing, (0.0, 5.0), start, (9.81,))
    assert np.max(np.abs(found.sample(found.times) - exact.sample(found.times))) <= 2 * ULP * max(found.rough.sizes)


def test_rounding_moves_it_as_the_conditioning_of_the_exact_motion_says() -> None:
    """The conditioning of a case is from exact motions that begin half an ulp away; here it is from variational equations."""

    def swing_of(t: float, y: Floats, g: float, length: float) -> list[Any]:
        return [y[1], -g / length * np.sin(y[0])]

    exact = gnomon.case("pendulum_simple", theta=1.9, omega=0.3, g=9.81, L=1.1).case.rounded()
    start = [float(x) for x in exact.initial_state]
    found = system(swing_of, (0.0, float(exact.span)), start, (9.81, 1.1))
    ratio = found.conditioning(found.times) / exact.conditioning(exact.times)
    assert np.all((ratio > 0.7) & (ratio < 1.5)), "the sizes differ by the grids on which they are taken"


def test_a_wrong_way_shows_in_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """If one way is off, the two agree in fewer digits, and the bound covers the difference."""
    right = smooth_reference.integrate

    def off(*given: Any) -> Any:
        return [tuple(x * (1 + Fraction(1, 10**9)) for x in row) for row in right(*given)]

    monkeypatch.setattr(smooth_reference, "integrate", off)
    monkeypatch.setattr(smooth_reference, "MOST_DIGITS", smooth_reference.DIGITS)  # more digits would not help
    found = system(swing, (0.0, 5.0), [1.0, 0.0], (9.81,))
    assert found.reference_error > 1e-9
    assert not found.reference.why


def test_equations_with_a_table_have_a_reference_in_binary64() -> None:
    """Linear interpolation of a line is the harmonic oscillator: the end is known."""

    def table(t: float, y: Floats) -> list[Any]:
        return [y[1], -np.interp(y[0], [-5.0, 0.0, 5.0], [-5.0, 0.0, 5.0])]

    with pytest.warns(UserWarning, match="has no formulas"):
        found = system(table, (0.0, 20.0), [1.0, 0.0])
    assert "binary64" in found.reference.text()
    assert abs(found.end - [math.cos(20), -math.sin(20)]).max() <= found.reference_error < 1e-9


def unstable(t: float, y: Floats) -> list[Any]:
    """From a start on its stable direction it decays, and an error grows as e^(10 t)."""
    return [y[1], 100 * y[0]]


def lorenz(t: float, y: Floats) -> list[Any]:
    return [10 * (y[1] - y[0]), y[0] * (28 - y[2]) - y[1], y[0] * y[1] - 8 / 3 * y[2]]


@pytest.mark.parametrize(
    ("fun", "start", "early", "late"),
    [
        (unstable, [1.0, -10.0], 2.0, (3.2, 4.5)),
        pytest.param(lorenz, [-13.76, -19.58, 27.0], 5.0, (25.0, 44.0), marks=pytest.mark.slow),
    ],
)
def test_where_errors_grow_it_is_said_after_which_time_no_digit_is_left(
    fun: Any, start: list[float], early: float, late: tuple[float, float]
) -> None:
    """The reference itself keeps its digits: its precision is raised until both ways agree."""
    found = system(fun, (0.0, late[1]), start)
    assert found.lost_after is not None
    assert late[0] < found.lost_after < late[1], "an error of 1e-16 grows to the size of the motion"
    assert found.reference_error < 1e-14
    first, *rest = found.reach()
    assert "changes all digits by t" in first, "by a multiple of the size is no statement about a motion"
    assert any("no digit" in text for text in rest)
    assert system(fun, (0.0, early), start).lost_after is None


@pytest.mark.parametrize("span", [1e-13, 1e12])
def test_the_unit_of_time_does_not_matter(span: float) -> None:
    def turning(t: float, y: Floats, w: float) -> list[Any]:
        return [w * y[1], -w * y[0]]

    w = 5.0 / span
    found = system(turning, (0.0, span), [1.0, 0.0], (w,))
    assert np.max(np.abs(found.end - [math.cos(w * span), -math.sin(w * span)])) < 4 * ULP


def test_backward_in_time() -> None:
    found = system(swing, (2.0, 0.0), [0.3, -1.0], (9.81,))
    there = gnomon.solve(swing, (0.0, 2.0), found.end, args=(9.81,), t_eval=[2.0], rtol=1e-12)
    assert np.max(np.abs(there.y[:, 0] - [0.3, -1.0])) < 1e-10


def test_a_driven_system_at_rest_has_a_reference() -> None:
    """Its start has no size."""
    found = system(lambda t, y: [y[1], -y[0] + np.sin(2 * t)], (0.0, 10.0), [0.0, 0.0])
    t = 10.0
    assert abs(found.end[0] - (2 * math.sin(t) - math.sin(2 * t)) / 3) < 1e-15


def test_an_event_of_scipys_kind_is_part_of_it() -> None:
    """The quarter period of the harmonic oscillator is pi / 2; a terminal event ends the motion."""

    def zero(t: float, y: Floats) -> float:
        return y[0]

    found = system(spring, (0.0, 5.0), [1.0, 0.0], events=[zero])
    assert [float(e.time) for e in found.events()] == pytest.approx([math.pi / 2, 3 * math.pi / 2], abs=4 * ULP)
    stop = lambda t, y: y[0]  # noqa: E731
    stop.terminal = True  # type: ignore[attr-defined]
    ended = system(spring, (0.0, 5.0), [1.0, 0.0], events=[stop])
    assert np.max(np.abs(ended.end - [0.0, -1.0])) < 4 * ULP


def spring(t: float, y: Floats) -> list[Any]:
    return [y[1], -y[0]]


def test_a_guard_counts_in_its_direction_alone() -> None:
    """From -1 the spring passes zero upward at pi / 2, which is no event, and downward at 3 pi / 2."""
    form = gnomon.Hybrid(
        (gnomon.Mode("swings", lambda t, y, p: (y[1], -y[0])),),
        lambda t, y, p: "swings",
        (gnomon.Transition("down", "swings", lambda t, y, p: (y[0],), -1, lambda t, y, p: y, "swings"),),
        settle=0.0,
    )
    found = system(form, (0.0, 6.0), [-1.0, 0.0])
    assert [float(event.time) for event in found.events()] == pytest.approx([3 * math.pi / 2], abs=4 * ULP)


@pytest.mark.parametrize(
    ("fun", "words"),
    [
        (
            lambda t, y: [y[0] ** 2],
            r"cannot be followed beyond t = 0\.99\d* after the start \(then the state is not finite\)",
        ),
        (lambda t, y: [y[0] / t], "not finite at the start"),
        (lambda t, y: [1.0, 2.0], "gives 2 values; 1 is wanted"),
    ],
)
def test_equations_without_a_motion_are_named(fun: Callable[..., Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        system(fun, (0.0, 10.0), [1.0])


def test_momenta_come_back_as_the_user_has_them() -> None:
    found = system(lambda t, y, m: [y[1] / m, -y[0]], (0.0, 3.0), [1.0, 0.5], (4.0,))
    wanted = [math.cos(1.5) + 0.25 * math.sin(1.5), -2 * math.sin(1.5) + 0.5 * math.cos(1.5)]
    assert found.end == pytest.approx(wanted, abs=4 * ULP)
    assert found.factors is not None


def test_each_of_two_walls_has_its_own_limit() -> None:
    """A ball that a mode drops on the second of two guards with limits: the second way looks for the zero of that guard."""

    def falling(t: float, y: Any, p: Any) -> Any:
        return y[1], -9.81

    def still(t: float, y: Any, p: Any) -> Any:
        return 0.0 * y[0], 0.0 * y[1]

    def bounce(t: float, y: Any, p: Any) -> Any:
        return y[0], -0.25 * y[1]

    form = gnomon.Hybrid(
        (gnomon.Mode("flies", falling), gnomon.Mode("lies", still)),
        lambda t, y, p: "flies",
        (
            gnomon.Transition("ceiling", "flies", lambda t, y, p: (5.0 - y[0],), -1, bounce, "flies"),
            gnomon.Transition("floor", "flies", lambda t, y, p: (y[0],), -1, bounce, "flies"),
        ),
        settle=1e-6,
        limits=(("ceiling", "lies", still), ("floor", "lies", still)),
    )
    found = system(form, (0.0, 2.0), [1.0, 0.0])
    assert [event.name for event in found.events()][-1] == "limit"
    assert not found.reference.why
    assert found.reference_error < 1e-9


def test_events_with_a_function_that_high_precision_does_not_have() -> None:
    """The angle of a turning point passes 1 at t = 1: two tight methods in binary64 take the place of high precision."""
    form = gnomon.Hybrid(
        (gnomon.Mode("before", turning), gnomon.Mode("after", turning)),
        before,
        (gnomon.Transition("up", "before", angle_past_one, 1, as_is, "after"),),
    )
    found = system(form, (0.0, 2.0), [1.0, 0.0])
    assert "binary64" in found.reference.text()
    assert [float(event.time) for event in found.events()] == pytest.approx([1.0], abs=1e-9)
    assert np.max(np.abs(found.end - [math.cos(2), math.sin(2)])) <= found.reference_error < 1e-9


def turning(t: float, y: Any, p: Any) -> tuple[Any, ...]:
    return -y[1], y[0]


def before(t: float, y: Any, p: Any) -> str:
    return "before"


def angle_past_one(t: float, y: Any, p: Any) -> tuple[Any, ...]:
    return (atan2(y[1], y[0]) - 1.0,)


def as_is(t: float, y: Any, p: Any) -> Any:
    return y

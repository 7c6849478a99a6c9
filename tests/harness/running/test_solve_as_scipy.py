"""`solve` as SciPy's `solve_ivp`: nothing is dropped, events end where SciPy's do, no step crosses a jump of the input."""

import math
import re
import warnings
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, Friction, Hybrid, Mode, SecondOrder, Transition
from gnomon.harness.contract.integrator import Problem, Refused, Steps
from gnomon.harness.kernels.called_equations import Called
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.registry import lookup
from gnomon.harness.running import call_watch
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from gnomon import sliding_friction, solve

ALL = {
    one.id: one
    for one in lookup.everything().values()
    if {FirstOrder, SecondOrder} & set(one.accepts) and lookup.missing(one) is None
}
NEED_FORMULAS = re.compile(
    "gnomon:(Radau|Gauss 8-stage SIMD|Taylor)|heyoka|diffrax|gsl:(bsimp|msbdf)|odeint:rosenbrock4"
)
FIXED = [name for name, one in ALL.items() if isinstance(one.sweep, Steps)]


def swing(t: float, y: Any) -> Any:
    return y[1], -np.sin(y[0])


def of_roots(t: float, y: Any) -> Any:
    """Complex from t = 1 on."""
    return [-2.0 * np.emath.sqrt(1.0 - t)]


@pytest.mark.filterwarnings("ignore:.*has no formulas")
@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"y0": np.array([1 + 2j, 0])}, "y0"),
        ({"y0": [1.0, 0j]}, "y0"),
        ({"t_eval": np.array([0.5 + 1j])}, "t_eval"),
        ({"jumps": [1j]}, "jumps"),
        ({"fun": lambda t, y, k: [k * y[1], y[0]], "args": (1j,)}, "<lambda>"),
        ({"fun": of_roots, "y0": [1.0]}, "of_roots"),
        ({"fun": of_roots, "y0": [1.0], "method": "RK45"}, "of_roots"),
    ],
)
def test_no_imaginary_part_is_dropped(changed: dict[str, Any], named: str) -> None:
    """The argument or the function is named, and the way out; in the course of the integration as at its start."""
    with pytest.raises(ValueError, match=named) as refused:
        solve(**({"fun": swing, "t_span": (0, 2), "y0": [1.0, 0.0]} | changed))
    assert "real and imaginary parts" in str(refused.value)


def early(t: float, y: Any) -> Any:
    return t - 0.01


def rest(t: float, y: Any) -> Any:
    return y[1]


early.terminal = True  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("method", "setting"), [("gnomon:DOP853", {}), ("scipy:RK45", {"rtol": 1e-10}), ("RK4", {"step": 0.01})]
)
def test_the_last_column_is_the_terminal_event(method: str, setting: dict[str, float]) -> None:
    """Without t_eval; the event comes long before the second of the 64 times."""
    found = solve(swing, (0, 100), [1.0, 0.0], method, events=early, **setting)
    assert found.t_events is not None
    assert found.y_events is not None
    assert found.t[-1] == found.t_events[0][0] == pytest.approx(0.01, rel=1e-9)
    assert np.array_equal(found.y[:, -1], found.y_events[0][0])
    assert np.all(np.diff(found.t) > 0)
    there = solve_ivp(swing, (0, 0.01), [1.0, 0.0], t_eval=found.t.clip(max=0.01), rtol=1e-12, atol=1e-14)
    assert np.abs(found.y - there.y).max() < 1e-9


@pytest.mark.parametrize("span", [(0.0, 50.0), (50.0, 0.0)])
@pytest.mark.parametrize("direction", [0, 1, -1])
@pytest.mark.parametrize("method", ["gnomon:DOP853 [events]", "scipy:RK45 [events]"])
def test_terminal_counts_occurrences(method: str, direction: int, span: tuple[float, float]) -> None:
    """As in SciPy, of those in the direction of the event."""

    def third(t: float, y: Any) -> Any:
        return y[0]

    third.terminal, third.direction = 3, direction  # type: ignore[attr-defined]
    found = solve(swing, span, [1.0, 0.3], method, rtol=1e-10, events=[third, rest])
    there = solve_ivp(swing, span, [1.0, 0.3], "DOP853", rtol=1e-12, atol=1e-13, events=[third, rest])
    assert found.t_events is not None
    assert found.status == there.status == 1
    assert len(found.t_events[0]) == 3
    assert found.t[-1] == found.t_events[0][-1]
    for ours, scipys in zip(found.t_events, there.t_events, strict=True):
        assert np.allclose(ours, scipys, rtol=0, atol=1e-7)


@pytest.mark.parametrize("count", [-1, 1.5, "two"])
def test_a_terminal_that_is_no_count_is_named(count: Any) -> None:
    def wrong(t: float, y: Any) -> Any:
        return y[0]

    wrong.terminal = count  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match=r"wrong .*terminal="):
        solve(swing, (0, 5), [1.0, 0.0], events=wrong)


KNOTS, HELD = np.array([0.0, 0.37, 1.1, 1.1003, 2.2]), np.array([1.0, -2.0, 3.0, 0.5, -1.0])
END = 3.0


def held(side: str) -> Callable[..., Any]:
    """x' = a held input - x, which at a knot has the new value (side "right") or still the old one."""
    return lambda t, y: [HELD[max(np.searchsorted(KNOTS, t, side) - 1, 0)] - y[0]]


def held_exactly(t: float) -> float:
    x = 0.5
    for begin, end, u in zip(KNOTS, [*KNOTS[1:], END], HELD, strict=True):
        if t > begin:
            x = u + (x - u) * math.exp(begin - min(t, end))
    return x


@pytest.mark.filterwarnings("ignore:.*has no formulas")
@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize("backward", [False, True])
def test_no_step_crosses_a_jump(side: str, backward: bool) -> None:
    """RK4 keeps its order 4 and a tolerance holds, whichever value the table has at a knot itself.

    Steps that do not fit between jumps: with them a step across a jump would leave an error of its own size.
    """
    span = (END, 0.0) if backward else (0.0, END)
    start, goal = held_exactly(span[0]), held_exactly(span[1])
    calls: dict[str, Any] = {"fun": held(side), "t_span": span, "y0": [start], "jumps": KNOTS[::-1]}
    errors = [abs(solve(method="RK4", step=h, **calls).y[0, -1] - goal) for h in (0.1, 0.05)]
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 12
    by_tolerance = solve(method="gnomon:DOP853", rtol=1e-11, **calls)
    assert np.allclose(by_tolerance.y[0], [held_exactly(t) for t in by_tolerance.t], rtol=0, atol=1e-9)


def test_each_piece_sees_only_its_own_times() -> None:
    """Not the time of a jump, where a table may have the value of the other side."""
    seen = list[float]()

    def watched(t: float, y: Any) -> Any:
        if isinstance(t, float):  # no symbol
            seen.append(t)
        return [1.0 if t < 0.5 else 2.0]

    with pytest.warns(UserWarning, match="no formulas"):
        found = solve(watched, (0, 1), [0.0], "scipy:RK45", jumps=[0.5], rtol=1e-6)
    assert found.y[0, -1] == pytest.approx(1.5, rel=1e-14)
    assert 0.5 not in seen
    assert min(seen) == 0.0
    assert max(seen) == 1.0


def test_formulas_have_no_jumps_but_may_be_given_some() -> None:
    smooth, pieces = (solve(swing, (0, 3), [1.0, 0.0], "gnomon:Taylor", jumps=jumps) for jumps in (None, [1.0, 2.0]))
    assert np.allclose(smooth.y, pieces.y, rtol=0, atol=1e-8)


@pytest.mark.parametrize("method", FIXED)
def test_outputs_may_be_closer_than_steps(method: str) -> None:
    """At even and uneven times; `message` has the size of the steps, which is the size asked for where steps do not
    have to end at the times."""
    form = SecondOrder if SecondOrder in ALL[method].accepts and FirstOrder not in ALL[method].accepts else FirstOrder
    fun: Any = (lambda t, q: [-q[0]]) if form is SecondOrder else (lambda t, y: [y[1], -y[0]])
    for times in (np.arange(1, 129) / 64, np.arange(1, 129) ** 1.01 / 128):
        found = solve(fun, (0, 2), [1.0, 0.0], method, times, step=0.03, accelerations=form is SecondOrder)
        assert found.success
        assert "in steps of 0.03" in found.message
        order = min(ALL[method].order or 1, 4)
        assert np.abs(found.y[0] - np.cos(times)).max() < 4 * 0.03**order


def test_the_message_has_the_step_that_the_times_change() -> None:
    found = solve(swing, (0, 10), [1.0, 0.0], "RK4", np.linspace(0, 10, 11), step=0.3)
    assert "in steps of 0.25: step=0.3 is shortened" in found.message
    assert "in steps of 10: step=20 is shortened" in solve(swing, (0, 10), [1.0, 0.0], "RK4", step=20).message
    assert "in steps of 0.3." in solve(swing, (0, 10), [1.0, 0.0], "RK4", [1.1, 10.0], step=0.3).message


def slow(t: float, y: Any) -> Any:
    return [y[1], -1e-6 * y[0]]


TAKE_SIZES = [name for name, one in ALL.items() if "max_step" in one.takes]


def test_most_methods_with_error_control_take_a_longest_step() -> None:
    others = {name for name, one in ALL.items() if not isinstance(one.sweep, Steps)} - {*TAKE_SIZES}
    without = ("gnomon:Gauss 8-stage SIMD", "rebound:", "diffrax:", "odeint:", "hairer:SEULEX")
    assert all(name.startswith(without) for name in others), others


@pytest.mark.parametrize("method", TAKE_SIZES)
def test_no_step_is_longer_than_the_longest(method: str) -> None:
    """Steps counted by their right-hand sides, or by the library: a slow motion needs few steps, and 200 at max_step."""
    one = ALL[method]
    second = SecondOrder in one.accepts and FirstOrder not in one.accepts
    fun: Any = (lambda t, q: [-1e-6 * q[0]]) if second else slow
    given: dict[str, Any] = {"rtol": 1e-6, "t_eval": [20.0], "accelerations": second}
    few, many = (solve(fun, (0, 20), [1.0, 1e-3], method, **given, **more) for more in ({}, {"max_step": 0.1}))
    assert np.allclose(few.y, many.y, rtol=1e-4)
    if one.counts_rhs:
        assert few.nfev is not None
        assert many.nfev is not None
        assert many.nfev >= 200
        assert few.nfev < many.nfev / 2


@pytest.mark.filterwarnings("ignore:.*has no formulas")
@pytest.mark.parametrize(
    "method", [name for name in TAKE_SIZES if "first_step" in ALL[name].takes and ALL[name].counts_rhs]
)
def test_the_first_step_has_the_size_asked_for(method: str) -> None:
    """The end of the first step, or the last stage before it, is evaluated: no time between 0 and .7 of it before."""
    if NEED_FORMULAS.match(method):
        found = [solve(swing, (0, 1), [1e-3, 0.0], method, rtol=1e-3, first_step=h).nfev for h in (1e-9, 0.1)]
        assert found[0] > found[1]
        return
    one, seen = ALL[method], list[float]()
    second = SecondOrder in one.accepts and FirstOrder not in one.accepts

    def watched(t: float, y: Any) -> Any:
        if not isinstance(t, float):
            raise TypeError("numbers alone")
        seen.append(t)
        return [0.0] if second else [y[1], 0.0]

    solve(watched, (0, 10), [1.0, 1.0], method, rtol=1e-3, accelerations=second, first_step=1e-5)
    within = [t for t in seen if 0 < t <= 1e-5 * (1 + 1e-9)]
    assert within
    assert max(within) > 0.7e-5


def stiff(t: float, y: Any) -> Any:
    return [-1000.0 * (y[0] - math.cos(t)) + (1.0 if t > -1 else 0.0), y[0]]


TAKE_JACOBIANS = [name for name, one in ALL.items() if "jac" in one.takes]


@pytest.mark.filterwarnings("ignore:.*has no formulas")
@pytest.mark.parametrize("form", ["formulas", "called", "matrix"])
@pytest.mark.parametrize("method", TAKE_JACOBIANS)
def test_a_jacobian_of_the_users_is_taken(method: str, form: str) -> None:
    """In place of differences: with it there are fewer right-hand sides; and it is called."""
    calls = []

    def derivatives(t: float, y: Any) -> Any:
        if form == "called":
            calls.append(float(t))
        return [[-1000.0, 0.0], [1.0, 0.0]]

    jac: Any = np.array([[-1000.0, 0.0], [1.0, 0.0]]) if form == "matrix" else derivatives
    given: dict[str, Any] = {"fun": stiff, "t_span": (0, 2), "y0": [1.0, 0.0], "method": method, "rtol": 1e-6}
    found, by_differences = solve(**given, jac=jac), solve(**given)
    assert np.allclose(found.y, by_differences.y, rtol=1e-3, atol=1e-6)
    assert found.nfev is not None
    assert by_differences.nfev is not None
    if method not in ("scipy:LSODA", "scipy:odeint"):  # they count differences, but take few Jacobians
        assert found.nfev < by_differences.nfev
    if form == "called":
        assert len(calls) > 1


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"method": "RK4", "step": 0.1, "max_step": 0.1}, "max_step: gnomon:RK4 .*step="),
        ({"method": "RK4", "step": 0.1, "first_step": 0.1}, "first_step: gnomon:RK4 .*step="),
        ({"method": "gnomon:Gauss 8-stage SIMD", "max_step": 0.1}, "max_step: gnomon:Gauss 8-stage SIMD"),
        ({"method": "gnomon:Taylor", "first_step": 0.1}, "first_step: gnomon:Taylor"),
        ({"jac": np.eye(2)}, "jac: gnomon:DOP853 .*leave it out"),
        ({"method": "Radau", "jac": lambda t, y: np.eye(3)}, r"shape \(3, 3\); an array of shape \(2, 2\) is wanted"),
        ({"method": "Radau", "jac": np.eye(2) * 1j}, "real and imaginary parts"),
        ({"max_step": -1.0}, "max_step=-1.0: give a positive number"),
        ({"min_step": 1.0}, "min_step=1.0: .* leave it out"),
    ],
)
def test_other_options_are_refused_by_name(changed: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        solve(**({"fun": swing, "t_span": (0, 1), "y0": [1.0, 0.0]} | changed))


LEAVE_THEIR_STEPS = {"gnomon:Forest-Ruth 4", "gnomon:Yoshida 6", "gnomon:Yoshida 8"}


@pytest.mark.parametrize("method", ALL)
def test_no_method_is_driven_past_the_end(method: str) -> None:
    """The times at which it evaluates equations, without the guard of `solve`, up to their rounding.

    Splitting methods with long substeps back and forth leave their own steps; `solve` then refuses a function that
    depends on time.
    """
    one, seen = ALL[method], list[float]()
    second = FirstOrder not in one.accepts
    fixed = isinstance(one.sweep, Steps)

    def watched(t: float, y: Any) -> Any:
        seen.append(t)
        return [-y[0]] if second else [y[1], -y[0]]

    form = SecondOrder(Called(watched, 1)) if second else FirstOrder(Called(watched, 2))
    for times in (np.array([1.0, 2.0]), np.array([0.3, 1.0, 2.13]), np.array([3e-5])):
        problem = Problem(form, 2, np.zeros(0), times, 1.0)
        setting = (problem.interval if problem.uniform else 0.05) if fixed else 1e-6
        try:
            prepared = Prepared(one, problem, setting)
        except Exception:  # whatever a method raises that needs formulas
            if not NEED_FORMULAS.match(method):
                raise
            return
        with prepared as run:
            run(np.array([[1.0, 0.0]]))
        assert seen
        if method not in LEAVE_THEIR_STEPS:
            assert max(seen) <= times[-1] * (1 + 1e-12)
        seen.clear()


@pytest.mark.filterwarnings("ignore:.*has no formulas")
@pytest.mark.parametrize("method", sorted(LEAVE_THEIR_STEPS))
def test_a_function_of_time_is_not_asked_outside_of_the_span(method: str) -> None:
    driven: Any = lambda t, q: [t - q[0] if t >= 0 else 0.0]  # noqa: E731 - as a user writes it
    with pytest.raises(Refused, match=r"outside of its steps, at t=.* take a method"):
        solve(driven, (0, 2), [1.0, 0.0], method, step=0.1, accelerations=True)
    still: Any = lambda t, q: [-abs(q[0])]  # noqa: E731
    assert solve(still, (0, 1), [1.0, 0.0], method, step=0.1, accelerations=True).success


def falling(t: float, state: Any, p: Any) -> Any:
    return state[1], -9.81


def ground(t: float, state: Any, p: Any) -> Any:
    return (state[0],)


def bounce(t: float, state: Any, p: Any) -> Any:
    return state[0], -p[0] * state[1]


def resting(t: float, state: Any, p: Any) -> Any:
    return 0.0 * state[0], 0.0 * state[1]


def at_rest(t: float, state: Any, p: Any) -> Any:
    return 0.0 * state[0], 0.0 * state[1]


def flight(t: float, state: Any, p: Any) -> str:
    return "flight"


def bouncing(settle: float, has_limit: bool = False) -> Hybrid:
    """A ball that falls from rest; the parameter is its coefficient of restitution."""
    impact = Transition("impact", "flight", ground, -1, bounce, "flight")
    limits = (("impact", "rest", at_rest),) if has_limit else ()
    return Hybrid(
        (Mode("flight", falling), Mode("rest", resting)), flight, (impact,), settle, frozenset({"rest"}), limits
    )


@pytest.mark.parametrize("method", [m for m in ALL if ALL[m].library != "gnomon"] + ["RK4", "gnomon:RKN 6(4)"])
def test_the_unit_of_time_does_not_matter(method: str) -> None:
    """An oscillation over 1e-13 and 1e13 s has the error that it has over 1 s: no absolute limit of a library counts."""
    one, errors = ALL.get(method), []
    second = one is not None and FirstOrder not in one.accepts
    for span in (1.0, 1e-13, 1e13):
        w = 3 / span
        fun: Any = (lambda t, q, w: [-w * w * q[0]]) if second else (lambda t, y, w: [w * y[1], -w * y[0]])
        setting = {"step": span / 50} if method == "RK4" else {"rtol": 1e-8}
        found = solve(fun, (0, span), [1.0, 0.0], method, [span], args=(w,), accelerations=second, **setting)
        errors.append(abs(found.y[0, -1] - math.cos(3)))
    assert max(errors) < max(1.5 * errors[0], 1e-9), "or far below the tolerance of 1e-8"


@pytest.mark.parametrize("method", ["gnomon:DOP853 [events]", "scipy:RK45 [events]", "scipy:LSODA [events]"])
@pytest.mark.parametrize("span", [1e-13, 1e13])
def test_an_event_over_a_tiny_span_is_located(method: str, span: float) -> None:
    """SciPy alone finds it to 9e-16 s, here .2 % of the span."""
    fun: Any = lambda t, y, w: [w * y[1], -w * y[0]]  # noqa: E731 - as a user writes it

    def crossing(t: float, y: Any, w: float) -> Any:
        return y[0]

    crossing.terminal = True  # type: ignore[attr-defined]
    found = solve(fun, (0, span), [1.0, 0.0], method, args=(3 / span,), events=crossing, rtol=1e-10)
    assert found.t[-1] == pytest.approx(math.pi / 6 * span, rel=1e-8)


def test_a_form_over_a_tiny_span_is_refused_where_events_would_be_early() -> None:
    ball = bouncing(settle=1e-30)
    with pytest.raises(Refused, match=r"SciPy locates events to .*smaller unit"):
        solve(ball, (0, 1e-13), [1e-26, 0.0], "scipy:RK45 [events]", args=(0.5,))


def sliding_block(t: float, y: Any) -> Any:
    """It stops at t = 2, and sign(v) then changes in every step."""
    return [y[1], -np.sign(y[1])]


def very_stiff(t: float, y: Any) -> Any:
    return [y[1], -1e7 * (y[1] - math.cos(t)) * (1.0 if t > -1 else 0.0)]


@pytest.mark.filterwarnings("ignore:.*has no formulas")
@pytest.mark.parametrize("filtered", ["error", "default"])
@pytest.mark.parametrize(
    ("function", "method", "says"),
    [
        (sliding_block, "gnomon:DOP853", r"at t=2[.:].*derivative of y\[1\] jumps between -1 and 1 .*y\[1\] changes"),
        (sliding_block, "scipy:LSODA", r"at t=2[.:].*derivative of y\[1\] jumps between -1 and 1 .*y\[1\] changes"),
        (very_stiff, "gnomon:DOP853", r"at t=0\.\d+: .*no derivative jumps.*y\[1\] changes fastest.*stiff"),
    ],
)
def test_steps_that_collapse_are_announced(
    function: Any, method: str, says: str, filtered: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With time, coordinate and way out, by three times MANY calls. As an error, where warnings are errors."""
    monkeypatch.setattr(call_watch, "MANY", 3000)
    calls = 0

    def counted(t: float, y: Any) -> Any:
        nonlocal calls
        if isinstance(t, float):
            calls += 1
            if calls > 9000:
                raise RuntimeError("enough")
        return function(t, y)

    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter(filtered)
        warnings.filterwarnings("ignore", message=".*has no formulas")
        with pytest.raises(UserWarning if filtered == "error" else ValueError) as raised:
            solve(counted, (0, 10), [0.0, 2.0], method)
    text = str(raised.value) if filtered == "error" else str(told[0].message)
    assert re.search(says, text)
    assert filtered == "error" or (len(told) == 1 and told[0].filename == __file__)
    assert ("sliding_friction" in text) == (function is sliding_block)


@pytest.mark.filterwarnings("ignore:.*has no formulas", "error:.*after 1000 calls")
def test_many_calls_that_get_on_are_not_announced(monkeypatch: pytest.MonkeyPatch) -> None:
    """Calls of equal progress; and fixed steps are as short as they were asked to be."""
    monkeypatch.setattr(call_watch, "MANY", 1000)
    rough: Any = lambda t, y: [y[1], -abs(1.0) * y[0] if y[0] > -9 else 0.0]  # noqa: E731 - as a user writes it
    assert solve(rough, (0, 20), [1.0, 0.0], "scipy:ode dop853", max_step=0.05).nfev > 4000  # type: ignore[operator]
    assert solve(sliding_block, (0, 2.2), [0.0, 2.0], "RK4", step=1e-3).success


@pytest.mark.parametrize("method", [m for m in lookup.everything() if m.endswith("[events]") and "Euler" not in m])
@pytest.mark.parametrize(("settle", "restitution"), [(1e-9, 0.5), (math.nan, 0.5), (1e-30, 0.9)])
def test_an_accumulation_of_impacts_is_located(method: str, settle: float, restitution: float) -> None:
    """At t = sqrt(2 h / g) (1 + e) / (1 - e), with the words of the form that state the motion after it.

    Not by Euler's method, whose ball gains energy.
    """
    setting = {"step": 0.01} if "RK4 " in method else {"rtol": 1e-10}
    found = solve(bouncing(settle), (0, 20), [1.0, 0.0], method, args=(restitution,), **setting)
    assert found.status == -1
    assert "`impact`" in found.message
    assert "limits=" in found.message
    assert "settle" in found.message
    goal = math.sqrt(2 / 9.81) * (1 + restitution) / (1 - restitution)
    said = re.search(r"accumulate at t = ([\d.]+)", found.message)
    assert said is not None
    assert float(said[1]) == pytest.approx(goal, rel=1e-6)
    assert np.all(found.t <= goal)


@pytest.mark.parametrize("method", [m for m in lookup.everything() if m.endswith("[events]") and "Euler" not in m])
def test_with_settle_and_limits_the_motion_goes_on(method: str) -> None:
    setting = {"step": 0.01} if "RK4 " in method else {"rtol": 1e-10}
    found = solve(bouncing(1e-6, has_limit=True), (0, 5), [1.0, 0.0], method, args=(0.5,), **setting)
    assert found.success
    assert np.array_equal(found.y[:, -1], [0.0, 0.0])
    too_small = solve(bouncing(math.nan, has_limit=True), (0, 5), [1.0, 0.0], method, args=(0.5,), **setting)
    assert "enters its limit mode `rest` only" in too_small.message


FRICTION = [m for m, one in lookup.everything().items() if Friction in one.accepts or Hybrid in one.accepts]


@pytest.mark.parametrize("method", FRICTION)
def test_a_sliding_body_sticks_and_slips(method: str) -> None:
    """An oscillation that loses 2 k / w^2 in each half of a period and sticks where the spring is too weak; a push
    that moves a body to and fro, which it sets in motion when it exceeds the friction."""
    order = lookup.everything()[method].order or 4
    fixed = isinstance(lookup.everything()[method].sweep, Steps)
    setting = {"step": 1e-3} if fixed else {"rtol": 1e-9}
    close = 2e-2 if order == 1 else 1e-6
    block = sliding_friction(lambda t, y, k: -k * y[0], kinetic=1.0, static=1.5, args=(9,))
    found = solve(block, (0, 10), [1.0, 0.0], method, **setting)
    assert np.array_equal(found.y[1, -8:], np.zeros(8))
    assert found.y[0, -1] == pytest.approx(1 - 4 * 2 / 9, abs=close)
    times = np.pi * np.array([1.5, 2.5, 3.5])
    pushed = sliding_friction(lambda t, y, a: a * np.cos(t), kinetic=lambda t, y, a: 1.0, args=(1.2,))
    turns = solve(pushed, (0, times[-1]), [0.0, 0.0], method, times, **setting)
    right, left = (slid(begin) for begin in (0.0, -math.acos(1 / 1.2)))
    assert turns.y[0] == pytest.approx([right - left, right, right - left], abs=close)
    assert np.array_equal(turns.y[1], np.zeros(3))


def slid(begin: float) -> float:
    """The way of a body under 1.2 cos(t) - 1 that starts at rest, until it stops."""

    def speed(t: float) -> float:
        return 1.2 * (math.sin(t) - math.sin(begin)) - (t - begin)

    end = brentq(speed, 0.8, 2.0, xtol=1e-14)
    return 1.2 * (math.cos(begin) - math.cos(end) - math.sin(begin) * (end - begin)) - (end - begin) ** 2 / 2


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ((0.0, -1.0), "kinetic=-1.0: give"),
        ((0.0, 2.0, 1.0), "static=1.0 is below kinetic=2.0"),
        ((lambda t, y: abs(y[0]), 1.0), "<lambda> .*has no formulas"),
    ],
)
def test_friction_that_is_no_friction_is_named(given: Any, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        sliding_friction(*given)


@cache
def swinging(span: tuple[float, float]) -> Any:
    return solve_ivp(swing, span, [1.0, 0.3], "DOP853", rtol=1e-12, atol=1e-13, dense_output=True, max_step=0.1).sol


@pytest.mark.parametrize("span", [(0.0, 10.0), (10.0, 0.0)])
@pytest.mark.parametrize("method", ["gnomon:RK4", "gnomon:Störmer-Verlet", *(m for m in ALL if m not in FIXED)])
def test_dense_output_is_the_solution_between_its_times(method: str, span: tuple[float, float]) -> None:
    """As accurate as the states at its times, but for the tolerance."""
    one = ALL[method]
    second = SecondOrder in one.accepts and FirstOrder not in one.accepts
    fun: Any = (lambda t, q: [-np.sin(q[0])]) if second else swing
    setting = {"step": 0.02} if method in FIXED else {"rtol": 1e-7}
    found = solve(fun, span, [1.0, 0.3], method, accelerations=second, dense_output=True, **setting)
    sol = found.sol
    assert sol is not None
    assert (sol.t_min, sol.t_max) == (0.0, 10.0)
    assert sol(3.0).shape == (2,)
    assert np.array_equal(sol([3.0, 4.0])[:, 0], sol(3.0))
    times = np.linspace(0.05, 9.95, 100)
    exact = swinging(span)
    # Where a library ends a step at each time, many times change the error.
    between = solve(
        fun,
        span,
        [1.0, 0.3],
        method,
        np.sort(times)[:: int(np.sign(span[1] - span[0]))],
        accelerations=second,
        **setting,
    )
    at_times = max(np.abs(one.y - exact(one.t)).max() for one in (found, between))
    if method == "gsl:msbdf":  # each time that ends a step costs it accuracy
        assert "depends on the times at which its steps end" in found.message
        return
    assert np.abs(sol(times) - exact(times)).max() < 2 * at_times + 2e-7
    assert "depends on the times" not in found.message or method.startswith("arkode:ARKStep DIRK")
    assert sol.error < (1e-4 if method in FIXED else 1e-7)
    with pytest.raises(ValueError, match="give times from 0 to 10"):
        sol(10.1)


@pytest.mark.parametrize("method", ["gnomon:DOP853", "scipy:RK45", "gnomon:Radau IIA 5"])
def test_dense_output_follows_a_long_motion(method: str) -> None:
    """Eight polynomials cannot follow its 40 turns: they are halved until they do."""
    times = np.linspace(1, 249, 200)
    given: dict[str, Any] = {"fun": swing, "t_span": (0, 250), "y0": [1.0, 0.3], "method": method, "rtol": 1e-7}
    found, between = solve(**given, dense_output=True), solve(**given, t_eval=times)
    assert found.sol is not None
    assert np.abs(found.sol(times) - between.y).max() < 1e-4
    assert len(found.sol.ends) > 40


@pytest.mark.filterwarnings("ignore:.*has no formulas")
def test_dense_output_has_jumps_impacts_and_a_terminal_event() -> None:
    """Where a derivative or the state jumps, one polynomial ends and another begins."""
    by_jumps = solve(held("right"), (0, END), [0.5], jumps=KNOTS, dense_output=True, rtol=1e-10)
    times = np.linspace(0, END, 1001)
    assert by_jumps.sol is not None
    assert by_jumps.sol(times)[0] == pytest.approx([held_exactly(t) for t in times], abs=1e-8)
    unknown = solve(held("right"), (0, END), [0.5], dense_output=True, rtol=1e-8)
    assert "`sol` has an error of" in unknown.message
    assert "jumps=" in unknown.message
    ball = solve(bouncing(1e-9), (0, 1.2), [1.0, 0.0], "gnomon:DOP853 [events]", args=(0.5,), dense_output=True)
    first = math.sqrt(2 / 9.81)
    assert ball.sol is not None
    assert ball.sol(first - 1e-9)[1] == pytest.approx(-9.81 * first, rel=1e-6)
    assert ball.sol(first + 1e-9)[1] == pytest.approx(9.81 * first / 2, rel=1e-6)
    ended = solve(swing, (0, 100), [1.0, 0.0], events=early, dense_output=True)
    assert ended.sol is not None
    assert ended.sol.t_max == ended.t[-1]
    assert ended.sol(0.005)[0] == pytest.approx(1 - math.sin(1) * 0.005**2 / 2, abs=1e-10)
    assert ended.message == "A terminal event occurred."
    singular = solve(lambda t, y: [1 / (y[0] - 1.0)], (0, 1), [1.0], dense_output=True)
    assert singular.status == -1
    assert singular.sol is None  # it did not leave its start
    infinite = solve(lambda t, y: y**2, (0, 2), [1.0], dense_output=True)
    assert infinite.sol is not None
    assert infinite.sol.t_max == infinite.t[-1] < 1
    assert infinite.sol(0.9)[0] == pytest.approx(10, rel=1e-6)

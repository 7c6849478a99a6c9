"""`solve` on equations of the reader's own: the motion is the exact one, as SciPy's where SciPy has it; wrong input is named."""

import math
import re
import warnings
from collections.abc import Callable
from functools import partial
from math import sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, NBody, SecondOrder
from gnomon.harness.contract.integrator import Refused, Steps
from gnomon.harness.registry import lookup
from gnomon.harness.running import own_functions
from scipy.integrate import solve_ivp

import gnomon
from gnomon import solve

ALL = {
    one.id: one
    for one in lookup.everything().values()
    if {FirstOrder, SecondOrder} & set(one.accepts) and lookup.missing(one) is None
}
QUICK = ("gnomon:RK4", "gnomon:Störmer-Verlet", "gnomon:DOP853", "scipy:RK45")
TIMES = (0.7, 0.71, 1.9, 2.0, 6.3)
START, ENDS = [1.0, 0.3], (0.0, 10.0)
CLOSE = 1e-8
"""Solutions at a tolerance of 1e-10 over two periods."""


def growth(t: float, y: Any) -> Any:
    return (y[1], -4.0 * y[0] + t)


def accelerated(t: float, q: Any, k: float) -> Any:
    return [-k * q[0] + t]


def exact(t: float) -> tuple[float, float]:
    """The motion of q'' = -4 q + t from q = 1/8 + .3, q' = 1/4 at t = 1/2."""
    return t / 4 + 0.3 * math.cos(2 * (t - 0.5)), 0.25 - 0.6 * math.sin(2 * (t - 0.5))


def error(method: str) -> float:
    integrator, start = ALL[method], exact(0.5)
    setting = {"step": 2.0**-9} if isinstance(integrator.sweep, Steps) else {"rtol": 1e-8}
    second = SecondOrder in integrator.accepts and FirstOrder not in integrator.accepts
    f: Callable[..., Any] = accelerated if second else growth
    given: dict[str, Any] = {"args": (4.0,), "accelerations": True} if second else {}
    times = [0.5 + t for t in TIMES]
    found = solve(f, (0.5, times[-1]), start, method, times, **setting, **given)
    return float(np.max(np.abs(found.y.T - [exact(0.5 + t) for t in TIMES])))


@pytest.mark.parametrize("method", [*QUICK, *(pytest.param(m, marks=pytest.mark.slow) for m in ALL if m not in QUICK)])
def test_the_motion_is_the_exact_one_at_decimal_times(method: str) -> None:
    """Steps of 2^-9 of a method of order p leave some (2^-8)^p times the span; a tolerance some hundred times itself."""
    order = ALL[method].order if isinstance(ALL[method].sweep, Steps) else None
    assert error(method) < (1e-5 if order is None else 20 * 2.0 ** (-8 * min(order, 4)))


def by_scipy(**changed: Any) -> Any:
    given = {"fun": swing, "t_span": ENDS, "y0": START, "method": "DOP853", "rtol": 1e-12, "atol": 1e-14} | changed
    return solve_ivp(**given)


def swing(t: float, y: Any, k: float = 1.0) -> Any:
    return y[1], -k * np.sin(y[0])


class Pendulum:
    """Equations as people write them: methods, helpers, arrays that are filled."""

    k = 1.0

    def motion(self, t: float, y: Any) -> Any:
        slope = np.zeros_like(y)
        slope[0], slope[1] = y[1], -self.k * self.pull(y)
        return slope

    def pull(self, y: Any) -> Any:
        return np.sin(y[0])


def filled(t: float, y: Any) -> Any:
    slope = np.empty(2)
    slope[:1] = y[1:]
    slope[1] = -math.sin(y[0])
    return slope


def unpacked(t: float, y: Any) -> list[Any]:
    angle, rate = y
    return [rate, -sin(angle)]


def in_a_loop(t: float, y: Any) -> Any:
    coupling = np.array([[0.0, 1.0], [0.0, 0.0]])
    return coupling @ y + np.array([0.0, -1.0]) * sum(np.sin(y[k]) for k in range(1))


WRITTEN: dict[str, Callable[..., Any]] = {
    "lambda, list, NumPy": lambda t, y: [y[1], -np.sin(y[0])],
    "tuple, math": lambda t, y: (y[1], -math.sin(y[0])),
    "method, array like the state": Pendulum().motion,
    "new array": filled,
    "unpacked": unpacked,
    "matrix, loop": in_a_loop,
    "partial": partial(swing, k=1.0),
}


@pytest.mark.parametrize("name", WRITTEN)
def test_equations_are_compiled_as_one_writes_them(name: str) -> None:
    """Without a warning: they are not called from Python."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = solve(WRITTEN[name], ENDS, START, rtol=1e-12)
    assert found.success
    assert found.t.shape == (64,)
    assert found.y.shape == (2, 64)
    assert np.abs(found.y - by_scipy(t_eval=found.t).y).max() < CLOSE


def test_arguments_are_parameters_and_other_objects_are_constants() -> None:
    """A second call with another number takes the same compiled code, and has the other motion."""

    def driven(t: float, y: Any, k: float, names: dict[str, float], c: float, force: Any) -> Any:
        return y[1], -k * math.sin(y[0]) - c * y[1] + names["a"] * force[1]

    compiled = set()
    for k in (1.0, 2.0):
        args = (k, {"a": 0.5}, 0.125, np.array([0.0, 0.25]))
        found = solve(driven, ENDS, START, args=args, rtol=1e-12)
        there = by_scipy(fun=driven, args=args, t_eval=found.t)
        assert np.abs(found.y - there.y).max() < CLOSE
        clock, start = own_functions.Clock(0.0, 1.0), np.array(START)
        equations = own_functions.OwnEquations(driven, clock, own_functions.Arguments(args), start, False)
        assert equations.parameters == [k, 0.125]
        compiled.add(equations.forms[0].equations)  # type: ignore[union-attr]
    assert len(compiled) == 1


def test_equations_may_branch_on_an_argument() -> None:
    """Its numbers are constants then: every value has formulas of its own."""

    def damped(t: float, y: Any, c: float) -> Any:
        return [y[1], -y[0] - c * y[1]] if c > 0 else [y[1], -y[0]]

    for c in (0.0, 0.5):
        found = solve(damped, ENDS, START, "gnomon:Taylor", args=(c,))
        assert np.abs(found.y - by_scipy(fun=damped, args=(c,), t_eval=found.t).y).max() < 1e-6


def test_an_import_inside_a_function_is_read_as_one_outside() -> None:
    """Else it has no formulas: `math.sin` takes numbers alone."""

    def inside(t: float, y: Any) -> Any:
        import math as m
        from math import sin as s

        import numpy as n

        return [y[1], -s(y[0]) - n.cos(y[1]) + m.exp(-t)]

    def outside(t: float, y: Any) -> Any:
        return [y[1], -sin(y[0]) - np.cos(y[1]) + math.exp(-t)]

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found, known = (solve(each, ENDS, START, "gnomon:Taylor", rtol=1e-10) for each in (inside, outside))
    assert np.array_equal(found.y, known.y)


def branching(t: float, y: Any) -> Any:
    return (y[1], -sin(y[0])) if y[0] > -9 else (0.0, 0.0)


def tabulated(t: float, y: Any) -> Any:
    return [np.interp(y[1], [-9.0, 9.0], [-9.0, 9.0]), -np.sin(y[0])]


@pytest.mark.parametrize(
    "function", [branching, tabulated, lambda t, y: (y[1], -abs(1.0) * math.sin(abs(y[0])) * np.sign(y[0]))]
)
@pytest.mark.parametrize(
    ("method", "setting"),
    [("gnomon:DOP853", {"rtol": 1e-12}), ("RK4", {"step": 1e-3}), ("scipy:LSODA", {"rtol": 1e-11}), ("Radau", {})],
)
def test_equations_without_formulas_are_called_and_it_is_said_once(
    function: Callable[..., Any], method: str, setting: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The warning names function and line, and the measured cost of a call."""
    monkeypatch.setattr(own_functions, "_TOLD", set())
    where = f"line {function.__code__.co_firstlineno}"
    with pytest.warns(UserWarning, match=rf"test_solve.py, {where}\) has no formulas .* µs a call") as told:
        found = solve(function, ENDS, START, method, **setting)
    assert {each.filename for each in told} == {__file__}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = solve(function, ENDS, START, method, **setting)
    assert np.array_equal(found.y, again.y)
    assert np.abs(found.y - by_scipy(t_eval=found.t).y).max() < 1e-6
    assert found.nfev
    assert found.nfev > 50


@pytest.mark.filterwarnings("ignore:.*has no formulas")
@pytest.mark.parametrize("method", ["gnomon:Radau IIA 5", "gnomon:Gauss 8-stage SIMD", "gnomon:Taylor"])
def test_a_method_that_needs_formulas_refuses_other_equations(method: str) -> None:
    with pytest.raises(Refused, match=rf"{method} needs the equations as formulas, and branching \(.*branch"):
        solve(branching, ENDS, START, method)


NEED_FORMULAS = re.compile("gnomon:(Radau|Gauss 8-stage SIMD|Taylor)|heyoka|diffrax")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*has no formulas")
@pytest.mark.parametrize("method", ALL)
def test_every_method_that_needs_no_derivatives_takes_equations_without_formulas(method: str) -> None:
    """With the states that it has for the same equations without the branch, to round-off or to its tolerance."""
    one = ALL[method]
    plain, opaque = swing, branching
    given: dict[str, Any] = {"step": 1 / 256} if isinstance(one.sweep, Steps) else {"rtol": 1e-8}
    if SecondOrder in one.accepts and FirstOrder not in one.accepts:
        plain, opaque = (lambda t, q: [-np.sin(q[0])]), (lambda t, q: [-sin(q[0])] if q[0] > -9 else [0.0])
        given["accelerations"] = True
    if NEED_FORMULAS.match(method):
        with pytest.raises(Refused, match="needs the equations as formulas"):
            solve(opaque, ENDS, START, method, **given)
        return
    states = [solve(function, ENDS, START, method, **given).y for function in (plain, opaque)]
    assert np.abs(states[0] - states[1]).max() < 1e-5


def test_time_runs_backward() -> None:
    """The way back ends at the start, for derivatives and for accelerations."""
    there = solve(swing, ENDS, START, rtol=1e-12)
    back = solve(swing, ENDS[::-1], there.y[:, -1], rtol=1e-12)
    assert back.t[0] == 10.0
    assert back.t[-1] == 0.0
    assert np.abs(back.y[:, -1] - START).max() < CLOSE
    for method in ("gnomon:RKN 12(10)", "gnomon:DOP853"):
        back = solve(lambda t, q: [-np.sin(q[0])], (10, 0), there.y[:, -1], method, rtol=1e-12, accelerations=True)
        assert np.abs(back.y[:, -1] - START).max() < CLOSE


def test_the_clock_of_the_user_is_the_clock_of_the_equations() -> None:
    forced = lambda t, y: [y[1], -y[0] + np.cos(3 * t)]  # noqa: E731 - as a user writes it
    for span in ((2.0, 9.0), (9.0, 2.0)):
        found = solve(forced, span, START, rtol=1e-12)
        assert np.abs(found.y - by_scipy(fun=forced, t_span=span, t_eval=found.t).y).max() < CLOSE


def crossing(t: float, y: Any) -> Any:
    return y[0]


def rising(t: float, y: Any) -> Any:
    return y[1]


def late(t: float, y: Any) -> Any:
    return t - 7.5


rising.direction = 1  # type: ignore[attr-defined]
late.terminal = True  # type: ignore[attr-defined]


@pytest.mark.parametrize("span", [(0.0, 10.0), (10.0, 0.0)])
@pytest.mark.parametrize(
    ("method", "setting"),
    [("gnomon:DOP853", {"rtol": 1e-12}), ("RK45", {"rtol": 1e-11}), ("RK4", {"step": 1e-3})],
)
def test_events_are_those_of_scipy(method: str, setting: dict[str, float], span: tuple[float, float]) -> None:
    """Number, times, states and end, in both directions of time. A start on an event is an event for SciPy alone."""
    for start in ([1.0, 0.0], [0.0, 1.0]):
        events = [crossing, rising, late]
        found = solve(swing, span, start, method, events=events, **setting)
        there = by_scipy(t_span=span, y0=start, events=events, t_eval=found.t)
        assert found.status == there.status == 1
        for k in range(len(events)):
            real = there.t_events[k] != span[0]
            assert len(found.t_events[k]) == real.sum()
            assert np.allclose(found.t_events[k], there.t_events[k][real], rtol=0, atol=CLOSE)
            assert np.allclose(found.y_events[k], there.y_events[k].reshape(-1, 2)[real], rtol=0, atol=CLOSE)
        assert np.abs(found.y - there.y).max() < CLOSE


def test_the_equations_of_a_case_are_solved() -> None:
    case = gnomon.case("pendulum_simple", L=2)
    found = solve(case.equations, (0, case.times[-1]), case.start, t_eval=case.times, rtol=1e-12)
    assert np.abs(found.y.T - case.sample(case.times)).max() < CLOSE


def test_the_equations_of_a_case_have_its_numbers() -> None:
    case = gnomon.case("pendulum_simple")
    with pytest.raises(ValueError, match="args="):
        solve(case.equations, ENDS, case.start, args=(9.8, 2.0))


def test_a_long_wrong_argument_is_shortened() -> None:
    with pytest.raises(ValueError, match="t_eval=") as raised:
        solve(growth, ENDS, START, t_eval=[float(-t) for t in range(100_000)])
    assert len(str(raised.value)) < 500


def test_a_method_that_gives_up_says_why_and_keeps_the_states_before() -> None:
    """y' = y^2 from 1 is infinite at t = 1."""
    found = solve(lambda t, y: y**2, (0, 2), [1.0])
    assert found.status == -1
    assert not found.success
    assert "gnomon:DOP853" in found.message
    assert 0 < len(found.t) < 64
    assert np.isfinite(found.y).all()
    assert np.allclose(found.y[0], 1 / (1 - found.t), rtol=1e-6)


def test_an_absolute_tolerance_reaches_the_library() -> None:
    """A motion of a micrometre is nothing to an absolute tolerance of 1e-3."""
    small = lambda t, y: [y[1], -y[0]]  # noqa: E731 - as a user writes it
    coarse, fine = (solve(small, ENDS, [1e-6, 0.0], "scipy:DOP853", rtol=1e-6, atol=a) for a in (1e-3, 1e-14))
    assert coarse.nfev
    assert fine.nfev
    assert coarse.nfev < fine.nfev / 2


def raising(t: float, y: Any) -> Any:
    if t > 3:
        raise RuntimeError("too late")
    return y[1], -y[0]


def test_the_epsilon_of_ias15_has_its_name_and_is_not_a_tolerance() -> None:
    """Two bodies on circles about each other; the default is the library's own, at which the error is round-off."""
    pytest.importorskip("rebound")
    circles = NBody(lambda p: (0.75, 0.25), lambda s: (s[:6], s[6:]), lambda bodies: (*bodies[0], *bodies[1]))
    start = [-0.25, 0.0, 0.0, 0.0, -0.25, 0.0, 0.75, 0.0, 0.0, 0.0, 0.75, 0.0]
    given: dict[str, Any] = {"method": "rebound:IAS15", "t_eval": [2 * np.pi]}
    default, own, loose = (
        solve(circles, (0, 2 * np.pi), start, **given, **setting).y
        for setting in ({}, {"epsilon": 1e-9}, {"epsilon": 1e-3})
    )
    assert np.array_equal(default, own)
    assert not np.array_equal(loose, own)
    assert np.max(np.abs(own[:, 0] - start)) < 1e-12
    with pytest.raises(ValueError, match=r"rtol=1e-09: rebound:IAS15 has no such setting; give epsilon"):
        solve(circles, (0, 2 * np.pi), start, **given, rtol=1e-9)


@pytest.mark.filterwarnings("ignore:.*has no formulas")
@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"y0": [math.nan, 1.0]}, "y0="),
        ({"y0": [[1.0, 1.0]]}, "y0="),
        ({"y0": [[1.0], [1.0, 2.0]]}, "y0="),
        ({"y0": "ab"}, "y0='ab'"),
        ({"t_span": (0, 0)}, r"t_span=\(0, 0\): give two different"),
        ({"t_eval": [1.0, 1.0]}, "in order, from 0 to 10"),
        ({"t_eval": [11]}, "in order, from 0 to 10"),
        ({"rtol": 0.0}, "rtol=0.0"),
        ({"rtol": [1e-3]}, "a vector is not supported"),
        ({"atol": 1e-3}, "atol=0.001: gnomon:DOP853 has no absolute tolerance"),
        ({"step": 0.1}, "step=0.1: gnomon:DOP853 has no such setting; give rtol"),
        ({"method": "RK4"}, "gnomon:RK4 takes fixed steps: give step"),
        ({"method": "RK4", "rtol": 1e-3}, "rtol=0.001: gnomon:RK4 has no such setting; give step"),
        ({"tolerance": 0.1}, "tolerance=0.1: .* write rtol"),
        ({"epsilon": 1e-9}, "epsilon=1e-09: gnomon:DOP853 has no such setting; give rtol"),
        ({"method": "RK5"}, "no integrator is called 'RK5'"),
        ({"method": "DOP853"}, "gnomon:DOP853 or scipy:DOP853"),
        ({"method": "gnomon:RKMK 4"}, "needs equations as RigidBody"),
        ({"fun": 3}, "fun=3"),
        ({"fun": lambda t, y: (1.0, 2.0, 3.0)}, r"<lambda> \(.*test_solve.py, line \d+\) gives 3 values; 2 are wanted"),
        ({"fun": lambda t, y: (y[0] / 0, y["a"])}, "line .* raised IndexError"),
        ({"fun": raising}, r"raising \(.*, line \d+\) raised RuntimeError: too late, at t=3"),
        ({"args": (1.0,)}, r"growth .* raised TypeError.*y=\[[^;]*$"),
        ({"fun": lambda y, t: (y[1], -y[0])}, r"raised TypeError.*; it takes \(y, t\)"),
        ({"fun": lambda y, t: np.sin(y)}, r"gives 1 values; 2 are wanted; it takes \(y, t\)"),
    ],
)
def test_wrong_input_is_named(changed: dict[str, Any], says: str) -> None:
    given = {"fun": growth, "t_span": (0, 10), "y0": [1.0, 0.0]}
    with pytest.raises((ValueError, Refused), match=says):
        solve(**(given | changed))


def test_a_call_in_the_old_order_shows_the_new_one() -> None:
    with pytest.raises(
        ValueError, match=r"solve\(growth, \(0.0, 2.0\), \[1.0, 0.0\], .*t_eval=\[1.0, 2.0\], rtol=1e-09\)"
    ):
        solve(growth, 0.0, [1.0, 0.0], [1.0, 2.0], 1e-9, "gnomon:DOP853")  # type: ignore[arg-type]

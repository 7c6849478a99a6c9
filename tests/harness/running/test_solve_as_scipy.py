"""`solve` as SciPy's `solve_ivp`: nothing is dropped, events end where SciPy's do, no step crosses a jump of the input."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, SecondOrder
from gnomon.harness.contract.integrator import Steps
from gnomon.harness.registry import lookup
from scipy.integrate import solve_ivp

from gnomon import solve

ALL = {
    one.id: one
    for one in lookup.everything().values()
    if {FirstOrder, SecondOrder} & set(one.accepts) and lookup.missing(one) is None
}
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
    assert "in steps of 0.3." in solve(swing, (0, 10), [1.0, 0.0], "RK4", [1.1, 10.0], step=0.3).message

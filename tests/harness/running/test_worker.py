"""How often a worker times a trial, and from which starts; the seconds of each call are given by the test."""

from __future__ import annotations

import gc
import itertools
import time
from types import SimpleNamespace
from typing import Any, NoReturn

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.contract import validation
from gnomon.harness.contract.validation import Unusable
from gnomon.harness.running import worker
from gnomon.harness.running.worker import FEWEST_CALLS, Request, _Series
from gnomon.harness.scoring.perturbed_starts import perturbed_states

START = np.zeros(2)


def never_called(initial_states: Any) -> NoReturn:
    """Prepared where the call itself is replaced."""
    raise AssertionError


def timed(
    monkeypatch: pytest.MonkeyPatch, seconds: list[float], estimate: float, slow: float, block: float, repeats: int
) -> tuple[list[int], int, Any]:
    """The starts of the calls (0: the exact initial state; 1, 2, ...: perturbed), the start of the scored call, `others`."""
    given = iter(seconds)

    class Call:
        def __init__(self, solve: Any, start: Any, task: Any, keep: bool = True) -> None:
            assert not gc.isenabled()
            self.seconds, self.states, self.number = next(given), start, int(start[0])

    series = object.__new__(_Series)
    series.task = SimpleNamespace(start=START)  # type: ignore[assignment]
    series.perturbed = (np.full(2, float(k)) for k in itertools.count(1))
    monkeypatch.setattr(worker, "_Call", Call)
    request = Request(0.1, False, block, repeats, slow)
    calls, scored, others = series._timed(None, request, estimate, None)  # type: ignore[arg-type]
    assert gc.isenabled()
    return [call.number for call in calls], scored.number, others  # type: ignore[attr-defined]


def test_a_quick_call_is_repeated_from_new_states_until_the_block_is_full(monkeypatch: pytest.MonkeyPatch) -> None:
    numbers, scored, others = timed(monkeypatch, [0.25] * 9, 0.25, slow=1.0, block=1.25, repeats=9)
    assert (numbers, scored) == ([1, 0, 2, 3, 4], 0)
    assert np.array_equal(others, [1.0, 1.0]), "the states from another start, to compare with the scored ones"


def test_a_quick_call_is_made_at_most_repeats_times_and_at_least_three_times(monkeypatch: pytest.MonkeyPatch) -> None:
    assert timed(monkeypatch, [0.25] * 9, 0.25, slow=1.0, block=99.0, repeats=4)[0] == [1, 0, 2, 3]
    assert timed(monkeypatch, [0.25] * 9, 0.25, slow=1.0, block=0.0, repeats=9)[0] == [1, 0, 2][:FEWEST_CALLS]


def test_a_slow_call_is_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    assert timed(monkeypatch, [2.0] * 9, 2.0, slow=1.0, block=99.0, repeats=9)[:2] == ([0], 0)


def test_a_call_with_repeats_1_is_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    assert timed(monkeypatch, [0.25] * 9, 0.25, slow=1.0, block=99.0, repeats=1)[:2] == ([0], 0)


@pytest.mark.parametrize("repeats", [1, 9])
def test_a_call_that_is_quick_because_results_were_kept_is_followed_by_calls_from_new_states(
    monkeypatch: pytest.MonkeyPatch, repeats: int
) -> None:
    """It is quick if it takes less than half of the time from another state."""
    numbers, scored, _ = timed(monkeypatch, [0.9, 2.0, 2.0], 2.0, slow=1.0, block=99.0, repeats=repeats)
    assert (numbers, scored) == ([0, 1, 2], 0)
    assert timed(monkeypatch, [1.1], 2.0, slow=1.0, block=99.0, repeats=repeats)[0] == [0]


@pytest.mark.parametrize(
    ("counted", "repeats", "estimate"), [(0.25, 9, 0.5), (2.0, 9, 2.0), (0.25, 1, 0.25)], ids=["quick", "slow", "once"]
)
def test_a_quick_trial_is_warmed_up_with_plain_equations(
    monkeypatch: pytest.MonkeyPatch, counted: float, repeats: int, estimate: float
) -> None:
    """The time of a slow one, or of one that is made once, is estimated by the counting run."""
    found = []

    def noted(solve: Any, request: Request, seconds: float, others: Any) -> Any:
        found.append(seconds)
        raise LookupError

    series = object.__new__(_Series)
    series.task, series.perturbed = SimpleNamespace(start=START), iter([START])  # type: ignore[assignment]
    series.integrator = SimpleNamespace(prepare=lambda problem, setting: never_called)  # type: ignore[assignment]
    series.say = lambda stage, **content: None  # type: ignore[assignment]
    monkeypatch.setattr(series, "problem", lambda counted: None)
    monkeypatch.setattr(series, "_count", lambda setting: (7, counted, START))
    monkeypatch.setattr(series, "_timed", noted)
    monkeypatch.setattr(worker, "_Call", lambda solve, start, task: SimpleNamespace(seconds=0.5, states=start))
    with pytest.raises(LookupError):
        series.run(Request(0.1, True, 99.0, repeats, 1.0))
    assert found == [estimate]


def test_right_hand_sides_of_the_preparation_are_not_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = SimpleNamespace(buffer=np.zeros(3))

    def prepare(given: Any, setting: float) -> Any:
        given.buffer[-1] += 5
        return never_called

    def call(solve: Any, start: Any, task: Any) -> Any:
        problem.buffer[-1] += 7
        return SimpleNamespace(seconds=0.5, states=start)

    series = object.__new__(_Series)
    series.task, series.counting_starts = SimpleNamespace(start=START), [START]  # type: ignore[assignment]
    series.integrator = SimpleNamespace(prepare=prepare, counts_rhs=True)  # type: ignore[assignment]
    series.say = lambda stage, **content: None  # type: ignore[assignment]
    monkeypatch.setattr(series, "problem", lambda counted: problem)
    monkeypatch.setattr(worker, "_Call", call)
    assert series._count(Request(0.1, True, 0.0, 1, 0.0))[:2] == (7, 0.5)


def test_counting_runs_start_from_the_state_of_their_setting(monkeypatch: pytest.MonkeyPatch) -> None:
    """When they took the next unused start of timed calls, counts of SciPy's DOP853 differed by 1.9 % between two runs."""
    starts: list[float] = []

    def call(solve: Any, start: Any, task: Any) -> Any:
        starts.append(float(start[0]))
        return SimpleNamespace(seconds=0.5, states=start)

    for places in ((0, 1, 2, 3), (2, 0)):  # another worker continues in the middle of a sweep
        series = object.__new__(_Series)
        series.task = SimpleNamespace(start=START)  # type: ignore[assignment]
        series.perturbed = iter([])
        series.counting, series.counting_starts = (np.full(2, float(k)) for k in itertools.count(1)), []
        series.integrator = SimpleNamespace(prepare=lambda *_: never_called, counts_rhs=True)  # type: ignore[assignment]
        series.say = lambda stage, **content: None  # type: ignore[assignment]
        monkeypatch.setattr(series, "problem", lambda counted: SimpleNamespace(buffer=np.zeros(3)))
        monkeypatch.setattr(worker, "_Call", call)
        for place in places:
            series._count(Request(0.1, True, 0.0, 1, 0.0, place=place))
    assert starts == [1.0, 2.0, 3.0, 4.0, 3.0, 1.0]


def test_counting_runs_start_where_no_timed_call_does() -> None:
    case = get("pendulum_simple").rounded()
    sizes = np.ones(2)
    near = {state.tobytes() for state in itertools.islice(perturbed_states(case, None, sizes), 1000)}
    far = {state.tobytes() for state in itertools.islice(perturbed_states(case, None, sizes, worker.COUNTING_ULPS), 20)}
    assert len(far) == 20
    assert not near & far


def test_a_replaced_clock_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    worker._verify_clocks()
    for module, name in ((time, "perf_counter"), (time, "monotonic"), (worker, "perf_counter_ns")):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, lambda: 0)
            with pytest.raises(Unusable, match=f"replaced time.{name}: times from a replaced clock are invalid"):
                worker._verify_clocks()
    with monkeypatch.context() as patch:  # replaced before the worker was loaded
        patch.setattr(time, "perf_counter", changed := lambda: 0)
        patch.setitem(worker.CLOCKS, "perf_counter", changed)
        with pytest.raises(Unusable, match=r"replaced time\.perf_counter"):
            worker._verify_clocks()


@pytest.mark.parametrize(("count", "seconds", "fits"), [(10**9, 1e-3, False), (10**9, 0.1, True), (64, 0.0, True)])
def test_more_right_hand_sides_than_a_processor_can_do_are_named(count: int, seconds: float, fits: bool) -> None:
    if fits:
        validation.possible(count, seconds, "right-hand sides")
        return
    with pytest.raises(Unusable, match=r"claims 1000000000 right-hand sides in 0.001 s: one takes 1e-11 s at least"):
        validation.possible(count, seconds, "right-hand sides")


@pytest.mark.parametrize(
    ("rhs_calls", "steps", "change", "nothing_done"),
    [(0, 0, 0.0, True), (None, None, 0.0, True), (4, 0, 0.0, False), (None, 1, 0.0, False), (0, 0, 1.0, False)],
)
def test_a_call_without_steps_that_returns_the_start_did_nothing(
    rhs_calls: int | None, steps: int | None, change: float, nothing_done: bool
) -> None:
    call = SimpleNamespace(solution=SimpleNamespace(steps=steps), states=np.tile(START + change, (64, 1)))
    assert worker._did_nothing(call, START, rhs_calls) is nothing_done  # type: ignore[arg-type]


@pytest.mark.parametrize(("compiling", "made"), [(0, 1), (1, 2), (2, 3), (9, 3)])
def test_a_call_that_compiles_is_repeated(compiling: int, made: int) -> None:
    """At most twice: of a method that compiles in each call, compiling is part of its time."""
    series = object.__new__(_Series)
    calls = itertools.count(1)

    def call() -> int:
        number = next(calls)
        assert series.calling
        series.compilations += number <= compiling
        return number

    assert series._compiled(call) == made
    assert not series.calling

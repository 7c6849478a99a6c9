"""How often a worker times a trial, and from which starts; the seconds of each call are given by the test."""

import gc
import itertools
import time
from types import SimpleNamespace
from typing import Any, NoReturn, cast

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.contract.integrator import Solution, Solver
from gnomon.harness.contract.validation import Unusable
from gnomon.harness.measuring import prepared
from gnomon.harness.measuring.outcome import DELAYED
from gnomon.harness.measuring.perturbed_starts import perturb_start
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.running import worker
from gnomon.harness.running.worker import ANNOUNCED_SECONDS, FEWEST_CALLS, MOST_REPEATS, Request, _Series

START = np.zeros(2)
UNUSED = object.__new__(Prepared)
"""Prepared for nothing: `planted_series` replaces its calls."""


def never_called(initial_states: Any) -> NoReturn:
    """Prepared where the call itself is replaced."""
    raise AssertionError


def call_of(seconds: float, start: Any, delay: float | None = None) -> Any:
    return SimpleNamespace(
        seconds=seconds,
        states=start,
        number=int(start[0]),
        reset_seconds=None,
        delay_seconds=delay,
        waited=(delay or 0.0) / seconds,
    )


def planted_series(monkeypatch: pytest.MonkeyPatch, call: Any) -> _Series:
    """A series on START whose calls are `call(start)`."""
    series = object.__new__(_Series)
    series.task = SimpleNamespace(start=START, times=np.zeros(64), output="")  # type: ignore[assignment]
    series.perturbed = (np.full(2, float(k)) for k in itertools.count(1))
    series.say = lambda stage, **content: None  # type: ignore[assignment]
    monkeypatch.setattr(Prepared, "timed", lambda solver, start, keep=True: call(start))
    return series


def timed(
    monkeypatch: pytest.MonkeyPatch, seconds: list[float], estimate: float, slow: float, block: float, repeats: int
) -> tuple[list[int], int, Any]:
    """The starts of the calls (0: the exact initial state; 1, 2, ...: perturbed), the start of the scored call, `others`."""
    given = iter(seconds)

    def call(start: Any) -> Any:
        assert not gc.isenabled()
        return call_of(next(given), start)

    series = planted_series(monkeypatch, call)
    request = Request(0.1, False, block, repeats, slow)
    calls, scored, others = series._timed(UNUSED, request, estimate, None)
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


def test_a_call_whose_code_was_just_loaded_does_not_make_a_trial_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first call of a later launch took 2 s, calls from any state take 0.25 s: they fill the block as in the first launch."""
    numbers, scored, _ = timed(monkeypatch, [0.25] * 9, 2.0, slow=1.0, block=1.25, repeats=9)
    assert (numbers, scored) == ([0, 1, 2, 3, 4], 0)


def announced(monkeypatch: pytest.MonkeyPatch, seconds: float, estimate: float, repeats: int) -> list[bool]:
    """Whether each timed call of a trial was announced."""
    found: list[bool] = []

    def call(start: Any) -> Any:
        found.append("calling" in said)
        said.clear()
        return call_of(seconds, start)

    said: list[str] = []
    series = planted_series(monkeypatch, call)
    series.say = lambda stage, **content: said.append(stage)  # type: ignore[assignment]
    series._timed(UNUSED, Request(0.1, False, 99.0, repeats, 0.02), estimate, None)
    return found


def test_each_long_call_has_a_deadline_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three calls of .45 s after a counting run of .95 s were a timeout under a limit of 1 s. The first has the deadline that
    its preparation set. Of short calls many have one deadline, as each message takes time of a processor."""
    assert announced(monkeypatch, 0.45, 0.95, repeats=9) == [False, True, True]
    short = announced(monkeypatch, ANNOUNCED_SECONDS / 20, 1e-3, repeats=60)
    assert len(short) == 60
    assert 1 <= sum(short) <= 3


def delayed_calls(
    monkeypatch: pytest.MonkeyPatch, delays: list[float | None], repeats: int = 9, seconds: float = 99.0
) -> Any:
    """The calls of a slow trial, of a second each, that waited for a processor so long; its scored call; all starts.

    Repeats may take `seconds` together.
    """
    monkeypatch.setattr(worker, "REPEATED_SECONDS", seconds)
    given, starts = iter(delays), []

    def call(start: Any) -> Any:
        starts.append(int(start[0]))
        return call_of(1.0, start, next(given))

    series = planted_series(monkeypatch, call)
    calls, scored, _ = series._timed(UNUSED, Request(0.1, False, 0.0, repeats, 0.5), 1.0, None)
    return [one.delay_seconds for one in calls], scored, starts


def test_a_call_that_waited_for_a_processor_is_repeated_from_new_states(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its time is the time of the repeat. Its own states count: they are of the exact initial state."""
    most = DELAYED * 1.0
    delays, scored, starts = delayed_calls(monkeypatch, [0.3, 2 * most, most, 0.0])
    assert (delays, starts, scored.number) == ([most], [0, 1, 2], 0)
    assert delayed_calls(monkeypatch, [most, 0.0])[2] == [0], "not repeated"
    assert delayed_calls(monkeypatch, [None, 0.0])[2] == [0], "the system does not tell"
    assert delayed_calls(monkeypatch, [0.3, 0.0], repeats=1)[2] == [0], "a run for errors alone"


def test_of_calls_that_all_waited_the_least_delayed_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    delays, _, starts = delayed_calls(monkeypatch, [0.5, 0.4, 0.3, 0.6, 0.5, 0.4, 0.0])
    assert (delays, len(starts)) == ([0.3], 1 + MOST_REPEATS)


@pytest.mark.parametrize(("seconds", "repeated"), [(0.9, 0), (1.0, 1), (2.5, 2)])
def test_repeats_of_long_calls_take_a_limited_time(
    monkeypatch: pytest.MonkeyPatch, seconds: float, repeated: int
) -> None:
    """On a busy machine every long call waits: with five repeats of each, half of a run was repeats."""
    assert len(delayed_calls(monkeypatch, [0.5] * 7, seconds=seconds)[2]) == 1 + repeated


@pytest.mark.parametrize(
    ("readings", "seconds"),
    [
        ([{"1": 5_000_000}, {"1": 9_000_000}], 0.004),
        ([{"1": 5_000_000}, {"1": 5_000_000, "2": 3_000_000}], 0.003),
        ([{"1": 5_000_000, "2": 7_000_000}, {"1": 6_000_000}], 0.001),
        ([None, None], None),
    ],
    ids=["one thread", "a new thread", "an ended thread", "unknown"],
)
def test_the_delay_of_a_call_is_read_outside_of_its_time(
    monkeypatch: pytest.MonkeyPatch, readings: list[dict[str, int] | None], seconds: float | None
) -> None:
    """On a simulated clock, on which a reading takes a second and the call 0.1 s."""
    clock, given = [0], iter(readings)

    def read() -> dict[str, int] | None:
        clock[0] += 10**9
        return next(given)

    def solve(initial_states: Any) -> Any:
        clock[0] += 10**8
        return Solution(np.zeros((1, 64, 2)))

    monkeypatch.setattr(prepared, "perf_counter_ns", lambda: clock[0])
    monkeypatch.setattr(prepared, "run_delays", read)
    problem = SimpleNamespace(times=np.arange(64), dimension=2)
    call = prepared.Call(cast(Any, SimpleNamespace(solver=Solver(solve), problem=problem)), START, keep=True)
    assert call.seconds == pytest.approx(0.1)
    assert call.delay_seconds == (None if seconds is None else pytest.approx(seconds))
    assert call.waited == pytest.approx((seconds or 0.0) / 0.1)


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

    series = planted_series(monkeypatch, lambda start: call_of(0.5, start))
    series.integrator = SimpleNamespace(prepare=lambda problem, setting: never_called)  # type: ignore[assignment]
    monkeypatch.setattr(series, "problem", lambda counted: None)
    monkeypatch.setattr(series, "_count", lambda setting: (7, counted, START))
    monkeypatch.setattr(series, "_timed", noted)
    with pytest.raises(LookupError):
        series.run(Request(0.1, True, 99.0, repeats, 1.0))
    assert found == [estimate]


def test_right_hand_sides_of_the_preparation_are_not_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = SimpleNamespace(buffer=np.zeros(3))

    def prepare(given: Any, setting: float) -> Any:
        given.buffer[-1] += 5
        return never_called

    def call(start: Any) -> Any:
        problem.buffer[-1] += 7
        return call_of(0.5, start)

    series = planted_series(monkeypatch, call)
    series.counting_starts = [START]
    series.integrator = SimpleNamespace(prepare=prepare, counts_rhs=True)  # type: ignore[assignment]
    monkeypatch.setattr(series, "problem", lambda counted: problem)
    assert series._count(Request(0.1, True, 0.0, 1, 0.0))[:2] == (7, 0.5)


def test_counting_runs_start_from_the_state_of_their_setting(monkeypatch: pytest.MonkeyPatch) -> None:
    """When they took the next unused start of timed calls, counts of SciPy's DOP853 differed by 1.9 % between two runs."""
    starts: list[float] = []

    def call(start: Any) -> Any:
        starts.append(float(start[0]))
        return call_of(0.5, start)

    for places in ((0, 1, 2, 3), (2, 0)):  # another worker continues in the middle of a sweep
        series = planted_series(monkeypatch, call)
        series.perturbed = iter([])
        series.counting, series.counting_starts = (np.full(2, float(k)) for k in itertools.count(1)), []
        series.integrator = SimpleNamespace(prepare=lambda *_: never_called, counts_rhs=True)  # type: ignore[assignment]
        monkeypatch.setattr(series, "problem", lambda counted: SimpleNamespace(buffer=np.zeros(3)))
        for place in places:
            series._count(Request(0.1, True, 0.0, 1, 0.0, place=place))
    assert starts == [1.0, 2.0, 3.0, 4.0, 3.0, 1.0]


def test_counting_runs_start_where_no_timed_call_does() -> None:
    case = get("pendulum_simple").rounded()
    sizes = np.ones(2)
    near = {state.tobytes() for state in itertools.islice(perturb_start(case, None, sizes), 1000)}
    far = {state.tobytes() for state in itertools.islice(perturb_start(case, None, sizes, worker.COUNTING_ULPS), 20)}
    assert len(far) == 20
    assert not near & far


def test_a_replaced_clock_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    worker._verify_clocks()
    replaced = (
        (time, "perf_counter"), (time, "monotonic"), (worker, "perf_counter_ns"), (prepared, "perf_counter_ns"),
    )  # fmt: skip
    for module, name in replaced:
        with monkeypatch.context() as patch:
            patch.setattr(module, name, lambda: 0)
            with pytest.raises(Unusable, match=f"replaced time.{name}: times from a replaced clock are invalid"):
                worker._verify_clocks()
    with monkeypatch.context() as patch:  # replaced before the worker was loaded
        patch.setattr(time, "perf_counter", changed := lambda: 0)
        patch.setitem(worker.CLOCKS, "perf_counter", changed)
        with pytest.raises(Unusable, match=r"replaced time\.perf_counter"):
            worker._verify_clocks()


@pytest.mark.parametrize(
    ("rhs_calls", "steps", "change", "moves", "nothing_done"),
    [
        (0, 0, 0.0, True, True), (4, 0, 0.0, True, True), (None, 1, 0.0, True, True), (0, 0, 1.0, True, False),
        (0, 0, 0.0, False, True), (None, None, 0.0, False, True), (4, 0, 0.0, False, False), (None, 1, 0.0, False, False),
    ],
)  # fmt: skip
def test_a_call_that_returns_the_start_did_nothing_whatever_it_counts_unless_the_start_is_an_equilibrium(
    rhs_calls: int | None, steps: int | None, change: float, moves: bool, nothing_done: bool
) -> None:
    call = SimpleNamespace(solution=SimpleNamespace(steps=steps), states=np.tile(START + change, (64, 1)))
    task = SimpleNamespace(start=START, moves=moves)
    assert worker._has_done_nothing(call, task, rhs_calls) is nothing_done  # type: ignore[arg-type]


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

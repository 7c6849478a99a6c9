"""How often a trial is timed, and from which states, with calls whose seconds are given."""

from __future__ import annotations

import gc
import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from gnomon.harness import worker
from gnomon.harness.worker import FEWEST_CALLS, Order, _Series

START = np.zeros(2)


def timed(
    monkeypatch: pytest.MonkeyPatch, seconds: list[float], estimate: float, slow: float, block: float, repeats: int
) -> tuple[list[int], int, Any]:
    """The states that calls started from (0: the unmoved one, then 1, 2, ...), which was scored, `others`."""
    given = iter(seconds)

    class Call:
        def __init__(self, solve: Any, start: Any, task: Any, keep: bool = True) -> None:
            assert not gc.isenabled()
            self.seconds, self.states, self.number = next(given), start, int(start[0])

    series = object.__new__(_Series)
    series.task = SimpleNamespace(start=START)  # type: ignore[assignment]
    series.moved = (np.full(2, float(k)) for k in itertools.count(1))
    monkeypatch.setattr(worker, "_Call", Call)
    order = Order(0.1, False, block, repeats, slow)
    calls, scored, others = series._timed(None, order, estimate, None)  # type: ignore[arg-type]
    assert gc.isenabled()
    return [call.number for call in calls], scored.number, others  # type: ignore[attr-defined]


def test_a_quick_call_is_repeated_from_new_states_until_the_block_is_full(monkeypatch: pytest.MonkeyPatch) -> None:
    numbers, scored, others = timed(monkeypatch, [0.25] * 9, 0.25, slow=1.0, block=1.25, repeats=9)
    assert (numbers, scored) == ([1, 0, 2, 3, 4], 0)
    assert np.array_equal(others, [1.0, 1.0]), "the states of another start, to hold the scored ones against"


def test_at_most_as_often_as_ordered_and_no_fewer_than_three_times(monkeypatch: pytest.MonkeyPatch) -> None:
    assert timed(monkeypatch, [0.25] * 9, 0.25, slow=1.0, block=99.0, repeats=4)[0] == [1, 0, 2, 3]
    assert timed(monkeypatch, [0.25] * 9, 0.25, slow=1.0, block=0.0, repeats=9)[0] == [1, 0, 2][:FEWEST_CALLS]


def test_a_slow_call_is_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    assert timed(monkeypatch, [2.0] * 9, 2.0, slow=1.0, block=99.0, repeats=9)[:2] == ([0], 0)


def test_one_that_is_not_to_be_repeated_too(monkeypatch: pytest.MonkeyPatch) -> None:
    assert timed(monkeypatch, [0.25] * 9, 0.25, slow=1.0, block=99.0, repeats=1)[:2] == ([0], 0)


@pytest.mark.parametrize("repeats", [1, 9])
def test_a_call_that_is_quick_because_it_remembers_is_held_against_new_states(
    monkeypatch: pytest.MonkeyPatch, repeats: int
) -> None:
    """Less than half of what another state took."""
    numbers, scored, _ = timed(monkeypatch, [0.9, 2.0, 2.0], 2.0, slow=1.0, block=99.0, repeats=repeats)
    assert (numbers, scored) == ([0, 1, 2], 0)
    assert timed(monkeypatch, [1.1], 2.0, slow=1.0, block=99.0, repeats=repeats)[0] == [0]

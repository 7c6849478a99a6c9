"""Located events are compared with the exact ones by name and number."""

import pytest
from gnomon.cases.core.case import Event
from gnomon.harness.measuring.events import EventScore, score_events

TWO = (Event(1.0, "bounce", (0, -1), (0, 1)), Event(2.0, "bounce", (0, -1), (0, 1)))
SETTLED = (*TWO, Event(2.5, "limit", (0, 0), (0, 0)))


def test_the_same_events_have_no_error() -> None:
    assert score_events([(1.0, "bounce"), (2.0, "bounce")], TWO) == EventScore(0, 0, 0.0)
    assert score_events([], ()) == EventScore(0, 0, 0.0)


def test_missing_and_extra_events_are_counted_by_name() -> None:
    assert score_events([(1.0, "bounce")], TWO)[:2] == (1, 0)
    assert score_events([(1.0, "bounce"), (2.0, "bounce"), (3.0, "bounce")], TWO)[:2] == (0, 1)
    assert score_events([(1.0, "bounce"), (2.0, "stop")], TWO)[:2] == (1, 1)


def test_the_largest_error_of_a_time_counts() -> None:
    assert score_events([(1.25, "bounce"), (2.5, "bounce")], TWO).time_error == 0.5


@pytest.mark.parametrize(("declared", "error"), [(2.0, 0.0), (2.25, 0.0), (2.5, 0.0), (2.75, 0.25), (1.5, 0.5)])
def test_a_limit_may_be_declared_from_the_last_listed_event_on(declared: float, error: float) -> None:
    located = [(1.0, "bounce"), (2.0, "bounce"), (declared, "limit")]
    assert score_events(located, SETTLED) == EventScore(0, 0, error)

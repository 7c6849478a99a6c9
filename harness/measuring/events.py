"""Compares the events that an integrator located with the exact events."""

from collections.abc import Sequence
from typing import NamedTuple

from gnomon.cases.core.case import Event


class EventScore(NamedTuple):
    """The number of exact events not located, the number of located events that do not exist, the largest error (s)."""

    missing: int
    extra: int
    time_error: float


def score_events(located: Sequence[tuple[float, str]], exact: Sequence[Event]) -> EventScore:
    """Compare (time, name) pairs with the exact events: for each name, the k-th located event with the k-th exact one.

    The event `limit` is the time at which the integrator declares the motion settled. The settle rule allows any time
    from the last listed event before it to the exact limit time; the error is the distance from that interval.
    """
    missing = extra = 0
    error = 0.0
    for name in dict.fromkeys([name for _, name in located] + [event.name for event in exact]):
        times = [time for time, other in located if other == name]
        true = [float(event.time) for event in exact if event.name == name]
        missing += max(0, len(true) - len(times))
        extra += max(0, len(times) - len(true))
        if name == "limit":
            others = [0.0, *(float(event.time) for event in exact if event.name != name)]
            earliest = [max(time for time in others if time <= limit) for limit in true]
            errors = (max(c - a, a - b) for a, b, c in zip(times, true, earliest, strict=False))
            error = max([error, *errors])
        else:
            error = max([error, *(abs(a - b) for a, b in zip(times, true, strict=False))])
    return EventScore(missing, extra, error)

"""The clock of the panels: each reading is a tick later, so their work does not depend on the speed of the machine."""

import itertools

import pytest

TICK = 1e-3
"""Seconds between two readings: so long does each piece of work take that a panel times."""


@pytest.fixture(autouse=True)
def _ticking(monkeypatch: pytest.MonkeyPatch) -> None:
    """A panel that may spend n ticks reads the clock n times, in a process of its own too (a fork has this clock)."""
    readings = itertools.count()
    monkeypatch.setattr("gnomon.harness.stability.subjects.process_time", lambda: TICK * next(readings))

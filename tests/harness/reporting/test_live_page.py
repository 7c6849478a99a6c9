"""The page of a run that is under way: when it is due, and that a page that cannot be written does not end the run."""

from pathlib import Path

import pytest
from gnomon.harness.reporting import live_page
from gnomon.harness.reporting.live_page import EVERY_SECONDS, FIRST_SECONDS, MOST_SHARE, LivePage

LONGEST = 120.0
"""Seconds between two pages of a run whose pages take some seconds."""


@pytest.fixture
def now(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time, which a test sets."""
    clock = [0.0]
    monkeypatch.setattr(live_page, "monotonic", lambda: clock[0])
    return clock


def due_after(page: LivePage, now: list[float]) -> int:
    """Seconds until the page is due again."""
    began = now[0]
    while not page.due():
        now[0] += 1.0
    return round(now[0] - began)


@pytest.mark.parametrize("seconds", [0.0, 10.0, 15.0, 300.0])
def test_pages_come_every_two_minutes_and_take_a_fifth_of_the_time_at_most(
    monkeypatch: pytest.MonkeyPatch, now: list[float], tmp_path: Path, seconds: float
) -> None:
    def take_time(*_: object) -> Path:
        now[0] += seconds
        return tmp_path

    monkeypatch.setattr(live_page, "refresh", take_time)
    page = LivePage(tmp_path, tmp_path, pytest.fail, {})
    assert due_after(page, now) <= FIRST_SECONDS + 1
    page.take()
    waited = due_after(page, now)
    assert seconds / (seconds + waited) <= MOST_SHARE + 0.01
    if seconds <= 15:
        assert seconds + waited + 1 < LONGEST


def test_a_fault_of_the_page_does_not_end_the_run(
    monkeypatch: pytest.MonkeyPatch, now: list[float], tmp_path: Path
) -> None:
    def fail(*_: object) -> Path:
        raise KeyError("planted")

    monkeypatch.setattr(live_page, "refresh", fail)
    told: list[str] = []
    LivePage(tmp_path, tmp_path, told.append, {}).take()
    assert told == ["no page was written: KeyError('planted')"]


def test_a_run_goes_on_without_a_page(now: list[float], tmp_path: Path) -> None:
    """Nothing has run yet: the reason is told, and the next page is due later."""
    told: list[str] = []
    page = LivePage(tmp_path / "results.sqlite", tmp_path / "page", told.append, {})
    now[0] = EVERY_SECONDS + 1
    page.take()
    page.write()
    assert page.written is None
    assert not page.due()
    assert [text.startswith("no page was written: ") for text in told] == [True, True]
    assert "no results here" in told[0]

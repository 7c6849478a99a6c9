"""Progress in plain output and on a terminal."""

import io

import pytest
from gnomon.harness.system import progress
from gnomon.harness.system.progress import Progress
from rich.console import Console


@pytest.mark.parametrize("terminal", [False, True])
def test_the_remaining_time_is_not_shown_for_the_first_pieces(terminal: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """They differ from the others: after 16 s, at 1 of 301, 4763 s were shown for a run that took 10 minutes."""
    now = 0.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    written = io.StringIO()
    console = Console(file=written, force_terminal=terminal, width=120, get_time=lambda: now)
    with Progress(console=console) as shown:
        shown.begin("series", 40)
        for count in range(1, 40):
            now += 3.0
            written.truncate(0)
            shown.advance()
            if terminal:
                assert shown._bars is not None
                shown._bars.refresh()
                visible = "-:--:--" not in written.getvalue()
            else:
                visible = "s remaining" in written.getvalue()
            assert visible is (count >= 4), f"{count} of 40"


def test_the_remaining_time_counts_work_and_not_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten expensive pieces of 9 s, then a hundred of 1 s: by pieces, 900 s would be predicted after the first ten."""
    now = 0.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    written = io.StringIO()
    with Progress(console=Console(file=written, width=120)) as shown:
        shown.begin("series", 110, 10 * 9.0 + 100)
        for seconds in [9.0] * 10 + [1.0] * 99:
            now += seconds
            written.truncate(0)
            shown.advance(seconds)
            if now > 60:
                assert f"about {190 - now:.0f} s remaining" in written.getvalue()


def test_the_remaining_time_is_shown_after_a_minute_however_little_is_done() -> None:
    assert progress.remaining_seconds(59.0, 1.0, 100.0) is None
    assert progress.remaining_seconds(61.0, 1.0, 100.0) == pytest.approx(61 * 99)
    assert progress.remaining_seconds(61.0, 0.0, 100.0) is None

"""Progress in plain output and on a terminal."""

from __future__ import annotations

import io

import pytest
from gnomon.harness.running import progress
from gnomon.harness.running.progress import Progress
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

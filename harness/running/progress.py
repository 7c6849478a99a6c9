"""Progress with remaining time: a bar on a terminal, plain lines elsewhere."""

import time
from typing import Protocol, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Task, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bars
from rich.text import Text

LINE_SECONDS = 10.0
"""Minimum time between two lines of plain output."""
ENOUGH = 0.1
"""The share of the pieces after which the remaining time is shown: the first pieces predict the others badly."""


def enough(count: float, total: float | None) -> bool:
    """Whether `count` pieces of `total` suffice to estimate the remaining time."""
    return total is not None and count >= ENOUGH * total


class Interlude(Protocol):
    """Work of the process that runs trials, which must not overlap one: writing the page of the run."""

    def due(self) -> bool:
        """Whether it is time for the work."""

    def take(self) -> None:
        """Do the work. The pool calls this if it is `due` and no worker has a request."""


class Remaining(TimeRemainingColumn):
    """The remaining time, shown after a share ENOUGH of the pieces."""

    def render(self, task: Task) -> Text:
        return super().render(task) if enough(task.completed, task.total) else Text("-:--:--")


class Progress:
    """Counts the pieces of one phase after another. `quiet` shows nothing; `interlude` is taken between trials."""

    def __init__(self, quiet: bool = False, console: Console | None = None, interlude: Interlude | None = None) -> None:
        self.console = console or Console(stderr=True)
        self.interlude = interlude
        self.quiet = quiet
        self._bars: Bars | None = None
        self._task: object = None
        self._name, self._total, self._count = "", 0, 0
        self._began = self._printed = 0.0

    def __enter__(self) -> Self:
        if not self.quiet and self.console.is_terminal:
            columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
            self._bars = Bars(*columns, TextColumn("remaining"), Remaining(), console=self.console)
            self._bars.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bars is not None:
            self._bars.stop()
            self._bars = None

    def begin(self, name: str, total: int) -> None:
        """A new phase of `total` pieces."""
        self._name, self._total, self._count = name, total, 0
        self._began = self._printed = time.monotonic()
        if self._bars is not None:
            self._task = self._bars.add_task(name, total=total)

    def advance(self) -> None:
        """One piece is done."""
        self._count += 1
        if self._bars is not None:
            self._bars.advance(self._task)  # type: ignore[arg-type]
            return
        now = time.monotonic()
        last = self._count == self._total
        if self.quiet or not (last or now - self._printed > LINE_SECONDS):
            return
        self._printed = now
        elapsed = now - self._began
        tail = ""
        if not last and enough(self._count, self._total):
            remaining = elapsed / self._count * (self._total - self._count)
            tail = f", about {remaining:.0f} s remaining"
        self.console.print(f"{self._name}: {self._count} of {self._total} in {elapsed:.0f} s{tail}", highlight=False)

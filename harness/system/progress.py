"""Progress with remaining time: a bar on a terminal, plain lines elsewhere."""

import time
from typing import Protocol, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, ProgressColumn, Task, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars
from rich.text import Text

LINE_SECONDS = 10.0
"""Minimum time between two lines of plain output."""
ENOUGH, ENOUGH_SECONDS = 0.1, 60.0
"""Share of the work, or seconds, after which the remaining time is shown: the first pieces predict it badly."""


def remaining_seconds(elapsed: float, done: float, total: float) -> float | None:
    """The time of the rest of the work at the rate so far; None while too little is done."""
    if done <= 0 or (done < ENOUGH * total and elapsed < ENOUGH_SECONDS):
        return None
    return elapsed / done * max(total - done, 0.0)


class Interlude(Protocol):
    """Work of the process that runs trials, such as writing the page of the run, which must not overlap a trial."""

    def due(self) -> bool:
        """Whether it is time for the work."""

    def take(self) -> None:
        """Do the work. The pool calls this if it is `due` and no worker has a request."""


class Remaining(ProgressColumn):
    """The remaining time, from the work done."""

    def render(self, task: Task) -> Text:
        remaining = remaining_seconds(task.elapsed or 0.0, task.fields["done"], task.fields["work"])
        minutes, seconds = divmod(round(remaining or 0.0), 60)
        return Text("-:--:--" if remaining is None else f"{minutes // 60}:{minutes % 60:02}:{seconds:02}")


class Progress:
    """Counts the pieces of one phase after another. `quiet` shows nothing; `interlude` is taken between trials."""

    def __init__(self, quiet: bool = False, console: Console | None = None, interlude: Interlude | None = None) -> None:
        self.console = console or Console(stderr=True)
        self.interlude = interlude
        self.quiet = quiet
        self._bars: Bars | None = None
        self._task: object = None
        self._name, self._total, self._count = "", 0, 0
        self._work, self._done = 0.0, 0.0
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

    def tell(self, text: str) -> None:
        """Print a line, unless this is quiet."""
        if not self.quiet:
            self.console.print(text, highlight=False, markup=False)

    def begin(self, name: str, total: int, work: float | None = None) -> None:
        """Begin a phase of `total` pieces, with their `work` in all; by default the work of each is 1."""
        self._name, self._total, self._count = name, total, 0
        self._work, self._done = float(total) if work is None else work, 0.0
        self._began = self._printed = time.monotonic()
        if self._bars is not None:
            self._task = self._bars.add_task(name, total=total, done=0.0, work=self._work)

    def advance(self, work: float = 1.0) -> None:
        """Count one piece with its work as done."""
        self._count += 1
        self._done += work
        if self._bars is not None:
            self._bars.update(self._task, advance=1, done=self._done)  # type: ignore[arg-type]
            return
        now = time.monotonic()
        last = self._count == self._total
        if self.quiet or not (last or now - self._printed > LINE_SECONDS):
            return
        self._printed = now
        elapsed = now - self._began
        remaining = None if last else remaining_seconds(elapsed, self._done, self._work)
        tail = "" if remaining is None else f", about {remaining:.0f} s remaining"
        self.console.print(f"{self._name}: {self._count} of {self._total} in {elapsed:.0f} s{tail}", highlight=False)

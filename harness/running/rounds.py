"""Rounds of repeated launches: of the integrators that may be the fastest of an open cell."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from time import monotonic
from typing import Any

from gnomon.harness.results import contenders
from gnomon.harness.results.contenders import MOST_LAUNCHES, THIRD, Names

NAME = "repeated launches"
"""The name of a run's record of its rounds in its environment."""
DECIDED = "no cell is open"
SPENT = "the time was spent"
EXHAUSTED = "further launches do not decide them, or fail"
WORDS = {THIRD: "of third parties", contenders.YOURS: "of your integrators", contenders.OWN: "of gnomon's methods"}
LARGEST = 2 * MOST_LAUNCHES
"""The largest number of a launch: an integrator whose repeated launches fail stays open."""


@dataclass
class Rounds:
    """When further launches run, and which.

    `rows` reads the timed rows of the file; `minutes` is the budget of the run, from `began` on the clock `monotonic`.
    """

    rows: Callable[[], Iterable[Mapping[str, Any]]]
    minutes: float
    began: float

    def __post_init__(self) -> None:
        self.begun = 0
        """The number of rounds that have begun."""

    def over(self) -> bool:
        """Whether the time is spent."""
        return monotonic() > self.began + 60 * self.minutes

    def next(self) -> tuple[int, dict[Names, set[float]]] | None:
        """The launch of the next round, and its settings by (case, variant, integrator id); None without a further round.

        All series of a round have one launch, so that its effect cancels between them. A launch that an earlier run began
        is not used again: its times are from another hour.
        """
        if self.over():
            return None
        times, scatter = contenders.times(self.rows())
        series = contenders.find_undecided(times, scatter)
        keys = [key for row in times if (row.case, row.variant, row.integrator_id) in series for key in row.times]
        launch = 1 + max((launch for _, launch in keys), default=LARGEST)
        if not series or launch > LARGEST:
            return None
        self.begun += 1
        return launch, series

    def record(self) -> str:
        """The cells that are open at the end, and the scatter, for the environment of the run and for its last lines."""
        cells = describe_open(self.rows())
        begun = f"{self.begun} round{'s' * (self.begun != 1)} of repeated launches"
        if cells.startswith(DECIDED):
            return f"{begun}; {cells}"
        return f"{begun}; {f'{SPENT}: {self.minutes:g} min' if self.over() else EXHAUSTED}; {cells}"


def describe_open(rows: Iterable[Mapping[str, Any]]) -> str:
    """The numbers of open cells of rows of `reading.rows`, and the scatter, in words."""
    times, scatter = contenders.times(rows)
    counts = contenders.open_cells(times, scatter)
    words = [f"{open_} of {cells} {WORDS[kind]}" for kind, (open_, cells) in counts.items() if cells]
    is_open = any(open_ for open_, _ in counts.values())
    text = f"open cells (a case at one error): {', '.join(words)}" if is_open else DECIDED
    return f"{text}; {scatter[contenders.OWN].text()}"

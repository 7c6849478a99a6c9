"""The page of a run that is under way, written anew as results come and never during a trial."""

from collections.abc import Callable, Mapping
from pathlib import Path
from time import monotonic

from gnomon.cases.core.case import Case
from gnomon.harness.reporting.up_to_date import refresh

FIRST_SECONDS = 30.0
"""Seconds from the beginning of a run to its first page. With the start, the end of the trials under way and the
writing, 8 s of a processor from empty caches, a page is there within 60 s."""
EVERY_SECONDS = 90.0
"""Seconds from one page to the beginning of the next: under two minutes with the end of trials and the writing."""
MOST_SHARE = 1 / 5
"""Largest share of a run's time that writing may take; on a slow machine pages are rarer."""


class LivePage:
    """An `Interlude` of `gnomon.harness.running.pool` that writes the report of `database` into `folder`.

    `tell` prints why a page could not be written, for example because nothing has run yet: the run goes on.
    """

    def __init__(
        self, database: Path, folder: Path, tell: Callable[[str], None], cases: Mapping[str, type[Case]]
    ) -> None:
        self.database, self.folder = database, folder
        self._tell, self._cases = tell, cases
        self._began = monotonic()
        self._next = self._began + FIRST_SECONDS
        self.written: Path | None = None
        """The page, once it was written."""
        self.first_seconds: float | None = None
        """Seconds from the beginning to the first page."""

    def due(self) -> bool:
        return monotonic() > self._next

    def take(self) -> None:
        """Write the page, and print any failure: a page must not end its run."""
        try:
            self.write()
        except Exception as error:
            self._tell(f"no page was written: {error!r}")

    def write(self) -> None:
        began = monotonic()
        try:
            self.written = refresh(self.database, self.folder, self._cases)
            self.first_seconds = self.first_seconds or monotonic() - self._began
        except (ValueError, OSError) as error:
            self._tell(f"no page was written: {error}")
        finally:
            ended = monotonic()
            self._next = ended + max(EVERY_SECONDS, (ended - began) * (1 / MOST_SHARE - 1))

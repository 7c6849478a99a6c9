"""Visits to a page in a real browser: the system's Chromium, driven by Playwright."""

import shutil
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from playwright.sync_api import ConsoleMessage, Page, Request

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)
BROWSER = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium found: install the system's package `chromium`"),
]
"""The marks of tests that need a browser."""
LIMIT = 300_000
"""Milliseconds after which a page that never shows what is expected fails its test; on a quiet machine it takes seconds."""


@dataclass
class Visit:
    """A page, errors and warnings of its console with its exceptions, and the addresses of all that it asked for."""

    page: Page
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.page.on("console", self._hear)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", self._note)

    def _hear(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning", "assert"):
            self.complaints.append(message.text)

    def _note(self, request: Request) -> None:
        if not request.url.startswith(("data:", "blob:")):
            self.requests.append(request.url)

    def open(self, path: Path) -> Page:
        """The page, once its script has started."""
        self.page.goto(path.resolve().as_uri())
        wait_until_ready(self.page)
        return self.page


def wait_until_ready(page: Page) -> None:
    page.wait_for_function("gnomonCharts.ready || gnomonCharts.failed")

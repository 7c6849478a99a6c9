"""A browser for the tests of pages."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from browser_visits import CHROMIUM, LIMIT, Visit
from playwright.sync_api import Browser, sync_playwright


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, timeout=LIMIT)
        yield browser
        browser.close()


@pytest.fixture
def visit(chromium: Browser) -> Iterator[Callable[..., Visit]]:
    """Makes visits of this width and height, with these settings of the browser."""
    contexts = []

    def begin(width: int = 1400, height: int = 900, **settings: Any) -> Visit:
        size: Any = {"width": width, "height": height}
        context = chromium.new_context(viewport=size, is_mobile=width < 600, **settings)
        context.set_default_timeout(LIMIT)
        contexts.append(context)
        return Visit(context.new_page())

    yield begin
    for context in contexts:
        context.close()

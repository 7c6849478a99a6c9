"""No test of this folder depends on the processor time of a solution, unless the test itself says what that is."""

import pytest


@pytest.fixture(autouse=True)
def _unhurried(unhurried: None) -> None:
    pass

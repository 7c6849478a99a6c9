"""No test of this folder depends on the processor time of a solution, unless the test itself says what that is.

Makes the builder of FMUs importable.
"""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(autouse=True)
def _unhurried(unhurried: None) -> None:
    pass

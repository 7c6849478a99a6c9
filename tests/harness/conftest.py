"""An invented run for tests of stores, analyses and reports."""

from pathlib import Path

import pytest
import synthetic


@pytest.fixture
def synthetic_results(tmp_path: Path) -> Path:
    """A results file with invented rows of every kind."""
    return synthetic.write(tmp_path / "results.sqlite")

"""Makes `synthetic` and `planted`, the helpers in this folder, importable by tests and by worker processes."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import synthetic


@pytest.fixture
def synthetic_results(tmp_path: Path) -> Path:
    """A results file with invented rows of every kind."""
    return synthetic.write(tmp_path / "results.sqlite")

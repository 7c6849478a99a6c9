"""Makes the helpers in this folder, and the second derivation of every case in `mass_points`, importable by tests."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parent / "mass_points")]

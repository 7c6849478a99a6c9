"""Makes the independent derivations (independent_*) importable by tests."""

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent / folder) for folder in ("derived_quantities", "mass_points")]

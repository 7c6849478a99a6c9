"""The planted integrators of tests/harness are found from here too."""

import sys
from pathlib import Path

for folder in (Path(__file__).parent, Path(__file__).parents[1] / "harness"):
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))

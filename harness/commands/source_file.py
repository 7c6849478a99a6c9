"""Where the source of a case, a check or an exact motion is."""

from __future__ import annotations

import sys


def source_file(kind: type) -> str:
    """The file of a class: below the root of the repository if it is gnomon's own, as `cases/orbits/two_body.py`."""
    package, _, rest = kind.__module__.partition(".")
    if package == "gnomon":
        return f"{rest.replace('.', '/')}.py"
    return getattr(sys.modules[kind.__module__], "__file__", None) or kind.__module__

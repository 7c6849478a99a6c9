"""Copies the declarations of the libraries to where they are read by people and by tools: docs/libraries.md, pyproject.toml.

`make libraries` is `python -m gnomon.harness.adapters.library_copies`, in a working tree.
"""

import json
import re
from pathlib import Path

from gnomon.harness.adapters.libraries import LIBRARIES, Library

PAGE, PROJECT = Path("docs/libraries.md"), Path("pyproject.toml")
HEAD = """# Libraries

gnomon runs the integrators of these third-party libraries. `make libraries` writes this page from their declarations in
`harness/adapters/libraries.toml`; CONTRIBUTING.md says how to add one.

| library | ids begin with | requirement | installed | licence |
|---|---|---|---|---|
"""
MARK = "# `make libraries` writes the next line.\n"


def page() -> str:
    """The text of PAGE."""
    rows = [
        f"| {one.title} | `{one.name}:` | `{one.requirement}` | {_installed(one)} | {one.licence} |\n"
        for one in LIBRARIES.values()
    ]
    return HEAD + "".join(rows)


def _installed(library: Library) -> str:
    wheels = "" if library.last_wheels is None else "; its wheels end with CPython {}.{}".format(*library.last_wheels)
    return (f"extra `{library.extra}`" if library.extra else "with gnomon") + wheels


def project(text: str) -> str:
    """The text of PROJECT with the extras of the libraries, and with their names where mypy ignores missing types."""
    lists = {"module": [f"{name}.*" for name in LIBRARIES]}
    for library in LIBRARIES.values():
        if library.extra:
            lists.setdefault(library.extra, []).append(library.installs)
    for name, values in lists.items():
        line = f"{name} = {json.dumps(values)}"
        text = re.sub(rf"(?<={MARK}){name} = \[.*\]", line, text)
    return text


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    PROJECT.write_text(project(PROJECT.read_text(encoding="utf-8")), encoding="utf-8")

"""Copies the declarations of the libraries to where they are read by people and by tools.

These are docs/libraries.md, a line of README.md, and lines of pyproject.toml.

`make libraries` is `python -m gnomon.harness.adapters.library_copies`, in a working tree.
"""

import json
import re
from pathlib import Path

from gnomon.harness.adapters.absent import ABSENT
from gnomon.harness.adapters.libraries import LIBRARIES, Library

PAGE, PROJECT, README = Path("docs/libraries.md"), Path("pyproject.toml"), Path("README.md")
HEAD = """# Libraries

gnomon runs the integrators of these third-party libraries. CONTRIBUTING.md says how to add a library.

| library | ids begin with | requirement | installed | licence |
|---|---|---|---|---|
"""
DRIVEN_HEAD = """
## How gnomon calls them

A measured time should be the library's own time. Therefore gnomon compiles its own part of each call as far as the library
allows. Each section names the compiled part, the part in Python, and the reasons for settings. If a library's manual advises
something else, open an issue with the sentence of the manual.

Times are processor times on Linux with Python 3.11, as medians of at least 25 pairs: one process ran the adapter before and after
a change in turn, and both gave the same states to rounding. A *null call* is a call over nearly no span; if the method has fixed
steps, its time excludes the steps.
"""
ABSENT_HEAD = """
## Known integrators that do not take part

"No wheel" means that pip finds no compiled package for CPython 3.11 on Linux.

| integrators | reason |
|---|---|
"""
MARK = "# `make libraries` writes the next line.\n"
EXTRAS = "[project.optional-dependencies]\n"
README_MARK = "<!-- `make libraries` writes the next line. -->\n"


def page() -> str:
    """The page docs/libraries.md: a table of the libraries, how each is driven, and libraries that are left out."""
    rows = [
        f"| {library.title} | `{library.name}:` | `{library.requirement}` | {_say_installed(library)} | {library.licence} |\n"
        for library in LIBRARIES.values()
    ]
    driven = [f"\n### {entry.title}\n\n{entry.driven.strip()}\n" for entry in LIBRARIES.values() if entry.driven]
    absent = [f"| {library.title} | {library.reason} |\n" for library in ABSENT]
    return "".join([HEAD, *rows, DRIVEN_HEAD, *driven, ABSENT_HEAD, *absent])


def readme(text: str) -> str:
    """The text of README with the names of the best-known integrators that do not take part."""
    names = ", ".join(library.readme for library in ABSENT if library.readme)
    line = f"[docs/libraries.md](docs/libraries.md) says why known integrators do not take part: {names} and others."
    return re.sub(rf"(?<={README_MARK}).*", line, text)


def _say_installed(library: Library) -> str:
    if library.debian:
        return f"by the system; Debian: `{library.debian}`"
    wheels = "" if library.last_wheels is None else "; its wheels end with CPython {}.{}".format(*library.last_wheels)
    return (f"extra `{library.extra}`" if library.extra else "with gnomon") + wheels


def project(text: str) -> str:
    """The text of PROJECT with the extras of the libraries, and with their names where mypy ignores missing types."""
    lists = {"module": [f"{name}.*" for name, library in LIBRARIES.items() if not library.debian]}
    for library in LIBRARIES.values():
        if library.extra:
            lists.setdefault(library.extra, []).append(library.installs)
    for name, values in lists.items():
        line = f"{name} = {json.dumps(values)}"
        text, replaced = re.subn(rf"(?<={MARK}){name} = \[.*\]", line, text)
        if not replaced:  # a new extra
            text = text.replace(EXTRAS, f"{EXTRAS}{MARK}{line}\n")
    return text


def write() -> None:
    """Write all copies, in a working tree."""
    PAGE.write_text(page(), encoding="utf-8")
    for path, change in ((PROJECT, project), (README, readme)):
        path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    write()

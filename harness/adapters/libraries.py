"""The third-party libraries that adapters drive, as `libraries.toml` declares them.

The file is data, so that reading it imports no library, and that a word for the page changes no key of a result.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import Any

from gnomon.harness.contract.declared import read_declared


@dataclass(frozen=True)
class Library:
    """A table of `libraries.toml`."""

    name: str
    """The name by which Python imports it, and the first part of the ids of its integrators."""
    requirement: str
    """Its distribution with the versions that were tried, as pip takes it."""
    licence: str
    title: str
    """Its name in texts; without, `name`."""
    modules: tuple[str, ...]
    """Its adapters: modules of this folder with a tuple `INTEGRATORS`; without, the module `name`."""
    families: Mapping[str, str] = field(default_factory=dict)
    """The families of its integrators on general equations, by a pattern of their names, the first match counts. A family
    of `registry/families.toml` with one of their forms comes first."""
    quick: tuple[str, ...] = ()
    """Its integrators in the suite `quick`, without the name of the library."""
    debian: str | None = None
    """The packages of Debian that have it, for a library of the system: pip has none, and Python cannot import it. Its
    adapters tell its version."""
    extra: str | None = None
    """The extra of pyproject.toml that installs it; None for a library that is installed with gnomon."""
    last_wheels: tuple[int, int] | None = None
    """The newest CPython that it has wheels for; None if it has wheels for every supported one."""
    depends: tuple[str, ...] = ()
    """The other distributions whose versions change its results."""
    preload: tuple[str, ...] = ()
    """The modules that worker processes find imported. A library that starts threads at its import has none: processes
    are forked from the one that imports them."""
    calls: Mapping[str, str] = field(default_factory=dict)
    """How its integrators call the equations of a case, by a pattern of their names, the first match counts: `compiled`
    together with the method, `direct` as machine code, through `python`; or they move bodies by their `own` equations, an
    `engine` on a scene."""
    suite: str | None = None
    """The only suite in which it runs unless it is named; None if it runs in all."""
    driven: str = ""
    """How it is driven, for docs/libraries.md: what is compiled, what is Python, what a call costs. Markdown."""
    colour: str | None = None
    """In charts, by its name in templates/colours.toml of `reporting`; without, it has the colour of text."""

    def way(self, name: str) -> str:
        """How the integrator of this name calls the equations (see `calls`); empty if that is not declared."""
        return _first_match(self.calls, name)

    def family(self, name: str) -> str:
        """The family of the integrator of this name (see `families`); empty if that is not declared."""
        return _first_match(self.families, name)

    @property
    def package(self) -> str:
        """The name of its distribution."""
        return re.split(r"[^\w.-]", self.requirement)[0]

    @property
    def installs(self) -> str:
        """Its requirement, for the versions of Python for which it has wheels."""
        marker = (
            "" if self.last_wheels is None else f"; python_version < '{self.last_wheels[0]}.{self.last_wheels[1] + 1}'"
        )
        return self.requirement + marker

    @property
    def versions(self) -> tuple[str, ...]:
        """The distributions whose versions results record, and their keys hold."""
        return () if self.debian else (self.package, *self.depends)


def _read(name: str, table: Mapping[str, Any]) -> Library:
    row: dict[str, Any] = {"name": name, "title": name, "modules": (name,)}
    return Library(**row | {key: tuple(value) if isinstance(value, list) else value for key, value in table.items()})


def _first_match(values: Mapping[str, str], name: str) -> str:
    """The value of the first pattern that a name matches; empty without one."""
    return next((value for pattern, value in values.items() if fnmatchcase(name, pattern)), "")


LIBRARIES = {name: _read(name, table) for name, table in read_declared("adapters", "libraries.toml").items()}
"""By name, in the order in which gnomon lists them."""


def title(library: str) -> str:
    """The name of a library in texts; its own where it is not declared."""
    return LIBRARIES[library].title if library in LIBRARIES else library

"""One method of each library for each kind of system, as `representatives.toml` chooses it from the library's manual.

The file is data that no measurement changes. Reading it imports no library.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from gnomon.cases.core.numbers import nearest
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.declared import read_declared

STIFF, ROUGH = "stiff", "rough"
"""The kinds that depend on the numbers of a system and not on its form."""
NOT_CHOSEN = "none of its methods is chosen yet"
"""The reason of a declared library that the file does not name."""


@dataclass(frozen=True)
class Representative:
    """The method that stands for a library on a kind of system."""

    integrator: str
    """Its id."""
    quote: str
    """What the library's own manual says of it, verbatim."""
    source: str
    """The address of this page of the manual, or a path in gnomon's own repository."""


def representative(library: str, kind: str) -> Representative | None:
    """The method of a library for a kind of system; None without one, for which `reason` has the cause.

    A library without a choice for ROUGH has none here: the choice of the system's own kind holds. A library that is not
    listed has no representatives: it is a user's own. Raises ValueError for an unknown kind.
    """
    return representatives().get((library, _require_known(kind)))


def standing(library: str, kind: str, needed: str | None = None) -> Representative | None:
    """The method that stands for a library on a system of a kind, for a need whose own kind is `needed`.

    For ROUGH it is that of the system's kind if the library has no choice of its own.
    """
    choice = None if needed is None else representative(library, needed)
    return representative(library, kind) if choice is None and needed != STIFF else choice


def representatives() -> Mapping[tuple[str, str], Representative]:
    """All representatives, by library and kind."""
    return _read()[0]


def reason(library: str, kind: str) -> str | None:
    """Why a library has no representative for a kind; None if it has one, or is a user's own."""
    return _read()[1].get((library, _require_known(kind)))


@cache
def kinds() -> tuple[str, ...]:
    """Every kind: those of systems, by their form, then STIFF and ROUGH."""
    groups = read_declared("registry", "representatives.toml")["groups"]
    return (*groups["events"], *groups["smooth"], STIFF, ROUGH)


def expand(names: Sequence[str]) -> list[str]:
    """The kinds with these names, with the kinds of a group in the place of its name."""
    groups = read_declared("registry", "representatives.toml")["groups"]
    return [kind for name in names for kind in groups.get(name, [name])]


def _require_known(kind: str) -> str:
    if kind not in kinds():
        raise ValueError(f"no kind of system is called {kind!r}; {nearest(kind, kinds())}")
    return kind


@cache
def _read() -> tuple[dict[tuple[str, str], Representative], dict[tuple[str, str], str]]:
    """The representatives and the reasons of the file, by library and kind."""
    table = read_declared("registry", "representatives.toml")
    chosen: dict[tuple[str, str], Representative] = {}
    for row in table["choice"]:
        choice = Representative(row["integrator"], row["quote"], row["source"])
        library = choice.integrator.partition(":")[0]
        chosen |= {(library, kind): choice for kind in expand(row["kinds"])}
    reasons = {
        (library, kind): row["reason"]
        for row in table["none"]
        for kind in expand(row["kinds"])
        for library in row["libraries"]
    }
    named = {library for library, _ in (*chosen, *reasons)}
    unnamed = [library for library in LIBRARIES if library not in named]
    return chosen, reasons | {(library, kind): NOT_CHOSEN for library in unnamed for kind in kinds()}

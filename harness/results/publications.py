"""The numbers of all publications: a file with an entry for each: revision, day, machine, versions and numbers.

The name of a number has slashes: its quantity, then the integrator or the case. Times, whose names begin with `TIMES`, can
be compared on one machine only.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gnomon.cases.core.numbers import is_pattern, matching, nearest
from gnomon.harness.results import study_file
from gnomon.harness.results.visible import visible

FILE = Path("reports/history.json")
SCHEMA = 1
TIMES = "seconds"
DIGITS = 6
"""Significant digits of a number in the file."""


@dataclass(frozen=True)
class Entry:
    """A publication: the environment of its results, and its numbers by name."""

    environment: Mapping[str, str]
    numbers: Mapping[str, float]

    @property
    def key(self) -> tuple[str, ...]:
        """The key of an entry, which is equal for publications of one revision on one machine."""
        return self.environment["sources"], self.environment["machine"]

    @property
    def label(self) -> str:
        return f"{self.environment.get('date', '')} {self.environment.get('revision', '')[:8]}".strip()


def read(path: Path) -> list[Entry]:
    """All entries, the first one first. Raises ValueError without a file, or if it holds something else."""
    if not path.is_file():
        raise ValueError(
            f"{path}: no publication has been recorded here; `make publication` does, or name another file with --from"
        )
    try:
        history = json.loads(path.read_text(encoding="utf-8"))
        if history["schema"] != SCHEMA:
            raise ValueError(f"schema {history['schema']}, not {SCHEMA}")
        return [_entry(row) for row in history["entries"]]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        why = visible(f"{type(error).__name__}: {error}")
        raise ValueError(f"{path}: no history of gnomon's ({why}); name another file with --from") from None


def _entry(row: Any) -> Entry:
    made_by = {visible(str(name)): visible(str(value)) for name, value in row["environment"].items()}
    return Entry(
        made_by | {name: made_by[name] for name in ("sources", "machine")},  # these it must have
        {visible(str(name)): float(value) for name, value in row["numbers"].items()},
    )


def append(path: Path, entry: Entry) -> None:
    """Add an entry to the file; it replaces an entry with an equal key."""
    former = read(path) if path.exists() else []
    rounded = {name: float(f"{value:.{DIGITS}g}") for name, value in sorted(entry.numbers.items())}
    entries = [*(other for other in former if other.key != entry.key), Entry(entry.environment, rounded)]
    study_file.write({"schema": SCHEMA, "entries": [asdict(entry) for entry in entries]}, path)


def names(entries: Sequence[Entry]) -> list[str]:
    """The names of all numbers in these publications, sorted."""
    return sorted({name for entry in entries for name in entry.numbers})


def choose(entries: Sequence[Entry], wanted: Sequence[str]) -> list[str]:
    """The names that are wanted, patterns resolved. Raises ValueError for an unknown one."""
    known, chosen = names(entries), []
    for name in wanted:
        if not is_pattern(name) and name not in known:
            raise ValueError(f"no number is called {name!r}; {nearest(name, known)}; without a name, all are listed")
        chosen += matching(name, known) if is_pattern(name) else [name]
    return list(dict.fromkeys(chosen))


def is_time(name: str) -> bool:
    return name.startswith(TIMES)


def values(entries: Sequence[Entry], name: str) -> list[float | None]:
    """A number of each entry; None if it is missing, or if it is a time on another machine than the last value."""
    held = [entry for entry in entries if name in entry.numbers]
    machine = held[-1].environment["machine"] if held else None
    return [
        entry.numbers[name]
        if entry in held and (not is_time(name) or entry.environment["machine"] == machine)
        else None
        for entry in entries
    ]

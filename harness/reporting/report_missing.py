"""What a report says of a run that is not complete: how many of the planned trials are missing, and where."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gnomon.harness.results.outstanding import Planned, outstanding

SHOWN = 12
"""The most names in a list."""


def missing(path: Path) -> dict[str, Any] | None:
    """How many `trials` of the `planned` ones have no measurement; the cases of which none has one, those of which some
    have, and the libraries with how many theirs are; `others` is what else is outstanding, `text` all of it. None if nothing
    is.
    """
    found = outstanding(path)
    if not found.text:
        return None
    cases, libraries = (_by_name(found.planned, name) for name in ("case", "library"))
    lost = {name: total - done for name, (total, done) in libraries.items() if done < total}
    return {
        "text": found.text,
        "others": found.others,
        "planned": sum(total for total, _ in libraries.values()),
        "trials": found.trials,
        "cases": _shorten([name for name, (_, done) in cases.items() if done == 0]),
        "partly": _shorten([name for name, (total, done) in cases.items() if 0 < done < total]),
        "libraries": _shorten([f"{name} ({count})" for name, count in lost.items()]),
    }


def _by_name(planned: Sequence[Planned], field: str) -> dict[str, tuple[int, int]]:
    """Planned and measured trials by case or by library."""
    found: dict[str, tuple[int, int]] = {}
    for row in planned:
        total, done = found.get(getattr(row, field), (0, 0))
        found[getattr(row, field)] = total + row.trials, done + row.measured
    return found


def _shorten(names: Sequence[str]) -> dict[str, Any]:
    return {"count": len(names), "names": list(names[:SHOWN]), "more": max(len(names) - SHOWN, 0)}

"""What a report says of a run that is not complete: how many of the planned trials are missing, and where."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gnomon.harness.results import reading

SHOWN = 12
"""The most names in a list."""


def missing(path: Path, runs: Sequence[Mapping[str, Any]]) -> dict[str, Any] | None:
    """How many `trials` of the `planned` ones have no measurement; the cases of which none has one, those of which some
    have, and the libraries with how many theirs are. None if the last run ended and nothing is missing.

    With no trial missing and a run that has not ended, later launches are.
    """
    planned = reading.planned(path)
    cases, libraries = (_by_name(planned, column) for column in (0, 1))
    lost = {name: total - done for name, (total, done) in libraries.items() if done < total}
    if not lost and all(run["ended"] for run in runs[-1:]):
        return None
    return {
        "planned": sum(total for _, _, total, _ in planned),
        "trials": sum(lost.values()),
        "cases": _listed([name for name, (_, done) in cases.items() if done == 0]),
        "partly": _listed([name for name, (total, done) in cases.items() if 0 < done < total]),
        "libraries": _listed([f"{name} ({count})" for name, count in lost.items()]),
    }


def _by_name(planned: Sequence[tuple[str, str, int, int]], column: int) -> dict[str, tuple[int, int]]:
    """Planned and measured trials by case or by library."""
    found: dict[str, tuple[int, int]] = {}
    for row in planned:
        total, done = found.get(str(row[column]), (0, 0))
        found[str(row[column])] = total + row[2], done + row[3]
    return found


def _listed(names: Sequence[str]) -> dict[str, Any]:
    return {"count": len(names), "names": list(names[:SHOWN]), "more": max(len(names) - SHOWN, 0)}

"""The part of a report about a run that is not complete: the number of missing trials, and where they are."""

from collections.abc import Sequence
from typing import Any

from gnomon.harness.results.outstanding import Outstanding, Planned

SHOWN = 12
"""Largest number of names in a list."""


def missing(found: Outstanding) -> dict[str, Any] | None:
    """The trials without a measurement, counted by case and by library; None if nothing is outstanding.

    `trials` of the `planned` trials are missing. `cases`: the cases without a measurement; `partly`: the cases with
    some measurements; `libraries`: the libraries with their numbers of missing trials; `others`: outstanding shards and
    repeated launches; `text`: all of it in words.
    """
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
    """The numbers of planned and measured trials by case or by library."""
    found: dict[str, tuple[int, int]] = {}
    for row in planned:
        total, done = found.get(getattr(row, field), (0, 0))
        found[getattr(row, field)] = total + row.trials, done + row.measured
    return found


def _shorten(names: Sequence[str]) -> dict[str, Any]:
    return {"count": len(names), "names": list(names[:SHOWN]), "more": max(len(names) - SHOWN, 0)}

"""The part of a report about a run that is not complete: the number of missing trials, and where they are."""

from collections.abc import Sequence
from typing import Any

from gnomon.harness.results.outstanding import Outstanding, Planned

SHOWN = 12
"""Largest number of names in a list."""


def missing(outstanding: Outstanding) -> dict[str, Any] | None:
    """The trials without a measurement, counted by case and by library; None if nothing is outstanding.

    `trials` of the `planned` trials are missing. `cases`: the cases without a measurement; `partly`: the cases with
    some measurements; `libraries`: the libraries with their numbers of missing trials; `others`: outstanding shards and
    repeated launches; `text`: all of it in words.
    """
    if not outstanding.text:
        return None
    cases, libraries = (_by_name(outstanding.planned, name) for name in ("case", "library"))
    lost = {name: total - measured for name, (total, measured) in libraries.items() if measured < total}
    return {
        "text": outstanding.text,
        "others": outstanding.others,
        "planned": sum(total for total, _ in libraries.values()),
        "trials": outstanding.trials,
        "cases": _shorten([name for name, (_, measured) in cases.items() if measured == 0]),
        "partly": _shorten([name for name, (total, measured) in cases.items() if 0 < measured < total]),
        "libraries": _shorten([f"{name} ({count})" for name, count in lost.items()]),
    }


def _by_name(planned: Sequence[Planned], field: str) -> dict[str, tuple[int, int]]:
    """The numbers of planned and measured trials by case or by library."""
    counts: dict[str, tuple[int, int]] = {}
    for row in planned:
        total, measured = counts.get(getattr(row, field), (0, 0))
        counts[getattr(row, field)] = total + row.trials, measured + row.measured
    return counts


def _shorten(names: Sequence[str]) -> dict[str, Any]:
    return {"count": len(names), "names": list(names[:SHOWN]), "more": max(len(names) - SHOWN, 0)}

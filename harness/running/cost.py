"""The predicted cost of a series, and the division of a plan into parts of about equal cost: shards, and tasks of a cluster."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from gnomon.harness.contract.declared import declared
from gnomon.harness.running.plan import Series, Suite, launches

COSTS: dict[str, dict[str, float]] = declared("running", "costs.toml")
LONG_LIMIT = 0.5
"""Seconds: a default variant with this time limit or more runs at more settings, and the last ones take longest."""
LEFT_OUT = 1e-3
"""Seconds for the one row of a pair that cannot run."""
PIECES = 8
"""A shard has this number of consecutive parts from the whole plan: series of one case cost more than predicted together,
or less. More parts would make more shards compute the same exact motion."""

Item = TypeVar("Item")


def predicted_seconds(series: Series, suite: Suite, near_duplicates: bool = True) -> float:
    """Seconds that all launches of a series take, from costs that are the same on every machine."""
    if series.left_out is not None:
        return LEFT_OUT
    limit, often = suite.of(series.case).limit(series.case), launches(series, suite, near_duplicates)
    return launched_seconds(series.integrator.library, series.case.variant is not None, limit, often)


def launched_seconds(library: str, hard: bool, limit_seconds: float, often: int) -> float:
    """Seconds of a series of a library on a default or a hard variant, launched `often` times."""
    kind = "hard" if hard else "long" if limit_seconds >= LONG_LIMIT else "short"
    first, again = (COSTS[name].get(library, COSTS[name]["other"]) for name in (kind, "again"))
    return first + again * (often - 1)


def divided(items: Sequence[Item], seconds: Sequence[float], parts: int) -> list[list[Item]]:
    """The items in `parts` consecutive parts of about equal cost: each differs from the mean by at most the largest item.

    Consecutive, because series of one case need the same exact motion, which few parts then compute.
    """
    found: list[list[Item]] = [[] for _ in range(parts)]
    total, before = sum(seconds), 0.0
    for item, cost in zip(items, seconds, strict=True):
        found[min(parts - 1, int(parts * (before + cost / 2) / total))].append(item)
        before += cost
    return found


def shard(series: Sequence[Series], suite: Suite, near_duplicates: bool = True) -> list[Series]:
    """The series of the suite's shard. Each series is in exactly one shard, the same whatever the order of `series`."""
    place, count = suite.shard
    if count == 1:
        return list(series)
    ordered = sorted(series, key=lambda one: one.id)
    costs = [predicted_seconds(one, suite, near_duplicates) for one in ordered]
    return [one for piece in divided(ordered, costs, PIECES * count)[place - 1 :: count] for one in piece]

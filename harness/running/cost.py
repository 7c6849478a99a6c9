"""The predicted cost of a series, and the division of a plan into parts of about equal cost: shards and tasks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.sources import digest
from gnomon.harness.results.outstanding import SHARD, shard_text
from gnomon.harness.running.plan import Series, Suite, launches

COSTS: dict[str, dict[str, float]] = read_declared("running", "costs.toml")
LONG_LIMIT = 0.5
"""Time limit (s) from which a default variant runs at more settings; the last settings take longest."""
OWN_START = 0.5
OWN_SWEEP, OWN_TURNED = 3.5, 25.0
"""Seconds for the start of a series of a user's own integrator; and for its sweep, and with turned starts, in time limits.
In Python its steps become smaller until a trial takes the limit: the trials before take one more together, each is counted
and timed, and the last one is cut off."""
START = 2.0
"""Seconds for the first worker, which imports gnomon, and for the table at the end: most of the time of a small run."""
LEFT_OUT = 1e-3
"""Seconds for the single row of a pair that cannot run."""
PIECES = 8
"""Number of consecutive parts of the whole plan in a shard, as series of one case may together cost more or less than
predicted. With more parts, more shards would compute one exact motion."""

Item = TypeVar("Item")


def predict_seconds(series: Series, suite: Suite, near_duplicates: bool = True) -> float:
    """Predicted seconds of all launches of a series, from costs that do not depend on the machine."""
    if series.left_out is not None:
        return LEFT_OUT
    first, again = launch_seconds(series, suite, 1), launch_seconds(series, suite, 2)
    return first + again * (launches(series, suite, near_duplicates) - 1)


def launch_seconds(series: Series, suite: Suite, launch: int) -> float:
    """Predicted seconds of one launch of a series; later launches have no turned starts."""
    case, own = series.case, suite.of(series.case)
    turned = own.scope.turned and case.turning is not None and launch == 1 and not series.over_timing_span
    return seconds_of(series.integrator.library, case.variant is not None, own.limit(case, series.integrator), turned)


def seconds_of(library: str, hard: bool, limit_seconds: float, turned: bool) -> float:
    """Predicted seconds of one launch of a series on a hard or a default variant, perhaps from turned starts too."""
    kind = _kind(hard, limit_seconds, turned)
    if library in COSTS[kind]:
        return COSTS[kind][library]
    return OWN_START + limit_seconds * (OWN_TURNED if kind == "turned" else OWN_SWEEP)


def run_seconds(launches: Sequence[tuple[str, float]], workers: int) -> float:
    """Predicted seconds of a run of `launches`, each with the id of its series and its seconds.

    The launches of one series follow one another, also where other workers have nothing to do.
    """
    if not launches:
        return 0.0
    of_series: dict[str, float] = {}
    for name, seconds in launches:
        of_series[name] = of_series.get(name, 0.0) + seconds
    return START + max(max(of_series.values()), sum(of_series.values()) / workers)


def _kind(hard: bool, limit_seconds: float, turned: bool) -> str:
    """The kind of cost: a name in `COSTS`."""
    if hard or limit_seconds < LONG_LIMIT:
        return "hard" if hard else "short"
    return "turned" if turned else "long"


def divide(items: Sequence[Item], seconds: Sequence[float], parts: int) -> list[list[Item]]:
    """The items in `parts` consecutive parts of about equal cost, within the largest item of the mean.

    Consecutive series of one case need one exact motion, which few parts then compute.
    """
    groups: list[list[Item]] = [[] for _ in range(parts)]
    total, before = sum(seconds), 0.0
    for item, cost in zip(items, seconds, strict=True):
        groups[min(parts - 1, int(parts * (before + cost / 2) / total))].append(item)
        before += cost
    return groups


def shard(series: Sequence[Series], suite: Suite, near_duplicates: bool = True) -> list[Series]:
    """The series of the suite's shard. Each series is in exactly one shard, for any order of `series`.

    The plan is divided into PIECES pieces for each shard, of about equal cost, and dealt out to the shards in turn.
    """
    place, count = suite.shard
    if count == 1:
        return list(series)
    ordered, costs = _order_series(series, suite, near_duplicates)
    return [series for piece in divide(ordered, costs, PIECES * count)[place - 1 :: count] for series in piece]


def shard_named(series: Sequence[Series], suite: Suite, near_duplicates: bool = True) -> dict[str, str]:
    """The shard for the environment of a run, with a hash of the whole plan; empty for a run of a whole plan."""
    place, count = suite.shard
    if count == 1:
        return {}
    ordered, costs = _order_series(series, suite, near_duplicates)
    plan = digest(f"{series.id} {cost!r}" for series, cost in zip(ordered, costs, strict=True))
    return {SHARD: shard_text(place, count, plan[:8])}


def _order_series(series: Sequence[Series], suite: Suite, near_duplicates: bool) -> tuple[list[Series], list[float]]:
    """All series of a plan in the order in which it is divided, and their costs."""
    ordered = sorted(series, key=lambda s: s.id)
    return ordered, [predict_seconds(series, suite, near_duplicates) for series in ordered]

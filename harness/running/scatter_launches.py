"""Launches that measure the scatter between launches: one setting of some series of each library, spread over a run.

Ranks rest on the scatter (see `gnomon.harness.results.separation`). Its launches lie as far from each other as those of the
members of a cell, never back to back, and each block of them has all libraries, so that an effect that all launches of a
time share can be told from it.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import count
from typing import TypeVar

from gnomon.harness.contract.status import SCORED
from gnomon.harness.results.store import Known
from gnomon.harness.running.plan import Series, Trial

SERIES_OF_A_LIBRARY = 6
"""Number of series of each library, each on another problem, as far as it takes so many."""

Item = TypeVar("Item")


def choose(series: Iterable[Series]) -> list[Series]:
    """Of each library the series that are launched again: its problems in their order, its integrators in turn."""
    found: dict[str, dict[str, list[Series]]] = {}
    for one in series:
        if one.left_out is None and one.formulation is None and one.case.variant is None and not one.label:
            found.setdefault(one.integrator.library, {}).setdefault(one.case.name, []).append(one)
    chosen = []
    for problems in found.values():
        for place, (_, members) in zip(count(), list(problems.items())[:SERIES_OF_A_LIBRARY], strict=False):
            chosen.append(members[place % len(members)])
    return chosen


def setting(trials: Sequence[Trial], history: Mapping[tuple[str, int], Known]) -> tuple[Trial, ...]:
    """The trial in the middle of those that the first launch of a series timed; empty without one."""
    timed = [
        trial
        for trial in trials
        for known in [history.get((trial.key, 1))]
        if known is not None and known.status in SCORED and known.seconds is not None
    ]
    return tuple(timed[len(timed) // 2 :][:1])


def spread(launches: Sequence[Item], blocks: Sequence[Sequence[Item]]) -> list[Item]:
    """The launches with the blocks at equal distances among them, the last one at the end."""
    found, done = list[Item](), 0
    for number, block in enumerate(blocks, 1):
        until = round(len(launches) * number / len(blocks))
        found += [*launches[done:until], *block]
        done = until
    return [*found, *launches[done:]]

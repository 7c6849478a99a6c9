"""The cost of one solve and of many, first use and preparation included, and the library that is then the fastest."""

from collections.abc import Iterator, Mapping, Sequence
from statistics import median
from typing import NamedTuple

import pandas as pd
from gnomon.harness.results.analysis import own, records
from gnomon.harness.results.best import Cost
from gnomon.harness.results.contenders import THIRD, division
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.rankings import FEWEST
from gnomon.harness.results.time_ratios import EQUAL_WITHIN

SOLVES = (1, 1000, 1_000_000)
"""The numbers of solves whose cost is computed."""
COMMON = 0.5
"""A library that reaches an error on a smaller part of the systems than the widest one is not compared."""


class Library(NamedTuple):
    """A library at one error: the systems that it reaches, and of SOLVES its median cost and whether it is the fastest."""

    name: str
    reached: int
    costs: tuple[float, ...]
    fastest: tuple[bool, ...]


class AtError(NamedTuple):
    """The libraries that are compared at one error, on the `systems` that all of them reach.

    `aside`: the libraries that reach it on too few systems, with their number. `first` is the fastest library for one
    solve, `later` for the most of SOLVES, and `even` the median number of solves from which on the latter is faster.
    """

    target: float
    systems: int
    libraries: tuple[Library, ...]
    aside: tuple[tuple[str, int], ...]
    first: str
    later: str
    even: float


def break_even(
    equal: pd.DataFrame, loads: Mapping[str, float], targets: Sequence[float] = TARGETS
) -> Iterator[AtError]:
    """The costs of libraries at each error at which two or more can be compared on FEWEST systems.

    The cost of a number of solves on a system is the least over the methods of a library of the seconds of `loads`
    (`analysis.load_seconds`, by integrator), the preparation, and this number of whole calls. Medians are over systems,
    default variants in their own formulation. A method whose first use was not measured is left out. If there are third
    parties, the fastest is one of them; costs within EQUAL_WITHIN of the least are called the fastest too.
    """
    rows = own(equal)
    rows = rows.assign(load=rows["integrator_id"].map(loads))
    rows = rows[rows["load"].notna() & rows["prepare_seconds"].notna()]
    for target in targets:
        ways: dict[str, dict[str, list[Cost]]] = {}
        names = ("library", "case", "load", "prepare_seconds", "seconds")
        for row in records(rows[rows["target"] == target], names):
            cost = Cost(row["load"] + row["prepare_seconds"], row["seconds"])
            ways.setdefault(row["library"], {}).setdefault(row["case"], []).append(cost)
        at_error = _at(target, ways)
        if at_error is not None:
            yield at_error


def _at(target: float, ways: Mapping[str, Mapping[str, Sequence[Cost]]]) -> AtError | None:
    """The libraries at one error, from the costs of their methods by library and case."""
    widest = max(map(len, ways.values()), default=0)
    compared = sorted((name for name in ways if len(ways[name]) >= COMMON * widest), key=lambda name: len(ways[name]))
    while len(compared) > 1 and len(common := set.intersection(*(set(ways[name]) for name in compared))) < FEWEST:
        compared = compared[1:]
    if len(compared) < 2:
        return None
    costs = {
        name: tuple(median(min(way.total(n) for way in ways[name][case]) for case in common) for n in SOLVES)
        for name in compared
    }
    third = [name for name in compared if division(name) == THIRD] or compared
    least = [min(costs[name][k] for name in third) for k in range(len(SOLVES))]
    first, *_, later = (min(third, key=lambda name: costs[name][k]) for k in range(len(SOLVES)))
    even = 1.0 if first == later else median(_even(ways[later][case], ways[first][case]) for case in common)
    libraries = tuple(
        Library(
            name,
            len(ways[name]),
            costs[name],
            tuple(name in third and cost <= EQUAL_WITHIN * least[k] for k, cost in enumerate(costs[name])),
        )
        for name in sorted(compared, key=lambda name: (name not in third, costs[name]))
    )
    aside = tuple((name, len(of)) for name, of in sorted(ways.items()) if name not in compared)
    return AtError(target, len(common), libraries, aside, first, later, even)


def _even(later: Sequence[Cost], first: Sequence[Cost]) -> float:
    """The number of solves from which on the best of many is faster than the best of one."""
    fast = min(later, key=lambda way: way.total(SOLVES[-1]))
    return fast.overtakes(min(first, key=lambda way: way.total(1)))

"""Simulated launches: pages of cells whose true factors are known, and the scatter that a run measures beside them."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from gnomon.harness.results.rankings import rank_methods
from gnomon.harness.results.time_ratios import Scatter, Timed, compare, scatter_of, states

SCATTER = 0.03
"""Standard deviation of the logarithm of a time between launches on a quiet machine."""
KNOWN = scatter_of(
    [
        Timed("x", {(1, n): float(np.exp(SCATTER * x)) for n, x in enumerate(row)})
        for row in np.random.default_rng(1).standard_normal((100, 6))
    ]
)
"""A scatter of SCATTER that is known well."""


class World(NamedTuple):
    """How launches scatter.

    `tails`: degrees of freedom of Student's t, inf for a normal. `mode`: the share of launches in a mode 10 % slower.
    `unlike`: standard deviation over series of the logarithm of their scatter. `slower`: the factor by which the machine
    slows down half-way.
    """

    tails: float = np.inf
    mode: float = 0.0
    unlike: float = 0.0
    slower: float = 1.0

    def draw(self, rng: np.random.Generator, size: float, count: int) -> np.ndarray:
        noise = rng.standard_normal(count) if np.isinf(self.tails) else rng.standard_t(self.tails, count)
        return size * noise + np.log(1.1) * (rng.random(count) < self.mode)

    def size(self, rng: np.random.Generator) -> float:
        return float(SCATTER * np.exp(self.unlike * rng.standard_normal()))


class Found(NamedTuple):
    """Of a page: the true and the found claims, the coverage of its intervals, and by true factor the states of pairs."""

    false: float
    covered: float
    states: dict[float, list[str]]


def scatter(rng: np.random.Generator, world: World, series: int = 36, launches: int = 6) -> Scatter:
    """The scatter that a run measures on series of three libraries."""
    late = np.log(world.slower) * (np.arange(launches) >= launches / 2)
    found = []
    for number in range(series):
        logs = world.draw(rng, world.size(rng), launches) + late
        found.append(Timed("abc"[number % 3], {(1, n): float(np.exp(x)) for n, x in enumerate(logs, 1)}))
    return scatter_of(found)


def page(rng: np.random.Generator, world: World, factors: Sequence[float], launched: int, cells: int = 25) -> Found:
    """A page of cells at four errors each, whose series take `factors` of a time; a launch has one effect at all errors."""
    known, compared, truth = scatter(rng, world), [], np.log(factors)
    for cell in range(cells):
        late = np.log(world.slower) * ((np.arange(launched) > 0) | (cell > cells / 2))
        logs = [x + world.draw(rng, world.size(rng), launched) + late for x in truth]
        series = [
            Timed("abc"[n % 3], {(1, k): float(np.exp(x)) for k, x in enumerate(of, 1)}) for n, of in enumerate(logs)
        ]
        compared += [compare(series, known)] * 4
    claims = false = 0
    covered, by = [], dict[float, list[str]]()
    for rows, of in zip(compared, states(compared), strict=True):
        first = of.index("fastest")
        for n, (row, state) in enumerate(zip(rows, of, strict=True)):
            if n != first:
                true = float(np.exp(truth[n] - truth[first]))
                claims += state == "slower"
                false += state == "slower" and true <= 1 + 1e-12
                covered.append(row.low <= true <= row.high)
                by.setdefault(round(max(true, 1 / true), 2), []).append(state)
    return Found(false / max(claims, 1), float(np.mean(covered)), by)


def timed(rows: Sequence[Mapping[str, Any]], launches: int = 5) -> pd.DataFrame:
    """`ranked` of rows with a case, an integrator, its `seconds`, an error: each launch has these, within 2 %."""
    table = pd.DataFrame(rows).assign(variant="", formulation="", null_share=0.01, launches=launches)
    table["times"] = [{(1, n): x * (1 + 0.01 * (n % 3 - 1)) for n in range(launches)} for x in table["seconds"]]
    return rank_methods(table, KNOWN)

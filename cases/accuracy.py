"""How accurate an answer in binary64 can be at all: the floor of the format and the conditioning of the case."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from gnomon.reference.precision import nearest_double
from numpy.typing import NDArray

if TYPE_CHECKING:
    from gnomon.cases.case import Case

Floats = NDArray[np.float64]
GRID = 257
CROWDED = 1e6
"""Where the time between events is below this many conditionings of their times, only position is scored."""


def grid_scales(case: Case) -> dict[str, float]:
    """The maximum norm of each group over 257 equal steps of the span and the sample times."""
    times = np.union1d(np.linspace(0.0, float(case.times[-1]), GRID), case.times)
    states = case.sample(times)
    scales = {}
    for name in dict.fromkeys(coordinate.group for coordinate in case.state):
        members = [i for i, c in enumerate(case.state) if c.group == name]
        largest = float(np.max(np.linalg.norm(states[:, members], axis=1)))
        if case.state[members[0]].kind == "angle":
            largest = min(largest, math.pi)
        scales[name] = largest if largest > 0 else case.natural_sizes.get(name, 1.0)
    return scales


def floor(case: Case, times: Floats) -> Floats:
    """Half an ulp of each component of the exact state, in the metric, shape (len(times),)."""
    states = case.sample(times)
    half = np.spacing(np.abs(states)) / 2
    return np.max([np.linalg.norm(half[:, list(g.indices)], axis=1) / g.scale for g in case.metric.groups], axis=0)


def conditioning(case: Case, times: Floats) -> Floats:
    """Root of the summed squares of the effects of half an ulp in each number and in time, shape (len(times),).

    A number at the edge of the domain is moved inward. A number that is exactly zero has no ulp and is left alone.
    """
    nominal = [case.exact(float(t), 40) for t in times]
    total = np.zeros(len(times))
    for neighbour in _neighbours(case):
        total += _distances(case, [neighbour.exact(float(t), 40) for t in times], nominal) ** 2
    shifted = [case.exact(Fraction(t) + Fraction(math.ulp(t)) / 2, 40) for t in map(float, times)]
    total += _distances(case, shifted, nominal) ** 2
    return np.asarray(np.sqrt(total))


def _neighbours(case: Case) -> list[Case]:
    """The case with one number moved by half an ulp, for each number that is not zero."""
    found = []
    states = len(case.state)
    names = list(case.parameters)
    numbers = [*case.initial_state, *case.parameters.values()]
    for index, value in enumerate(numbers):
        half = Fraction(math.ulp(float(value))) / 2
        for moved in (value + half, value - half):
            changed = [*numbers[:index], moved, *numbers[index + 1 :]]
            try:
                neighbour = case.with_numbers(changed[:states], dict(zip(names, changed[states:], strict=True)))
            except ValueError:
                continue  # outside the domain: the other side is inside
            if not case.same_course(neighbour):
                continue  # across a decision, where the effect is no measure of round-off
            if value != 0:
                found.append(neighbour)
            break
    return found


def _distances(case: Case, states: list[tuple[object, ...]], nominal: list[tuple[object, ...]]) -> Floats:
    """Distances between states that differ far below an ulp: differences first, in high precision."""
    rows = np.array(
        [[nearest_double(x - y) for x, y in zip(a, b, strict=True)] for a, b in zip(states, nominal, strict=True)]  # type: ignore[operator]
    )
    zero = np.zeros_like(rows)
    return np.max(list(case.metric.by_group(rows, zero).values()), axis=0)


def crowded(case: Case) -> frozenset[float]:
    """Sample times where the time between events is below 1e6 times the conditioning of the events' times."""
    neighbours, known, found = _neighbours(case), dict[int, float](), set()
    for t in case.times.tolist():
        near = case.between(t)
        for n in (near.past, near.past + 1):
            if n < 1 or (n > near.past and near.next == math.inf):
                continue
            if n not in known:
                known[n] = _event_conditioning(case, neighbours, n)
            if near.gap < CROWDED * known[n]:
                found.add(t)
    return frozenset(found)


def _event_conditioning(case: Case, neighbours: list[Case], n: int) -> float:
    """Effect of half an ulp in each number on the time of event n, and of its own, as a root of squares."""
    time = case.event_time(n, 40)
    effects = [nearest_double(other.event_time(n, 40) - time) for other in neighbours]
    return math.hypot(*effects, math.ulp(float(time)) / 2)

"""The distance between two states: the largest of the norms of groups of like coordinates, each over its own scale."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from gnomon.cases.core.forms import Hybrid, Transition
from gnomon.cases.core.interface import StatedCase
from numpy.typing import NDArray

Floats = NDArray[np.float64]
RATES = ("velocity", "angular velocity", "rate")


@dataclass(frozen=True)
class Group:
    """Coordinates that share a norm. `scale` is the largest norm of the exact motion over the span.

    `wrapped` coordinates are angles, compared modulo 2 pi. A group that is not `scored` does not count in the distance.
    """

    name: str
    indices: tuple[int, ...]
    scale: float
    wrapped: bool
    scored: bool = True

    def difference(self, states: Floats, exact: Floats) -> Floats:
        """Differences, shape (..., len(indices)); differences of angles are modulo 2 pi."""
        index = list(self.indices)
        raw = states[..., index] - exact[..., index]
        if not self.wrapped:
            return np.asarray(raw)
        # A difference below half a turn stays as it is: adding pi would round it to the ulp of pi.
        return np.where(np.abs(raw) <= math.pi, raw, np.remainder(raw + math.pi, 2 * math.pi) - math.pi)


@dataclass(frozen=True)
class Metric:
    """The largest of the groups' scaled distances.

    In a hybrid case the state just before a transition and its image just after it are the same point. So the distance
    is also computed through the reset: the distance of one state to the guard plus the distance of its image to the other state.
    """

    groups: tuple[Group, ...]
    jumps: tuple[Callable[[Floats], Floats | None], ...] = ()
    positions: tuple[str, ...] = ()
    """The groups that are positions; the others are rates of change."""
    crowded: frozenset[float] = frozenset()
    """Sample times at which events follow each other so fast that only positions are compared."""

    @classmethod
    def scaled(cls, case: StatedCase, scales: Mapping[str, float], crowded: frozenset[float]) -> Metric:
        """The metric of a case whose scales and crowded times are known; to compute them takes up to seconds."""
        groups = []
        for name in dict.fromkeys(coordinate.group for coordinate in case.state):
            members = tuple(i for i, c in enumerate(case.state) if c.group == name)
            wrapped = case.state[members[0]].kind == "angle"
            groups.append(Group(name, members, scales[name], wrapped, name in case.scored or not case.scored))
        hybrid = case.hybrid
        jumps = [] if hybrid is None else [_jump(case, hybrid, t) for t in hybrid.transitions if t.onto]
        positions = tuple(dict.fromkeys(c.group for c in case.state if c.kind not in RATES))
        return cls(tuple(groups), tuple(jumps), positions, crowded)

    def by_group(self, states: Floats, exact: Floats) -> dict[str, Floats]:
        """Scaled distance of each scored group, shape of the leading axes, without the way through transitions."""
        return {g.name: np.linalg.norm(g.difference(states, exact), axis=-1) / g.scale for g in self.groups if g.scored}

    def distance(self, states: Floats, exact: Floats, times: Floats | None = None) -> Floats:
        """Distance of states (n, dim) from exact states (n, dim), shape (n,); nan where a state is not finite.

        If their `times` (n,) are given, states at `crowded` times are compared in their positions only.
        """
        if times is not None and self.crowded:
            rows = np.isin(times, list(self.crowded))
            positions = replace(self, groups=tuple(g for g in self.groups if g.name in self.positions))
            distances = self.distance(states, exact)
            distances[rows] = positions.distance(states[rows], exact[rows])
            return distances
        plain = self._plain(states, exact)
        if not self.jumps:
            return plain
        return np.array([self._through_jumps(d, a, b) for d, a, b in zip(plain, states, exact, strict=True)])

    def turns(self, states: Floats, exact: Floats) -> int:
        """The largest number of whole turns by which an angle is wrong; the distance ignores whole turns."""
        angles = [i for g in self.groups if g.wrapped for i in g.indices]
        if not angles:
            return 0
        off = np.abs(states[..., angles] - exact[..., angles])
        # Beyond 2^53 binary64 does not resolve single turns, and the store has no such integers.
        return int(min(np.max(np.round(off[np.isfinite(off)] / (2 * math.pi)), initial=0.0), 2.0**53))

    def _plain(self, states: Floats, exact: Floats) -> Floats:
        return np.asarray(np.max(np.stack(list(self.by_group(states, exact).values())), axis=0))

    def _through_jumps(self, best: float, a: Floats, b: Floats) -> float:
        if not np.all(np.isfinite(a)):
            return best
        for jump in self.jumps:
            for here, there in ((a, b), (b, a)):
                landed = jump(here)
                if landed is not None:
                    before, after = landed
                    best = min(best, float(self._plain(here, before) + self._plain(after, there)))
        return best


def _jump(case: StatedCase, hybrid: Hybrid, transition: Transition) -> Callable[[Floats], Floats | None]:
    """A function state -> (state on the guard, its image); None for a state that does not move towards the guard."""
    parameters = tuple(float(value) for value in case.parameter_values())
    mode = hybrid.mode(transition.mode)
    step = 1e-6 * case.time_scale

    def jump(state: Floats) -> Floats | None:
        here = tuple(map(float, state))
        rates = mode.equations(0.0, here, parameters + mode.constants)
        ahead = tuple(x + step * rate for x, rate in zip(here, rates, strict=True))
        rise = transition.guard(0.0, ahead, parameters)[0] - transition.guard(0.0, here, parameters)[0]
        if rise * transition.direction <= 0 or transition.onto is None:
            return None
        try:
            on_guard = transition.onto(0.0, here, parameters)
        except ValueError:
            return None  # a wrong state (such as one below the plane) from which no motion meets the guard
        return np.array([on_guard, transition.reset(0.0, on_guard, parameters)])

    return jump

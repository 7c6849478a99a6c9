"""How accurate a binary64 answer can be: the floor of the format and the conditioning of the case.

Results of many evaluations of the exact motion are kept on disk; exact numbers, times and sources are their key.
"""

import hashlib
import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, Protocol, TypeVar

import numpy as np
from gnomon.cases.core.interface import SolvedCase
from gnomon.cases.core.metric import Metric
from gnomon.reference.numerics.certified import CertifiedMotion
from gnomon.reference.numerics.precision import nearest_double
from gnomon.reference.storage.diskcache import Entry, cached
from gnomon.reference.storage.import_closure import closure
from numpy.typing import NDArray

Floats = NDArray[np.float64]
GRID = 257
FINER, RESTARTS = 1e-5, 8
DIGITS = 28
"""Half an ulp changes the 16th digit: twelve digits of the effect remain."""
CROWDED = 1e6
"""Only positions are compared where the time between events is below this multiple of the error of their times."""


class MeasuredCase(SolvedCase, Protocol):
    """A case with the distance between two of its states."""

    @property
    def metric(self) -> Metric: ...


C = TypeVar("C", bound=SolvedCase)


def grid_scales(case: SolvedCase, samples_alone: bool = False) -> dict[str, float]:
    """The largest norm of each group over 257 equally spaced times and the sample times (of angles at most pi).

    With `samples_alone`, over the sample times: where peaks are narrower than any grid, which is then a matter of chance. A group that stays zero gets the natural size that the case states, or 1 SI unit.
    """
    times = case.times if samples_alone else np.union1d(np.linspace(0.0, float(case.times[-1]), GRID), case.times)
    names = tuple(dict.fromkeys(coordinate.group for coordinate in case.state))

    def largest() -> Floats:
        states = case.sample(times)
        members = [[i for i, c in enumerate(case.state) if c.group == name] for name in names]
        return np.array([np.max(np.linalg.norm(states[:, index], axis=1)) for index in members])

    scales = {}
    for name, size in zip(names, _kept("scales", case, times, largest).tolist(), strict=True):
        angle = any(c.kind == "angle" for c in case.state if c.group == name)
        extent = min(size, math.pi) if angle else size
        scales[name] = extent if extent > 0 else case.natural_sizes.get(name, 1.0)
    return scales


def floor(case: MeasuredCase, times: Floats) -> Floats:
    """Half an ulp of each component of the exact state, in the metric, shape (len(times),)."""
    half = np.spacing(np.abs(case.sample(times))) / 2
    groups = [group for group in case.metric.groups if group.scored]
    return np.asarray(np.max([np.linalg.norm(half[:, list(g.indices)], axis=1) / g.scale for g in groups], axis=0))


def conditioning(case: MeasuredCase, times: Floats) -> Floats:
    """The typical effect, in the metric, of half an ulp in each number and in the time, shape (len(times),).

    Each effect is the exact difference of two exact motions, with one number changed. Effects add like independent
    errors: the result is the root of the sum of their squares. A number at the edge of the domain is changed inward. A
    number that is exactly zero is not changed: it has no rounding error.

    A start very close to an unstable equilibrium (1e-12 from an axis, for example) has an ulp far smaller than the ulps of
    later states, which every binary64 method rounds too. For such a start the exact motions from later states, rounded
    to binary64, count as well.
    """
    return _kept("conditioning", case, times, lambda: _conditioning(case, times))


def _conditioning(case: MeasuredCase, times: Floats) -> Floats:
    moments = [Fraction(t) for t in times.tolist()]
    nominal = _states(case, moments)
    later = _states(case, [t + Fraction(math.ulp(t)) / 2 for t in moments])
    total = _distances(case, later, nominal) ** 2
    for neighbour in _neighbours(case):
        total += _distances(case, _states(neighbour, moments), nominal) ** 2
    for index in _coarser(case, nominal):
        again = _rounded_there(case, nominal[index])
        if again is not None:
            states = [again.exact(t - moments[index], DIGITS) for t in moments[index:]]
            total[index:] += _distances(case, states, nominal[index:]) ** 2
    return np.asarray(np.sqrt(total))


def _states(case: SolvedCase, moments: Sequence[Fraction]) -> list[tuple[Any, ...]]:
    """States of which differences are taken."""
    motion = case.motion()
    if isinstance(motion, CertifiedMotion):
        return [motion.rough_state(t) for t in moments]
    return [case.exact(t, DIGITS) for t in moments]


def _coarser(case: SolvedCase, states: list[tuple[Any, ...]]) -> list[int]:
    """Indices of up to 8 states in which a component is large that started above 0 but 1e5 times smaller.

    Empty if the motion cannot be restarted at a later time (driven, hybrid) or if that is too expensive (integrated).
    """
    if not case.autonomous or case.hybrid is not None or isinstance(case.motion(), CertifiedMotion):
        return []
    indices = set()
    for start, column in zip(case.initial_state, zip(*states, strict=True), strict=True):
        sizes = [abs(float(x)) for x in column]
        if 0 < abs(start) < FINER * max(sizes):
            indices |= {i for i, size in enumerate(sizes) if size > 0.1 * max(sizes)}
    return sorted(indices)[:RESTARTS]


def _rounded_there(case: C, state: tuple[Any, ...]) -> C | None:
    """The case started from `state` rounded to binary64; None if that is outside the domain, as off a constraint."""
    try:
        return case.with_numbers([nearest_double(x) for x in state], case.parameters)
    except ValueError:
        return None


def _neighbours(case: C) -> list[C]:
    """The case with one number changed by half an ulp of it, for each number that is not zero."""
    neighbours: list[C] = []
    states = len(case.state)
    names = list(case.parameters)
    numbers = [*case.initial_state, *case.parameters.values()]
    for index, value in enumerate(numbers):
        if value == 0:
            continue
        half = Fraction(math.ulp(float(value))) / 2
        for moved in (value + half, value - half):
            changed = [*numbers[:index], moved, *numbers[index + 1 :]]
            try:
                neighbour = case.with_numbers(changed[:states], dict(zip(names, changed[states:], strict=True)))
            except ValueError:
                continue  # outside the domain: the other side is inside
            if not case.same_course(neighbour):
                continue  # it passes through other modes, so the difference does not measure round-off
            neighbours.append(neighbour)
            break
    return neighbours


def _distances(case: MeasuredCase, states: list[tuple[object, ...]], nominal: list[tuple[object, ...]]) -> Floats:
    """Distances between states that differ by far less than an ulp: subtracted in high precision, then rounded."""
    rows = np.array(
        [[nearest_double(x - y) for x, y in zip(a, b, strict=True)] for a, b in zip(states, nominal, strict=True)]  # type: ignore[operator]
    )
    return np.asarray(np.max(list(case.metric.by_group(rows, np.zeros_like(rows)).values()), axis=0))


def crowded(case: SolvedCase) -> frozenset[float]:
    """Sample times where the time between events is below 1e6 times the conditioning of the events' times."""
    neighbours, known, times = _neighbours(case), dict[int, float](), set()
    for t in case.times.tolist():
        near = case.between(t)
        for n in (near.past, near.past + 1):
            if n < 1 or (n > near.past and near.next == math.inf):
                continue
            if n not in known:
                known[n] = _event_conditioning(case, neighbours, n)
            if near.gap < CROWDED * known[n]:
                times.add(t)
    return frozenset(times)


def _event_conditioning(case: SolvedCase, neighbours: Sequence[SolvedCase], n: int) -> float:
    """Effect on the time of event n (s) of half an ulp in each number and in that time: the root of summed squares."""
    time = case.event_time(n, 40)
    effects = [nearest_double(other.event_time(n, 40) - time) for other in neighbours]
    return math.hypot(*effects, math.ulp(float(time)) / 2)


def _kept(what: str, case: SolvedCase, times: Floats, build: Callable[[], Floats]) -> Floats:
    """The array of `build`, read from disk if neither the numbers nor the sources have changed."""
    code = closure(type(case).__module__)
    if code is None:
        return build()
    numbers = [str(value) for value in (*case.initial_state, *case.parameters.values(), case.span)]
    digest = hashlib.sha256(times.tobytes()).hexdigest()
    key = " ".join([what, type(case).__qualname__, code, *numbers, *case.scored, digest])
    return np.asarray(cached(key, lambda: Entry({what: build()})).arrays[what])

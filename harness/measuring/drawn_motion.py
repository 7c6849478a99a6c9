"""The exact motion of a case as a curve for a picture: right to a fraction of a pixel, in a second.

A point of an exact motion in high precision may take milliseconds, and a motion without a closed form seconds as a whole.
So the equations are integrated from an exact state, and compared with the other exact states: the kept ones at the sample
times of a default case, else some that are computed here, and the states before events. Where they differ by more than
`AGREED`, the integration begins again at the last state that agreed; an interval that it cannot cross is computed exactly.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.forms import Equations, FirstOrder
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.measuring.reference_solution import CaseSpec, find_kept

SCALES = 80.0
"""The largest number of time scales in a drawing, as more oscillations would merge."""
FEW = 24
"""Exact states that are computed where none are kept."""
AGREED = 1e-4
"""The largest difference from an exact state, in parts of the range of the coordinate in the picture."""
BENT = 1e-3
"""The largest distance of the curve from its chords, in the same parts: a fifth of a pixel in a panel of 180."""
TOLERANCE = 1e-9
MOST = 4000
"""Points of a stretch beyond which chords are not halved."""


@dataclass
class Stretch:
    """A smooth part of the motion: its equations, its first state, and the exact states that follow, up to its end."""

    equations: Equations
    parameters: tuple[float, ...]
    times: list[float]
    states: list[Floats]
    pieces: list[tuple[float, float, Callable[[Floats], Floats]]] = field(default_factory=list)
    """Times from and to, and the states in between."""


def curve(case: Case) -> tuple[Floats, Floats]:
    """Times and states of the motion, up to `SCALES` time scales: between two points the motion is a line in a picture.

    At a jump two points have one time.
    """
    shown, times, states = _exact_states(case)
    stretches = list(_stretches(shown, times, states))
    known = np.concatenate([each.states for each in stretches])
    for _ in range(2):  # the ranges of the first integration are those of the second
        sizes = _group_ranges(shown, np.ptp(known, axis=0))
        for each in stretches:
            each.pieces = list(_integrate_stretch(shown, each, sizes))
        drawn = [_points(each, sizes, shown.time_scale) for each in stretches]
        known = np.concatenate([points for _, points in drawn])
        if np.all(_group_ranges(shown, np.ptp(known, axis=0)) <= 2 * sizes):
            break
    return np.concatenate([when for when, _ in drawn]), known


def planes(case: Case) -> dict[str, tuple[int, int]]:
    """The places of x and y of each body that moves in a plane or is seen from above, by the number in its names.

    These are Cartesian coordinates in metres of one group: x and y, or x2 and y2.
    """
    names = {coordinate.name: k for k, coordinate in enumerate(case.state)}
    places = {}
    for name, k in names.items():
        body = re.fullmatch(r"x(\d*)", name)
        across = names.get(f"y{body[1]}") if body else None
        if body and across is not None:
            x, y = case.state[k], case.state[across]
            if x.group == y.group and x.unit == y.unit == "m":
                places[body[1]] = (k, across)
    return places


def _exact_states(case: Case) -> tuple[Case, Floats, Floats]:
    """The case as it is drawn, and exact states after the start.

    Without a variant a case is drawn as it is run, in binary64; the numbers of a variant may be critical.
    """
    rounded = case.rounded()
    span = min(float(case.times[-1]), SCALES * case.time_scale)
    stored = find_kept(CaseSpec.of(rounded)) if case.variant is None else None
    if stored is not None and np.count_nonzero(stored.times <= span) >= FEW:
        inside = stored.times <= span
        return rounded, stored.times[inside], stored.exact[inside]
    times = np.linspace(0.0, span, FEW + 1)[1:]
    return case, times, case.sample(times)


def _stretches(case: Case, times: Floats, states: Floats) -> Iterator[Stretch]:
    """The motion between events; of a motion without events the whole."""
    values = tuple(float(value) for value in case.parameter_values())
    start: Sequence[Any] = case.initial_state
    hybrid, begin = case.hybrid, 0.0
    if hybrid is None:
        first = next(form for form in case.all_forms() if isinstance(form, FirstOrder))
        yield _stretch(first.equations, values, begin, start, times, states)
        return
    name, last = hybrid.start(0.0, tuple(map(float, start)), values), ""
    for event in case.events(20):
        end = float(event.time)
        if end >= times[-1]:
            break
        inside = (times > begin) & (times < end)
        mode = hybrid.mode(name)
        before = np.array([float(x) for x in event.before])
        yield _stretch(
            mode.equations, (*values, *mode.constants), begin, start,
            np.append(times[inside], end), np.vstack([states[inside], before]),
        )  # fmt: skip
        begin, start = end, event.after
        after = tuple(map(float, start))
        if event.name == "limit":
            name = next(mode for transition, mode, _ in hybrid.limits if transition == last)
        else:
            fired = next(t for t in hybrid.transitions if t.name == event.name and t.mode == name)
            name, last = fired.lands(end, after, values), event.name
    mode, inside = hybrid.mode(name), times > begin
    yield _stretch(mode.equations, (*values, *mode.constants), begin, start, times[inside], states[inside])


def _stretch(
    equations: Equations, values: tuple[float, ...], begin: float, start: Sequence[Any], times: Floats, states: Floats
) -> Stretch:
    first = np.array([float(x) for x in start])
    return Stretch(equations, values, [begin, *times.tolist()], [first, *states])


def _group_ranges(case: Case, ranges: Floats) -> Floats:
    """For each coordinate the largest range of its group, which is the height of its panel."""
    groups = [coordinate.group for coordinate in case.state]
    largest = {name: max(r for r, g in zip(ranges, groups, strict=True) if g == name) for name in groups}
    return np.array([max(largest[name], 1e-300) for name in groups])


def _integrate_stretch(
    case: Case, stretch: Stretch, sizes: Floats
) -> Iterator[tuple[float, float, Callable[[Floats], Floats]]]:
    """The pieces of a stretch, each from an exact state to the last one with which the integration agrees."""
    from scipy.integrate import solve_ivp  # slow to load: only drawings wait

    last: Any = np.zeros_like(sizes)

    def rates(t: float, y: Floats) -> Any:
        nonlocal last
        with suppress(ArithmeticError, ValueError):  # a mode may be singular where it ends: the rates just before
            last = stretch.equations(t, tuple(y.tolist()), stretch.parameters)
        return last

    k, times = 0, stretch.times
    while k < len(times) - 1:
        interval = times[k], times[-1]
        solution = solve_ivp(
            rates, interval, stretch.states[k], "LSODA", dense_output=True, rtol=TOLERANCE, atol=TOLERANCE * sizes
        )
        good = k
        for place in range(k + 1, len(times)):
            if times[place] > solution.t[-1]:
                break
            if not np.all(np.abs(solution.sol(times[place]) - stretch.states[place]) <= AGREED * sizes):
                break
            good = place
        if good > k:
            yield times[k], times[good], partial(_rows, solution.sol)
        else:
            good = k + 1
            yield times[k], times[good], case.sample
        k = good


def _rows(solution: Callable[[Floats], Floats], times: Floats) -> Floats:
    return solution(times).T


def _points(stretch: Stretch, sizes: Floats, time_scale: float) -> tuple[Floats, Floats]:
    """The points of a stretch: chords are halved where the motion is not a line."""
    times, states = [np.array(stretch.times[:1])], [np.array(stretch.states[:1])]
    for begin, end, motion in stretch.pieces:
        t = np.linspace(begin, end, 2 + min(MOST // 4, int(4 * (end - begin) / time_scale)))
        y = motion(t)
        bent = np.full(len(t) - 1, True)
        while len(t) < MOST and np.any(bent):
            (k,) = np.nonzero(bent)
            middle = (t[k] + t[k + 1]) / 2
            there = motion(middle)
            far = np.max(np.abs(there - (y[k] + y[k + 1]) / 2) / sizes, axis=1) > BENT
            t, y = np.insert(t, k + 1, middle), np.insert(y, k + 1, there, axis=0)
            halves = np.repeat(bent, 1 + bent)
            halves[np.repeat(bent, 1 + bent)] = np.repeat(far, 2)
            bent = halves
        times.append(t[1:])
        states.append(y[1:])
    return np.concatenate(times), np.concatenate(states)

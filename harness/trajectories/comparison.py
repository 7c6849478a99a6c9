"""Compares a trajectory with the exact motion of a case: error by time, phase and shape, period, drifts, events, digits."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.metric import Metric
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.measuring.reference_solution import ReferenceSolution
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.trajectories.columns import Trajectory
from gnomon.harness.trajectories.file_events import EventErrors, compare_events
from gnomon.reference.numerics.certified import CertifiedMotion
from numpy.typing import NDArray

Places = NDArray[np.int64]
MOST_COMPARED = 100_000
"""Rows that are compared; of a longer file, evenly chosen ones."""
MOST_PHASES = 4096
"""Rows at which phase, shape and period are computed."""
HALVES = 2.0
"""An error below this multiple of the effect of the last digits may be that effect alone."""
LINEAR = 0.05
"""Up to this error in the metric the phase is proportional to the time by which the motion is late."""
LEAST_TIME = 0.1
"""Rows that end before this part of the time scale have hardly left the start."""
TRIED = 64
"""Rows at which the effect of rounded times is computed."""


class NotCheckedError(ValueError):
    """A trajectory that cannot be compared, with the reason."""


@dataclass(frozen=True)
class Period:
    """The period of a trajectory, half of its 95 % interval, and the exact period (s)."""

    found: float
    margin: float
    exact: float
    name: str


@dataclass
class Comparison:
    """A trajectory beside the exact motion.

    `times` (n,), `states` and `exact` (n, dim): the rows that are compared; `errors` (n,): their distance in the metric.
    `part`: the times that are compared, as text, if they leave out some of the span of the case, unasked.
    `doubts`: reasons why small errors do not prove that the motion is right.
    """

    case: Case
    trajectory: Trajectory
    rows: Places
    exact: Floats
    scorer: Scorer
    part: str = ""
    doubts: list[str] = field(default_factory=list)

    @property
    def times(self) -> Floats:
        return self.scorer.reference.times

    @cached_property
    def states(self) -> Floats:
        return self.trajectory.states[self.rows]

    @cached_property
    def is_whole(self) -> bool:
        """Whether every coordinate has a column."""
        return bool(np.all(self.trajectory.present))

    @cached_property
    def metric(self) -> Metric:
        """The metric of the coordinates that the file has."""
        present, groups = self.trajectory.present, []
        for group in self.scorer.metric.groups:
            indices = tuple(index for index in group.indices if present[index])
            if indices:
                groups.append(replace(group, indices=indices))
        jumps = self.scorer.metric.jumps if self.is_whole else ()
        if not any(group.scored for group in groups):
            groups = [replace(group, scored=True) for group in groups]
        return replace(self.scorer.metric, groups=tuple(groups), jumps=jumps)

    @cached_property
    def errors(self) -> Floats:
        with np.errstate(all="ignore"):
            return self.metric.distance(self.states, self.exact)

    @cached_property
    def errors_by_group(self) -> dict[str, Floats]:
        with np.errstate(all="ignore"):
            return self.metric.by_group(self.states, self.exact)

    @cached_property
    def differences(self) -> Floats:
        """State less exact state (n, dim), of angles modulo 2 pi; nan without a column."""
        differences = np.full_like(self.states, np.nan)
        for group in self.metric.groups:
            differences[:, list(group.indices)] = group.difference(self.states, self.exact)
        return differences

    @property
    def worst(self) -> int:
        return int(np.argmax(np.where(np.isnan(self.errors), np.inf, self.errors)))

    @property
    def error(self) -> float:
        return float(self.errors[self.worst])

    @cached_property
    def largest(self) -> dict[str, tuple[float, int]]:
        """By coordinate, the largest difference in its unit, and its place."""
        largest = {}
        for index, coordinate in enumerate(self.case.state):
            if self.trajectory.present[index]:
                place = int(np.argmax(np.abs(self.differences[:, index])))
                largest[coordinate.name] = float(self.differences[place, index]), place
        return largest

    @cached_property
    def with_turns(self) -> dict[str, tuple[float, int]]:
        """By angle, the largest difference with its whole turns, and its first place, where this exceeds half a turn."""
        largest = {}
        for index in (i for group in self.metric.groups if group.wrapped for i in group.indices):
            apart = self.states[:, index] - self.exact[:, index]
            place = int(np.argmax(np.isclose(np.abs(apart), np.max(np.abs(apart)))))
            if abs(apart[place]) > math.pi:
                largest[self.case.state[index].name] = float(apart[place]), place
        return largest

    @cached_property
    def worst_coordinate(self) -> int:
        """The coordinate with the largest share in the worst error."""
        shares = np.zeros(len(self.case.state))
        for group in self.metric.groups:
            if group.scored:
                index = list(group.indices)
                shares[index] = np.abs(self.differences[self.worst, index]) / group.scale
        return int(np.argmax(shares))

    # The parts of the error

    @cached_property
    def _phased(self) -> tuple[Scorer, Floats] | None:
        """A scorer of at most MOST_PHASES rows, and their states; None where phase has no meaning."""
        if not self.is_whole or not np.all(np.isfinite(self.errors)):
            return None
        places = pick_evenly(len(self.times), MOST_PHASES)
        scorer = Scorer(self.case, None, _reference(self.case, self.times[places], self.exact[places], self.scorer))
        return (scorer, self.states[places]) if scorer.scaled_rates is not None else None

    @cached_property
    def phase_and_shape(self) -> tuple[float, float] | None:
        """The largest error along the exact motion and across it; None for hybrid and driven cases, and without a column."""
        return None if self._phased is None else self._phased[0].split(self._phased[1])

    @cached_property
    def lateness(self) -> tuple[Floats, Floats, Floats] | None:
        """Times, the seconds by which the trajectory is late there, and the weight of each; None as `phase_and_shape`."""
        if self._phased is None:
            return None
        scorer, states = self._phased
        rates = scorer.scaled_rates
        assert rates is not None
        weights = np.sum(rates**2, axis=1)
        along = np.sum(scorer.scaled_error(states) * rates, axis=1)
        late = np.divide(-along, weights, out=np.zeros_like(along), where=weights > 0)
        return scorer.reference.times, late, weights

    @cached_property
    def latest(self) -> tuple[float, float] | None:
        """(time, seconds) where the trajectory is most late or early; None for errors that are not small."""
        if self.lateness is None or self.error > LINEAR:
            return None
        times, late, weights = self.lateness
        place = int(np.argmax(np.abs(late) * (weights > 1e-3 * np.max(weights))))
        return float(times[place]), float(late[place])

    @cached_property
    def period(self) -> Period | None:
        """The period by a fit; None without an exact period, or with less than two of them."""
        name, exact = find_period(self.case) or ("", math.inf)
        if self.lateness is None or self.times[-1] - self.times[0] < 2 * exact:
            return None
        fit = self._by_lateness(exact) if self.error <= LINEAR else self._by_crossings(exact)
        return None if fit is None else Period(*fit, exact, name)

    def _by_lateness(self, exact: float) -> tuple[float, float]:
        """The slope of the lateness over time, and its margin from the slopes of four parts of the time."""
        assert self.lateness is not None
        times, late, weights = self.lateness
        slope, rests = _fit_line(times, late, weights)
        spread = math.sqrt(float(np.sum(weights * rests**2) / np.sum(weights)))
        turns = (times[-1] - times[0]) / exact
        # Residuals vary within a turn: as many of them are independent as there are turns, and two more.
        margin = 2 * spread / (math.sqrt(turns + 2) * float(np.std(times)))
        return exact * (1 + slope), exact * margin

    def _by_crossings(self, exact: float) -> tuple[float, float] | None:
        """The mean time between crossings, corrected by this estimate for the exact motion with the same samples."""
        for index in range(len(self.case.state)):
            level = float(np.mean(self.exact[:, index]))
            crossings, right = (_crossings(self.times, each[:, index] - level) for each in (self.states, self.exact))
            if min(len(crossings), len(right)) >= 3:
                mean, scatter = float(np.mean(np.diff(crossings))), float(np.std(np.diff(crossings)))
                ratio = mean / float(np.mean(np.diff(right)))
                return exact * ratio, exact * 2 * scatter / mean / math.sqrt(len(crossings) - 1)
        return None

    @cached_property
    def drifts(self) -> dict[str, tuple[float, float, float]]:
        """By invariant: the largest drift over its size, its time, and the drift at the end."""
        if not self.is_whole or not np.all(np.isfinite(self.states)):
            return {}
        drifts = {}
        for name, drift in self.scorer.drift(self.states).items():
            if np.all(np.isfinite(drift)):
                place = int(np.argmax(drift))
                drifts[name] = float(drift[place]), float(self.times[place]), float(drift[-1])
        return drifts

    @cached_property
    def events(self) -> EventErrors | None:
        """The events of a hybrid case; None for other cases, and for a part of the coordinates."""
        if self.case.hybrid is None or not self.is_whole or not np.all(np.isfinite(self.states)):
            return None
        return compare_events(self.case, self.times, self.states, self.metric)

    # What limits the result

    @cached_property
    def digits_effect(self) -> float:
        """The effect in the metric of half a unit of the last digit of the file's numbers."""
        halves = self.trajectory.half_units[self.rows]
        return float(np.max(np.stack(list(self.metric.by_group(halves, np.zeros_like(halves)).values()))))

    @cached_property
    def times_effect(self) -> float:
        """The effect in the metric of half a unit of the last digit of the times."""
        half = self.trajectory.half_time
        if not half:
            return 0.0
        places = np.union1d(pick_evenly(len(self.times), TRIED), [self.worst])
        end = float(self.case.span)
        moved = np.where(self.times[places] + half <= end, self.times[places] + half, self.times[places] - half)
        shifted = self.case.sample(np.maximum(moved, 0.0))
        return float(np.max(self.metric.distance(shifted, self.exact[places])))

    @cached_property
    def conditioning(self) -> float:
        """The effect at the worst row of half an ulp in each number of the case; nan where it takes long to compute."""
        if isinstance(self.case.motion(), CertifiedMotion) or not self.is_whole:
            return math.nan
        return float(self.case.conditioning(self.times[[self.worst]])[0])

    @property
    def limits(self) -> list[str]:
        """What limits the result besides the motion, a sentence each."""
        limits = []
        if self.digits_effect and self.error <= HALVES * self.digits_effect:
            limits.append(
                f"the digits of the file: half a unit of the last one is {self.digits_effect:.2g} of the size; write more digits"
            )
        if self.times_effect and self.error <= HALVES * self.times_effect:
            limits.append(
                f"the digits of the times: half a unit of the last one changes the state by {self.times_effect:.2g} of the"
                " size; write more digits"
            )
        horizon = self.case.horizon
        if horizon is not None and horizon < self.times[-1]:
            limits.append(
                f"chaos: from t = {horizon:.6g} s on no digit of binary64 can be right; compare with --to {horizon:.6g}"
            )
        elif self.conditioning > self.error / 10:
            limits.append(
                f"binary64: half an ulp in the numbers of the case has the effect {self.conditioning:.2g} at the worst row"
            )
        return limits

    def by_time(self, parts: int = 8) -> list[tuple[float, float]]:
        """The largest error in each of several equal parts of the time, with the end of the part."""
        edges = np.linspace(self.times[0], self.times[-1], parts + 1)
        largest = []
        for low, high in itertools.pairwise(edges.tolist()):
            inside = (self.times >= low) & (self.times <= high)
            if np.any(inside):
                largest.append((float(high), float(np.max(self.errors[inside]))))
        return largest


def find_period(case: Case) -> tuple[str, float] | None:
    """The name and the value (s) of the exact period of a motion; None for a motion without one."""
    values = case.quantities(17)
    names = [name for name in values if name in ("period", "turn_time") or name.endswith("_period")]
    kept = [name for name in names if "small" not in name and "per_period" not in name]
    name = min(kept, key=lambda each: each != "period", default="")
    return (name, float(values[name])) if name and 0 < values[name] < math.inf else None


def count_periods(case: Case, seconds: float) -> str:
    """A time in exact periods, as ", 2.65 periods of 3.77011 s"; empty for a motion without a period."""
    name, exact = find_period(case) or ("", math.inf)
    return f", {seconds / exact:.3g} {name.replace('_', ' ')}s of {exact:.6g} s" if name else ""


def longest_gap(case: Case) -> float:
    """The longest time (s) between rows in which the motion cannot turn unseen: 2 pi times its time scale."""
    return 2 * math.pi * float(case.time_scale)


def compare(
    case: Case,
    trajectory: Trajectory,
    first: float | None = None,
    last: float | None = None,
    is_sorted_on_request: bool = False,
    is_sparse: bool = False,
) -> Comparison:
    """Compare a trajectory with the exact motion of a case, from `first` to `last` (s) if they are given.

    Raises NotCheckedError with the reason if the trajectory cannot be compared, ValueError for times before the motion.
    """
    case = case.rounded()
    trajectory = _in_sequence(trajectory, is_sorted_on_request)
    rows = _choose_rows(trajectory, first, last)
    finite = np.all(np.isfinite(trajectory.states[:, trajectory.present]), axis=1)
    bad = rows[~finite[rows]]
    if len(bad):
        names = [c.name for c, x in zip(case.state, trajectory.states[bad[0]], strict=True) if not math.isfinite(x)]
        here = [name for name in names if trajectory.present[[c.name for c in case.state].index(name)]]
        raise NotCheckedError(
            f"{', '.join(here[:4])} is not a finite number in {trajectory.row(int(bad[0]))}"
            f" (t = {trajectory.times[bad[0]]:.9g} s; {len(bad)} such rows); compare the rows before with --to"
        )
    steps, notes = np.diff(trajectory.times[rows]), []
    gap, after = float(np.max(steps)), float(trajectory.times[rows[int(np.argmax(steps)) + 1]])
    if len(rows) > MOST_COMPARED:
        notes.append(f"compared: {MOST_COMPARED} of {len(rows)} rows, evenly chosen")
        rows = rows[pick_evenly(len(rows), MOST_COMPARED)]
    times = trajectory.times[rows]
    part = _name_part(times, float(case.span), first, last)
    case = _fit_span(case, float(times[-1]))
    exact = case.sample(times)
    scorer = Scorer(case, None, _reference(case, times, exact))
    trajectory.notes += notes
    comparison = Comparison(case, trajectory, rows, exact, scorer, part)
    if last is None and times[-1] < LEAST_TIME * case.time_scale:
        comparison.doubts.append(
            f"only the start: the rows end at t = {times[-1]:.4g} s, and the motion changes within {case.time_scale:.4g} s;"
            " give a longer file, or say with --to how far it has to reach"
        )
    most = longest_gap(case)
    if gap > most and not is_sparse:
        comparison.doubts.append(
            f"a gap of {gap:.6g} s before t = {after:.9g} s is longer than {most:.6g} s (2 pi times the time scale):"
            " whether the phase is right between cannot be told; write rows more often, or accept it with --sparse"
        )
    return comparison


def pick_evenly(count: int, most: int) -> Places:
    """At most `most` places of `count`, evenly chosen, the first and the last among them."""
    return np.unique(np.round(np.linspace(0, count - 1, min(count, most))).astype(np.int64))


def _in_sequence(trajectory: Trajectory, is_sorted_on_request: bool) -> Trajectory:
    """The rows sorted by time if that is wanted. Raises NotCheckedError for times that do not rise otherwise."""
    times = trajectory.times
    bad = np.flatnonzero(~np.isfinite(times))
    if len(bad):
        raise NotCheckedError(f"the time in {trajectory.row(int(bad[0]))} is not a finite number; correct it")
    falling = np.flatnonzero(np.diff(times) <= 0)
    if not len(falling):
        return trajectory
    if not is_sorted_on_request:
        place = int(falling[0]) + 1
        what = "repeated" if times[place] == times[place - 1] else "earlier than the one before"
        raise NotCheckedError(
            f"the time t = {times[place]:.9g} s in {trajectory.row(place)} is {what} ({len(falling)} such rows); correct the"
            " file, or give --sort to sort the rows by time"
        )
    order = np.argsort(times, kind="stable")
    return replace(
        trajectory,
        times=times[order],
        states=trajectory.states[order],
        half_units=trajectory.half_units[order],
        lines=trajectory.lines[order],
        notes=[*trajectory.notes, "rows sorted by time, on request"],
    )


def _choose_rows(trajectory: Trajectory, first: float | None, last: float | None) -> Places:
    times = trajectory.times
    if not len(times):
        raise NotCheckedError("no rows; give a file with the rows of a motion")
    slack = trajectory.half_time + 1e-9 * abs(float(times[-1]))
    if times[0] < -slack:
        raise ValueError(
            f"t = {times[0]:.9g} s in {trajectory.row(0)}: the motion of a case starts at 0; if the first row is the start,"
            " give the time column the option :first"
        )
    if len(times) == 1:
        raise NotCheckedError("only one row; give the rows of a motion")
    if first is not None and times[0] > first + slack:
        raise NotCheckedError(
            f"the rows begin at t = {times[0]:.9g} s, after --from {first:.9g}; nothing is known of the rest"
        )
    if last is not None and times[-1] < last - slack:
        raise NotCheckedError(
            f"the rows end at t = {times[-1]:.9g} s, before --to {last:.9g}; nothing is known of the rest"
        )
    low, high = (0.0 if first is None else first), (math.inf if last is None else last)
    rows = np.flatnonzero((times >= low - slack) & (times <= high + slack))
    if len(rows) < 2:
        raise NotCheckedError(f"{len(rows)} rows from --from to --to; give a longer time")
    if times[rows[-1]] <= 0:
        raise NotCheckedError("only rows at the start, t = 0; give the rows of a motion")
    return rows


def _name_part(times: Floats, span: float, first: float | None, last: float | None) -> str:
    """The times of rows that begin or end well over a step inside the span, where `first` or `last` does not allow it."""
    is_late = first is None and times[0] > 1.5 * (times[1] - times[0])
    is_early = last is None and times[-1] + 1.5 * (times[-1] - times[-2]) < span
    text = f", but only from t = {times[0]:.6g} s to {times[-1]:.6g} s of the span of {span:.6g} s"
    return text if is_late or is_early else ""


def _fit_span(case: Case, last: float) -> Case:
    """The case with the span of a trajectory that ends at `last`; with its own span if the trajectory fills at least half."""
    if float(case.span) / 2 <= last <= float(case.span):
        return case
    other = case.with_span(last)
    other.variant = case.variant
    return other


def _reference(case: Case, times: Floats, exact: Floats, scored: Scorer | None = None) -> ReferenceSolution:
    """A reference solution at the times of a file, without floor and conditioning, which are computed when needed."""
    if scored is None:
        sizes = np.empty(len(case.state))
        for group in case.metric.groups:
            sizes[list(group.indices)] = group.scale
    else:
        sizes = scored.reference.sizes
    none, start = np.zeros(len(times)), np.array([float(x) for x in case.initial_state])
    empty = np.empty((0, len(start)))
    return ReferenceSolution(
        times, exact, none, none, times, start, sizes, np.zeros(len(times), dtype=np.bool_), float(case.time_scale),
        empty, empty, np.empty((0, len(times), len(start))),
    )  # fmt: skip


def _fit_line(x: Floats, y: Floats, weights: Floats) -> tuple[float, Floats]:
    """The slope of a weighted straight line, and the residuals."""
    total = np.sum(weights)
    middle, level = np.sum(weights * x) / total, np.sum(weights * y) / total
    slope = float(np.sum(weights * (x - middle) * (y - level)) / np.sum(weights * (x - middle) ** 2))
    return slope, y - level - slope * (x - middle)


def _crossings(times: Floats, values: Floats) -> Floats:
    """The times at which values rise through zero, by linear interpolation."""
    rising = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    share = -values[rising] / (values[rising + 1] - values[rising])
    return np.asarray(times[rising] + share * (times[rising + 1] - times[rising]))

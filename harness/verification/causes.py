"""The likely causes of wrong states of a case: the mistake, and the error that would be left without it.

Each hypothesis undoes one common mistake, in the states or in the exact motion with which the states are compared. It is a
cause only if the error that is left is small. A hypothesis with a fitted number is a cause only if the error that is left is
also small compared with the change by this number: a correct method of order p has errors of h^p in the amplitudes of a
motion and in its frequencies, and a fitted number would explain only one of the two.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.cases.core.metric import Metric
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.studies.conventions import Turning, conventions, rotations_of_axes, turns
from numpy.typing import NDArray
from scipy.integrate import DOP853, DenseOutput, OdeSolution
from scipy.optimize import linear_sum_assignment
from scipy.spatial.transform import Rotation

NEAR = 0.05
"""A cause leaves less than this share of the error."""
SIZE = 0.1
"""A cause leaves an error below this share of the size of the motion: a motion that diverged fits anything."""
LEAST = 1e-9
"""Smaller errors are not explained: other motions are computed with about this error."""
SNAPPED = 0.02
"""A fitted factor is a factor of `FACTORS` if it is within this share of it."""
OTHER_FACTOR, OTHER_RATE = 0.01, 0.1
"""A factor, or a rate of the time, that is in no list is named if it differs from 1 by more than this. The period of a correct
method at a practical step has a smaller error."""
OFFSET = 0.05
"""A constant offset is named if it is larger than this share of the size of a coordinate."""
ALIKE, TIED = 3.0, 1e-5
"""A cause is named if it leaves at most ALIKE times the error that the best cause leaves, or at most the share TIED of the error."""
FACTORS = {
    180 / math.pi: "degrees for radians",
    math.pi / 180: "radians for degrees",
    1000.0: "a factor 1000, as km for m",
    1e-3: "a factor 1/1000, as km for m",
    -1.0: "the other sign",
    2 * math.pi: "a factor 2 pi",
    1 / (2 * math.pi): "a factor 1/(2 pi), as turns for radians",
    60 / (2 * math.pi): "revolutions per minute for rad/s",
    60.0: "a factor 60",
    1 / 60: "a factor 1/60",
    3.6: "km/h for m/s",
    1 / 0.3048: "feet for metres",
    0.3048: "metres for feet",
    100.0: "a factor 100, as cm for m",
    0.01: "a factor 1/100",
    2.0: "a factor 2",
    0.5: "a factor 1/2",
}
"""Factors on coordinates that people leave out, or apply twice."""
TIMES = {
    1e-3: "the time is in ms",
    1e-6: "the time is in microseconds",
    1000.0: "the time is in thousands of seconds",
    60.0: "the time is in minutes",
    3600.0: "the time is in hours",
    86400.0: "the time is in days",
    1 / 60: "the time is in frames of 1/60 s",
    2 * math.pi: "the time lacks a factor 2 pi, as in turns for radians",
    1 / (2 * math.pi): "the time has a factor 2 pi too much",
    2.0: "the motion is twice as fast",
    0.5: "the motion is half as fast",
    -1.0: "the motion runs backwards",
}
"""Factors of the times at which the exact motion has the computed states."""
OF_PARAMETERS = (
    -1.0,
    2.0,
    0.5,
    1000.0,
    1e-3,
    100.0,
    0.01,
    180 / math.pi,
    math.pi / 180,
    2 * math.pi,
    1 / (2 * math.pi),
)
"""Factors on parameters and starts."""
GRAVITY = {"9.8": 9.8, "9.81": 9.81, "9.80665": 9.80665, "10": 10.0, "9.78": 9.78, "9.83": 9.83}
DIGITS = (1, 2, 3)
"""Significant digits to which people round a parameter."""
MOST_SCALES = 25.0
"""Largest number of time scales over which other motions are computed: a longer span does not tell more."""
MOST_CALLS, TIMES_CALLS, BEYOND = 30_000, 3, 1.3
"""Most right-hand sides of the motion itself; of another motion, as a multiple of them. BEYOND: factor of the horizon up to
which the motion is known."""
RTOL, ATOL = 1e-10, 1e-11
OF_EQUATIONS = ("exchanged", "parameter", "inertia", "start", "damping", "period")
"""The kinds of causes that lie in equations, parameters and start."""
FEWEST = 4
"""Least number of samples."""
SCREEN, OPEN = 8, 0.3
"""Another motion is computed to its end only if, in the first part of SCREEN, it leaves less than the share OPEN."""
SEEN = 1e3
"""The first part decides only if its errors are larger than SEEN times LEAST."""
SETTLED = 0.01
"""If a mistake in states or times leaves less than this share of the error, no other motion is computed."""
ROUNDS = 6
"""Iterations of a fitted number."""


Rows = NDArray[np.bool_]


@dataclass(frozen=True)
class Cause:
    """A likely cause. `kind`: a word; `text`: the mistake; `error`: the error; `left`: the error without the mistake."""

    kind: str
    text: str
    left: float
    error: float

    def __str__(self) -> str:
        return f"{self.text}; without it an error of {self.left:.2g} would be left, of {self.error:.2g}"


@dataclass(frozen=True)
class Explained:
    """A hypothesis: `states` (n, dim), corrected for a mistake, should agree with `exact` (n, dim) in the rows `rows` (n,)."""

    kind: str
    text: str
    states: Floats
    exact: Floats
    rows: Rows
    change: float = math.inf
    """The relative size of a fitted change; infinite for a change that has one size only."""


def causes(
    case: Case, times: Floats, states: Floats, moves: Mapping[str, float] | None = None, own_equations: bool = True
) -> list[Cause]:
    """Find the likely causes of wrong states.

    Parameters
    ----------
    case : Case
        The case with the numbers that the states should belong to.
    times : ndarray, shape (n,)
        The times (s), rising.
    states : ndarray, shape (n, dim)
        The computed states, in the case's coordinates and units. Rows that are not finite are left out.
    moves : mapping of str to float, optional
        Further shifts in time (s) by name, as the step size.
    own_equations : bool
        Whether the states come from equations, parameters and a start of their own, which may be wrong too.

    Returns
    -------
    list of Cause
        The simplest first; empty if nothing that is tried explains the error.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> swing = get("pendulum_simple")
    >>> [cause.text for cause in causes(swing, swing.times, swing.sample(swing.times) * [57.29577951308232, 1])]
    ['theta: degrees for radians']
    """
    times, states = np.asarray(times, dtype=float), np.asarray(states, dtype=float)
    finite = np.isfinite(states).all(axis=1)
    times, states = times[finite], states[finite]
    if len(times) < FEWEST or np.all(states == states[0]):  # a motion that rests is another mistake
        return []
    tried = _Tried(case, times, states, dict(moves or {}))
    by_text: dict[str, Cause] = {}
    least = math.inf
    for group in tried.groups(own_equations) if tried.error > LEAST else ():
        for hypothesis in group:
            cause = tried.judge(hypothesis)
            if cause is not None:
                by_text.setdefault(cause.text, cause)
                least = min(least, cause.left)
        if least < SETTLED * tried.error:
            break
    enough = ALIKE * max(least, TIED * tried.error)
    return [cause for cause in by_text.values() if cause.left <= enough]


def name_low_order(points: Sequence[tuple[float, float]], order: int) -> Cause | None:
    """The cause if errors fall more slowly with the step than the order. `points`: (step, error), longest step first.

    The error that is left is the error of the finest step if errors fell with the order from the step before.
    """
    if len(points) < 2 or not all(error > 0 for _, error in points[-2:]):
        return None
    (h0, e0), (h1, e1) = points[-2:]
    power = math.log(e0 / e1) / math.log(h0 / h1)
    if power >= order - 0.5:
        return None
    return Cause("order", say_low_order(power, order), e0 * (h1 / h0) ** order, e1)


def say_low_order(power: float, order: int) -> str:
    """The sentence about errors that fall with this power of the step."""
    what = "it does not converge" if power < 0.3 else f"it converges with order {power:.1f}"
    return f"{what} where {order} is declared: a coefficient, a sign or a term of the formula is wrong"


def count_printed_digits(values: Floats) -> int | None:
    """The number of decimal digits of the values; None if they need more than 12."""
    numbers = np.asarray(values).ravel()[:128].tolist()
    return next((n for n in range(4, 13) if all(float(f"{x:.{n}g}") == x for x in numbers)), None)


def round_to_single(values: Floats) -> Floats:
    """The nearest single-precision numbers."""
    return np.asarray(values, dtype=np.float32).astype(np.float64)


class _Tried:
    """The hypotheses about one trajectory."""

    def __init__(self, case: Case, times: Floats, states: Floats, moves: dict[str, float]) -> None:
        self.case, self.times, self.states, self.moves = case, times, states, moves
        self.exact = case.sample(times)
        self.names = [coordinate.name for coordinate in case.state]
        self.all: Rows = np.ones(len(times), dtype=bool)
        self._change = math.inf
        with np.errstate(all="ignore"):
            distances = case.metric.distance(states, self.exact)
        self.error = float(np.max(distances))

    @cached_property
    def metric(self) -> Metric:
        return self.case.metric

    @cached_property
    def sizes(self) -> Floats:
        """The largest size of each coordinate on the exact motion; 1 for a coordinate that rests at 0."""
        sizes: Floats = np.max(np.abs(self.exact), axis=0)
        return np.where(sizes > 0, sizes, 1.0)

    @cached_property
    def pairs(self) -> bool:
        """Whether a state consists of positions, then velocities."""
        half, odd = divmod(len(self.names), 2)
        return self.case.second_order is not None or (
            not odd
            and all(name == "v" + other for name, other in zip(self.names[half:], self.names[:half], strict=True))
        )

    def judge(self, hypothesis: Explained) -> Cause | None:
        rows = hypothesis.rows
        if np.count_nonzero(rows) < FEWEST:
            return None
        with np.errstate(all="ignore"):
            left = float(np.max(self.metric.distance(hypothesis.states[rows], hypothesis.exact[rows])))
            before = float(np.max(self.metric.distance(self.states[rows], self.exact[rows])))
        if not (before > LEAST and left < min(NEAR * before, NEAR * hypothesis.change, SIZE)):
            return None
        return Cause(hypothesis.kind, hypothesis.text, left, before)

    def groups(self, own_equations: bool) -> Iterator[Iterator[Explained]]:
        """The hypotheses in groups, the simplest first."""
        yield self.factors()
        yield self.attitudes()
        yield from (self.swaps(), self.permutations(), self.axes(), self.offsets(), self.shifts(), self.clocks())
        if own_equations:
            yield itertools.chain(self.other_numbers(), self.dampings(), self.periods())

    # In the states.

    def of_states(self, kind: str, text: str, states: Floats, change: float = math.inf) -> Explained:
        return Explained(kind, text, states, self.exact, self.all, change)

    def factors(self) -> Iterator[Explained]:
        for named, states in self._scaled(self.states):
            yield Explained("factor", named, states, self.exact, self.all, self._change)

    def _scaled(self, states: Floats) -> Iterator[tuple[str, Floats]]:
        """The states without the factor of each coordinate: first factors of the list, then any factors."""
        norm = np.sum(self.exact**2, axis=0)
        fitted = np.where(norm > 0, np.sum(states * self.exact, axis=0) / np.where(norm > 0, norm, 1.0), 1.0)
        near = [min(FACTORS, key=lambda f: abs(factor / f - 1)) for factor in fitted.tolist()]
        snapped = np.where(np.abs(fitted / near - 1) < SNAPPED, near, 1.0)
        self._change = math.inf
        if np.any(snapped != 1):
            words: dict[str, list[str]] = {}
            for name, factor in zip(self.names, snapped.tolist(), strict=True):
                if factor != 1:
                    words.setdefault(FACTORS[factor], []).append(name)
            yield "; ".join(f"{', '.join(names)}: {word}" for word, names in words.items()), states / snapped
        other = np.where((np.abs(fitted - 1) > OTHER_FACTOR) & (fitted != 0), fitted, 1.0)
        if np.any((other != 1) & (snapped == 1)):
            self._change = float(np.min(np.abs(other[other != 1] - 1)))
            named = ", ".join(f"{name} {f:.6g}" for name, f in zip(self.names, other.tolist(), strict=True) if f != 1)
            yield f"a constant factor: {named}", states / other

    def swaps(self) -> Iterator[Explained]:
        """Orders of positions and velocities that have a name."""
        count, half = len(self.names), len(self.names) // 2
        if self.pairs:
            swapped = np.roll(self.states, half, axis=1)
            text = "velocities stand before positions"
            yield self.of_states("order", text, swapped)
            for named, states in self._scaled(swapped):
                yield Explained("order", f"{text}; {named}", states, self.exact, self.all, self._change)
            woven = [k // 2 + half * (k % 2) for k in range(count)]  # x, vx, y, vy
            if count > 2:
                undone = np.empty_like(self.states)
                undone[:, woven] = self.states
                yield self.of_states("order", "each velocity stands beside its position", undone)

    def permutations(self) -> Iterator[Explained]:
        """The order of the coordinates that fits best; then with signs."""
        count = len(self.names)
        for signs in ((1.0,), (1.0, -1.0)):
            # cost[i, j]: distance of the column i of the states, with the better sign, from the coordinate j
            apart = np.array(
                [
                    [[float(np.max(np.abs(s * self.states[:, i] - self.exact[:, j]))) for j in range(count)] for i in range(count)]
                    for s in signs
                ]
            ) / self.sizes  # fmt: skip
            if not np.isfinite(apart).all():
                return
            _, places = linear_sum_assignment(np.min(apart, axis=0))
            sign = np.array([signs[int(np.argmin(apart[:, i, j]))] for i, j in enumerate(places)])
            if np.all(places == np.arange(count)):
                continue
            undone = np.empty_like(self.states)
            undone[:, places] = self.states * sign
            order = ", ".join(
                "-" * (s < 0) + self.names[j] for j, s in zip(places.tolist(), sign.tolist(), strict=True)
            )
            yield self.of_states("order", f"the coordinates are in the order {order}", undone)

    def offsets(self) -> Iterator[Explained]:
        apart = np.median(self.states - self.exact, axis=0)
        apart[np.abs(apart) < OFFSET * self.sizes] = 0.0
        if np.any(apart):
            named = ", ".join(f"{name} {x:+.6g}" for name, x in zip(self.names, apart.tolist(), strict=True) if x)
            text = f"a constant is added: {named} (another origin, or another line from which an angle counts)"
            yield self.of_states("offset", text, self.states - apart)

    def attitudes(self) -> Iterator[Explained]:
        """Other conventions of a rotation matrix and of an angular velocity along the axes of the body."""
        matrix = [k for k, name in enumerate(self.names) if name in MATRIX]
        spin = [k for k, coordinate in enumerate(self.case.state) if coordinate.kind == "angular velocity"]
        if len(matrix) != 9 or len(spin) != 3:
            return
        rows = self.states[:, matrix].reshape(-1, 3, 3)
        with np.errstate(all="ignore"):
            if not np.all(np.abs(np.linalg.det(rows) - 1) < 0.5):
                return
        turning = Turning(Rotation.from_matrix(rows).as_quat(), self.states[:, spin])
        for convention in conventions(along_body=True):
            undone, states = convention.undo(turning), self.states.copy()
            states[:, matrix] = turns(undone.quaternion).reshape(-1, 9)
            states[:, spin] = undone.spin
            yield self.of_states("convention", convention.text, states)
        for named, turn in rotations_of_axes().items():
            for what, left, right, own in (
                (f"the axes of space are those of another frame: x, y, z are its {named}", turn, np.eye(3), np.eye(3)),
                (f"the axes of the body are others: its x, y, z are {named}", np.eye(3), turn.T, turn),
                (f"the axes of space and body are others: x, y, z are {named}", turn, turn.T, turn),
            ):
                states = self.states.copy()
                states[:, matrix] = (left @ rows @ right).reshape(-1, 9)
                states[:, spin] = self.states[:, spin] @ own.T
                yield self.of_states("axes", what + UP * (turn.tolist() == Y_UP and "space" in what), states)

    def axes(self) -> Iterator[Explained]:
        """A frame with other axes: positions and velocities in threes."""
        kinds = [coordinate.group for coordinate in self.case.state]
        triples = [
            list(range(k, k + 3))
            for k in range(len(kinds) - 2)
            if len(set(kinds[k : k + 3])) == 1 and kinds[k] in ("length", "velocity") and self.names[k].endswith("x")
        ]
        for named, turn in rotations_of_axes().items() if triples else ():
            states = self.states.copy()
            for part in triples:
                states[:, part] = self.states[:, part] @ turn.T
            up = UP * (turn.tolist() == Y_UP)
            yield self.of_states("axes", f"the axes are those of another frame: x, y, z are its {named}{up}", states)

    # In the time.

    def shifts(self) -> Iterator[Explained]:
        """Samples, or a part of the state, one sample early or late, or off by one of the `moves`."""
        half = len(self.names) // 2
        parts = {"states": slice(None)}
        if self.pairs:
            parts |= {"velocities": slice(half, None), "positions": slice(half)}
        interval = np.diff(self.times)
        earlier, later = np.concatenate([interval[:1], interval]), np.concatenate([interval, interval[-1:]])
        tried: list[tuple[str, float | Floats, str]] = [(name, -move, "t - ") for name, move in self.moves.items()]
        tried += [(name, move, "t + ") for name, move in self.moves.items()]
        for name, move, sign in (*tried, ("a sample", -earlier, "t - "), ("a sample", later, "t + ")):
            moved = self.times + move
            rows = (moved >= 0) & (moved <= self.times[-1])
            if np.count_nonzero(rows) < FEWEST:
                continue
            other = self.exact.copy()
            other[rows] = self.sample(moved[rows])
            for what, part in parts.items():
                mixed = self.exact.copy()
                mixed[:, part] = other[:, part]
                yield Explained("shift", f"its {what} fit the exact motion at {sign}{name}", self.states, mixed, rows)

    def clocks(self) -> Iterator[Explained]:
        """Another unit of the time; velocities are then in the case's units, or per unit of the other time."""
        for factor, text in TIMES.items():
            rows = self.near & (self.times * abs(factor) <= max(float(self.times[-1]), self.horizon))
            if factor > 0 and np.count_nonzero(rows) >= FEWEST:
                yield from self._at_rate(factor, text, rows)
            elif factor < 0:
                motion = self.flow(backwards=True)
                if motion is not None:
                    yield Explained("time", text, self.states, motion, self.near)

    def periods(self) -> Iterator[Explained]:
        """A rate of the time that no list has."""
        rate = self._fit_rate()
        if abs(rate - 1) > OTHER_RATE:
            period = f"periods are {1 / rate:.4g} times the exact ones: look for a parameter, or a constant in the time"
            yield from self._at_rate(rate, period, self.near, abs(rate - 1), "period")

    def _at_rate(
        self, factor: float, text: str, rows: Rows, change: float = math.inf, kind: str = "time"
    ) -> Iterator[Explained]:
        exact = self.exact.copy()
        try:
            exact[rows] = self.sample(self.times[rows] * factor)
        except (ArithmeticError, ValueError):
            return
        yield Explained(kind, text, self.states, exact, rows, change)
        if self.pairs:
            quick = exact.copy()
            quick[:, len(self.names) // 2 :] *= factor
            yield Explained(kind, text, self.states, quick, rows, change)

    def _fit_rate(self) -> float:
        """The rate of the time, from the first samples on; 1 if no rate fits."""
        rate, first = 1.0, FEWEST
        scale = 1 / self.sizes
        if self.pairs:  # velocities may be per unit of the other time
            scale[len(scale) // 2 :] = 0.0
        while True:
            rows = slice(0, first)
            for _ in range(ROUNDS):
                small = 1e-6
                try:
                    low, high = (self.sample(self.times[rows] * (rate * each)) for each in (1 - small, 1 + small))
                except (ArithmeticError, ValueError):
                    return 1.0
                slope = (high - low) / (2 * small * rate) * scale
                apart = (self.states[rows] - (high + low) / 2) * scale
                if not np.any(slope):
                    return 1.0
                change = float(np.sum(slope * apart) / np.sum(slope * slope))
                rate = min(max(rate + change, rate / 2), rate * 2)
                if not 0.1 < rate < 10:
                    return 1.0
                if abs(change) < 1e-9:
                    break
            if first >= np.count_nonzero(self.near):
                return rate
            first = min(2 * first, int(np.count_nonzero(self.near)))

    # In the equations.

    @cached_property
    def horizon(self) -> float:
        """The time (s) up to which other motions are computed."""
        return MOST_SCALES * float(self.case.time_scale)

    @cached_property
    def near(self) -> Rows:
        """The rows up to the horizon; at least the first ones."""
        rows: Rows = self.times <= self.horizon
        rows[:FEWEST] = True
        return rows

    @cached_property
    def equations(self) -> FirstOrder | None:
        if self.case.hybrid is not None:
            return None
        return next((form for form in self.case.all_forms() if isinstance(form, FirstOrder)), None)

    @cached_property
    def own(self) -> tuple[OdeSolution | None, float, int]:
        """The motion itself for many times: a dense solution, its end (s), its right-hand sides; None without equations."""
        form, end = self.equations, min(BEYOND * self.horizon, BEYOND * float(self.times[-1]))
        if form is None:
            return None, 0.0, MOST_CALLS
        values = tuple(map(float, self.case.parameter_values()))

        def rates(t: float, state: Floats) -> Floats:
            return np.array(form.equations(t, _values(state), values), dtype=float)

        start = np.array([float(x) for x in self.case.initial_state])
        solver, times, parts = (
            DOP853(rates, 0.0, start, end, rtol=RTOL, atol=ATOL * self.sizes),
            [0.0],
            list[DenseOutput](),
        )
        while solver.status == "running" and solver.nfev < MOST_CALLS:
            if solver.step() is not None or not np.isfinite(solver.y).all():
                break
            times.append(solver.t)
            parts.append(solver.dense_output())
        return (OdeSolution(times, parts), times[-1], solver.nfev) if parts else (None, 0.0, MOST_CALLS)

    def sample(self, times: Floats) -> Floats:
        """The motion itself at times (s), to about LEAST."""
        dense, end, _ = self.own
        if dense is None or np.min(times) < 0 or np.max(times) > end:
            return self.case.sample(times)
        states: Floats = dense(times).T
        return states

    def flow(
        self,
        parameters: Mapping[str, float] | None = None,
        start: Floats | None = None,
        damping: float | None = None,
        backwards: bool = False,
    ) -> Floats | None:
        """The motion of changed equations at the near times, among the exact states; None if it cannot be computed."""
        numbers = {name: float(value) for name, value in self.case.parameters.items()} | dict(parameters or {})
        begin = np.array([float(x) for x in self.case.initial_state]) if start is None else start
        rows, form = self.near, self.equations
        motion = self.exact.copy()
        if form is None:
            if damping is not None or backwards:
                return None
            try:
                exact = {name: Fraction(value) for name, value in numbers.items()}
                motion[rows] = self.case.with_numbers([Fraction(x) for x in begin.tolist()], exact).sample(
                    self.times[rows]
                )
            except (ArithmeticError, ValueError):
                return None
            return motion
        values, half, direction = tuple(numbers.values()), len(begin) // 2, -1.0 if backwards else 1.0

        def rates(t: float, state: Floats) -> Floats:
            rate = np.array(form.equations(direction * t, _values(state), values), dtype=float)
            if damping:
                rate[half:] -= damping * state[half:]
            return direction * rate

        def promising(states: Floats) -> bool:
            """Whether the first states leave little enough of the error that the others are computed."""
            first = slice(0, len(states))
            before = float(np.max(self.metric.distance(self.states[first], self.exact[first])))
            left = float(np.max(self.metric.distance(self.states[first], states)))
            return before < SEEN * LEAST or left < OPEN * before

        with np.errstate(all="ignore"):
            try:
                most = TIMES_CALLS * self.own[2]
                states = _solve(
                    rates, begin, self.times[rows], self.sizes, most, None if damping is not None else promising
                )
            except (ArithmeticError, ValueError):
                return None
        if states is None:
            return None
        motion[rows] = states
        return motion

    def other_numbers(self) -> Iterator[Explained]:
        """Other parameters and starts: exchanged, rounded, in other units, of the other sign."""
        for kind, text, parameters, start in self._numbers():
            motion = self.flow(parameters, start)
            if motion is not None:
                yield Explained(kind, text, self.states, motion, self.near)

    def _numbers(self) -> Iterator[tuple[str, str, dict[str, float] | None, Floats | None]]:
        numbers = {name: float(value) for name, value in self.case.parameters.items()}
        units = {each.name: each.unit for each in self.case.parameter_list}
        for first, other in itertools.combinations(numbers, 2):
            if units[first] == units[other] and numbers[first] != numbers[other]:
                changed = {first: numbers[other], other: numbers[first]}
                yield "exchanged", f"{first} and {other} are exchanged", changed, None
        for group in ([name for name in numbers if units[name] == unit] for unit in dict.fromkeys(units.values())):
            if len(group) == 3 and len({numbers[name] for name in group}) == 3:
                for k in (1, 2):
                    turned = dict(zip(group, (numbers[group[(n + k) % 3]] for n in range(3)), strict=True))
                    shown = ", ".join(f"{name} = {value:g}" for name, value in turned.items())
                    yield "exchanged", f"{shown}: they are about other axes", turned, None
        for name, value in numbers.items():
            for text, instead in _others(value, units[name]).items():
                yield "parameter", f"{name} is {text}, where the case has {value:g}", {name: instead}, None
            if units[name] == "kg m^2":
                arms = [n for n in numbers if units[n] == "m"]
                for mass, arm in itertools.product([n for n in numbers if units[n] == "kg"], arms):
                    for sign in (1, -1):
                        shifted = value + sign * numbers[mass] * numbers[arm] ** 2
                        where = f"{name} {'+' if sign > 0 else '-'} {mass} {arm}^2"
                        if shifted > 0:
                            yield "inertia", f"{name} is about another point: it is {where}", {name: shifted}, None
        yield from self._starts()

    def _starts(self) -> Iterator[tuple[str, str, None, Floats]]:
        """The start that the first row has; without a row at the start, starts with a factor."""
        start = np.array([float(x) for x in self.case.initial_state])
        if self.times[0] == 0:
            if np.max(np.abs(self.states[0] - start) / self.sizes) > LEAST:
                other = ", ".join(
                    f"{name} = {x:.6g} for {y:.6g}{_factor_text(x, y)}"
                    for name, x, y in zip(self.names, self.states[0].tolist(), start.tolist(), strict=True)
                    if x != y
                )
                yield "start", f"another start: {other}", None, self.states[0]
            return
        kinds = [coordinate.kind for coordinate in self.case.state]
        for kind in dict.fromkeys(kinds):
            members = np.array([each == kind for each in kinds])
            for factor, word in ((factor, FACTORS[factor]) for factor in OF_PARAMETERS):
                if np.any(start[members]) and (factor != -1.0 or len(set(kinds)) > 1):
                    yield (
                        "start",
                        f"{_plural(kind)} at the start: {word}",
                        None,
                        np.where(members, start * factor, start),
                    )

    def dampings(self) -> Iterator[Explained]:
        """A damping of all velocities, fitted."""
        if not self.pairs or self.equations is None:
            return
        damping, scale, rows = 0.0, 1 / self.sizes, self.near
        small = 1e-4 / float(self.case.time_scale)
        for _ in range(ROUNDS):
            here, there = self.flow(damping=damping), self.flow(damping=damping + small)
            if here is None or there is None:
                return
            slope = (there - here)[rows] / small * scale
            apart = (self.states - here)[rows] * scale
            if not np.any(slope):
                return
            change = float(np.sum(slope * apart) / np.sum(slope * slope))
            damping += change
            if abs(change) < 1e-6 * abs(damping):
                break
        motion = self.flow(damping=damping)
        if motion is not None and damping:
            word = "damping" if damping > 0 else "negative damping"
            text = f"a {word} that is not in the equations: accelerations of -{abs(damping):.4g}/s times the velocities"
            change = abs(damping) * float(self.case.time_scale)
            yield Explained("damping", text, self.states, motion, self.near, change)


MATRIX = tuple(f"R{row}{column}" for row in (1, 2, 3) for column in (1, 2, 3))
Y_UP = next(iter(rotations_of_axes().values())).tolist()
UP = " (its y axis is up)"


def _plural(kind: str) -> str:
    return {"velocity": "velocities", "angular velocity": "angular velocities"}.get(kind, f"{kind}s")


def _factor_text(value: float, instead: float) -> str:
    """The factor between two numbers that people leave out, in brackets; empty for another one."""
    near = (FACTORS[each] for each in OF_PARAMETERS if instead and math.isclose(value, each * instead, rel_tol=1e-6))
    return next((f" ({word})" for word in near), "")


def _others(value: float, unit: str) -> dict[str, float]:
    """Other values of a parameter by text: another gravity, rounded, with a factor, of the other sign."""
    candidates: dict[str, float] = {}
    if unit == "m/s^2" and 9.7 < abs(value) < 10.1:
        candidates |= {text: math.copysign(number, value) for text, number in GRAVITY.items()}
    candidates |= {f"{value:.{digits}g}": float(f"{value:.{digits}g}") for digits in DIGITS}
    candidates |= {
        f"{factor * value:.4g} ({word})": factor * value for factor, word in FACTORS.items() if factor in OF_PARAMETERS
    }
    if value > 0:
        candidates |= {f"{1 / value:.4g} (its inverse)": 1 / value, f"{value * value:.4g} (its square)": value * value}
    others: dict[str, float] = {}
    for text, number in candidates.items():
        if number != value and number not in others.values():
            others[text] = number
    return others


def _values(state: Floats) -> Values:
    return tuple(state.tolist())


def _solve(
    rates: Callable[[float, Floats], Floats],
    start: Floats,
    times: Floats,
    sizes: Floats,
    most: int,
    promising: Callable[[Floats], bool] | None = None,
) -> Floats | None:
    """The states at these times; None if the solution ends before, takes more than `most` evaluations, or is not `promising`.

    `promising` is asked once, of the states so far, when these are at least 1/SCREEN of all.
    """
    states, filled = np.empty((len(times), len(start))), int(times[0] == 0)
    states[:filled] = start
    screened = max(2, len(times) // SCREEN)
    solver = DOP853(rates, 0.0, start, float(times[-1]), rtol=RTOL, atol=ATOL * sizes)
    while filled < len(times):
        if solver.status != "running" or solver.nfev > most:
            return None
        solver.step()
        if not np.isfinite(solver.y).all():
            return None
        until = int(np.searchsorted(times, solver.t, side="right"))
        if until > filled:
            states[filled:until] = solver.dense_output()(times[filled:until]).T
            if promising is not None and filled < screened <= until and not promising(states[:until]):
                return None
            filled = until
    return states

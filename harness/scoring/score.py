"""What an outcome is worth: its status, its errors against the exact motion, the drift of its invariants.

One orientation of an orbit or a body may be lucky: at one setting the error varies 28 times between orientations. Where
a case has a rotational symmetry, its default settings are solved from turned starts too, and the errors are those of
the start with the median error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.arithmetic import FUNCTIONS, rebind
from gnomon.cases.core.forms import FirstOrder, Hybrid, first_order
from gnomon.cases.core.formulation import Formulation
from gnomon.cases.core.metric import Metric
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.contract.problem import groups_of
from gnomon.harness.scoring.events import score_events
from gnomon.harness.scoring.outcome import Outcome
from gnomon.harness.scoring.reference_solution import ReferenceSolution
from numpy.typing import NDArray

Floats = NDArray[np.float64]

INACCURATE, DIVERGED = 0.1, 1.0
"""Errors above which an answer counts as inaccurate or diverged, if it is also above CONDITIONED conditionings."""
CONDITIONED = 10.0
FIRST = 4
"""Samples that `error_start` is taken over."""
CLOCK_ITERATIONS = 8
_NUMPY_NAMES = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2",
                "asinh": "arcsinh", "acosh": "arccosh", "atanh": "arctanh"}  # fmt: skip
NUMPY = {name: getattr(np, _NUMPY_NAMES.get(name, name)) for name in FUNCTIONS}
"""The functions of `math` on arrays: an invariant is evaluated at all samples at once."""


class Scorer:
    """Judges the outcomes of one case in one formulation."""

    def __init__(self, case: Case, formulation: Formulation | None, reference: ReferenceSolution) -> None:
        self.case, self.formulation, self.reference = case, formulation, reference
        scales = {coordinate.group: float(size) for coordinate, size in zip(case.state, reference.sizes, strict=True)}
        self.metric = Metric.scaled(case, scales, frozenset(reference.times[reference.crowded].tolist()))
        self.parameters = tuple(float(value) for value in case.parameter_values())

    def problem(self, form: Any) -> Problem:
        """What an integrator that takes `form` is given, the counter off."""
        reference = self.reference
        parameters, groups = np.array(self.parameters), groups_of(self.case, self.formulation)
        return Problem(
            form, len(reference.start), parameters, reference.problem_times, reference.time_scale, groups=groups
        )

    def summary(self) -> dict[str, Any]:
        """What the row of a trial says of its truth: the largest floor and conditioning over the samples."""
        return {
            "dimension": len(self.reference.start),
            "floor": float(self.reference.floor.max()),
            "conditioning": float(self.reference.conditioning.max()),
        }

    def measure(self, outcome: Outcome, tolerance: float | None) -> tuple[dict[str, Any], Floats]:
        """The columns of a measurement that the outcome decides, and its states (64, dim) in the case's coordinates."""
        seconds = np.array(outcome.seconds)
        row: dict[str, Any] = {
            "rhs_calls": outcome.rhs_calls,
            "steps": outcome.steps,
            "repeats": len(seconds),
            "seconds_median": float(np.median(seconds)),
            "seconds_low": float(np.quantile(seconds, 0.1)),
            "seconds_high": float(np.quantile(seconds, 0.9)),
            "prepare_seconds": outcome.prepare_seconds,
            "reset_seconds": outcome.reset_seconds,
            "null_seconds": outcome.null_seconds,
            "output": outcome.output or None,
        }
        states = self.decoded(outcome.states)
        row |= self.score(states)
        if outcome.turned is not None:
            row |= self.over_turned(outcome.turned) | {"error_unturned": row["error_max"]}
        if outcome.stopped and row["status"] == "diverged":
            row["reason"] = f"{outcome.stopped}; {row['reason']}"
        if outcome.events is not None and self.case.hybrid is not None:
            row |= self.events(outcome.events)
        if tolerance is not None and math.isfinite(row["error_max"]):
            row["error_over_tolerance"] = row["error_max"] / tolerance
        return row, states

    def over_turned(self, answers: Floats) -> dict[str, Any]:
        """Status and errors of the turned start with the median error, and the range over all of them.

        `answers` (n, 64, dim_y) belong to the truth's turned starts. A start whose error is not finite counts as the
        worst; `error_low` or `error_high` is nan where it is such a start's.
        """
        states = [scorer.decoded(answer) for scorer, answer in zip(self._turned, answers, strict=True)]
        errors = np.array([scorer.largest_error(each) for scorer, each in zip(self._turned, states, strict=True)])
        middle = int(np.argsort(errors, kind="stable")[len(errors) // 2])
        low, high = np.where(np.isfinite(errors), errors, math.nan)[[np.argmin(errors), np.argmax(errors)]]
        found = self._turned[middle].score(states[middle])
        return found | {"turned_starts": len(errors), "error_low": float(low), "error_high": float(high)}

    def largest_error(self, states: Floats) -> float:
        """The largest error of sampled states (64, dim), infinite where one is not finite."""
        with np.errstate(all="ignore"):  # wild but finite states overflow on the way to a large error
            largest = float(np.max(self.metric.distance(states, self.reference.exact, self.reference.times)))
        return largest if math.isfinite(largest) else math.inf

    def score(self, states: Floats) -> dict[str, Any]:
        """Status and errors of sampled states (64, dim): all that follows from them alone."""
        finite = np.all(np.isfinite(states), axis=1)
        if not np.all(finite):
            first = float(self.reference.times[int(np.argmin(finite))])
            return {
                "status": "diverged",
                "reason": f"states are not finite from t = {first:.6g} s",
                "error_max": math.nan,
            }
        with np.errstate(all="ignore"):  # wild but finite states overflow on the way to a large error
            errors = self.metric.distance(states, self.reference.exact, self.reference.times)
        if not np.all(np.isfinite(errors)):
            return {"status": "diverged", "reason": "states too large to measure", "error_max": math.nan}
        status, reason = self.status(errors)
        phase, shape = self.split(states)
        return {
            "status": status,
            "reason": reason,
            "error_max": float(np.max(errors)),
            "error_start": float(np.max(errors[:FIRST])),
            "error_end": float(errors[-1]),
            "error_rms": float(np.sqrt(np.mean(errors**2))),
            "error_phase": phase,
            "error_shape": shape,
            "turns": self.metric.turns(states, self.reference.exact),
            "invariant_drift": {name: float(np.max(drift)) for name, drift in self.drift(states).items()},
        }

    def status(self, errors: Floats) -> tuple[str, str]:
        """`ok`, `inaccurate` or `diverged`, and why, of errors (64,), each against the conditioning up to its time."""
        excusable = CONDITIONED * np.maximum.accumulate(self.reference.conditioning)
        for status, threshold in (("diverged", DIVERGED), ("inaccurate", INACCURATE)):
            beyond = (errors > threshold) & (errors > excusable)
            if np.any(beyond):
                first = int(np.argmax(beyond))
                error = above_text(errors[first], threshold)
                return status, f"error {error} at t = {self.reference.times[first]:.6g} s, above {threshold:g}"
        return "ok", ""

    def split(self, states: Floats) -> tuple[float, float]:
        """The largest component of the error along the exact flow (phase) and across it (shape), both scaled.

        Both nan for hybrid and for driven cases, where an error along the flow is no error in time.
        """
        if self._flow is None:
            return math.nan, math.nan
        groups = self.metric.groups
        error = np.hstack([g.difference(states, self.reference.exact) / g.scale for g in groups])
        phase = np.einsum("ij,ij->i", error, self._flow)
        across = error - phase[:, np.newaxis] * self._flow
        return float(np.max(np.abs(phase))), float(np.max(np.linalg.norm(across, axis=1)))

    def drift(self, states: Floats) -> dict[str, Floats]:
        """Of each invariant, its departure from its law at each sample (64,), over its size.

        A constant one departs by its difference from the start; one that decays, by what it rose above its lowest.
        """
        found = {}
        for name, (function, law, initial, size) in self._invariants.items():
            with np.errstate(all="ignore"):
                (values,) = function(self.reference.times, tuple(states.T), self.parameters)
            values = np.broadcast_to(np.asarray(values, dtype=np.float64), self.reference.times.shape)
            if law == "decays":
                lowest = np.minimum.accumulate(np.concatenate(([initial], values)))
                found[name] = np.maximum(values - lowest[:-1], 0.0) / size
            else:
                found[name] = np.abs(values - initial) / size
        return found

    def events(self, found: Sequence[tuple[float, str]]) -> dict[str, Any]:
        """Events that are missing, events that never were, and the largest error of a time, in seconds."""
        score = score_events(found, self.case.events())
        return {f"events_{name}": value for name, value in score._asdict().items()}

    def decoded(self, states: Floats) -> Floats:
        """States of the problem at its times as states of the case at the sample times."""
        if self.formulation is None:
            return states
        if self.formulation.clock is not None:
            states = self._on_time(states)
        with np.errstate(all="ignore"):
            return np.asarray(self.formulation.decode(states, self.parameters), dtype=np.float64)

    def _on_time(self, states: Floats) -> Floats:
        """Each state moved to its sample time by one step of the formulation's own equations."""
        clock = self.formulation.clock if self.formulation is not None else None
        assert clock is not None
        moved = states.copy()
        for row, (state, time) in enumerate(zip(states, self.reference.times.tolist(), strict=True)):
            if np.all(np.isfinite(state)):
                moved[row] = _to_time(self._equations, self.parameters, tuple(state.tolist()), clock, time)
        return moved

    @cached_property
    def _turned(self) -> list[Scorer]:
        """A judge for each turned start, by its own exact motion."""
        return [
            Scorer(
                self.case.with_numbers(state.tolist(), self.case.parameters),
                self.formulation,
                replace(self.reference, exact=exact, start=start),
            )
            for state, start, exact in zip(
                self.reference.turned, self.reference.turned_starts, self.reference.turned_exact, strict=True
            )
        ]

    @cached_property
    def _equations(self) -> Callable[..., Any]:
        """The formulation's own equations, first order."""
        forms = self.formulation.forms if self.formulation is not None else self.case.forms
        return next(f.equations for f in map(first_order, forms) if isinstance(f, FirstOrder))

    @cached_property
    def _flow(self) -> Floats | None:
        """The unit vector of the exact flow at each sample in the scaled coordinates, zero where nothing moves."""
        form = next((f for f in self.case.all_forms() if isinstance(f, FirstOrder)), None)
        if form is None or not self.case.autonomous or isinstance(self.case.forms[0], Hybrid):
            return None
        rates = np.array(
            [
                form.equations(t, tuple(x), self.parameters)
                for t, x in zip(self.reference.times, self.reference.exact, strict=True)
            ]
        )
        scaled = np.hstack([rates[:, list(g.indices)] / g.scale for g in self.metric.groups])
        norms = np.linalg.norm(scaled, axis=1, keepdims=True)
        return np.asarray(np.divide(scaled, norms, out=np.zeros_like(scaled), where=norms > 0))

    @cached_property
    def _invariants(self) -> dict[str, tuple[Callable[..., Any], str, float, float]]:
        """name -> (function on arrays, law, initial value, size)."""
        start = tuple(float(value) for value in self.case.initial_state)
        found = {}
        for name, invariant in self.case.invariants.items():
            (initial,) = invariant.function(0.0, start, self.parameters)
            size = self._size(invariant.function, float(initial))
            found[name] = (rebind(invariant.function, NUMPY), invariant.law, float(initial), size)
        return found

    @np.errstate(all="ignore")  # over a long decay an invariant leaves binary64: its drift is then not a number
    def _size(self, function: Callable[..., tuple[Any, ...]], initial: float) -> float:
        """The size that a drift is relative to: that of the invariant, or, where its terms cancel, that of the terms.

        The size of the terms is taken as the sum of |x dI/dx| over the coordinates, each at its largest on the exact
        motion, by central differences.
        """
        (values,) = rebind(function, NUMPY)(self.reference.times, tuple(self.reference.exact.T), self.parameters)
        largest = max(abs(initial), float(np.max(np.abs(values))))
        terms = np.zeros(len(self.reference.times))
        for index in range(self.reference.exact.shape[1]):
            step = 2.0**-17 * self.reference.sizes[index]
            sides = []
            for sign in (1, -1):
                states = self.reference.exact.copy()
                states[:, index] += sign * step
                sides.append(rebind(function, NUMPY)(self.reference.times, tuple(states.T), self.parameters)[0])
            terms += np.abs(self.reference.exact[:, index] * (sides[0] - sides[1]) / (2 * step))
        cancelled = float(np.max(terms))
        return largest if largest > 1e-3 * cancelled else cancelled or 1.0


def above_text(value: float, limit: float) -> str:
    """A value above a limit in as many digits, two at least, as it takes to be above the limit as it reads."""
    texts = (f"{value:.{digits}g}" for digits in range(2, 17))
    return next((text for text in texts if float(text) > limit), repr(float(value)))


def _to_time(
    equations: Callable[..., tuple[float, ...]],
    parameters: tuple[float, ...],
    state: tuple[float, ...],
    clock: int,
    time: float,
) -> tuple[float, ...]:
    """One step of the classical Runge-Kutta method from `state`, its length found by Newton so that it ends on `time`.

    The step is as long as the error of the clock, so its own error is the fifth power of that.
    """
    length, landed = 0.0, state
    for _ in range(CLOCK_ITERATIONS):
        try:
            rate = equations(0.0, landed, parameters)[clock]
            correction = (time - landed[clock]) / rate
            if not math.isfinite(correction):
                return state
            length += correction
            landed = _step(equations, parameters, state, length)
        except (ArithmeticError, ValueError):
            return state  # off the domain of the equations: the state is judged where it is
        if abs(time - landed[clock]) <= math.ulp(time):
            break
    return landed


def _step(
    equations: Callable[..., tuple[float, ...]], parameters: tuple[float, ...], y: tuple[float, ...], h: float
) -> tuple[float, ...]:
    def ahead(share: float, k: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(a + share * h * b for a, b in zip(y, k, strict=True))

    k1 = equations(0.0, y, parameters)
    k2 = equations(0.0, ahead(0.5, k1), parameters)
    k3 = equations(0.0, ahead(0.5, k2), parameters)
    k4 = equations(0.0, ahead(1.0, k3), parameters)
    return tuple(a + h / 6 * (b + 2 * c + 2 * d + e) for a, b, c, d, e in zip(y, k1, k2, k3, k4, strict=True))

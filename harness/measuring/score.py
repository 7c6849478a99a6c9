"""Scores an outcome: its status, its errors against the exact motion, the drift of its invariants.

The error depends on the orientation of an orbit or a body: at one setting it varies by a factor of up to 28. If a case
has a rotational symmetry, its default variant is therefore also solved from turned starts, and the errors from the
start with the median error are recorded. A solution that is not finite, from any of these starts, is diverged.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.arithmetic import FUNCTIONS, rebind
from gnomon.cases.core.forms import FirstOrder, Hybrid, first_order
from gnomon.cases.core.formulation import Formulation
from gnomon.cases.core.metric import Metric
from gnomon.harness.contract.integrator import Floats, Problem
from gnomon.harness.contract.problem import groups_of, names_of
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.events import score_events
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.measuring.reference_solution import CaseSpec, ReferenceSolution, reference_solution

INACCURATE, DIVERGED = 0.1, 1.0
"""Errors above which a solution is inaccurate or diverged, if they also exceed CONDITIONED times the conditioning."""
CONDITIONED = 10.0
FIRST = 4
"""Number of samples for `error_start`."""
CLOCK_ITERATIONS = 8
SPREAD = ("turned_starts", "error_low", "error_high")
"""The columns for the range of errors over turned starts."""
_NUMPY_NAMES = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2",
                "asinh": "arcsinh", "acosh": "arccosh", "atanh": "arctanh"}  # fmt: skip
NUMPY = {name: getattr(np, _NUMPY_NAMES.get(name, name)) for name in FUNCTIONS}
"""The functions of `math` for arrays, as an invariant is evaluated at all samples at once."""


class Scorer:
    """Scores the outcomes of one case in one formulation."""

    def __init__(self, case: Case, formulation: Formulation | None, reference: ReferenceSolution) -> None:
        self.case, self.formulation, self.reference = case, formulation, reference
        scales = {coordinate.group: float(size) for coordinate, size in zip(case.state, reference.sizes, strict=True)}
        self.metric = Metric.scaled(case, scales, frozenset(reference.times[reference.crowded].tolist()))
        self.parameters = tuple(float(value) for value in case.parameter_values())

    @classmethod
    def of(cls, case: Case, formulation: Formulation | None = None) -> Self:
        return cls(case, formulation, reference_solution(CaseSpec.of(case, formulation)))

    def problem(self, form: Any, counted: bool = False) -> Problem:
        """The problem for an integrator that accepts `form`; with `counted` its right-hand sides are counted."""
        case, own, reference = self.case, self.formulation, self.reference
        return Problem(
            form, len(reference.start), np.array(self.parameters), reference.problem_times, reference.time_scale,
            counted, groups_of(case, own), names_of(case, own),
        )  # fmt: skip

    def summary(self) -> dict[str, Any]:
        """Columns of a trial from its reference solution: dimension, and the largest floor and conditioning."""
        return {
            "dimension": len(self.reference.start),
            "floor": float(self.reference.floor.max()),
            "conditioning": float(self.reference.conditioning.max()),
        }

    def measure(self, outcome: Outcome, tolerance: float | None) -> tuple[dict[str, Any], Floats]:
        """The columns of a measurement from its outcome, and its states (64, dim) in the case's coordinates."""
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
            "null_work": outcome.null_work,
            "delay_seconds": outcome.delay_seconds,
            "first_seconds": outcome.first_seconds,
            "output": outcome.output or None,
        }
        states = self.decoded(outcome.states)
        scored = self.score(states)
        if outcome.turned is not None:
            own, over = scored["error_max"], self.score_turned(outcome.turned)
            # The median over the turned starts would hide that the solution from the case's own is lost.
            scored = scored | {name: over[name] for name in SPREAD} if math.isnan(own) else over
            row["error_unturned"] = own
        row |= scored
        if outcome.stopped and row["status"] == Status.DIVERGED:
            row["reason"] = f"{outcome.stopped}; {row['reason']}"
        if outcome.events is not None and self.case.hybrid is not None:
            row |= self.events(outcome.events)
        if tolerance is not None and math.isfinite(row["error_max"]):
            row["error_over_tolerance"] = row["error_max"] / tolerance
        return row, states

    def score_turned(self, answers: Floats) -> dict[str, Any]:
        """Status and errors of the turned start with the median error, and the range of errors over all turned starts.

        `answers` (n, 64, dim_y) are the solutions from the turned starts of the reference solution. If an error is not
        finite, status and errors are from that start; `error_low` or `error_high` is nan if it is not finite.
        """
        states = [scorer.decoded(answer) for scorer, answer in zip(self._turned, answers, strict=True)]
        errors = np.array([scorer.largest_error(each) for scorer, each in zip(self._turned, states, strict=True)])
        order, lost = np.argsort(errors, kind="stable"), int(np.count_nonzero(np.isinf(errors)))
        shown = int(order[-1] if lost else order[len(errors) // 2])
        low, high = np.where(np.isfinite(errors), errors, math.nan)[[np.argmin(errors), np.argmax(errors)]]
        row = self._turned[shown].score(states[shown])
        if lost:
            row["reason"] = f"from {lost} of {len(errors)} turned starts: {row['reason']}"
        return row | dict(zip(SPREAD, (len(errors), float(low), float(high)), strict=True))

    def largest_error(self, states: Floats) -> float:
        """The largest error of sampled states (64, dim), infinite if one is not finite."""
        with np.errstate(all="ignore"):  # very large finite states overflow in the metric
            largest = float(np.max(self.metric.distance(states, self.reference.exact, self.reference.times)))
        return largest if math.isfinite(largest) else math.inf

    def score(self, states: Floats) -> dict[str, Any]:
        """Status, errors and drifts of sampled states (64, dim)."""
        finite = np.all(np.isfinite(states), axis=1)
        if not np.all(finite):
            first = float(self.reference.times[int(np.argmin(finite))])
            return _score_diverged(f"states are not finite from t = {first:.6g} s")
        with np.errstate(all="ignore"):  # very large finite states overflow in the metric
            errors = self.metric.distance(states, self.reference.exact, self.reference.times)
        if not np.all(np.isfinite(errors)):
            return _score_diverged("states too large to measure")
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

    def status(self, errors: Floats) -> tuple[Status, str]:
        """`ok`, `inaccurate` or `diverged`, and the reason, from errors (64,).

        An error is compared with the largest conditioning up to its time: an error that rounding of the initial state
        can cause is not a fault of the integrator.
        """
        excusable = CONDITIONED * np.maximum.accumulate(self.reference.conditioning)
        for status, threshold in ((Status.DIVERGED, DIVERGED), (Status.INACCURATE, INACCURATE)):
            beyond = (errors > threshold) & (errors > excusable)
            if np.any(beyond):
                first = int(np.argmax(beyond))
                error = above_text(errors[first], threshold)
                return status, f"error {error} at t = {self.reference.times[first]:.6g} s, above {threshold:g}"
        return Status.OK, ""

    def split(self, states: Floats) -> tuple[float, float]:
        """The largest component of the scaled error along the exact flow (phase) and across it (shape).

        Both are nan for hybrid and for driven cases, in which an error along the flow is not an error in time.
        """
        if self._flow is None:
            return math.nan, math.nan
        error = self.scaled_error(states)
        phase = np.einsum("ij,ij->i", error, self._flow)
        across = error - phase[:, np.newaxis] * self._flow
        return float(np.max(np.abs(phase))), float(np.max(np.linalg.norm(across, axis=1)))

    def drift(self, states: Floats) -> dict[str, Floats]:
        """For each invariant, its departure from its law at each sample (64,), divided by its size.

        A constant invariant departs by its difference from the initial value; a decaying one, by its rise above its
        lowest value so far.
        """
        departures = {}
        for name, (function, law, initial, size) in self._invariants.items():
            with np.errstate(all="ignore"):
                (values,) = function(self.reference.times, tuple(states.T), self.parameters)
            values = np.broadcast_to(np.asarray(values, dtype=np.float64), self.reference.times.shape)
            if law == "decays":
                lowest = np.minimum.accumulate(np.concatenate(([initial], values)))
                departures[name] = np.maximum(values - lowest[:-1], 0.0) / size
            else:
                departures[name] = np.abs(values - initial) / size
        return departures

    def events(self, located: Sequence[tuple[float, str]]) -> dict[str, Any]:
        """The number of missing events, the number of extra events, and the largest error of a time in seconds."""
        score = score_events(located, self.case.events())
        return {f"events_{name}": value for name, value in score._asdict().items()}

    def decoded(self, states: Floats) -> Floats:
        """States of the problem at its times, converted to states of the case at the sample times."""
        if self.formulation is None:
            return states
        if self.formulation.clock is not None:
            states = self._on_time(states)
        with np.errstate(all="ignore"):
            return np.asarray(self.formulation.decode(states, self.parameters), dtype=np.float64)

    def _on_time(self, states: Floats) -> Floats:
        """Each state carried to its sample time by one step of the formulation's own equations."""
        clock = self.formulation.clock if self.formulation is not None else None
        assert clock is not None
        on_time = states.copy()
        for row, (state, time) in enumerate(zip(states, self.reference.times.tolist(), strict=True)):
            if np.all(np.isfinite(state)):
                on_time[row] = _to_time(self._equations, self.parameters, tuple(state.tolist()), clock, time)
        return on_time

    @cached_property
    def _turned(self) -> "list[Scorer]":
        """A scorer for each turned start, with its own exact motion."""
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
        """The formulation's own equations, in first-order form."""
        forms = self.formulation.forms if self.formulation is not None else self.case.forms
        return next(f.equations for f in map(first_order, forms) if isinstance(f, FirstOrder))

    @cached_property
    def scaled_rates(self) -> Floats | None:
        """The rates of the exact motion at each sample, each over the scale of its group; None as for `split`."""
        form = next((f for f in self.case.all_forms() if isinstance(f, FirstOrder)), None)
        if form is None or not self.case.autonomous or isinstance(self.case.forms[0], Hybrid):
            return None
        rates = np.array(
            [
                form.equations(t, tuple(x), self.parameters)
                for t, x in zip(self.reference.times, self.reference.exact, strict=True)
            ]
        )
        return np.hstack([rates[:, list(g.indices)] / g.scale for g in self.metric.groups])

    @cached_property
    def _flow(self) -> Floats | None:
        """The unit vector of the exact flow at each sample in scaled coordinates; zero for a state at rest."""
        scaled = self.scaled_rates
        if scaled is None:
            return None
        norms = np.linalg.norm(scaled, axis=1, keepdims=True)
        return np.asarray(np.divide(scaled, norms, out=np.zeros_like(scaled), where=norms > 0))

    def scaled_error(self, states: Floats) -> Floats:
        """The differences from the exact motion, each over the scale of its group, in the sequence of the groups."""
        return np.hstack([g.difference(states, self.reference.exact) / g.scale for g in self.metric.groups])

    @cached_property
    def _invariants(self) -> dict[str, tuple[Callable[..., Any], str, float, float]]:
        """name -> (function on arrays, law, initial value, size)."""
        start = tuple(float(value) for value in self.case.initial_state)
        invariants = {}
        for name, invariant in self.case.invariants.items():
            (initial,) = invariant.function(0.0, start, self.parameters)
            size = self._size(invariant.function, float(initial))
            invariants[name] = (rebind(invariant.function, NUMPY), invariant.law, float(initial), size)
        return invariants

    @np.errstate(all="ignore")  # during a long decay an invariant may overflow: its drift is then nan
    def _size(self, function: Callable[..., tuple[Any, ...]], initial: float) -> float:
        """The size to which a drift is relative: the largest value of the invariant, or of its terms if they cancel.

        The size of the terms is the sum of |x dI/dx| over the coordinates, by central differences, at its largest on
        the exact motion.
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


def _score_diverged(reason: str) -> dict[str, Any]:
    return {"status": Status.DIVERGED, "reason": reason, "error_max": math.nan}


def moves(reference: ReferenceSolution) -> bool:
    """Whether an exact motion changes by more than rounding of its start can explain; False for an equilibrium."""
    away = np.max(np.abs(reference.exact - reference.exact[0]) / reference.sizes)
    return bool(away > CONDITIONED * np.max(reference.conditioning))


def above_text(value: float, limit: float) -> str:
    """A value above a limit, with as many digits as the text needs to be above the limit, at least two."""
    texts = (f"{value:.{digits}g}" for digits in range(2, 17))
    return next((text for text in texts if float(text) > limit), repr(float(value)))


def _to_time(
    equations: Callable[..., tuple[float, ...]],
    parameters: tuple[float, ...],
    state: tuple[float, ...],
    clock: int,
    time: float,
) -> tuple[float, ...]:
    """One step of the classical Runge-Kutta method from `state`, of a length (by Newton's method) that ends at `time`.

    The step is as long as the error of the clock; its own error is proportional to the fifth power of this length.
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
            return state  # outside the domain of the equations: the state is scored unchanged
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

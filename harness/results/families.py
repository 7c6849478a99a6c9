"""The success of families of methods on problems, with its error and cost, and the separation of methods by a problem.

A problem is a case with the name of its variant, in the case's own formulation. A method that is exact by construction on a
problem is left out there, because it shows nothing about its family.
"""

import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd
from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.registry.families import FAMILIES, OTHER, exact_reason, family_of
from gnomon.harness.results.analysis import NEVER_RAN, records, settings
from gnomon.harness.results.equal_error import error_within, time_at

SUCCESS = 1e-6
"""The error with which a method succeeds."""
PRECISE = (1e-9, SUCCESS, 1e-3)
"""Errors at which a problem separates methods: the first one that a method reaches."""
HIGH_ORDER = 4
"""Least order of the methods that are compared at equal cost."""
LIBRARIES = 3
"""Fewest libraries of these methods."""
TIME, CALLS = "time", "calls"
"""Costs: seconds of a call, and evaluations of the equations."""
Problem = tuple[str, str]


@dataclass(frozen=True)
class Sweep:
    """The scored settings of one method on a problem, loosest first; no setting, if none has an answer."""

    integrator: str
    library: str
    order: float
    """nan for a method whose order varies."""
    errors: tuple[float, ...] = ()
    seconds: tuple[float, ...] = ()
    calls: tuple[float, ...] = ()
    """Evaluations of the equations; nan where they are not counted."""

    @property
    def least(self) -> float:
        return min(self.errors, default=math.inf)

    def costs(self, axis: str) -> tuple[float, ...]:
        return self.seconds if axis == TIME else self.calls

    def counts(self, axis: str) -> bool:
        """Whether its costs are known: only some libraries count evaluations."""
        return axis == TIME or (bool(self.calls) and not any(map(math.isnan, self.calls)))

    def cost(self, error: float, axis: str = TIME) -> float:
        """The cost at which it reaches an error; inf if it does not."""
        cost = time_at(self.errors, self.costs(axis), error)[0] if self.errors else math.nan
        return math.inf if math.isnan(cost) else cost

    def error(self, cost: float, axis: str) -> float:
        """The error that it reaches at a cost, at most 1: so large is the error without an answer."""
        return min(1.0, error_within(self.errors, self.costs(axis), cost)) if self.errors else 1.0


@dataclass(frozen=True)
class Family:
    """A family on a problem: the number of its methods that ran and that succeed, the fastest and the most accurate."""

    name: str
    ran: int
    succeed: int
    fastest: str
    seconds: float
    """Of the fastest to SUCCESS; inf if no method succeeds."""
    closest: str
    error: float
    """The least error of its methods; inf without an answer."""


@dataclass(frozen=True)
class Separation:
    """The separation of methods by a problem: their errors at the cost at which the best method reaches `error`."""

    best: str
    error: float
    cost: float
    """Seconds, or evaluations of the equations."""
    median: float
    """The median over methods of order HIGH_ORDER or more, the best one among them; without an answer 1."""
    methods: int
    libraries: int

    @property
    def factor(self) -> float:
        return self.median / self.error


def sweeps(timed: pd.DataFrame) -> dict[Problem, list[Sweep]]:
    """The methods that ran on each problem, without those that are exact by construction (`exact_reason`).

    `timed`: `analysis.own_spans`.
    """
    ran = timed[(timed["formulation"] == "") & ~timed["status"].isin({*NEVER_RAN, Status.INTERRUPTED})]
    columns = (
        *("case", "variant", "integrator_id", "library", "order_declared"),
        *("status", "error_max", "seconds", "rhs_calls"),
    )
    by_problem: dict[Problem, dict[str, list[dict[str, Any]]]] = {}
    for row in records(settings(ran), columns):
        by_problem.setdefault((row["case"], row["variant"]), {}).setdefault(row["integrator_id"], []).append(row)
    return {
        (case, variant): [_sweep(name, rows) for name, rows in of.items() if exact_reason(name, case) is None]
        for (case, variant), of in by_problem.items()
    }


def _sweep(name: str, rows: Sequence[dict[str, Any]]) -> Sweep:
    """The sweep of a method on a problem, from its rows; the error of a setting that diverged is infinite."""
    scored = [row for row in rows if row["status"] in SCORED and row["seconds"] > 0]
    errors = (math.inf if row["status"] == Status.DIVERGED else row["error_max"] for row in scored)
    return Sweep(
        name,
        rows[0]["library"],
        rows[0]["order_declared"],
        tuple(math.inf if math.isnan(error) else error for error in errors),
        tuple(row["seconds"] for row in scored),
        tuple(row["rhs_calls"] if row["rhs_calls"] > 0 else math.nan for row in scored),
    )


def families(of: Iterable[Sweep]) -> list[Family]:
    """The families of the methods on one problem, in the order of `families.toml`."""
    members: dict[str, list[Sweep]] = {name: [] for name in (*FAMILIES, OTHER)}
    for sweep in of:
        members[family_of(sweep.integrator)].append(sweep)
    return [_family(name, methods) for name, methods in members.items() if methods]


def _family(name: str, methods: Sequence[Sweep]) -> Family:
    times = {method.integrator: method.cost(SUCCESS) for method in methods}
    fastest = min(times, key=lambda key: times[key])
    closest = min(methods, key=lambda method: method.least)
    reached = sum(math.isfinite(seconds) for seconds in times.values())
    return Family(name, len(methods), reached, fastest, times[fastest], closest.integrator, closest.least)


def separation(of: Iterable[Sweep], axis: str = TIME) -> Separation | None:
    """The separation of the methods by a problem at equal time, or at equal numbers of evaluations of the equations.

    It is None if methods of order HIGH_ORDER or more with known costs come from fewer than LIBRARIES libraries, or if no
    method reaches an error of PRECISE.
    """
    methods = [sweep for sweep in of if sweep.counts(axis) or not sweep.errors]
    high = [method for method in methods if math.isnan(method.order) or method.order >= HIGH_ORDER]
    libraries = {method.library for method in high}
    for error in PRECISE if len(libraries) >= LIBRARIES else ():
        cost, best = min((method.cost(error, axis), method.integrator) for method in methods)
        if math.isfinite(cost):
            median = statistics.median(method.error(cost, axis) for method in high)
            return Separation(best, error, cost, median, len(high), len(libraries))
    return None

"""Solutions of constrained motions, judged apart: positions, velocities, multipliers, and the drift off the constraints.

One number hides which of these a method gets wrong: at index 1 the constraints drift, at index 2 the positions leave them,
at index 3 velocities and multipliers lose orders.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from gnomon.cases.core.case import Case
from gnomon.cases.core.elimination import multipliers, product, rows_of
from gnomon.cases.core.forms import Constrained, Equations, Values
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.kernels.equations import function_kernel
from gnomon.harness.studies.scored_states import read_scored_states

COLUMNS = ("position", "velocity", "multiplier", "constraint", "rate")


@dataclass(frozen=True)
class Parts:
    """Errors of a solution, each the largest of its samples: of positions, velocities and multipliers over the largest
    exact one; of constraints (in their units) and of their rates, from those of the start and from 0."""

    position: float
    velocity: float
    multiplier: float
    constraint: float
    rate: float


def parts(case: Case, times: Floats, exact: Floats, states: Floats) -> Parts:
    """Sampled states (64, dim) of a case with a form Constrained, compared with the exact ones.

    The multipliers are those that belong to a state; a method's own ones are not sampled.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> case = get("holonomic_constraint_dae").rounded()
    >>> exact = case.sample(case.times)
    >>> parts(case, case.times, exact, exact).position
    0.0
    """
    n, p = states.shape[1] // 2, np.array([float(x) for x in case.parameter_values()])
    form = find_constrained(case)
    assert form is not None
    start = np.array([float(x) for x in case.initial_state])
    m = len(form.constraint(0.0, tuple(start[:n]), tuple(p)))
    kernel = function_kernel(beside(form), 2 * n, len(p), 3 * m).array
    first = kernel(0.0, start, p)[m : 2 * m]
    rows, true = (np.array([kernel(t, y.copy(), p) for t, y in zip(times, of, strict=True)]) for of in (states, exact))
    return Parts(
        _relative(states[:, :n], exact[:, :n]),
        _relative(states[:, n:], exact[:, n:]),
        _relative(rows[:, :m], true[:, :m]),
        float(np.max(np.abs(rows[:, m : 2 * m] - first))),
        float(np.max(np.abs(rows[:, 2 * m :]))),
    )


def _relative(values: Floats, true: Floats) -> float:
    return float(np.max(np.abs(values - true)) / np.max(np.abs(true)))


def find_constrained(case: Case) -> Constrained | None:
    """The form of a case with constraints, if it has one."""
    return next((form for form in case.all_forms() if isinstance(form, Constrained)), None)


def beside(form: Constrained) -> Equations:
    """(t, state, parameters) -> the multipliers, the constraints, and their rates G q' + g_t."""
    lam, constraint, gradient, rate = multipliers(form), form.constraint, form.gradient, form.constraint_rate

    def at_rest(t: Any, state: Values, p: Values) -> Values:
        half = len(state) // 2
        q, v = state[:half], state[half:]
        along = tuple([product(row, v) for row in rows_of(gradient(t, q, p), half)])
        return (*lam(t, state, p), *constraint(t, q, p), *along)

    if rate is None:
        return at_rest
    moved: Callable[..., Any] = rate

    def moving(t: Any, state: Values, p: Values) -> Values:
        values, added = at_rest(t, state, p), moved(t, state[: len(state) // 2], p)
        last = len(values) - len(added)
        return (*values[:last], *[x + y for x, y in zip(values[last:], added, strict=True)])

    return moving


def judge(path: Path) -> pd.DataFrame:
    """The measurements of constrained cases in a results file: case, variant, integrator_id, error_max, and COLUMNS."""
    rows = []
    for scorer, row, states in read_scored_states(path, lambda case: find_constrained(case) is not None):
        if np.isfinite(states).all():
            apart = parts(scorer.case, scorer.reference.times, scorer.reference.exact, states)
            labels = {name: row[name] for name in ("case", "variant", "integrator_id", "setting", "error_max")}
            rows.append(labels | vars(apart))
    return pd.DataFrame(rows)

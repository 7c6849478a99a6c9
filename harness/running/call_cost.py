"""What one call of compiled equations from Python costs: part of the time of every solver that takes them so."""

from __future__ import annotations

import timeit

from gnomon.cases import get
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.scipy_ivp import right_hand_side_of
from gnomon.harness.contract.problem import initial_state, problem_of

PYTHON_CALL = "one call of compiled equations from Python"
"""The name under which the environment of a run has it."""
CALLS, BLOCKS = 1000, 7


def described() -> dict[str, str]:
    """The time of one call by its name, as the environment of a run has it."""
    return {PYTHON_CALL: f"{1e6 * python_call_seconds():.2f} µs"}


def python_call_seconds() -> float:
    """Seconds that one right-hand side of the simple pendulum takes as SciPy's solvers call it: the least of several
    blocks. Compiled in-house loops call the same equations without Python."""
    case = get("pendulum_simple").rounded()
    function, start = right_hand_side_of(problem_of(case, (FirstOrder,))), initial_state(case)
    return min(timeit.repeat(lambda: function(0.0, start), number=CALLS, repeat=BLOCKS)) / CALLS

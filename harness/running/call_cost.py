"""Measures one call of compiled equations from Python: part of the time of every solver that calls them from Python."""

import timeit

from gnomon.cases import get
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.scipy_ivp import right_hand_side_of
from gnomon.harness.contract.problem import initial_state, problem_of

PYTHON_CALL = "one call of compiled equations from Python"
"""The name of this time in the environment of a run."""
CALLS, BLOCKS = 1000, 7


def describe() -> dict[str, str]:
    """{name: time of one call, in microseconds}, for the environment of a run.

    The call is one right-hand side of the simple pendulum as SciPy's solvers make it; its time is the minimum over
    several blocks of calls. In-house loops are compiled and call these equations without Python.
    """
    case = get("pendulum_simple").rounded()
    function, start = right_hand_side_of(problem_of(case, (FirstOrder,))), initial_state(case)
    seconds = min(timeit.repeat(lambda: function(0.0, start), number=CALLS, repeat=BLOCKS)) / CALLS
    return {PYTHON_CALL: f"{1e6 * seconds:.2f} µs"}

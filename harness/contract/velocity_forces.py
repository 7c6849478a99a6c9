"""Equations of second order with forces that depend on velocities, as a form that equations of first order may have."""

from abc import ABC

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Problem, Unsupported


class VelocityForces(ABC):  # noqa: B024 - no object is made of it: every FirstOrder is one
    """Equations of second order whose forces depend on velocities: q'' = a(t, q, q'). The state is (q..., q'...).

    An integrator accepts it beside SecondOrder. It is then given equations of first order, and calls
    `require_velocities`, as only some of them are of this form.

    Examples
    --------
    >>> isinstance(FirstOrder(lambda t, y, p: (y[1], -p[0] * y[1] * y[1])), VelocityForces)
    True
    """


VelocityForces.register(FirstOrder)


def require_velocities(problem: Problem) -> None:
    """Raise Unsupported unless the first half of the derivatives of first-order equations are the second half of the state.

    They must be so to the bit at several states and parameters.
    """
    form, half = problem.form, problem.dimension // 2
    assert isinstance(form, FirstOrder)
    draw = np.random.default_rng(1)
    for _ in range(3):
        state, parameters = draw.uniform(0.5, 1.5, problem.dimension), problem.parameters * draw.uniform(0.9, 1.1)
        try:
            derivatives = form.equations(float(draw.uniform()), tuple(state.tolist()), tuple(parameters.tolist()))
        except (ArithmeticError, ValueError):
            derivatives = ()
        if problem.dimension % 2 or list(derivatives[:half]) != state[half:].tolist():
            raise Unsupported(
                "the first half of its derivatives are not the second half of its state, as velocities are"
            )

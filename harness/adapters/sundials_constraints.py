"""IDA of SUNDIALS on motions under constraints, by its C interface.

How it is driven, and why:

- The formulation of Gear, Gupta and Leimkuhler (J. Comput. Appl. Math. 12, 1985), of index 2: positions and velocities
  satisfy both the constraints and their rates. So does SUNDIALS' own example of a slider-crank (idaSlCrank_dns.c).
- As in this example the multipliers are left out of the error test (`IDASetSuppressAlg`), which the manual encourages for
  index 2, and IDA computes the Jacobian by differences; these evaluations are counted.
- The values of the constraints at the start are variables too, which stay.
- The residual is compiled. Tolerances are those of IDA on equations without constraints (see `sundials`), except that the
  multipliers have none: the round-off of positions over the step is in them (Petzold and Lötstedt, SIAM J. Sci. Stat.
  Comput. 7, 1986), and with a tolerance Newton's iteration failed from 1e-9 on.
- Multipliers and slopes at the start are consistent; those of the second multipliers are 0.
"""

import ctypes
from typing import Any

import numpy as np
from gnomon.cases.core.elimination import forces_of, multipliers, rows_of
from gnomon.cases.core.forms import Constrained, Equations, Values
from gnomon.harness.adapters.scipy_ivp import STEP_SIZES
from gnomon.harness.adapters.sundials import (
    DATA,
    EQUATIONS,
    NORMAL,
    PARAMETERS,
    Motion,
    Native,
    Session,
    bad,
    numbers,
)  # fmt: skip
from gnomon.harness.contract.constraints import constraints_of, rest
from gnomon.harness.contract.integrator import Integrator, Problem
from gnomon.harness.kernels.c_structures import c_functions, floats_at, run_on, word_at
from gnomon.harness.kernels.equations import function_kernel

NONE = 1e100
"""The absolute tolerance of the multipliers."""
SIZE = 0
"""The number of variables, which is compiled in."""


def stabilise(t: Any, y: Any, slope: Any, out: Any, user: Any) -> int:
    """The equations of IDA: the compiled function takes variables and slopes in one array."""
    both = np.empty(2 * SIZE)
    state, rates, residuals = numbers(y, SIZE), numbers(slope, SIZE), numbers(out, SIZE)
    for i in range(SIZE):
        both[i] = state[i]
        both[SIZE + i] = rates[i]
    run_on(word_at(user, EQUATIONS), t, both, floats_at(word_at(user, PARAMETERS), 1), residuals)
    return bad(residuals)


def residual_of(form: Constrained, n: int, m: int) -> Equations:
    """(t, (variables, slopes), parameters) -> the residual of q' = v - G^T mu, M v' = forces - G^T lam, g and its rate."""
    forces, rate = forces_of(form.force, form.velocity_force), form.constraint_rate or rest(form.constraint)
    constraint, gradient, masses = form.constraint, form.gradient, form.mass or rest(form.force)
    size = 2 * n + 3 * m

    def unit_inertia(t: Any, q: Values, accelerations: Values, p: Values) -> Values:
        return accelerations

    def inertia(t: Any, q: Values, accelerations: Values, p: Values) -> Values:
        rows = rows_of(masses(t, q, p), n)
        return tuple([sum([x * a for x, a in zip(row, accelerations, strict=True)]) for row in rows])

    moved = unit_inertia if form.mass is None else inertia

    def residual(t: Any, both: Values, p: Values) -> Values:
        q, v, lam, mu = both[:n], both[n : 2 * n], both[2 * n : 2 * n + m], both[2 * n + m : 2 * n + 2 * m]
        held, rates = both[2 * n + 2 * m : size], both[size:]
        normals = rows_of(gradient(t, q, p), n)
        pushed, pulled = moved(t, q, rates[n : 2 * n], p), forces(t, both[: 2 * n], p)
        return (
            *[rates[i] - v[i] + sum([row[i] * x for row, x in zip(normals, mu, strict=True)]) for i in range(n)],
            *[pushed[i] - pulled[i] + sum([row[i] * x for row, x in zip(normals, lam, strict=True)]) for i in range(n)],
            *[g - first for g, first in zip(constraint(t, q, p), held, strict=True)],
            *[sum([x * w for x, w in zip(r, v, strict=True)]) + c for r, c in zip(normals, rate(t, q, p), strict=True)],
            *rates[2 * n + 2 * m :],
        )

    return residual


def start_of(form: Constrained) -> Equations:
    """(t, state, parameters) -> slopes, multipliers and constraints of a consistent state."""
    equations, lam, constraint = form.equations, multipliers(form), form.constraint

    def start(t: Any, state: Values, p: Values) -> Values:
        return (*equations(t, state, p), *lam(t, state, p), *constraint(t, state[: len(state) // 2], p))

    return start


class IdaOnConstraints(Native):
    """IDA's backward differentiation formulas of variable order and step on constraints and their rates."""

    name, solver, advance = "IDA on constraints", "IDA", "IDASolve"
    accepts = (Constrained,)
    takes = STEP_SIZES

    def size(self, problem: Problem) -> int:
        assert isinstance(problem.form, Constrained)
        n = problem.dimension // 2
        return 2 * n + 3 * constraints_of(problem.form, n, len(problem.parameters))

    def tolerate(self, session: Session, problem: Problem, rtol: float, atol: float) -> None:
        n = problem.dimension // 2
        each = np.full(session.dimension, atol)
        each[2 * n : 2 * n + 2 * (session.dimension - 2 * n) // 3] = NONE
        session.set("SVtolerances", rtol, session.create_vector(each))

    def connect(self, session: Session, problem: Problem) -> tuple[dict[str, Any], Motion]:
        form, n, size, known = problem.form, problem.dimension // 2, session.dimension, len(problem.parameters)
        assert isinstance(form, Constrained)
        m = (size - 2 * n) // 3
        kernel = function_kernel(residual_of(form, n, m), 2 * size, known, size, problem.counted)
        begin = function_kernel(start_of(form), 2 * n, known, 2 * n + 2 * m).array
        differential, slope = np.ones(size), np.zeros(size)
        differential[2 * n : 2 * n + 2 * m] = 0.0
        dense = session.create_dense()
        slopes, marks = session.create_vector(slope), session.create_vector(differential)
        session.create_memory()
        session.user[EQUATIONS] = kernel.address
        functions = c_functions(((stabilise, "float int int int int"),), (("DATA", DATA), ("SIZE", size)))
        t0, y, state, parameters = problem.t0, session.y, session.state, problem.parameters
        session.set("Init", functions[stabilise.__name__], t0, y, slopes)
        session.set("SetId", marks)
        session.set("SetSuppressAlg", 1)
        session.set("SetLinearSolver", *dense)

        def restart() -> None:
            begun = begin(t0, state[: 2 * n].copy(), parameters)
            slope[:] = 0.0
            slope[: 2 * n] = begun[: 2 * n]
            state[2 * n : 2 * n + m], state[2 * n + m : 2 * n + 2 * m] = begun[2 * n : 2 * n + m], 0.0
            state[2 * n + 2 * m :] = begun[2 * n + m :]
            session.set("ReInit", t0, y, slopes)

        options = {"formulation": "Gear, Gupta, Leimkuhler", "suppressalg": True}
        return options, (restart, (ctypes.addressof(session.reached), y, slopes, NORMAL))


INTEGRATORS: tuple[type[Integrator], ...] = (IdaOnConstraints,)

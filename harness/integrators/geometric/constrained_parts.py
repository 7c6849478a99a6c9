"""The parts of a constrained form that methods of index 3 call, and the arguments on which its functions depend."""

from collections.abc import Callable
from typing import Any

from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.elimination import forces_of, rows_of, solve_all
from gnomon.cases.core.forms import Constrained, Equations, Values
from gnomon.harness.contract.constraints import rest
from gnomon.harness.kernels.traced import RUN, Trace, level


def is_constant(function: Equations, n: int, parameters: int) -> bool:
    """Whether values depend on neither time nor place."""
    trace = Trace(n, parameters)
    values = rebind(function, trace.functions)(trace.t, trace.state, trace.parameters)
    return all(level(value) == RUN for value in values)


def explicit_parts(form: Constrained, of_state: bool = False) -> Callable[..., Any]:
    """(t, q, parameters) -> M^-1 force, constraints, their rates at a constant place, G, and M^-1 G^T by columns.

    With `of_state` a function of (t, state, parameters), whose forces are all but those of the constraints.
    """
    forces = forces_of(form.force, form.velocity_force) if of_state else form.force
    constraint, gradient, mass, place = form.constraint, form.gradient, form.mass, half if of_state else whole
    rate = form.constraint_rate or rest(constraint)

    def of_unit_masses(t: Any, given: Values, p: Values) -> Values:
        q = place(given)
        normals = gradient(t, q, p)
        return *forces(t, given, p), *constraint(t, q, p), *rate(t, q, p), *normals, *normals

    if mass is None:
        return of_unit_masses

    def of_masses(t: Any, given: Values, p: Values) -> Values:
        q = place(given)
        pulled, normals = tuple(forces(t, given, p)), tuple(gradient(t, q, p))
        rights = (pulled, *rows_of(normals, len(q)))
        accelerations, *moved = solve_all(rows_of(mass(t, q, p), len(q)), rights, 1 + 0 * q[0])
        pushed = [x for row in moved for x in row]
        return *accelerations, *constraint(t, q, p), *rate(t, q, p), *normals, *pushed

    return of_masses


def whole(given: Values) -> Values:
    return given


def half(given: Values) -> Values:
    return given[: len(given) // 2]

"""Linear systems in equations, and the multipliers of constraints eliminated with them.

All is without a branch on a value, so that it works in every arithmetic: compiled, traced, in mpmath and in balls.
"""

from collections.abc import Sequence
from typing import Any

from gnomon.cases.core.forms import Constrained, Equations, Values


def solve_linear(rows: Sequence[Values], right: Values, one: Any = 1) -> Values:
    """The solution of a linear system, by elimination without exchange of rows.

    Parameters
    ----------
    rows : sequence of tuples
        The matrix. Its leading minors must not vanish: it is symmetric and definite, or has such a block M first, then
        G^T beside M, G below M and zeros.
    right : tuple
        The right-hand side.
    one : number
        1 in the arithmetic of the numbers, for a matrix that may have plain integers: 1 + 0 * state[0].

    Returns
    -------
    tuple
        The solution.

    Examples
    --------
    >>> solve_linear(((2, 1), (1, 1)), (5, 3))
    (2.0, 1.0)
    """
    return solve_all(rows, (right,), one)[0]


def solve_all(rows: Sequence[Values], rights: Sequence[Values], one: Any) -> tuple[Values, ...]:
    """The solutions of linear systems with one matrix; see `solve_linear`."""
    size = len(rows)
    left = [[*row, *[right[i] for right in rights]] for i, row in enumerate(rows)]
    eliminated: list[list[Any]] = []
    for _ in rows:
        pivot = left[0]
        inverse = one / pivot[0]
        scaled = [x * inverse for x in pivot[1:]]
        left = [[x - row[0] * y for x, y in zip(row[1:], scaled, strict=True)] for row in left[1:]]
        eliminated = [scaled, *eliminated]
    solution: list[Values] = []
    for k, row in enumerate(eliminated):
        known = [row[k + j] - sum([row[i] * x[j] for i, x in enumerate(solution)]) for j in range(len(rights))]
        solution = [tuple(known), *solution]
    return tuple([tuple([solution[i][j] for i in range(size)]) for j in range(len(rights))])


def rows_of(values: Values, width: int) -> tuple[Values, ...]:
    """The rows of a matrix that a function of a form gives row by row."""
    return tuple([tuple(values[k : k + width]) for k in range(0, len(values), width)])


def product(row: Values, other: Values) -> Any:
    """The scalar product of two rows of at least one number."""
    parts = [x * y for x, y in zip(row, other, strict=True)]
    return sum(parts[1:], parts[0])


def along(rows: Sequence[Values], vector: Values, added: Values, one: Any) -> Values:
    """The coefficients of a combination of the rows for which rows . (vector - combination) + added = 0."""
    square = tuple([tuple([product(a, b) for b in rows]) for a in rows])
    right = tuple([product(row, vector) + x for row, x in zip(rows, added, strict=True)])
    return solve_linear(square, right, one)


def constrained_by_unit_masses(gradient: Values, forces: Values, curvature: Values, one: Any) -> Values:
    """The accelerations of q'' = forces - G^T lam, G q'' + curvature = 0."""
    normals = rows_of(gradient, len(forces))
    lam = along(normals, forces, curvature, one)
    across = [tuple([row[i] for row in normals]) for i in range(len(forces))]
    return tuple([f - product(column, lam) for f, column in zip(forces, across, strict=True)])


def constrained_by_masses(mass: Values, gradient: Values, forces: Values, curvature: Values, one: Any) -> Values:
    """The accelerations of M q'' = forces - G^T lam, G q'' + curvature = 0."""
    count = len(forces)
    normals = rows_of(gradient, count)
    upper = [(*row, *[normal[i] for normal in normals]) for i, row in enumerate(rows_of(mass, count))]
    lower = [(*normal, *[0 for _ in normals]) for normal in normals]
    return solve_linear((*upper, *lower), (*forces, *[-x for x in curvature]), one)[:count]


def index_one(
    *, force: Equations, gradient: Equations, curvature: Equations, mass: Equations | None = None,
    velocity_force: Equations | None = None,
) -> Equations:  # fmt: skip
    """The equations of first order of a constrained motion, with the multipliers eliminated.

    Parameters
    ----------
    force, gradient, mass, velocity_force : callable
        The functions of `Constrained`.
    curvature : callable
        (t, state, parameters) -> the second derivatives of the m constraints in time at constant velocities: (dG/dt) q',
        and with time in the constraints d(g_t)/dt besides.

    Returns
    -------
    callable
        (t, state, parameters) -> derivatives, with q'' of M q'' = force + velocity_force - G^T lam, G q'' + curvature = 0.

    Examples
    --------
    >>> def force(t, q, p):
    ...     return 0, -10
    >>> def gradient(t, q, p):
    ...     return 2 * q[0], 2 * q[1]
    >>> def curvature(t, state, p):
    ...     return (2 * state[2] ** 2 + 2 * state[3] ** 2,)
    >>> index_one(force=force, gradient=gradient, curvature=curvature)(0, (0, -1, 2, 0), ())
    (2, 0, 0.0, 4.0)
    """
    forces = forces_of(force, velocity_force)

    def with_unit_masses(t: Any, state: Values, parameters: Values) -> Values:
        half = len(state) // 2
        place, one = state[:half], 1 + 0 * state[0]
        accelerations = constrained_by_unit_masses(
            gradient(t, place, parameters), forces(t, state, parameters), curvature(t, state, parameters), one
        )
        return (*state[half:], *accelerations)

    if mass is None:
        return with_unit_masses

    def with_masses(t: Any, state: Values, parameters: Values) -> Values:
        half = len(state) // 2
        place, one = state[:half], 1 + 0 * state[0]
        inertia, normals = mass(t, place, parameters), gradient(t, place, parameters)
        pushes, bend = forces(t, state, parameters), curvature(t, state, parameters)
        return (*state[half:], *constrained_by_masses(inertia, normals, pushes, bend, one))

    return with_masses


def forces_of(force: Equations, velocity_force: Equations | None) -> Equations:
    """All forces but those of the constraints: a function of (t, state, parameters)."""

    def of_place(t: Any, state: Values, parameters: Values) -> Values:
        return force(t, state[: len(state) // 2], parameters)

    if velocity_force is None:
        return of_place

    def of_state(t: Any, state: Values, parameters: Values) -> Values:
        at_rest, moving = of_place(t, state, parameters), velocity_force(t, state, parameters)
        return tuple([a + b for a, b in zip(at_rest, moving, strict=True)])

    return of_state


def multipliers(form: Constrained) -> Equations:
    """(t, state, parameters) -> lam of M q'' = forces - G^T lam, from the equations of the form.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> (form,) = get("holonomic_constraint_dae").forms
    >>> multipliers(form)(0, (0, -1, 2, 0), (10,))
    (7.0,)
    """
    equations, gradient, forces = form.equations, form.gradient, forces_of(form.force, form.velocity_force)

    def of_unit_masses(t: Any, state: Values, parameters: Values) -> Values:
        half = len(state) // 2
        accelerations = equations(t, state, parameters)[half:]
        pull = tuple([f - x for f, x in zip(forces(t, state, parameters), accelerations, strict=True)])
        normals = rows_of(gradient(t, state[:half], parameters), half)
        return along(normals, pull, tuple([0 for _ in normals]), 1 + 0 * state[0])

    if form.mass is None:
        return of_unit_masses
    mass = form.mass

    def of_masses(t: Any, state: Values, parameters: Values) -> Values:
        half = len(state) // 2
        accelerations, pushes = equations(t, state, parameters)[half:], forces(t, state, parameters)
        inertia = rows_of(mass(t, state[:half], parameters), half)
        pull = tuple([f - product(row, accelerations) for f, row in zip(pushes, inertia, strict=True)])
        normals = rows_of(gradient(t, state[:half], parameters), half)
        return along(normals, pull, tuple([0 for _ in normals]), 1 + 0 * state[0])

    return of_masses

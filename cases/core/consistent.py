"""Starts of constrained motions: how they violate their constraints, and the nearest start that does not."""

from collections.abc import Sequence
from typing import Any

from gnomon.cases.core.elimination import product, rows_of, solve_all, solve_linear
from gnomon.cases.core.forms import Constrained, Values

ROUNDED = 1e-12
"""The residual, over the sum of its terms, up to which a start counts as a consistent one that was rounded."""
MOST_ROUNDS = 50
CONVERGED = 1e-15


def violation(
    form: Constrained, t: float, state: Sequence[Any], parameters: Sequence[Any], constants: Sequence[Any] | None = None
) -> str | None:
    """How a start violates its constraints, in words, with the nearest start that does not; None if it is consistent.

    The velocities must have G q' + g_t = 0; with `constants` the constraints must have these values besides. Nearest is
    in the metric of the masses.
    """
    numbers, p = tuple(map(float, state)), tuple(map(float, parameters))
    half = len(numbers) // 2
    place, velocity = numbers[:half], numbers[half:]
    wrong = []
    if constants is not None:
        values = form.constraint(t, place, p)
        beyond = [g - float(c) for g, c in zip(values, constants, strict=True)]
        sizes = [abs(g) + abs(float(c)) for g, c in zip(values, constants, strict=True)]
        wrong += [f"constraint {k} is off by {x:.6g}" for k, x in exceeding(beyond, sizes)]
    residual, sizes = departing(form, t, place, velocity, p)
    wrong += [f"constraint {k} changes at the rate {x:.6g}" for k, x in exceeding(residual, sizes)]
    if not wrong:
        return None
    try:
        nearest = place if constants is None else nearest_place(form, t, place, p, constants)
        velocities = nearest_velocity(form, t, nearest, velocity, p)
    except ZeroDivisionError:
        return f"{', '.join(wrong)}; its gradients are not independent there"
    start = "velocities are" if constants is None else "start is"
    shown = velocities if constants is None else (*nearest, *velocities)
    return f"{', '.join(wrong)}; the nearest consistent {start} [{', '.join(f'{x:.17g}' for x in shown)}]"


def exceeding(residuals: Sequence[Any], sizes: Sequence[Any]) -> list[tuple[int, Any]]:
    """The residuals above round-off, with their numbers from 1; a residual that is not a number is above it."""
    both = enumerate(zip(residuals, sizes, strict=True), start=1)
    return [(k, x) for k, (x, size) in both if not abs(x) <= ROUNDED * size]


def departing(form: Constrained, t: Any, place: Values, velocity: Values, parameters: Values) -> tuple[Any, Any]:
    """G q' + g_t, and the sums of the sizes of its terms."""
    rows = rows_of(tuple(form.gradient(t, place, parameters)), len(place))
    rates = form.constraint_rate(t, place, parameters) if form.constraint_rate else (0,) * len(rows)
    terms = [
        [g * v for g, v in zip(row, velocity, strict=True)] + [rate] for row, rate in zip(rows, rates, strict=True)
    ]
    return tuple(map(sum, terms)), tuple(sum(map(abs, each)) for each in terms)


def nearest_velocity(form: Constrained, t: Any, place: Values, velocity: Values, parameters: Values) -> Values:
    """The velocity with G q' + g_t = 0 that is nearest in the metric of the masses."""
    residual, _ = departing(form, t, place, velocity, parameters)
    change = across(form, t, place, residual, parameters)
    return tuple(v - x for v, x in zip(velocity, change, strict=True))


def nearest_place(form: Constrained, t: Any, place: Values, parameters: Values, constants: Sequence[Any]) -> Values:
    """A place near to the given one at which the constraints have their constants, by Newton's method."""
    for _ in range(MOST_ROUNDS):
        values = form.constraint(t, place, parameters)
        beyond = tuple(g - float(c) for g, c in zip(values, constants, strict=True))
        change = across(form, t, place, beyond, parameters)
        place = tuple(x - move for x, move in zip(place, change, strict=True))
        if max(map(abs, change)) <= CONVERGED * max(map(abs, place)):
            break
    return place


def across(form: Constrained, t: Any, place: Values, beyond: Values, parameters: Values) -> Values:
    """The shortest displacement in the metric of the masses that changes the constraints by `beyond`."""
    n = len(place)
    normals = rows_of(tuple(form.gradient(t, place, parameters)), n)
    moved = normals
    if form.mass is not None:
        moved = solve_all(rows_of(tuple(form.mass(t, place, parameters)), n), normals, 1.0)
    shares = solve_linear([tuple(product(a, b) for b in moved) for a in normals], beyond, 1.0)
    return tuple(sum(share * row[i] for share, row in zip(shares, moved, strict=True)) for i in range(n))

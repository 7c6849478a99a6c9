"""Forms with several constraints, masses, forces that depend on velocities and time; the check of their parts."""

import random
from typing import Any

from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.elimination import index_one, rows_of, solve_linear
from gnomon.cases.core.forms import Constrained, Values
from gnomon.cases.declare import sin
from gnomon.reference.numerics.precision import working


def weights(t: Any, place: Values, parameters: Values) -> Values:
    """Three point masses in the plane, in a field of gravity and on a spring to a wall that moves."""
    _x1, _y1, _x2, _y2, x3, _y3 = place
    m1, m2, m3, g = parameters
    return 0, -m1 * g, 0, -m2 * g, 3 * (sin(t) - x3), -m3 * g


def masses(t: Any, place: Values, parameters: Values) -> Values:
    """A mass matrix that couples the first two points; definite for positive masses."""
    m1, m2, m3, _g = parameters
    a, b, c = m1 + m2, m2, m3
    return (
        a, 0, b / 2, 0, 0, 0,
        0, a, 0, b / 2, 0, 0,
        b / 2, 0, b, 0, 0, 0,
        0, b / 2, 0, b, 0, 0,
        0, 0, 0, 0, c, 0,
        0, 0, 0, 0, 0, c,
    )  # fmt: skip


def rods(t: Any, place: Values, parameters: Values) -> Values:
    """Half the squares of the lengths of three rods in a row."""
    x1, y1, x2, y2, x3, y3 = place
    first, second = (x2 - x1, y2 - y1), (x3 - x2, y3 - y2)
    return (
        (x1 * x1 + y1 * y1) / 2,
        (first[0] * first[0] + first[1] * first[1]) / 2,
        (second[0] * second[0] + second[1] * second[1]) / 2,
    )


def along_rods(t: Any, place: Values, parameters: Values) -> Values:
    x1, y1, x2, y2, x3, y3 = place
    u, v, w, z = x2 - x1, y2 - y1, x3 - x2, y3 - y2
    return (
        x1, y1, 0, 0, 0, 0,
        -u, -v, u, v, 0, 0,
        0, 0, -w, -z, w, z,
    )  # fmt: skip


def bend_of_rods(t: Any, state: Values, parameters: Values) -> Values:
    u1, v1, u2, v2, u3, v3 = state[6:]
    return (
        u1 * u1 + v1 * v1,
        (u2 - u1) * (u2 - u1) + (v2 - v1) * (v2 - v1),
        (u3 - u2) * (u3 - u2) + (v3 - v2) * (v3 - v2),
    )


def on_a_shaken_pivot(t: Any, place: Values, parameters: Values) -> Values:
    """The same with a pivot at height t^2."""
    x1, y1 = place[:2]
    _, second, third = rods(t, place, parameters)
    return (x1 * x1 + (y1 - t * t) * (y1 - t * t)) / 2, second, third


def along_shaken_rods(t: Any, place: Values, parameters: Values) -> Values:
    return place[0], place[1] - t * t, *along_rods(t, place, parameters)[2:]


def rate_of_the_pivot(t: Any, place: Values, parameters: Values) -> Values:
    return -2 * t * (place[1] - t * t), 0, 0


def bend_of_shaken_rods(t: Any, state: Values, parameters: Values) -> Values:
    y1, u1, v1 = state[1], state[6], state[7] - 2 * t
    return u1 * u1 + v1 * v1 - 2 * (y1 - t * t), *bend_of_rods(t, state, parameters)[1:]


def drag(t: Any, state: Values, parameters: Values) -> Values:
    u1, v1, u2, v2, u3, v3 = state[6:]
    return -u1 / 2, -v1 / 2, v2 * state[0], -u2 * state[0], -u3 * u3 * u3, -v3


def varying_masses(t: Any, place: Values, parameters: Values) -> Values:
    found = masses(t, place, parameters)
    return found[0] + place[0] * place[0], *found[1:]


CHAIN = Constrained(
    index_one(force=weights, gradient=along_rods, curvature=bend_of_rods, mass=masses),
    force=weights, constraint=rods, gradient=along_rods, mass=masses,
)  # fmt: skip
OF_UNIT_MASSES = Constrained(
    index_one(force=weights, gradient=along_rods, curvature=bend_of_rods),
    force=weights, constraint=rods, gradient=along_rods,
)  # fmt: skip
SHAKEN = Constrained(
    index_one(force=weights, gradient=along_shaken_rods, curvature=bend_of_shaken_rods, mass=masses),
    force=weights, constraint=on_a_shaken_pivot, gradient=along_shaken_rods, mass=masses,
    constraint_rate=rate_of_the_pivot,
)  # fmt: skip
DRAGGED = Constrained(
    index_one(
        force=weights, gradient=along_shaken_rods, curvature=bend_of_shaken_rods, mass=varying_masses,
        velocity_force=drag,
    ),
    force=weights, constraint=on_a_shaken_pivot, gradient=along_shaken_rods, mass=varying_masses, velocity_force=drag,
    constraint_rate=rate_of_the_pivot,
)  # fmt: skip
FORMS = {"chain": CHAIN, "unit masses": OF_UNIT_MASSES, "shaken": SHAKEN, "dragged": DRAGGED}
"""Three rods in a row, in Cartesian coordinates: 6 coordinates, 3 constraints, 4 parameters."""


def tangent(mp: Any, rows: Any, rates: Any, velocity: Any) -> list[Any]:
    """The velocity nearest to one given that has G q' + g_t = 0."""
    m = len(rows)
    square = [tuple(mp.fdot(a, b) for b in rows) for a in rows]
    beyond = tuple(mp.fdot(row, velocity) + rate for row, rate in zip(rows, rates, strict=True))
    shares = solve_linear(square, beyond)
    return [v - mp.fsum(shares[k] * rows[k][i] for k in range(m)) for i, v in enumerate(velocity)]


def check_parts(form: Constrained, n: int, count: int, seed: str = "") -> None:
    """At a random consistent state: G and g_t are derivatives of g, g'' = 0 along q'', and M q'' - forces lies in G^T.

    `n`: the number of coordinates; `count`: the number of parameters.
    """
    source = random.Random(seed)
    with working(60) as mp:
        functions = mpmath_arithmetic(mp)

        def value(name: str, *arguments: Any) -> list[Any]:
            return [mp.mpf(x) for x in rebind(getattr(form, name), functions)(*arguments)]

        t, p = mp.mpf(source.uniform(0, 1)), tuple(mp.mpf(source.uniform(1, 2)) for _ in range(count))
        place = tuple(mp.mpf(source.uniform(-1, 1)) for _ in range(n))
        rows = rows_of(tuple(value("gradient", t, place, p)), n)
        m = len(value("constraint", t, place, p))
        assert len(rows) == m
        rates = value("constraint_rate", t, place, p) if form.constraint_rate else [mp.mpf(0)] * m
        velocity = tangent(mp, rows, rates, [mp.mpf(source.uniform(-1, 1)) for _ in range(n)])
        state = (*place, *velocity)
        found = value("equations", t, state, p)
        assert found[:n] == velocity
        accelerations = found[n:]

        def along(k: int, s: Any) -> Any:
            path = zip(place, velocity, accelerations, strict=True)
            return value("constraint", t + s, tuple(x + s * v + s * s / 2 * a for x, v, a in path), p)[k]

        for k in range(m):
            assert abs(mp.diff(lambda s, k=k: along(k, s), 0)) < 1e-20
            assert abs(mp.diff(lambda s, k=k: along(k, s), 0, 2)) < 1e-15
            assert abs(mp.diff(lambda s, k=k: value("constraint", t + s, place, p)[k], 0) - rates[k]) < 1e-20
            for i in range(n):
                moved = [
                    tuple(x + s * (i == j) for j, x in enumerate(place)) for s in (mp.mpf("1e-25"), mp.mpf("-1e-25"))
                ]
                above, below = (value("constraint", t, q, p)[k] for q in moved)
                assert abs((above - below) / mp.mpf("2e-25") - rows[k][i]) < 1e-20
        pull = value("force", t, place, p)
        if form.velocity_force is not None:
            pull = [a + b for a, b in zip(pull, value("velocity_force", t, state, p), strict=True)]
        mass = value("mass", t, place, p) if form.mass else [mp.mpf(i == j) for i in range(n) for j in range(n)]
        inertia = rows_of(tuple(mass), n)
        assert all(inertia[i][j] == inertia[j][i] for i in range(n) for j in range(i))
        rest = [f - mp.fdot(row, accelerations) for f, row in zip(pull, inertia, strict=True)]
        assert max(map(abs, tangent(mp, rows, [0] * m, rest))) < 1e-45, "the rest is a force of the constraints"

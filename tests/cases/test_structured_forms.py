"""Every structured form of a case agrees with the second derivation of its motion (independent_mechanics)."""

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import flint
import pytest
from gnomon.cases import get, names
from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.elimination import along, rows_of
from gnomon.cases.core.forms import (
    Charged,
    Constrained,
    Form,
    Friction,
    Impact,
    NBody,
    SemiLinear,
    Separable,
)
from gnomon.reference.numerics.taylor import flint_arithmetic
from independent import STATES, evaluated, many_digits, same
from independent_mechanics import Vec, coefficient, cross, dot, length, sqrt
from independent_models import MODELS, drawn

KINDS = (Separable, SemiLinear, Charged, Constrained, NBody, Impact, Friction)
FORMS = [(name, form) for name in names() for form in get(name).forms if isinstance(form, KINDS)]


@pytest.fixture(autouse=True)
def _precision() -> Iterator[None]:
    with many_digits():
        yield


def gradient(function: Any, t: Any, q: list[Any], p: SimpleNamespace, k: int = 0) -> list[Any]:
    """The gradient of a value of a function of position, by series along each coordinate."""
    found = []
    for i in range(len(q)):
        moved = [flint.arb_series([x, int(i == j)], 3) for j, x in enumerate(q)]
        found.append(coefficient(evaluated(function, t, moved, p)[k], 1))
    return found


def separable(form: Separable, name: str, p: Any, t: Any, s: Any, rates: list[Any]) -> None:
    """The acceleration is minus the gradient of the potential."""
    q = first_half(s)
    same([-x for x in gradient(form.potential, t, q, p)], rates[len(q) :])


def first_half(s: SimpleNamespace) -> list[Any]:
    values = list(vars(s).values())
    return values[: len(values) // 2]


def parameter_function(function: Any, p: SimpleNamespace) -> list[Any]:
    return list(rebind(function, flint_arithmetic())(tuple(vars(p).values())))


def semilinear(form: SemiLinear, name: str, p: Any, t: Any, s: Any, rates: list[Any]) -> None:
    state = list(vars(s).values())
    rows = parameter_function(form.linear, p)
    n = len(state)
    moved = [dot(rows[i * n : (i + 1) * n], state) for i in range(n)]
    same([a + b for a, b in zip(moved, evaluated(form.rest, t, s, p), strict=True)], rates)


def charged(form: Charged, name: str, p: Any, t: Any, s: Any, rates: list[Any]) -> None:
    values = list(vars(s).values())
    place, u = values[:3], Vec(values[3:])
    if form.light:
        (c,) = parameter_function(form.light, p)
        u = u / sqrt(1 + dot(u, u) / (c * c))
    fields = evaluated(form.fields, t, place, p)
    same(Vec(fields[:3]) + cross(u, fields[3:]), rates[3:])


def constrained(form: Constrained, name: str, p: Any, t: Any, s: Any, rates: list[Any]) -> None:
    """Forces less mass times acceleration are a combination of the gradients of the constraints."""
    q = first_half(s)
    n = len(q)
    normals = rows_of(tuple(evaluated(form.gradient, t, q, p)), n)
    for k, normal in enumerate(normals):
        same(normal, gradient(form.constraint, t, q, p, k))
    forces = evaluated(form.force, t, q, p)
    if form.velocity_force is not None:
        forces = [a + b for a, b in zip(forces, evaluated(form.velocity_force, t, s, p), strict=True)]
    if form.constraint_rate is not None:
        moved = evaluated(form.constraint, flint.arb_series([t, 1], 3), q, p)
        same(evaluated(form.constraint_rate, t, q, p), [coefficient(x, 1) for x in moved])
    taken = rates[n:]
    if form.mass is not None:
        taken = [dot(row, taken) for row in rows_of(tuple(evaluated(form.mass, t, q, p)), n)]
    pull = tuple(a - b for a, b in zip(taken, forces, strict=True))
    one = flint.arb(1)
    shares = along(normals, pull, (0,) * len(normals), one)
    same([dot(shares, column) for column in zip(*normals, strict=True)], pull)


def gravitating(form: NBody, name: str, p: Any, t: Any, s: Any, rates: list[Any]) -> None:
    """Newton's law of gravitation between the bodies; the state is linear in their positions and velocities."""
    masses, bodies = parameter_function(form.masses, p), form.bodies(tuple(vars(s).values()))
    path = form.bodies(tuple(flint.arb_series([x, v], 3) for x, v in zip(vars(s).values(), rates, strict=True)))
    same([coefficient(x, 1) for body in path for x in body[:3]], [x for body in bodies for x in body[3:]])
    moved = []
    for i, body in enumerate(bodies):
        pull = Vec((0, 0, 0))
        for j, other in enumerate(bodies):
            if i != j:
                apart = Vec(other[:3]) - body[:3]
                pull = pull + apart * (masses[j] / length(apart) ** 3)
        moved.append((*body[3:], *pull))
    same(form.state(bodies), vars(s).values())
    same(form.state(tuple(moved)), rates)


def impact(form: Impact, name: str, p: Any, t: Any, s: Any, rates: list[Any]) -> None:
    """Free motion, and after an impact the gap opens at the restitution times the rate at which it closed."""
    same(evaluated(form.free, t, s, p), rates)
    p, t, s = drawn(name, "at bounce", 0)
    q = first_half(s)
    assert evaluated(form.gap, t, q, p)[0] == 0
    normal = evaluated(form.normal, t, q, p)
    same(normal, gradient(form.gap, t, q, p))
    same([dot(normal, normal)], [flint.arb(1)])
    before, after = list(vars(s).values())[len(q) :], MODELS[name].after(p, t, s, "bounce")[len(q) :]
    (restitution,) = parameter_function(form.restitution, p)
    same([dot(normal, after)], [-restitution * dot(normal, before)])


def rubbing(form: Friction, name: str, p: Any, t: Any, s: Any, rates: list[Any]) -> None:
    """Without friction for side 0; the bounds are proportional to the coefficients of friction."""
    free = MODELS[name].rates(SimpleNamespace(**(vars(p) | {"mu_k": flint.arb(0)})), t, s, form.modes[0].name)
    same(evaluated(form.sliding, t, s, p, (0.0,)), free)
    for side in (1.0, -1.0):
        mode = next(mode.name for mode in form.modes if mode.constants == (side,))
        p, t, s = drawn(name, mode, 0)
        free = MODELS[name].rates(SimpleNamespace(**(vars(p) | {"mu_k": flint.arb(0)})), t, s, mode)
        braked = MODELS[name].rates(p, t, s, mode)
        same(evaluated(form.sliding, t, s, p, (side,)), braked)
        kinetic = (free[1] - braked[1]) * side
        same(evaluated(form.bounds, t, s, p), [kinetic, kinetic * p.mu_s / p.mu_k])


STATED: dict[type[Any], Callable[..., None]] = {
    Separable: separable,
    SemiLinear: semilinear,
    Charged: charged,
    Constrained: constrained,
    NBody: gravitating,
    Impact: impact,
    Friction: rubbing,
}


@pytest.mark.parametrize(("name", "form"), FORMS, ids=lambda x: x if isinstance(x, str) else type(x).__name__)
def test_the_form_agrees_with_the_second_derivation(name: str, form: Form) -> None:
    mode = form.modes[0].name if isinstance(form, (Impact, Friction)) else ""
    for seed in range(STATES):
        p, t, s = drawn(name, mode, seed)
        STATED[type(form)](form, name, p, t, s, MODELS[name].rates(p, t, s, mode))

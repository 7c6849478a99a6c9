"""The equations of motion of every case against a second derivation that shares no formula with them.

The second derivation is d'Alembert's principle on mass points in an inertial Cartesian frame (independent_mechanics):
a case states there only where its points are and which forces pull at them.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import flint
import independent_bodies
import independent_contact
import independent_earth
import independent_impacts
import independent_oscillators
import independent_particles
import independent_pendulums
import pytest
from gnomon.cases import case_class, get, names
from gnomon.cases.arithmetic import rebind
from gnomon.cases.forms import first_order
from gnomon.reference.taylor import flint_arithmetic
from independent_mechanics import DIGITS
from independent_models import MODELS

SCENES = (
    *(independent_bodies, independent_contact, independent_earth, independent_impacts),
    *(independent_oscillators, independent_particles, independent_pendulums),
)
"""Importing them fills MODELS."""
STATES = 3
"""Random states and numbers, each of every mode and transition."""
TOLERANCE = flint.arb("1e-30")
"""Of the largest component: limits are right to 35 digits, everything else to more than 100."""
ROUNDED = flint.arb("1e-100")
"""Where all components are zero, what is left of their terms."""


@pytest.fixture(autouse=True)
def _precision() -> Iterator[None]:
    before, cap = flint.ctx.dps, flint.ctx.cap
    flint.ctx.dps, flint.ctx.cap = DIGITS, 3
    yield
    flint.ctx.dps, flint.ctx.cap = before, cap


def drawn(name: str, mode: str, seed: int) -> tuple[SimpleNamespace, Any, SimpleNamespace]:
    """Parameters, time and state; a coordinate that the domain pins (a start at rest) is drawn all the same."""
    kind, source = case_class(name), random.Random(f"{name} {mode} {seed}")
    parameters = [parameter.name for parameter in kind.parameter_list]
    found = kind.domain.draw([*parameters, *(c.name for c in kind.state)], source.random)
    p = SimpleNamespace(**{label: flint.arb(found[label]) for label in parameters})
    values = {}
    for coordinate in kind.state:
        allowed = kind.domain.ranges.get(coordinate.name)
        pinned = allowed is not None and allowed.typical[0] == allowed.typical[1]
        values[coordinate.name] = flint.arb(source.uniform(-1, 1) if pinned else found[coordinate.name])
    s = SimpleNamespace(**values)
    prepare = MODELS[name].prepare
    t = prepare(source, p, s, mode) if prepare else None
    return p, flint.arb(source.uniform(0, 3)) if t is None else t, s


def same(found: Any, expected: Any, where: Any) -> None:
    size = max(float(abs(flint.arb(x))) for x in expected)
    for k, (a, b) in enumerate(zip(found, expected, strict=True)):
        assert abs(flint.arb(a) - b) <= TOLERANCE * size + ROUNDED, (where, k, float(flint.arb(a)), float(flint.arb(b)))


def test_every_moving_case_has_a_second_derivation() -> None:
    assert set(MODELS) == set(names())


@pytest.mark.parametrize("name", names())
def test_equations_follow_from_the_scene(name: str) -> None:
    case, model = get(name), MODELS[name]
    arithmetic = flint_arithmetic()
    regimes: list[tuple[str, Any, tuple[float, ...]]] = [
        (mode.name, mode.equations, mode.constants) for mode in (case.hybrid.modes if case.hybrid else ())
    ]
    forms = [found for found in map(first_order, case.all_forms()) if found is not None]
    regimes += [("", form.equations, ()) for form in forms]
    assert regimes
    for mode, equations, constants in regimes:
        for seed in range(STATES):
            p, t, s = drawn(name, mode, seed)
            values = *vars(p).values(), *map(flint.arb, constants)
            found = rebind(equations, arithmetic)(t, tuple(vars(s).values()), values)
            same(found, model.rates(p, t, s, mode), (mode, vars(p), vars(s)))


@pytest.mark.parametrize("name", [name for name in names() if get(name).hybrid])
def test_transitions_follow_from_impulses(name: str) -> None:
    case, model = get(name), MODELS[name]
    assert case.hybrid is not None
    arithmetic = flint_arithmetic()
    for transition in case.hybrid.transitions:
        for seed in range(STATES):
            p, t, s = drawn(name, f"at {transition.name}", seed)
            arguments = t, tuple(vars(s).values()), tuple(vars(p).values())
            (guard,) = rebind(transition.guard, arithmetic)(*arguments)
            expected = flint.arb(0)
            if model.guards and transition.name in model.guards:
                expected = model.guards[transition.name](p, s, model.multipliers(p, t, s, transition.mode))
            assert abs(guard - expected) <= TOLERANCE * (1 + abs(expected)), (transition.name, guard, expected)
            found = rebind(transition.reset, arithmetic)(*arguments)
            same(found, model.after(p, t, s, transition.name), (transition.name, vars(p), vars(s)))

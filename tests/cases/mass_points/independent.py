"""The second derivations of all moving cases together, and how they are compared with the equations of a case."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import flint
import independent_bodies
import independent_chains
import independent_contact
import independent_earth
import independent_impacts
import independent_oscillators
import independent_particles
import independent_pendulums
import independent_rolling
from gnomon.cases.core.arithmetic import rebind
from gnomon.reference.numerics.taylor import flint_arithmetic
from independent_mechanics import DIGITS

SCENES = (
    *(independent_bodies, independent_chains, independent_contact, independent_earth, independent_impacts),
    *(independent_oscillators, independent_particles, independent_pendulums, independent_rolling),
)
"""Importing them fills the register of models."""
STATES = 3
"""Random states and numbers, each of every mode and transition."""
TOLERANCE = flint.arb("1e-30")
"""Of the largest component: limits are right to 35 digits, everything else to more than 100."""
ROUNDED = flint.arb("1e-100")
"""Where all components are zero, what is left of their terms."""


@contextmanager
def many_digits() -> Iterator[None]:
    """Balls of many digits and series of second order."""
    before, cap = flint.ctx.dps, flint.ctx.cap
    flint.ctx.dps, flint.ctx.cap = DIGITS, 3
    try:
        yield
    finally:
        flint.ctx.dps, flint.ctx.cap = before, cap


def evaluated(function: Any, t: Any, s: Any, p: SimpleNamespace, constants: tuple[float, ...] = ()) -> list[Any]:
    """A function of a case in balls; `s` are names with values, or the values."""
    state = tuple(vars(s).values()) if isinstance(s, SimpleNamespace) else tuple(s)
    values = *vars(p).values(), *map(flint.arb, constants)
    return list(rebind(function, flint_arithmetic())(t, state, values))


def same(found: Any, expected: Any, where: Any = "") -> None:
    """Component by component, relative to the largest."""
    size = max(abs(float(flint.arb(x))) for x in expected)
    for k, (a, b) in enumerate(zip(found, expected, strict=True)):
        assert abs(flint.arb(a) - b) <= TOLERANCE * size + ROUNDED, (where, k, float(flint.arb(a)), float(flint.arb(b)))

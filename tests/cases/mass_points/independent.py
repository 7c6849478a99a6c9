"""All independent derivations and quantities, and how derivations are compared with the equations of a case."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import flint
from gnomon.cases.core.arithmetic import rebind
from gnomon.reference.numerics.taylor import flint_arithmetic
from independent_mechanics import DIGITS

for file in sorted(Path(__file__).parents[1].glob("*/independent_*.py")):
    import_module(file.stem)  # fills MODELS, and SMOOTH and HYBRID of independent_quantities
STATES = 3
"""The number of random states, with random parameters, for each mode and transition."""
TOLERANCE = flint.arb("1e-30")
"""Relative to the largest component: limits are accurate to 35 digits, all else to more than 100."""
ROUNDED = flint.arb("1e-100")
"""Absolute, for components that are all zero: the round-off of their terms."""


@contextmanager
def many_digits() -> Iterator[None]:
    """Use balls of many digits, and series of second order."""
    before, cap = flint.ctx.dps, flint.ctx.cap
    flint.ctx.dps, flint.ctx.cap = DIGITS, 3
    try:
        yield
    finally:
        flint.ctx.dps, flint.ctx.cap = before, cap


def evaluated(function: Any, t: Any, s: Any, p: SimpleNamespace, constants: tuple[float, ...] = ()) -> list[Any]:
    """A function of a case in balls; `s` has values by name, or is a sequence of values."""
    state = tuple(vars(s).values()) if isinstance(s, SimpleNamespace) else tuple(s)
    values = *vars(p).values(), *map(flint.arb, constants)
    return list(rebind(function, flint_arithmetic())(t, state, values))


def same(found: Any, expected: Any, where: Any = "") -> None:
    """Assert that the components agree, relative to the largest."""
    size = max(abs(float(flint.arb(x))) for x in expected)
    for k, (a, b) in enumerate(zip(found, expected, strict=True)):
        assert abs(flint.arb(a) - b) <= TOLERANCE * size + ROUNDED, (where, k, float(flint.arb(a)), float(flint.arb(b)))

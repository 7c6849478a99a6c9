"""Motions that follow from a motion of a case: in other units, mirrored, with like parts exchanged."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import Equations
from numpy.typing import NDArray

Floats = NDArray[np.float64]

UNITS = {"m": (1, 0), "s": (0, 1), "N": (1, -2), "Pa": (-1, -2), "V": (2, -2), "T": (0, -1)} | dict.fromkeys(
    ("1", "rad", "kg", "C"), (0, 0)
)
"""The powers of length and time in each unit; kilogram and coulomb are not changed."""


@dataclass(frozen=True)
class Relation:
    """A relation between two motions: the related motion follows from the known motion.

    The number `name` of the related motion is `factors[name]` (1 without an entry) times the number `sources[name]`
    (`name` without an entry) of the known motion, and its times are `time` times as long.
    """

    factors: Mapping[str, float] = field(default_factory=dict)
    sources: Mapping[str, str] = field(default_factory=dict)
    time: float = 1.0

    def applied(self, names: Sequence[str], values: Floats) -> Floats:
        """Compute the numbers (..., n) of the related motion from the numbers of the known motion."""
        places = [names.index(self.sources.get(name, name)) for name in names]
        factors = [self.factors.get(name, 1.0) for name in names]
        return np.asarray(values, dtype=np.float64)[..., places] * factors

    def undone(self, names: Sequence[str], values: Floats) -> Floats:
        """The inverse of `applied`."""
        back = Relation(
            {self.sources.get(name, name): 1 / self.factors.get(name, 1.0) for name in names},
            {self.sources.get(name, name): name for name in names},
        )
        return back.applied(names, values)


def mirrored(case: Case) -> Relation | None:
    """The relation by `Case.mirror`, None for a case without it."""
    return Relation(dict.fromkeys(case.mirror, -1.0)) if case.mirror else None


def permuted(case: Case) -> Relation | None:
    """The relation by `Case.alike`, None for a case without it: each part takes the numbers of the next one."""
    following = (*case.alike[1:], *case.alike[:1])
    pairs = [pair for part, other in zip(case.alike, following, strict=True) for pair in zip(part, other, strict=True)]
    return Relation(sources=dict(pairs)) if pairs else None


def in_units(case: Case, length: float, time: float) -> Relation | None:
    """The same motion where a metre is `length` units and a second `time`; None if a unit is not of those in `UNITS`."""
    units = {c.name: c.unit for c in case.state} | {p.name: p.unit for p in case.parameter_list}
    try:
        powers = {name: _powers(unit) for name, unit in units.items()}
    except (KeyError, ValueError):
        return None
    return Relation({name: length**a * time**b for name, (a, b) in powers.items()}, time=time)


def _powers(unit: str) -> tuple[float, float]:
    """The powers of length and time in a unit such as `m^3/(kg s^2)`. Raises KeyError or ValueError for another text."""
    above, _, below = unit.replace("^(1/2)", "^0.5").partition("/")
    total = [0.0, 0.0]
    for sign, part in ((1.0, above), (-1.0, below)):
        for symbol, _, power in (factor.partition("^") for factor in part.strip("()").split()):
            total = [old + sign * float(power or 1) * new for old, new in zip(total, UNITS[symbol], strict=True)]
    return total[0], total[1]


def defect(
    case: Case,
    equations: Equations,
    relation: Relation,
    moments: Sequence[tuple[float, Floats]],
    values: Floats,
) -> float:
    """How far equations of first order are from keeping a relation, at (time, state) pairs and parameters.

    The largest error of a derivative, over the largest value of that component: 0 where the relation holds, infinite
    where the equations have no value.
    """
    coordinates = [coordinate.name for coordinate in case.state]
    after = relation.applied([parameter.name for parameter in case.parameter_list], values)

    def slopes(t: float, state: Floats, parameters: Floats) -> Floats:
        return np.array(equations(t, tuple(state.tolist()), tuple(parameters.tolist())), dtype=np.float64)

    try:
        known = np.array([slopes(t, state, values) for t, state in moments])
        related = [(t * relation.time, relation.applied(coordinates, state)) for t, state in moments]
        actual = np.array([slopes(t, state, after) for t, state in related])
    except (ArithmeticError, ValueError):
        return math.inf
    expected = relation.applied(coordinates, known) / relation.time
    sizes = np.max(np.abs(expected), axis=0)
    return float(np.max(np.abs(actual - expected) / np.where(sizes > 0, sizes, 1.0)))

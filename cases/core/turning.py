"""Rotational symmetry of a case: the motion from a turned start is the turned motion."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol, TypeVar

import numpy as np
from gnomon.cases.core.interface import StatedCase
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STARTS = 9
"""The number of turned starts; odd, so that the median is the error of one of them."""
_ATTEMPTS = 1000
_PLASTIC = 1.2207440846057596
"""The root of x^4 = x + 1, whose powers give evenly spread points in three dimensions (R3 sequence, Roberts 2018)."""


@dataclass(frozen=True)
class Turning:
    """A rotational symmetry: if these vectors are turned by one rotation, the motion is. Other coordinates do not change.

    `vectors` names the coordinates of each vector: two names for a vector in the plane of the rotation, three for one
    in space. Vectors in space may be turned by any rotation; if `vertical`, only about the third axis.

    Examples
    --------
    >>> plane = Turning((("x", "y"), ("vx", "vy")))
    >>> plane.rotation(1).shape
    (2, 2)
    """

    vectors: tuple[tuple[str, ...], ...]
    vertical: bool = False

    def rotation(self, number: int) -> Floats:
        """Rotation `number` = 1, 2, ... of a fixed, evenly spread sequence, a matrix (2, 2) or (3, 3)."""
        a, b, c = (number * _PLASTIC**-power % 1.0 for power in (1, 2, 3))
        cos, sin = math.cos(2 * math.pi * a), math.sin(2 * math.pi * a)
        if len(self.vectors[0]) == 2:
            return np.array([[cos, -sin], [sin, cos]])
        if self.vertical:
            return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        # A unit quaternion, evenly spread: Shoemake, Graphics Gems III (1992).
        low, high = math.sqrt(c), math.sqrt(1 - c)
        w, x = high * sin, high * cos
        y, z = low * math.sin(2 * math.pi * b), low * math.cos(2 * math.pi * b)
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )

    def turned(self, case: StatedCase, states: Floats, rotation: Floats) -> Floats:
        """States (..., dim) of a case, turned by a rotation matrix (2, 2) or (3, 3)."""
        names = [coordinate.name for coordinate in case.state]
        turned = np.array(states, dtype=np.float64)
        for vector in self.vectors:
            indices = [names.index(name) for name in vector]
            turned[..., indices] = states[..., indices] @ rotation.T
        return turned


class SymmetricCase(StatedCase, Protocol):
    """A case that says whether it has a rotational symmetry."""

    @property
    def turning(self) -> Turning | None: ...


C = TypeVar("C", bound=SymmetricCase)


def turned_cases(case: C, count: int = STARTS) -> list[C]:
    """The case from `count` turned starts, each rounded to binary64; their exact motions start at the rounded numbers.

    Empty if the case declares no symmetry. Raises ValueError if its domain admits too few turned starts.
    """
    if case.turning is None:
        return []
    start = np.array([float(value) for value in case.initial_state])
    names = [coordinate.name for coordinate in case.state]
    admitted: list[C] = []
    for number in range(1, _ATTEMPTS):
        turned: Sequence[float] = case.turning.turned(case, start, case.turning.rotation(number)).tolist()
        if case.domain.admits(case.parameters | {n: Fraction(x) for n, x in zip(names, turned, strict=True)}):
            admitted.append(case.with_numbers(turned, case.parameters))
        if len(admitted) == count:
            return admitted
    raise ValueError(f"{case.id}: its domain admits {len(admitted)} of {count} turned starts; see its `turning`")

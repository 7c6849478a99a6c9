"""Another way to write a case, with its own state, equations and independent variable."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from gnomon.cases.core.forms import Form
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Formulation:
    """Another way to write a case.

    `forms`: as in a Case, the most structured first. `encode(mp, state, parameters)` -> y in the mpmath context mp
    (the harness computes it in high precision and rounds once). `decode(y, parameters)`: array (..., dim_y) -> array
    (..., dim). `clock`: the index of the component of y that is t; None if the independent variable is t.
    `independent(t, digits)` -> the exact value of the independent variable at time t; given only with a clock.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> [each.name for each in get("kepler_orbit").formulations]
    ['sundman']
    """

    name: str
    forms: tuple[Form, ...]
    encode: Callable[[Any, Sequence[Any], Sequence[Any]], tuple[Any, ...]]
    decode: Callable[[Floats, Sequence[float]], Floats]
    clock: int | None = None
    independent: Callable[[Any, int], Any] | None = None

"""What an opponent of a check is."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

Numbers = Mapping[str, float]


class Unsupported(Exception):  # noqa: N818
    """Raised by an opponent for numbers that it cannot be given; the message says why."""


@dataclass(frozen=True)
class IndependentComputation:
    """`compute(numbers)` gives quantities of the check by name, as floats, from its parameters in binary64."""

    name: str
    library: str
    check: str
    compute: Callable[[Numbers], Mapping[str, float]]

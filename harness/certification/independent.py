"""The type of an independent computation of the quantities of a check."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

Numbers = Mapping[str, float]


class Unsupported(Exception):  # noqa: N818
    """Raised by a computation for numbers that it does not accept; the message is the reason."""


@dataclass(frozen=True)
class IndependentComputation:
    """A numerical way to quantities of a check. `compute(parameters)` returns them as floats by name; the parameters are
    binary64."""

    name: str
    library: str
    check: str
    compute: Callable[[Numbers], Mapping[str, float]]

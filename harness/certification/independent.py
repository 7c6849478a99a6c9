"""The type of an independent computation of the quantities of a check."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

Numbers = Mapping[str, float]
Quantities = dict[str, Any]


@dataclass(frozen=True)
class IndependentComputation:
    """A numerical computation of quantities of a check.

    `compute(parameters)` returns them by name, each as a number or as components in the order of the check; the
    parameters are binary64.
    """

    name: str
    library: str
    check: str
    compute: Callable[[Numbers], Quantities]


def independent(
    name: str, library: str, check: str
) -> Callable[[Callable[[Numbers], Quantities]], IndependentComputation]:
    """A decorator: the function computes quantities of `check` with `library`."""
    return partial(IndependentComputation, name, library, check)

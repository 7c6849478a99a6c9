"""The attributes of a case that sampling, turned starts, the metric and accuracy read: `Case` calls these, so they stand below it."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple, Protocol, Self

import numpy as np
from gnomon.cases.core.declared import Coordinate
from gnomon.cases.core.forms import Hybrid
from gnomon.cases.core.numbers import Domain
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.precision import Number
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Between(NamedTuple):
    """Where a time stands among the events: how many are past, the last (0 at first), the next (infinite: none).

    `gap` is the local time between events.
    """

    past: int
    last: Any
    next: Any
    gap: Any


class StatedCase(Protocol):
    """The numbers of a case and the declarations of its state, see `Case`."""

    @property
    def id(self) -> str: ...
    @property
    def variant(self) -> str | None: ...
    @property
    def state(self) -> tuple[Coordinate, ...]: ...
    @property
    def scored(self) -> tuple[str, ...]: ...
    @property
    def domain(self) -> Domain: ...
    @property
    def natural_sizes(self) -> Mapping[str, float]: ...
    @property
    def autonomous(self) -> bool: ...
    @property
    def hybrid(self) -> Hybrid | None: ...
    @property
    def time_scale(self) -> float: ...
    @property
    def initial_state(self) -> tuple[Fraction, ...]: ...
    @property
    def parameters(self) -> dict[str, Fraction]: ...
    @property
    def span(self) -> Fraction: ...
    def parameter_values(self) -> tuple[Fraction, ...]: ...
    def with_numbers(self, initial_state: Sequence[Number], parameters: Mapping[str, Number]) -> Self: ...


class SolvedCase(StatedCase, Protocol):
    """A case with its exact motion and the events of it, see `Case`."""

    @property
    def times(self) -> Floats: ...
    def motion(self) -> Motion: ...
    def exact(self, t: Number, digits: int = 15) -> tuple[Any, ...]: ...
    def sample(self, times: Floats) -> Floats: ...
    def between(self, t: float) -> Between: ...
    def event_time(self, n: int, digits: int = 15) -> Any: ...
    def same_course(self, other: Self) -> bool: ...

"""The clock of a call of `solve`: the user's time and the time of the problem."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Clock:
    """The time of the problem, t, since the start: the user's time is t0 + direction scale t.

    `mirrored`: the number of the last coordinates that are rates by the problem's time. `scale`: a power of two, in the
    unit of the user's time. `first`, `last`: the limits of the times that a function of Python is called with.
    """

    t0: float
    direction: float
    mirrored: int = 0
    scale: float = 1.0
    first: float = -math.inf
    last: float = math.inf

    @property
    def rate(self) -> float:
        """The user's time over the time of the problem."""
        return self.direction * self.scale

    def time(self, t: Any) -> Any:
        """The user's time at a time of the problem, a number, an array or a symbol."""
        return self.t0 + self.rate * t

    def elapsed(self, time: Any) -> Any:
        """The time of the problem at a time of the user."""
        return (time - self.t0) / self.rate

    def within(self, t: float) -> float:
        """The user's time between the limits, which rounding, or a method that probes the end, may pass."""
        return min(max(float(self.time(t)), self.first), self.last)

    def own(self, state: Any) -> Any:
        """A state (..., dim) of the problem as the user has it."""
        return self._with_rates(state, 1 / self.rate)

    def given(self, state: Any) -> Any:
        """A state (..., dim) of the user as the problem has it."""
        return self._with_rates(state, self.rate)

    def _with_rates(self, state: Any, factor: float) -> Any:
        if factor == 1 or not self.mirrored:
            return state
        split = state.shape[-1] - self.mirrored
        return np.concatenate([state[..., :split], factor * state[..., split:]], axis=-1)

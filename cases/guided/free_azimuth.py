"""Base class of governor and bead on a free hoop: one coordinate in a well, an azimuth with constant momentum."""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar

from gnomon.cases.core.case import Level, same
from gnomon.cases.core.numbers import Coordinate
from gnomon.cases.oscillators.well import WellCase
from gnomon.reference.guided.free_azimuth import Governor
from gnomon.reference.numerics.precision import Number

HEAVIER = 2**40
"""The rate of a spindle or hoop that is heavier by this factor is constant to twelve digits."""


class FreeAzimuthCase(WellCase):
    """State (theta, phi, rate, spin); the parameter I is the moment of the spindle or hoop about the vertical."""

    state = (
        Coordinate("theta", "rad", "angle"),
        Coordinate("phi", "rad", "angle"),
        Coordinate("rate", "rad/s", "angular velocity"),
        Coordinate("spin", "rad/s", "angular velocity"),
    )
    reversal = ("rate", "spin")

    _PERIODS: ClassVar = {"long_1e4": 10000.37}
    _DRIVEN: ClassVar[str]
    """The effect of the level whose I is so large that the rate is constant."""

    @cached_property
    def _exact(self) -> Governor:
        raise NotImplementedError

    @cached_property
    def time_scale(self) -> float:  # type: ignore[override]
        """The period of theta over 2 pi, or the time of a radian of the fastest rotation if that is shorter."""
        slow, fastest = super().time_scale, float(self._exact.fastest_spin())
        return min(slow, 1 / fastest) if fastest else slow

    def natural_span(self) -> Number:
        """5.37 periods of theta."""
        periods = self._PERIODS.get(self.variant or "", 5.37)
        return 10 if self._exact.rests else periods * float(self._exact.period())

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`azimuth`: by how much phi grows in a period (rad); `small_frequency`: that about the steady angle (rad/s)."""
        motion = self._exact
        found = {"steady_angle": motion.steady_angle(digits), "momentum": motion.momentum(digits)}
        if motion.rests:
            return found
        found |= {
            "small_frequency": motion.small_frequency(digits),
            "azimuth": motion.carried_over_period(0, digits),
        }
        return super().quantities(digits) | found

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The model with a constant rate: a spindle or hoop too heavy to be slowed."""
        numbers = self.numbers | {"I": self.parameters["I"] * HEAVIER}
        if self.parameters["I"] > HEAVIER or not self.domain.admits(numbers):
            return ()
        parameters: dict[str, Any] = self.parameters | {"I": numbers["I"]}
        driven = type(self)(initial_state=self.initial_state, span=self.span, **parameters)
        return (Level(driven, same, self._DRIVEN),)

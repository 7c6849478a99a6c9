"""Base class of governor and bead on a free hoop: one coordinate in a well, an azimuth with constant momentum."""

from functools import cached_property
from typing import ClassVar

from gnomon.cases.declare import *
from gnomon.cases.oscillators.well import WellCase
from gnomon.reference.guided.free_azimuth import Governor

HEAVIER = 2**40
"""The rate of a spindle or hoop that is heavier by this factor is constant to twelve digits."""


class FreeAzimuthCase(WellCase):
    """State (theta, phi, rate, spin); the parameter I is the moment of the spindle or hoop about the vertical."""

    exact_motion: Governor
    reversal = ("rate", "spin")

    _DRIVEN: ClassVar[str]
    """The effect of the level whose I is so large that the rate is constant."""

    @cached_property
    def time_scale(self) -> float:  # type: ignore[override]
        """The period of theta over 2 pi, or the time of a radian of the fastest rotation if that is shorter."""
        slow, fastest = super().time_scale, float(self.exact_motion.fastest_spin())
        return min(slow, 1 / fastest) if fastest else slow

    def natural_span(self) -> Number:
        """5.37 periods of theta; 10 s in equilibrium."""
        return 10 if self.exact_motion.rests else self.periods * float(self.exact_motion.period())

    @property
    def quantity_names(self) -> tuple[str, ...]:
        """`azimuth`: the growth of phi in a period (rad); `small_frequency`: of swings about the steady angle (rad/s)."""
        moving = () if self.exact_motion.rests else ("small_frequency", "azimuth")
        return ("steady_angle", "momentum", *moving)

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The model with a constant rate: a spindle or hoop too heavy to be slowed."""
        numbers = self.numbers | {"I": self.numbers["I"] * HEAVIER}
        if self.numbers["I"] > HEAVIER or not self.domain.admits(numbers):
            return ()
        return (self.level(type(self), self._DRIVEN, I=numbers["I"]),)

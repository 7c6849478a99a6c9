"""Base class of cases with one coordinate in a potential well: span, time scale, period, turning points, reversal."""

from functools import cached_property
from typing import ClassVar

from gnomon.cases.declare import *
from gnomon.reference.numerics.well import WellMotion


class WellCase(Case):
    """A case whose motion is a WellMotion (reference/numerics/well.py): periodic, except for coordinates that advance."""

    exact_motion: WellMotion
    default_span = Span(5.37, "turn")
    _REST_TIME: ClassVar[float] = 1.0
    """The time scale if the start is an equilibrium (s)."""

    @cached_property
    def time_scale(self) -> float:  # type: ignore[override]
        """The period over 2 pi; in equilibrium 1 s."""
        return self._REST_TIME if self.exact_motion.rests else float(self.exact_motion.period()) / tau

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """Period, least and largest coordinate, then the quantities of the subclass; in equilibrium these alone."""
        if self.exact_motion.rests:
            return super().quantities(digits)
        low, high = self.exact_motion.turning_points(digits)
        return {"period": self.exact_motion.period(digits), "least": low, "largest": high} | super().quantities(digits)

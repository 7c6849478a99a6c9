"""Base class of cases with one coordinate in a potential well: span, time scale, period, turning points, reversal."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from math import tau
from typing import Any, ClassVar

from gnomon.cases.core.case import Case
from gnomon.reference.numerics.precision import Number
from gnomon.reference.numerics.well import WellMotion


class WellCase(Case):
    """A case whose motion is a WellMotion (reference/numerics/well.py): periodic, except for coordinates that advance."""

    _PERIODS: ClassVar[Mapping[str, float]] = {}
    _REST_TIME: ClassVar[float] = 1.0
    """The time scale if the start is an equilibrium (s)."""

    @cached_property
    def _exact(self) -> WellMotion:
        raise NotImplementedError

    def motion(self) -> WellMotion:
        return self._exact

    @cached_property
    def time_scale(self) -> float:  # type: ignore[override]
        """The period over 2 pi; in equilibrium 1 s."""
        return self._REST_TIME if self._exact.rests else float(self._exact.period()) / tau

    def natural_span(self) -> Number:
        """5.37 periods."""
        return self._PERIODS.get(self.variant or "", 5.37) * tau * self.time_scale

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        if self._exact.rests:
            return {}
        low, high = self._exact.turning_points(digits)
        return {"period": self._exact.period(digits), "least": low, "largest": high}

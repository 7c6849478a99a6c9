"""A pendulum whose support is accelerated: it hangs along the apparent gravity."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.pendulums.equivalent_pendulum import EquivalentPendulum


@dataclass(frozen=True)
class CarriedPendulum(EquivalentPendulum):
    """A pendulum whose support has the constant acceleration (ax, ay); g + ay and ax are not both zero."""

    g: Fraction
    length: Fraction
    ax: Fraction
    ay: Fraction

    def _pull(self, mp: Any) -> Any:
        return mp.hypot(mp.mpf(self.g + self.ay), mp.mpf(self.ax)) / mp.mpf(self.length)

    def _shift(self, mp: Any) -> Any:
        return mp.atan2(mp.mpf(self.ax), mp.mpf(self.g + self.ay))

"""A uniform chain in a circular tube, its middle at theta from the bottom: W^2 = (2g/L) sin(L/2R)."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from gnomon.reference.pendulums.equivalent_pendulum import EquivalentPendulum


@dataclass(frozen=True)
class TubeChain(EquivalentPendulum):
    """A chain of length L in a smooth vertical tube of radius R, L < 2 pi R."""

    g: Fraction
    length: Fraction
    radius: Fraction

    def _pull(self, mp: Any) -> Any:
        # guard digits: 2 pi R - L may be small
        with mp.workdps(mp.dps + 40):
            return 2 * mp.mpf(self.g / self.length) * mp.sin(mp.mpf(self.length / (2 * self.radius)))

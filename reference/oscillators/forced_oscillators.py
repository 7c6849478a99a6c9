"""Linear motion of one coordinate under a load: x'' + 2b x' + c x = h + e^(rt) (C cos pt + S sin pt).

One matrix exponential covers all damping regimes and all resonances.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar

import flint
import numpy as np
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.linear import LinearMotion, Row
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.pointwise import Floats


@dataclass(frozen=True)
class ForcedLinear(LinearMotion):
    """State (x, v)."""

    damping: Fraction
    stiffness: Fraction
    constant: Fraction
    cosine: Fraction
    sine: Fraction
    frequency: Fraction
    growth: Fraction
    x: Fraction
    v: Fraction

    dimension: ClassVar[int] = 2

    def _system(self) -> tuple[Sequence[Row], Row]:
        p, r = self.frequency, self.growth
        rows = (
            (0, 1, 0, 0, 0),
            (-self.stiffness, -2 * self.damping, self.cosine, self.sine, self.constant),
            (0, 0, r, -p, 0),
            (0, 0, p, r, 0),
            (0, 0, 0, 0, 0),
        )
        return rows, (self.x, self.v, 1, 0, 1)

    def _rate(self) -> float:
        own = max(self.stiffness - self.damping**2, Fraction(0))
        return max(math.sqrt(own), abs(float(self.frequency)))

    def natural_rate(self, digits: int = 15) -> Any:
        """sqrt(c); c > 0."""
        return self._derived(digits, lambda: ball(self.stiffness).sqrt())

    def steady_amplitude(self, digits: int = 15) -> Any:
        """Amplitude of the steady response, hypot(C, S)/|c - p^2 + 2ibp|; r = 0, no exact resonance."""
        below = (self.stiffness - self.frequency**2) ** 2 + (2 * self.damping * self.frequency) ** 2
        return self._derived(digits, lambda: ball((self.cosine**2 + self.sine**2) / below).sqrt())

    def magnification(self, digits: int = 15) -> Any:
        """Steady amplitude over the static deflection under the same load."""
        below = (self.stiffness - self.frequency**2) ** 2 + (2 * self.damping * self.frequency) ** 2
        return self._derived(digits, lambda: ball(self.stiffness) / ball(below).sqrt())

    def unbalance_ratio(self, digits: int = 15) -> Any:
        """The magnification times p^2/c, for loads in proportion to p^2: an unbalance, or a vibrating base."""
        below = (self.stiffness - self.frequency**2) ** 2 + (2 * self.damping * self.frequency) ** 2
        return self._derived(digits, lambda: ball(self.frequency**2) / ball(below).sqrt())

    def phase_lag(self, digits: int = 15) -> Any:
        """Phase lag of the steady response behind the load (rad), in [0, pi]."""
        real, imaginary = self.stiffness - self.frequency**2, 2 * self.damping * self.frequency
        return self._derived(digits, lambda: flint.arb.atan2(ball(imaginary), ball(real)))

    def transmissibility(self, digits: int = 15) -> Any:
        """Steady force on the foundation over the load; also the amplitude ratio of mass and vibrating base."""
        passed = self.stiffness**2 + (2 * self.damping * self.frequency) ** 2
        below = (self.stiffness - self.frequency**2) ** 2 + (2 * self.damping * self.frequency) ** 2
        return self._derived(digits, lambda: ball(passed / below).sqrt())


@dataclass(frozen=True)
class SwitchedOff(BallMotion):
    """State (x, v) of a motion whose forces all end at the time `off` (s): afterwards it is uniform."""

    driven: ForcedLinear
    off: Fraction

    def _balls(self, t: Fraction) -> Sequence[Any]:
        return self.driven._balls(t) if t < self.off else Coasting(self)._balls(t)

    def sample(self, times: Floats, span: float | None = None, breaks: Sequence[Any] = ()) -> Floats:
        """Each part has a table of its own; the state at `off` belongs to the second."""
        times = np.asarray(times, dtype=np.float64)
        nearest = float(self.off)
        past = times >= nearest if Fraction(nearest) >= self.off else times > nearest
        values = np.empty((len(times), 2))
        for part, motion in ((~past, self.driven), (past, Coasting(self))):
            if np.any(part):
                values[part] = motion.sample(times[part])
        return values

    def off_time(self, digits: int = 15) -> Any:
        return self._rational(digits, self.off)

    def impulse(self, mass: Fraction, digits: int = 15) -> Any:
        """Impulse of the force until `off`: the change of momentum."""
        return self._derived(digits, lambda: ball(mass) * (self.driven._balls(self.off)[1] - ball(self.driven.v)))


@dataclass(frozen=True)
class Coasting(BallMotion):
    """The uniform motion after `off`, extended to all times."""

    switched: SwitchedOff

    def _balls(self, t: Fraction) -> Sequence[Any]:
        off = self.switched.off
        x, v = self.switched.driven._balls(off)
        return x + v * ball(t - off), v

"""Base class of cases that move exactly like a pendulum: a chain in a tube, a pendulum on an accelerated support."""

from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.reference.pendulums.equivalent_pendulum import EquivalentPendulum
from gnomon.reference.pendulums.pendulum_simple import Pendulum


class EquivalentPendulumCase(Case):
    """A case that moves like a simple pendulum whose constants are irrational."""

    exact_motion: EquivalentPendulum
    default_span = Span(10.37, lambda motion: motion.pendulum().period(20))

    @property
    def time_scale(self) -> float:
        """1/W, W the frequency of small swings; in fast rotation the time of a radian."""
        return min(1 / float(self.exact_motion.frequency()), float(self.exact_motion.pendulum().period()) / tau)

    def scales(self) -> dict[str, float]:
        """In closed form if the span holds a period: close to the top the peaks are narrow."""
        scales = accuracy.grid_scales(self)
        pendulum = self.exact_motion.pendulum()
        if self.span >= pendulum.period() and pendulum.regime != Pendulum.REST:
            scales["angular velocity"] = float(pendulum.top_speed())
        return scales

    def derived(self, digits: int) -> dict[str, Any]:
        motion, pendulum = self.exact_motion, self.exact_motion.pendulum(digits + 60)
        return {
            "small_swing_frequency": motion.frequency(digits),
            "rest_angle": motion.rest_angle(digits),
            "modulus_squared": pendulum.modulus_squared(digits),
            "amplitude": pendulum.amplitude(digits),
            "turn_time" if pendulum.regime == Pendulum.ROTATION else "period": pendulum.period(digits),
        }

"""The simple pendulum."""

from __future__ import annotations

from functools import cached_property
from math import cos, pi, sin, sqrt, tau
from typing import Any, ClassVar

from gnomon.cases.core import accuracy
from gnomon.cases.core.case import Case, Invariant, Level, Variant, same
from gnomon.cases.core.forms import Separable, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.oscillators.duffing_unforced import DuffingUnforced
from gnomon.cases.oscillators.harmonic_oscillator import HarmonicOscillator
from gnomon.cases.pendulums.pendulum_simple_scene import SCENE
from gnomon.reference.numerics.precision import Number
from gnomon.reference.pendulums.pendulum_simple import Pendulum


def acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """theta'' = -(g/L) sin(theta)."""
    (theta,) = q
    g, length = parameters
    return (-(g / length) * sin(theta),)


def potential(t: Any, q: Values, parameters: Values) -> Values:
    (theta,) = q
    g, length = parameters
    return (-(g / length) * cos(theta),)


def energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over m L^2, zero at the rest position: omega^2/2 + 2 (g/L) sin^2(theta/2)."""
    theta, omega = state
    g, length = parameters
    return (omega * omega / 2 + 2 * (g / length) * sin(theta / 2) * sin(theta / 2),)


class PendulumSimple(Case):
    """A point mass on a rigid massless rod of length L under gravity g."""

    name = "pendulum_simple"
    title = "Simple pendulum, exact (Jacobi)"
    section = "7.10, 6.7.3, 6.10.1, 6.14.1"
    conventions = "theta from the downward vertical, rad, continuous (not wrapped)."
    state = (Coordinate("theta", "rad", "angle"), Coordinate("omega", "rad/s", "angular velocity"))
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("L", "m", 1, "length of the rod"),
    )
    default_state = (2, 0)
    domain = Domain(
        {
            "g": positive(),
            "L": positive(),
            "theta": Range(typical=(-7.0, 7.0)),
            "omega": Range(typical=(-8.0, 8.0)),
        }
    )
    variants = (
        Variant("rotation", "turns over the top: theta grows without bound", initial_state=("0.5", 7)),
        Variant(
            "separatrix",
            "exactly the energy at the top, which it reaches after infinite time; errors grow as e^(2 w t)",
            {"L": "9.81"},
            (0, 2),
        ),
        Variant(
            "near_separatrix_below",
            "1 - m = 1e-12: turns back 2e-6 rad before the top",
            {"L": "9.81"},
            (0, "1.999999999999"),
        ),
        Variant(
            "near_separatrix_above",
            "1 - m = -1e-12: passes the top slowly",
            {"L": "9.81"},
            (0, "2.000000000001"),
        ),
        Variant(
            "upright",
            "released at rest 1e-12 rad from the top: an exponential phase, 9 time scales for each 4 digits",
            initial_state=("3.141592653588793", 0),
        ),
        Variant("long_1e4", "10,000 periods: phase error"),
        Variant("long_1e6", "1,000,000 periods: phase error"),
        Variant("engines", "the parameters of engine tests: released at 2.5 rad, 10 periods", initial_state=("2.5", 0)),
        Variant(
            "speed",
            "the parameters of speed tests: released at 2.5 rad, 100.37 periods",
            {"g": 1, "L": 1},
            ("2.5", 0),
        ),
    )
    invariants: ClassVar = {"energy": Invariant(energy)}
    forms = (Separable(acceleration, potential),)
    scene = SCENE
    reversal = ("omega",)
    mirror = ("theta", "omega")

    _PERIODS: ClassVar = {
        "near_separatrix_below": "3.37",
        "near_separatrix_above": "3.37",
        "upright": "0.45",
        "long_1e4": "10000.37",
        "long_1e6": "1000019.37",
        "engines": "10",
        "speed": "100.37",
    }
    """Spans in periods, of variants without one of 10.37. Close to the top as long as binary64 can follow the motion."""

    @cached_property
    def _exact(self) -> Pendulum:
        g, length = self.parameter_values()
        theta, omega = self.initial_state
        return Pendulum(g, length, theta, omega)

    def motion(self) -> Pendulum:
        return self._exact

    @property
    def time_scale(self) -> float:
        """sqrt(L/g), the time of a small swing; in fast rotation the time of a radian."""
        g, length = map(float, self.parameter_values())
        return min(sqrt(length / g), float(self._exact.period()) / tau)

    def natural_span(self) -> Number:
        """10.37 periods; 9 sqrt(L/g) on the separatrix."""
        if self._exact.regime == Pendulum.SEPARATRIX:
            return 9 * self.time_scale
        return float(self._exact.period(20)) * float(self._PERIODS.get(self.variant or "", "10.37"))

    def scales(self) -> dict[str, float]:
        """In closed form if the span holds a period: close to the separatrix the peaks are narrow."""
        found = accuracy.grid_scales(self)
        motion = self._exact
        if self.span >= motion.period() and motion.regime != Pendulum.REST:
            found["angular velocity"] = float(motion.top_speed())
            found["angle"] = min(max(found["angle"], float(motion.amplitude())), pi)
        return found

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """Tensions of the rod over the mass (m/s^2) at the lowest and at the highest point reached, and others."""
        motion = self._exact
        found = {
            "small_swing_period": motion.small_swing_period(digits),
            "modulus_squared": motion.modulus_squared(digits),
            "one_minus_modulus_squared": motion.complement(digits),
            "amplitude": motion.amplitude(digits),
            "top_speed": motion.top_speed(digits),
            "energy": motion.energy(digits),
            "tension_lowest_point": motion.tension_lowest(digits),
            "tension_highest_point": motion.tension_highest(digits),
        }
        if motion.regime == Pendulum.ROTATION:
            found["turn_time"] = motion.period(digits)
        elif motion.regime != Pendulum.SEPARATRIX:
            found["period"] = motion.period(digits)
        return found

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The models with a linear and with a cubic restoring force; the cubic one only if its motion is bounded."""
        g, length = self.parameter_values()
        if self._exact.regime != Pendulum.LIBRATION or abs(self.initial_state[0]) > pi:
            return ()
        linear = HarmonicOscillator(initial_state=self.initial_state, span=self.span, m=length, k=g)
        levels = [Level(linear, same, "restoring force proportional to the angle")]
        alpha, beta = g / length, -g / (6 * length)
        numbers = {"alpha": alpha, "beta": beta} | dict(zip("xv", self.initial_state, strict=True))
        if DuffingUnforced.domain.admits(numbers):
            quartic = DuffingUnforced(initial_state=self.initial_state, span=self.span, alpha=alpha, beta=beta)
            levels.append(Level(quartic, same, "softening: the period grows with the amplitude squared"))
        return tuple(levels)

"""The simple pendulum."""

from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.cases.oscillators.duffing_unforced import DuffingUnforced
from gnomon.cases.oscillators.harmonic_oscillator import HarmonicOscillator
from gnomon.cases.scenes.pendulum import SCENE
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
    theta = Coordinate("rad", 2, typical(-7, 7))
    omega = Coordinate("rad/s", 0, typical(-8, 8))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    L = Parameter("m", 1, "length of the rod", positive())
    exact_motion = bind(Pendulum, length="L")
    default_span = Span(10.37, lambda motion: motion.period(20), otherwise=9)
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
            periods=3.37,
        ),
        Variant(
            "near_separatrix_above",
            "1 - m = -1e-12: passes the top slowly",
            {"L": "9.81"},
            (0, "2.000000000001"),
            periods=3.37,
        ),
        Variant(
            "upright",
            "released at rest 1e-12 rad from the top: an exponential phase, 9 time scales for each 4 digits",
            initial_state=("3.141592653588793", 0),
            periods=0.45,
        ),
        Variant("long_1e3", "1000 periods: phase error", periods=1000.37),
        Variant("long_1e4", "10,000 periods: phase error", periods=10000.37),
        Variant("long_1e6", "1,000,000 periods: phase error", periods=1000019.37),
        Variant(
            "engines",
            "the parameters of engine tests: released at 2.5 rad, 10 periods",
            initial_state=("2.5", 0),
            periods=10,
        ),
        Variant(
            "speed",
            "the parameters of speed tests: released at 2.5 rad, 100.37 periods",
            {"g": 1, "L": 1},
            ("2.5", 0),
            periods=100.37,
        ),
    )
    invariants = conserved(energy=energy)
    forms = (Separable(acceleration, potential),)
    scene = SCENE
    mirror = ("theta", "omega")

    @property
    def time_scale(self) -> float:
        """sqrt(L/g), the time of a small swing; in fast rotation the time of a radian."""
        return min(sqrt(float(self.L) / float(self.g)), float(self.exact_motion.period()) / tau)

    def scales(self) -> dict[str, float]:
        """In closed form if the span holds a period: close to the separatrix the peaks are narrow."""
        scales = accuracy.grid_scales(self)
        motion = self.exact_motion
        if self.span >= motion.period() and motion.regime != Pendulum.REST:
            scales["angular velocity"] = float(motion.top_speed())
            scales["angle"] = min(max(scales["angle"], float(motion.amplitude())), pi)
        return scales

    @property
    def quantity_names(self) -> tuple[str, ...]:
        """Tensions of the rod over the mass (m/s^2) at the lowest and at the highest point reached, and others."""
        motion = self.exact_motion
        period = () if motion.regime == Pendulum.SEPARATRIX else ("period",)
        return (
            *(
                "small_swing_period",
                "modulus_squared",
                "one_minus_modulus_squared=complement",
                "amplitude",
                "top_speed",
            ),
            *("energy", "tension_lowest_point=tension_lowest", "tension_highest_point=tension_highest"),
            *(("turn_time=period",) if motion.regime == Pendulum.ROTATION else period),
        )

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The models with a linear and with a cubic restoring force; the cubic one only if its motion is bounded."""
        g, length = self.parameter_values()
        if self.exact_motion.regime != Pendulum.LIBRATION or abs(self.theta) > pi:
            return ()
        levels = [self.level(HarmonicOscillator, "restoring force proportional to the angle", m=length, k=g)]
        alpha, beta = g / length, -g / (6 * length)
        numbers = {"alpha": alpha, "beta": beta} | dict(zip("xv", self.initial_state, strict=True))
        if DuffingUnforced.domain.admits(numbers):
            effect = "softening: the period grows with the amplitude squared"
            levels.append(self.level(DuffingUnforced, effect, alpha=alpha, beta=beta))
        return tuple(levels)

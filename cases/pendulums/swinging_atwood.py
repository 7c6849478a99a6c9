"""The swinging Atwood machine: a hanging mass pulls the string of a pendulum over a pulley."""

from gnomon.cases.core.case import Invariant
from gnomon.cases.declare import *
from gnomon.cases.scenes.rope import SWINGING


def swinging_atwood_equations(t: Any, state: Values, parameters: Values) -> Values:
    """The unit mass swings at (r, theta); the mass mu hangs."""
    r, theta, vr, w = state
    mu, g = parameters
    return vr, w, (r * w * w + g * (cos(theta) - mu)) / (1 + mu), -(2 * vr * w + g * sin(theta)) / r


def swinging_atwood_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the swinging mass."""
    r, theta, vr, w = state
    mu, g = parameters
    return ((1 + mu) * vr * vr / 2 + r * r * w * w / 2 + g * r * (mu - cos(theta)),)


def tufillaro_integral(t: Any, state: Values, parameters: Values) -> Values:
    """The second integral, constant only for mu = 3 (Tufillaro, J. Physique 46 (1985) 1495)."""
    r, theta, vr, w = state
    _mu, g = parameters
    half, c = sin(theta / 2), cos(theta / 2)
    return (r * r * w * (vr * c - r * w * half / 2) + g * r * r * half * c * c,)


class SwingingAtwood(IntegratedCase):
    name = "swinging_atwood"
    title = "Swinging Atwood machine (no closed form; certified Taylor)"
    section = "8.8-8.9"
    conventions = (
        "r from the pulley (a point) to the swinging mass, theta from the downward vertical; mu is the hanging mass "
        "over the swinging one. Integrable only at mu = 3."
    )
    r = Coordinate("m", 1, positive(1, 2))
    theta = Coordinate("rad", "1.5", typical(-1.5, 1.5))
    vr = Coordinate("m/s", 0, typical(-0.2, 0.2))
    w = Coordinate("rad/s", 0, typical(-1, 1))
    mu = Parameter("1", "2.5", "hanging mass over swinging mass", positive(1, 4))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 12))
    default_span = Span(14.3, "time scale")
    variants = (
        Variant("integrable", "mu = 3: a second integral exists", {"mu": 3}, (1, "1.5", 0, "0.5")),
        Variant(
            "near_pulley",
            "passes the pulley at a tenth of the initial distance: a sharp turn",
            {"mu": "2.5"},
            (1, "0.3", 0, "0.5"),
        ),
    )
    forms = (FirstOrder(swinging_atwood_equations),)
    scene = SWINGING
    reversal = ("vr", "w")

    @property
    def invariants(self) -> Mapping[str, Invariant]:  # type: ignore[override]
        """The energy; with mu = 3 a second one."""
        energy = conserved(energy=swinging_atwood_energy)
        return energy | conserved(tufillaro=tufillaro_integral) if self.mu == 3 else energy

    @property
    def time_scale(self) -> float:
        """A third of sqrt(r/g): the string becomes short during the motion."""
        return sqrt(float(self.r) / float(self.g)) / 3

    @property
    def fastest_time(self) -> float:
        """The time of a radian at r/sqrt(mu) from the pulley, which the mass passes if mu is large."""
        return self.time_scale / max(1.0, sqrt(float(self.mu)) / 2)

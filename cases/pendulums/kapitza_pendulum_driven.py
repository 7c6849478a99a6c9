"""Kapitza's pendulum: a pivot that vibrates fast holds a pendulum upright."""

from gnomon.cases.declare import *


def kapitza_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """Gravity in the frame of the pivot is g - a w^2 cos(w t)."""
    (theta,) = q
    length, g, a, w = parameters
    return (-((g - a * w * w * cos(w * t)) / length) * sin(theta),)


class KapitzaPendulumDriven(IntegratedCase):
    """A point mass on a rigid massless rod whose pivot vibrates along the vertical."""

    name = "kapitza_pendulum_driven"
    title = "Kapitza's pendulum on a vibrating pivot (no closed form; certified Taylor)"
    section = "7.10"
    conventions = (
        "[inferred] theta from the downward vertical, rad, continuous; the pivot is at the height a cos(w t). Kapitza "
        "(1951): upright is stable if a^2 w^2 > 2 g L, for a << L and w^2 >> g/L."
    )
    theta = Coordinate("rad", 3, typical(-3.2, 3.2))
    omega = Coordinate("rad/s", 0, typical(-1, 1))
    L = Parameter("m", 1, "length of the rod", positive(0.5, 2))
    g = Parameter("m/s^2", 1, "acceleration of gravity", positive(0.5, 2))
    a = Parameter("m", "0.1", "amplitude of the pivot", nonnegative(0, 0.1))
    w = Parameter("rad/s", 30, "frequency of the pivot", positive(5, 40))
    autonomous = False
    default_span = "10.3"
    variants = (
        Variant("faster", "w = 300: ten times faster, a tenth of the amplitude", {"a": "0.01", "w": 300}, span="2.93"),
        Variant("fastest", "w = 1000: a stroke of 1e-3 of the length or so", {"a": "0.003", "w": 1000}, span="0.93"),
        Variant("falls", "a w = 1.35 < sqrt 2: upright is unstable, it falls", {"a": "0.045"}),
        Variant("hanging", "swings about the lower equilibrium, stiffened by the vibration", initial_state=(1, 0)),
    )
    forms = (SecondOrder(kapitza_acceleration),)
    mirror = ("theta", "omega")

    @property
    def time_scale(self) -> float:
        """One radian of the slow swing about the lower equilibrium, or of the pivot if that is shorter."""
        return min(1 / sqrt(float(self._hanging())), 1 / float(self.w))

    def _hanging(self) -> Fraction:
        length, g, a, w = self.parameter_values()
        return g / length + (a * w / length) ** 2 / 2

    def derived(self, digits: int) -> dict[str, Any]:
        """Frequencies of small slow swings of the averaged pendulum (rad/s), hanging and, where it is stable, upright."""
        hanging = self._hanging()
        upright = hanging - 2 * self.g / self.L
        quantities: dict[str, Any] = {"averaged_hanging_frequency": lambda mp: mp.sqrt(mp.mpf(hanging))}
        if upright > 0:
            quantities["averaged_upright_frequency"] = lambda mp: mp.sqrt(mp.mpf(upright))
        return quantities

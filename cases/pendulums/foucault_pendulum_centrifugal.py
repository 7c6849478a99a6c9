"""Foucault's pendulum for small amplitudes with the centrifugal terms of the horizontal plane."""

from gnomon.cases.declare import *
from gnomon.cases.pendulums.foucault_pendulum_linear import FoucaultLinear, FoucaultPrecession, no_load
from gnomon.cases.scenes.point import free_point
from gnomon.reference.pendulums.foucault_pendulum_centrifugal import FoucaultCentrifugal


def centrifugal_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Spring, Coriolis and in-plane centrifugal forces."""
    x, y, vx, vy = state
    g, length, rate, lat = parameters
    stiffness, turn = g / length, rate * sin(lat)
    return vx, vy, 2 * turn * vy - (stiffness - rate * rate) * x, -2 * turn * vx - (stiffness - turn * turn) * y


def centrifugal_matrix(parameters: Values) -> Values:
    g, length, rate, lat = parameters
    stiffness, turn = g / length, rate * sin(lat)
    east, north = stiffness - rate * rate, stiffness - turn * turn
    return 0, 0, 1, 0, 0, 0, 0, 1, -east, 0, 0, 2 * turn, 0, -north, -2 * turn, 0


def centrifugal_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Jacobi's integral per unit mass."""
    x, y, vx, vy = state
    g, length, rate, lat = parameters
    stiffness, turn = g / length, rate * sin(lat)
    return ((vx * vx + vy * vy + (stiffness - rate * rate) * x * x + (stiffness - turn * turn) * y * y) / 2,)


SCENE = free_point(centrifugal_equations, (0, 1))


class FoucaultInPlaneCentrifugal(Case):
    name = "foucault_pendulum_centrifugal"
    title = "Foucault pendulum, small amplitudes, with the centrifugal terms of the horizontal plane"
    section = "6.17.2-6.17.4"
    conventions = (
        "As foucault_pendulum_linear, with the terms Om^2 x east and Om^2 sin^2(lat) y north; g is the apparent gravity at "
        "the point of rest. Except at the poles the two axes differ."
    )
    x = Coordinate("m", 3)
    y = Coordinate("m", 0)
    vx = Coordinate("m/s", 0)
    vy = Coordinate("m/s", 0)
    g = Parameter("m/s^2", "9.81", "apparent gravity", positive(5, 15))
    L = Parameter("m", 67, "length of the pendulum", positive(0.5, 100))
    Om = Parameter("rad/s", "7.292115e-5", "rate of rotation of the Earth", typical(-0.2, 0.2))
    lat = Parameter("rad", "0.8526", "latitude", Range(-pi / 2, pi / 2, typical=(-1.5, 1.5)))
    rules = (Rule("the pendulum is bound (Om^2 < g/L)", lambda n: n["Om"] ** 2 * n["L"] < n["g"]),)
    exact_motion = bind(FoucaultCentrifugal, start="x y vx vy")
    default_span = 3600
    variants = (
        Variant("day", "24 h: the axes differ by 1e-8 of the stiffness, whose effect accumulates", span=86400),
        Variant("equator", "no precession, two frequencies", {"lat": 0}, (2, 2, 0, 0)),
        Variant(
            "turntable",
            "a fast turntable at mid latitude: strongly anisotropic",
            {"L": 1, "Om": 2},
            ("0.1", 0, 0, 0),
            span=31,
        ),
    )
    invariants = conserved(energy=centrifugal_energy)
    forms = (SemiLinear(centrifugal_equations, linear=centrifugal_matrix, rest=no_load),)
    scene = SCENE
    reversal = ("vx", "vy", "Om")

    @property
    def time_scale(self) -> float:
        """One radian of a swing."""
        return 1 / (sqrt(float(self.g) / float(self.L)) + abs(float(self.Om)))

    def derived(self, digits: int) -> dict[str, Any]:
        """Rate of the plane of swing (rad/s), and the difference of stiffness of north and east over the stiffness."""
        return {
            "precession_rate": lambda mp: -mp.mpf(self.Om) * mp.sin(mp.mpf(self.lat)),
            "anisotropy": lambda mp: (
                (mp.mpf(self.Om) * mp.cos(mp.mpf(self.lat))) ** 2 * mp.mpf(self.L) / mp.mpf(self.g)
            ),
            "swing_period": lambda mp: 2 * mp.pi * mp.sqrt(mp.mpf(self.L / self.g)),
        }

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        return (
            self.level(FoucaultPrecession, "a fixed plane", Om=0),
            self.level(FoucaultPrecession, "the plane turns at -Om sin(lat)"),
            self.level(FoucaultLinear, "Coriolis force in full"),
        )

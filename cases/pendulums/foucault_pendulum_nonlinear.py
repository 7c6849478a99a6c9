"""Foucault's pendulum at any amplitude: a spherical pendulum with the Coriolis force."""

import math

import numpy as np
from gnomon.cases.declare import *
from gnomon.cases.pendulums.foucault_pendulum_linear import FoucaultLinear, FoucaultPrecession


def foucault_sphere(t: Any, state: Values, parameters: Values) -> Values:
    """e'' = f + lam e, f = (0, 0, -g/L) - 2 Om x e', with lam such that e.e' stays constant."""
    ex, ey, ez, vx, vy, vz = state
    g, length, rate, lat = parameters
    oy, oz = rate * cos(lat), rate * sin(lat)
    fx, fy, fz = 2 * (oz * vy - oy * vz), -2 * oz * vx, 2 * oy * vx - g / length
    lam = -(vx * vx + vy * vy + vz * vz + ex * fx + ey * fy + ez * fz) / (ex * ex + ey * ey + ez * ez)
    return vx, vy, vz, fx + lam * ex, fy + lam * ey, fz + lam * ez


def sphere_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over m L^2."""
    _ex, _ey, ez, vx, vy, vz = state
    g, length, _rate, _lat = parameters
    return ((vx * vx + vy * vy + vz * vz) / 2 + g / length * ez,)


def squared_radius(t: Any, state: Values, parameters: Values) -> Values:
    ex, ey, ez, _vx, _vy, _vz = state
    return (ex * ex + ey * ey + ez * ez,)


def radial_rate(t: Any, state: Values, parameters: Values) -> Values:
    """e.e', zero on the sphere."""
    ex, ey, ez, vx, vy, vz = state
    return (ex * vx + ey * vy + ez * vz,)


def bob_scene(state: Values, parameters: Values) -> Scene:
    """A point mass on a ball joint at the origin, with the Coriolis force."""
    ex, ey, ez, vx, vy, vz = state
    g, length, rate, lat = parameters

    def coriolis(t: float, position: Vector, velocity: Vector) -> Vector:
        oy, oz = rate * cos(lat), rate * sin(lat)
        ux, uy, uz = velocity
        return 2 * (oz * uy - oy * uz), -2 * oz * ux, 2 * oy * ux

    place, speed = (length * ex, length * ey, length * ez), (length * vx, length * vy, length * vz)
    bob = Body("bob", 1.0, (0.0, 0.0, 0.0), place, velocity=speed)
    return Scene((0.0, 0.0, -g), (bob,), forces=(Force("bob", "velocity_force", coriolis),))


def bob_reading(readings: Readings, parameters: Values) -> Values:
    position, _, velocity, _ = readings.bodies["bob"]
    return tuple(x / parameters[1] for x in (*position, *velocity))


SCENE = SceneForm(bob_scene, bob_reading, frozenset({"ball_joint", "velocity_force"}), conservative=False)
POLE = math.nextafter(math.pi / 2, 2)
"""The double just above pi/2, so that pi/2 to more digits is admitted."""


OFF_THE_SPHERE = Fraction(1, 10**6)
"""Of e.e and of the radian of a swing: roundings of a start on the sphere are less."""


def _along_the_sphere(n: Mapping[str, Fraction]) -> bool:
    square, speed, radial = (
        sum((n[a + i] * n[b + i] for i in "xyz"), Fraction(0)) for a, b in (("e", "e"), ("v", "v"), ("e", "v"))
    )
    return radial**2 <= OFF_THE_SPHERE**2 * square * (speed + square * n["g"] / n["L"])


class FoucaultNonlinear(IntegratedCase):
    name = "foucault_pendulum_nonlinear"
    title = "Foucault pendulum at any amplitude, with the Coriolis force at a latitude (certified Taylor)"
    section = "6.17.1"
    conventions = (
        "e is the direction of the bob from its support: x east, y north, z up; g includes the centrifugal acceleration. "
        "The multiplier is divided by e.e, so that a start rounded off the unit sphere keeps its |e|; starts have e.e' = 0."
    )
    ex = Coordinate("1", "0.28", typical(0.3, 1))
    ey = Coordinate("1", 0, typical(-1, 1))
    ez = Coordinate("1", "-0.96", typical(-1, -0.5))
    vx = Coordinate("1/s", 0, typical(0, 0))
    vy = Coordinate("1/s", 0, typical(0, 0))
    vz = Coordinate("1/s", 0, typical(0, 0))
    g = Parameter("m/s^2", "9.81", "apparent gravity", positive(5, 15))
    L = Parameter("m", 67, "length of the pendulum", positive(0.5, 5))
    Om = Parameter("rad/s", "7.292115e-5", "rate of rotation of the Earth", typical(-1, 1))
    lat = Parameter("rad", "0.8526", "latitude", Range(-POLE, POLE, typical=(-1.5, 1.5)))
    rules = (
        Rule("e is not zero", lambda n: any(n[f"e{axis}"] != 0 for axis in "xyz")),
        Rule("the bob moves along its sphere: |e.e'| <= 1e-6 |e| sqrt(e'.e' + (g/L) e.e)", _along_the_sphere),
    )
    longest = 700
    variants = (
        Variant(
            "wide", "swings of 74 degrees: small-angle formulas do not hold", {"L": 1}, ("0.96", 0, "-0.28", 0, 0, 0)
        ),
        Variant(
            "ellipse",
            "a wide ellipse whose own precession is opposite to that due to the Earth's rotation",
            {"L": 1},
            ("0.28", 0, "-0.96", 0, "0.4", 0),
            "4.9",
        ),
        Variant("turntable", "rotates as fast as the pendulum swings", {"L": 1, "Om": 3}, span="3.7"),
        Variant("equator", "only the vertical Coriolis force is left", {"L": 1, "lat": 0}, span="3.3"),
        Variant(
            "pole",
            "at the pole: the height is an elliptic function, the plane turns at the full rate of the planet",
            {"L": 1, "Om": "0.5", "lat": math.pi / 2},
            span="5.3",
        ),
        Variant("above", "released above its support: the rod pushes", {"L": 1}, ("0.96", 0, "0.28", 0, 0, 0), "3.1"),
    )
    invariants = conserved(energy=sphere_energy, squared_radius=squared_radius, radial_rate=radial_rate)
    forms = (FirstOrder(foucault_sphere),)
    scene = SCENE
    reversal = ("vx", "vy", "vz", "Om")

    @property
    def time_scale(self) -> float:
        """sqrt(L/g), or one radian of the frame where that is shorter."""
        g, length, rate, _lat = map(float, self.parameter_values())
        return min(math.sqrt(length / g), 1 / abs(2 * rate) if rate else math.inf)

    def natural_span(self) -> Number:
        """3.37 small swings: the integration is expensive."""
        g, length, *_ = map(float, self.parameter_values())
        return 3.37 * 2 * math.pi * math.sqrt(length / g)

    def derived(self, digits: int) -> dict[str, Any]:
        """Of small swings: the period (s), the rate of the plane and the ellipse's own precession 3/8 ab sqrt(g/L) (rad/s)."""
        return {
            "small_swing_period": lambda mp: 2 * mp.pi / mp.sqrt(mp.mpf(self.g) / mp.mpf(self.L)),
            "precession_rate": lambda mp: -mp.mpf(self.Om) * mp.sin(mp.mpf(self.lat)),
            "apsidal_rate": 3 * (self.ex * self.vy - self.ey * self.vx) / 8,
        }

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """Models in the horizontal plane, their states projected onto the sphere; only for swings below the support."""
        ex, ey, ez, vx, vy, _vz = self.initial_state
        if ez >= 0:
            return ()
        length = self.L
        start = [length * value for value in (ex, ey, vx, vy)]
        plane: dict[str, Any] = {"initial_state": start, "span": self.span, **self.parameters}
        size = float(length)

        def lifted(states: Floats) -> Floats:
            x, y, u, w = (states[:, i] / size for i in range(4))
            height = -np.sqrt(np.maximum(1 - x * x - y * y, 1e-12))
            return np.stack([x, y, height, u, w, -(x * u + y * w) / height], axis=1)

        return (
            Level(FoucaultPrecession(**plane), lifted, "small swings, with precession only"),
            Level(FoucaultLinear(**plane), lifted, "small swings, with the full Coriolis force"),
        )

"""Foucault's pendulum for small amplitudes, and a model with precession as the only effect of rotation.

Cases: foucault_pendulum_linear, foucault_precession.
"""

from typing import ClassVar

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import free_point
from gnomon.reference.pendulums.foucault_pendulum_linear import Foucault

TURN = 2 * pi


def foucault_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Spring and Coriolis forces in the horizontal plane."""
    x, y, vx, vy = state
    g, length, rate, lat = parameters
    stiffness = g / length
    twice = 2 * rate * sin(lat)
    return vx, vy, twice * vy - stiffness * x, -twice * vx - stiffness * y


def precession_equations(t: Any, state: Values, parameters: Values) -> Values:
    """The same with an added term, with which precession of the plane is the only effect of rotation."""
    x, y, vx, vy = state
    g, length, rate, lat = parameters
    turn = rate * sin(lat)
    stiffness = g / length - turn * turn
    return vx, vy, 2 * turn * vy - stiffness * x, -2 * turn * vx - stiffness * y


def foucault_matrix(parameters: Values) -> Values:
    g, length, rate, lat = parameters
    stiffness, twice = g / length, 2 * rate * sin(lat)
    return 0, 0, 1, 0, 0, 0, 0, 1, -stiffness, 0, 0, twice, 0, -stiffness, -twice, 0


def precession_matrix(parameters: Values) -> Values:
    g, length, rate, lat = parameters
    turn = rate * sin(lat)
    stiffness = g / length - turn * turn
    return 0, 0, 1, 0, 0, 0, 0, 1, -stiffness, 0, 0, 2 * turn, 0, -stiffness, -2 * turn, 0


def no_load(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0, 0, 0


def foucault_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy per unit mass: the Coriolis force does no work."""
    x, y, vx, vy = state
    g, length, _rate, _lat = parameters
    return ((vx * vx + vy * vy + g / length * (x * x + y * y)) / 2,)


def precession_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    g, length, rate, lat = parameters
    turn = rate * sin(lat)
    return ((vx * vx + vy * vy + (g / length - turn * turn) * (x * x + y * y)) / 2,)


def foucault_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum per unit mass about the vertical in the inertial frame."""
    x, y, vx, vy = state
    _g, _length, rate, lat = parameters
    return (x * vy - y * vx + rate * sin(lat) * (x * x + y * y),)


PRECESSION_SCENE = free_point(precession_equations, (0, 1))


def foucault_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """A free point mass in the horizontal plane; one force holds the attraction to the centre and the Coriolis force."""
    x, y, vx, vy = state
    g, length, turning, latitude = parameters

    def pull_and_coriolis(t: float, position: Vector, velocity: Vector) -> Vector:
        stiffness, spin = g / length, turning * sin(latitude)
        return -stiffness * position[0] + 2 * spin * velocity[1], -stiffness * position[1] - 2 * spin * velocity[0], 0.0

    bob = Body("bob", 1.0, (0.0, 0.0, 0.0), (x, y, 0.0), velocity=(vx, vy, 0.0))
    return Scene((0.0, 0.0, 0.0), (bob,), forces=(Force("bob", "velocity_force", pull_and_coriolis),))


SCENE = SceneForm(foucault_scene, free_body("bob", 0, 1), frozenset({"velocity_force"}), conservative=False)
"""Not conservative: the Coriolis force depends on the velocity."""


class FoucaultLinear(Case):
    name = "foucault_pendulum_linear"
    title = "Foucault pendulum, small amplitudes"
    section = "6.17.2-6.17.4"
    conventions = (
        "x east, y north; centrifugal terms are absorbed in g; for lat > 0 the plane of swing turns clockwise."
    )
    x = Coordinate("m", 3)
    y = Coordinate("m", 0)
    vx = Coordinate("m/s", 0)
    vy = Coordinate("m/s", 0)
    g = Parameter("m/s^2", "9.81", "apparent gravity", positive(5, 15))
    L = Parameter("m", 67, "length of the pendulum", positive(0.5, 100))
    Om = Parameter("rad/s", "7.292115e-5", "rate of rotation of the Earth", typical(-1, 1))
    lat = Parameter("rad", "0.8526", "latitude", Range(-pi / 2, pi / 2, typical=(-1.5, 1.5)))
    exact_motion = bind(Foucault)
    quantity_names = ("precession_rate", "swing_period", "closest")
    turning = Turning((("x", "y"), ("vx", "vy")))
    default_span = 3600
    variants: ClassVar[tuple[Variant, ...]] = (
        Variant("day", "24 h: the drift of the plane over 5e3 swings", span=86400),
        Variant(
            "two_days", "48 h on 1 m: the drift of the plane over 9e4 swings", {"L": 1}, ("0.1", 0, 0, 0), span=172800
        ),
        Variant("equator", "no precession: the other component stays exactly zero", {"lat": 0}),
        Variant(
            "turntable",
            "a fast turntable: the frame rotates six times faster than the pendulum swings",
            {"L": 1, "Om": 20, "lat": 1.5707963267948966},
            ("0.1", 0, 0, 0),
            span=21,
        ),
    )
    invariants = conserved(energy=foucault_energy, angular_momentum=foucault_momentum)
    forms = (SemiLinear(foucault_equations, linear=foucault_matrix, rest=no_load),)
    scene = SCENE
    reversal = ("vx", "vy", "Om")
    mirror = ("x", "y", "vx", "vy")

    @property
    def time_scale(self) -> float:
        """One radian of the faster of the two circular motions."""
        return 1 / max(abs(float(rate)) for rate in self.exact_motion.circles()[2:])

    def scales(self) -> dict[str, float]:
        """The sums of the radii and of the speeds of the two circular motions, which are reached within half a swing."""
        motion = self.exact_motion
        if float(self.times[-1]) < float(motion.swing_period()) / 2:
            return super().scales()
        p, q, faster, slower = (abs(float(value)) for value in motion.circles())
        sizes = {"length": p + q, "velocity": p * faster + q * slower}
        return {name: size if size > 0 else 1.0 for name, size in sizes.items()}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        return (
            self.level(FoucaultPrecession, "swings in a fixed plane", Om=0),
            self.level(FoucaultPrecession, "the plane turns at -Om sin(lat)"),
        )


class FoucaultPrecession(FoucaultLinear):
    name = "foucault_precession"
    title = "Foucault pendulum, precession only"
    conventions = "As foucault_pendulum_linear, with a term Om^2 sin^2(lat) r: the swing is as on an Earth at rest."
    exact_motion = bind(lambda c: Foucault(**c.numbers, larmor=True))
    variants = ()
    invariants = conserved(energy=precession_energy, angular_momentum=foucault_momentum)
    forms = (SemiLinear(precession_equations, linear=precession_matrix, rest=no_load),)
    scene = PRECESSION_SCENE
    hierarchy = ()

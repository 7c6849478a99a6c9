"""The spherical pendulum in angles. With phi -> phi - Om t it is also the nonlinear Foucault pendulum at the pole."""

from collections.abc import Sequence

import mpmath
import numpy as np
from gnomon.cases.declare import *
from gnomon.cases.orbits.central_force import CentralForceConservation
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.cases.pendulums.spherical_cartesian import CARTESIAN, from_the_sphere, on_the_sphere
from gnomon.reference.rigid_bodies.lagrange_top import SphericalPendulum


def spherical_equations(t: Any, state: Values, parameters: Values) -> Values:
    theta, omega, _phi = state
    g, length, h = parameters
    s = sin(theta)
    return omega, h * h * cos(theta) / (s * s * s) - g / length * s, h / (s * s)


def flat_start(state: Sequence[Fraction], parameters: Sequence[Fraction]) -> tuple[float, ...]:
    """Horizontal position and velocity."""
    theta, omega, phi = map(float, state)
    _g, length, h = map(float, parameters)
    c, s, outward, around = cos(phi), sin(phi), length * cos(theta) * omega, length * h / sin(theta)
    r = length * sin(theta)
    return r * c, r * s, outward * c - around * s, outward * s + around * c


def spherical_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over m L^2, zero at the lowest point."""
    theta, omega, _phi = state
    g, length, h = parameters
    s, half = sin(theta), sin(theta / 2)
    return (omega * omega / 2 + h * h / (2 * s * s) + 2 * g / length * half * half,)


def ball_joint_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """A point mass on a ball joint at the origin; at the lowest point, where the azimuth is not defined, it starts at rest."""
    g, length, _h = parameters
    placed = on_the_sphere(mpmath.fp, state, parameters) if sin(state[0]) else (0.0, 0.0, -length, 0.0, 0.0, 0.0)
    x, y, z, vx, vy, vz = map(float, placed)
    bob = Body("bob", 1.0, (0.0, 0.0, 0.0), (x, y, z), velocity=(vx, vy, vz))
    return Scene((0.0, 0.0, -g), (bob,))


def ball_joint_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    position, _, velocity, _ = readings.bodies["bob"]
    return tuple(map(float, from_the_sphere(np.array([*position, *velocity]), parameters)))


SCENE = SceneForm(ball_joint_scene, ball_joint_reading, frozenset({"ball_joint"}), conservative=False)


class SphericalPendulumCase(Case):
    name = "spherical_pendulum"
    title = "Spherical pendulum"
    section = "6.17, 11.10"
    conventions = "theta from the downward vertical; h = sin^2(theta) phi' is constant and not zero; phi continuous."
    theta = Coordinate("rad", 1, Range(0.0, pi, low_open=True, typical=(0.1, 3.0)), group="tilt")
    omega = Coordinate("rad/s", 0, typical(-5, 5))
    phi = Coordinate("rad", 0, group="azimuth")
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    L = Parameter("m", 1, "length of the rod", positive())
    h = Parameter("1/s", "0.5", "sin^2(theta) phi', momentum about the vertical over m L^2", typical(-5, 5))
    rules = (Rule("h is not 0 (a plane swing is the case pendulum_simple)", lambda n: n["h"] != 0),)
    exact_motion = bind(SphericalPendulum)
    default_span = Span(10.37, lambda motion: motion.nutation_period(20) or 1)
    quantity_names = ("polar_period=nutation_period", "azimuth_advance=precession_per_nutation")
    """`azimuth_advance`: the growth of phi in a polar period (rad); pi in the limit of a thin ellipse."""
    variants = (
        Variant(
            "near_pole",
            "h = 1e-6: passes 3e-7 rad from the lowest point, where phi changes fast by pi",
            {"h": "1e-6"},
            periods=3.37,
        ),
        Variant("over_the_top", "passes close to both poles", {"h": "0.01"}, (1, 7, 0)),
        Variant("conical", "a circle up to 1e-6: two roots nearly coincide", {"h": "3.01713"}),
        Variant("thin_ellipse", "amplitude 0.01: precesses by (3/8)(ab/L^2) per radian", {"h": "1e-5"}, ("0.01", 0, 0)),
        Variant("upper_half", "starts above the point of suspension", {"h": 1}, ("2.5", 1, 0)),
        Variant("long_1e3", "1000 polar periods: phase error", periods=1000.37),
        Variant("long_1e4", "10,000 polar periods: phase error", periods=10000.37),
    )
    invariants = conserved(energy=spherical_energy)
    forms = (FirstOrder(spherical_equations),)
    scene = SCENE
    reversal = ("omega", "h")
    formulations = (CARTESIAN,)

    @property
    def time_scale(self) -> float:
        """The time of a small swing, or of a radian of the azimuth where that is fastest, close to a pole."""
        g, length, h = map(float, self.parameter_values())
        low, high = self.exact_motion.heights(30) or (0, 0)
        nearest = min(float((1 - low) * (1 + low)), float((1 - high) * (1 + high)))
        return 1 / max(sqrt(g / length), abs(h) / nearest)

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """Two horizontal oscillators, then the plane swing without h; only for starts below the height of the support."""
        g, length, _h = self.parameter_values()
        theta, omega, phi = self.initial_state
        if float(theta) >= pi / 2:
            return ()
        flat = CentralForceConservation(
            initial_state=flat_start(self.initial_state, self.parameter_values()), span=self.span, m=length, k=g
        )
        plane = PendulumSimple(initial_state=(theta, omega), span=self.span, g=g, L=length)

        def from_above(states: Floats) -> Floats:
            x, y, vx, vy = states.T
            r = np.hypot(x, y)
            sine = np.clip(r / float(length), 0.0, 1.0)
            rate = (x * vx + y * vy) / r / float(length) / np.sqrt(np.maximum(1 - sine * sine, 1e-9))
            return np.stack([np.arcsin(sine), rate, np.arctan2(y, x)], axis=-1)

        def in_the_plane(states: Floats) -> Floats:
            angle, rate = states.T
            side = np.where(np.remainder(angle, 2 * pi) <= pi, 1.0, -1.0)
            tilt = np.abs(np.remainder(angle + pi, 2 * pi) - pi)
            azimuth = float(phi) + np.where(side > 0, 0.0, pi)
            return np.stack([tilt, side * rate, azimuth], axis=-1)

        return (
            Level(flat, from_above, "small swings: an ellipse without precession"),
            Level(plane, in_the_plane, "swings of any amplitude, in a plane"),
        )

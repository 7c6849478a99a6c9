"""theta'' = -A sin(theta) + B sin(theta) cos(theta): a body that hangs from a turning axis.

Cases: rotating_pendulum, bearing_reaction_torque_stability. The gyrocompass (cases/rigid_bodies/gyrocompass.py)
has such an equation too.
"""

import numpy as np
from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.cases.scenes.hinge import hinged_pull
from gnomon.cases.scenes.hoop import SCENE
from gnomon.reference.guided.pendulum_on_hoop import Hoop


def hoop_acceleration(theta: Any, pull: Any, lift: Any) -> Values:
    return (lift * sin(theta) * cos(theta) - pull * sin(theta),)


def hoop_potential(theta: Any, pull: Any, lift: Any) -> Values:
    """Zero at theta = 0, so without the cancellation of -A cos(theta) there."""
    half = sin(theta / 2)
    return (2 * pull * half * half - lift * sin(theta) * sin(theta) / 2,)


def bead_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    g, radius, rate = parameters
    return hoop_acceleration(q[0], g / radius, rate * rate)


def bead_potential(t: Any, q: Values, parameters: Values) -> Values:
    g, radius, rate = parameters
    return hoop_potential(q[0], g / radius, rate * rate)


def bead_jacobi(t: Any, state: Values, parameters: Values) -> Values:
    """Jacobi's integral over m R^2; the energy is not constant, because the drive does work."""
    return (state[1] * state[1] / 2 + bead_potential(t, state[:1], parameters)[0],)


def hinged_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    moment, ia, ib, ic, rate = parameters
    return hoop_acceleration(q[0], moment / ia, rate * rate * (ib - ic) / ia)


def hinged_potential(t: Any, q: Values, parameters: Values) -> Values:
    moment, ia, ib, ic, rate = parameters
    return hoop_potential(q[0], moment / ia, rate * rate * (ib - ic) / ia)


def hinged_jacobi(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] * state[1] / 2 + hinged_potential(t, state[:1], parameters)[0],)


HINGED_SCENE = hinged_pull(hinged_acceleration)


class HoopCase(Case):
    """Base class of the cases in this family; a subclass states A and B as functions of its parameters."""

    default_span = Span(10.37, lambda motion: motion.period(20), otherwise=9)

    def coefficients(self) -> tuple[Fraction, Fraction]:
        """A and B (1/s^2)."""
        raise NotImplementedError

    exact_motion = bind(lambda c: Hoop(*c.coefficients(), *c.initial_state))

    @property
    def time_scale(self) -> float:
        """The shortest time of a small swing, with rotation or without, or of a radian of a motion over the top."""
        pull, lift = map(abs, self.coefficients())
        rate = sqrt(pull + lift)
        if self.exact_motion.regime == Hoop.ROTATION:
            rate = max(rate, tau / float(self.exact_motion.period()))
        return 1 / rate if rate else 1.0

    def scales(self) -> dict[str, float]:
        """Close to a homoclinic motion the peaks are narrower than the grid spacing; they are at quarters of the period."""
        scales = accuracy.grid_scales(self)
        period = self.exact_motion.period()
        if period is not None and 60 * self.time_scale < float(period) < float(self.span):
            around = self.time_scale * np.linspace(-10, 10, 101)
            near = self.sample(np.concatenate([float(period) * k / 4 + around for k in (1, 2, 3, 4)]))
            angle, speed = np.max(np.abs(near), axis=0).tolist()
            scales = {
                "angle": min(max(scales["angle"], angle), pi),
                "angular velocity": max(scales["angular velocity"], speed),
            }
        return scales

    @property
    def quantity_names(self) -> tuple[str, ...]:
        period = "turn_time=period" if self.exact_motion.regime == Hoop.ROTATION else "period"
        return ("energy", period, "tilted_equilibrium", "small_frequency")


class RotatingPendulum(HoopCase):
    name = "rotating_pendulum"
    title = "Bead on a hoop, or pendulum in a plane, rotating at constant rate about the vertical"
    section = "11.12.2, 6.9, 6.14, 10.12.5"
    conventions = "theta from the downward vertical, rad, not wrapped; Om is prescribed."
    theta = Coordinate("rad", "0.5", typical(-7, 7))
    omega = Coordinate("rad/s", 0, typical(-8, 8))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    R = Parameter("m", 1, "radius of the hoop", positive())
    Om = Parameter("rad/s", 4, "rate of the hoop", typical(-5, 5))
    variants = (
        Variant("rotation", "turns over the top", initial_state=("0.5", 10)),
        Variant(
            "bifurcation",
            "exactly Om^2 = g/R: no linear force, the period grows as 1/amplitude",
            {"g": 9, "Om": 3},
            ("0.001", 0),
        ),
        Variant(
            "above_bifurcation",
            "Om^2 1e-6 above g/R: equilibrium tilted by 1.4e-3, a slow swing",
            {"g": 9, "Om": "3.0000015"},
            ("0.0018", 0),
        ),
        Variant(
            "homoclinic_inside",
            "released at the double below 2 pi/3: approaches the unstable bottom slowly",
            {"g": 1, "Om": 2},
            (2.0943951023931953, 0),
            periods=0.45,
        ),
        Variant(
            "homoclinic_outside",
            "released at the double above 2 pi/3: approaches the unstable bottom slowly, outside the separatrix",
            {"g": 1, "Om": 2},
            (2.0943951023931957, 0),
            periods=0.22,
        ),
        Variant("near_homoclinic", "1e-12 rad from the unstable bottom", {"g": 1, "Om": 2}, ("1e-12", 0), periods=2.37),
        Variant(
            "separatrix",
            "exactly the energy at the top, which it reaches after infinite time",
            {"g": 1, "Om": "0.5"},
            (0, 2),
        ),
        Variant("tilted", "small swings about the tilted equilibrium", initial_state=("0.911", 0)),
        Variant("long_1e4", "10,000 periods: phase error", periods=10000.37),
        Variant("without_rotation", "Om = 0: the simple pendulum", {"Om": 0}, (2, 0)),
        Variant("engines", "the parameters of engine tests, 5 s", initial_state=("0.3", 0), span=5),
    )
    invariants = conserved(jacobi=bead_jacobi)
    forms = (Separable(bead_acceleration, bead_potential),)
    scene = SCENE

    def coefficients(self) -> tuple[Fraction, Fraction]:
        g, radius, rate = self.parameter_values()
        return g / radius, rate * rate

    def derived(self, digits: int) -> dict[str, Any]:
        """`drive_torque` over the mass at the start: 2 R^2 Om sin(theta) cos(theta) theta' (m^2/s^2)."""
        size = self.R**2 * self.Om * self.omega
        return {"drive_torque": lambda mp: mp.mpf(size) * mp.sin(2 * mp.mpf(self.theta))}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        return (self.level(PendulumSimple, "no rotation: the simple pendulum", L=self.R),)


class BearingReactionTorqueStability(HoopCase):
    name = "bearing_reaction_torque_stability"
    title = "Plate or rod hinged to a rotating shaft: relative equilibria and their stability"
    section = "10.12.5"
    conventions = (
        "theta from the downward vertical, rad, not wrapped; axis a is the hinge, c along the body, b perpendicular to "
        "both; moments about the hinge; Om is prescribed. Rotation drives the body away from the shaft if I_b > I_c."
    )
    theta = Coordinate("rad", "0.4", typical(-7, 7))
    omega = Coordinate("rad/s", "0.5", typical(-8, 8))
    mgl = Parameter("N m", "4.905", "weight times distance of the centre of mass from the hinge", nonnegative())
    I_a = Parameter("kg m^2", "0.4", "moment about the hinge axis", positive(0.1, 2))
    I_b = Parameter("kg m^2", "0.35", "moment about the axis across the body", positive(0.1, 2))
    I_c = Parameter("kg m^2", "0.05", "moment about the long axis", positive(0.1, 2))
    Om = Parameter("rad/s", 6, "rate of the shaft", typical(-8, 8))
    variants = (
        Variant("flat", "I_b < I_c: rotation presses the body to the shaft", {"I_b": "0.05", "I_c": "0.35"}),
        Variant(
            "between",
            "I_b < I_c, fast: the upright position is stable too, and the motion stays around it",
            {"I_b": "0.05", "I_c": "0.35", "Om": 12},
            ("3.5", 0),
        ),
        Variant("no_moment", "I_b = I_c: rotation has no effect", {"I_b": "0.2", "I_c": "0.2"}),
        Variant("balanced", "hinged at the centre of mass: two wells half a turn apart", {"mgl": 0}, ("0.3", 0)),
        Variant("unstable", "1e-10 rad from the unstable bottom", initial_state=("1e-10", 0), periods=2.37),
    )
    invariants = conserved(jacobi=hinged_jacobi)
    forms = (Separable(hinged_acceleration, hinged_potential),)
    scene = HINGED_SCENE

    def coefficients(self) -> tuple[Fraction, Fraction]:
        moment, ia, ib, ic, rate = self.parameter_values()
        return moment / ia, rate * rate * (ib - ic) / ia

    def derived(self, digits: int) -> dict[str, Any]:
        """Torques at the start (N m): of the drive, 2 Om (I_b - I_c) sin(theta) cos(theta) theta', and, transverse to the

        shaft, on the bearings, Om theta' (I_a + (I_b - I_c) cos(2 theta)).
        """
        size, apart = self.Om * self.omega, self.I_b - self.I_c

        def bearing(mp: Any) -> Any:
            return mp.mpf(size) * (mp.mpf(self.I_a) + mp.mpf(apart) * mp.cos(2 * mp.mpf(self.theta)))

        return {
            "drive_torque": lambda mp: mp.mpf(size) * mp.mpf(apart) * mp.sin(2 * mp.mpf(self.theta)),
            "bearing_torque": bearing,
        }

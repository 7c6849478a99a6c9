"""Huygens' isochronous pendulum."""

from collections.abc import Sequence

import numpy as np
from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.reference.pendulums.cycloidal_pendulum import CycloidalMotion


def cycloid_equations(t: Any, state: Values, parameters: Values) -> Values:
    """phi'' = tan(phi/2) (phi'^2 - g/a) / 2."""
    phi, rate = state
    a, g = parameters
    return rate, tan(phi / 2) * (rate * rate - g / a) / 2


def arc_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """s'' = -(g/4a) s."""
    (s,) = q
    a, g = parameters
    return (-(g / (4 * a)) * s,)


def arc_potential(t: Any, q: Values, parameters: Values) -> Values:
    (s,) = q
    a, g = parameters
    return ((g / (8 * a)) * s * s,)


def cycloid_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero at the bottom: s'^2/2 + g y, s' = 2 a cos(phi/2) phi', y = 2 a sin^2(phi/2)."""
    phi, rate = state
    a, g = parameters
    square = sin(phi / 2) * sin(phi / 2)
    return (2 * a * a * (1 - square) * rate * rate + 2 * a * g * square,)


def arc_from_angle(mp: Any, state: Sequence[Any], parameters: Sequence[Any]) -> tuple[Any, Any]:
    phi, rate = state
    a, _ = parameters
    return 4 * a * mp.sin(phi / 2), 2 * a * mp.cos(phi / 2) * rate


def angle_from_arc(y: Floats, parameters: Sequence[float]) -> Floats:
    """The angle; nan beyond the cusp, where there is none."""
    a = parameters[0]
    sine = y[..., 0] / (4 * a)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = np.sqrt((1 - sine) * (1 + sine))
        return np.stack([2 * np.arctan2(sine, cosine), y[..., 1] / (2 * a * cosine)], axis=-1)


def cycloid_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """A bead on a guide with the shape of the cycloid."""
    phi, rate = state
    a, g = parameters

    def cycloid(phi: float) -> Vector:
        return a * (phi + sin(phi)), 0.0, a * (1 - cos(phi))

    bead = Body("bead", 1.0, (0.0, 0.0, 0.0))
    return Scene((0.0, 0.0, -g), (bead,), guides=(Guide("cycloid", "bead", cycloid, phi, rate),))


SCENE = SceneForm(cycloid_scene, joint("cycloid"), frozenset({"curved_guide"}), conservative=False)


class CycloidalPendulum(Case):
    """A bead on a smooth cycloid, or a string of length 4 a between cycloidal jaws of the same size."""

    name = "cycloidal_pendulum"
    title = "Huygens' isochronous cycloidal pendulum"
    section = "7.11.3-7.11.5, 8.12"
    conventions = "x=a(phi+sin phi), y=a(1-cos phi), s=4a sin(phi/2) arc length from the bottom, s''=-(g/4a)s."
    phi = Coordinate("rad", 1, Range(low=-pi, high=pi, typical=(-3.0, 3.0)))
    phidot = Coordinate("rad/s", 0, typical(-5, 5))
    a = Parameter("m", "0.25", "radius of the rolling circle", positive())
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    rules = (Rule("phidot^2 < g/a (else the bead reaches the cusp)", lambda n: n["phidot"] ** 2 * n["a"] < n["g"]),)
    exact_motion = bind(CycloidalMotion, rate0="phidot")
    default_span = Span(10.37, "turn")
    quantity_names = (
        *("period", "angle_amplitude", "arc_amplitude", "energy"),
        *("normal_force_start", "normal_force_bottom", "string_length"),
    )
    """Normal forces are over the mass (m/s^2). As a string between jaws of the same shape, the evolute of the cycloid, the
    pendulum has length 4 a."""
    variants = (
        Variant("small", "amplitude 0.01 rad: the period does not depend on the amplitude", initial_state=("0.01", 0)),
        Variant("wide", "amplitude 3 rad: the period does not depend on the amplitude", initial_state=(3, 0)),
        Variant("launched", "starts with speed and passes the bottom", initial_state=("0.5", 5)),
        Variant(
            "near_cusp",
            "released 1e-4 rad from the cusp: the angle turns sharply, the arc length does not",
            initial_state=("3.141492653589793", 0),
        ),
        Variant(
            "nearer_cusp",
            "released 1e-8 rad from the cusp: the angle turns within 1e-8 of a period; 2.5e-17 of the energy to reach the "
            "cusp is missing, less than binary64 resolves",
            initial_state=("3.141592643589793", 0),
        ),
        Variant(
            "cusp_to_cusp",
            "released at the last double before the cusp, s = 4a after rounding; ends just before the other cusp",
            initial_state=(pi, 0),
            periods=0.47,
        ),
    )
    invariants = conserved(energy=cycloid_energy)
    forms = (FirstOrder(cycloid_equations),)
    scene = SCENE
    reversal = ("phidot",)
    mirror = ("phi", "phidot")
    formulations = (
        Formulation("arc length", (Separable(arc_acceleration, arc_potential),), arc_from_angle, angle_from_arc),
    )

    @property
    def time_scale(self) -> float:
        """2 sqrt(a/g), the period over 2 pi."""
        return 2 * sqrt(float(self.a) / float(self.g))

    @property
    def fastest_time(self) -> float:
        """The time in which the angle turns close to the cusp."""
        return self.time_scale * cos(float(self.exact_motion.angle_amplitude()) / 2)

    def scales(self) -> dict[str, float]:
        """In closed form if the span holds a period: close to the cusp the peaks are narrow."""
        scales = accuracy.grid_scales(self)
        motion = self.exact_motion
        if self.span >= motion.period() and motion.energy() > 0:
            return {"angle": float(motion.angle_amplitude()), "angular velocity": float(motion.top_rate())}
        return scales

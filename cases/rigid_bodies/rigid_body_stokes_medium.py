"""A rigid body that rotates in a Stokes medium."""

from dataclasses import replace

from gnomon.cases.core.scene import Quaternion, Torque
from gnomon.cases.declare import *
from gnomon.cases.rigid_bodies.euler_top import (
    TRIANGLE,
    EulerTopCase,
    momentum_x,
    momentum_y,
    momentum_z,
    spinning,
)
from gnomon.cases.scenes.attitude import euler_top_reading, euler_top_scene, in_body, matrix
from gnomon.reference.rigid_bodies.rigid_body_stokes_medium import StokesBody


def stokes_moments(parameters: Values) -> Values:
    return parameters[:3]


def stokes_torque(t: Any, state: Values, parameters: Values) -> Values:
    """-nu H."""
    i1, i2, i3, nu = parameters
    return -nu * i1 * state[0], -nu * i2 * state[1], -nu * i3 * state[2]


def stokes_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Twice the energy, which decays as e^(-2 nu t)."""
    w1, w2, w3 = state[:3]
    i1, i2, i3, _nu = parameters
    return (i1 * w1 * w1 + i2 * w2 * w2 + i3 * w3 * w3,)


def stokes_ratio(t: Any, state: Values, parameters: Values) -> Values:
    """sqrt(2T)/|H|, constant: both decay as e^(-nu t)."""
    w1, w2, w3 = state[:3]
    i1, i2, i3, _nu = parameters
    m1, m2, m3 = i1 * w1, i2 * w2, i3 * w3
    return (sqrt((m1 * w1 + m2 * w2 + m3 * w3) / (m1 * m1 + m2 * m2 + m3 * m3)),)


def fading(momentum: Equations) -> Equations:
    """A component of H in space over its decay e^(-nu t), which is constant."""

    def over_its_decay(t: Any, state: Values, parameters: Values) -> Values:
        return (momentum(t, state, parameters[:3])[0] * exp(parameters[3] * t),)

    return over_its_decay


def stokes_scene(state: Values, parameters: Values) -> Scene:
    """The medium's torque -nu H is not the damping of rates that engines have, unless all moments are equal."""
    return in_medium(euler_top_scene(state, parameters[:3]), parameters[3])


def in_medium(scene: Scene, nu: float) -> Scene:
    """The scene of one body with the torque -nu H on it."""
    (body,) = scene.bodies

    def drag(t: float, attitude: Quaternion, spin: Vector) -> Vector:
        r = matrix(attitude)
        a, b, c = (-nu * moment * rate for moment, rate in zip(body.inertia, in_body(r, spin), strict=True))
        return r[0] * a + r[1] * b + r[2] * c, r[3] * a + r[4] * b + r[5] * c, r[6] * a + r[7] * b + r[8] * c

    return replace(scene, torques=(Torque(body.name, "drag_torque", drag),))


def stokes_reading(readings: Readings, parameters: Values) -> Values:
    return euler_top_reading(readings, parameters[:3])


SCENE = SceneForm(stokes_scene, stokes_reading, frozenset({"gyroscopic", "drag_torque"}), conservative=False)
ROTATES = Rule("the body rotates (w is not zero)", lambda n: any(n[w] != 0 for w in ("w1", "w2", "w3")))


class RigidBodyStokesMedium(Case):
    name = "rigid_body_stokes_medium"
    title = "Rigid body rotating in a Stokes medium"
    section = "10.22.1-10.22.3"
    conventions = (
        "Drag -nu v per unit mass on every element, so the medium's torque is -nu H. w are body components; R, row by "
        "row, takes body components to space, R' = R hat(w). R(0) need not be orthogonal."
    )
    w1 = Coordinate("rad/s", 1, typical(-2, 2))
    w2 = Coordinate("rad/s", "0.6", typical(-2, 2))
    w3 = Coordinate("rad/s", "0.3", typical(-2, 2))
    attitude = Attitude()
    I1 = Parameter("kg m^2", 2, "principal moment of inertia", positive(0.8, 1.5))
    I2 = Parameter("kg m^2", 3, "principal moment of inertia", positive(0.8, 1.5))
    I3 = Parameter("kg m^2", 4, "principal moment of inertia", positive(0.8, 1.5))
    nu = Parameter("1/s", "0.1", "drag over mass and speed", nonnegative(0, 1))
    rules = (
        TRIANGLE,
        ROTATES,
    )
    exact_motion = bind(StokesBody, moments="I1 I2 I3", rates="w1 w2 w3")
    quantity_names = ("free_time_limit=final_turn",)
    """`free_time_limit`: the body never turns further than the torque-free one in this time (s)."""
    variants = (
        Variant(
            "weak_flips",
            "weak drag on a body that tumbles about its middle axis: the time between flips grows",
            {"I1": 1, "I2": 2, "I3": 3, "nu": "0.001"},
            spinning("1e-6", 1, "1e-6"),
            span=400,
        ),
        Variant("dead", "nu t = 60: the rates decay to 1e-26, the attitude becomes constant", span=600),
        Variant("strong", "nu = 20: stops within about 0.05 s", {"nu": 20}),
        Variant(
            "rod",
            "a thin rod that rotates about a transverse axis: one moment is 1e-9 of the others",
            {"I1": "1e-9", "I2": 1, "I3": 1},
            spinning(0, 1, "0.5"),
        ),
        Variant("separatrix", "exactly on the separatrix", {"I1": 1, "I2": 2, "I3": "2.25"}, spinning(3, 1, 4)),
        Variant("no_medium", "nu = 0: the torque-free body", {"nu": 0}, span=60),
    )
    invariants = decaying(twice_energy=stokes_energy) | conserved(
        ratio=stokes_ratio, momentum_x=fading(momentum_x), momentum_y=fading(momentum_y), momentum_z=fading(momentum_z)
    )
    forms = (RigidBody(stokes_moments, stokes_torque),)
    scene = SCENE

    @property
    def time_scale(self) -> float:
        """The time of a radian at the initial rate, or of the drag if that is shorter."""
        return 1 / max(hypot(*map(float, self.initial_state[:3])), float(self.nu))

    def natural_span(self) -> Number:
        """6/nu, at most 100 radians at the initial rate."""
        nu, scale = float(self.nu), self.time_scale
        return min(6 / nu, 100 * scale) if nu else 100 * scale

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        return (self.level(EulerTopCase, "no medium: the torque-free body"),)

"""A rigid body thrown in uniform gravity."""

from gnomon.cases.core.forms import euler_equations
from gnomon.cases.declare import *
from gnomon.cases.rigid_bodies.euler_top import (
    TRIANGLE,
    momentum_x,
    momentum_y,
    momentum_z,
    spinning,
    twice_energy,
)
from gnomon.cases.scenes.attitude import euler_top_scene, in_body, matrix
from gnomon.reference.rigid_bodies.dynamics_of_free_rigid_body_in_gravity import FreeBody
from gnomon.reference.rigid_bodies.euler_top import EulerTop


def thrown_body(t: Any, state: Values, parameters: Values) -> Values:
    g, i1, i2, i3 = parameters
    return (*state[3:6], 0 * g, 0 * g, -g, *euler_equations(state[6:], (i1, i2, i3), (0, 0, 0)))


def thrown_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy of the centre of mass, per unit mass."""
    g = parameters[0]
    return ((state[3] * state[3] + state[4] * state[4] + state[5] * state[5]) / 2 + g * state[2],)


def thrown_spin_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Twice the energy of rotation."""
    return twice_energy(t, state[6:], parameters[1:])


def thrown_velocity(t: Any, state: Values, parameters: Values) -> Values:
    """vz + g t."""
    return (state[5] + parameters[0] * t,)


def of_the_rotation(momentum: Equations) -> Equations:
    """A component of the angular momentum about the centre, in space."""

    def about_the_centre(t: Any, state: Values, parameters: Values) -> Values:
        return momentum(t, state[6:], parameters[1:])

    return about_the_centre


def thrown_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    (turning,) = euler_top_scene(state[6:], parameters[1:]).bodies
    x, y, z, vx, vy, vz = state[:6]
    body = Body(
        "body",
        1.0,
        turning.inertia,
        (x, y, z),
        turning.quaternion,
        (vx, vy, vz),
        turning.angular_velocity,
    )
    return Scene((0.0, 0.0, -parameters[0]), (body,))


def thrown_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    position, attitude, velocity, spin = readings.bodies["body"]
    r = matrix(attitude)
    return (*position, *velocity, *in_body(r, spin), *r)


SCENE = SceneForm(thrown_scene, thrown_reading, frozenset({"gyroscopic"}), conservative=False)


class DynamicsOfFreeRigidBodyInGravity(Case):
    name = "dynamics_of_free_rigid_body_in_gravity"
    title = "Rigid body thrown in uniform gravity"
    section = "10.4"
    conventions = (
        "z up; x, y, z of the centre of mass. w are body components; R, row by row, takes body components to space, "
        "R' = R hat(w). R(0) need not be orthogonal."
    )
    x = Coordinate("m", 0)
    y = Coordinate("m", 0)
    z = Coordinate("m", 1)
    vx = Coordinate("m/s", 3)
    vy = Coordinate("m/s", 0)
    vz = Coordinate("m/s", 8)
    w1 = Coordinate("rad/s", 4, typical(-2, 2))
    w2 = Coordinate("rad/s", "0.5", typical(-2, 2))
    w3 = Coordinate("rad/s", 1, typical(-2, 2))
    attitude = Attitude()
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", nonnegative(0, 20))
    I1 = Parameter("kg m^2", 2, "principal moment of inertia", positive(0.8, 1.5))
    I2 = Parameter("kg m^2", 3, "principal moment of inertia", positive(0.8, 1.5))
    I3 = Parameter("kg m^2", 4, "principal moment of inertia", positive(0.8, 1.5))
    rules = (TRIANGLE,)
    exact_motion = bind(
        lambda c: FreeBody(
            c.g, (c.x, c.y, c.z), (c.vx, c.vy, c.vz), EulerTop((c.I1, c.I2, c.I3), (c.w1, c.w2, c.w3), c.attitude)
        )
    )
    default_span = "1.7"
    quantity_names = ("precession_rate=body.precession",)
    variants = (
        Variant(
            "racket",
            "a racket thrown with rotation about its middle axis: it flips in flight",
            {"I1": 1, "I2": 2, "I3": "2.8"},
            (0, 0, 1, 1, 0, 8, *spinning("0.001", 15, "0.001")),
        ),
        Variant("no_gravity", "g = 0: a straight line", {"g": 0}),
        Variant("high", "falls for 100 s: 43 turns in one fall", span=100),
    )
    invariants = conserved(
        energy=thrown_energy,
        twice_spin_energy=thrown_spin_energy,
        upward_velocity=thrown_velocity,
        momentum_x=of_the_rotation(momentum_x),
        momentum_y=of_the_rotation(momentum_y),
        momentum_z=of_the_rotation(momentum_z),
    )
    forms = (FirstOrder(thrown_body),)
    scene = SCENE
    reversal = ("vx", "vy", "vz", "w1", "w2", "w3")

    @property
    def time_scale(self) -> float:
        """One radian at the initial rate."""
        rate = hypot(*map(float, self.initial_state[6:9]))
        return min(1 / rate, 1.0) if rate else 1.0

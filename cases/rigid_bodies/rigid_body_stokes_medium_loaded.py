"""A rigid body in a Stokes medium under a load: its own weight, or a constant torque.

Cases: rigid_body_stokes_medium_falling, rigid_body_stokes_medium_torque.
"""

from dataclasses import replace

from gnomon.cases.core.forms import euler_equations
from gnomon.cases.core.scene import Torque
from gnomon.cases.declare import *
from gnomon.cases.rigid_bodies.dynamics_of_free_rigid_body_in_gravity import (
    DynamicsOfFreeRigidBodyInGravity,
    thrown_reading,
    thrown_scene,
)
from gnomon.cases.rigid_bodies.euler_top import (
    TRIANGLE,
    momentum_x,
    momentum_y,
    momentum_z,
    spinning,
)
from gnomon.cases.rigid_bodies.rigid_body_stokes_medium import (
    ROTATES,
    RigidBodyStokesMedium,
    fading,
    in_medium,
    stokes_moments,
    stokes_reading,
    stokes_scene,
)
from gnomon.reference.flight.projectile_stokes_drag import StokesDrag
from gnomon.reference.rigid_bodies.rigid_body_stokes_medium import StokesBody
from gnomon.reference.rigid_bodies.rigid_body_stokes_medium_falling import FallingStokesBody


def falling_in_medium(t: Any, state: Values, parameters: Values) -> Values:
    g, i1, i2, i3, nu = parameters
    vx, vy, vz, w1, w2, w3 = state[3:9]
    torque = -nu * i1 * w1, -nu * i2 * w2, -nu * i3 * w3
    return (vx, vy, vz, -nu * vx, -nu * vy, -g - nu * vz, *euler_equations(state[6:], (i1, i2, i3), torque))


def carried_x(t: Any, state: Values, parameters: Values) -> Values:
    """vx + nu x, constant: drag reduces the velocity by nu times the distance."""
    return (state[3] + parameters[4] * state[0],)


def carried_y(t: Any, state: Values, parameters: Values) -> Values:
    return (state[4] + parameters[4] * state[1],)


def carried_z(t: Any, state: Values, parameters: Values) -> Values:
    """vz + nu z + g t."""
    return (state[5] + parameters[4] * state[2] + parameters[0] * t,)


def falling_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """H_z over its decay e^(-nu t), constant."""
    return fading(momentum_z)(t, state[6:], parameters[1:])


def turned_torque(t: Any, state: Values, parameters: Values) -> Values:
    """-nu H plus the torque M about the vertical, M times the third row of R."""
    i1, i2, i3, nu, M = parameters
    return (
        M * state[9] - nu * i1 * state[0],
        M * state[10] - nu * i2 * state[1],
        M * state[11] - nu * i3 * state[2],
    )


def scaled_momentum_excess(t: Any, state: Values, parameters: Values) -> Values:
    """nu (H_z - M/nu) e^(nu t), constant."""
    nu, M = parameters[3:]
    return ((nu * momentum_z(t, state, parameters[:3])[0] - M) * exp(nu * t),)


def driven_scene(state: Values, parameters: Values) -> Scene:
    """The torque M about the vertical is constant in space."""
    drag = stokes_scene(state, parameters[:4])
    return replace(
        drag, torques=(*drag.torques, Torque("top", "torque", lambda t, attitude, spin: (0.0, 0.0, parameters[4])))
    )


def falling_scene(state: Values, parameters: Values) -> Scene:
    """Drag acts on the centre of mass as a force, and as a torque."""
    nu = parameters[4]

    def drag(t: float, position: Vector, velocity: Vector) -> Vector:
        vx, vy, vz = velocity
        return -nu * vx, -nu * vy, -nu * vz

    scene = in_medium(thrown_scene(state, parameters[:4]), nu)
    return replace(scene, forces=(Force("body", "velocity_force", drag),))


FALLING = SceneForm(
    falling_scene, thrown_reading, frozenset({"gyroscopic", "velocity_force", "drag_torque"}), conservative=False
)
DRIVEN = SceneForm(driven_scene, stokes_reading, frozenset({"gyroscopic", "drag_torque", "torque"}), conservative=False)


class RigidBodyStokesMediumFalling(Case):
    name = "rigid_body_stokes_medium_falling"
    title = "Rigid body that falls and tumbles in a Stokes medium"
    section = "10.22.4, 10.22.1"
    conventions = (
        "z up; x, y, z of the centre of mass; drag -nu v per unit mass on every element, so that r'' = g - nu r' and the "
        "torque is -nu H. w are body components; R, row by row, takes body components to space, R' = R hat(w)."
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
    nu = Parameter("1/s", "0.4", "drag over mass and speed", nonnegative(0, 1))
    rules = (TRIANGLE, ROTATES)
    exact_motion = bind(
        lambda c: FallingStokesBody(
            StokesDrag(c.nu, (0 * c.g, 0 * c.g, -c.g), (c.x, c.y, c.z), (c.vx, c.vy, c.vz)),
            StokesBody(c.nu, (c.I1, c.I2, c.I3), (c.w1, c.w2, c.w3), c.attitude),
        )
    )
    default_span = "4.7"
    variants = (
        Variant("terminal", "falls for 30/nu: reaches the terminal speed, the rotation stops", span=75),
        Variant("weak", "nu = 1e-9: formulas divide by nu^2", {"nu": "1e-9"}),
        Variant("strong", "nu = 1e3: stops at once and falls slowly", {"nu": 1000}, span="1.7"),
    )
    invariants = conserved(carried_x=carried_x, carried_y=carried_y, carried_z=carried_z, momentum_z=falling_momentum)
    forms = (FirstOrder(falling_in_medium),)
    scene = FALLING

    @property
    def time_scale(self) -> float:
        """The time of a radian at the initial rate, or of the drag if that is shorter."""
        rate = hypot(*map(float, self.initial_state[6:9]))
        return 1 / max(rate, float(self.nu), 1.0)

    def derived(self, digits: int) -> dict[str, Any]:
        motion, limit = self.exact_motion, self.exact_motion.body.final_turn(digits)
        return {
            "terminal_speed": None if limit is None else motion.centre.terminal_speed(2, digits),
            "free_time_limit": limit,
        }

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        return (self.level(DynamicsOfFreeRigidBodyInGravity, "no medium"),)


class RigidBodyStokesMediumTorque(IntegratedCase):
    name = "rigid_body_stokes_medium_torque"
    title = "Rigid body driven by a constant torque in a Stokes medium (certified Taylor)"
    section = "10.22.4, 10.22.1"
    conventions = (
        "[inferred] A torque M about the fixed vertical z, and the medium's -nu H: H' = M - nu H in space; the attitude "
        "follows by integration. w are body components; R, row by row, is orthogonal and maps body components to space, "
        "R' = R hat(w)."
    )
    w1 = Coordinate("rad/s", 1, typical(-2, 2))
    w2 = Coordinate("rad/s", "0.6", typical(-2, 2))
    w3 = Coordinate("rad/s", "0.3", typical(-2, 2))
    attitude = Attitude(fixed=True)
    I1 = Parameter("kg m^2", 2, "principal moment of inertia", positive(0.8, 1.5))
    I2 = Parameter("kg m^2", 3, "principal moment of inertia", positive(0.8, 1.5))
    I3 = Parameter("kg m^2", 4, "principal moment of inertia", positive(0.8, 1.5))
    nu = Parameter("1/s", "0.1", "drag over mass and speed", positive(0.05, 1))
    M = Parameter("N m", 1, "torque along the vertical", typical(-2, 2))
    rules = (TRIANGLE,)
    default_span = "12.3"
    variants = (
        Variant("from_rest", "driven from rest about an axis that is not principal", initial_state=spinning(0, 0, 0)),
        Variant("axisymmetric", "two equal moments", {"I1": 2, "I2": 2, "I3": 3}),
        Variant("rod", "a rod: the torque accelerates it about the axis of the moment that is 1e-2 of the others", {"I1": "0.01", "I2": 1, "I3": 1}, spinning(0, 1, "0.5"), "2.3"),
        Variant("settles", "nu t = 20: ends in rotation about the vertical with H = M/nu", {"nu": 1}, span=20),
    )  # fmt: skip
    invariants = conserved(
        momentum_x=fading(momentum_x), momentum_y=fading(momentum_y), momentum_left=scaled_momentum_excess
    )
    forms = (RigidBody(stokes_moments, turned_torque),)
    scene = DRIVEN

    @property
    def time_scale(self) -> float:
        """The shortest time of a radian at the initial or the final rate, and of the drag."""
        i1, i2, i3, nu, M = map(float, self.parameter_values())
        rate = hypot(*map(float, self.initial_state[:3]))
        return 1 / max(rate, abs(M) / nu / max(i1, i2, i3), nu, 0.1)

    def derived(self, digits: int) -> dict[str, Any]:
        """`final_momentum`: M/nu, about the vertical (kg m^2/s)."""
        return {"final_momentum": self.M / self.nu}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        if not any(self.initial_state[:3]):
            return ()
        undriven = self.level(RigidBodyStokesMedium, "no torque")
        return (*undriven.case.hierarchy, undriven)

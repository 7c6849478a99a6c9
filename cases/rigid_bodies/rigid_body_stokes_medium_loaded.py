"""A rigid body in a Stokes medium under a load: its own weight, or a constant torque.

Cases: rigid_body_stokes_medium_falling, rigid_body_stokes_medium_torque.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from math import exp
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Level, Variant, same
from gnomon.cases.core.forms import FirstOrder, RigidBody, Values, euler_equations
from gnomon.cases.core.integrated import IntegratedCase
from gnomon.cases.core.numbers import Domain, Parameter, Range, positive
from gnomon.cases.core.scene import Force, Scene, SceneForm, Vector
from gnomon.cases.rigid_bodies.dynamics_of_free_rigid_body_in_gravity import (
    DynamicsOfFreeRigidBodyInGravity,
    thrown_reading,
    thrown_scene,
)
from gnomon.cases.rigid_bodies.euler_top import (
    ORTHOGONAL,
    TRIANGLE,
    EulerTopCase,
    momentum_x,
    momentum_y,
    momentum_z,
    spinning,
)
from gnomon.cases.rigid_bodies.rigid_body_stokes_medium import (
    ROTATES,
    RigidBodyStokesMedium,
    fading,
    stokes_moments,
    stokes_reading,
    stokes_scene,
)
from gnomon.reference.flight.projectile_stokes_drag import StokesDrag
from gnomon.reference.numerics.precision import publish, working
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
    return stokes_scene(state, parameters[:4])


def falling_scene(state: Values, parameters: Values) -> Scene:
    """The drag on the centre of mass is a force; the token `drag_torque` states the torque."""
    nu = parameters[4]

    def drag(t: float, position: Vector, velocity: Vector) -> Vector:
        vx, vy, vz = velocity
        return -nu * vx, -nu * vy, -nu * vz

    return replace(thrown_scene(state, parameters[:4]), forces=(Force("body", "velocity_force", drag),))


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
    state = DynamicsOfFreeRigidBodyInGravity.state
    parameter_list = (
        *DynamicsOfFreeRigidBodyInGravity.parameter_list,
        Parameter("nu", "1/s", "0.4", "drag over mass and speed"),
    )
    default_state = (0, 0, 1, 3, 0, 8, *spinning(4, "0.5", 1))
    default_span = "4.7"
    domain = Domain(
        dict(DynamicsOfFreeRigidBodyInGravity.domain.ranges) | {"nu": Range(low=0.0, typical=(0.0, 1.0))},
        (TRIANGLE, ROTATES),
    )
    variants = (
        Variant("terminal", "falls for 30/nu: reaches the terminal speed, the rotation stops", span=75),
        Variant("weak", "nu = 1e-9: formulas divide by nu^2", {"nu": "1e-9"}),
        Variant("strong", "nu = 1e3: stops at once and falls slowly", {"nu": 1000}, span="1.7"),
    )
    invariants: ClassVar = {
        "carried_x": Invariant(carried_x),
        "carried_y": Invariant(carried_y),
        "carried_z": Invariant(carried_z),
        "momentum_z": Invariant(falling_momentum),
    }
    forms = (FirstOrder(falling_in_medium),)
    scene = FALLING

    @cached_property
    def _exact(self) -> FallingStokesBody:
        g, i1, i2, i3, nu = self.parameter_values()
        x, y, z, vx, vy, vz, w1, w2, w3, *attitude = self.initial_state
        return FallingStokesBody(
            StokesDrag(nu, (0 * g, 0 * g, -g), (x, y, z), (vx, vy, vz)),
            StokesBody(nu, (i1, i2, i3), (w1, w2, w3), tuple(attitude)),
        )

    def motion(self) -> FallingStokesBody:
        return self._exact

    @property
    def time_scale(self) -> float:
        """The time of a radian at the initial rate, or of the drag if that is shorter."""
        rate = math.hypot(*map(float, self.initial_state[6:9]))
        return 1 / max(rate, float(self.parameters["nu"]), 1.0)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        motion = self._exact
        limit = motion.body.final_turn(digits)
        if limit is None:
            return {}
        return {"terminal_speed": motion.centre.terminal_speed(2, digits), "free_time_limit": limit}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        numbers: dict[str, Any] = {name: self.parameters[name] for name in ("g", "I1", "I2", "I3")}
        free = DynamicsOfFreeRigidBodyInGravity(initial_state=self.initial_state, span=self.span, **numbers)
        return (Level(free, same, "no medium"),)


class RigidBodyStokesMediumTorque(IntegratedCase):
    name = "rigid_body_stokes_medium_torque"
    title = "Rigid body driven by a constant torque in a Stokes medium (certified Taylor)"
    section = "10.22.4, 10.22.1"
    conventions = (
        "[inferred] A torque M about the fixed vertical z, and the medium's -nu H: H' = M - nu H in space; the attitude "
        "follows by integration. w are body components; R, row by row, is orthogonal and maps body components to space, "
        "R' = R hat(w)."
    )
    state = EulerTopCase.state
    parameter_list = (*RigidBodyStokesMedium.parameter_list, Parameter("M", "N m", 1, "torque along the vertical"))
    default_state = spinning(1, "0.6", "0.3")
    default_span = "12.3"
    domain = Domain(
        {name: positive(0.8, 1.5) for name in ("I1", "I2", "I3")}
        | {name: Range(typical=(-2.0, 2.0)) for name in ("w1", "w2", "w3")}
        | {
            f"R{i}{j}": Range(ORTHOGONAL.low, ORTHOGONAL.high, typical=(float(i == j),) * 2)
            for i in (1, 2, 3)
            for j in (1, 2, 3)
        }
        | {"nu": positive(0.05, 1.0), "M": Range(typical=(-2.0, 2.0))},
        (TRIANGLE,),
    )
    variants = (
        Variant("from_rest", "driven from rest about an axis that is not principal", initial_state=spinning(0, 0, 0)),
        Variant("axisymmetric", "two equal moments", {"I1": 2, "I2": 2, "I3": 3}),
        Variant("rod", "a rod: the torque accelerates it about the axis of the moment that is 1e-2 of the others", {"I1": "0.01", "I2": 1, "I3": 1}, spinning(0, 1, "0.5"), "2.3"),
        Variant("settles", "nu t = 20: ends in rotation about the vertical with H = M/nu", {"nu": 1}, span=20),
    )  # fmt: skip
    invariants: ClassVar = {
        "momentum_x": Invariant(fading(momentum_x)),
        "momentum_y": Invariant(fading(momentum_y)),
        "momentum_left": Invariant(scaled_momentum_excess),
    }
    forms = (RigidBody(stokes_moments, turned_torque),)
    scene = DRIVEN

    @property
    def time_scale(self) -> float:
        """The shortest time of a radian at the initial or the final rate, and of the drag."""
        i1, i2, i3, nu, M = map(float, self.parameter_values())
        rate = math.hypot(*map(float, self.initial_state[:3]))
        return 1 / max(rate, abs(M) / nu / max(i1, i2, i3), nu, 0.1)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`final_momentum`: M/nu, about the vertical (kg m^2/s)."""
        with working(digits + 2) as mp:
            found = publish([mp.mpf(self.parameters["M"] / self.parameters["nu"])], digits)
        return {"final_momentum": found[0]}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        if not any(self.initial_state[:3]):
            return ()
        numbers: dict[str, Any] = {name: self.parameters[name] for name in ("I1", "I2", "I3", "nu")}
        undriven = RigidBodyStokesMedium(initial_state=self.initial_state, span=self.span, **numbers)
        return (*undriven.hierarchy, Level(undriven, same, "no torque"))

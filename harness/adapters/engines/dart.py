"""DART: rigid bodies in joint coordinates (Featherstone), built from scenes. A step is a kick, then a drift.

Forces are applied once a step; DART's own springs and dampers of joints err ten times more. A body whose fixed point is
the origin has a BallJoint: an EulerJoint is singular where its second angle is 90 degrees. The EulerJoint errs less on the
heavy top of the engine tables (0.015 instead of 0.25 at 1e-3 s). But `spherical_pendulum`, and tops with a step that is
too coarse, pass its singularity and end in numbers that are not finite; in a turned frame `spherical_pendulum` still errs a
third more than the BallJoint (0.039 instead of 0.029), and the tops diverge. No frame is the better one without knowing the
motion. Friction is a cone by NsgsFrictionSolver. A box touches a PlaneShape in one point, so
it has tiny spheres at its corners instead.

Limits that Python cannot change: a body rebounds only with more than 0.1 m/s and at most 100 m/s, a coefficient of
friction below 1e-3 counts as none, and the depth of a contact turns into a velocity of at most 1 mm/s. A rope is a
Coupler of two joints, whose force comes a step late.
"""

from collections.abc import Iterable, Mapping
from math import sqrt
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import Form
from gnomon.cases.core.scene import Body, Quaternion, Readings, Rope, Scene, SceneForm, Vector
from gnomon.harness.adapters.engines.compiled_laws import Loads
from gnomon.harness.adapters.engines.dart_world import Built
from gnomon.harness.adapters.engines.scene_run import (
    COARSE,
    TIGHTER,
    SceneIntegrator,
    forces_at,
    idle,
    impulses_within,
    torques_at,
)
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot
from gnomon.harness.contract.integrator import Floats


class World(Built):
    """A world that moves: `place` sets the start of a scene, then `advance` and `read`."""

    def place(self, scene: Scene) -> None:
        self.scene = scene
        for hinge in scene.hinges:
            self._set(self.joints[hinge.name], [hinge.angle], [hinge.rate])
        for slider in scene.sliders:
            self._set(self.joints[slider.name], [slider.position], [slider.rate])
        for rope in scene.ropes:
            self._place_rope(scene, rope)
        for body in scene.bodies:
            joint = self.nodes[body.name].getParentJoint()
            if joint.getType() == "FreeJoint":
                joint.setTransform(self._pose(body.position, matrix(body.quaternion)))
                joint.setLinearVelocity(body.velocity)
                joint.setAngularVelocity(body.angular_velocity)
            elif joint.getType() == "TranslationalJoint":
                self._set(joint, body.position, body.velocity)
            elif joint.getType() == "BallJoint":
                self._place_fixed(joint, body)

    def _set(self, joint: Any, place: Iterable[float], rate: Iterable[float]) -> None:
        joint.setPositions(list(place))
        joint.setVelocities(list(rate))

    def _place_fixed(self, joint: Any, body: Body) -> None:
        """A body whose fixed point is the origin.

        A point mass m on an arm L moves like 2m at L/2 with the moment m L^2 / 2 about its centre: the moment about the
        origin across the arm is m L^2, and the torque of gravity m g L. Forces act at the point itself.
        """
        turn, spin, node = matrix(body.quaternion), body.angular_velocity, joint.getChildBodyNode()
        if not any(body.inertia):
            square = dot(body.position, body.position)
            spin = along(ORIGIN, cross(body.position, body.velocity), 1 / square if square else 0.0)
            self.eccentric.add(body.name)
            self._weigh(node, 2 * body.mass, (body.mass * square / 2,) * 3, along(ORIGIN, body.position, -0.5))
        joint.setTransformFromChildBodyNode(self._pose(tuple(-turn.T @ body.position)))
        self._set(joint, self.api.dynamics.BallJoint.convertToPositions(turn), turn.T @ spin)

    def _place_rope(self, scene: Scene, rope: Rope) -> None:
        """The arm turns about a normal of the plane in which the body moves, so a motion in that plane meets no pole."""
        bodies = {body.name: body for body in scene.bodies}
        body, radial = bodies[rope.body], self.ropes[rope.body]
        arm = along(body.position, rope.hole, -1.0)
        r = sqrt(dot(arm, arm)) or 1.0
        out = along(ORIGIN, arm, 1 / r)
        candidates = (
            cross(out, body.velocity),
            cross(out, scene.gravity),
            cross(out, (1.0, 0.0, 0.0)),
        )
        normal = next((each for each in candidates if dot(each, each) > 1e-24), (0.0, 1.0, 0.0))
        normal = along(ORIGIN, normal, 1 / sqrt(dot(normal, normal)))
        turning = radial.getChildBodyNode().getParentBodyNode().getParentJoint()
        across = cross(normal, out)
        rate = dot(across, body.velocity) / r
        if turning.getNumDofs() == 1:
            turning.setAxis(normal)
            self._set(turning, [0.0], [rate])
        else:
            turning.setAxis1(normal)
            turning.setAxis2(across)
            self._set(turning, [0.0, 0.0], [rate, 0.0])
        radial.setAxis(out)
        speed = dot(out, body.velocity)
        self._set(radial, [r], [speed])
        if rope.other:  # a follower moves to where its leader was a step ago
            straight = self.nodes[rope.other].getParentJoint()
            straight.setAxis(rope.axis)
            behind = speed * self.dt * (-1 if self.leads else 1)
            self._set(straight, [rope.length(0.0) - r + behind], [-speed])

    def advance(self, steps: int) -> None:
        step = self.world.step
        if not self.pushed:
            for _ in range(steps):
                step()
        else:
            for number in range(self.steps, self.steps + steps):
                self.push(number * self.dt)
                step()
        self.steps += steps

    def push(self, t: float) -> None:
        """Apply forces, torques and blows at time t for one step, over which the engine keeps them constant."""
        if self.loads is None:
            for name, force, _ in forces_at(self.scene, t, self._motion):
                self.nodes[name].addExtForce(force)
            for name, torque in torques_at(self.scene, t, self._rotation):
                self.nodes[name].addExtTorque(torque, False)
        else:
            self._load(self.loads, t)
        for name, linear, angular in impulses_within(self.scene, t, self.dt):
            self.nodes[name].addExtForce(along(ORIGIN, linear, 1 / self.dt))
            self.nodes[name].addExtTorque(along(ORIGIN, angular, 1 / self.dt), False)
        for joint, place in self.driven:
            joint.setCommand(0, (place(t + self.dt) - joint.getPosition(0)) / self.dt)

    def _load(self, loads: Loads, t: float) -> None:
        """Apply the forces and torques of compiled laws."""
        for name, (spin, velocity, place, attitude, _, _) in loads.parts.items():
            place[:], velocity[:] = self._places(name)
            if self.scene.torques:
                (x, y, z, w), (spin[0], spin[1], spin[2]) = self._rotation(name)
                attitude[0], attitude[1], attitude[2], attitude[3] = w, x, y, z
        loads.update(t)
        for name, (*_, force, torque) in loads.parts.items():
            self.nodes[name].addExtForce(force)
            if self.scene.torques:
                self.nodes[name].addExtTorque(torque, False)

    def _places(self, name: str) -> tuple[Floats, Floats]:
        """Position and velocity of a body. Where its centre of mass is its origin, `getCOM` takes a tenth of the time."""
        node = self.nodes[name]
        if name in self.eccentric:
            return node.getWorldTransform().translation(), node.getLinearVelocity()
        return node.getCOM(), node.getCOMLinearVelocity()

    def _motion(self, name: str) -> tuple[Vector, Vector]:
        place, velocity = self._places(name)
        return tuple(place.tolist()), tuple(velocity.tolist())

    def _rotation(self, name: str) -> tuple[Quaternion, Vector]:
        node = self.nodes[name]
        q = node.getWorldTransform().quaternion()
        return (q.x(), q.y(), q.z(), q.w()), tuple(node.getAngularVelocity().tolist())

    def read(self) -> Readings:
        joints = {name: (joint.getPosition(0), joint.getVelocity(0)) for name, joint in self.joints.items()}
        bodies = {}
        for name in self.free:
            (place, velocity), (attitude, spin) = self._motion(name), self._rotation(name)
            bodies[name] = place, attitude, velocity, spin
        return Readings(joints, bodies)


def matrix(quaternion: Quaternion) -> Floats:
    """The rotation matrix of a unit quaternion."""
    x, y, z, w = quaternion
    twice: Floats = 2 * np.array(
        [
            [-y * y - z * z, x * y - z * w, x * z + y * w],
            [x * y + z * w, -x * x - z * z, y * z - x * w],
            [x * z - y * w, y * z + x * w, -x * x - y * y],
        ]
    )
    return np.eye(3) + twice


CURVES = "no joint or contact follows a smooth curve or surface that a function gives"


class Dart(SceneIntegrator):
    """DART with every option chosen so that it models the scene and nothing else. Order 1.

    Lee et al. 2018, J. Open Source Softw. 3(22), 500.
    """

    name, library = "World.step", "dartpy"
    order: ClassVar[int | None] = 1
    configured: ClassVar[bool] = True
    tight: ClassVar[bool] = False
    lines: ClassVar[Mapping[str, str]] = {
        "deactivation": "sleep = world.getDeactivationOptions(); sleep.mEnabled = {}; world.setDeactivationOptions(sleep)",
        "boxedLcpSolver": "solver = dartpy.constraint.{}(); world.getConstraintSolver().setBoxedLcpSolver(solver)"
        "  # the default friction is a pyramid",
        "collisionDetector": "world.setCollisionDetector(dartpy.collision.{}CollisionDetector())",
        "maxSweeps": "chosen = solver.getOptions(); chosen.maxSweeps = {}; solver.setOptions(chosen)  # default 100",
        "tolerance": "chosen = solver.getOptions(); chosen.tolerance = {}; solver.setOptions(chosen)  # default 1e-5",
    }
    lacks: ClassVar[Mapping[str, str]] = {
        "adhesion": "no contact holds two bodies together",
        "adhesive_contact": "no contact holds a body",
        "belt": "no belts",
        "curved_guide": CURVES,
        "curved_surface": CURVES,
        "disc_contact": "no contact of a sharp edge",
        "drill_friction": "no friction against rotation about the normal of a contact",
        "driven_frame": "a scene has no rate of its frame, which a driven joint would need",
        "knife_edge": "no constraint of velocities alone",
        "linkage": "couplers of joints are linear, and a scene has no rods that would close a loop",
        "loss_of_contact": CURVES,
        "rolling_without_slip": "no constraint of velocities alone",
        "static_friction": "one coefficient of friction",
        "unwinding_string": "no string that a body winds, and a scene has no radius for a coupler",
    }

    def world(self, form: SceneForm, dt: float) -> World:
        import dartpy  # without the library the status is `not_installed`

        return World(dartpy, form, dt, self.configured, self.tight)


class DartAsShipped(Dart):
    """DART with its defaults: only what the scene declares is set.

    Motions without contacts are the same. With friction it has no order against the exact motion: its friction is a
    pyramid, a box touches a plane in one point, and a body at rest for half a second sleeps.
    """

    policy, configured, order = "as shipped", False, None


CONTACTS = frozenset({"rigid_impact", "coulomb_isotropic", "thin_rod_contact"})
"""Each scene with contacts has one of these tokens. Motors and couplers have the default solver, which is direct."""


class DartTight(Dart):
    """DART as configured, with ten times the sweeps of its contact solver and a hundredth of its tolerance."""

    policy, tight, primary = TIGHTER, True, False
    sweep = COARSE

    def unsupported(self, form: Form | SceneForm) -> str | None:
        return super().unsupported(form) or idle(form, CONTACTS)


INTEGRATORS = (Dart, DartAsShipped, DartTight)

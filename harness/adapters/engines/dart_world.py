"""A DART world that holds one scene: only the bodies, joints, ropes, forces and contacts that the scene declares."""

from collections.abc import Callable, Iterable
from math import sqrt
from typing import Any

import numpy as np
from gnomon.cases.core.scene import (
    IDENTITY,
    Body,
    Contact,
    Hinge,
    Quaternion,
    Readings,
    Rope,
    Scene,
    SceneForm,
    Slider,
    Vector,
)
from gnomon.harness.adapters.engines.scene_run import forces_at, impulses_within, torques_at
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot
from gnomon.harness.contract.integrator import Floats

NOTHING = 1e-300
"""The mass or moment of inertia of what has none: DART warns of zeros, and every sum of doubles loses this."""
GRIP = 1e9
"""Friction of the surface of a body on a plane: of two coefficients DART takes the smaller, so the plane's counts."""
POINT = 1e-12
"""Radius of the spheres that are the ends of a thin rod (m)."""
SOLVER = {"tolerance": 1e-12, "maxSweeps": 1000}
"""With the defaults, 1e-5 and 100, a block at rest creeps."""


class World:
    """A world of the engine: `build` creates the things of a scene, `place` sets its start, then `advance` and `read`.

    `configured`: everything that the engine adds to the scene is switched off; otherwise the engine keeps its defaults.
    """

    def __init__(self, dartpy: Any, form: SceneForm, dt: float, configured: bool) -> None:
        self.api, self.needs, self.dt, self.configured = dartpy, form.needs, dt, configured
        self.options: dict[str, Any] = {}
        self.close()

    def close(self) -> None:
        """Drop everything: Python's references are the only ones."""
        self.world: Any = None
        self.steps = 0
        self.nodes: dict[str, Any] = {}  # the node of each body
        self.joints: dict[str, Any] = {}
        self.ropes: dict[str, Any] = {}  # the joint along the part of the rope between hole and body
        self.driven: list[tuple[Any, Callable[[float], float]]] = []

    def build(self, scene: Scene) -> None:
        self.close()
        self.scene = scene
        self.world = self.api.simulation.World()
        self.world.setTimeStep(self.dt)
        self.world.setGravity(scene.gravity)
        if self.configured:
            self._configure(bool(scene.contacts))
        for rope in scene.ropes:
            self._rope(rope)
        for body in scene.bodies:
            self._add(body)
        for contact in scene.contacts:
            self._touch(contact)
        self.free = [body.name for body in scene.bodies if body.name not in {joint.body for joint in scene.joints}]
        self.pushed = bool(scene.forces or scene.torques or scene.impulses or self.driven)

    def _configure(self, touching: bool) -> None:
        sleep = self.world.getDeactivationOptions()
        sleep.mEnabled = False
        self.world.setDeactivationOptions(sleep)
        self.options["deactivation"] = False
        if touching:
            solver, friction = self.world.getConstraintSolver(), self.api.constraint.NsgsFrictionSolver()
            chosen = friction.getOptions()
            for name, value in SOLVER.items():
                setattr(chosen, name, value)
            friction.setOptions(chosen)
            solver.setBoxedLcpSolver(friction)
            solver.setSplitImpulseEnabled(True)
            self.options |= {"boxedLcpSolver": "NsgsFrictionSolver", "splitImpulse": True} | SOLVER

    def _node(self, kind: str, parent: Any = None, properties: Any = None) -> tuple[Any, Any]:
        """A joint of this kind and its body, on the parent or in a skeleton of its own."""
        if parent is None:
            parent = self.api.dynamics.Skeleton(f"skeleton {self.world.getNumSkeletons()}")
            self.world.addSkeleton(parent)
        joint, node = getattr(parent, f"create{kind}JointAndBodyNodePair")()
        return joint, node

    def _weigh(self, node: Any, mass: float, inertia: Vector, centre: Vector = ORIGIN) -> None:
        moments = np.diag([max(each, NOTHING) for each in inertia])
        node.setInertia(self.api.dynamics.Inertia(mass, centre, moments))

    def _pose(self, place: Vector, turn: Floats | None = None) -> Any:
        pose = self.api.math.Isometry3()
        pose.set_translation(place)
        if turn is not None:
            pose.set_rotation(turn)
        return pose

    def _add(self, body: Body) -> None:
        """Create the node of a body, after that of the body which carries it."""
        if body.name in self.nodes:
            return
        joint = next((each for each in self.scene.joints if each.body == body.name), None)
        inertia = body.inertia
        if joint is not None:
            node = self._jointed(joint)
        elif self.needs & {"ball_joint", "rod"}:
            node = self._node("Ball")[1]
        else:
            node = self._node("Free" if any(inertia) else "Translational")[1]
            # A thin rod has no moment about its axis, and never turns about it: any moment gives the same motion.
            inertia = tuple(each or max(inertia) for each in inertia)  # type: ignore[assignment]
        self._weigh(node, body.mass, inertia)
        self.nodes[body.name] = node

    def _jointed(self, joint: Hinge | Slider) -> Any:
        parent, anchor = joint.parent, joint.anchor
        first = self.scene.hinges[0] if "chained_hinges" in self.needs else joint
        if joint != first and not parent:  # the first hinge carries the others, whose anchors are in space at angle zero
            parent, anchor = first.body, along(along(anchor, first.anchor, -1.0), first.arm, -1.0)  # type: ignore[union-attr]
        if parent:
            self._add(next(body for body in self.scene.bodies if body.name == parent))
        made, node = self._node("Revolute" if isinstance(joint, Hinge) else "Prismatic", self.nodes.get(parent))
        made.setAxis(joint.axis)
        made.setTransformFromParentBodyNode(self._pose(anchor))
        if isinstance(joint, Hinge):
            made.setTransformFromChildBodyNode(self._pose(along(ORIGIN, joint.arm, -1.0)))
            made.setCoulombFriction(0, joint.friction)
        elif joint.drive is not None:
            self._drive(made, joint.drive)
        self.joints[joint.name] = made
        return node

    def _drive(self, joint: Any, place: Callable[[float], float]) -> None:
        joint.setActuatorType(self.api.dynamics.VELOCITY)
        self.driven.append((joint, place))

    def _rope(self, rope: Rope) -> None:
        """Polar coordinates about the hole: a massless arm turns, and the body moves along it."""
        masses = {body.name: body.mass for body in self.scene.bodies}
        on_plane = any(contact.body == rope.body for contact in self.scene.contacts)
        joint, arm = self._node("Revolute" if on_plane else "Universal")
        joint.setTransformFromParentBodyNode(self._pose(rope.hole))
        self._weigh(arm, NOTHING, ORIGIN)
        radial, node = self._node("Prismatic", arm)
        self._weigh(node, masses[rope.body], ORIGIN)
        self.nodes[rope.body], self.ropes[rope.body] = node, radial
        if not rope.other:
            self._drive(radial, rope.length)
            return
        self.nodes[rope.other] = self._coupled("Prismatic", rope.axis, radial, -1.0, rope)
        self._weigh(self.nodes[rope.other], masses[rope.other], ORIGIN)
        if rope.inertia:  # a wheel of radius 1 m
            wheel = self._coupled("Revolute", rope.axis, radial, 1.0, rope)
            self._weigh(wheel, 1.0, (rope.inertia,) * 3)

    def _coupled(self, kind: str, axis: Vector, leader: Any, ratio: float, rope: Rope) -> Any:
        """A body on a joint whose coordinate follows that of the leader, with the opposite force on the leader.

        DART looks for a leader in every entry of the list, also beyond the degrees of freedom, and crashes without one.
        """
        joint, node = self._node(kind, leader.getSkeleton())
        properties = getattr(self.api.dynamics, f"{kind}JointProperties")()
        entries = properties.mMimicDofProps
        for entry in entries:
            entry.mReferenceJoint, entry.mMultiplier = leader, ratio
            entry.mOffset = rope.length(0.0) if ratio < 0 else 0.0
            entry.mConstraintType = self.api.dynamics.MimicConstraintType.Coupler
        properties.mMimicDofProps, properties.mAxis = entries, axis
        joint.setProperties(properties)
        joint.setActuatorType(self.api.dynamics.MIMIC)
        joint.setUseCouplerConstraint(True)
        joint.setTransformFromParentBodyNode(self._pose(rope.hole))
        return node

    def _touch(self, contact: Contact) -> None:
        """Give the surfaces of a contact their shapes; the engine multiplies their restitutions."""
        bodies = {body.name: body for body in self.scene.bodies}
        share = sqrt(contact.restitution) if any(each.partner for each in self.scene.contacts) else 1.0
        shapes = self.api.dynamics
        for name in filter(None, (contact.body, contact.partner)):
            body, node = bodies[name], self.nodes[name]
            if node.getNumShapeNodes() or name in self.ropes:
                continue
            if body.radius is not None:
                self._shape(node, shapes.SphereShape(body.radius), share, GRIP)
            elif "thin_rod_contact" in self.needs and body.half_extents is not None:
                for end in (1.0, -1.0):
                    tip = self._shape(node, shapes.SphereShape(POINT), share, GRIP)
                    tip.setRelativeTranslation(along(ORIGIN, body.half_extents, end))
            elif body.half_extents is not None:
                self._shape(node, shapes.BoxShape([2 * each for each in body.half_extents]), share, GRIP)
            else:  # a table: a plane that moves with the body
                self._shape(node, shapes.PlaneShape(contact.normal, 0.0), share, contact.friction)
        if not contact.partner and contact.body not in self.ropes:
            speed = sqrt(dot(contact.velocity, contact.velocity))
            joint, ground = self._node("Prismatic" if speed else "Weld")
            if speed:  # a plane that slides along itself looks the same at every place
                joint.setAxis(along(ORIGIN, contact.velocity, 1 / speed))
                self._drive(joint, lambda t: speed * t)
            rest = contact.restitution / share if share else 0.0
            self._shape(ground, shapes.PlaneShape(contact.normal, 0.0), rest, contact.friction)

    def _shape(self, node: Any, shape: Any, restitution: float, friction: float) -> Any:
        made = node.createShapeNode(shape)
        made.createCollisionAspect()
        made.createDynamicsAspect()
        made.getDynamicsAspect().setRestitutionCoeff(restitution)
        made.getDynamicsAspect().setFrictionCoeff(friction)
        return made

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
        candidates = (cross(out, body.velocity), cross(out, scene.gravity), *(cross(out, each) for each in np.eye(3).tolist()))
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
        for node in self.nodes[rope.body].getSkeleton().getBodyNodes():
            joint = node.getParentJoint()
            if joint.getActuatorType() == self.api.dynamics.MIMIC:
                wheel = joint.getType() == "RevoluteJoint"
                # The engine gives a follower the velocity that makes up for its lag in one step: it starts one step late.
                lagging = r - speed * self.dt
                self._set(joint, [lagging if wheel else rope.length(0.0) - lagging], [speed if wheel else -speed])

    def advance(self, steps: int) -> None:
        step = self.world.step
        if not self.pushed:
            for _ in range(steps):
                step()
        else:
            for done in range(self.steps, self.steps + steps):
                self._push(done * self.dt)
                step()
        self.steps += steps

    def _push(self, t: float) -> None:
        """Apply forces, torques and blows at time t for one step, over which the engine keeps them constant."""
        for name, force, _ in forces_at(self.scene, t, self._motion):
            self.nodes[name].addExtForce(force)
        for name, torque in torques_at(self.scene, t, self._rotation):
            self.nodes[name].addExtTorque(torque, False)
        for name, linear, angular in impulses_within(self.scene, t, self.dt):
            self.nodes[name].addExtForce(along(ORIGIN, linear, 1 / self.dt))
            self.nodes[name].addExtTorque(along(ORIGIN, angular, 1 / self.dt), False)
        for joint, place in self.driven:
            joint.setCommand(0, (place(t + self.dt) - joint.getPosition(0)) / self.dt)

    def _motion(self, name: str) -> tuple[Vector, Vector]:
        node = self.nodes[name]
        return tuple(node.getWorldTransform().translation().tolist()), tuple(node.getLinearVelocity().tolist())

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
    return np.eye(3) + 2 * np.array(
        [
            [-y * y - z * z, x * y - z * w, x * z + y * w],
            [x * y + z * w, -x * x - z * z, y * z - x * w],
            [x * z - y * w, y * z + x * w, -x * x - y * y],
        ]
    )

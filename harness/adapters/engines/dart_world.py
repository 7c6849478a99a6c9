"""A DART world that holds one scene: only the bodies, joints, ropes, forces and contacts that the scene declares."""

from collections.abc import Callable, Mapping
from itertools import product
from math import sqrt
from typing import Any

import numpy as np
from gnomon.cases.core.scene import (
    Body,
    Contact,
    Hinge,
    Rope,
    Scene,
    SceneForm,
    Slider,
    Vector,
)
from gnomon.harness.adapters.engines.compiled_laws import Loads, loads_if_compiled
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, dot
from gnomon.harness.contract.integrator import Floats

NOTHING = 1e-300
"""The mass or moment of inertia of what has none: DART warns of zeros, and every sum of doubles loses this."""
GRIP = 1e9
"""Friction of the surface of a body on a plane: of two coefficients DART takes the smaller, so the plane's counts."""
POINT = 1e-12
"""Radius of the spheres at the corners of a box and at the ends of a rod (m): a box touches a plane in one point only."""
CONTACT = {"boxedLcpSolver": "NsgsFrictionSolver", "collisionDetector": "DART"}
"""The default friction is a pyramid. Split impulses would let a block at rest creep, 0.5 mm in 10 s at steps of 0.01 s."""


class Built:
    """A world of the engine with the things of a scene, which `build` creates.

    `configured`: everything that the engine adds to the scene is switched off; otherwise the engine keeps its defaults.
    `tight`: the contact solver iterates longer.
    """

    def __init__(self, dartpy: Any, form: SceneForm, dt: float, configured: bool, tight: bool = False) -> None:
        self.api, self.needs, self.dt, self.configured, self.tight = dartpy, form.needs, dt, configured, tight
        self.chosen: dict[str, Any] = {}
        self.traced: Scene | None = None
        self.loads: Loads | None = None
        self.options: Mapping[str, Any] = self.chosen
        self.close()

    def close(self) -> None:
        """Drop everything: Python's references are the only ones."""
        self.world: Any = None
        self.steps = 0
        self.nodes: dict[str, Any] = {}  # the node of each body
        self.joints: dict[str, Any] = {}
        self.eccentric: set[str] = set()  # the bodies whose centre of mass is not at their origin
        self.ropes: dict[str, Any] = {}  # the joint along the part of the rope between hole and body
        self.driven: list[tuple[Any, Callable[[float], float]]] = []

    def build(self, scene: Scene) -> None:
        self.close()
        if scene is not self.traced:  # before each start the same scene is built anew
            self.traced, self.loads = scene, loads_if_compiled(scene)
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
        self.chosen["deactivation"] = False
        if touching:
            friction = self.api.constraint.NsgsFrictionSolver()
            if self.tight:
                options = friction.getOptions()
                options.maxSweeps, options.tolerance = 10 * options.maxSweeps, options.tolerance / 100
                friction.setOptions(options)
                self.chosen |= {"maxSweeps": options.maxSweeps, "tolerance": options.tolerance}
            self.world.getConstraintSolver().setBoxedLcpSolver(friction)
            self.world.setCollisionDetector(self.api.collision.DARTCollisionDetector())
            self.chosen |= CONTACT

    def _node(self, kind: str, parent: Any = None) -> tuple[Any, Any]:
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
        if joint.parent:
            self._add(next(body for body in self.scene.bodies if body.name == joint.parent))
        axle, node = self._node("Revolute" if isinstance(joint, Hinge) else "Prismatic", self.nodes.get(joint.parent))
        axle.setAxis(joint.axis)
        axle.setTransformFromParentBodyNode(self._pose(joint.anchor))
        if isinstance(joint, Hinge):
            axle.setTransformFromChildBodyNode(self._pose(along(ORIGIN, joint.arm, -1.0)))
            axle.setCoulombFriction(0, joint.friction)
        elif joint.drive is not None:
            self._drive(axle, joint.drive)
        self.joints[joint.name] = axle
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
        straight, hanging = self._node("Prismatic", radial.getSkeleton())
        straight.setTransformFromParentBodyNode(self._pose(rope.hole))
        self._weigh(hanging, masses[rope.other], ORIGIN)
        self.nodes[rope.other] = hanging
        if rope.inertia:  # a pulley turns as fast as this body moves, and weighs nothing
            pulley = self._node("Weld", hanging)[1]
            self._weigh(pulley, rope.inertia, ORIGIN)
            pulley.setGravityMode(False)
        self.leads = masses[rope.other] + rope.inertia > masses[rope.body]
        self._couple(*((radial, straight) if self.leads else (straight, radial)), rope)

    def _couple(self, follower: Any, leader: Any, rope: Rope) -> None:
        """Let two joints share the length of the rope, with the same force on both.

        The force comes a step late, which is unstable unless the leader has the larger mass. DART looks for a leader in
        every entry of the list, also beyond the degrees of freedom, and crashes without one.
        """
        properties = self.api.dynamics.PrismaticJointProperties()
        properties.mT_ParentBodyToJoint = follower.getTransformFromParentBodyNode()
        properties.mAxis = rope.axis
        entries = properties.mMimicDofProps
        for entry in entries:
            entry.mReferenceJoint, entry.mMultiplier, entry.mOffset = leader, -1.0, rope.length(0.0)
            entry.mConstraintType = self.api.dynamics.MimicConstraintType.Coupler
        properties.mMimicDofProps = entries
        follower.setProperties(properties)
        follower.setActuatorType(self.api.dynamics.MIMIC)
        follower.setUseCouplerConstraint(True)

    def _touch(self, contact: Contact) -> None:
        """Give the surfaces of a contact their shapes; the engine multiplies their restitutions."""
        bodies = {body.name: body for body in self.scene.bodies}
        share = sqrt(contact.restitution) if any(each.partner for each in self.scene.contacts) else 1.0
        shapes = self.api.dynamics
        for name in filter(None, (contact.body, contact.partner)):
            body, node = bodies[name], self.nodes[name]
            grip = contact.friction if contact.partner else GRIP
            if node.getNumShapeNodes() or name in self.ropes:
                continue
            if body.radius is not None:
                self._shape(node, shapes.SphereShape(body.radius), share, grip)
            elif body.half_extents is not None and (self.configured or not all(body.half_extents)):
                for corner in sorted(set(product(*((-each, each) for each in body.half_extents)))):
                    self._shape(node, shapes.SphereShape(POINT), share, grip).setRelativeTranslation(corner)
            elif body.half_extents is not None:
                self._shape(node, shapes.BoxShape([2 * each for each in body.half_extents]), share, grip)
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
        patch = node.createShapeNode(shape)
        patch.createCollisionAspect()
        patch.createDynamicsAspect()
        patch.getDynamicsAspect().setRestitutionCoeff(restitution)
        patch.getDynamicsAspect().setFrictionCoeff(friction)
        return patch

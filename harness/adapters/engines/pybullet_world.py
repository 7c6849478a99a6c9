"""A PyBullet world that holds one scene: only the bodies, joints, forces and contacts that the scene declares."""

from collections.abc import Callable
from functools import partial
from math import atan2, sqrt
from typing import Any

from gnomon.cases.core.scene import (
    IDENTITY,
    Body,
    Contact,
    Force,
    Hinge,
    Readings,
    Scene,
    SceneForm,
    Slider,
    Vector,
)
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot, turned

BREAKING_THRESHOLD = 0.02
"""The engine's default, set in every world because the value is global to the process."""

UNDAMPED = {"linearDamping": 0.0, "angularDamping": 0.0}
"""The defaults are 0.04: a damping that no scene declares."""
UNLIMITED = {"maxJointVelocity": 1e9}
"""By default all velocities of a multibody, also of its base, are limited to 100."""
IMPACT = {"restitutionVelocityThreshold": 0.0, "contactERP": 0.0, "contactSlop": 0.0}
IMPACT_BODY = {"contactProcessingThreshold": 0.0}
"""By default contacts act before they close, and restitution vanishes as the step size decreases."""
FRICTION = {"contactSlop": 0.0, "solverResidualThreshold": 0.0, "numSolverIterations": 100}
"""With the default residual and 50 iterations a block at rest creeps. Friction is isotropic by default, a cone."""


class World:
    """A world of the engine: `build` creates the bodies of a scene, `place` sets its start, then `advance` and `read`.

    A charge is pushed by Boris' method (Buneman 1967; Boris 1970): the engine adds force times step over mass to the
    velocity, so the force mass (Boris' new velocity - velocity) / step gives Boris' new velocity. The engine's velocity
    belongs to a time half a step before the position; `place` and `read` convert it. Order 2.

    `configured`: everything that the engine adds to the scene is switched off; otherwise the engine keeps its defaults.
    `maximal`: six coordinates for each body and constraints, instead of joint coordinates. `options`: the options that
    differ from the engine's defaults, apart from the step and the properties that the scene declares.
    """

    def __init__(self, pybullet: Any, form: SceneForm, dt: float, configured: bool, maximal: bool) -> None:
        self.api, self.needs, self.dt = pybullet, form.needs, dt
        self.configured, self.maximal = configured, maximal
        self.options: dict[str, Any] = {"useMaximalCoordinates": 1} if maximal else {}
        self.steps = 0
        self.client = int(pybullet.connect(pybullet.DIRECT))
        self._step, self._pose, self._twist, self._joint_state = map(
            self._bound, ("stepSimulation", "getBasePositionAndOrientation", "getBaseVelocity", "getJointState")
        )

    def close(self) -> None:
        """Disconnect: each open world slows down later connections."""
        if self.client >= 0:
            self.api.disconnect(physicsClientId=self.client)
            self.client = -1

    def build(self, scene: Scene) -> None:
        """Empty the world and create the bodies, joints, contacts and forces of `scene`."""
        self.steps = 0
        self.bodies: dict[str, int] = {}
        self.hinged: dict[str, tuple[int, Hinge, Vector]] = {}
        self.jointed: dict[str, int] = {}
        self.fields = {force.body: force.fields for force in scene.forces if force.fields and self.configured}
        if self.fields:
            self.options["charges"] = "pushed by Boris' method, velocities half a step before positions"
        self._call("resetSimulation")
        self._call(
            "setPhysicsEngineParameter",
            fixedTimeStep=self.dt,
            numSubSteps=0,
            contactBreakingThreshold=BREAKING_THRESHOLD,
        )
        if "rigid_impact" in self.needs:
            self._extra("setPhysicsEngineParameter", IMPACT)
        if "coulomb_isotropic" in self.needs:
            self._extra("setPhysicsEngineParameter", FRICTION)
        self._call("setGravity", *scene.gravity)
        self.masses = {body.name: body.mass for body in scene.bodies}
        joints = {joint.body: joint for joint in scene.joints}
        for body in scene.bodies:
            joint = joints.get(body.name)
            if joint is None:
                self._free(body, [c for c in scene.contacts if body.name in (c.body, c.partner)])
            elif self.maximal and isinstance(joint, Hinge):
                self._constrained(body, joint)
            else:
                self._jointed(body, joint)
        self.pushes = [self._push(force, joints.get(force.body)) for force in scene.forces]

    def _free(self, body: Body, contacts: list[Contact]) -> None:
        shape = self._shape(body) if self.maximal or contacts else -1
        number = self._create(body.mass, shape)
        if shape >= 0 and not contacts:
            self._call("setCollisionFilterGroupMask", number, -1, 0, 0)
        self._inertia(number, -1, body.mass, body.inertia)
        # The engine multiplies the coefficients of the two surfaces.
        for contact in contacts:
            if contact.partner:
                self._surface(number, sqrt(contact.restitution), sqrt(contact.friction))
                continue
            plane = self._create(0.0, self._shape_of("GEOM_PLANE", planeNormal=contact.normal))
            self._surface(plane, 1.0, 1.0)
            self._surface(number, contact.restitution, contact.friction)
        self.bodies[body.name] = number

    def _surface(self, number: int, restitution: float, friction: float) -> None:
        self._call("changeDynamics", number, -1, restitution=restitution, lateralFriction=friction)
        if "rigid_impact" in self.needs:
            self._extra("changeDynamics", IMPACT_BODY, number, -1)

    def _jointed(self, body: Body, joint: Hinge | Slider) -> None:
        """The body as the only link of a multibody whose base is fixed at the anchor."""
        hinge = isinstance(joint, Hinge)
        number = int(
            self._call(
                "createMultiBody",
                basePosition=joint.anchor,
                linkMasses=[body.mass],
                linkCollisionShapeIndices=[-1],
                linkVisualShapeIndices=[-1],
                linkPositions=[ORIGIN],
                linkOrientations=[IDENTITY],
                linkInertialFramePositions=[joint.arm if isinstance(joint, Hinge) else ORIGIN],
                linkInertialFrameOrientations=[IDENTITY],
                linkParentIndices=[0],
                linkJointTypes=[self.api.JOINT_REVOLUTE if hinge else self.api.JOINT_PRISMATIC],
                linkJointAxis=[joint.axis],
            )
        )
        self._inertia(number, 0, body.mass, body.inertia)
        if self.configured:  # the default motor locks a joint
            self._call("setJointMotorControl2", number, 0, self.api.VELOCITY_CONTROL, force=0.0)
            self.options["velocityMotorForce"] = 0.0
        self.jointed[joint.name] = number

    def _constrained(self, body: Body, hinge: Hinge) -> None:
        """The body attached to a fixed one by a point-to-point constraint.

        The engine needs positive inertia: a point mass at the arm's end moves like a body at half the arm with the
        moment m |arm|^2 / 4, at every angle of the hinge.
        """
        arm, inertia = hinge.arm, body.inertia
        if not any(inertia):
            moment = body.mass * dot(arm, arm) / 4
            arm, inertia = along(ORIGIN, arm, 0.5), (moment, moment, moment)
        support, number = self._create(0.0, self._shape(body)), self._create(body.mass, self._shape(body))
        for each in (support, number):
            self._call("setCollisionFilterGroupMask", each, -1, 0, 0)
        self._inertia(number, -1, body.mass, inertia)
        self._call("resetBasePositionAndOrientation", support, hinge.anchor, IDENTITY)
        self._call("resetBasePositionAndOrientation", number, along(hinge.anchor, arm, 1.0), IDENTITY)
        pivot = along(ORIGIN, arm, -1.0)
        kind = self.api.JOINT_POINT2POINT
        self._call("createConstraint", support, -1, number, -1, kind, hinge.axis, ORIGIN, pivot)
        self.hinged[hinge.name] = number, hinge, arm

    def _create(self, mass: float, shape: int) -> int:
        return int(self._call("createMultiBody", mass, shape, useMaximalCoordinates=int(self.maximal)))

    def _shape(self, body: Body) -> int:
        """The body's shape: a box, or a sphere, in maximal coordinates also for bodies without contacts."""
        if body.half_extents is not None:
            return self._shape_of("GEOM_BOX", halfExtents=body.half_extents)
        return self._shape_of("GEOM_SPHERE", radius=body.radius if body.radius is not None else 0.1)

    def _shape_of(self, kind: str, **sizes: Any) -> int:
        return int(self._call("createCollisionShape", getattr(self.api, kind), **sizes))

    def _inertia(self, number: int, link: int, mass: float, inertia: Vector) -> None:
        if any(inertia):  # in one call: set alone, the inertia of a body in maximal coordinates sets its mass to 0
            self._call("changeDynamics", number, link, mass=mass, localInertiaDiagonal=inertia)
        self._extra("changeDynamics", UNDAMPED if self.maximal else UNDAMPED | UNLIMITED, number, link)

    def place(self, scene: Scene) -> None:
        """Set the initial state of every body and joint."""
        settling = self.maximal and not scene.contacts
        poses = [(self.bodies[b.name], b.position, b.quaternion) for b in scene.bodies if b.name in self.bodies]
        twists = [
            (self.bodies[b.name], self._pushed(b.name, 0.0, b.position, b.velocity, -0.5), b.angular_velocity)
            for b in scene.bodies
            if b.name in self.bodies
        ]
        for hinge in scene.hinges:
            if hinge.name in self.hinged:
                number, _, arm = self.hinged[hinge.name]
                attitude, lever = turned(hinge.axis, arm, hinge.angle)
                spin = along(ORIGIN, hinge.axis, hinge.rate)
                poses.append((number, along(hinge.anchor, lever, 1.0), attitude))
                twists.append((number, cross(spin, lever), spin))
            else:
                self._call("resetJointState", self.jointed[hinge.name], 0, hinge.angle, hinge.rate)
        for slider in scene.sliders:
            self._call("resetJointState", self.jointed[slider.name], 0, slider.position, slider.rate)
        for pose in poses:
            self._call("resetBasePositionAndOrientation", *pose)
        if (
            settling
        ):  # the first step after a change of pose or inertia uses the old value: take it at rest, without gravity
            self._call("setGravity", *ORIGIN)
            self._step()
            self._call("setGravity", *scene.gravity)
        for twist in twists:
            self._call("resetBaseVelocity", *twist)

    def advance(self, steps: int) -> None:
        for done in range(self.steps, self.steps + steps):
            for push in self.pushes:
                push(done * self.dt)
            self._step()
        self.steps += steps

    def _push(self, force: Force, joint: Hinge | Slider | None) -> Callable[[float], None]:
        """A function that applies a force at time t for one step, over which the engine keeps it constant."""
        law = force.law
        if force.partner:
            return self._push_pair(force)
        if isinstance(joint, Slider):
            rail, number = joint, self.jointed[joint.name]
            drive = self._bound("setJointMotorControl2", number, 0, self.api.TORQUE_CONTROL)

            def push_along(t: float) -> None:
                x, v, *_ = self._joint_state(number, 0)
                drive(force=dot(rail.axis, law(t, along(rail.anchor, rail.axis, x), along(ORIGIN, rail.axis, v))))

            return push_along
        if isinstance(joint, Hinge):
            hinge, number = joint, self.jointed[joint.name]
            turn = self._bound("setJointMotorControl2", number, 0, self.api.TORQUE_CONTROL)

            def push_around(t: float) -> None:
                angle, rate, *_ = self._joint_state(number, 0)
                _, arm = turned(hinge.axis, hinge.arm, angle)
                velocity = along(ORIGIN, cross(hinge.axis, arm), rate)
                turn(force=dot(hinge.axis, cross(arm, law(t, along(hinge.anchor, arm, 1.0), velocity))))

            return push_around
        number, frame = self.bodies[force.body], self.api.WORLD_FRAME
        apply, static = self._bound("applyExternalForce"), force.token == "position_force"
        if force.body in self.fields:
            per_step = self.masses[force.body] / self.dt

            def push_charge(t: float) -> None:
                position, velocity = self._pose(number)[0], self._twist(number)[0]
                after = self._pushed(force.body, t, position, velocity, 1.0)
                impulse = along(after, velocity, -1.0)
                apply(number, -1, along(ORIGIN, impulse, per_step), position, frame)

            return push_charge

        def push_body(t: float) -> None:
            position = self._pose(number)[0]
            velocity = ORIGIN if static else self._twist(number)[0]
            apply(number, -1, law(t, position, velocity), position, frame)

        return push_body

    def _push_pair(self, force: Force) -> Callable[[float], None]:
        """A function that applies a force at time t, and the opposite force to the partner."""
        one, two, law = self.bodies[force.body], self.bodies[force.partner], force.law
        apply, frame = self._bound("applyExternalForce"), self.api.WORLD_FRAME

        def push(t: float) -> None:
            here, there = self._pose(one)[0], self._pose(two)[0]
            pull = law(t, along(here, there, -1.0), along(self._twist(one)[0], self._twist(two)[0], -1.0))
            apply(one, -1, pull, here, frame)
            apply(two, -1, along(ORIGIN, pull, -1.0), there, frame)

        return push

    def read(self) -> Readings:
        joints = {name: self._joint_state(number, 0)[:2] for name, number in self.jointed.items()}
        for name, (number, hinge, _) in self.hinged.items():
            attitude, spin = self._pose(number)[1], self._twist(number)[1]
            angle = 2 * atan2(dot(attitude[:3], hinge.axis), attitude[3])
            joints[name] = angle, dot(spin, hinge.axis)
        bodies = {}
        for name, number in self.bodies.items():
            (position, attitude), (velocity, spin) = self._pose(number), self._twist(number)
            velocity = self._pushed(name, self.steps * self.dt, position, velocity, 0.5)
            bodies[name] = position, attitude, velocity, spin
        return Readings(joints, bodies)

    def _pushed(self, name: str, t: float, position: Vector, velocity: Vector, steps: float) -> Vector:
        """The velocity of a charge after `steps` steps in the fields at this time and position.

        The velocities of other bodies are returned unchanged.
        """
        if name not in self.fields:
            return velocity
        electric, magnetic = self.fields[name](t, position)
        half = steps * self.dt / 2
        turn = along(ORIGIN, magnetic, half)
        v = along(velocity, electric, half)
        twice = along(ORIGIN, turn, 2 / (1 + dot(turn, turn)))
        v = along(v, cross(along(v, cross(v, turn), 1.0), twice), 1.0)
        return along(v, electric, half)

    def _bound(self, name: str, *arguments: Any) -> Callable[..., Any]:
        return partial(getattr(self.api, name), *arguments, physicsClientId=self.client)

    def _call(self, name: str, *arguments: Any, **named: Any) -> Any:
        return getattr(self.api, name)(*arguments, physicsClientId=self.client, **named)

    def _extra(self, name: str, values: dict[str, Any], *arguments: Any) -> None:
        """If `configured`, set options that no scene declares, and record them."""
        if self.configured:
            self._call(name, *arguments, **values)
            self.options |= values

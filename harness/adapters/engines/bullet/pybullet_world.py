"""A PyBullet world that holds one scene: only the bodies, joints, forces and contacts that the scene declares."""

from collections.abc import Callable
from functools import partial
from math import atan2
from typing import Any

from gnomon.cases.core.scene import IDENTITY, Body, Contact, Hinge, Readings, Scene, SceneForm, Vector
from gnomon.harness.adapters.engines.bullet.pybullet_forces import Charges, Chore, chores_of
from gnomon.harness.adapters.engines.bullet.pybullet_joints import Motion
from gnomon.harness.adapters.engines.bullet.pybullet_planes import MovingPlane, skin, touch
from gnomon.harness.adapters.engines.bullet.pybullet_swivels import Pointer, Swivel, on_ropes
from gnomon.harness.adapters.engines.bullet.pybullet_trees import grow, place_joints
from gnomon.harness.adapters.engines.compiled_laws import Loads, loads_if_compiled
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot, turn_arm

BREAKING_THRESHOLD = 0.02
"""The engine's default, set in every world because the value is global to the process."""

UNDAMPED = {"linearDamping": 0.0, "angularDamping": 0.0}
"""The defaults are 0.04: a damping that no scene declares."""
UNLIMITED = {"maxJointVelocity": 1e9}
"""By default all velocities of a multibody, also of its base, are limited to 100."""
IMPACT = {"restitutionVelocityThreshold": 0.0, "contactERP": 0.0, "contactSlop": 0.0}
"""By default contacts act before they close, and restitution vanishes as the step size decreases."""
NO_SLOP = {"contactSlop": 0.0}
"""By default bodies may penetrate a little before a contact pushes: a drop flies on, and the end of a rod sinks."""
DEFAULT_ITERATIONS, TIGHTER = 50, 10
ITERATED = {"solverResidualThreshold": 0.0, "numSolverIterations": 100}
"""With the default residual and 50 iterations a block at rest creeps, and the two gears of a pulley do not agree. At small
steps the impulses of a gear or of a joint in maximal coordinates are below the default residual, and the solver stops early."""
PARAMETERS = (
    ({"rigid_impact"}, IMPACT),
    ({"coulomb_isotropic"}, NO_SLOP | ITERATED),  # friction is isotropic by default, a cone
    ({"thin_rod_contact", "adhesive_contact"}, NO_SLOP),
    ({"rope", "pulley", "linkage", "driven_axis"}, ITERATED),
)


class World:
    """A world of the engine: `build` creates the bodies of a scene, `place` sets its start, then `advance` and `read`.

    `configured`: everything that the engine adds to the scene is switched off; otherwise the engine keeps its defaults.
    `maximal`: six coordinates for each body and constraints, instead of joint coordinates. `tight`: ten times the
    iterations of the solver, and all of them. `options`: the options that
    differ from the engine's defaults, apart from the step and the properties that the scene declares.
    """

    def __init__(
        self, pybullet: Any, form: SceneForm, dt: float, configured: bool, maximal: bool, tight: bool = False
    ) -> None:
        self.api, self.needs, self.dt = pybullet, form.needs, dt
        self.configured, self.maximal, self.tight = configured, maximal, tight
        self.options: dict[str, Any] = {"useMaximalCoordinates": 1} if maximal else {}
        self.steps = 0
        self.traced: Scene | None = None
        self.loads: Loads | None = None
        self.client = int(pybullet.connect(pybullet.DIRECT))
        self._step, self.pose, self.twist, self.joint_state = map(
            self.bound, ("stepSimulation", "getBasePositionAndOrientation", "getBaseVelocity", "getJointState")
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
        self.planes: dict[str, MovingPlane] = {}
        self.hinged: dict[str, tuple[int, Hinge, Vector]] = {}
        self.jointed: dict[str, tuple[int, int]] = {}
        self.swivels: dict[str, Pointer | Swivel] = {}
        self.sleeve: tuple[int, int] | None = None
        self.measured: dict[str, Callable[[], Motion]] = {}
        self.carriers: dict[str, Callable[[], Motion]] = {}
        self.handles: dict[str, tuple[int, int]] = {}
        self.call("resetSimulation")
        self.call(
            "setPhysicsEngineParameter",
            fixedTimeStep=self.dt,
            numSubSteps=0,
            contactBreakingThreshold=BREAKING_THRESHOLD,
        )
        values: dict[str, Any] = {}
        for tokens, own in PARAMETERS:
            if self.needs & tokens or (self.maximal and own is ITERATED and "hinge" in self.needs):
                values |= own
        if self.tight:
            values |= ITERATED | {
                "numSolverIterations": TIGHTER * values.get("numSolverIterations", DEFAULT_ITERATIONS)
            }
        self.extra("setPhysicsEngineParameter", values)
        self.call("setGravity", *scene.gravity)
        if scene is not self.traced:  # before each start the same scene is built anew
            self.traced, self.loads = scene, loads_if_compiled(scene)
        self.charges = Charges(self, scene)
        self.chores: list[Chore] = []
        self._create_joints(scene)
        self._create_swivels(scene)
        for body in scene.bodies:
            if body.name not in (self.handles.keys() | self.planes.keys() | self.measured.keys()):
                self._free(body, [c for c in scene.contacts if body.name in (c.body, c.partner)])
        self.chores += [*(plane.chore for plane in self.planes.values()), *chores_of(self, scene)]

    def _create_joints(self, scene: Scene) -> None:
        """The joints; a body that is driven and touched is a plane, which the engine does not take as a link."""
        touched = {contact.partner: contact for contact in scene.contacts if contact.partner}
        for slider in scene.sliders:
            if slider.drive and slider.body in touched:
                self.planes[slider.body] = MovingPlane(self, touched[slider.body].normal, slider)
        if self.maximal:
            bodies = {body.name: body for body in scene.bodies}
            for hinge in scene.hinges:
                self._constrained(bodies[hinge.body], hinge)
        else:
            grow(self, scene)

    def _create_swivels(self, scene: Scene) -> None:
        """The bodies on ropes, rods and ball joints."""
        pointers, chores = on_ropes(self, scene)
        self.swivels |= pointers
        self.chores += chores
        if self.needs & {"ball_joint", "rod"}:
            for body in scene.bodies:
                swivel = Swivel(self, body) if any(body.inertia) else Pointer(self, body)
                if isinstance(swivel, Pointer):
                    swivel.multibody.driven(swivel.end)
                self.chores.append(swivel.keep)
                self.swivels[body.name] = swivel
        for name, swivel in self.swivels.items():
            self.carriers[name] = self.measured[name] = swivel.motion
            self.handles[name] = swivel.multibody.number, len(swivel.multibody.links) - 1

    def _free(self, body: Body, contacts: list[Contact]) -> None:
        shape = self._shape(body) if self.maximal or contacts else -1
        number = self.create(body.mass, shape)
        if shape >= 0 and not contacts:
            self.call("setCollisionFilterGroupMask", number, -1, 0, 0)
        # A rod does not turn about its own axis, where its moment is 0 and the engine needs a positive one.
        moments = [moment or max(body.inertia) for moment in body.inertia]
        self.set_inertia(number, -1, body.mass, (moments[0], moments[1], moments[2]))
        touch(self, number, body, contacts)
        self.bodies[body.name] = number
        self.handles[body.name] = number, -1

    def _constrained(self, body: Body, hinge: Hinge) -> None:
        """The body attached to a fixed one by a point-to-point constraint.

        The engine needs positive inertia: a point mass at the arm's end moves like a body at half the arm with the
        moment m |arm|^2 / 4, at every angle of the hinge.
        """
        arm, inertia = hinge.arm, body.inertia
        if not any(inertia):
            moment = body.mass * dot(arm, arm) / 4
            arm, inertia = along(ORIGIN, arm, 0.5), (moment, moment, moment)
        support, number = self.create(0.0, self._shape(body)), self.create(body.mass, self._shape(body))
        for each in (support, number):
            self.call("setCollisionFilterGroupMask", each, -1, 0, 0)
        self.set_inertia(number, -1, body.mass, inertia)
        self.call("resetBasePositionAndOrientation", support, hinge.anchor, IDENTITY)
        self.call("resetBasePositionAndOrientation", number, along(hinge.anchor, arm, 1.0), IDENTITY)
        pivot = along(ORIGIN, arm, -1.0)
        kind = self.api.JOINT_POINT2POINT
        self.call("createConstraint", support, -1, number, -1, kind, hinge.axis, ORIGIN, pivot)
        self.hinged[hinge.name] = number, hinge, arm
        self.handles[body.name] = number, -1

    def create(self, mass: float, shape: int) -> int:
        return int(self.call("createMultiBody", mass, shape, useMaximalCoordinates=int(self.maximal)))

    def _shape(self, body: Body) -> int:
        """The body's shape: a box, or a sphere, in maximal coordinates also for bodies without contacts."""
        if (radius := skin(body)) and (ends := body.half_extents):
            places = [ends, along(ORIGIN, ends, -1.0)]
            kinds = [self.api.GEOM_SPHERE] * 2
            return int(
                self.call(
                    "createCollisionShapeArray", shapeTypes=kinds, radii=[radius] * 2, collisionFramePositions=places
                )
            )
        if body.half_extents is not None:
            return self.shape_of("GEOM_BOX", halfExtents=body.half_extents)
        return self.shape_of("GEOM_SPHERE", radius=body.radius or radius or 0.1)

    def shape_of(self, kind: str, **sizes: Any) -> int:
        return int(self.call("createCollisionShape", getattr(self.api, kind), **sizes))

    def set_inertia(self, number: int, link: int, mass: float, inertia: Vector) -> None:
        if any(inertia):  # in one call: set alone, the inertia of a body in maximal coordinates sets its mass to 0
            self.call("changeDynamics", number, link, mass=mass, localInertiaDiagonal=inertia)
        self.undamped(number, link)

    def undamped(self, number: int, link: int) -> None:
        self.extra("changeDynamics", UNDAMPED if self.maximal else UNDAMPED | UNLIMITED, number, link)

    def place(self, scene: Scene) -> None:
        """Set the initial state of every body and joint."""
        settling = self.maximal and not scene.contacts
        pushed = self.charges.pushed
        poses, twists = [], []
        for body in scene.bodies:
            if body.name in self.bodies:
                poses.append((self.bodies[body.name], body.position, body.quaternion))
                velocity = pushed(body.name, 0.0, body.position, body.velocity, -0.5)
                twists.append((self.bodies[body.name], velocity, body.angular_velocity))
            elif body.name in self.swivels:
                self.swivels[body.name].place(body)
        for hinge in scene.hinges:
            if hinge.name in self.hinged:
                number, _, arm = self.hinged[hinge.name]
                attitude, lever = turn_arm(hinge.axis, arm, hinge.angle)
                spin = along(ORIGIN, hinge.axis, hinge.rate)
                poses.append((number, along(hinge.anchor, lever, 1.0), attitude))
                twists.append((number, cross(spin, lever), spin))
        place_joints(self, scene)
        for plane in self.planes.values():
            plane.place(scene)
        for pose in poses:
            self.call("resetBasePositionAndOrientation", *pose)
        if settling:
            # The first step after a change of pose or inertia uses the old value: take it at rest, without gravity.
            self.call("setGravity", *ORIGIN)
            self._step()
            self.call("setGravity", *scene.gravity)
        for twist in twists:
            self.call("resetBaseVelocity", *twist)

    def advance(self, steps: int) -> None:
        for step in range(self.steps, self.steps + steps):
            for chore in self.chores:
                chore(step * self.dt)
            self._step()
        self.steps += steps

    def read(self) -> Readings:
        joints = {name: self.joint_state(*handle)[:2] for name, handle in self.jointed.items()}
        for name, (number, hinge, _) in self.hinged.items():
            attitude, spin = self.pose(number)[1], self.twist(number)[1]
            angle = 2 * atan2(dot(attitude[:3], hinge.axis), attitude[3])
            joints[name] = angle, dot(spin, hinge.axis)
        joints |= {plane.rail.name: plane.state() for plane in self.planes.values() if plane.rail}
        bodies = {name: motion() for name, motion in self.measured.items()}
        for name, number in self.bodies.items():
            (position, attitude), (velocity, spin) = self.pose(number), self.twist(number)
            velocity = self.charges.pushed(name, self.steps * self.dt, position, velocity, 0.5)
            bodies[name] = position, attitude, velocity, spin
        return Readings(joints, bodies)

    def motion_of(self, body: str) -> Callable[[], Motion]:
        """A function that tells the motion of a body."""
        if body in self.carriers:
            return self.carriers[body]
        number = self.bodies[body]
        return lambda: (*self.pose(number), *self.twist(number))

    def bound(self, name: str, *arguments: Any, **named: Any) -> Callable[..., Any]:
        return partial(getattr(self.api, name), *arguments, physicsClientId=self.client, **named)

    def call(self, name: str, *arguments: Any, **named: Any) -> Any:
        return getattr(self.api, name)(*arguments, physicsClientId=self.client, **named)

    def record(self, values: dict[str, Any]) -> None:
        self.options |= values

    def extra(self, name: str, values: dict[str, Any], *arguments: Any) -> None:
        """If `configured`, set options that no scene declares, and record them."""
        if self.configured:
            self.call(name, *arguments, **values)
            self.record(values)

"""Planes in PyBullet, at rest and moving, and the surfaces of the bodies that touch them."""

from collections.abc import Callable
from math import sqrt
from typing import Any

from gnomon.cases.core.scene import IDENTITY, Body, Contact, Scene, Slider, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot, unit, upright_to

IMPACT_BODY = {"contactProcessingThreshold": 0.0}
"""See `IMPACT` of a world."""
HEAVY = 1e9
"""Mass of a moving plane (kg): the reaction changes its velocity by a share of 1e-9 of that of a body of 1 kg."""
HALF = (50.0, 50.0, 1.0)
"""Half the sides of a moving plane (m), so large that no body comes to its edge."""
SKIN = 0.05
"""Radius (m) of the spheres that stand for points, as the engine's contacts need bodies of some size."""


def surface(world: Any, number: int, restitution: float, friction: float) -> None:
    world.call("changeDynamics", number, -1, restitution=restitution, lateralFriction=friction)
    if "rigid_impact" in world.needs:
        world.extra("changeDynamics", IMPACT_BODY, number, -1)


def skin(body: Body) -> float:
    """SKIN for a point, and for a thin rod, whose ends are points; 0 for other bodies. Planes are set back by it."""
    return SKIN if body.radius == 0.0 or (body.half_extents and not any(body.half_extents[:2])) else 0.0


def touch(world: Any, number: int, body: Body, contacts: list[Contact]) -> None:
    """Give a body the coefficients of its contacts, and create the planes at rest. The engine multiplies coefficients."""
    for contact in contacts:
        if contact.partner and contact.partner not in world.planes:
            surface(world, number, sqrt(contact.restitution), sqrt(contact.friction))
            continue
        surface(world, number, contact.restitution, contact.friction)
        if contact.partner:
            continue
        if any(contact.velocity):
            world.planes[f"plane of {contact.body}"] = MovingPlane(world, contact.normal, velocity=contact.velocity)
            continue
        plane = world.create(0.0, world.shape_of("GEOM_PLANE", planeNormal=contact.normal))
        surface(world, plane, 1.0, 1.0)
        if back := skin(body):
            place = along(ORIGIN, contact.normal, -back)
            world.call("resetBasePositionAndOrientation", plane, place, IDENTITY)
        if contact.adhesive:
            world.chores.append(adhesive(world, number, plane))


def adhesive(world: Any, number: int, plane: int) -> Callable[[float], None]:
    """A function that fixes a body in its place by a constraint, once the engine reports a force of contact."""
    stuck: list[int] = []

    def stick(t: float) -> None:
        if stuck or not any(point[9] > 0 for point in world.call("getContactPoints", number, plane)):
            return
        position, attitude = world.pose(number)
        arguments = (number, -1, -1, -1, world.api.JOINT_FIXED, ORIGIN, ORIGIN, position, IDENTITY, attitude)
        stuck.append(world.call("createConstraint", *arguments))

    return stick


class MovingPlane:
    """The face of a heavy box, which is put in its place with its velocity before each step.

    In contacts the engine takes a static body, as its own plane is, for one at rest, whatever velocity it is given. A
    `rail` prescribes the motion of the box; a `velocity` is that of its surface alone, as of a belt.
    """

    def __init__(self, world: Any, normal: Vector, rail: Slider | None = None, velocity: Vector = ORIGIN) -> None:
        self.world, self.rail, self.velocity = world, rail, velocity
        self.number = world.create(HEAVY, world.shape_of("GEOM_BOX", halfExtents=HALF))
        surface(world, self.number, 1.0, 1.0)
        world.undamped(self.number, -1)
        world.record({"movingPlaneMass": HEAVY})
        self.origin = along(rail.anchor if rail else ORIGIN, normal, -HALF[2])
        x = unit(cross(normal, min(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), key=lambda axis: abs(dot(axis, normal)))))
        self.attitude = upright_to(x, normal)

    def put(self, coordinate: float, velocity: Vector) -> None:
        place = along(self.origin, self.rail.axis, coordinate) if self.rail else self.origin
        self.world.call("resetBasePositionAndOrientation", self.number, place, self.attitude)
        self.world.call("resetBaseVelocity", self.number, velocity, ORIGIN)

    def place(self, scene: Scene) -> None:
        self.fall = along(ORIGIN, scene.gravity, -self.world.dt)
        if self.rail is None or self.rail.drive is None:
            self.put(0.0, self.velocity)
        else:
            self.put(self.rail.drive(0.0), along(ORIGIN, self.rail.axis, self.rail.rate))

    def chore(self, t: float) -> None:
        """The velocity is that of the step's mean motion, less what gravity adds to it in the step."""
        if self.rail is None or self.rail.drive is None:
            self.put(0.0, along(self.velocity, self.fall, 1.0))
            return
        now, dt = self.rail.drive(t), self.world.dt
        self.put(now, along(self.fall, self.rail.axis, (self.rail.drive(t + dt) - now) / dt))

    def state(self) -> tuple[float, float]:
        assert self.rail is not None
        place = along(self.world.pose(self.number)[0], self.origin, -1.0)
        return dot(self.rail.axis, place), dot(self.rail.axis, self.world.twist(self.number)[0])

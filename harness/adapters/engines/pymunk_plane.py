"""The coordinate plane in which a scene moves: a planar engine runs the scene in it, and refuses other scenes."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import atan2, cos, sin

from gnomon.cases.core.scene import Quaternion, Scene, Vector
from gnomon.harness.adapters.engines.vectors import along
from gnomon.harness.contract.integrator import Refused

Pair = tuple[float, float]
ROUNDING = 1e-12
"""Components across the plane below this share of a vector come from rounding."""


@dataclass(frozen=True)
class Plane:
    """The plane across axis `normal`. Its axes follow in cyclic order, so that angles are positive about the normal."""

    normal: int

    def flat(self, vector: Vector) -> Pair:
        return vector[(self.normal + 1) % 3], vector[(self.normal + 2) % 3]

    def space(self, pair: Pair) -> Vector:
        x, y = pair
        return ((0.0, x, y), (y, 0.0, x), (x, y, 0.0))[self.normal]

    def spin(self, rate: float) -> Vector:
        """The vector of this length along the normal."""
        return ((rate, 0.0, 0.0), (0.0, rate, 0.0), (0.0, 0.0, rate))[self.normal]

    def attitude(self, angle: float) -> Quaternion:
        return (*self.spin(sin(angle / 2)), cos(angle / 2))

    def angle(self, attitude: Quaternion) -> float:
        return 2 * atan2(attitude[self.normal], attitude[3])

    def holds(self, vector: Vector) -> bool:
        """Whether the vector is in the plane."""
        return abs(vector[self.normal]) <= ROUNDING * max(map(abs, vector))

    def crosses(self, vector: Vector) -> bool:
        """Whether the vector is along the normal."""
        return max(map(abs, self.flat(vector))) <= ROUNDING * abs(vector[self.normal])


def turn_plane(vector: Pair, angle: float) -> Pair:
    """A vector of the plane turned by an angle."""
    c, s = cos(angle), sin(angle)
    return c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]


def plane_of(scene: Scene, first: int = 1) -> Plane:
    """The coordinate plane of a planar scene: all vectors lie in it, and all axes of rotation along its normal.

    If several planes are possible, the plane whose normal is axis `first`. Raises Refused if no plane is.
    """
    for plane in map(Plane, (first, 1, 2, 0)):
        if (
            all(map(plane.holds, _in_plane(scene)))
            and all(map(plane.crosses, _across(scene)))
            and _is_pulled_in_plane(scene, plane)
        ):
            return plane
    raise Refused("planar engine: the scene does not move in a coordinate plane")


def _in_plane(scene: Scene) -> Iterator[Vector]:
    yield scene.gravity
    for body in scene.bodies:
        yield from (body.position, body.velocity)
    for hinge in scene.hinges:
        yield from (hinge.anchor, hinge.arm)
    for slider in scene.sliders:
        yield from (slider.anchor, slider.axis)
    for contact in scene.contacts:
        yield from (contact.normal, contact.velocity)
    for rope in scene.ropes:
        yield rope.hole
    for impulse in scene.impulses:
        yield impulse.linear


def _across(scene: Scene) -> Iterator[Vector]:
    for hinge in scene.hinges:
        yield hinge.axis
    for body in scene.bodies:
        yield from (body.angular_velocity, body.quaternion[:3])
    for impulse in scene.impulses:
        yield impulse.angular


def _is_pulled_in_plane(scene: Scene, plane: Plane) -> bool:
    """Whether forces on free bodies are in the plane at the start, also with another velocity in it."""
    jointed = {joint.body for joint in scene.joints}
    bodies = {body.name: body for body in scene.bodies}
    for force in scene.forces:
        if force.body in jointed:
            continue
        body = bodies[force.body]
        place, velocity = body.position, body.velocity
        if force.partner:
            other = bodies[force.partner]
            place, velocity = along(place, other.position, -1.0), along(velocity, other.velocity, -1.0)
        faster = along(velocity, plane.space((1.0, 1.0)), 1.0)
        if not any(place):
            place = plane.space((1.0, 1.0))
        if not all(plane.holds(force.law(0.0, place, v)) for v in (velocity, faster)):
            return False
    return True

"""A scene as MJCF, the text that MuJoCo compiles: a frame for each body, at its centre of mass, and joints between frames."""

from collections.abc import Callable, Iterator
from math import atan2, exp, log, sqrt

from gnomon.cases.core.scene import Body, Contact, Hinge, Rope, Scene, Slider, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot

TINY = 2e-15
"""The engine refuses moments below 1e-15 (mjMINVAL). Beside the moment of a point mass about its joint this is rounding."""
PRESCRIBED = 1e12
"""Armature of a prescribed joint (kg): forces of a scene change its acceleration by about 1e-12 of it."""
FINE = 1e-9
"""Radius of the ends of a thin rod, as a share of its half length: a geom needs a positive size."""
TABLE = 10.0
"""Half width of the box that is a moving plane (m): the engine fixes planes to the world."""
LIGHT = f'diaginertia="{TINY!r} {TINY!r} {TINY!r}"'
AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def numbers(*values: float) -> str:
    """Values as text that reads back to the same doubles."""
    return " ".join(repr(float(value)) for value in values)


def moments(body: Body) -> Vector:
    """Positive moments with which the body moves as with its own: a thin rod never turns about its own axis."""
    largest = max(body.inertia) or TINY
    x, y, z = (moment or largest for moment in body.inertia)
    return x, y, z


def is_point(body: Body) -> bool:
    return not any(body.inertia) and body.radius is None and body.half_extents is None


def link(rope: Rope) -> str:
    """The name of the massless body between a hole and a body on a rope."""
    return f"link of {rope.body}"


def rebound(ratio: float) -> float:
    """The coefficient of restitution of a spring and damper with `ratio` of the critical damping.

    The contact ends when its force is zero, before the spring is relaxed (Schwager and Poschel, Granular Matter 9, 2007, 465).
    """
    if ratio < 1:
        root = sqrt(1 - ratio * ratio)
        return exp(-ratio / root * atan2(2 * ratio * root, 2 * ratio * ratio - 1))
    root = sqrt(ratio * ratio - 1)
    return exp(-ratio / root * log((ratio + root) / (ratio - root))) if root else exp(-2.0)


def damping_ratio(restitution: float) -> float:
    """The share of the critical damping that gives this coefficient of restitution, which is above 0."""
    low, high = 0.0, 1.0
    while rebound(high) > restitution:
        high *= 2
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if rebound(middle) > restitution else (low, middle)
    return high


class Model:
    """The text of a scene.

    `on_ball_joint`: the body is fixed at the origin. `chained`: each hinge carries the next one. `soft`: attributes of
    the constraints of ropes, for example their solref.

    A body on a rope has polar coordinates about the hole, in the plane in which it starts; an equality of two joints
    holds the length of a rope between two bodies.
    """

    def __init__(self, scene: Scene, on_ball_joint: bool, chained: bool, soft: str) -> None:
        self.scene, self.on_ball_joint, self.soft = scene, on_ball_joint, soft
        self.joints: dict[str, Hinge | Slider] = {joint.body: joint for joint in scene.joints}
        self.parents = {joint.body: joint.parent for joint in scene.joints if joint.parent}
        if chained:
            for inner, outer in zip(scene.hinges, scene.hinges[1:], strict=False):
                self.parents.setdefault(outer.body, inner.body)
        self.roped = {name for rope in scene.ropes for name in (rope.body, rope.other)}

    def text(self, option: str, attributes: Callable[[Contact], str]) -> str:
        """The model with this element `option`, and these attributes of its contacts."""
        bodies = "".join(self._body(body, ORIGIN) for body in self.scene.bodies if body.name not in self.parents)
        planes, pairs = self._contacts(attributes)
        return (
            f'<mujoco><compiler angle="radian" inertiafromgeom="false"/>{option}<worldbody>{planes}{bodies}</worldbody>'
            f"<contact>{pairs}</contact><equality>{self._equalities()}</equality></mujoco>"
        )

    def kind(self, body: Body) -> str:
        """How the body moves: `joint`, `rope`, `ball`, `slides` (a point without a joint) or `free`."""
        if body.name in self.joints:
            return "joint"
        if body.name in self.roped:
            return "rope"
        return "ball" if self.on_ball_joint else "slides" if is_point(body) else "free"

    def _body(self, body: Body, base: Vector) -> str:
        """The element of a body in the frame of its parent, whose centre of mass is at `base` at zero coordinates."""
        if self.kind(body) == "rope":
            return self._rope(body)
        place, joints = self._joints(body, base)
        # `place` sets the arms of a body on a ball joint; of a point it makes a body of twice the mass at half the arm
        mass, centre = body.mass, ORIGIN
        if self.kind(body) == "ball" and is_point(body):
            mass, centre = 2 * body.mass, (0.0, 0.0, -0.5)
        here = along(base, place, 1.0)
        carried = "".join(self._body(b, here) for b in self.scene.bodies if self.parents.get(b.name) == body.name)
        return (
            f'<body name="{body.name}" pos="{numbers(*place)}"><inertial pos="{numbers(*centre)}" mass="{numbers(mass)}"'
            f' diaginertia="{numbers(*moments(body))}"/>{joints}{self._geoms(body)}{carried}</body>'
        )

    def _joints(self, body: Body, base: Vector) -> tuple[Vector, str]:
        """The place of the body's frame, relative to `base`, and the elements of its joints."""
        joint, kind = self.joints.get(body.name), self.kind(body)
        if joint is not None:
            in_space = body.name in self.parents and not joint.parent
            anchor = along(joint.anchor, base, -1.0) if in_space else joint.anchor
            if isinstance(joint, Slider):
                armature = PRESCRIBED if joint.drive is not None else 0.0
                more = f'type="slide" armature="{numbers(armature)}"'
                return anchor, f'<joint name="{body.name}" {more} axis="{numbers(*joint.axis)}"/>'
            friction = f'frictionloss="{numbers(joint.friction)}" {self.soft.replace("=", "friction=")}'
            axis = f'pos="{numbers(*along(ORIGIN, joint.arm, -1.0))}" axis="{numbers(*joint.axis)}"'
            more = friction if joint.friction else ""
            return along(anchor, joint.arm, 1.0), f'<joint name="{body.name}" type="hinge" {axis} {more}/>'
        if kind == "slides":
            slides = (f'<joint type="slide" axis="{numbers(*axis)}"/>' for axis in AXES)
            return ORIGIN, "".join(slides)
        return ORIGIN, '<joint type="ball" pos="0 0 -1"/>' if kind == "ball" else "<freejoint/>"

    def _geoms(self, body: Body) -> str:
        """The shapes of a body that touches something; only the pairs that the scene declares collide."""
        apart = 'contype="0" conaffinity="0"'
        if body.half_extents is not None and not all(body.half_extents):
            return "".join(
                f'<geom name="{body.name} {end}" size="{numbers(FINE * max(body.half_extents))}"'
                f' pos="{numbers(*along(ORIGIN, body.half_extents, end))}" {apart}/>'
                for end in (-1, 1)
            )
        if body.half_extents is not None:
            return f'<geom name="{body.name}" type="box" size="{numbers(*body.half_extents)}" {apart}/>'
        if body.radius:
            return f'<geom name="{body.name}" size="{numbers(body.radius)}" {apart}/>'
        normal = next((each.normal for each in self.scene.contacts if each.partner == body.name), None)
        if normal is None:
            return ""
        place = numbers(*along(ORIGIN, normal, -TABLE))
        return f'<geom name="{body.name}" type="box" size="{numbers(TABLE, TABLE, TABLE)}" pos="{place}" zaxis="{numbers(*normal)}" {apart}/>'

    def _contacts(self, attributes: Callable[[Contact], str]) -> tuple[str, str]:
        planes, pairs = "", ""
        for number, (contact, names) in enumerate(self.touching()):
            if not contact.partner:
                normal = numbers(*contact.normal)
                planes += f'<geom name="plane {number}" type="plane" size="1 1 1" zaxis="{normal}" contype="0" conaffinity="0"/>'
            mu = contact.friction
            friction = f'condim="{3 if mu else 1}" friction="{numbers(mu, mu, 0, 0, 0)}"'
            for name in names:
                other = contact.partner or f"plane {number}"
                pairs += f'<pair geom1="{other}" geom2="{name}" {friction} {attributes(contact)}/>'
        return planes, pairs

    def touching(self) -> Iterator[tuple[Contact, list[str]]]:
        """Each contact with the names of its body's geoms."""
        bodies = {body.name: body for body in self.scene.bodies}
        for contact in self.scene.contacts:
            body = bodies[contact.body]
            if contact.body in self.roped:  # on a smooth table, in whose plane the rope turns
                continue
            thin = body.half_extents is not None and not all(body.half_extents)
            yield contact, [f"{body.name} {end}" for end in (-1, 1)] if thin else [body.name]

    def _rope(self, body: Body) -> str:
        """A body at a rope's end: on a rail along a link without mass, which turns about the hole; or hanging from it."""
        (number,) = (n for n, rope in enumerate(self.scene.ropes) if body.name in (rope.body, rope.other))
        rope, inertial = self.scene.ropes[number], f'<inertial pos="0 0 0" mass="{numbers(body.mass)}" {LIGHT}/>'
        slide = f'<joint name="{body.name}" type="slide"'
        hole = f'pos="{numbers(*rope.hole)}"'
        if body.name == rope.other:
            axis, pulley = numbers(*rope.axis), numbers(rope.inertia)
            return f'<body name="{body.name}" {hole}>{inertial}{slide} axis="{axis}" armature="{pulley}"/></body>'
        armature = 0.0 if rope.other else PRESCRIBED
        return (
            f'<body name="{link(rope)}" {hole}><inertial pos="0 0 0" mass="{TINY!r}" {LIGHT}/><joint name="{link(rope)}" axis="0 0 1"/>'
            f'<body name="{body.name}">{inertial}{slide} axis="1 0 0" armature="{numbers(armature)}"/></body></body>'
        )

    def _equalities(self) -> str:
        """The lengths of ropes between two bodies."""
        return "".join(
            f'<joint joint1="{rope.body}" joint2="{rope.other}" polycoef="{numbers(rope.length(0.0), -1, 0, 0, 0)}" {self.soft}/>'
            for rope in self.scene.ropes
            if rope.other
        )

"""A scene as MJCF, the text that MuJoCo compiles: a frame for each body, at its centre of mass, and joints between frames."""

from collections.abc import Callable, Iterator
from functools import partial
from operator import mul

from gnomon.cases.core.scene import Body, Contact, Hinge, Rope, Scene, Slider, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, dot

TINY = 2e-15
"""The engine refuses moments below 1e-15 (mjMINVAL). Beside the moment of a point mass about its joint this is rounding."""
PRESCRIBED = 1e12
"""Armature of a prescribed joint (kg): forces of a scene change its acceleration by about 1e-12 of it."""
FINE = 1e-9
"""Radius of the ends of a thin rod, as a share of its half length: a geom needs a positive size."""
TABLE = 100.0
"""Half width of the box that is a moving plane (m): the engine fixes planes to the world."""
LIGHT = f'diaginertia="{TINY!r} {TINY!r} {TINY!r}"'
APART = 'contype="0" conaffinity="0"'
"""Only the pairs that the scene declares collide."""
FOLLOWERS = {"other arm": 1.0, "link": 2.0}
"""The joints of a linkage and their angles over the angle of the arm."""
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


def table(name: str, normal: Vector) -> str:
    """A moving plane through the origin of its body: the upper face of a box."""
    size, place = numbers(TABLE, TABLE, TABLE), numbers(*along(ORIGIN, normal, -TABLE))
    return f'<geom name="{name}" type="box" size="{size}" pos="{place}" zaxis="{numbers(*normal)}" {APART}/>'


class Model:
    """The text of a scene.

    `tokens`: the needs of its form. `soft`: attributes of constraints other than contacts, for example their solref.

    A body on a rope has polar coordinates about the hole, in the plane in which it starts; an equality of two joints
    holds the length of a rope between two bodies. In a linkage equalities of joints let the other arm and the link to
    the sleeve follow the last hinge.
    """

    def __init__(self, scene: Scene, tokens: frozenset[str], soft: str) -> None:
        self.scene, self.soft, self.linked = scene, soft, "linkage" in tokens
        self.on_ball_joint = bool(tokens & {"ball_joint", "rod"})
        self.joints: dict[str, Hinge | Slider] = {joint.body: joint for joint in scene.joints}
        self.parents = {joint.body: joint.parent for joint in scene.joints if joint.parent}
        self.roped = {name for rope in scene.ropes for name in (rope.body, rope.other)}

    def text(self, option: str, attributes: Callable[[Contact], str]) -> str:
        """The model with this element `option`, and these attributes of its contacts."""
        bodies = "".join(self._body(body, ORIGIN) for body in self.scene.bodies if self._stands(body))
        planes, pairs = self._contacts(attributes)
        return (
            f'<mujoco><compiler angle="radian" inertiafromgeom="false"/>{option}<worldbody>{planes}{bodies}</worldbody>'
            f"<contact>{pairs}</contact><equality>{self._equalities()}</equality></mujoco>"
        )

    def prescribed(self) -> list[tuple[str, Callable[[float], float]]]:
        """The joints whose positions are given functions of time: sliders, lengths of ropes, moving planes."""
        planes = [(f"plane {n}", dot(c.velocity, c.velocity) ** 0.5) for n, c in enumerate(self.scene.contacts)]
        return [
            *((slider.body, slider.drive) for slider in self.scene.sliders if slider.drive is not None),
            *((rope.body, rope.length) for rope in self.scene.ropes if not rope.other),
            *((name, partial(mul, speed)) for name, speed in planes if speed),
        ]

    def kind(self, body: Body) -> str:
        """How the body moves: `joint`, `rope`, `sleeve`, `ball`, `slides` (a point) or `free`."""
        if body.name in self.joints:
            return "joint"
        if body.name in self.roped:
            return "rope"
        if self.linked:
            return "sleeve"
        return "ball" if self.on_ball_joint else "slides" if is_point(body) else "free"

    def _stands(self, body: Body) -> bool:
        """Whether no other body carries this one."""
        return body.name not in self.parents and self.kind(body) != "sleeve"

    def _body(self, body: Body, base: Vector) -> str:
        """The element of a body in the frame of its parent, whose centre of mass is at `base` at zero coordinates."""
        if self.kind(body) == "rope":
            return self._rope(body)
        place, joints = self._joints(body, base)
        # `place` sets the arms of a body on a ball joint; of a point it makes a body of twice the mass at half the arm
        mass, centre = body.mass, ORIGIN
        if self.kind(body) == "ball" and is_point(body):
            mass, centre = 2 * body.mass, (0.0, 0.0, -0.5)
        here, beside = along(base, place, 1.0), ""
        carried = "".join(self._body(b, here) for b in self.scene.bodies if self.parents.get(b.name) == body.name)
        if self.linked and body.name == self.scene.hinges[-1].body:
            carried += self._link(self.scene.hinges[-1])
            beside = self._other_arm(body, place, self.scene.hinges[-1])
        return beside + (
            f'<body name="{body.name}" pos="{numbers(*place)}"><inertial pos="{numbers(*centre)}" mass="{numbers(mass)}"'
            f' diaginertia="{numbers(*moments(body))}"/>{joints}{self._geoms(body)}{carried}</body>'
        )

    def _joints(self, body: Body, base: Vector) -> tuple[Vector, str]:
        """The place of the body's frame, relative to `base`, and the elements of its joints."""
        joint, kind = self.joints.get(body.name), self.kind(body)
        if joint is not None:
            if isinstance(joint, Slider):
                armature = PRESCRIBED if joint.drive is not None else 0.0
                more = f'type="slide" armature="{numbers(armature)}"'
                return joint.anchor, f'<joint name="{body.name}" {more} axis="{numbers(*joint.axis)}"/>'
            friction = f'frictionloss="{numbers(joint.friction)}" {self.soft.replace("=", "friction=")}'
            axis = f'pos="{numbers(*along(ORIGIN, joint.arm, -1.0))}" axis="{numbers(*joint.axis)}"'
            more = friction if joint.friction else ""
            return along(joint.anchor, joint.arm, 1.0), f'<joint name="{body.name}" type="hinge" {axis} {more}/>'
        if kind == "slides":
            return ORIGIN, "".join(f'<joint type="slide" axis="{numbers(*axis)}"/>' for axis in AXES)
        return ORIGIN, '<joint type="ball" pos="0 0 -1"/>' if kind == "ball" else "<freejoint/>"

    def _geoms(self, body: Body) -> str:
        """The shapes of a body that touches something."""
        if body.half_extents is not None and not all(body.half_extents):
            return "".join(
                f'<geom name="{body.name} {end}" size="{numbers(FINE * max(body.half_extents))}"'
                f' pos="{numbers(*along(ORIGIN, body.half_extents, end))}" {APART}/>'
                for end in (-1, 1)
            )
        if body.half_extents is not None:
            return f'<geom name="{body.name}" type="box" size="{numbers(*body.half_extents)}" {APART}/>'
        if body.radius:
            return f'<geom name="{body.name}" size="{numbers(body.radius)}" {APART}/>'
        normal = next((each.normal for each in self.scene.contacts if each.partner == body.name), None)
        return "" if normal is None else table(body.name, normal)

    def _contacts(self, attributes: Callable[[Contact], str]) -> tuple[str, str]:
        planes, pairs = "", ""
        for number, (contact, names) in enumerate(self.touching()):
            normal, speed = numbers(*contact.normal), dot(contact.velocity, contact.velocity) ** 0.5
            if speed:
                axis = numbers(*along(ORIGIN, contact.velocity, 1 / speed))
                slide = f'<joint name="plane {number}" type="slide" axis="{axis}" armature="{numbers(PRESCRIBED)}"/>'
                inertial = f'<inertial pos="0 0 0" mass="1" {LIGHT}/>'
                planes += f"<body>{inertial}{slide}{table(f'plane {number}', contact.normal)}</body>"
            elif not contact.partner:
                planes += f'<geom name="plane {number}" type="plane" size="1 1 1" zaxis="{normal}" {APART}/>'
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

    def _other_arm(self, ball: Body, place: Vector, hinge: Hinge) -> str:
        """The arm with its ball on the other side of the axis."""
        inertial = f'<inertial pos="0 0 0" mass="{numbers(ball.mass)}" {LIGHT}/>'
        return f'<body pos="{numbers(*place)}">{inertial}{_follower("other arm", hinge)}</body>'

    def _link(self, hinge: Hinge) -> str:
        """A link from a ball back to the axis, as long as the arm, with the sleeve at its end."""
        (sleeve,) = (body for body in self.scene.bodies if self.kind(body) == "sleeve")
        inertial = f'<inertial pos="0 0 0" mass="{numbers(max(sleeve.mass, TINY))}" {LIGHT}/>'
        return f'<body name="{sleeve.name}" pos="{numbers(*hinge.arm)}">{inertial}{_follower("link", hinge)}</body>'

    def _equalities(self) -> str:
        """The lengths of ropes between two bodies, and the angles of a linkage."""
        if self.linked:
            return "".join(
                f'<joint joint1="{name}" joint2="{self.scene.hinges[-1].body}" polycoef="{numbers(0, share, 0, 0, 0)}" {self.soft}/>'
                for name, share in FOLLOWERS.items()
            )
        return "".join(
            f'<joint joint1="{rope.body}" joint2="{rope.other}" polycoef="{numbers(rope.length(0.0), -1, 0, 0, 0)}" {self.soft}/>'
            for rope in self.scene.ropes
            if rope.other
        )


def _follower(name: str, hinge: Hinge) -> str:
    """A hinge that turns against this one."""
    place, axis = (numbers(*along(ORIGIN, each, -1.0)) for each in (hinge.arm, hinge.axis))
    return f'<joint name="{name}" pos="{place}" axis="{axis}"/>'

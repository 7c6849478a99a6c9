"""A scene as a tree of links, which every file format states in its own words.

The frame of a link lies in its joint; that of a free body in its centre of mass. At coordinate zero the axes of all links on
hinges and sliders are parallel to space. Parsers refuse a body without moments of inertia, so each point mass is replaced by
a rigid body that moves in the same way.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from gnomon.cases.core.case import Case
from gnomon.cases.core.scene import IDENTITY, Body, Hinge, Quaternion, Readings, Scene, Slider, Vector
from gnomon.cases.scenes.attitude import in_body, matrix
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot

STATED = frozenset(
    {
        *("gyroscopic", "hinge", "slider", "linked_joint", "chained_hinges", "ball_joint", "rod"),
        *("rigid_impact", "body_contact", "coulomb_isotropic"),
    }
)
"""What a tree can say. All else needs a law, a prescribed motion or a mechanism that is no joint."""
PIVOTED = frozenset({"ball_joint", "rod"})
"""The origin is a fixed point of the body."""
LAWS = ("forces", "torques", "impulses", "guides", "ropes")
"""The parts of a scene that no tree holds."""
LEAST = 2e-15
"""Moments (kg m^2) of a point mass on a hinge that moves; MuJoCo refuses moments below 1e-15."""
ROUNDING = 64 * 2.0**-52
"""A start is read back within a few roundings of its largest number."""


@dataclass(frozen=True)
class Link:
    """A link and the joint that carries it. `joint`: hinge, slider, ball or free; `parent`: "" for space.

    `place` and `attitude`: of the link's frame in that of the parent, at coordinate zero; of a ball or a free body at the
    start. `centre`: the centre of mass in the link's frame, along whose axes `inertia` has its principal moments. `point`:
    the place of the scene's body in the link's frame. Velocity (of `point`) and `spin` are in space.
    """

    name: str
    joint: str
    joint_name: str
    mass: float
    inertia: Vector
    parent: str = ""
    place: Vector = ORIGIN
    attitude: Quaternion = IDENTITY
    centre: Vector = ORIGIN
    point: Vector = ORIGIN
    axis: Vector = ORIGIN
    coordinate: float = 0.0
    rate: float = 0.0
    velocity: Vector = ORIGIN
    spin: Vector = ORIGIN
    radius: float | None = None
    half_extents: Vector | None = None
    replaced: str = ""
    """How the body differs from the scene's point mass; "" if it does not."""


@dataclass(frozen=True)
class Touch:
    """Two links touch, or a link and the plane through the origin with unit `normal` (`other` is "")."""

    link: str
    other: str
    normal: Vector
    restitution: float
    friction: float


@dataclass(frozen=True)
class Tree:
    """Links in a sequence in which every parent is before its children."""

    name: str
    gravity: Vector
    links: tuple[Link, ...]
    touches: tuple[Touch, ...]

    @property
    def planes(self) -> list[Vector]:
        """The normals of the planes."""
        return list(dict.fromkeys(touch.normal for touch in self.touches if not touch.other))

    def carried_by(self, parent: str) -> list[Link]:
        return [link for link in self.links if link.parent == parent]


def word(text: str) -> str:
    """A name for files and their elements: letters, digits and _."""
    return re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")


def readings_of(scene: Scene) -> Readings:
    """What an engine without error reads in the state of this scene."""
    joints = {hinge.name: (hinge.angle, hinge.rate) for hinge in scene.hinges}
    joints |= {slider.name: (slider.position, slider.rate) for slider in scene.sliders}
    held = {joint.body for joint in scene.joints}
    bodies = {
        body.name: (body.position, body.quaternion, body.velocity, body.angular_velocity)
        for body in scene.bodies
        if body.name not in held
    }
    return Readings(joints, bodies)


def tree_of(case: Case) -> Tree:
    """The scene of a case, with numbers rounded to binary64, in its start. Raises ValueError if it is no tree of rigid links."""
    form = case.scene
    assert form is not None
    state = tuple(map(float, case.initial_state))
    parameters = tuple(map(float, case.parameter_values()))
    scene, at_zero = form.build(state, parameters), form.build((0.0,) * len(state), parameters)
    if unnamed := [name for name in LAWS if getattr(scene, name)]:
        raise ValueError(f"{case.id}: its scene has {', '.join(unnamed)}, which its tokens do not name")
    observed = form.observe(readings_of(scene), parameters)
    size = max(map(abs, (*state, 1.0, *(x for body in scene.bodies for x in (*body.velocity, *body.angular_velocity)))))
    if any(abs(a - b) > ROUNDING * size for a, b in zip(observed, state, strict=True)):
        raise ValueError(
            f"{case.id}: its start is no state of rigid bodies, for example its attitude is not a rotation"
        )
    links: dict[str, Link] = {}
    bodies, first = {body.name: body for body in scene.bodies}, {body.name: body for body in at_zero.bodies}
    for joint in _parents_first(scene):
        links[joint.body] = _add_joint(bodies[joint.body], joint, links)
    for name, body in bodies.items():
        if name not in links:
            links[name] = _add_pivot(body, first[name]) if form.needs & PIVOTED else _free(body)
    renamed = tuple(
        replace(link, name=word(link.name), joint_name=word(link.joint_name), parent=word(link.parent))
        for link in links.values()
    )
    touches = tuple(
        Touch(word(each.body), word(each.partner), each.normal, each.restitution, each.friction)
        for each in scene.contacts
    )
    return Tree(word(case.id), scene.gravity, renamed, touches)


def _parents_first(scene: Scene) -> list[Hinge | Slider]:
    """The joints, each after the one that carries its parent."""
    waiting: list[Hinge | Slider] = [*scene.sliders, *scene.hinges]
    ordered: list[Hinge | Slider] = []
    known = {""}
    while waiting:
        ready = [joint for joint in waiting if joint.parent in known]
        if not ready:
            raise ValueError(
                f"joint {waiting[0].name}: its parent {waiting[0].parent} hangs from no joint of the scene"
            )
        ordered += ready
        known |= {joint.body for joint in ready}
        waiting = [joint for joint in waiting if joint not in ready]
    return ordered


def _add_joint(body: Body, joint: Hinge | Slider, links: Mapping[str, Link]) -> Link:
    parent, place = joint.parent, joint.anchor
    if body.quaternion != IDENTITY:
        raise ValueError(f"{body.name}: on joint {joint.name} its axes are not parallel to space at coordinate zero")
    if parent:
        place = along(links[parent].point, joint.anchor, 1.0)
    if isinstance(joint, Slider):
        link = Link(body.name, "slider", joint.name, body.mass, body.inertia, parent, place)
        return _without_turning(replace(link, axis=joint.axis, coordinate=joint.position, rate=joint.rate))
    link = Link(
        body.name, "hinge", joint.name, body.mass, body.inertia, parent, place, centre=joint.arm, point=joint.arm
    )
    link = replace(link, axis=joint.axis, coordinate=joint.angle, rate=joint.rate)
    lever = cross(joint.axis, joint.arm)
    return _with_least(link, lever) if parent else _halve_arm(link, lever)


def _add_pivot(body: Body, at_zero: Body) -> Link:
    """A body on a ball joint in the origin. A point mass has its axes in space at the start."""
    link = Link(body.name, "ball", f"{body.name} joint", body.mass, body.inertia, attitude=body.quaternion)
    link = replace(link, velocity=body.velocity, spin=body.angular_velocity)
    if any(body.inertia):
        # The fixed point is a point of the body: in state zero, where axes are parallel to space, the arm has no rounding.
        arm = in_body(matrix(at_zero.quaternion), at_zero.position)
        return replace(link, centre=arm, point=arm)
    x = body.position
    spin = along(ORIGIN, cross(x, body.velocity), 1 / dot(x, x))
    return _halve_arm(replace(link, centre=x, point=x, spin=spin), x)


def _free(body: Body) -> Link:
    link = Link(body.name, "free", f"{body.name} joint", body.mass, body.inertia, "", body.position, body.quaternion)
    shape = replace(link, radius=body.radius, half_extents=body.half_extents)
    return _without_turning(replace(shape, velocity=body.velocity, spin=body.angular_velocity))


def _halve_arm(link: Link, lever: Vector) -> Link:
    """Twice the mass at half the arm, and the moment m L^2/2 about its centre in every direction; L is the lever.

    Equal to the point mass in what moves it: first moment 2m r/2, and moment about the pivot 2m (L/2)^2 + m L^2/2 = m L^2. On
    a ball joint also the moment about the arm is m L^2/2, but there the spin is zero and stays zero.
    """
    if any(link.inertia):
        return link
    moment = link.mass * dot(lever, lever) / 2
    half = along(ORIGIN, link.centre, 0.5)
    note = f"{link.name}: a point mass m at distance L is twice the mass at L/2 with moments m L^2/2: the same motion"
    return replace(link, mass=2 * link.mass, centre=half, inertia=(moment,) * 3, replaced=note)


def _without_turning(link: Link) -> Link:
    """Moments of 1 kg m^2 for 1 kg: no torque acts on the point mass, and its attitude is not read."""
    if any(link.inertia):
        return link
    note = (
        f"{link.name}: a point mass has moments of 1 m^2 times its mass: it does not turn, so that they have no effect"
    )
    return replace(link, inertia=(link.mass,) * 3, replaced=note)


def _with_least(link: Link, lever: Vector) -> Link:
    """A point mass on a hinge that moves: a body with larger moments has another motion."""
    if any(link.inertia):
        return link
    share = LEAST / (link.mass * dot(lever, lever))
    note = (
        f"{link.name}: a point mass has moments of {LEAST} kg m^2, as parsers refuse zero: not exact, {share:.0e} of its"
        " moment about the hinge"
    )
    return replace(link, inertia=(LEAST,) * 3, replaced=note)

"""A space of pymunk with the bodies, joints and contacts of a scene, and nothing else.

The engine corrects the error of a joint in one step (`error_bias` 0) and that of a contact never (`collision_bias` 1: its
correction adds speed to a body that bounces). The default leaves 90 % of both after 1/60 s, whatever the step. A point
mass on a hinge is a body without rotation on a pin joint, the rod, so it needs no inertia. Restitution and friction are
products of the coefficients of two surfaces.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import hypot, inf, sqrt
from typing import Any

from gnomon.cases.core.scene import Body, Contact, Hinge, Scene, Slider, Vector
from gnomon.harness.adapters.engines.pymunk_plane import Pair, Plane
from gnomon.harness.adapters.engines.vectors import ORIGIN, along
from gnomon.harness.contract.integrator import Refused

REACH, DEPTH = 1e4, 1.0
"""A plane is a rounded segment of this half length and radius (m): below a thin one a fast body would pass."""
RAIL = 1e5
"""The half length of a rail (m), times 1 + |position| + |rate|: a longer one loses digits across."""
ITERATIONS = 100
"""With the default of 10 a block that touches two planes with friction errs at every step size."""


@dataclass
class Part:
    """A body in the engine. `tip`: the place of the scene's body in it, its centre of mass unless it was replaced."""

    body: Any
    tip: Pair = (0.0, 0.0)


class Built:
    """The space of a scene in a plane.

    Attributes
    ----------
    parts : dict
        The bodies.
    parents : dict
        For each joint the body that carries it, or "", and its anchor.
    drives : list
        Functions of the time at the start of a step, which set what is prescribed for it.
    rods, grooves : list, dict
        Constraints whose lengths depend on the initial state.
    """

    def __init__(
        self, pymunk: Any, scene: Scene, plane: Plane, dt: float, rod: bool, options: dict[str, Any] | None
    ) -> None:
        """Options that are set are added to `options`; None: the engine keeps its defaults."""
        if any(rope.other for rope in scene.ropes):
            raise Refused("no joint for a rope through a hole to a second body")
        self.api, self.plane, self.dt, self.options = pymunk, plane, dt, options
        self.space = pymunk.Space()
        self.space.gravity = plane.flat(scene.gravity)
        self.parents = {joint.name: (joint.parent, joint.anchor) for joint in scene.joints}
        self.joints: dict[str, Hinge | Slider] = {joint.body: joint for joint in scene.joints}
        self.drives: list[Callable[[float], None]] = []
        self.rods: list[Any] = []
        self.grooves: dict[str, Any] = {}
        self.parts = {body.name: self._body(body) for body in scene.bodies}
        self.wheels = [part for part in self.parts.values() if any(part.tip)]
        for joint in scene.joints:
            self._join(joint)
        self._tie(scene, rod)
        for contact in scene.contacts:
            self._touch(contact, {body.name: body for body in scene.bodies})
        if options is not None and scene.contacts:
            self.space.collision_bias = options["collision_bias"] = 1.0
        if options is not None and (scene.contacts or scene.joints):
            self.space.iterations = options["iterations"] = ITERATIONS

    def _body(self, body: Body) -> Part:
        joint, moment, mass = self.joints.get(body.name), body.inertia[self.plane.normal], body.mass
        tip = (0.0, 0.0)
        if isinstance(joint, Slider):
            moment = inf
        elif isinstance(joint, Hinge) and not moment and joint.friction:
            # Friction of a hinge needs a body that turns: a wheel on the axle with the point's moment of inertia, at
            # whose rim all forces on the point act, its weight too. About a fixed axle both turn alike.
            tip = self.plane.flat(joint.arm)
            moment = mass * (tip[0] ** 2 + tip[1] ** 2)
        kind = self.api.Body.DYNAMIC
        if isinstance(joint, Slider) and joint.drive and not joint.parent:
            kind = self.api.Body.KINEMATIC
        solid = self.api.Body(mass, moment or inf, kind)
        self.space.add(solid)
        return Part(solid, tip)

    def _join(self, joint: Hinge | Slider) -> None:
        """The joint of a body to its parent, or to the static body."""
        part, plane = self.parts[joint.body], self.plane
        parent, anchor = self.parents[joint.name]
        base = self.parts[parent].body if parent else self.space.static_body
        start = plane.flat(anchor)
        if isinstance(joint, Hinge):
            arm = plane.flat(joint.arm)
            if part.body.moment == inf:
                self._add(self.api.PinJoint(base, part.body, start, (0.0, 0.0))).distance = hypot(*arm)
            else:
                self._add(self.api.PivotJoint(base, part.body, start, (part.tip[0] - arm[0], part.tip[1] - arm[1])))
            if joint.friction:
                self._add(self.api.SimpleMotor(base, part.body, 0.0)).max_force = joint.friction
        elif joint.drive is None:
            self.grooves[joint.name] = self._add(self.api.GrooveJoint(base, part.body, start, start, (0.0, 0.0)))
        else:
            self._drive(joint, base, parent, anchor)

    def _drive(self, rail: Slider, base: Any, parent: str, anchor: Vector) -> None:
        """A body on a driven rail: kinematic in space, on a parent a pivot whose anchor moves along the rail."""
        at, body, plane, dt = rail.drive, self.parts[rail.body].body, self.plane, self.dt
        assert at is not None
        if not parent:

            def carry(t: float) -> None:
                body.velocity = plane.flat(along(ORIGIN, rail.axis, (at(t + dt) - at(t)) / dt))

            self.drives.append(carry)
            return
        pivot = self._add(self.api.PivotJoint(base, body, plane.flat(anchor), (0.0, 0.0)))

        def shift(t: float) -> None:
            # The solver gives the velocity with which the next drift, to t + 2 dt, reaches the anchor.
            pivot.anchor_a = plane.flat(along(anchor, rail.axis, at(t + 2 * dt)))

        self.drives.append(shift)

    def _tie(self, scene: Scene, rod: bool) -> None:
        """A rod from the origin (token `rod`), and ropes from a hole, which hold by their length."""
        if rod:
            static = self.space.static_body
            self.rods = [self._add(self.api.PinJoint(static, self.parts[b.name].body)) for b in scene.bodies]
        for rope in scene.ropes:
            self._hang(self.parts[rope.body].body, self.plane.flat(rope.hole), rope.length)

    def _hang(self, body: Any, hole: Pair, length: Callable[[float], float]) -> None:
        slide = self._add(self.api.SlideJoint(self.space.static_body, body, hole, (0.0, 0.0), 0.0, length(0.0)))

        def shorten(t: float) -> None:
            slide.max = length(t + 2 * self.dt)

        self.drives.append(shorten)

    def _add(self, constraint: Any) -> Any:
        if self.options is not None:
            constraint.error_bias = self.options["error_bias"] = 0.0
        self.space.add(constraint)
        return constraint

    def _touch(self, contact: Contact, bodies: dict[str, Body]) -> None:
        """Two shapes that touch: a body and a plane, or two bodies. The engine multiplies their coefficients."""
        body, partner = bodies[contact.body], bodies.get(contact.partner)
        if partner is not None and partner.radius is not None:
            for each in (body, partner):
                self._shape(each, sqrt(contact.restitution), sqrt(contact.friction))
            return
        shape = self._shape(body, contact.restitution, contact.friction)
        ground = self.space.static_body if partner is None else self.parts[partner.name].body
        normal = self.plane.flat(contact.normal)
        ends = [(-DEPTH * normal[0] - s * normal[1], -DEPTH * normal[1] + s * normal[0]) for s in (-REACH, REACH)]
        plane = self.api.Segment(ground, *ends, DEPTH)
        own = shape.elasticity
        plane.elasticity, plane.friction = contact.restitution / own if own else 0.0, 1.0
        plane.surface_velocity = self.plane.flat(contact.velocity)
        self.space.add(plane)
        if contact.adhesive:
            shape.collision_type, plane.collision_type = 1, 2
            self.space.on_collision(1, 2, begin=self._stick)

    def _shape(self, body: Body, restitution: float, friction: float) -> Any:
        """The shape of a body, made once: a circle, a box, or for a thin rod a segment."""
        solid = self.parts[body.name].body
        if solid.shapes:
            return next(iter(solid.shapes))
        if body.half_extents is not None:
            a, b = self.plane.flat(body.half_extents)
            corners = [(a, b), (-a, b), (-a, -b), (a, -b)]
            shape = self.api.Poly(solid, corners) if a and b else self.api.Segment(solid, (-a, -b), (a, b), 0.0)
        elif body.radius is not None:
            shape = self.api.Circle(solid, body.radius)
        else:
            raise Refused("points without a radius do not touch")
        shape.elasticity, shape.friction = restitution, friction
        self.space.add(shape)
        return shape

    def _stick(self, arbiter: Any, space: Any, data: Any) -> None:
        """A joint at the first contact, as in Chipmunk's own example of sticky surfaces."""
        a, b = (shape.body for shape in arbiter.shapes)
        space.add_post_step_callback(lambda *_: self._add(self.api.PivotJoint(a, b, tuple(a.position))), a)

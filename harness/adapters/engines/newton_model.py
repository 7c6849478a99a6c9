"""A model of Newton that holds one scene: only the bodies, joints and contacts that the scene declares."""

from collections.abc import Callable
from typing import Any

from gnomon.cases.core.scene import Body, Contact, Hinge, Rope, Scene, Slider, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, dot, rotate, vector
from gnomon.harness.contract.integrator import Refused

STAND_IN = 0.1
"""A point on a plane is a sphere of this radius (m), with the plane as far below."""
POINT_MOMENT = 1e12
"""The moment of a free point over its mass (m^2); it does not change the motion of the centre of mass."""


class Part:
    """A body in the engine, and the body of the scene whose motion it gives.

    A point mass m on a hinge or ball joint with arm L becomes a body of mass m at L/2 with the moment m L^2/4. Its moment
    about the joint is m L^2/2; weight, forces and blows have half of their lever, and torques are halved: the equation of
    motion is halved. The joint must be fixed in space and carry nothing else, because the load on it differs.
    """

    def __init__(self, body: Body, joint: Hinge | Slider | None = None, share: float = 1.0) -> None:
        self.body, self.joint, self.share = body, joint, share
        self.ball = False
        self.pivot = joint.anchor if joint is not None and share < 1 else ORIGIN
        self.number = self.q = self.qd = -1
        self.drive: Callable[[float], Vector] | None = None

    def motion(self, pose: list[float], twist: list[float]) -> tuple[Vector, Vector]:
        if self.share == 1.0:
            return vector(pose), vector(twist)
        lever = along(vector(pose), self.pivot, -1.0)
        return along(self.pivot, lever, 1 / self.share), along(ORIGIN, vector(twist), 1 / self.share)


class Assembly:
    """The parts of a scene, and the model made of them.

    `chosen(**settings)` gives those of the settings that are to be set; `reduced`: the solver moves coordinates of joints;
    `springs`: the coefficients of contacts that the solver uses.
    """

    def __init__(
        self,
        scene: Scene,
        needs: frozenset[str],
        dt: float,
        chosen: Callable[..., dict[str, Any]],
        *,
        reduced: bool,
        springs: tuple[str, ...],
    ) -> None:
        import newton  # optional, and slow: 6 s
        import warp

        self.newton, self.warp, self.needs, self.dt = newton, warp, needs, dt
        self.chosen, self.reduced, self.springs = chosen, reduced, springs
        self.parts: dict[str, Part] = {}
        self.light = float("inf")
        """The least effective mass that a joint holds: kg, or kg m^2 where it holds an attitude."""
        self.builder = newton.ModelBuilder(gravity=warp.vec3(*scene.gravity))
        joints: dict[str, Hinge | Slider] = {joint.body: joint for joint in scene.joints}
        parents = {joint.parent for joint in joints.values()}
        jointed = [body for body in scene.bodies if self._holds(joints.get(body.name))]
        numbers = [self._link(body, joints.get(body.name), body.name in parents) for body in jointed]
        if numbers:
            self.builder.add_articulation(numbers)
        for body in scene.bodies:
            if body.name not in self.parts:
                self._free(body, joints.get(body.name))
        for contact in scene.contacts:
            self._touch(contact)
        for rope in scene.ropes:
            self._tie(rope)
        self.builder.color()  # SolverVBD moves the bodies of one colour at a time; the other solvers do not look
        self.model = self.builder.finalize(**chosen(skip_validation_inertia=True))

    def _holds(self, joint: Hinge | Slider | None) -> bool:
        if joint is None:
            return bool(self.needs & {"ball_joint", "rod"})
        return not (isinstance(joint, Slider) and joint.drive)

    def _link(self, body: Body, joint: Hinge | Slider | None, carries: bool) -> int:
        """Add a body with its joint, whose number is returned."""
        inertia, share, arm = body.inertia, 1.0, ORIGIN
        if joint is None:
            x, y, z, w = body.quaternion
            arm = rotate((-x, -y, -z, w), body.position)
        elif isinstance(joint, Hinge):
            arm = joint.arm
            own = sum(i * a * a for i, a in zip(inertia, joint.axis, strict=True))
            if not joint.parent and own:  # a fixed hinge takes all torques but one: the other moments are free
                inertia = (own, own, own)
        if not any(inertia) and not carries and not isinstance(joint, Slider) and not (joint and joint.parent):
            share = 0.5
            inertia = (body.mass * dot(arm, arm) / 4,) * 3
        elif isinstance(joint, Hinge) and not all(inertia) and not self.reduced:
            raise Refused(
                "coordinates of bodies: a body without inertia, such as a point mass, does not turn on a hinge"
            )
        arm = along(ORIGIN, arm, share)
        parent = self.parts[joint.parent] if joint and joint.parent else None
        number = self._add(Part(body, joint, share), self.builder.add_link, inertia)
        frame, turn, axis = self.warp.transform, self.warp.quat_identity(), joint.axis if joint else ORIGIN
        if (
            sum(map(bool, axis)) > 1
        ):  # XPBD frees whole coordinates of the frame of a joint: one is turned along the axis
            turn, axis = (
                self.warp.quat_between_vectors(self.warp.vec3(1.0, 0.0, 0.0), self.warp.vec3(*axis)),
                (1.0, 0.0, 0.0),
            )
        anchor = joint.anchor if joint else ORIGIN
        ends = {
            "parent_xform": frame(self.warp.vec3(*anchor), turn),
            "child_xform": frame(self.warp.vec3(*along(ORIGIN, arm, -1.0)), turn),
        }
        at = parent.number if parent else -1
        yields = 1 / body.mass + (dot(arm, arm) / max(inertia) if any(inertia) else 0.0)
        yields += 1 / parent.body.mass if parent else 0.0
        self.light = min(self.light, 1 / yields, *(i for i in inertia if i))
        if joint is None:
            self.parts[body.name].ball = True
            added = self.builder.add_joint_ball(at, number, **ends)
        else:
            hinge = isinstance(joint, Hinge)
            add = self.builder.add_joint_revolute if hinge else self.builder.add_joint_prismatic
            added = add(at, number, axis=self.warp.vec3(*axis), **ends)
        self._indexed(self.parts[body.name])
        return int(added)

    def _free(self, body: Body, joint: Hinge | Slider | None = None) -> Part:
        """A body with six degrees of freedom; the attitude of a point is of no interest. Or one that is driven."""
        part = Part(body, joint)
        if isinstance(joint, Slider) and joint.drive:
            if joint.parent:
                raise Refused("prescribes the motion only of bodies that no moving body carries")
            rail, drive = joint, joint.drive
            part.drive = lambda t: along(rail.anchor, rail.axis, drive(t))
        # A thin rod and a point have no spin where their moment is 0. That of a point is large, because it must not drown in
        # mass times distance squared, which the mass matrix of float32 holds.
        spare = max(body.inertia) or POINT_MOMENT * body.mass
        a, b, c = body.inertia
        moment = a or spare, b or spare, c or spare
        self._add(part, self.builder.add_body, moment, is_kinematic=part.drive is not None)
        self._indexed(part)
        return part

    def _add(self, part: Part, add: Callable[..., int], inertia: Vector, **more: Any) -> int:
        body, (a, b, c) = part.body, inertia
        frame = self.warp.transform(self.warp.vec3(*body.position), self.warp.quat(*body.quaternion))
        tensor = self.warp.mat33(a, 0.0, 0.0, 0.0, b, 0.0, 0.0, 0.0, c)
        part.number = add(xform=frame, mass=body.mass, inertia=tensor, label=body.name, lock_inertia=True, **more)
        self.parts[body.name] = part
        return part.number

    def _indexed(self, part: Part) -> None:
        part.q, part.qd = self.builder.joint_q_start[-1], self.builder.joint_qd_start[-1]

    def _touch(self, contact: Contact) -> None:
        """Shapes for a contact. The engine takes the mean of the coefficients of both shapes."""
        body = self.parts[contact.body].body
        points = 4 if body.half_extents else 1
        config = self.newton.ModelBuilder.ShapeConfig(mu=contact.friction, restitution=contact.restitution)
        # Stiffness follows the step: 12 steps a period; damping acts while bodies approach; a slip ends within steps.
        rate = 0.5 / self.dt
        stiff = {
            "ke": body.mass * rate**2 / points,
            "kd": body.mass * rate / points,
            "kf": body.mass * rate / 2 / points,
        }
        settings = {name: stiff[name] for name in self.springs}
        for name, value in self.chosen(mu_torsional=0.0, mu_rolling=0.0, **settings).items():
            setattr(config, name, value)
        self._shape(body, config)
        # Spheres stand for a point and for the ends of a rod: the plane is as far below as their radius.
        depth, at = 0.0 if body.radius or all(body.half_extents or (0.0,)) else STAND_IN, -1
        if contact.partner:
            partner = self.parts[contact.partner]
            if partner.body.radius:
                self._shape(partner.body, config)
                return
            at = partner.number
        elif any(contact.velocity):  # the engine keeps the pose and the velocity of such a body
            belt = Part(Body(f"under {body.name}", 1.0, ORIGIN, velocity=contact.velocity))
            at = self._add(belt, self.builder.add_body, ORIGIN, is_kinematic=True)
            self._indexed(belt)
        self.builder.add_shape_plane((*contact.normal, depth), width=0.0, length=0.0, body=at, cfg=config)

    def _shape(self, body: Body, config: Any) -> None:
        number = self.parts[body.name].number
        if self.builder.body_shapes.get(number):
            return
        if body.half_extents and all(body.half_extents):
            a, b, c = body.half_extents
            self.builder.add_shape_box(number, hx=a, hy=b, hz=c, cfg=config)
            return
        ends = body.half_extents or ORIGIN
        for end in dict.fromkeys((ends, along(ORIGIN, ends, -1.0))):
            at = self.warp.transform(self.warp.vec3(*end), self.warp.quat_identity())
            self.builder.add_shape_sphere(number, xform=at, radius=body.radius or STAND_IN, cfg=config)

    def _tie(self, rope: Rope) -> None:
        """A tendon through a hole without friction. A rope without another end is pulled by a driven body below the hole."""
        newton = self.newton
        if rope.other:
            end = self.parts[rope.other]
        else:
            body = Body(f"puller of {rope.body}", 1.0, ORIGIN, along(rope.hole, rope.axis, 1.0))
            end = self._free(
                body, Slider(body.name, body.name, body.position, rope.axis, 0.0, 0.0, drive=_make_pull(rope.length))
            )
        guides = (
            (self.parts[rope.body].number, "ANCHOR", ORIGIN),
            (-1, "PINHOLE", rope.hole),
            (end.number, "ANCHOR", ORIGIN),
        )
        # Without compliance a rope that moves through the hole sticks there; the shorter the step, the less it yields.
        yields = self.chosen(compliance=self.dt / (4 * self.parts[rope.body].body.mass)) if rope.other else {}
        self.builder.add_tendon(
            [
                newton.TendonGuide(
                    body=number,
                    guide_type=newton.TendonGuideType[kind],
                    offset=self.warp.vec3(*at),
                    **(yields if place else {}),
                )
                for place, (number, kind, at) in enumerate(guides)
            ]
        )


def _make_pull(length: Callable[[float], float]) -> Callable[[float], float]:
    return lambda t: length(0.0) - length(t)

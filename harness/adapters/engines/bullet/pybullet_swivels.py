"""Bodies that turn about a fixed point in PyBullet: ball joints, rods and ropes, as revolutes and a rail in one multibody.

The engine's own ball joint has more error for a fast top, and its energy grows at |w| dt = 0.4: see `Swivel`. A rod or a
rope is a rail along the line from the pivot, whose coordinate a motor or a gear prescribes; both keep it to rounding.
"""

from collections.abc import Callable
from math import atan2, cos, sin
from typing import Any

from gnomon.cases.core.scene import Body, Quaternion, Rope, Scene, Vector
from gnomon.harness.adapters.engines.bullet.pybullet_joints import Link, Motion, Multibody
from gnomon.harness.adapters.engines.vectors import (
    ORIGIN,
    along,
    cross,
    dot,
    inverse,
    rotate,
    times,
    turn_arm,
    unit,
    upright_to,
)

AXES: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
SINGULAR = 0.7
"""Two axes of rotation that are nearer than this (sine of the angle) are chosen anew: at zero the middle one is lost."""
PLANE = 1e-20
"""Below this share of its largest square, the angular momentum has no direction but that of rounding."""


def across(vector: Vector) -> Vector:
    """A unit vector at a right angle to a unit vector."""
    return unit(cross(vector, min(AXES, key=lambda axis: abs(dot(axis, vector)))))


class Pointer:
    """A point mass at the end of a straight line from a pivot: two revolutes and a rail.

    The first axis is that of the angular momentum at the start, so that a plane motion stays far from the singular
    position, in which the line is along the first axis. With a `normal` the line stays in a plane (one revolute), with a
    `line` it has a fixed direction (a rail alone).
    """

    def __init__(
        self,
        world: Any,
        body: Body,
        pivot: Vector = ORIGIN,
        *,
        normal: Vector | None = None,
        line: Vector | None = None,
    ) -> None:
        self.world, self.pivot, self.normal, self.line = world, pivot, normal, line
        self.wheel: Multibody | None = None
        axes = () if line else (AXES[2],) if normal else (AXES[2], AXES[1])
        links = [Link(axis, before=n - 1) for n, axis in enumerate(axes)]
        self.end = len(links)
        self.multibody = Multibody(
            world, [*links, Link(AXES[0], slides=True, before=self.end - 1, mass=body.mass)], pivot
        )

    def place(self, body: Body) -> None:
        self._set(body.position, body.velocity)

    def _set(self, position: Vector, velocity: Vector) -> None:
        arm = along(position, self.pivot, -1.0)
        toward = self.line or unit(arm)
        momentum = self.normal or cross(arm, velocity)
        if self.line or (
            not self.normal and dot(momentum, momentum) <= PLANE * dot(arm, arm) * dot(velocity, velocity)
        ):
            momentum = across(toward)
        aside = unit(cross(momentum, toward))
        normal = cross(toward, aside)
        distance = dot(arm, toward)
        self.multibody.turn_base(upright_to(toward, normal))
        turns = () if self.line else ((0.0, dot(velocity, aside) / distance), (0.0, -dot(velocity, normal) / distance))
        along_line = distance, dot(velocity, toward)
        self.multibody.set_state(*turns[: self.end], along_line)
        if self.wheel:
            self.wheel.set_state(along_line)

    def keep(self, t: float) -> None:
        """Choose new axes where the present ones are nearly singular."""
        if self.end == 2 and abs(cos(self.world.joint_state(self.multibody.number, 1)[0])) < SINGULAR:
            position, _, velocity, _ = self.motion()
            self._set(position, velocity)

    def motion(self) -> Motion:
        return self.multibody.motion(self.end)


class Swivel:
    """A rigid body on a ball joint: three revolutes, the last one along the principal axis of the body nearest to the arm.

    So the large spin of a top is one coordinate, and exact. The first axis is at a right angle to it at the start, and is
    chosen anew where the two come near one another. On the heavy top of 40 rad/s the axis errs by 0.010 at 1e-3 s, on the
    engine's ball joint by 0.070; a vertical first axis gives 0.007, but seven times the error of a top that rises to the
    vertical.
    """

    def __init__(self, world: Any, body: Body) -> None:
        self.world = world
        arm = rotate(inverse(body.quaternion), body.position)
        self.spun = max(range(3), key=lambda axis: abs(arm[axis]))
        self.tilted = (self.spun + 1) % 3
        first, second = AXES[self.spun], AXES[self.tilted]
        last = Link(first, before=1, arm=arm, mass=body.mass, inertia=body.inertia)
        self.multibody = Multibody(world, [Link(first), Link(second, before=0), last])

    def place(self, body: Body) -> None:
        self._set(body.quaternion, body.angular_velocity)

    def _set(self, attitude: Quaternion, spin: Vector) -> None:
        b = rotate(attitude, AXES[self.spun])
        first = across(b)
        middle = unit(cross(first, b))
        sine, cosine = dot(cross(first, b), middle), dot(first, b)
        axes = [ORIGIN] * 3
        axes[self.spun], axes[self.tilted], axes[(self.spun + 2) % 3] = first, middle, cross(first, middle)
        base = upright_to(axes[0], axes[2])
        tilt = atan2(sine, cosine)
        rest = times(inverse(times(base, turn_arm(AXES[self.tilted], ORIGIN, tilt)[0])), attitude)
        outer, inner = dot(spin, first), dot(spin, b)
        self.multibody.turn_base(base)
        self.multibody.set_state(
            (0.0, (outer - inner * cosine) / sine**2),
            (tilt, dot(spin, middle)),
            (2 * atan2(rest[self.spun], rest[3]), (inner - outer * cosine) / sine**2),
        )

    def keep(self, t: float) -> None:
        """Choose new axes where the present ones are nearly singular."""
        if abs(sin(self.world.joint_state(self.multibody.number, 1)[0])) < SINGULAR:
            _, attitude, _, spin = self.motion()
            self._set(attitude, spin)

    def motion(self) -> Motion:
        return self.multibody.motion(2)


def on_ropes(world: Any, scene: Scene) -> tuple[dict[str, Pointer], list[Callable[[float], None]]]:
    """The bodies on ropes, and functions to call before each step.

    PyBullet has no ropes. A body on a rope slides on a straight rail that turns about the hole. A rope that joins two bodies
    is a gear between their rails, which keeps the sum of both lengths. A pulley with inertia is a wheel of radius 1 m with a
    gear to each side; over a pulley both sides hang straight.
    """
    bodies = {body.name: body for body in scene.bodies}
    smooth = {contact.body: contact.normal for contact in scene.contacts}
    by_body: dict[str, Pointer] = {}
    chores: list[Callable[[float], None]] = []
    for rope in scene.ropes:
        line = rope.axis if rope.inertia else None
        pointer = Pointer(world, bodies[rope.body], rope.hole, normal=smooth.get(rope.body), line=line)
        by_body[rope.body] = pointer
        chores.append(pointer.keep)
        if not rope.other:
            chores.append(pointer.multibody.driven(pointer.end, rope.length))
            continue
        other = by_body[rope.other] = Pointer(world, bodies[rope.other], rope.hole, line=rope.axis)
        _join(world, rope, pointer, other)
    return by_body, chores


def _join(world: Any, rope: Rope, first: Pointer, second: Pointer) -> None:
    if not rope.inertia:
        first.multibody.gear(first.end, second.multibody, second.end, 1.0)
        return
    moment = rope.inertia
    wheel = Multibody(world, [Link(AXES[1], mass=1.0, inertia=(moment, moment, moment))], rope.hole)
    first.wheel = wheel
    wheel.gear(0, first.multibody, first.end, -1.0)
    wheel.gear(0, second.multibody, second.end, 1.0)

"""A world of pymunk that holds one scene: it is built, placed, stepped and read.

How it is driven: forces are set in `velocity_func` of the first body, which the engine calls after the drift and before the
kick of all bodies. Exceptions in such a function are printed and lost, so the step raises them again.
"""

from math import atan2, cos, hypot, inf, sin
from typing import Any

from gnomon.cases.core.scene import Hinge, Quaternion, Readings, Scene, SceneForm, Slider, Vector
from gnomon.harness.adapters.engines.compiled_laws import Loads, loads_if_compiled
from gnomon.harness.adapters.engines.pymunk_build import RAIL, Built
from gnomon.harness.adapters.engines.pymunk_plane import Pair, Plane, plane_of, turn_plane
from gnomon.harness.adapters.engines.scene_run import forces_at, impulses_within, torques_at
from gnomon.harness.contract.integrator import Refused

TIGHTER = 10
"""`tight`: so many times the iterations of the solver."""


class World:
    """A world of the engine: `build` creates the bodies of a scene, `place` sets its start, then `advance` and `read`.

    `configured`: joints and contacts are corrected as the scene asks; otherwise the engine keeps its defaults. `options`:
    the options that differ from the engine's defaults, apart from the step and the properties that the scene declares.
    """

    def __init__(self, pymunk: Any, form: SceneForm, dt: float, configured: bool, tight: bool = False) -> None:
        self.api, self.needs, self.dt, self.configured, self.tight = pymunk, form.needs, dt, configured, tight
        self.options: dict[str, Any] = {}
        self.failure: Exception | None = None
        self.traced: Scene | None = None
        self.loads: Loads | None = None
        self.plane = Plane(1)

    def close(self) -> None:
        """Drop the space, with which the engine's memory is freed."""
        self.__dict__.pop("built", None)

    def build(self, scene: Scene) -> None:
        """Make an empty space and create the bodies, joints, contacts and forces of `scene`."""
        self._make(scene, plane_of(scene, self.plane.normal))

    def _make(self, scene: Scene, plane: Plane) -> None:
        if scene is not self.traced or plane != self.plane:  # before each start the same scene is built anew
            self.traced, self.loads = scene, loads_if_compiled(scene)
        self.scene, self.plane, self.steps = scene, plane, 0
        options = self.options if self.configured else None
        self.built = Built(self.api, scene, plane, self.dt, "rod" in self.needs, options)
        if self.tight:
            self.built.space.iterations = self.options["iterations"] = TIGHTER * self.built.space.iterations
        self.parts, self.joints, self.parents = self.built.parts, self.built.joints, self.built.parents
        self.central = {name: part.body for name, part in self.parts.items() if not any(part.tip)}
        if scene.forces or scene.torques or scene.impulses or self.built.wheels:
            self.parts[scene.bodies[0].name].body.velocity_func = self._push

    def place(self, scene: Scene) -> None:
        """Set the initial state of every body. At rest in the origin a scene may have shown another plane."""
        plane = plane_of(scene, self.plane.normal)
        if plane != self.plane:
            self._make(scene, plane)
        self.scene = scene
        for body in scene.bodies:
            if body.name not in self.joints:
                turn, spin = plane.angle(body.quaternion), body.angular_velocity[plane.normal]
                self._move(body.name, plane.flat(body.position), plane.flat(body.velocity), turn, spin)
        for joint in sorted(scene.joints, key=self._depth):
            self._set(joint)
        for rod in self.built.rods:
            rod.distance = hypot(*rod.b.position)

    def _depth(self, joint: Hinge | Slider) -> int:
        """The number of joints between a joint and the ground: a body is set after the one that carries it."""
        parent, _ = self.parents[joint.name]
        return 1 + self._depth(self.joints[parent]) if parent else 0

    def _move(self, name: str, position: Pair, velocity: Pair, angle: float, rate: float) -> None:
        """Set a body by the motion of its tip."""
        part = self.parts[name]
        body, (x, y) = part.body, turn_plane(part.tip, angle)
        body.position, body.angle = (position[0] - x, position[1] - y), angle
        body.velocity, body.angular_velocity = (velocity[0] + rate * y, velocity[1] - rate * x), rate
        self.built.space.reindex_shapes_for_body(body)

    def _set(self, joint: Hinge | Slider) -> None:
        """Set a body by its joint, after its parent; all of a chain's angles are relative to the body before."""
        parent, anchor = self.parents[joint.name]
        start = self.plane.flat(anchor)
        point, velocity, angle, rate = start, (0.0, 0.0), 0.0, 0.0
        if parent:
            (px, py), velocity, angle, rate = self._motion(parent)
            x, y = turn_plane(start, angle)
            point, velocity = (px + x, py + y), (velocity[0] - rate * y, velocity[1] + rate * x)
        if isinstance(joint, Slider):
            x, y = self.plane.flat(joint.axis)
            q, v = joint.position, joint.rate
            if joint.name in self.built.grooves:
                far = RAIL * (1.0 + abs(q) + abs(v))
                groove = self.built.grooves[joint.name]
                groove.groove_a, groove.groove_b = ((start[0] + s * x, start[1] + s * y) for s in (-far, far))
            self._move(
                joint.body, (point[0] + q * x, point[1] + q * y), (velocity[0] + v * x, velocity[1] + v * y), 0.0, 0.0
            )
            return
        sense = joint.axis[self.plane.normal]
        angle, rate = angle + sense * joint.angle, rate + sense * joint.rate
        x, y = turn_plane(self.plane.flat(joint.arm), angle)
        self._move(
            joint.body, (point[0] + x, point[1] + y), (velocity[0] - rate * y, velocity[1] + rate * x), angle, rate
        )

    def _motion(self, name: str) -> tuple[Pair, Pair, float, float]:
        """Position and velocity of the tip, angle and rate; the angle of a point on a rod is that of the rod, up to turns."""
        part, joint = self.parts[name], self.joints.get(name)
        body = part.body
        if any(part.tip):
            return (
                body.local_to_world(part.tip),
                body.velocity_at_local_point(part.tip),
                body.angle,
                body.angular_velocity,
            )
        (x, y), (vx, vy) = body.position, body.velocity
        if not isinstance(joint, Hinge) or body.moment != inf:
            return (x, y), (vx, vy), body.angle, body.angular_velocity
        parent, anchor = self.parents[joint.name]
        rx, ry = self.plane.flat(anchor)
        ux, uy = 0.0, 0.0
        if parent:
            (px, py), (pvx, pvy), angle, rate = self._motion(parent)
            rx, ry = turn_plane((rx, ry), angle)
            ux, uy, rx, ry = pvx - rate * ry, pvy + rate * rx, px + rx, py + ry
        dx, dy, a, b = x - rx, y - ry, *self.plane.flat(joint.arm)
        rate = (dx * (vy - uy) - dy * (vx - ux)) / (dx * dx + dy * dy)
        return (x, y), (vx, vy), atan2(a * dy - b * dx, a * dx + b * dy), rate

    def advance(self, steps: int) -> None:
        step, dt = self.built.space.step, self.dt
        for n in range(self.steps, self.steps + steps):
            for drive in self.built.drives:
                drive(n * dt)
            self.steps = n + 1
            step(dt)
            if self.failure is not None:
                failure, self.failure = self.failure, None
                raise failure

    def _push(self, body: Any, gravity: Any, damping: float, dt: float) -> None:
        """Called for the first body, after the drift and before the kick of all bodies: set the forces on all of them."""
        try:
            self._apply(self.steps * self.dt)
        except Exception as error:
            self.failure = error
        self.api.Body.update_velocity(body, gravity, damping, dt)

    def _apply(self, t: float) -> None:
        plane, scene = self.plane, self.scene
        if self.loads is not None:
            self._load(self.loads, t)
        else:
            for name, force, place in forces_at(scene, t, self._places):
                self._pull(name, force, plane.flat(place))
            for name, torque in torques_at(scene, t, self._rotation):
                self.parts[name].body.torque += torque[plane.normal]
        for part in self.built.wheels:
            weight = (part.body.mass * self.built.space.gravity[0], part.body.mass * self.built.space.gravity[1])
            part.body.apply_force_at_world_point(weight, part.body.local_to_world(part.tip))
        for name, linear, angular in impulses_within(scene, t - self.dt, self.dt):
            body, (x, y) = self.parts[name].body, plane.flat(linear)
            body.apply_force_at_world_point((x / self.dt, y / self.dt), body.position)
            body.torque += angular[plane.normal] / self.dt

    def _load(self, loads: Loads, t: float) -> None:
        """Apply the forces and torques of compiled laws."""
        plane, torques = self.plane, self.scene.torques
        first, second = (plane.normal + 1) % 3, (plane.normal + 2) % 3
        for name, (spin, velocity, place, attitude, _, _) in loads.parts.items():
            (place[first], place[second]), (velocity[first], velocity[second]) = self._place(name)
            if torques:
                _, _, angle, spin[plane.normal] = self._motion(name)
                attitude[0], attitude[1 + plane.normal] = cos(angle / 2), sin(angle / 2)
        loads.update(t)
        for name, (_, _, place, _, force, torque) in loads.parts.items():
            self._pull(name, force.tolist(), (place[first], place[second]))
            if torques:
                self.parts[name].body.torque += torque[plane.normal]

    def _place(self, name: str) -> tuple[Pair, Pair]:
        """Position and velocity of the tip: where it is the body's centre, the engine tells them without its angle."""
        body = self.central.get(name)
        return self._motion(name)[:2] if body is None else (body.position, body.velocity)

    def _places(self, name: str) -> tuple[Vector, Vector]:
        place, velocity = self._place(name)
        return self.plane.space(place), self.plane.space(velocity)

    def _rotation(self, name: str) -> tuple[Quaternion, Vector]:
        _, _, angle, rate = self._motion(name)
        return self.plane.attitude(angle), self.plane.spin(rate)

    def _pull(self, name: str, force: Vector, at: Pair) -> None:
        if not self.plane.holds(force):
            raise Refused("planar engine: a force leaves the plane")
        self.parts[name].body.apply_force_at_world_point(self.plane.flat(force), at)

    def read(self) -> Readings:
        plane, joints = self.plane, {}
        for joint in self.scene.joints:
            (x, y), (vx, vy), angle, rate = self._motion(joint.body)
            parent, anchor = self.parents[joint.name]
            (px, py), (ux, uy), turn, spin = self._motion(parent) if parent else ((0.0, 0.0), (0.0, 0.0), 0.0, 0.0)
            if isinstance(joint, Hinge):
                sense = joint.axis[plane.normal]
                joints[joint.name] = sense * (angle - turn), sense * (rate - spin)
            else:  # bodies on rails do not turn, also those that carry a rail
                (a, b), (ox, oy) = plane.flat(joint.axis), plane.flat(anchor)
                joints[joint.name] = a * (x - px - ox) + b * (y - py - oy), a * (vx - ux) + b * (vy - uy)
        bodies = {}
        for name in self.parts.keys() - self.joints.keys():
            place, velocity, angle, rate = self._motion(name)
            bodies[name] = plane.space(place), plane.attitude(angle), plane.space(velocity), plane.spin(rate)
        return Readings(joints, bodies)

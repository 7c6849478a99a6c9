"""A Newton world: a model of a scene with a solver and its states, which are float32."""

from collections.abc import Callable, Mapping
from importlib.util import find_spec
from typing import Any

from gnomon.cases.core.scene import Body, Hinge, Quaternion, Readings, Scene, SceneForm, Slider, Vector
from gnomon.harness.adapters.engines.compiled_laws import Loads, loads_if_compiled
from gnomon.harness.adapters.engines.newton_model import Assembly, Part
from gnomon.harness.adapters.engines.scene_run import forces_at, impulses_within, torques_at
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot

START_SHAPES = frozenset({"ball_joint", "rod", "rope"})
"""Scenes whose geometry follows from their start: the model is built when the start is known."""


class World:
    """A model of the engine with its solver: `build` makes both, `place` sets a start, then `advance` and `read`.

    `make(world)` makes the solver. `reduced`: it moves the coordinates of joints, otherwise six coordinates of each body.
    `configured`: what the engine adds to a scene is switched off; `options` has what differs from its defaults.
    """

    def __init__(
        self,
        form: SceneForm,
        dt: float,
        make: Callable[["World"], Any],
        *,
        reduced: bool,
        springs: tuple[str, ...],
        configured: bool,
    ) -> None:
        if find_spec("newton") is None:  # the status is then `not_installed`
            raise ImportError("No module named 'newton'")
        import warp  # optional, and slow to import

        # Else each module of kernels prints a line when it is loaded.
        warp.config.log_level = warp.LOG_ERROR
        import newton

        self.newton, self.warp = newton, warp
        self.needs, self.dt, self.make = form.needs, dt, make
        self.kind: dict[str, Any] = {"reduced": reduced, "springs": springs}
        self.configured = configured
        self.settings: dict[str, Any] = {"lock_inertia": True}  # else shapes add to the mass that the scene declares
        self.options: Mapping[str, Any] = self.settings
        self.traced: Scene | None = None
        self.loads: Loads | None = None
        self.assembly: Any = None
        self.model: Any = None
        self.solver: Any = None
        self.contacts: Any = None
        self.states: list[Any] = []
        self.graphs: list[Any] = []
        self.views: dict[int, tuple[Any, ...]] = {}

    def close(self) -> None:
        """The engine frees arrays with their last reference."""
        self.assembly = self.model = self.solver = self.contacts = None
        self.states.clear()
        self.graphs.clear()
        self.views.clear()

    def chosen(self, **settings: Any) -> dict[str, Any]:
        """The settings, recorded, if the world is configured; none otherwise."""
        if not self.configured:
            return {}
        self.settings |= settings
        return settings

    def build(self, scene: Scene) -> None:
        if scene is not self.traced:  # before each start the same scene is built anew
            self.traced, self.loads = scene, loads_if_compiled(scene)
        if not self.needs & START_SHAPES:
            self._build(scene)

    def _build(self, scene: Scene) -> None:
        self.scene = scene
        self.assembly = Assembly(scene, self.needs, self.dt, self.chosen, **self.kind)
        self.model, self.parts = self.assembly.model, self.assembly.parts
        self.driven = [part for part in self.parts.values() if part.drive]
        self.solver = self.make(self)
        self.states = [self.model.state(), self.model.state()]
        # On a processor arrays of NumPy are views of the engine's own, elsewhere copies.
        self.views = {id(state): views_of(state) for state in self.states} if self.model.device.is_cpu else {}
        self.control: Any = self.model.control()
        self.contacts = None
        if self.model.shape_count:
            self.pipeline: Any = self.newton.CollisionPipeline(self.model)
            self.contacts = self.pipeline.contacts()
        self._capture()

    def _capture(self) -> None:
        """Record a step from the first state to the second, and one back: a replay spares the Python code of every launch.

        On a processor that code takes 10 to 70 times as long as the kernels. The states are the same to the bit.
        """
        self.graphs.clear()
        for old, new in (self.states, self.states[::-1]):
            with self.warp.ScopedCapture(device=self.model.device) as capture:
                if self.contacts is not None:
                    self.pipeline.collide(old, self.contacts)
                self.solver.step(old, new, self.control, self.contacts, self.dt)
            self.graphs.append(capture.graph)

    def place(self, scene: Scene) -> None:
        """All solvers start from the coordinates of the joints; a free body is on a joint with six of them."""
        if self.needs & START_SHAPES:
            self._build(scene)
        self.scene, self.steps = scene, 0
        q, qd = self.states[0].joint_q.numpy(), self.states[0].joint_qd.numpy()
        starts = {body.name: body for body in scene.bodies}
        joints = {joint.body: joint for joint in scene.joints}
        for name, part in self.parts.items():
            body, joint = starts.get(name, part.body), joints.get(name, part.joint)
            if part.drive is not None:
                assert isinstance(joint, Slider)
                q[part.q : part.q + 7] = *part.drive(0.0), 0.0, 0.0, 0.0, 1.0
                qd[part.qd : part.qd + 6] = *along(ORIGIN, joint.axis, joint.rate), 0.0, 0.0, 0.0
            elif isinstance(joint, Hinge):
                q[part.q], qd[part.qd] = joint.angle, joint.rate
            elif isinstance(joint, Slider):
                q[part.q], qd[part.qd] = joint.position, joint.rate
            elif part.ball:
                q[part.q : part.q + 4] = body.quaternion
                qd[part.qd : part.qd + 3] = spin_of(body)
            else:
                q[part.q : part.q + 7] = *body.position, *body.quaternion
                qd[part.qd : part.qd + 6] = *body.velocity, *body.angular_velocity
        for state in self.states:
            state.joint_q.assign(q)
            state.joint_qd.assign(qd)
            self.newton.eval_fk(self.model, state.joint_q, state.joint_qd, state)
            state.body_f.zero_()

    def advance(self, steps: int) -> None:
        pushed = bool(self.scene.forces or self.scene.torques or self.scene.impulses)
        for step in range(self.steps, self.steps + steps):
            if self.driven:
                self._drive(self.states[0], step * self.dt)
            if pushed:
                self._push(self.states[0], step * self.dt)
            self.warp.capture_launch(self.graphs[0])
            self.states.reverse()
            self.graphs.reverse()
        self.steps += steps

    def _drive(self, state: Any, t: float) -> None:
        """Driven bodies are where they are at the end of the step, as a solver of positions expects."""
        for names in (("body_q", "body_qd"), ("joint_q", "joint_qd")):
            poses, twists = (getattr(state, name) for name in names)
            q, qd = poses.numpy(), twists.numpy()
            for part in self.driven:
                assert part.drive is not None
                start, end = part.drive(t), part.drive(t + self.dt)
                row, twist = (
                    (part.number, part.number) if names[0] == "body_q" else (slice(part.q, None), slice(part.qd, None))
                )
                q[row][:3] = end
                qd[twist][:3] = along(ORIGIN, along(end, start, -1.0), 1 / self.dt)
            poses.assign(q)
            twists.assign(qd)

    def _push(self, state: Any, t: float) -> None:
        """Forces at the start of the step. A blow acts over the whole step."""
        poses, twists, wrench = self.views.get(id(state)) or views_of(state)
        wrench[:] = 0.0
        if self.loads is not None:
            self._load(self.loads, t, poses, twists, wrench)
        else:
            self._call_laws(t, poses, twists, wrench)
        for name, linear, angular in impulses_within(self.scene, t, self.dt):
            part = self.parts[name]
            wrench[part.number, :3] += along(ORIGIN, linear, 1 / self.dt)
            wrench[part.number, 3:] += along(ORIGIN, angular, part.share / self.dt)
        if not self.views:
            state.body_f.assign(wrench)

    def _load(self, loads: Loads, t: float, poses: Any, twists: Any, wrench: Any) -> None:
        """Forces and torques of compiled laws."""
        for name, (spin, velocity, place, attitude, _, _) in loads.parts.items():
            part: Part = self.parts[name]
            x, y, z, *turn = poses[part.number].tolist()
            u, v, w, *rate = twists[part.number].tolist()
            (place[0], place[1], place[2]), (velocity[0], velocity[1], velocity[2]) = part.motion([x, y, z], [u, v, w])
            if self.scene.torques:
                attitude[1], attitude[2], attitude[3], attitude[0] = turn
                spin[0], spin[1], spin[2] = rate
        loads.update(t)
        for name, (*_, force, torque) in loads.parts.items():
            part = self.parts[name]
            row = wrench[part.number]
            row[:3] = force
            if self.scene.torques:
                row[3:] = along(ORIGIN, torque, part.share)

    def _call_laws(self, t: float, poses: Any, twists: Any, wrench: Any) -> None:
        """Forces and torques of laws that only Python computes."""

        def motion(name: str) -> tuple[Vector, Vector]:
            part: Part = self.parts[name]
            return part.motion(poses[part.number].tolist(), twists[part.number].tolist())

        def rotation(name: str) -> tuple[Quaternion, Vector]:
            number = self.parts[name].number
            return tuple(poses[number][3:].tolist()), tuple(twists[number][3:].tolist())  # type: ignore[return-value]

        for name, force, _ in forces_at(self.scene, t, motion):
            wrench[self.parts[name].number, :3] += force
        for name, torque in torques_at(self.scene, t, rotation):
            wrench[self.parts[name].number, 3:] += along(ORIGIN, torque, self.parts[name].share)

    def read(self) -> Readings:
        state = self.states[0]
        if not self.kind["reduced"]:
            self.newton.eval_ik(self.model, state, state.joint_q, state.joint_qd)
        q, qd = state.joint_q.numpy().tolist(), state.joint_qd.numpy().tolist()
        poses, twists = state.body_q.numpy().tolist(), state.body_qd.numpy().tolist()
        joints, bodies = {}, {}
        for body in self.scene.bodies:
            part = self.parts[body.name]
            place, velocity = part.motion(poses[part.number], twists[part.number])
            if part.drive is not None:
                assert part.joint is not None
                rail = part.joint
                offset = along(place, rail.anchor, -1.0)
                joints[rail.name] = dot(offset, rail.axis), dot(velocity, rail.axis)
            elif part.joint is not None:
                joints[part.joint.name] = q[part.q], qd[part.qd]
            else:
                attitude, spin = tuple(poses[part.number][3:]), tuple(twists[part.number][3:])
                bodies[body.name] = place, attitude, velocity, spin
        return Readings(joints, bodies)


def views_of(state: Any) -> tuple[Any, ...]:
    """The poses and twists of bodies and the forces on them, as arrays of NumPy."""
    return state.body_q.numpy(), state.body_qd.numpy(), state.body_f.numpy()


def spin_of(body: Body) -> Vector:
    """The angular velocity of a body about the origin; a point mass has none about its arm."""
    if any(body.inertia):
        return body.angular_velocity
    return along(ORIGIN, cross(body.position, body.velocity), 1 / dot(body.position, body.position))

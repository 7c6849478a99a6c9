"""A MuJoCo world that holds one scene: only the bodies, joints, forces and contacts that the scene declares."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from gnomon.cases.core.scene import Body, Contact, Quaternion, Readings, Scene, SceneForm, Slider, Vector
from gnomon.harness.adapters.engines.attitudes import frame_along, scalar_first, upward_to
from gnomon.harness.adapters.engines.compiled_laws import Law, compile_laws
from gnomon.harness.adapters.engines.compliant import damping_ratio
from gnomon.harness.adapters.engines.mujoco_forces import TABLE, CompiledForces, time_function
from gnomon.harness.adapters.engines.mujoco_model import AXES, FOLLOWERS, PRESCRIBED, Model, is_point, link, numbers
from gnomon.harness.adapters.engines.scene_run import forces_at, impulses_within, torques_at
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot, inverse, rotate
from gnomon.harness.contract.integrator import Floats

HARD = (0.9999, 0.9999, 0.001)
"""`solimp`: the largest impedance that the engine takes, at every depth. The default yields by a tenth of the force."""
STIFFEST = 2
"""The smallest time constant of a constraint in steps: below it the engine's `refsafe` raises it."""
SLIDING = 20
"""The time constant of a contact with friction, in steps. The engine's convex model of friction also lifts a body that
slides at v, in a step by 2 mu v over this number: at the smallest one the body hops."""
TOLERANCE, ITERATIONS = 1e-8, 100
"""The defaults of the solver. `tight`: ten times these iterations, a hundredth of the tolerance."""
IMPACT = 0.1
"""The frequency of an impact times the step: it lasts 31 steps. The limit of `refsafe` is 1/2."""


class World:
    """A world of the engine: `build` compiles the model of a scene, `place` sets its start, then `advance` and `read`.

    `configured`: constraints are as hard as the step allows, friction has an elliptic cone, and large accelerations are
    no reason for a reset; otherwise the engine keeps its defaults. `options`: the options that differ from the defaults,
    apart from the step and what the scene declares.
    """

    def __init__(
        self, mujoco: Any, form: SceneForm, dt: float, integrator: str, configured: bool, tight: bool = False
    ) -> None:
        self.api, self.needs, self.dt = mujoco, form.needs, dt
        self.integrator, self.configured, self.tight = integrator, configured, tight
        self.options: dict[str, Any] = {} if integrator == "Euler" else {"integrator": integrator}
        self.twist = np.empty(6)
        self.scene: Any = None
        self.model: Any = None
        self.data: Any = None

    def close(self) -> None:
        """Forget the model; the engine frees it."""
        self.model = self.data = None

    def build(self, scene: Scene) -> None:
        """Compile the bodies, joints, contacts and forces of `scene`."""
        known, self.scene = scene is self.scene, scene  # before each start the same scene is built anew
        soft = ""
        if scene.ropes or self.needs & {"linkage", "joint_friction"}:
            kind = "friction." if "joint_friction" in self.needs else "equality."
            soft = self._attributes(kind, solref=(STIFFEST * self.dt, 1.0), solimp=HARD)
        self.layout = Model(scene, self.needs, soft)
        self.prescribed = self.layout.prescribed()
        if self.prescribed:
            self.options["armature"] = PRESCRIBED
        self.pushed = bool(scene.forces or scene.torques or self.prescribed)
        if not known:
            drives = [law for _, law in self.prescribed]
            self.laws = compile_laws(scene, drives, self._drive) if self.pushed else None
            self.positions = time_function(drives, self._follow)
        self.text = self.layout.text(self._option() + (TABLE if self.laws else ""), self._contact)
        self.model = self.api.MjModel.from_xml_string(self.text)
        self.data = self.api.MjData(self.model)
        self.numbers = {body.name: self.model.body(body.name).id for body in scene.bodies}
        self.joints = {name: self._joint(name) for name in [*(x.body for x in scene.joints), *dict(self.prescribed)]}
        rates = [self.joints[name][1] for name, _ in self.prescribed]
        self.forces = CompiledForces(self.api, self.model, self.data, self.laws, rates) if self.laws else None

    def _joint(self, name: str) -> tuple[int, int]:
        """The first coordinate and the first rate of a joint."""
        where = self.model.joint(name)
        return where.qposadr.item(), where.dofadr.item()

    def _option(self) -> str:
        option = f'timestep="{self.dt!r}" integrator="{self.integrator}" gravity="{numbers(*self.scene.gravity)}"'
        if not self.configured:
            return f"<option {option}/>"
        sliding = any(contact.friction for contact in self.scene.contacts)
        if sliding:
            option += self._attributes(cone="elliptic", impratio=100.0)
        if sliding or self.tight:
            option += self._attributes(tolerance=(1e-10 if sliding else TOLERANCE) / (100 if self.tight else 1))
        if self.tight:
            option += self._attributes(iterations=10 * ITERATIONS)
        self.options["autoreset"] = "disable"
        return f'<option {option}><flag autoreset="disable"/></option>'

    def _contact(self, contact: Contact) -> str:
        """The attributes of a contact: a spring and a damper if it rebounds, else a critically damped constraint."""
        kind, detail = "sliding" if contact.friction else "contact", ""
        reference = ((SLIDING if contact.friction else STIFFEST) * self.dt, 1.0)
        if contact.restitution:
            frequency = IMPACT / self.dt
            reference = -(frequency**2), -2 * damping_ratio(contact.restitution) * frequency
            kind, detail = "impact", f" (restitution {contact.restitution:g})"
        if self.configured:
            self.options |= {f"{kind}.solref{detail}": reference, "contact.solimp": HARD}
        return self._written(solref=reference, solimp=HARD)

    def _attributes(self, kind: str = "", **values: Any) -> str:
        """If `configured`, the text that sets these attributes, which are recorded as those of a kind of constraint."""
        if self.configured:
            self.options |= {kind + name: value for name, value in values.items()}
        return self._written(**values)

    def _written(self, **values: Any) -> str:
        if not self.configured:
            return ""
        texts = {
            name: numbers(*value) if isinstance(value, tuple) else value if isinstance(value, str) else repr(value)
            for name, value in values.items()
        }
        return "".join(f' {name}="{text}"' for name, text in texts.items())

    def place(self, scene: Scene) -> None:
        """Set the initial state of every body and joint."""
        model, data = self.model, self.data
        self.api.mj_resetData(model, data)  # also the solver's start from the last solution
        for joint in scene.joints:
            q, v = self.joints[joint.body]
            values = (joint.position, joint.rate) if isinstance(joint, Slider) else (joint.angle, joint.rate)
            data.qpos[q], data.qvel[v] = values
        for body in scene.bodies:
            if (kind := self.layout.kind(body)) != "joint":
                getattr(self, f"_place_{kind}")(body)
        self._prescribe(0.0)

    def _first(self, body: Body) -> tuple[int, int]:
        """The first coordinate and the first rate of a body."""
        joint = self.model.body_jntadr[self.numbers[body.name]]
        return self.model.jnt_qposadr[joint], self.model.jnt_dofadr[joint]

    def _place_sleeve(self, body: Body) -> None:
        """The joints of a linkage follow its arm."""
        arm = self.model.joint(self.scene.hinges[-1].body)
        for name, share in FOLLOWERS.items():
            where = self.model.joint(name)
            self.data.qpos[where.qposadr] = share * self.data.qpos[arm.qposadr]
            self.data.qvel[where.dofadr] = share * self.data.qvel[arm.dofadr]

    def _place_slides(self, body: Body) -> None:
        q, v = self._first(body)
        self.data.qpos[q : q + 3], self.data.qvel[v : v + 3] = body.position, body.velocity

    def _place_rope(self, body: Body) -> None:
        """The rope's plane contains the hole, the body's position and velocity; the weight if it starts at rest."""
        (rope,) = (rope for rope in self.scene.ropes if body.name in (rope.body, rope.other))
        (q, v), arm = self._first(body), along(body.position, rope.hole, -1.0)
        if body.name == rope.other:
            self.data.qpos[q], self.data.qvel[v] = dot(arm, rope.axis), dot(body.velocity, rope.axis)
            return
        size = dot(arm, arm) ** 0.5
        outward = along(ORIGIN, arm, 1 / size)
        frame = frame_along(outward, body.velocity, self.scene.gravity, *AXES)
        turning, number = self.model.joint(link(rope)), self.model.body(link(rope)).id
        self.api.mju_mat2Quat(self.model.body_quat[number], np.array(frame).T.ravel())
        self.data.qpos[q], self.data.qvel[v] = size, dot(body.velocity, outward)
        self.data.qvel[turning.dofadr] = dot(body.velocity, frame[1]) / size

    def _place_free(self, body: Body) -> None:
        q, v = self._first(body)
        self.data.qpos[q : q + 7] = *body.position, *scalar_first(body.quaternion)
        self.data.qvel[v : v + 6] = *body.velocity, *rotate(inverse(body.quaternion), body.angular_velocity)

    def _place_ball(self, body: Body) -> None:
        """The body with its fixed point at the origin.

        A point mass at the arm's end moves like a body of twice the mass at half the arm, with moments m L^2 / 2: weight
        and moment about the fixed point are the same. About the arm it never turns, so that moment has no effect.
        """
        model, attitude, spin = self.model, body.quaternion, body.angular_velocity
        number, square = self.numbers[body.name], dot(body.position, body.position)
        if is_point(body):
            attitude, spin = upward_to(body.position), along(ORIGIN, cross(body.position, body.velocity), 1 / square)
            model.body_ipos[number] = 0.0, 0.0, -(square**0.5) / 2
            model.body_inertia[number] = body.mass * square / 2
        arm = rotate(inverse(attitude), body.position)
        joint = model.body_jntadr[number]
        model.body_pos[number], model.jnt_pos[joint] = arm, along(ORIGIN, arm, -1.0)
        q, v = self._first(body)
        self.data.qpos[q : q + 4], self.data.qvel[v : v + 3] = scalar_first(attitude), rotate(inverse(attitude), spin)

    def _prescribe(self, t: float) -> None:
        """Set prescribed joints to their values at time t."""
        values = iter(self.positions(t))
        for name, _ in self.prescribed:
            q, v = self.joints[name]
            self.data.qpos[q], self.data.qvel[v] = next(values), next(values)

    def _follow(self, law: Law, t: Any) -> tuple[Any, Any]:
        """Position and rate of a prescribed joint; the difference errs like the classical Runge-Kutta method."""
        h = self.dt
        return law(t), (law(t - 2 * h) - 8 * law(t - h) + 8 * law(t + h) - law(t + 2 * h)) / (12 * h)

    def advance(self, steps: int) -> None:
        model, data, step = self.model, self.data, self.api.mj_step
        with self._hooks():
            if not (self.prescribed or self._blows_within(steps)):
                step(model, data, nstep=steps)
                return
            for _ in range(steps):
                self._strike(data.time)
                step(model, data)
                self._prescribe(data.time)
            data.qfrc_applied[:] = 0.0

    def _blows_within(self, steps: int) -> bool:
        """Whether a blow may fall into the coming steps: the engine's time is a sum of steps."""
        if not self.scene.impulses:
            return False
        start, end = self.data.time, self.data.time + (steps + 1) * self.dt
        return any(start <= impulse.time < end for impulse in self.scene.impulses)

    @contextmanager
    def _hooks(self) -> Iterator[None]:
        """The callbacks are global to the process: they are set while this world steps.

        Without a handler the engine writes its warnings, of large accelerations, to a file in the working directory.
        """
        self.api.set_mju_user_warning(lambda message: None)
        self.api.set_mjcb_passive(self.forces.pointer if self.forces else self._push if self.pushed else None)
        try:
            yield
        finally:
            self.api.set_mjcb_passive(None)
            self.api.set_mju_user_warning(None)

    def _push(self, model: Any, data: Any) -> None:
        """Add the forces of the scene at the time and in the state of a stage."""
        t, target = data.time, data.qfrc_passive
        for body, force, place in forces_at(self.scene, t, self._motion):
            self.api.mj_applyFT(model, data, np.array(force), ZERO, np.array(place), self.numbers[body], target)
        for body, torque in torques_at(self.scene, t, self._rotation):
            self.api.mj_applyFT(model, data, ZERO, np.array(torque), ZERO, self.numbers[body], target)
        for name, law in self.prescribed:
            target[self.joints[name][1]] += self._drive(law, t)[0]

    def _drive(self, law: Law, t: Any) -> tuple[Any]:
        """The force that moves a prescribed joint."""
        h = self.dt
        bend = 16 * (law(t - h) + law(t + h)) - law(t - 2 * h) - law(t + 2 * h) - 30 * law(t)
        return (PRESCRIBED * bend / (12 * h * h),)

    def _strike(self, t: float) -> None:
        """Apply the blows of the coming step as forces over it."""
        model, data = self.model, self.data
        data.qfrc_applied[:] = 0.0
        for body, *blow in impulses_within(self.scene, t, self.dt):
            self.api.mj_kinematics(model, data)
            self.api.mj_comPos(model, data)
            (force, torque), number = np.array(blow) / self.dt, self.numbers[body]
            self.api.mj_applyFT(model, data, force, torque, data.xpos[number], number, data.qfrc_applied)

    def _motion(self, name: str) -> tuple[Vector, Vector]:
        """Position and velocity of a body's centre of mass."""
        place, (_, _, _, x, y, z) = self.data.xpos[self.numbers[name]].tolist(), self._twist(name)
        return (place[0], place[1], place[2]), (x, y, z)

    def _rotation(self, name: str) -> tuple[Quaternion, Vector]:
        """Attitude and angular velocity of a body."""
        (w, i, j, k), (x, y, z, *_) = self.data.xquat[self.numbers[name]].tolist(), self._twist(name)
        return (i, j, k, w), (x, y, z)

    def _twist(self, name: str) -> list[float]:
        frame, number = self.api.mjtObj.mjOBJ_XBODY, self.numbers[name]
        self.api.mj_objectVelocity(self.model, self.data, frame, number, self.twist, 0)
        return self.twist.tolist()

    def read(self) -> Readings:
        model, data = self.model, self.data
        for update in (self.api.mj_kinematics, self.api.mj_comPos, self.api.mj_comVel):
            update(model, data)  # after a step they belong to its last stage
        joints, bodies = {}, {}
        for joint in self.scene.joints:
            q, v = self.joints[joint.body]
            joints[joint.name] = data.qpos[q].item(), data.qvel[v].item()
        for body in self.scene.bodies:
            if self.layout.kind(body) != "joint":
                (place, velocity), (attitude, spin) = self._motion(body.name), self._rotation(body.name)
                bodies[body.name] = place, attitude, velocity, spin
        return Readings(joints, bodies)

    def accelerations(self) -> Floats:
        """The engine's accelerations of its coordinates in the present state, without a step."""
        with self._hooks():
            self.api.mj_forward(self.model, self.data)
        return np.array(self.data.qacc)


ZERO = np.zeros(3)

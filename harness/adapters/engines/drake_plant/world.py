"""A Drake plant that holds one scene: only the bodies, joints, forces and contacts that the scene declares."""

from collections.abc import Callable
from math import sqrt
from typing import Any, NamedTuple
from weakref import ref

import numpy as np
from gnomon.cases.core.scene import Body, Hinge, Readings, Scene, SceneForm, Vector
from gnomon.harness.adapters.engines.drake_plant.contact import Contacts
from gnomon.harness.adapters.engines.drake_plant.forces import symbolic_loads
from gnomon.harness.adapters.engines.scene_run import forces_at, torques_at
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot
from gnomon.harness.contract.integrator import Floats

SHORTEST = 1e-8
"""The shortest step of error control, over the longest: a motion that needs shorter ones would not end in days."""


class Control(NamedTuple):
    """Error control: an accuracy, the longest step, and the times at which states are read."""

    accuracy: float
    longest: float
    times: Floats


class World:
    """A diagram of the engine: `build` creates the plant of a scene, `place` sets its start, then `advance` and `read`.

    `scheme`: an integrator of continuous plants, or a contact approximation of discrete ones, or empty for the default.
    `configured`: contact is as stiff as the step admits; otherwise the engine keeps its defaults.
    `control`: error control chooses the steps, and `advance` goes from sample to sample; None for steps of the size `dt`.
    `taken`: the steps of a continuous plant.
    """

    def __init__(
        self,
        drake: Any,
        form: SceneForm,
        dt: float,
        scheme: str,
        configured: bool,
        control: Control | None = None,
    ) -> None:
        self.api, self.needs, self.dt, self.scheme, self.configured = drake, form.needs, dt, scheme, configured
        self.control = control
        self.continuous = scheme in drake.GetIntegrationSchemes()
        self.options: dict[str, Any] = {}
        self.steps_taken = 0

    def close(self) -> None:
        """Release the diagram, which each part of it keeps alive."""
        vars(self).clear()

    def build(self, scene: Scene) -> None:
        api, self.steps, self.scene = self.api, 0, scene
        builder = api.DiagramBuilder()
        plant = self.plant = builder.AddSystem(api.MultibodyPlant(0.0 if self.continuous else self.dt))
        if scene.contacts:
            graph = builder.AddSystem(api.SceneGraph())
            plant.RegisterAsSourceForSceneGraph(graph)
            builder.Connect(graph.get_query_output_port(), plant.get_geometry_query_input_port())
            builder.Connect(plant.get_geometry_pose_output_port(), graph.get_source_pose_port(plant.get_source_id()))
        if self.scheme and not self.continuous:
            plant.set_discrete_contact_approximation(getattr(api.DiscreteContactApproximation, self.scheme))
            self.options["discrete_contact_approximation"] = self.scheme
        plant.mutable_gravity_field().set_gravity_vector(scene.gravity)
        self.joints, self.balls, self.bodies = dict[str, Any](), dict[str, Any](), dict[str, Any]()
        jointed = {joint.body for joint in scene.joints}
        for body in scene.bodies:
            on_ball = body.name not in jointed and bool(self.needs & {"ball_joint", "rod"})
            self.bodies[body.name] = plant.AddRigidBody(body.name, self._inertia(body, body.name in jointed, on_ball))
            if on_ball:
                self._hang(body)
        self._join(scene)
        if scene.contacts:
            contacts = Contacts(api, plant, self.bodies, self.dt, self.continuous)
            self.options |= contacts.add(scene, self.configured, "rigid_impact" in self.needs)
        plant.Finalize()
        self.free = {
            name: (body.floating_positions_start(), body.floating_velocities_start_in_v())
            for name, body in self.bodies.items()
            if body.is_floating_base_body()
        }
        if scene.forces or scene.torques:
            law = builder.AddSystem(symbolic_loads(self) or _law(self))
            builder.Connect(plant.get_state_output_port(), law.get_input_port())
            builder.Connect(law.get_output_port(), plant.get_applied_generalized_force_input_port())
        self.simulator = api.Simulator(builder.Build())
        self.root = self.simulator.get_mutable_context()
        self.context = plant.GetMyMutableContextFromRoot(self.root)
        if self.continuous:
            self._integrate()

    def _integrate(self) -> None:
        control = self.control
        longest = self.dt if control is None else control.longest
        self.integrator = self.api.ResetIntegratorFromFlags(self.simulator, self.scheme, longest)
        self.options["integration_scheme"] = self.scheme
        if control is None:
            self.integrator.set_fixed_step_mode(True)
            self.options["fixed_step_mode"] = True
        else:
            self.integrator.set_target_accuracy(control.accuracy)
            self.integrator.set_requested_minimum_step_size(SHORTEST * longest)
            self.options |= {"target_accuracy": control.accuracy, "maximum_step_size": longest}
            self.options["requested_minimum_step_size"] = SHORTEST * longest

    def _inertia(self, body: Body, jointed: bool, on_ball: bool) -> Any:
        """The inertia of a body about its frame, whose origin is the scene's centre of mass.

        The engine inverts the inertia of every joint, so what does not move needs a positive moment too:
        - A free point mass turns, unseen: any moment will do. A thin rod is not turned about itself.
        - A point mass at distance r on a ball joint moves like twice the mass at r/2 with a moment of m r^2/2 about each
          axis: the weight's torque is m g r and the moment across the arm m r^2, as they were. Nothing turns it about the
          arm, so the moment there does not count.
        """
        api, moments, mass, centre = self.api, body.inertia, body.mass, ORIGIN
        if on_ball and not any(moments):
            r = sqrt(dot(body.position, body.position)) or 1.0
            moments, mass, centre = (mass * r * r / 2,) * 3, 2 * mass, (0.0, 0.0, -r / 2)
        elif not jointed and not all(moments):
            moments = (max(moments) or mass,) * 3
        return api.SpatialInertia.MakeFromCentralInertia(mass, np.array(centre), api.RotationalInertia(*moments))

    def _pose(self, position: Vector, rotation: Any = None) -> Any:
        return self.api.RigidTransform(rotation or self.api.RotationMatrix(), np.array(position))

    def _join(self, scene: Scene) -> None:
        api, plant = self.api, self.plant
        for joint in scene.joints:
            hinge, arm = isinstance(joint, Hinge), joint.arm if isinstance(joint, Hinge) else ORIGIN
            frame = self.bodies[joint.parent].body_frame() if joint.parent else plant.world_frame()
            here = plant.AddFrame(api.FixedOffsetFrame(f"{joint.name} anchor", frame, self._pose(joint.anchor)))
            back, mine = self._pose(along(ORIGIN, arm, -1.0)), self.bodies[joint.body].body_frame()
            there = plant.AddFrame(api.FixedOffsetFrame(f"{joint.name} end", mine, back))
            kind = api.RevoluteJoint if hinge else api.PrismaticJoint
            self.joints[joint.name] = plant.AddJoint(kind(joint.name, here, there, joint.axis, damping=0.0))

    def _hang(self, body: Body) -> None:
        """The body on a ball joint at the origin: roll, pitch and yaw, of which roll is the spin about the body's z.

        At a pitch of 90 degrees, where the body's z is along the y of space, they are singular.
        """
        api, plant, frame = self.api, self.plant, self.bodies[body.name].body_frame()
        self.turn = api.RotationMatrix(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]))
        ball = plant.AddFrame(api.FixedOffsetFrame("ball", plant.world_frame(), self._pose(ORIGIN, self.turn)))
        self.socket = plant.AddFrame(api.FixedOffsetFrame("socket", frame, self._socket(body)))
        self.balls[body.name] = plant.AddJoint(api.BallRpyJoint("ball joint", ball, self.socket, damping=0.0))

    def _socket(self, body: Body) -> Any:
        return self.api.RigidTransform(self.turn, -(self._attitude(body).inverse() @ np.array(body.position)))

    def _attitude(self, body: Body) -> Any:
        """The attitude of a body; a point mass, which has none, is on the positive z axis of its own."""
        if any(body.inertia) or not any(body.position) or not self.needs & {"ball_joint", "rod"}:
            x, y, z, w = body.quaternion
            return self.api.RotationMatrix(self.api.Quaternion(w, x, y, z))
        return self.api.RotationMatrix.MakeFromOneVector(np.array(body.position), 2)

    def place(self, scene: Scene) -> None:
        """Set the initial state of every body and joint, at t = 0."""
        api, plant, context = self.api, self.plant, self.context
        self.steps = 0
        self.root.SetTime(0.0)
        for hinge in scene.hinges:
            self.joints[hinge.name].set_angle(context, hinge.angle)
            self.joints[hinge.name].set_angular_rate(context, hinge.rate)
        for slider in scene.sliders:
            self.joints[slider.name].set_translation(context, slider.position)
            self.joints[slider.name].set_translation_rate(context, slider.rate)
        for body in scene.bodies:
            if body.name in self.balls:
                self._place_on_ball(body)
            elif body.name in self.free:
                plant.SetFreeBodyPose(context, self.bodies[body.name], self._pose(body.position, self._attitude(body)))
                twist = api.SpatialVelocity(np.array(body.angular_velocity), np.array(body.velocity))
                plant.SetFreeBodySpatialVelocity(context, self.bodies[body.name], twist)
        self.simulator.Initialize()

    def _place_on_ball(self, body: Body) -> None:
        ball, spin = self.balls[body.name], body.angular_velocity
        if not any(body.inertia):  # at zero state it may be in the joint: only now the length of its arm is known
            r = body.position
            self.socket.SetPoseInParentFrame(self.context, self._socket(body))
            self.bodies[body.name].SetSpatialInertiaInBodyFrame(self.context, self._inertia(body, False, True))
            spin = along(ORIGIN, cross(r, body.velocity), 1 / dot(r, r))
        turned = self.turn.inverse() @ self._attitude(body) @ self.turn
        ball.set_angles(self.context, self.api.RollPitchYaw(turned).vector())
        ball.set_angular_velocity(self.context, self.turn.inverse() @ np.array(spin))

    def advance(self, steps: int) -> None:
        """To a time, not by steps: each call of the engine costs as much as a step."""
        start, end = self._time(self.steps), self._time(self.steps + steps)
        for impulse in self.scene.impulses:
            # A continuous plant stops at the blow, within a step if need be; a discrete one can stop at steps only.
            stop = impulse.time if self.continuous else int(impulse.time / self.dt) * self.dt
            if start <= stop < end:
                self._go(stop)
                self._strike(impulse.body, (*impulse.angular, *impulse.linear))
        self._go(end)
        self.steps += steps

    def _time(self, steps: int) -> float:
        if self.control is None:
            return steps * self.dt
        return float(self.control.times[steps - 1]) if steps else 0.0

    def _go(self, time: float) -> None:
        before = self.integrator.get_num_steps_taken() if self.continuous else 0
        try:
            self.simulator.AdvanceTo(time)
        except RuntimeError as error:  # of an expression, or of error control that finds no step
            raise ArithmeticError(str(error)) from error
        self.steps_taken += self.integrator.get_num_steps_taken() - before if self.continuous else 0

    def _strike(self, body: str, blow: tuple[float, ...]) -> None:
        """The jump of the velocities by a blow, with the engine's own mass matrix."""
        plant, context = self.plant, self.context
        jump = np.linalg.solve(plant.CalcMassMatrix(context), self._jacobian(body).T @ np.array(blow))
        plant.SetVelocities(context, plant.GetVelocities(context) + jump)

    def _jacobian(self, body: str) -> Floats:
        """Angular velocity and velocity of a body for each of the plant's velocities."""
        world, frame, kind = self.plant.world_frame(), self.bodies[body].body_frame(), self.api.JacobianWrtVariable.kV
        jacobian: Floats = self.plant.CalcJacobianSpatialVelocity(self.context, kind, frame, np.zeros(3), world, world)
        return jacobian

    def read(self) -> Readings:
        plant, context = self.plant, self.context
        joints = {
            name: (joint.GetOnePosition(context), joint.GetOneVelocity(context)) for name, joint in self.joints.items()
        }
        bodies = {}
        for name in (*self.free, *self.balls):
            pose = plant.EvalBodyPoseInWorld(context, self.bodies[name])
            twist = plant.EvalBodySpatialVelocityInWorld(context, self.bodies[name])
            w, x, y, z = pose.rotation().ToQuaternion().wxyz().tolist()
            motion = (pose.translation(), twist.translational(), twist.rotational())
            place, velocity, spin = (tuple(each.tolist()) for each in motion)
            bodies[name] = place, (x, y, z, w), velocity, spin
        return Readings(joints, bodies)

    def load(self, t: float, state: list[float]) -> Floats:
        """The generalised forces of the scene's forces and torques at this time and state of the plant."""
        plant, context, velocities = self.plant, self.context, self.plant.num_positions()
        total: Floats = np.zeros(plant.num_velocities())

        def motion(body: str) -> tuple[Any, Any]:
            if body in self.free:
                q, v = self.free[body][0] + 4, velocities + self.free[body][1] + 3
                return state[q : q + 3], state[v : v + 3]
            pose = plant.EvalBodyPoseInWorld(context, self.bodies[body])
            twist = plant.EvalBodySpatialVelocityInWorld(context, self.bodies[body])
            return pose.translation().tolist(), twist.translational().tolist()

        def rotation(body: str) -> tuple[Any, Any]:
            turn = plant.EvalBodyPoseInWorld(context, self.bodies[body]).rotation().ToQuaternion()
            spin = plant.EvalBodySpatialVelocityInWorld(context, self.bodies[body]).rotational()
            return (turn.x(), turn.y(), turn.z(), turn.w()), spin.tolist()

        def push(body: str, part: int, vector: Vector) -> None:
            if body in self.free:
                first = self.free[body][1] + part
                total[first : first + 3] += vector
            else:
                total[:] += self._jacobian(body)[part : part + 3].T @ np.array(vector)

        for body, force, _ in forces_at(self.scene, t, motion):
            push(body, 3, force)
        for body, torque in torques_at(self.scene, t, rotation):
            push(body, 0, torque)
        return total


def _law(world: World) -> Any:
    """A system whose output is the world's load: the engine evaluates it in every stage of its integrator."""
    api = world.api

    class Law(api.LeafSystem):  # type: ignore[misc, name-defined]
        def __init__(self) -> None:
            super().__init__()
            self.DeclareVectorInputPort("state", world.plant.num_multibody_states())
            weak: Callable[[], Any] = ref(self)  # the engine never releases a system that is in its own callback
            self.DeclareVectorOutputPort(
                "load", world.plant.num_velocities(), lambda context, output: weak().calculate(context, output)
            )

        def calculate(self, context: Any, output: Any) -> None:
            state = self.get_input_port().Eval(context).tolist()
            output.SetFromVector(world.load(context.get_time(), state))

    return Law()

"""A small correct engine of rigid bodies with impacts on a plane, and engines each with one planted fault."""

from collections.abc import Callable
from typing import Any

import numpy as np
from gnomon.cases.core.scene import Body, Hinge, Readings, Scene
from gnomon.cases.scenes.attitude import matrix
from gnomon.harness.adapters.engines.scene_run import forces_at
from gnomon.harness.adapters.engines.vectors import turn_arm
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.verification.engine_adapter import EngineIntegrator, from_engine

TOKENS = (
    "gyroscopic", "hinge", "slider", "position_force", "velocity_force", "time_force", "mutual_force", "rigid_impact",
    "coulomb_isotropic",
)  # fmt: skip


class RigidEngine:
    """Free bodies, and bodies on one hinge or rail, by Heun's method. Order 2.

    A contact acts after the step, on the centre of mass: right for balls that bounce and for boxes that slide.
    """

    def load(self, scene: Scene) -> None:
        self.t, self.scene, self.steps = 0.0, scene, 0
        self.joints = {joint.body: joint for joint in scene.joints}
        self.bodies = {body.name: body for body in scene.bodies}
        self.places: dict[str, slice] = {}
        parts: list[list[float]] = []
        for name, body in self.bodies.items():
            joint = self.joints.get(name)
            if joint is None:
                part = [*body.position, *body.quaternion, *body.velocity, *body.angular_velocity]
            else:
                part = [joint.angle if isinstance(joint, Hinge) else joint.position, joint.rate]
            start = sum(map(len, parts))
            self.places[name] = slice(start, start + len(part))
            parts.append(part)
        self.y = np.array([value for part in parts for value in part], dtype=float)

    def step(self, dt: float) -> None:
        before = self.rates(self.t, self.y)
        after = self.rates(self.t + dt, self.predicted(dt, before))
        self.y = self.y + dt / 2 * (before + after)
        self.t += dt
        self.steps += 1
        for name, place in self.places.items():
            if name not in self.joints:
                part = self.y[place]
                part[3:7] /= np.linalg.norm(part[3:7])
                self.touch(self.bodies[name], part)

    def predicted(self, dt: float, before: Floats) -> Floats:
        """The state at which the forces at the end of the step are evaluated."""
        return self.y + dt * before

    def motion(self, name: str, y: Floats) -> tuple[Any, Any]:
        """Position and velocity of a centre of mass."""
        part, joint = y[self.places[name]], self.joints.get(name)
        if joint is None:
            return tuple(part[:3].tolist()), tuple(part[7:10].tolist())
        axis, place, rate = self.axis(joint), float(part[0]), float(part[1])
        if isinstance(joint, Hinge):
            arm = np.array(turn_arm(tuple(axis.tolist()), joint.arm, place)[1])
            where, velocity = joint.anchor + arm, rate * np.cross(axis, arm)
        else:
            where, velocity = joint.anchor + place * axis, rate * axis
        return tuple(where.tolist()), tuple(velocity.tolist())

    def axis(self, joint: Any) -> Floats:
        return np.array(joint.axis, dtype=float)

    def forces(self, t: float, y: Floats) -> dict[str, Floats]:
        total = {name: body.mass * np.array(self.scene.gravity) for name, body in self.bodies.items()}
        for name, force, _ in forces_at(self.scene, t, lambda body: self.motion(body, y)):
            total[name] = total[name] + np.array(force)
        return total

    def rates(self, t: float, y: Floats) -> Floats:
        found, forces = np.empty_like(y), self.forces(t, y)
        for name, place in self.places.items():
            body, part, joint = self.bodies[name], y[place], self.joints.get(name)
            if joint is not None:
                found[place] = part[1], self.along(joint, body, float(part[0]), forces[name])
                continue
            spin, vector, scalar = part[10:], part[3:6], part[6]
            turn = np.concatenate([scalar * spin + np.cross(spin, vector), [-spin @ vector]]) / 2
            found[place] = np.concatenate([part[7:10], turn, forces[name] / body.mass, self.spin_rate(body, part)])
        return found

    def along(self, joint: Any, body: Body, place: float, force: Floats) -> float:
        """The acceleration of a joint."""
        axis = self.axis(joint)
        if not isinstance(joint, Hinge):
            return float(axis @ force) / body.mass
        lever = np.cross(axis, np.array(turn_arm(tuple(axis.tolist()), joint.arm, place)[1]))
        moment = axis @ (np.array(body.inertia) * axis) + body.mass * lever @ lever
        return float(lever @ force / moment)

    def frame(self, part: Floats) -> Floats:
        """The rotation from the axes of the moments to space."""
        return np.array(matrix(tuple(part[3:7].tolist()))).reshape(3, 3)  # type: ignore[arg-type]

    def spin_rate(self, body: Body, part: Floats) -> Floats:
        moments, frame = np.array(body.inertia), self.frame(part)
        if not moments.any():
            return np.zeros(3)
        spin = frame.T @ part[10:]
        rate: Floats = frame @ (np.cross(moments * spin, spin) / moments)
        return rate

    def touch(self, body: Body, part: Floats) -> None:
        """Reflect a body that is in the plane, and brake it."""
        for contact in self.scene.contacts:
            normal = np.array(contact.normal)
            size = body.radius if body.radius is not None else np.abs(normal) @ np.array(body.half_extents)
            depth, speed = float(size - normal @ part[:3]), float(normal @ part[7:10])
            if depth < 0 or speed >= 0:
                continue
            e = self.restitution(contact.restitution)
            jump = self.impulse(-(1 + e) * speed)
            part[:3] += (1 + e) * depth * normal
            part[7:10] += jump * normal
            part[7:10] -= self.braked(part[7:10] - (normal @ part[7:10]) * normal, contact.friction * jump)

    def restitution(self, e: float) -> float:
        return e

    def impulse(self, exact: float) -> float:
        return exact

    def braked(self, sliding: Floats, most: float) -> Floats:
        speed = float(np.linalg.norm(sliding))
        return sliding if speed <= most else sliding * most / speed

    def read(self) -> Readings:
        joints, bodies = {}, {}
        for name, place in self.places.items():
            part = self.y[place].tolist()
            if name in self.joints:
                joints[self.joints[name].name] = part[0], part[1]
            else:
                bodies[name] = tuple(part[:3]), tuple(part[3:7]), tuple(part[7:10]), tuple(part[10:])
        return Readings(joints, bodies)  # type: ignore[arg-type]


class SpaceAxes(RigidEngine):
    def frame(self, part: Floats) -> Floats:
        """The moments act along the axes of space."""
        return np.eye(3)


class NoGyroscope(RigidEngine):
    def spin_rate(self, body: Body, part: Floats) -> Floats:
        return np.zeros(3)


class TwiceRestitution(RigidEngine):
    def restitution(self, e: float) -> float:
        """Once for the ball, once for the plane."""
        return e * e


class FalseTrapezoid(RigidEngine):
    def predicted(self, dt: float, before: Floats) -> Floats:
        """Positions advance, but velocities, and so forces, stay those of the start. Order 1."""
        return self.y


class Clamped(RigidEngine):
    def step(self, dt: float) -> None:
        super().step(dt)
        self.y = np.clip(self.y, -500.0, 500.0)


class WarmStart(RigidEngine):
    guess = 0.0

    def impulse(self, exact: float) -> float:
        """Nearly converged from the last impulse, which `load` does not clear."""
        self.guess = exact + 2.0**-12 * (self.guess - exact)
        return self.guess


class Damped(RigidEngine):
    def step(self, dt: float) -> None:
        super().step(dt)
        for name, place in self.places.items():
            if name not in self.joints:
                self.y[place][7:] *= 1 - 1e-9 * dt


class Sleeper(RigidEngine):
    def step(self, dt: float) -> None:
        if self.t < 2 or np.max(np.abs(self.y[7:])) > 1e-3:
            super().step(dt)


class LateForces(RigidEngine):
    def forces(self, t: float, y: Floats) -> dict[str, Floats]:
        """The first step has no forces."""
        found = super().forces(t, y)
        return found if self.steps else {name: 0 * force for name, force in found.items()}


class Pyramid(RigidEngine):
    def braked(self, sliding: Floats, most: float) -> Floats:
        """Each axis brakes alone."""
        return np.clip(sliding, -most, most)


class StraightAxes(RigidEngine):
    def axis(self, joint: Any) -> Floats:
        """The axis of space that is nearest to the joint's."""
        found = np.zeros(3)
        found[int(np.argmax(np.abs(joint.axis)))] = 1.0
        return found


class DoubleForces(RigidEngine):
    def forces(self, t: float, y: Floats) -> dict[str, Floats]:
        """Laws act twice, gravity once."""
        own = {name: body.mass * np.array(self.scene.gravity) for name, body in self.bodies.items()}
        return {name: 2 * force - own[name] for name, force in super().forces(t, y).items()}


class StaleVelocities(RigidEngine):
    def read(self) -> Readings:
        """Before the first step all velocities are 0."""
        found = super().read()
        if self.steps:
            return found
        rest = (0.0, 0.0, 0.0)
        return Readings(
            {name: (place, 0.0) for name, (place, _) in found.joints.items()},
            {name: (place, attitude, rest, rest) for name, (place, attitude, _, _) in found.bodies.items()},
        )


class Single(RigidEngine):
    """Keeps its state in binary32."""

    def step(self, dt: float) -> None:
        self.y = self.y.astype(np.float32).astype(float)
        super().step(dt)
        self.y = self.y.astype(np.float32).astype(float)


def rigid(engine: Callable[[], Any]) -> EngineIntegrator:
    return from_engine(engine, name=engine.__name__, order=2, tokens=TOKENS)


SOUND, CLAMPED = rigid(RigidEngine), rigid(Clamped)
SINGLE = from_engine(Single, name="Single", order=2, tokens=TOKENS, bits=24)
PLANTED = {
    "start": rigid(StaleVelocities),
    "inertia_frame": rigid(SpaceAxes),
    "gyroscopic_term": rigid(NoGyroscope),
    "restitution": rigid(TwiceRestitution),
    "declared_order": rigid(FalseTrapezoid),
    "clamp": CLAMPED,
    "same_bits": rigid(WarmStart),
    "drift": rigid(Damped),
    "sleep": rigid(Sleeper),
    "first_step": rigid(LateForces),
    "friction": rigid(Pyramid),
    "joint_axes": rigid(StraightAxes),
    "acceleration": rigid(DoubleForces),
}
"""For each pre-flight the engine with the fault that it is to name."""

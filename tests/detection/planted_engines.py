"""Small engines with a known motion: steady rotation about an axis of a free body, balls that meet a plane or each other."""

import os
from typing import Any

import numpy as np
from gnomon.cases.core.scene import IDENTITY, Readings, Scene
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.verification.engine_adapter import EngineIntegrator, from_engine
from scipy.spatial.transform import Rotation

REST = (0.0, 0.0, 0.0)


class Steady:
    """A free body that, with its angular momentum, turns about one of its axes from the first step on."""

    axis = 1

    def load(self, scene: Scene) -> None:
        (self.body,), self.t = scene.bodies, 0.0
        momentum = np.multiply(self.body.inertia, self.body.angular_velocity)
        self.spin = momentum / self.body.inertia[self.axis]
        self.turn = Rotation.align_vectors([momentum], [np.eye(3)[self.axis]])[0]

    def step(self, dt: float) -> None:
        self.t += dt

    def read(self) -> Readings:
        attitude = tuple((Rotation.from_rotvec(self.t * self.spin) * self.turn).as_quat().tolist())
        return Readings(bodies={self.body.name: (REST, attitude, REST, tuple(self.spin.tolist()))})


class AboutFirst(Steady):
    axis = 0


class AboutLast(Steady):
    axis = 2


class Resting(Steady):
    """Keeps the start."""

    def load(self, scene: Scene) -> None:
        (self.body,) = scene.bodies

    def step(self, dt: float) -> None:
        pass

    def read(self) -> Readings:
        return Readings(bodies={self.body.name: (REST, IDENTITY, REST, self.body.angular_velocity)})


class Ball:
    """A ball above the plane z = 0, exact between impacts and at them."""

    def load(self, scene: Scene) -> None:
        (self.body,), (self.plane,) = scene.bodies, scene.contacts
        self.gravity = -scene.gravity[2]
        assert self.body.radius is not None
        self.height, self.velocity = self.body.position[2] - self.body.radius, self.body.velocity[2]

    def step(self, dt: float) -> None:
        while dt > 0:
            y, v, g = self.height, self.velocity, self.gravity
            falls = v + (v * v + 2 * g * y) ** 0.5  # over g the time to the plane
            until = falls / g if g else (y / -v if v < 0 else dt)
            part = min(dt, until)
            self.height, self.velocity = max(y + v * part - g * part * part / 2, 0.0), v - g * part
            if until <= dt and self.velocity < 0:
                self.height, self.velocity = 0.0, -self.keep(-self.velocity) * self.velocity
                if self.velocity * self.velocity < 1e-12 * g:
                    self.gravity, self.velocity = 0.0, 0.0  # it rests
            dt -= part

    def keep(self, speed: float) -> float:
        """The coefficient of restitution at a speed."""
        return self.plane.restitution

    def read(self) -> Readings:
        assert self.body.radius is not None
        place = (0.0, 0.0, self.height + self.body.radius)
        return Readings(bodies={self.body.name: (place, IDENTITY, (0.0, 0.0, self.velocity), REST)})


class Leaky(Ball):
    def keep(self, speed: float) -> float:
        return 0.999


class Dead(Ball):
    def keep(self, speed: float) -> float:
        return 0.5


class Threshold(Ball):
    def keep(self, speed: float) -> float:
        """No rebound below 1 m/s."""
        return self.plane.restitution if speed >= 1 else 0.0


class Capped(Ball):
    def keep(self, speed: float) -> float:
        """A fast ball leaves as if it came with 10 m/s."""
        return self.plane.restitution * min(1.0, 10 / speed)


class Crashes(Ball):
    def step(self, dt: float) -> None:
        os._exit(3)


class Raises(Resting):
    def step(self, dt: float) -> None:
        raise RuntimeError("no solver")


class Line:
    """Balls on the x axis and a wall, without other forces: impacts after a step, which keep the energy."""

    share = 1.0
    """The part of the restitution that an impact keeps."""

    def load(self, scene: Scene) -> None:
        self.scene, bodies = scene, scene.bodies
        self.mass = {body.name: body.mass for body in bodies}
        self.size = {body.name: body.radius or 0.0 for body in bodies}
        self.place = {body.name: body.position[0] for body in bodies}
        self.speed = {body.name: body.velocity[0] for body in bodies}

    def step(self, dt: float) -> None:
        for name in self.place:
            self.place[name] += dt * self.speed[name]
        for contact in self.scene.contacts:
            near, far = contact.body, contact.partner
            way = 1.0 if not far or self.place[near] > self.place[far] else -1.0
            gap = way * (self.place[near] - (self.place[far] if far else 0.0)) - self.size[near]
            closing = -way * (self.speed[near] - (self.speed[far] if far else 0.0))
            if gap - (self.size[far] if far else 0.0) <= 0 < closing:
                jump = way * (1 + self.share * contact.restitution) * closing
                jump /= 1 / self.mass[near] + (1 / self.mass[far] if far else 0.0)
                self.speed[near] += jump / self.mass[near]
                if far:
                    self.speed[far] -= jump / self.mass[far]

    def read(self) -> Readings:
        bodies = {name: ((x, 0.0, 0.0), IDENTITY, (self.speed[name], 0.0, 0.0), REST) for name, x in self.place.items()}
        return Readings(bodies=bodies)


class LeakyLine(Line):
    share = 1 - 1e-9


class Fall:
    """Point masses under gravity alone, by a step that is exact: it keeps the energy. `share` of the fall in a step."""

    share = 0.5

    def load(self, scene: Scene) -> None:
        self.gravity = np.array(scene.gravity)
        self.motion = {body.name: (np.array(body.position), np.array(body.velocity)) for body in scene.bodies}

    def step(self, dt: float) -> None:
        for name, (place, velocity) in self.motion.items():
            fall = self.gravity * dt
            self.motion[name] = place + dt * (velocity + self.share * fall), velocity + fall

    def read(self) -> Readings:
        def numbers(values: Floats) -> Any:
            return tuple(values.tolist())

        bodies = {name: (numbers(x), IDENTITY, numbers(v), REST) for name, (x, v) in self.motion.items()}
        return Readings(bodies=bodies)


class EulerFall(Fall):
    """Symplectic Euler."""

    share = 1.0


def planted(engine: Any, *tokens: str, conserves: tuple[str, ...] = ()) -> EngineIntegrator:
    return from_engine(engine, name=engine.__name__, order=1, tokens=tokens, conserves=conserves)

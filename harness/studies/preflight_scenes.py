"""Small scenes with known equations of motion, by which pre-flights separate the faults of physics engines."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from gnomon.cases.core.scene import (
    IDENTITY,
    Body,
    Contact,
    Force,
    Hinge,
    Readings,
    Scene,
    SceneForm,
    Slider,
    Vector,
    joint,
)
from gnomon.cases.scenes.attitude import matrix
from gnomon.harness.contract.integrator import Floats

MASS, INERTIA = 2.0, (0.5, 1.0, 1.25)
"""Of every body here: distinct moments, the largest below the sum of the others."""
GRAVITY, STIFFNESS = 9.75, 3.0
"""Numbers that are exact in binary32, as all numbers of these scenes that can be."""
POSITION, ATTITUDE, VELOCITY, SPIN = slice(0, 3), slice(3, 7), slice(7, 10), slice(10, 13)
"""The parts of the state of a free body."""
POINT = [*range(3), *range(7, 10)]
"""The parts of the state that a point mass has."""
TURNED = (0.5, -0.5, 0.1, 0.7)
"""A quaternion without a symmetry, up to its length."""
OBLIQUE = (1 / 3, 2 / 3, 2 / 3)
ARM, ANCHOR = (0.5, -0.25, 0.125), (0.5, 1.0, -0.25)
RADIUS = 0.125

Rates = Callable[[float, Floats], Floats]
"""The equations of motion: time and state to the rates of change of the state."""


def state(
    position: Iterable[float] = (0, 0, 0),
    attitude: Iterable[float] = IDENTITY,
    velocity: Iterable[float] = (0, 0, 0),
    spin: Iterable[float] = (0, 0, 0),
) -> Floats:
    """The state of a free body, shape (13,), with a quaternion of length 1."""
    quaternion = np.array(list(attitude), dtype=float)
    return np.concatenate([list(position), quaternion / np.linalg.norm(quaternion), list(velocity), list(spin)])


def free(*needs: str, gravity: Vector = (0.0, 0.0, 0.0), conservative: bool = False, **parts: Any) -> SceneForm:
    """The form of one body without a joint. `parts`: shape and moments of the body, forces and contacts of the scene."""
    shape = {"inertia": INERTIA} | {k: parts.pop(k) for k in ("inertia", "radius", "half_extents") if k in parts}

    def build(start: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        position, attitude, velocity, spin = (start[part] for part in (POSITION, ATTITUDE, VELOCITY, SPIN))
        body = Body("body", MASS, shape["inertia"], position, attitude if any(attitude) else IDENTITY, velocity, spin)  # type: ignore[arg-type]
        outer = {name: value for name, value in shape.items() if name != "inertia"}
        return Scene(gravity, (Body(**(vars(body) | outer)),), **parts)

    return SceneForm(build, _free_state, frozenset(needs), conservative)


def _free_state(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(value for part in readings.bodies["body"] for value in part)


def _spring(t: float, position: Vector, velocity: Vector) -> Vector:
    return -STIFFNESS * position[0], -STIFFNESS * position[1], -STIFFNESS * position[2]


AT_REST = free(conservative=True)
"""A body on which nothing acts; its attitude does not count."""
TUMBLING = free("gyroscopic")
"""A body on which nothing acts; its attitude counts."""
FALLING = free(gravity=(0.0, 0.0, -GRAVITY), conservative=True)
ON_A_SPRING = free("position_force", forces=(Force("body", "position_force", _spring),), conservative=True)


def falling_rates(t: float, y: Floats) -> Floats:
    return np.concatenate([y[VELOCITY], np.zeros(4), [0.0, 0.0, -GRAVITY], np.zeros(3)])


def spring_rates(t: float, y: Floats) -> Floats:
    return np.concatenate([y[VELOCITY], np.zeros(4), -STIFFNESS / MASS * y[POSITION], np.zeros(3)])


def tumbling_rates(t: float, y: Floats) -> Floats:
    """Euler's equations in space, and the rate w q / 2 of the quaternion."""
    turn = np.array(matrix(tuple(y[ATTITUDE].tolist()))).reshape(3, 3)  # type: ignore[arg-type]
    moments, spin = np.array(INERTIA), y[SPIN]
    of_body = turn.T @ spin
    change = turn @ (np.cross(moments * of_body, of_body) / moments)
    vector, scalar = y[3:6], y[6]
    quaternion = np.concatenate([scalar * spin + np.cross(spin, vector), [-spin @ vector]]) / 2
    return np.concatenate([y[VELOCITY], quaternion, np.zeros(3), change])


SMOOTH: dict[str, tuple[SceneForm, Rates, Floats, list[int]]] = {
    "falling_body": (FALLING, falling_rates, state((0.5, -0.25, 1.0), velocity=(1.0, 0.5, 2.0)), POINT),
    "body_on_a_spring": (ON_A_SPRING, spring_rates, state((0.5, -0.25, 1.0), velocity=(1.0, 0.5, -2.0)), POINT),
    "tumbling_body": (TUMBLING, tumbling_rates, state(attitude=TURNED, spin=(1.0, -0.5, 1.5)), list(range(13))),
}
"""Form, equations of motion, start, and the parts of the state that count. The time scale of each is about 1 s."""


def ball(restitution: float) -> SceneForm:
    """A ball that meets the plane z = 0, without gravity."""
    moment = 2 / 5 * MASS * RADIUS**2
    plane = Contact("body", (0.0, 0.0, 1.0), restitution=restitution)
    return free("rigid_impact", inertia=(moment,) * 3, radius=RADIUS, contacts=(plane,))


def box(friction: float) -> SceneForm:
    """A flat box on the plane z = 0 under gravity; it starts at a height of RADIUS."""
    half = (0.5, 0.5, RADIUS)
    x, y, z = (each**2 for each in half)
    moments = (MASS / 3 * (y + z), MASS / 3 * (x + z), MASS / 3 * (x + y))
    plane = Contact("body", (0.0, 0.0, 1.0), friction=friction)
    return free(
        "coulomb_isotropic", gravity=(0.0, 0.0, -GRAVITY), inertia=moments, half_extents=half, contacts=(plane,)
    )


def oblique_hinge(gravity: Vector) -> tuple[SceneForm, Rates]:
    """A body on a hinge whose axis and arm lie along no axis of space or body, with its equations of motion."""

    def build(start: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        hinge = Hinge("pivot", "body", ANCHOR, OBLIQUE, arm=ARM, angle=start[0], rate=start[1])
        return Scene(gravity, (Body("body", MASS, INERTIA),), hinges=(hinge,))

    axis, arm = np.array(OBLIQUE), np.array(ARM)
    lever = np.cross(axis, arm)
    moment = axis @ (np.array(INERTIA) * axis) + MASS * lever @ lever

    def rates(t: float, y: Floats) -> Floats:
        across = np.cos(y[0]) * lever + np.sin(y[0]) * np.cross(axis, lever)  # axis x arm, turned by the angle
        return np.array([y[1], MASS * (across @ np.array(gravity)) / moment])

    return SceneForm(build, joint("pivot"), frozenset({"hinge"})), rates


def oblique_slider(gravity: Vector) -> tuple[SceneForm, Rates]:
    """A body on a rail that lies along no axis of space, with its equations of motion."""

    def build(start: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        rail = Slider("rail", "body", ANCHOR, OBLIQUE, position=start[0], rate=start[1])
        return Scene(gravity, (Body("body", MASS, INERTIA),), sliders=(rail,))

    def rates(t: float, y: Floats) -> Floats:
        return np.array([y[1], np.dot(OBLIQUE, gravity)])

    return SceneForm(build, joint("rail"), frozenset({"slider"})), rates


def flow(rates: Rates, start: Floats, t: float, steps: int) -> Floats:
    """The state at time t, by the classical Runge-Kutta method of order 4 with this number of steps."""
    y, h = start, t / steps
    for step in range(steps):
        now = step * h
        a = rates(now, y)
        b = rates(now + h / 2, y + h / 2 * a)
        c = rates(now + h / 2, y + h / 2 * b)
        d = rates(now + h, y + h * c)
        y = y + h / 6 * (a + 2 * b + 2 * c + d)
    return y

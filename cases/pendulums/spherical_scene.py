"""Scene of the spherical pendulum: a point mass on a ball joint (token `ball_joint`)."""

from __future__ import annotations

from math import sin

import mpmath
import numpy as np
from gnomon.cases.core.scene import Body, Readings, Scene, SceneForm
from gnomon.cases.pendulums.spherical_cartesian import from_the_sphere, on_the_sphere


def ball_joint_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """The joint is at the origin; at the lowest point, where the azimuth is not defined, the bob starts at rest."""
    g, length, _h = parameters
    placed = on_the_sphere(mpmath.fp, state, parameters) if sin(state[0]) else (0.0, 0.0, -length, 0.0, 0.0, 0.0)
    x, y, z, vx, vy, vz = map(float, placed)
    bob = Body("bob", 1.0, (0.0, 0.0, 0.0), (x, y, z), velocity=(vx, vy, vz))
    return Scene((0.0, 0.0, -g), (bob,))


def ball_joint_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    position, _, velocity, _ = readings.bodies["bob"]
    return tuple(map(float, from_the_sphere(np.array([*position, *velocity]), parameters)))


SCENE = SceneForm(ball_joint_scene, ball_joint_reading, frozenset({"ball_joint"}))

"""The small-amplitude Foucault pendulum as a physics engine is given it: a free point mass in the horizontal plane.

The pull to the centre and the Coriolis force are one force on it.
"""

from __future__ import annotations

from math import sin

from gnomon.cases.core.scene import Body, Force, Readings, Scene, SceneForm, Vector


def foucault_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    x, y, vx, vy = state
    g, length, turning, latitude = parameters

    def pull_and_coriolis(t: float, position: Vector, velocity: Vector) -> Vector:
        stiffness, spin = g / length, turning * sin(latitude)
        return -stiffness * position[0] + 2 * spin * velocity[1], -stiffness * position[1] - 2 * spin * velocity[0], 0.0

    bob = Body("bob", 1.0, (0.0, 0.0, 0.0), (x, y, 0.0), velocity=(vx, vy, 0.0))
    return Scene((0.0, 0.0, 0.0), (bob,), forces=(Force("bob", "velocity_force", pull_and_coriolis),))


def foucault_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    position, _, velocity, _ = readings.bodies["bob"]
    return position[0], position[1], velocity[0], velocity[1]


SCENE = SceneForm(foucault_scene, foucault_reading, frozenset({"velocity_force"}), conservative=False)
"""Not staggered: the Coriolis force depends on the velocity."""

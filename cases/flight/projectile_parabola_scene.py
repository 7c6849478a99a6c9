"""Scene of the projectile: a free point mass under gravity; y is along the engine's z."""

from __future__ import annotations

from gnomon.cases.core.scene import Body, Readings, Scene, SceneForm


def projectile_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    x, y, vx, vy = state
    (g,) = parameters
    return Scene((0.0, 0.0, -g), (Body("projectile", 1.0, (0.0, 0.0, 0.0), (x, 0.0, y), velocity=(vx, 0.0, vy)),))


def projectile_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    position, _, velocity, _ = readings.bodies["projectile"]
    return position[0], position[2], velocity[0], velocity[2]


SCENE = SceneForm(projectile_scene, projectile_reading, frozenset())

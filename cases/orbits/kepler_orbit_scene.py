"""Scene of the Kepler orbit: a free point mass with the attraction as a force."""

from __future__ import annotations

from math import hypot

from gnomon.cases.core.scene import Body, Force, Readings, Scene, SceneForm, Vector


def kepler_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    x, y, vx, vy = state
    (mu,) = parameters

    def attraction(t: float, position: Vector, velocity: Vector) -> Vector:
        x, y, _ = position
        factor = -mu / hypot(x, y) ** 3
        return factor * x, factor * y, 0.0

    planet = Body("planet", 1.0, (0.0, 0.0, 0.0), (x, y, 0.0), velocity=(vx, vy, 0.0))
    return Scene((0.0, 0.0, 0.0), (planet,), forces=(Force("planet", "position_force", attraction),))


def kepler_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    position, _, velocity, _ = readings.bodies["planet"]
    return position[0], position[1], velocity[0], velocity[1]


SCENE = SceneForm(kepler_scene, kepler_reading, frozenset({"position_force"}))

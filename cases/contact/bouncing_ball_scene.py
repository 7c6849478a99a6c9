"""Scene of the bouncing ball: a sphere of radius 0.1 m above a plane; y is the gap between them."""

from __future__ import annotations

from gnomon.cases.core.scene import Body, Contact, Readings, Scene, SceneForm

RADIUS = 0.1


def bouncing_ball_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    y, v = state
    g, e = parameters
    moment = 2 * RADIUS**2 / 5
    ball = Body("ball", 1.0, (moment, moment, moment), (0.0, 0.0, RADIUS + y), velocity=(0.0, 0.0, v), radius=RADIUS)
    return Scene((0.0, 0.0, -g), (ball,), contacts=(Contact("ball", (0.0, 0.0, 1.0), restitution=e),))


def bouncing_ball_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    position, _, velocity, _ = readings.bodies["ball"]
    return position[2] - RADIUS, velocity[2]


SCENE = SceneForm(bouncing_ball_scene, bouncing_ball_reading, frozenset({"rigid_impact"}), conservative=False)
"""Not conservative in the sense of SceneForm: at an impact the velocity jumps."""

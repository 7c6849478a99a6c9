"""The billiard ball as a physics engine is given it: a sphere on a plane with friction, none of rolling or drilling."""

from __future__ import annotations

from gnomon.cases.scene import Body, Contact, Readings, Scene, SceneForm


def billiard_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    x, y, vx, vy, wx, wy, wz = state
    radius, mu, g = parameters
    moment = 2 * radius * radius / 5
    ball = Body(
        "ball",
        1.0,
        (moment, moment, moment),
        (x, y, radius),
        velocity=(vx, vy, 0.0),
        angular_velocity=(wx, wy, wz),
        radius=radius,
    )
    return Scene((0.0, 0.0, -g), (ball,), contacts=(Contact("ball", (0.0, 0.0, 1.0), friction=mu),))


def billiard_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    position, _, velocity, spin = readings.bodies["ball"]
    return position[0], position[1], velocity[0], velocity[1], *spin


SCENE = SceneForm(billiard_scene, billiard_reading, frozenset({"coulomb_isotropic"}), conservative=False)

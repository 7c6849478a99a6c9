"""Scenes of the billiard ball: a sphere on a plane with sliding friction; one adds drilling friction."""

from dataclasses import replace

from gnomon.cases.core.scene import Body, Contact, Readings, Scene, SceneForm
from gnomon.cases.scenes.attitude import matrix, quaternion


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


def attitude_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    scene = billiard_scene(state[:7], parameters)
    attitude = state[7:] if any(state[7:]) else (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    return replace(scene, bodies=(replace(scene.bodies[0], quaternion=quaternion(attitude)),))


def attitude_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    return (*billiard_reading(readings, parameters), *matrix(readings.bodies["ball"][1]))


def drill_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """The contact is a patch with drilling friction (token `drill_friction`)."""
    return billiard_scene(state, parameters[:3])


TOKENS = frozenset({"coulomb_isotropic"})
ATTITUDE_SCENE = SceneForm(attitude_scene, attitude_reading, TOKENS, conservative=False)
DRILL_SCENE = SceneForm(drill_scene, billiard_reading, TOKENS | {"drill_friction"}, conservative=False)

"""The pendulum in a rotating plane as a physics engine is given it: a hinge in the plane, and the centrifugal force.

Coriolis forces are across the plane: the hinge takes them.
"""

from __future__ import annotations

from gnomon.cases.scene import Body, Force, Hinge, Readings, Scene, SceneForm, Vector


def bead_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    theta, omega = state
    g, radius, rate = parameters

    def centrifugal(t: float, position: Vector, velocity: Vector) -> Vector:
        return rate * rate * position[0], 0.0, 0.0

    bob = Body("bob", 1.0, (0.0, 0.0, 0.0))
    hinge = Hinge("pivot", "bob", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -radius), theta, omega)
    force = Force("bob", "position_force", centrifugal)
    return Scene((0.0, 0.0, -g), (bob,), hinges=(hinge,), forces=(force,))


def bead_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    return readings.joints["pivot"]


SCENE = SceneForm(bead_scene, bead_reading, frozenset({"hinge", "position_force"}))

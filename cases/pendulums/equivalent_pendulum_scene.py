"""Scenes of a pendulum on an accelerated support (a hinge at rest in the apparent gravity) and a chain in a tube."""

from __future__ import annotations

from math import sin

from gnomon.cases.core.scene import Body, Hinge, Scene, SceneForm
from gnomon.cases.pendulums.pendulum_simple_scene import pendulum_reading


def carried_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    theta, omega = state
    g, length, ax, ay = parameters
    bob = Body("bob", 1.0, (0.0, 0.0, 0.0))
    hinge = Hinge("pivot", "bob", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -length), theta, omega)
    # theta grows towards -x, the direction in which the support is accelerated.
    return Scene((ax, 0.0, -(g + ay)), (bob,), hinges=(hinge,))


SCENE = SceneForm(carried_scene, pendulum_reading, frozenset({"hinge"}))


def tube_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """The chain in the tube moves as a rigid arc about the centre of the circle."""
    theta, omega = state
    g, length, radius = parameters
    arm = 2 * radius * radius / length * sin(length / (2 * radius))
    moment = max(radius * radius - arm * arm, 0.0)  # rounding makes it negative for a very short chain
    arc = Body("arc", 1.0, (moment, moment, moment))
    hinge = Hinge("pivot", "arc", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -arm), theta, omega)
    return Scene((0.0, 0.0, -g), (arc,), hinges=(hinge,))


TUBE = SceneForm(tube_scene, pendulum_reading, frozenset({"hinge"}))

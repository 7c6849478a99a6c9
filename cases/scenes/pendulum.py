"""Scene of the simple pendulum: a point mass on a hinge."""

from gnomon.cases.core.scene import Body, Hinge, Readings, Scene, SceneForm


def pendulum_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    theta, omega = state
    g, length = parameters
    bob = Body("bob", 1.0, (0.0, 0.0, 0.0))
    hinge = Hinge("pivot", "bob", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -length), theta, omega)
    return Scene((0.0, 0.0, -g), (bob,), hinges=(hinge,))


def pendulum_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    return readings.joints["pivot"]


SCENE = SceneForm(pendulum_scene, pendulum_reading, frozenset({"hinge"}))

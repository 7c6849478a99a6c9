"""Scene of the simple pendulum: a point mass on a hinge."""

from gnomon.cases.core.scene import Body, Hinge, Scene, SceneForm, joint


def pendulum_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    theta, omega = state
    g, length = parameters
    bob = Body("bob", 1.0, (0.0, 0.0, 0.0))
    hinge = Hinge("pivot", "bob", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -length), theta, omega)
    return Scene((0.0, 0.0, -g), (bob,), hinges=(hinge,))


SCENE = SceneForm(pendulum_scene, joint("pivot"), frozenset({"hinge"}))

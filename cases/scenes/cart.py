"""Scenes of bodies on moving bodies: a man on a cart, a pendulum on a cart, a block on a wedge."""

from math import cos, sin

from gnomon.cases.core.scene import Body, Hinge, Readings, Scene, SceneForm, Slider, joint
from gnomon.cases.scenes.two_masses import NO_INERTIA

Values = tuple[float, ...]
ORIGIN = (0.0, 0.0, 0.0)
ALONG = (1.0, 0.0, 0.0)


def man_scene(state: Values, parameters: Values) -> Scene:
    m, M, d, w = parameters
    bodies = (Body("cart", M, NO_INERTIA), Body("man", m, NO_INERTIA))

    def walk(t: float) -> float:
        return d * (1 - cos(w * t)) / 2

    wheels = Slider("wheels", "cart", ORIGIN, ALONG, *state)
    return Scene(
        ORIGIN, bodies, sliders=(wheels, Slider("walk", "man", ORIGIN, ALONG, 0.0, 0.0, parent="cart", drive=walk))
    )


def cart_pendulum_scene(state: Values, parameters: Values) -> Scene:
    x, theta, vx, omega = state
    g, m, M, length = parameters
    bodies = (Body("cart", M, NO_INERTIA), Body("bob", m, NO_INERTIA))
    # theta grows towards +x
    hinge = Hinge("hinge", "bob", ORIGIN, (0.0, -1.0, 0.0), (0.0, 0.0, -length), theta, omega, parent="cart")
    return Scene((0.0, 0.0, -g), bodies, hinges=(hinge,), sliders=(Slider("wheels", "cart", ORIGIN, ALONG, x, vx),))


def cart_pendulum_reading(readings: Readings, parameters: Values) -> Values:
    (x, vx), (theta, omega) = readings.joints["wheels"], readings.joints["hinge"]
    return x, theta, vx, omega


def wedge_scene(state: Values, parameters: Values) -> Scene:
    X, s, V, v = state
    g, m, M, alpha = parameters
    bodies = (Body("wedge", M, NO_INERTIA), Body("block", m, NO_INERTIA))
    face = Slider("face", "block", ORIGIN, (cos(alpha), 0.0, -sin(alpha)), s, v, parent="wedge")
    return Scene((0.0, 0.0, -g), bodies, sliders=(Slider("floor", "wedge", ORIGIN, ALONG, X, V), face))


def wedge_reading(readings: Readings, parameters: Values) -> Values:
    (X, V), (s, v) = readings.joints["floor"], readings.joints["face"]
    return X, s, V, v


MAN = SceneForm(man_scene, joint("wheels"), frozenset({"slider", "linked_joint", "driven_axis"}), conservative=False)
CART_PENDULUM = SceneForm(
    cart_pendulum_scene, cart_pendulum_reading, frozenset({"slider", "hinge", "linked_joint"}), conservative=False
)
WEDGE = SceneForm(wedge_scene, wedge_reading, frozenset({"slider", "linked_joint"}))

"""Scenes with an impulse: a bullet that hits a hanging block, an arm that is struck, a projectile that bursts."""

from __future__ import annotations

from gnomon.cases.core.scene import Body, Contact, Hinge, Readings, Scene, SceneForm, Slider
from gnomon.cases.core.two_masses_scene import NO_INERTIA
from gnomon.cases.pendulums.pendulum_simple_scene import pendulum_reading

Values = tuple[float, ...]
ORIGIN = (0.0, 0.0, 0.0)
ACROSS = (0.0, -1.0, 0.0)
"""The hinge axis about which a positive angle turns a hanging body towards +x."""


def ballistic_scene(state: Values, parameters: Values) -> Scene:
    """The bullet moves on a rail without weight until it sticks to the block (token `adhesion`)."""
    x, theta, u, omega = state
    g, length, m, M = parameters
    bodies = (Body("bullet", m, NO_INERTIA), Body("block", M, NO_INERTIA))
    pivot = Hinge("pivot", "block", ORIGIN, ACROSS, (0.0, 0.0, -length), theta, omega)
    barrel = Slider("barrel", "bullet", (0.0, 0.0, -length), (1.0, 0.0, 0.0), x, u)
    contact = Contact("bullet", (1.0, 0.0, 0.0), partner="block")
    return Scene((0.0, 0.0, -g), bodies, hinges=(pivot,), sliders=(barrel,), contacts=(contact,))


def ballistic_reading(readings: Readings, parameters: Values) -> Values:
    (x, u), (theta, omega) = readings.joints["barrel"], readings.joints["pivot"]
    return x, theta, u, omega


def arm_scene(state: Values, parameters: Values) -> Scene:
    """A uniform rod; the blow is an impulse at a given time (token `impulse`)."""
    theta, omega = state
    g, m, length, _H, _blow = parameters
    moment = m * length * length / 12
    rod = Body("arm", m, (moment, moment, 0.0))
    hinge = Hinge("pivot", "arm", ORIGIN, ACROSS, (0.0, 0.0, -length / 2), theta, omega)
    return Scene((0.0, 0.0, -g), (rod,), hinges=(hinge,))


def fragments_scene(state: Values, parameters: Values) -> Scene:
    """The parts fly together until the burst: opposite impulses on both at a given time."""
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    g, m1, m2, *_ = parameters
    bodies = (
        Body("part 1", m1, NO_INERTIA, (x1, 0.0, y1), velocity=(vx1, 0.0, vy1)),
        Body("part 2", m2, NO_INERTIA, (x2, 0.0, y2), velocity=(vx2, 0.0, vy2)),
    )
    return Scene((0.0, 0.0, -g), bodies)


def fragments_reading(readings: Readings, parameters: Values) -> Values:
    (r1, _, v1, _), (r2, _, v2, _) = (readings.bodies[f"part {n}"] for n in (1, 2))
    return r1[0], r1[2], r2[0], r2[2], v1[0], v1[2], v2[0], v2[2]


BALLISTIC = SceneForm(
    ballistic_scene, ballistic_reading, frozenset({"hinge", "slider", "body_contact", "adhesion"}), conservative=False
)
ARM = SceneForm(arm_scene, pendulum_reading, frozenset({"hinge", "impulse"}), conservative=False)
FRAGMENTS = SceneForm(fragments_scene, fragments_reading, frozenset({"impulse"}), conservative=False)

"""The block on an incline as a physics engine is given it: a flat box on a plane, gravity tilted by the angle."""

from __future__ import annotations

from fractions import Fraction
from math import cos, sin

from gnomon.cases.scene import Body, Contact, Readings, Scene, SceneForm
from gnomon.reference.block_incline import holds

HALF_EXTENTS = (0.5, 0.5, 0.1)


def block_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    s, v = state
    g, alpha, mu_k, _mu_s = parameters
    a, b, c = HALF_EXTENTS
    inertia = ((b * b + c * c) / 3, (a * a + c * c) / 3, (a * a + b * b) / 3)
    block = Body("block", 1.0, inertia, (s, 0.0, c), velocity=(v, 0.0, 0.0), half_extents=HALF_EXTENTS)
    contact = Contact("block", (0.0, 0.0, 1.0), friction=mu_k)
    return Scene((-g * sin(alpha), 0.0, -g * cos(alpha)), (block,), contacts=(contact,))


def block_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    position, _, velocity, _ = readings.bodies["block"]
    return position[0], velocity[0]


SCENE = SceneForm(block_scene, block_reading, frozenset({"coulomb_isotropic"}), conservative=False)
TWO_COEFFICIENTS = SceneForm(
    block_scene, block_reading, frozenset({"coulomb_isotropic", "static_friction"}), conservative=False
)


def scene_of(parameters: tuple[Fraction, ...]) -> SceneForm:
    """The scene needs a static coefficient of its own only where that decides whether the block holds."""
    _g, alpha, mu_k, mu_s = parameters
    return TWO_COEFFICIENTS if holds(alpha, mu_s) and not holds(alpha, mu_k) else SCENE

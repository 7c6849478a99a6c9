"""Scene of the block on an incline: a flat box on a horizontal plane with tilted gravity."""

from __future__ import annotations

from fractions import Fraction
from math import cos, sin

from gnomon.cases.core.box_scene import flat_box
from gnomon.cases.core.scene import SceneForm, Vector
from gnomon.reference.contact.block_incline_friction import holds


def tilted_gravity(parameters: tuple[float, ...]) -> Vector:
    g, alpha, _mu_k, _mu_s = parameters
    return -g * sin(alpha), 0.0, -g * cos(alpha)


SCENE, TWO_COEFFICIENTS = (
    flat_box(tilted_gravity, lambda parameters: parameters[2], *more) for more in ((), ("static_friction",))
)


def scene_of(parameters: tuple[Fraction, ...]) -> SceneForm:
    """The scene needs a separate static coefficient only if that decides whether the block holds."""
    _g, alpha, mu_k, mu_s = parameters
    return TWO_COEFFICIENTS if holds(alpha, mu_s) and not holds(alpha, mu_k) else SCENE

"""The spherical pendulum in Cartesian coordinates with its rod as a constraint: regular at the poles."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gnomon.cases.core.forms import Constrained, Values
from gnomon.cases.core.formulation import Formulation
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def sphere_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = g - lam r, z up from the point of suspension, with lam such that r stays on the sphere."""
    x, y, z, vx, vy, vz = state
    g, _length, _h = parameters
    lam = (vx * vx + vy * vy + vz * vz - g * z) / (x * x + y * y + z * z)
    return vx, vy, vz, -lam * x, -lam * y, -lam * z - g


def gravity_in_space(t: Any, place: Values, parameters: Values) -> Values:
    g, _length, _h = parameters
    return 0, 0, -g


def sphere(t: Any, place: Values, parameters: Values) -> Values:
    x, y, z = place
    return (x * x + y * y + z * z,)


def sphere_gradient(t: Any, place: Values, parameters: Values) -> Values:
    x, y, z = place
    return 2 * x, 2 * y, 2 * z


def on_the_sphere(mp: Any, state: Sequence[Any], parameters: Sequence[Any]) -> tuple[Any, ...]:
    """Position and velocity from the angles, the polar rate and the momentum h."""
    theta, omega, phi = state
    _g, length, h = parameters
    s, c, cosine, sine = mp.sin(theta), mp.cos(theta), mp.cos(phi), mp.sin(phi)
    outward, around = length * c * omega, length * h / s
    return (
        length * s * cosine,
        length * s * sine,
        -length * c,
        outward * cosine - around * sine,
        outward * sine + around * cosine,
        length * s * omega,
    )


def from_the_sphere(y: Floats, parameters: Sequence[float]) -> Floats:
    """The angles and the polar rate."""
    x1, x2, x3, v1, v2, v3 = np.moveaxis(y, -1, 0)
    radius = np.hypot(x1, x2)
    outward = (x1 * v1 + x2 * v2) / radius
    omega = (radius * v3 - x3 * outward) / (radius * radius + x3 * x3)
    return np.stack([np.arctan2(radius, -x3), omega, np.arctan2(x2, x1)], axis=-1)


CARTESIAN = Formulation(
    "Cartesian",
    (Constrained(sphere_equations, force=gravity_in_space, constraint=sphere, gradient=sphere_gradient),),
    on_the_sphere,
    from_the_sphere,
)

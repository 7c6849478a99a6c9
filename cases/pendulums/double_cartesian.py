"""The double pendulum in Cartesian coordinates: two point masses under two constraints, regular and without angles."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gnomon.cases.core.elimination import index_one
from gnomon.cases.core.forms import Constrained, Values
from gnomon.cases.core.formulation import Formulation
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def two_weights(t: Any, place: Values, parameters: Values) -> Values:
    m1, m2, _l1, _l2, g = parameters
    return 0, -m1 * g, 0, -m2 * g


def two_masses(t: Any, place: Values, parameters: Values) -> Values:
    m1, m2, _l1, _l2, _g = parameters
    return m1, 0, 0, 0, 0, m1, 0, 0, 0, 0, m2, 0, 0, 0, 0, m2


def two_rods(t: Any, place: Values, parameters: Values) -> Values:
    """Half the squares of the lengths."""
    x1, y1, x2, y2 = place
    x, y = x2 - x1, y2 - y1
    return (x1 * x1 + y1 * y1) / 2, (x * x + y * y) / 2


def along_two_rods(t: Any, place: Values, parameters: Values) -> Values:
    x1, y1, x2, y2 = place
    x, y = x2 - x1, y2 - y1
    return x1, y1, 0, 0, -x, -y, x, y


def bend_of_two_rods(t: Any, state: Values, parameters: Values) -> Values:
    u1, v1, u2, v2 = state[4:]
    u, v = u2 - u1, v2 - v1
    return u1 * u1 + v1 * v1, u * u + v * v


def on_two_rods(mp: Any, state: Sequence[Any], parameters: Sequence[Any]) -> tuple[Any, ...]:
    """Positions and velocities from the angles and their rates, y up from the pivot."""
    th1, th2, w1, w2 = state
    _m1, _m2, l1, l2, _g = parameters
    x1, y1, u1, v1 = l1 * mp.sin(th1), -l1 * mp.cos(th1), l1 * w1 * mp.cos(th1), l1 * w1 * mp.sin(th1)
    x, y, u, v = l2 * mp.sin(th2), -l2 * mp.cos(th2), l2 * w2 * mp.cos(th2), l2 * w2 * mp.sin(th2)
    return x1, y1, x1 + x, y1 + y, u1, v1, u1 + u, v1 + v


def from_two_rods(y: Floats, parameters: Sequence[float]) -> Floats:
    """The angles, from -pi to pi, and their rates."""
    x1, y1, x2, y2, u1, v1, u2, v2 = np.moveaxis(y, -1, 0)
    rods = ((x1, y1, u1, v1), (x2 - x1, y2 - y1, u2 - u1, v2 - v1))
    angles = [np.arctan2(x, -z) for x, z, _, _ in rods]
    rates = [(x * v - z * u) / (x * x + z * z) for x, z, u, v in rods]
    return np.stack([*angles, *rates], axis=-1)


CARTESIAN = Formulation(
    "Cartesian",
    (
        Constrained(
            index_one(force=two_weights, gradient=along_two_rods, curvature=bend_of_two_rods, mass=two_masses),
            force=two_weights, constraint=two_rods, gradient=along_two_rods, mass=two_masses,
        ),
    ),
    on_two_rods,
    from_two_rods,
)  # fmt: skip
"""The pendulum in Cartesian coordinates: two constraints with their multipliers."""

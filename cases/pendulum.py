"""The simple pendulum."""

from __future__ import annotations

from math import cos, sin
from typing import Any

from gnomon.cases.forms import Values


def acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """theta'' = -(g/L) sin(theta)."""
    (theta,) = q
    g, length = parameters
    return (-(g / length) * sin(theta),)


def potential(t: Any, q: Values, parameters: Values) -> Values:
    (theta,) = q
    g, length = parameters
    return (-(g / length) * cos(theta),)

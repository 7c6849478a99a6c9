"""Hamilton's action along actual motions, and its second variation, in balls (Beatty, Dynamics, 11.11)."""

from __future__ import annotations

from typing import Any

import flint
from gnomon.reference.numerics.vectors import square


def oscillator(m: Any, w: Any, T: Any, begin: Any, end: Any) -> Any:
    """Action of m x'' = -m w^2 x from x = begin to x = end in the time T; infinite at the conjugate points w T = n pi."""
    cosine, sine = (w * T).cos(), (w * T).sin()
    return m * w / (2 * sine) * ((begin * begin + end * end) * cosine - 2 * begin * end)


def fall(m: Any, g: Any, T: Any, begin: Any, end: Any) -> Any:
    """Action of m y'' = -m g from y = begin to y = end in the time T."""
    return m * square(end - begin) / (2 * T) - m * g * T * (begin + end) / 2 - m * g * g * T**3 / 24


def variation(m: Any, w: Any, T: Any, size: Any, mode: int) -> Any:
    """The change of the action when size sin(mode pi t/T) is added to the path; w = 0 for a force independent of x.

    The Lagrangian is quadratic, and the first variation vanishes on the actual path: only the second one is left.
    """
    rate = mode * flint.arb.pi() / T
    return size * size * m * T / 4 * (rate - w) * (rate + w)

"""The increment of a step of RK4, and steps with a planted fault in the increment."""

from typing import Any

import numpy as np


def increment(f: Any, t: float, y: Any, h: float) -> Any:
    a = f(t, y)
    b = f(t + h / 2, y + h / 2 * a)
    c = f(t + h / 2, y + h / 2 * b)
    return h / 6 * (a + 2 * b + 2 * c + f(t + h, y + h * c))


def drops_small_increments(f: Any, t: float, y: Any, h: float) -> Any:
    change = increment(f, t, y, h)
    return y + np.where(np.abs(change) < 1e-3, 0.0, change)


def first_component_by_euler(f: Any, t: float, y: Any, h: float) -> Any:
    found = y + increment(f, t, y, h)
    found[0] = y[0] + h * f(t, y)[0]
    return found

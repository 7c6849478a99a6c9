"""Equations that fail: during the motion, at once, as stiff ones; and the scalar problem that they are tested on."""

from math import sqrt
from typing import Any

import numpy as np
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.harness.contract.integrator import Problem


def scalar(equations: Any) -> Problem:
    """x' = f(x) over two seconds."""
    return Problem(FirstOrder(equations), 1, np.zeros(0), np.arange(1, 65) * 0.03125, 1.0)


def squared(t: Any, state: Values, parameters: Values) -> Values:
    """x' = x^2 from x = 1 reaches infinity at t = 1."""
    (x,) = state
    return (x * x,)


def undefined(t: Any, state: Values, parameters: Values) -> Values:
    """Not a number at every state."""
    (x,) = state
    return (sqrt(-1 - x * x),)


def stiff(t: Any, state: Values, parameters: Values) -> Values:
    (x,) = state
    return (-100000000 * x,)

"""Störmer-Verlet in its velocity form."""

import numpy as np


def step(f, t, y, h):
    """One step of size h from the state y = (q, v) at t; f(t, q) gives the accelerations."""
    q, v = np.split(y, 2)
    middle = v + h / 2 * f(t, q)
    q = q + h * middle
    return np.concatenate([q, middle + h / 2 * f(t + h, q)])

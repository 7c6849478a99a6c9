"""Impacts of engines whose contacts are springs and dampers."""

from math import atan2, exp, log, sqrt


def rebound(ratio: float) -> float:
    """The coefficient of restitution of a spring and damper with `ratio` of the critical damping.

    The contact ends when its force is zero, before the spring is relaxed (Schwager and Poschel, Granular Matter 9, 2007, 465).
    """
    if ratio < 1:
        root = sqrt(1 - ratio * ratio)
        return exp(-ratio / root * atan2(2 * ratio * root, 2 * ratio * ratio - 1))
    root = sqrt(ratio * ratio - 1)
    return exp(-ratio / root * log((ratio + root) / (ratio - root))) if root else exp(-2.0)


def damping_ratio(restitution: float) -> float:
    """The share of the critical damping that gives this coefficient of restitution, which is above 0."""
    low, high = 0.0, 1.0
    while rebound(high) > restitution:
        high *= 2
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if rebound(middle) > restitution else (low, middle)
    return high

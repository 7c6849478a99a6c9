"""The time scale of uniformly accelerated motions, which three machines share."""

from math import sqrt


def fall_time(speed: float, acceleration: float) -> float:
    """Initial speed over acceleration; from rest the time of the first metre; 1 s without acceleration."""
    return (speed / acceleration or sqrt(2 / acceleration)) if acceleration else 1.0

"""Actions, energies and averaged frequencies of stiff vibrations, computed independently: from derivatives of the motion."""

from typing import Any

import mpmath
from independent_quantities import ObservedMotion, close, oracle
from mpmath import sqrt

STEPS = 300
"""Steps of a Runge-Kutta method over a period of the pivot."""
AVERAGING = 0.02
"""The relative error of averaging, about the square of the ratio of the frequencies, here 1/14, and of a/L."""


@oracle("stiff_spring_pendulum.fast_action")
def of_the_length(observed: ObservedMotion, value: Any) -> Any:
    """The length r vibrates as r'' = -w^2 s about the length at which the forces along the spring are balanced."""

    def length(t: Any) -> Any:
        here = observed.at(t)
        return sqrt(here.x**2 + here.y**2)

    def rate(t: Any) -> Any:
        here = observed.at(t)
        return (here.x * here.vx + here.y * here.vy) / length(t)

    w = observed.p.w
    return close(value, (rate(0) ** 2 + (observed.slope(rate) / w) ** 2) / (2 * w), 12)


def stiffness_across(observed: ObservedMotion) -> Any:
    return -observed.equations(observed.state(0))[3] / observed.at(0).y


@oracle("local_frequency")
def of_the_force_across(observed: ObservedMotion, value: Any) -> Any:
    return sqrt(stiffness_across(observed))


@oracle("stiff_valley.fast_action")
def area_in_phase_space(observed: ObservedMotion, value: Any) -> Any:
    """The area of the ellipse over 2 pi: half the product of the largest y and the largest velocity."""
    here, square = observed.at(0), stiffness_across(observed)
    largest = sqrt(here.y**2 + here.vy**2 / square)
    return largest * largest * sqrt(square) / 2


def energy_of_a_stiff_spring(observed: ObservedMotion, i: int, t: Any) -> Any:
    """By the displacements of its two masses: a spring of stiffness w^2/2 and the kinetic energy of the relative motion."""
    found = vars(observed.at(t))
    opening, rate = (
        (found[f"{slow}{i}"] + found[f"{fast}{i}"] - found[f"{slow}{i}"] + found[f"{fast}{i}"]) / sqrt(2)
        for slow, fast in (("q", "s"), ("v", "u"))
    )
    return observed.p.w**2 / 2 * opening**2 / 2 + rate**2 / 4


@oracle("stiff_energy_1")
def of_the_first(observed: ObservedMotion, value: Any) -> Any:
    return energy_of_a_stiff_spring(observed, 1, observed.span)


@oracle("stiff_energy_2")
def of_the_second(observed: ObservedMotion, value: Any) -> Any:
    return energy_of_a_stiff_spring(observed, 2, observed.span)


@oracle("stiff_energy_3")
def of_the_third(observed: ObservedMotion, value: Any) -> Any:
    return energy_of_a_stiff_spring(observed, 3, observed.span)


@oracle("stiff_energy")
def of_all(observed: ObservedMotion, value: Any) -> Any:
    return sum(energy_of_a_stiff_spring(observed, i, 0) for i in (1, 2, 3))


def floquet_frequency(observed: ObservedMotion, place: Any) -> Any:
    """The frequency of small motions about an equilibrium: their growth over a period of the pivot is exp(+- i w T)."""
    period = 2 * mpmath.pi / observed.p.w
    h = period / STEPS
    small = mpmath.mpf(10) ** -12

    def rates(t: Any, y: Any) -> Any:
        return observed.equations([place + y[0], y[1]], t)

    trace = mpmath.mpf(0)
    for k in range(2):
        y = [small * (k == 0), small * (k == 1)]
        for n in range(STEPS):
            t = n * h
            a = rates(t, y)
            b = rates(t + h / 2, [u + h / 2 * v for u, v in zip(y, a, strict=True)])
            c = rates(t + h / 2, [u + h / 2 * v for u, v in zip(y, b, strict=True)])
            d = rates(t + h, [u + h * v for u, v in zip(y, c, strict=True)])
            y = [u + h / 6 * (p + 2 * q + 2 * r + s) for u, p, q, r, s in zip(y, a, b, c, d, strict=True)]
        trace += y[k] / small
    return mpmath.acos(trace / 2) / period


@oracle("averaged_hanging_frequency")
def about_the_bottom(observed: ObservedMotion, value: Any) -> bool:
    return abs(floquet_frequency(observed, mpmath.mpf(0)) / value - 1) < AVERAGING


@oracle("averaged_upright_frequency")
def about_the_top(observed: ObservedMotion, value: Any) -> bool:
    return abs(floquet_frequency(observed, +mpmath.pi) / value - 1) < AVERAGING

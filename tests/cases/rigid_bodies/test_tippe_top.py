"""The tippe top turns over when, and as, its literature says: Jellett's integral, the power of friction, stability."""

from collections.abc import Iterator
from typing import Any

import mpmath
import numpy as np
import pytest
from gnomon.cases import Case, get
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.rigid_bodies.tippe_top import (
    glide,
    jellett,
    squared_eccentricity,
    tippe_energy,
    tippe_equations,
    turned_axis,
)
from mpmath import mpf

TIMES = ("0.1", "0.2", "0.3")
SPAN = "0.3"
"""It tilts to 13 degrees: the whole inversion takes longer to integrate."""
FOUND = {
    each.__name__: rebind(each, mpmath_arithmetic(mpmath.mp))
    for each in (tippe_equations, tippe_energy, jellett, squared_eccentricity)
}


@pytest.fixture(autouse=True)
def _digits() -> Iterator[None]:
    with mpmath.workdps(40):
        yield


def numbers(case: Case) -> tuple[Any, ...]:
    return tuple(mpf(x.numerator) / x.denominator for x in case.parameter_values())


def exact(case: Case, t: Any) -> tuple[Any, ...]:
    return tuple(map(mpf, case.exact(t, 30)))


def drift(label: str, case: Case, t: Any) -> Any:
    """The relative change of an invariant from the start to t."""
    values, invariant = numbers(case), FOUND[label]
    first, later = (invariant(0, exact(case, when), values)[0] for when in (0, t))
    return abs(later / first - 1)


@pytest.mark.parametrize("t", TIMES)
def test_jelletts_integral_is_constant_to_28_digits_whatever_the_friction(t: str) -> None:
    """The force of the plane has no torque about the line from the centre of mass to the point of contact."""
    case = get("tippe_top", span=SPAN)
    assert drift("jellett", case, t) < 1e-28
    assert drift("squared_eccentricity", case, t) < 1e-28
    assert drift("tippe_energy", case, t) > 1e-4


@pytest.mark.parametrize("t", TIMES)
def test_without_friction_energy_and_both_angular_momenta_are_constant(t: str) -> None:
    """The normal force has no torque about the vertical nor about the axis, and no horizontal component."""
    case = get("tippe_top", "frictionless", span=SPAN)
    assert drift("tippe_energy", case, t) < 1e-28
    start, later = exact(case, 0), exact(case, t)
    along = [sum(a * b for a, b in zip(state[:3], state[3:6], strict=True)) for state in (start, later)]
    assert abs(along[1] / along[0] - 1) < 1e-28
    assert later[6:] == (0, 0)


@pytest.mark.parametrize("t", TIMES)
def test_energy_decays_with_the_power_of_friction(t: str) -> None:
    """E' = -mu N v^2, where N = m (g - R e_z'') is the weight with the vertical acceleration of the centre of mass."""
    case = get("tippe_top", span=SPAN)
    values, state = numbers(case), exact(case, t)
    m, R, _I1, _I3, mu, g = values
    slopes = FOUND["tippe_equations"](0, state, values)

    def onward(h: Any) -> tuple[Any, ...]:
        return tuple(x + h * rate for x, rate in zip(state, slopes, strict=True))

    power = mpmath.diff(lambda h: FOUND["tippe_energy"](0, onward(h), values)[0], 0)
    normal = m * (g - R * mpmath.diff(lambda h: turned_axis(onward(h))[2], 0))
    gliding = sum(v * v for v in glide(state, turned_axis(state), values))
    assert gliding > 1e-6
    assert abs(power / (-mu * normal * gliding) - 1) < 1e-15


def growth(side: int, ratio: float) -> float:
    """The fastest growth (1/s) of small changes of the spin about the vertical, with Jellett's integral at `ratio` of its
    limit; `side` is -1 upside down."""
    case = get("tippe_top")
    values = tuple(map(float, case.parameter_values()))
    limit, alpha = float(case.quantities()["jellett_limit"]), 0.3
    spin = ratio * limit / (values[1] * values[3] * (1 - side * alpha))
    state, h = np.array([0, 0, spin, 0, 0, side * alpha, 0, 0]), 1e-6
    columns = [
        np.subtract(*(tippe_equations(0, tuple(state + sign * h * unit), values) for sign in (1, -1))) / (2 * h)
        for unit in np.eye(8)
    ]
    return float(np.max(np.linalg.eigvals(np.array(columns).T).real))


def test_upside_down_is_stable_above_the_published_limit_only() -> None:
    """SIGMA 10 (2014) 017: the limit sqrt(m g R^3 I3 alpha) (1 + alpha)^2/sqrt(1 + alpha - I1/I3) of Jellett's integral,
    if 1 - alpha < I1/I3 < 1. The spin and the height do not change back: growth zero up to rounding."""
    assert growth(-1, 0.99) > 1e-3
    assert growth(-1, 1.01) < 1e-5
    assert growth(1, 1.01) > 1e-3


@pytest.mark.slow
def test_it_turns_over_above_the_limit() -> None:
    """Upside down it keeps Jellett's integral, so its spin is (1 - alpha)/(1 + alpha) of the first one."""
    case = get("tippe_top")
    assert float(case.quantities()["jellett_ratio"]) > 1
    end = case.exact(case.span)
    assert float(end[5]) < -0.997 * 0.3
    assert abs(float(end[2]) / 155 / (0.7 / 1.3) - 1) < 2e-3
    slow = get("tippe_top", "slow_spin")
    assert float(slow.quantities()["jellett_ratio"]) < 1
    assert float(slow.exact(slow.span)[5]) > 0.9997 * 0.3

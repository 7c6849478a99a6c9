"""Splitting methods with a force that depends on time, and symplectic Euler compared with its formula."""

from fractions import Fraction
from typing import Any

import pytest
from gnomon.cases.core.forms import SecondOrder, Values
from gnomon.harness.integrators.geometric import splitting
from gnomon.harness.integrators.geometric.splitting import Splitting, SymplecticEuler
from gnomon.harness.studies.orders import solve_exactly
from gnomon.reference.numerics.precision import working

METHODS: tuple[type[Splitting], ...] = splitting.INTEGRATORS  # type: ignore[assignment]


def power_of_time(t: Any, q: Values, parameters: Values) -> Values:
    """The sum of c_m t^m."""
    total = 0 * t
    for m in range(8):
        total = total + parameters[m] * t**m
    return (total,)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_time_drifts_with_the_position(method: type[Splitting]) -> None:
    """With a force that depends only on time the kicks are a quadrature, exact for powers of time below the order."""
    assert method.order is not None
    for m in range(method.order):
        coefficients = [Fraction(k == m) for k in range(8)]
        with working(60) as mp:
            _, v = solve_exactly(method(), SecondOrder(power_of_time), coefficients, (0, 0), Fraction(3, 2), 1)  # type: ignore[arg-type]
            wanted = mp.mpf(3) / 2
            assert abs(v - wanted ** (m + 1) / (m + 1)) < 1e-24, "two lengths are printed to 26 digits"


def spring_and_time(t: Any, q: Values, parameters: Values) -> Values:
    return (t - 2 * q[0],)


def test_symplectic_euler_kicks_with_the_old_position_and_drifts_with_the_new_velocity() -> None:
    q, v = 3, 5
    for step in range(2):
        v += (Fraction(step, 4) - 2 * q) * Fraction(1, 4)  # type: ignore[assignment]
        q += v * Fraction(1, 4)  # type: ignore[assignment]
    start = (Fraction(3), Fraction(5))
    found = solve_exactly(SymplecticEuler(), SecondOrder(spring_and_time), (), start, Fraction(1, 2), 2)
    assert [Fraction(str(x)) for x in found] == [q, v]

"""Stiff vibrations: adiabatic invariants, the exchange of energy in the chain of Fermi, Pasta, Ulam and Tsingou, limits."""

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from gnomon.cases import get
from gnomon.cases.oscillators.fermi_pasta_ulam import fermi_equations, stiff_energies
from gnomon.cases.oscillators.stiff_valley import valley_action
from gnomon.cases.pendulums.stiff_spring_pendulum import fast_action
from scipy.integrate import solve_ivp

SPRING, VALLEY = "stiff_spring_pendulum", "stiff_valley"


def wander(name: str, variant: str | None, action: Callable[[Any, Any], Any]) -> float:
    """The relative range of an action over the span."""
    case = get(name, variant)
    parameters = tuple(map(float, case.parameter_values()))
    found = [action(state, parameters) for state in case.sample(np.linspace(0.0, float(case.span), 200)).tolist()]
    return (max(found) - min(found)) / found[0]


@pytest.mark.parametrize(
    ("name", "variant", "action", "bound"),
    [
        pytest.param(SPRING, None, fast_action, 0.11, marks=pytest.mark.slow),
        pytest.param(SPRING, "ratio_100", fast_action, 1.1e-3, marks=pytest.mark.slow),
        pytest.param(SPRING, "ratio_1000", fast_action, 1.1e-5, marks=pytest.mark.slow),
        pytest.param(VALLEY, None, valley_action, 2e-2, marks=pytest.mark.slow),
        pytest.param(VALLEY, "steep", valley_action, 5e-3, marks=pytest.mark.slow),
        pytest.param(VALLEY, "steepest", valley_action, 5e-4, marks=pytest.mark.slow),
    ],
)
def test_the_adiabatic_invariant_stays_within_a_power_of_the_ratio(
    name: str, variant: str | None, action: Callable[[Any, Any], Any], bound: float
) -> None:
    """Energy over frequency of the fast vibration is not constant: it wanders by w^-2 about the balanced length of the
    spring, by w^-1 in the valley, whose frequency itself changes."""
    assert bound / 20 < wander(name, variant, action) < bound


def exchanged(w: float, times: list[float]) -> Any:
    start = [1, 0, 0, 1 / w, 0, 0, 1, 0, 0, 1, 0, 0]
    found = solve_ivp(
        lambda t, y: fermi_equations(t, tuple(y), (1.0, w)),
        (0.0, times[-1]),
        start,
        method="DOP853",
        rtol=1e-9,
        atol=1e-11,
        t_eval=times,
    )
    return np.array([stiff_energies(tuple(y), (1.0, w)) for y in found.y.T])


@pytest.mark.slow
def test_the_first_stiff_spring_gives_its_energy_to_the_third() -> None:
    """Hairer, Lubich and Wanner, Geometric Numerical Integration, figure I.5.2, w = 50: at first I_1 = 1, on the way I_2 has
    up to half, then I_3 has nearly all at about t = 170; the sum stays near 1. The time of the exchange is of order w."""
    start, middle, late = exchanged(50.0, [0.0, 80.0, 170.0])
    assert start == pytest.approx([1, 0, 0])
    assert 0.4 < middle[1] < 0.6
    assert late[2] > 0.9
    assert late[0] < 0.05
    for row in (middle, late):
        assert row.sum() == pytest.approx(1, abs=0.06)
    # At w = 25 the same stage comes at half the time.
    (sooner,) = exchanged(25.0, [0.0, 40.0])[1:]
    assert 0.4 < sooner[1] < 0.6


def test_without_narrowing_the_valley_is_two_harmonic_oscillators() -> None:
    case = get(VALLEY, "uniform")
    x, y, _vx, _vy = case.exact("7.3", 30)
    with mpmath.workdps(40):
        t, w = mpmath.mpf("7.3"), mpmath.mpf(25)
        assert abs(x - mpmath.cos(t)) < mpmath.mpf(10) ** -29
        wave = mpmath.mpf("0.04") * mpmath.cos(w * t) + mpmath.mpf("0.5") / w * mpmath.sin(w * t)
        assert abs(y - wave) < mpmath.mpf(10) ** -30


def test_a_pivot_at_rest_leaves_the_pendulum() -> None:
    """The closed form of the pendulum, in elliptic functions, to 29 digits."""
    still = get("kapitza_pendulum_driven", a=0, initial_state=(2, 0), span=5)
    plain = get("pendulum_simple", g=1, L=1, initial_state=(2, 0), span=5)
    for driven, free in zip(still.exact("4.1", 30), plain.exact("4.1", 30), strict=True):
        assert abs(driven - free) < mpmath.mpf(10) ** -28


@pytest.mark.slow
def test_the_pivot_holds_the_pendulum_upright_where_kapitza_says() -> None:
    """a w = 3 is above sqrt(2 g L): the rod stays within 0.3 rad of the top. a w = 1.35 is below: it falls."""
    times = np.linspace(0.0, 10.3, 100)
    held, fallen = (
        np.abs(get("kapitza_pendulum_driven", variant).sample(times)[:, 0] - math.pi).max()
        for variant in (None, "falls")
    )
    assert held < 0.3
    assert fallen > 2


def test_a_rigid_rope_makes_one_mass_of_crane_and_load() -> None:
    """For k = 1e12 both move as a mass M + m on the mount under the same force, up to F/k and (w/w_rope)^2."""
    start = (Fraction(1, 10), Fraction(1, 10), 0, 0)
    hoist = get("stiff_load_forced", k=10**12, initial_state=start, w=5, F=1, span=3)
    single = get("forced_oscillator", m=3, c=0, k=3, F0=1, w=5, initial_state=(Fraction(1, 10), 0), span=3)
    for t in ("0.7", "2.9"):
        assert hoist.exact(t, 20)[0] == pytest.approx(float(single.exact(t, 20)[0]), abs=1e-9)

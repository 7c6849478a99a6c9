"""Chaotic cases: special starts with a known motion, other equations of the same motion, and the horizons that they state."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from gnomon.cases import Case, case_class, get, names
from gnomon.cases.core.integrated import IntegratedCase

CHAOTIC = [
    (name, variant)
    for name in names()
    for variant, horizon in [
        (None, case_class(name).default_horizon),
        *((v.name, v.horizon) for v in case_class(name).variants),
    ]
    if horizon is not None
]


def test_a_star_on_the_axis_of_the_galaxy_has_the_period_of_a_quadrature() -> None:
    """On x = 0 the motion is y'' = -y + y^2. From rest at 1/2, v^2 is 2/3 of (1/2 - y)(y^2 - y - 1/2) with three roots."""
    case = get("henon_heiles", initial_state=(0, "0.5", 0, 0), span=7)
    with mpmath.workdps(40):
        low, high, far = (1 - mpmath.sqrt(3)) / 2, mpmath.mpf("0.5"), (1 + mpmath.sqrt(3)) / 2
        # Withy = low + (high - low) sin(a)^2 the integrand is smooth.
        period = 2 * mpmath.quad(
            lambda a: 2 / mpmath.sqrt(mpmath.mpf(2) / 3 * (far - low - (high - low) * mpmath.sin(a) ** 2)),
            [0, mpmath.pi / 2],
        )
        x, y, vx, vy = case.exact(period, 30)
        assert (x, vx) == (0, 0)
        assert abs(y - mpmath.mpf("0.5")) < mpmath.mpf(10) ** -29
        assert abs(vy) < mpmath.mpf(10) ** -29
        _, turned, _, _ = case.exact(period / 2, 30)
        assert abs(turned - low) < mpmath.mpf(10) ** -29


def test_a_third_of_a_turn_maps_one_motion_of_the_star_to_another() -> None:
    """The potential has the symmetry of a triangle, which none of its equations shows."""
    with mpmath.workdps(40):
        c, s = mpmath.mpf(-1) / 2, mpmath.sqrt(3) / 2
        start = [mpmath.mpf(value) for value in ("0.1", "0.2", "0.3", "-0.1")]
        turned = [
            c * start[0] - s * start[1],
            s * start[0] + c * start[1],
            c * start[2] - s * start[3],
            s * start[2] + c * start[3],
        ]
        one = get("henon_heiles", initial_state=start, span=10).exact(9, 32)
        two = get("henon_heiles", initial_state=turned, span=10).exact(9, 32)
        for k in (0, 2):
            assert abs(c * one[k] - s * one[k + 1] - two[k]) < mpmath.mpf(10) ** -29
            assert abs(s * one[k] + c * one[k + 1] - two[k + 1]) < mpmath.mpf(10) ** -29


def test_without_torque_and_damping_the_driven_pendulum_is_the_pendulum() -> None:
    driven = get("driven_pendulum", initial_state=("1.1", "0.3"), c=0, F=0, span=20)
    free = get("pendulum_simple", initial_state=("1.1", "0.3"), g=1, L=1, span=20)
    with mpmath.workdps(40):
        for t in (3, 19):
            for a, b in zip(driven.exact(t, 32), free.exact(t, 32), strict=True):
                assert abs(a - b) < mpmath.mpf(10) ** -29


@pytest.mark.slow
def test_the_plane_problem_is_the_problem_in_space_at_height_zero() -> None:
    """Through the first encounter, by the equations of `equilateral_three_body`, in three coordinates each."""
    plane = get("three_body_pythagorean", span="2.5")
    flat = [*plane.initial_state[:6]]
    places = [value for k in (0, 2, 4) for value in (*flat[k : k + 2], 0)]
    space = get("equilateral_three_body", initial_state=(*places, *[0] * 9), span="2.5", m1=3, m2=4, m3=5)
    with mpmath.workdps(40):
        one, two = plane.exact("2.4", 30), space.exact("2.4", 30)
        inside = [two[k + i] for k in (0, 3, 6, 9, 12, 15) for i in (0, 1)]
        for a, b in zip(one, inside, strict=True):
            assert abs(a - b) < mpmath.mpf(10) ** -26


def crossing(case: Case) -> float:
    """The first of 160 times up to 1.1 horizons at which the conditioning is 1; after an impact it may be so for a moment."""
    assert case.horizon is not None
    times = np.linspace(0.8, 1.1, 160) * case.horizon
    found = case.rounded().with_span(Fraction(float(times[-1]))).conditioning(times)
    return float(times[np.argmax(found >= 1)])


@pytest.mark.slow
@pytest.mark.parametrize(("name", "variant"), CHAOTIC)
def test_the_conditioning_of_a_chaotic_case_reaches_one_at_its_horizon(
    name: str, variant: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = get(name, variant)
    if isinstance(case, IntegratedCase):
        monkeypatch.setattr(type(case), "most_work", 10 * case.most_work)
    assert case.horizon is not None
    # The conditioning is not monotonic: it crosses 1 more than once within 3 % of the horizon.
    assert crossing(case) == pytest.approx(case.horizon, rel=0.03)
    assert case.span < 0.97 * case.horizon


def test_a_variant_that_names_its_horizon_ends_shortly_before() -> None:
    told = 0
    for name, variant in CHAOTIC:
        case = get(name, variant)
        text = next((v.stresses for v in case.variants if v.name == variant), "")
        if "0.95 of the horizon" in text:
            assert case.horizon is not None
            assert f", {case.horizon:g} s" in text
            assert float(case.span) / case.horizon == pytest.approx(0.95, abs=0.005)
            told += 1
    assert told >= 3


def test_a_horizon_belongs_to_the_numbers_of_its_variant_alone() -> None:
    assert (
        get("henon_heiles").horizon == get("henon_heiles").rounded().horizon == get("henon_heiles", "chaotic").horizon
    )
    assert get("henon_heiles", lam="0.9").horizon is None
    assert get("henon_heiles", "regular").horizon is None
    assert get("pendulum_simple").horizon is None

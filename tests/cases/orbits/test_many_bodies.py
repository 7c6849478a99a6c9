"""Cases of many bodies against published digits and against laws that the integration does not use."""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from gnomon.cases import get
from gnomon.cases.core.accuracy import conditioning
from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.case import Case
from gnomon.cases.orbits.figure_eight import PERIOD
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import flint_arithmetic, integrate

PLEIADES = (
    *(0.3706139143970502, 3.237284092057233, -3.222559032418324, 0.6597091455775310, 0.3425581707156584),
    *(1.562172101400631, -0.7003092922212495, -3.943437585517392, -3.271380973972550, 5.225081843456543),
    *(-2.590612434977470, 1.198213693392275, -0.2429682344935824, 1.091449240428980, 3.417003806314313),
    *(1.354584501625501, -2.590065597810775, 2.025053734714242, -1.155815100160448, -0.8072988170223021),
    *(0.5952396354208710, -3.741244961234010, 0.3773459685750630, 0.9386858869551073, 0.3667922227200571),
    *(-0.3474046353808490, 2.344915448180937, -1.947020434263292),
)
"""At t = 3: x of the seven stars, y, x', y'. F. Mazzia, C. Magherini, Test Set for Initial Value Problem Solvers, release
2.4 (Bari, 2008), problem PLEI."""


def integrate_case(case: Case, times: Sequence[Fraction], digits: int) -> Any:
    """The states at the times, by one integration of the equations of motion, without the second that bounds its errors."""
    rebound = rebind(case.equations_of_motion, flint_arithmetic())
    values = tuple(map(ball, case.parameter_values()))
    return integrate(lambda t, s: rebound(t, s, values), case.initial_state, times, digits)


def test_pleiades_end_where_the_test_set_says() -> None:
    """All 16 digits, within the round-off with which the published state was computed."""
    published = np.array(PLEIADES).reshape(4, 7)
    found = np.array(integrate_case(get("pleiades"), [Fraction(3)], 20)[0], dtype=float)
    x, y, vx, vy = found[:14:2], found[1:14:2], found[14::2], found[15::2]
    assert np.abs(np.array([x, y, vx, vy]) / published - 1).max() < 2e-13


@pytest.mark.slow
def test_the_effect_of_half_an_ulp_needs_the_coarse_integration_alone() -> None:
    """The full one gives the same effect to six digits."""
    case = get("henon_heiles").rounded()
    times = case.times[[10, 63]]
    exact = [case.exact(t, 28) for t in times.tolist()]
    half = Fraction(float(np.spacing(float(case.initial_state[0])))) / 2
    start = (case.initial_state[0] + half, *case.initial_state[1:])
    beside = case.with_numbers(start, case.parameters)
    rough, other = case.motion(), beside.motion()
    for t, one in zip(times.tolist(), exact, strict=True):
        full = [float(a - b) for a, b in zip(beside.exact(t, 28), one, strict=True)]
        moment = Fraction(t)
        coarse = [float(a - b) for a, b in zip(other.rough_state(moment), rough.rough_state(moment), strict=True)]
        assert coarse == pytest.approx(full, rel=1e-6)
    assert conditioning(case, times).max() < 1e-9


TWO_PI = "6.283185307179586476925286766559005768394338798750211641949889"
CHOREOGRAPHIES = {
    # the period, the step in the bodies' numbers after its share, and published numbers with half a unit of their last digit
    "figure_eight": (PERIOD, -1, {"vx3": (-0.93240737, 1e-8), "vy3": (-0.86473146, 1e-8)}),
    "choreography_super_eight": (
        TWO_PI, -1, {"x1": (1.382857, 5e-7), "y2": (0.157030, 5e-7), "vy1": (0.584873, 5e-7), "vx2": (1.871935, 5e-7)},
    ),
    "choreography_five_bodies": (
        TWO_PI, -1,
        {"x2": (0.439775, 5e-7), "y2": (-0.169717, 5e-7), "x3": (-1.268608, 5e-7), "vx2": (1.822785, 5e-7), "vy3": (0.168645, 5e-7)},
    ),
}  # fmt: skip
"""C. Simo (2000): the start of the eight has 8 decimals, of the others 6."""


@pytest.mark.parametrize("name", CHOREOGRAPHIES)
def test_the_bodies_of_a_choreography_change_places_after_their_share_of_the_period(name: str) -> None:
    """To 28 digits, with a start whose digits are the published ones. The exact motions are certified elsewhere."""
    period, step, published = CHOREOGRAPHIES[name]
    case = get(name)
    numbers = {c.name: x for c, x in zip(case.state, case.initial_state, strict=True)}
    for label, (value, half) in published.items():
        assert abs(float(numbers[label]) - value) <= half, label
    count = len(case.state) // 4
    (there,) = integrate_case(case, [exact(period) / count], 34)
    for k in range(1, count + 1):
        place = (k - 1 + step) % count + 1
        for label in ("x", "y", "vx", "vy"):
            found = there[[c.name for c in case.state].index(f"{label}{k}")]
            assert abs(found - numbers[f"{label}{place}"]) < Fraction(1, 10**28)


@pytest.mark.parametrize(
    ("variant", "period"), [(None, "11.124340337266085134999734047"), ("four_loops", "17.0652165601579625588917206249")]
)
def test_arenstorf_orbits_close_after_their_published_periods(variant: str | None, period: str) -> None:
    """E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.0: within the 28 digits of start and
    period, of which the Moon, near at both ends, takes two."""
    case = get("arenstorf_orbit", variant)
    closed = get("arenstorf_orbit", initial_state=case.initial_state, span=period)
    with mpmath.workdps(40):
        for found, begun in zip(closed.exact(period, 30), closed.initial_state, strict=True):
            assert abs(found - mpmath.mpf(begun.numerator) / begun.denominator) < mpmath.mpf(10) ** -25


def test_the_four_loops_of_arenstorf_pass_by_the_earth_and_meet_the_moon_at_both_ends_alone() -> None:
    """As the text of the variant says: the distance from the Earth has four minima, that from the Moon stays above 1 between."""
    case = get("arenstorf_orbit", "four_loops")
    states = integrate_case(case, [case.span * k / 120 for k in range(1, 121)], 12)
    x, y = np.array(states, dtype=float)[:, :2].T
    mu = float(case.mu)
    earth, moon = np.hypot(x + mu, y), np.hypot(x - 1 + mu, y)
    assert np.count_nonzero((earth[1:-1] < earth[:-2]) & (earth[1:-1] < earth[2:])) == 4
    assert moon[-1] == pytest.approx(0.0063, abs=1e-4)
    assert moon[20:100].min() > 1

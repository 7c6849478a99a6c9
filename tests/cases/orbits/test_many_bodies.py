"""Cases of many bodies against published digits and against laws that the integration does not use."""

from fractions import Fraction

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.cases.core.accuracy import conditioning
from gnomon.cases.core.arithmetic import rebind
from gnomon.reference.numerics.balls import ball
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


def test_pleiades_end_where_the_test_set_says() -> None:
    """All 16 digits, within the round-off with which the published state was computed."""
    case = get("pleiades")
    published = np.array(PLEIADES).reshape(4, 7)
    rebound = rebind(case.equations_of_motion, flint_arithmetic())
    values = tuple(map(ball, case.parameter_values()))
    (end,) = integrate(lambda t, s: rebound(t, s, values), case.initial_state, [Fraction(3)], 20)
    found = np.array(end, dtype=float)
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

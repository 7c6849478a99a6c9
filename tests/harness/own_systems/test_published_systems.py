"""The digits of the published systems: of their sources, of an independent derivation, and of SciPy agree."""

import numpy as np
import published_systems
import pytest
from gnomon.harness.contract.integrator import Floats
from mpmath import mp, mpf
from published_systems import SYSTEMS, ball_at, falling, ground
from scipy.integrate import solve_ivp

APART = 3e-10
"""Published digits are closer than this: the velocities of the beam are published to 2e-10, and in ten revolutions of
Lorenz's system the rounding of the start to binary64 grows to 1e-10."""
SETTINGS = {
    "pleiades": ("DOP853", 1e-11),
    "van_der_pol": ("LSODA", 1e-10),
    "hires": ("LSODA", 1e-11),
    "rober": ("LSODA", 1e-11),
    "beam": ("Radau", 1e-8),
    "arenstorf": ("DOP853", 1e-12),
    "lorenz": ("DOP853", 1e-11),
    "lorenz_ten_revolutions": ("DOP853", 1e-12),
    "torque": ("DOP853", 1e-11),
    "eulr": ("DOP853", 1e-11),
    "bead": ("DOP853", 1e-11),
    "chain": ("DOP853", 1e-11),
}


@pytest.mark.parametrize("name", [one for one in SYSTEMS if one != "e5"])
def test_published_digits_are_of_the_problem_as_it_is_stated(name: str) -> None:
    assert SYSTEMS[name].apart() < APART


def test_the_published_end_of_e5_breaks_its_conservation_law() -> None:
    _, y2, y3, y4 = map(mpf, SYSTEMS["e5"].end)
    assert y2 == y3 + y4
    _, y2, y3, y4 = map(mpf, SYSTEMS["e5"].published)
    assert abs(y2 - y3 - y4) > y2 / 1000


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=pytest.mark.slow if one == "beam" else ()) for one in SETTINGS]
)
def test_scipy_ends_there(name: str) -> None:
    system = SYSTEMS[name]
    method, tight = SETTINGS[name]
    end = np.array(system.end, float)
    smallest = min(abs(end[end != 0]))
    found = _solve(system, system.f, system.start, method, tight, min(tight * smallest, tight))
    assert found == pytest.approx(end, rel=1e-5, abs=1e-6 if name == "arenstorf" else 0)


def test_scipy_ends_there_for_e5_where_the_conservation_law_replaces_an_equation() -> None:
    system = SYSTEMS["e5"]

    def reduced(t: float, y: Floats) -> list[float]:
        y1, y2, y4 = y
        d1, d2, _, d4 = published_systems.e5(t, [y1, y2, y2 - y4, y4])
        return [d1, d2, d4]

    found = _solve(system, reduced, (system.start[0], 0.0, 0.0), "LSODA", 1e-10, 1e-36)
    assert found[1] == pytest.approx(float(system.end[1]), rel=1e-6)
    assert abs(found[[0, 2]]) == pytest.approx(0, abs=1e-30)


def test_a_ball_that_scipy_restarts_bounces_as_the_formula() -> None:
    g, e = args = SYSTEMS["ball"].args
    t, state, last = 0.0, [1.0, 0.0], SYSTEMS["ball"].t_span[1]
    impacts = []
    while t < last:
        leg = solve_ivp(falling, (t, last), state, "DOP853", rtol=1e-12, atol=1e-12, events=ground, args=args)
        t, state = leg.t[-1], [0.0, -e * leg.y[1, -1]]
        impacts += list(leg.t_events[0])
    with mp.workdps(30):
        assert leg.y[:, -1] == pytest.approx([float(x) for x in ball_at(last, 1.0, g, e)], rel=1e-9)
        assert impacts[0] == pytest.approx(float(mp.sqrt(2 / mpf(g))), rel=1e-12)
    assert len(impacts) == 3


def _solve(system: published_systems.System, f: object, start: object, method: str, rtol: float, atol: float) -> Floats:
    """The end by SciPy; no step crosses a jump of the input."""
    state, at = np.array(start, float), system.t_span[0]
    for until in (*system.jumps, system.t_span[1]):
        leg = solve_ivp(f, (at, until), state, method, rtol=rtol, atol=atol, args=system.args)  # type: ignore[call-overload]
        assert leg.success, leg.message
        state, at = leg.y[:, -1], until
    return state

"""Sampling at many times: within 0.51 ulp of mpmath at all of them, and fast, since few states are computed singly."""

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case, case_class, get, names
from gnomon.reference.numerics import table
from gnomon.reference.numerics.motion import MANY
from gnomon.reference.numerics.precision import exact, nearest_double
from gnomon.reference.storage import diskcache

CASES = (
    "pendulum_simple",
    "kepler_orbit",
    "two_body",
    "damped_oscillator",
    "foucault_pendulum_linear",
    "euler_top",
    "forced_oscillator",
    "projectile_parabola",
    "planet_tunnel",
    "bouncing_ball",
    "coulomb_friction_oscillator",
    "restitution_impact_1d_2d",
    "radial_fall_inverse_square",
    "free_fall_rotating_earth",
    "dumbbell_free_flight",
)
"""At least one case for each way to sample: cycles that shift, turn and decay, events, a limit, a collision, ties."""
CLOSED = tuple(name for name in names() if case_class(name).certified_digits > 30)
PERIODIC = (
    *("pendulum_simple", "harmonic_oscillator", "duffing_unforced", "damped_oscillator", "cycloidal_pendulum"),
    *("kepler_orbit", "foucault_pendulum_linear", "euler_top"),
)
PERIODS = ("period", "turn_time", "swing_period", "body_period")
"""Quantities that are a period of the motion."""
NOTHING = Fraction(1, 10**27)
"""Fraction of the motion's size: for components below it the contract of `state` promises no digits."""
HALF_AND_A_LITTLE = Fraction(51, 100)
AFEW = 20
"""So many of 200,000 samples may lie close to zeros and events: at some ms a state they take 0.1 s."""


@pytest.fixture(autouse=True, scope="module")
def own_cache(tmp_path_factory):
    """Tables are made anew in an empty cache."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(diskcache, "folder", lambda: folder)
        patch.setattr(table, "_kept", {})
        patch.setattr(table, "_too_expensive", {})
        yield


def crowd(case: Case, times: Any) -> Any:
    """The sampled states at `times`, sampled together with so many others that a table is used."""
    others = np.linspace(0.0, float(case.span), MANY)
    return case.sample(np.concatenate([times, others]))[: len(times)]


def assert_within_the_rule(case: Case, times: Any) -> None:
    for t, row in zip(times.tolist(), crowd(case, times), strict=True):
        expected = [exact(x) for x in case.exact(t, 40)]
        size = max(map(abs, expected))
        for found, x in zip(row.tolist(), expected, strict=True):
            if abs(x) > NOTHING * size:
                ulp = Fraction(float(np.spacing(abs(float(x)))))
                assert abs(Fraction(found) - x) <= HALF_AND_A_LITTLE * ulp, (t, found)
            elif x == 0:
                assert found == 0.0, t


def zeros(case: Case) -> list[float]:
    """Times close to a zero of each component that changes its sign: the nearest double, and a little before it."""
    found = []
    grid = np.linspace(0.0, float(case.span), MANY)
    states = case.sample(grid)
    for d in range(len(case.state)):
        change = np.flatnonzero(states[1:, d] * states[:-1, d] < 0)
        if not len(change):
            continue
        low, high = (Fraction(t) for t in grid[change[-1] : change[-1] + 2])
        for _ in range(6):  # by secants, which converge to the zero
            below, above = (exact(case.exact(t, 25)[d]) for t in (low, high))
            if above == below:
                break
            low, high = high, Fraction(float(high - above * (high - low) / (above - below)))
        found += [float(high), float(high) * (1 - 1e-9)]
    return found


def every_variant(*names: str) -> list[tuple[str, str | None]]:
    return [(name, variant) for name in names for variant in (None, *(v.name for v in case_class(name).variants))]


@pytest.mark.parametrize(("name", "variant"), every_variant("kepler_orbit", "foucault_pendulum_linear", "euler_top"))
def test_few_samples_are_the_nearest_doubles(name, variant):
    """Each is computed singly, and rounded once."""
    case = get(name, variant)
    times = case.times[[0, 31, 63]]
    expected = [[nearest_double(value) for value in case.exact(float(t), 60)] for t in times]
    np.testing.assert_array_equal(case.sample(times), expected)


@pytest.mark.parametrize(
    ("name", "variant"), [row for row in every_variant(*PERIODIC) if row != ("euler_top", "engines")]
)
def test_samples_leave_no_gap_in_the_phase(name, variant):
    """If the motion has more than one period, its sampled phases are at most a tenth of a turn apart."""
    case = get(name, variant).rounded()
    found = case.quantities()
    rates = [1 / float(found[period]) for period in PERIODS if period in found]
    rates.append(abs(float(found.get("precession_rate", 0))) / math.tau)
    for rate in rates:
        turns = case.times * rate
        if turns[-1] > 1:
            phases = np.sort(np.mod(turns, 1))
            assert np.max(np.diff(np.append(phases, phases[0] + 1))) <= 0.1


@pytest.mark.parametrize("name", CASES)
def test_values_are_within_051_ulp_of_the_exact_ones(name):
    """At random times, close to zeros, at the start and on both sides of events."""
    case = get(name).rounded()
    span = float(case.span)
    moments = [float(event.time) for event in case.events(20)][:4]
    around = [float(np.nextafter(t, side)) for t in moments for side in (0.0, np.inf)] + moments
    random = np.random.default_rng(11).uniform(0, span, 25)
    assert_within_the_rule(case, np.array([*random, *zeros(case), *around, 0.0, 5e-324, 1e-9 * span, span]))


@pytest.mark.parametrize("name", [name for name in CASES if table.cycle_of(get(name).rounded().motion()) is not None])
def test_values_at_late_times_are_as_accurate(name):
    """After a thousand spans, if decay has not yet made values subnormal."""
    case = get(name).rounded()
    far = 3 if name == "damped_oscillator" else 1000
    assert_within_the_rule(case, np.random.default_rng(12).uniform(0, far * float(case.span), 12))


def check_speed(name: str, singly: list[float]) -> None:
    case = get(name).rounded()
    first, second = np.random.default_rng(13).uniform(0, float(case.span), (2, 10_000))
    case.sample(first)
    singly.clear()
    case.sample(second)
    assert len(singly) <= AFEW


@pytest.mark.parametrize("name", CASES)
def test_nearly_all_values_come_from_the_table(name, singly):
    check_speed(name, singly)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in CLOSED if name not in CASES])
def test_nearly_all_values_of_every_closed_form_come_from_the_table(name, singly):
    check_speed(name, singly)
    assert_within_the_rule(get(name).rounded(), np.random.default_rng(14).uniform(0, float(get(name).span), 10))


def test_states_are_the_same_whether_few_or_many_are_asked_for():
    """Bit for bit at random times, where no value is a tie."""
    case = get("bouncing_ball").rounded()
    times = np.random.default_rng(15).uniform(0, float(case.span), 50)
    assert np.array_equal(crowd(case, times), case.sample(times))

"""Growth of energy errors: the fit finds given powers, and methods follow their laws over a thousand periods."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest
from gnomon.cases import get
from gnomon.cases.core.forms import Hybrid, Impact
from gnomon.harness.contract.integrator import Problem, Refused, Solution
from gnomon.harness.integrators.runge_kutta.explicit import RK4
from gnomon.harness.registry import lookup
from gnomon.harness.studies.growth import (
    SAMPLES,
    STRETCH,
    SUBJECTS,
    Subject,
    energy_errors,
    fit_powers,
    in_extended_precision,
    interval_of_mean,
    measure_growth,
    name_law,
    period_of,
    twenty_bits,
)


@pytest.mark.parametrize("power", [0.0, 0.5, 1.0])
def test_a_given_power_is_found(power: float) -> None:
    """For sixteen errors that scatter by 10 % about t^power."""
    times = np.arange(1, SAMPLES + 1) / SAMPLES
    noise = 1 + 0.1 * np.random.default_rng(1).standard_normal((16, SAMPLES))
    powers = fit_powers(times, np.abs(1e-10 * times**power * noise))
    assert powers.shape == (16,)
    assert np.mean(powers) == pytest.approx(power, abs=0.03)


def test_the_interval_contains_the_mean_with_its_confidence() -> None:
    """With 24 values the coverage of percentiles is slightly low, .935; 300 samples determine it to .014."""
    random = np.random.default_rng(3)
    held = 0
    for _ in range(300):
        low, high = interval_of_mean(random.standard_normal(24))
        held += low <= 0 <= high
    assert 0.89 < held / 300 < 0.98
    wide = interval_of_mean(random.standard_normal(24), 0.999)
    assert wide[1] - wide[0] > 5 / math.sqrt(24)


@pytest.mark.parametrize(("until", "seen"), [(1 / 128, False), (1 / 64, True)])
def test_the_power_is_that_of_the_last_seven_octaves(until: float, seen: bool) -> None:
    """Two decades in whole octaves: an error ten times too large has an effect in the first of them, and none before."""
    times = np.arange(1, SAMPLES + 1) / SAMPLES
    found, _ = fit_powers(times, np.array([np.where(times <= until, 10.0, 1.0) * times] * 2)).tolist()
    # A first of seven octaves that is too large by ln 10 changes the slope by 3 ln 10 / (28 ln 2).
    assert 1 - found == pytest.approx(3 * math.log(10) / (28 * math.log(2)) if seen else 0.0, abs=0.02)


def test_random_walks_grow_as_the_square_root() -> None:
    times = np.arange(1, SAMPLES + 1) / SAMPLES
    walks = np.abs(np.cumsum(np.random.default_rng(2).standard_normal((64, SAMPLES)), axis=1))
    low, high = interval_of_mean(fit_powers(times, walks))
    assert name_law(low, high) == "sqrt t"
    assert high - low < 0.2


def test_every_in_house_smooth_method_is_a_subject() -> None:
    """Methods that locate events, and time stepping for contact, are not smooth."""
    measured = {subject.integrator for subject in SUBJECTS}
    smooth = [one.id for one in lookup.in_house() if not {Hybrid, Impact} & {*one.accepts}]
    for name in smooth:
        line = f'{{ integrators = ["{name.removeprefix("gnomon:")}"], ... }}'
        assert name in measured, f"{name}: write a line {line} into harness/studies/growth.toml"
    assert measured == {*smooth}


def test_bounded_growth_is_expected_of_symplectic_or_reversible_methods_only() -> None:
    for subject in SUBJECTS:
        conserves = lookup.own()[subject.integrator].conserves
        if subject.expected == "bounded":
            assert set(conserves) & {"symplectic", "reversible"}
        if "symplectic" in conserves:
            assert subject.expected in ("bounded", "sqrt t")


@pytest.mark.parametrize(
    ("low", "high", "law"),
    [
        (-0.3, -0.2, "bounded"), (-0.05, 0.02, "bounded"), (0.4, 0.59, "sqrt t"), (0.56, 0.83, "between sqrt t and t"),
        (0.62, 0.98, "t"), (0.52, 0.98, "undecided between sqrt t and t"), (1.48, 1.52, "t^1.5"), (1.9, 2.0, "t^2"),
        (2.2, 2.3, "faster than t^2"), (0.02, 1.05, "undecided between bounded, sqrt t and t"),
    ],
)  # fmt: skip
def test_a_law_is_named_if_the_others_are_excluded(low: float, high: float, law: str) -> None:
    """Within 0.03, the bias of a fit over two decades: .757 (.695 to .810) is neither sqrt t nor t."""
    assert name_law(low, high) == law


def test_no_step_nearly_divides_a_period() -> None:
    """Otherwise the same rounding errors would repeat in every period."""
    for subject in SUBJECTS:
        if subject.setting > 1:
            a_period = round(subject.setting * subject.periods / SAMPLES) * SAMPLES / (STRETCH * subject.periods)
            assert abs(a_period - round(a_period)) > 0.03, subject


SHORT = [
    ("gnomon:Störmer-Verlet", "bounded"), ("gnomon:Blanes-Moan 4", "bounded"), ("gnomon:Gauss 4-stage", "bounded"),
    ("gnomon:Axis splitting 2", "bounded"), ("gnomon:RATTLE", "bounded"), ("gnomon:RK4", "t"), ("gnomon:DOP853", "t"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "law"), SHORT)
def test_the_law_over_a_thousand_periods(name: str, law: str) -> None:
    """The interval between samples is not a multiple of the period: samples would otherwise all be at one phase."""
    subject = next(s for s in SUBJECTS if s.integrator == name)
    row = measure_growth(replace(subject, periods=1.3e3, starts=8))
    assert row["law"] == law == subject.expected


def test_times_are_in_periods_and_every_start_is_different() -> None:
    subject = next(s for s in SUBJECTS if s.integrator == "gnomon:RK4")
    times, errors = energy_errors(replace(subject, periods=1e3, starts=3, parts=2))
    assert times[-1] == pytest.approx(STRETCH * 1e3, rel=1e-5)
    assert errors.shape == (3, SAMPLES)
    # Energy is lost at the same rate in the second part as in the first: it starts where the first one ended.
    assert 0.45 < errors[0, SAMPLES // 2] / errors[0, -1] < 0.55
    assert len(set(errors[:, -1])) == 3
    row = measure_growth(replace(subject, periods=1e3, starts=3, parts=2))
    assert row["size"] == pytest.approx(float(np.median(errors[:, -1])), rel=0.02)  # of the last 8 samples of 4096
    assert (row["integrator"], row["case"], row["periods"], row["starts"]) == ("RK4", "pendulum_simple", 1e3, 3)
    assert (row["setting"], row["expected"]) == ("about 128 steps a period", "t")


def test_starts_are_the_initial_state_scaled_in_steps_of_one_64th(monkeypatch: pytest.MonkeyPatch) -> None:
    started = []

    class Watched(RK4):
        def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
            solve = super().prepare(problem, setting)

            def watched(initial: Any) -> Any:
                started.append(initial.copy())
                return solve(initial)

            return watched

    monkeypatch.setattr(lookup, "own", lambda: {"gnomon:RK4": Watched()})
    energy_errors(Subject("gnomon:RK4", 16, "t", periods=1e3, starts=3))
    (found,) = started
    assert found.tolist() == [[2.0, 0.0], [2.0 - 2 / 64, 0.0], [2.0 - 4 / 64, 0.0]]


def test_energies_are_rounded_far_below_the_states() -> None:
    """A state is rounded by 1e-16 of itself; an invariant computed in binary64 would add as much."""
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("this machine has no arithmetic beyond binary64")
    case = get("pendulum_simple").rounded()
    g, length = case.parameter_values()
    states = np.array([[[0.1 * k, 1 / k] for k in range(1, 40)]])
    value = in_extended_precision(case.invariants["energy"].function, np.array([float(g), float(length)]))
    with mpmath.workdps(30):
        for (theta, omega), found in zip(states[0].tolist(), value(states)[0], strict=True):
            sine = mpmath.sin(mpmath.mpf(theta) / 2)
            energy = mpmath.mpf(omega) ** 2 / 2 + 2 * (mpmath.mpf(float(g)) / mpmath.mpf(float(length))) * sine**2
            high = float(found)
            assert abs((mpmath.mpf(high) + mpmath.mpf(float(found - np.longdouble(high)))) / energy - 1) < 1e-18


def test_without_a_known_period_it_is_2_pi_time_scales() -> None:
    assert period_of(get("projectile_stokes_drag")) == pytest.approx(4 * math.pi)  # the time scale is 1/nu = 2 s
    assert period_of(get("harmonic_oscillator")) == pytest.approx(math.pi)


def test_an_integration_that_ends_early_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    class Stops(RK4):
        def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
            solve = super().prepare(problem, setting)
            return lambda initial: replace(solve(initial), stopped="enough")

    monkeypatch.setattr(lookup, "own", lambda: {"gnomon:RK4": Stops()})
    with pytest.raises(Refused, match="enough"):
        energy_errors(Subject("gnomon:RK4", 16, "t", periods=1e3))


def test_gauss_follows_brouwers_law() -> None:
    """With rounded coefficients, or an iteration that stops too early, the power is 1 and the error ten times larger."""
    subject = Subject("gnomon:Gauss 8-stage", 16, "sqrt t", periods=2e3, starts=16)
    row = measure_growth(subject)
    assert row["size"] < 1e-14
    assert row["power"] < 0.75


def test_intervals_have_exact_multiples() -> None:
    x = twenty_bits(math.pi)
    assert 0 <= math.pi - x < 2**-18
    assert all(np.float64(k) * x == k * int(x * 2**18) / 2**18 for k in range(SAMPLES))

"""The error of the fast Gauss method's energy at the finest tolerance is a random walk without bias."""

import numpy as np
import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.contract.problem import find_accepted_form, initial_state
from gnomon.harness.integrators.gauss.gauss_fast import GaussFast
from gnomon.harness.studies.growth import STRETCH, fit_powers, in_extended_precision, period_of, twenty_bits
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SAMPLES, STARTS = 256, 24


def energy_walks(name: str, periods: float) -> tuple[Floats, Floats, float]:
    """Times (SAMPLES,), relative error of the energy with its sign (STARTS, SAMPLES), and the mean number of steps."""
    case = get(name).rounded()
    form = find_accepted_form(case, GaussFast.accepts)
    assert form is not None
    parameters = np.array([float(x) for x in case.parameter_values()])
    times = np.arange(1, SAMPLES + 1) * twenty_bits(STRETCH * period_of(case) * periods / SAMPLES)
    solve = GaussFast().prepare(Problem(form, len(case.state), parameters, times, float(case.time_scale)), 1e-16)
    energy = next(name for name in case.invariants if "energy" in name)
    value = in_extended_precision(case.invariants[energy].function, parameters)
    draw, walks, steps = np.random.default_rng(5), [], 0
    for _ in range(STARTS):
        start = (initial_state(case) * (1 - draw.uniform(0, 0.5)))[None]
        found = solve(start.copy())
        assert found.stopped is None
        assert found.steps is not None
        steps += found.steps
        walks.append(value(found.states[0]) / value(start) - 1)
    return times, np.asarray(walks, dtype=np.float64), steps / STARTS


@pytest.mark.slow
def test_the_energy_of_the_pendulum_is_a_random_walk_over_a_million_steps() -> None:
    """Each start's drift over the spread that its own increments give it is normal with variance 1, so the sum of squares
    is chi-squared: 99 % below 43 for 24 starts. Resampled starts do not exclude the power 1/2 at 1 %."""
    times, walks, steps = energy_walks("pendulum_simple", 4e4)
    assert steps > 1e6
    increments = np.diff(walks, axis=1, prepend=0.0)
    drifts = np.mean(increments, axis=1) / (np.std(increments, axis=1, ddof=1) / np.sqrt(SAMPLES))
    assert np.sum(drifts**2) < 43
    draw = np.random.default_rng(6)
    powers = [fit_powers(times, np.abs(walks[draw.integers(0, STARTS, STARTS)]))[0] for _ in range(1000)]
    low, high = np.quantile(powers, [0.005, 0.995])
    assert low < 0.5 < high

"""Time of exact states, computed one by one and from a table."""

from typing import Any

import numpy as np
import pytest
from gnomon.cases import case_class, get, names

pytestmark = pytest.mark.benchmark
CASES = ("pendulum_simple", "duffing_unforced", "cycloidal_pendulum", "damped_oscillator")
PERIODIC = ("kepler_orbit", "two_body", "euler_top", "foucault_pendulum_linear", "planet_tunnel", "lagrange_top")
CLOSED = tuple(name for name in names() if case_class(name).certified_digits > 30)


@pytest.mark.parametrize("name", CASES)
def test_exact_state_of_fifty_digits(benchmark: Any, name: str) -> None:
    case = get(name).rounded()
    times = iter(np.linspace(0.01, float(case.span), 100_000))
    state = benchmark(lambda: case.exact(float(next(times)), 50))
    assert len(state) == len(case.state)


@pytest.mark.parametrize("name", [*CASES, *(pytest.param(name, marks=pytest.mark.slow) for name in PERIODIC)])
def test_a_million_samples(benchmark: Any, name: str) -> None:
    sampled(benchmark, name, 1_000_000)


@pytest.mark.slow
@pytest.mark.parametrize("name", CLOSED)
def test_ten_thousand_samples(benchmark: Any, name: str) -> None:
    sampled(benchmark, name, 10_000)


def sampled(benchmark: Any, name: str, count: int) -> None:
    """Time `case.sample` at `count` times, after a first call that builds the table or reads it from disk."""
    case = get(name).rounded()
    times = np.random.default_rng(1).uniform(0, float(case.span), count)
    case.sample(times[:1000])
    states = benchmark.pedantic(case.sample, (times,), rounds=3)
    assert np.array_equal(states[:10], case._motion.sample_each(times[:10]))

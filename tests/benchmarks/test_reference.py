"""What an exact state costs, one by one and by table."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gnomon.cases import get

pytestmark = pytest.mark.benchmark
CASES = ("pendulum_simple", "duffing_unforced", "cycloidal_pendulum", "damped_oscillator")
POINTS = 1_000_000


@pytest.mark.parametrize("name", CASES)
def test_exact_state_of_fifty_digits(benchmark: Any, name: str) -> None:
    case = get(name).rounded()
    times = iter(np.linspace(0.01, float(case.span), 100_000))
    state = benchmark(lambda: case.exact(float(next(times)), 50))
    assert len(state) == len(case.state)


@pytest.mark.parametrize("name", CASES)
def test_a_million_samples(benchmark: Any, name: str) -> None:
    case = get(name).rounded()
    times = np.random.default_rng(1).uniform(0, float(case.span), POINTS)
    case.sample(times[:1000])  # builds the table
    states = benchmark.pedantic(case.sample, (times,), rounds=3)
    assert np.array_equal(states[:10], case._motion.sample_each(times[:10]))

"""The rate of samples of ensembles, and of their exact states, in one process.

On one core of an EPYC that others use too, in processor time: a pendulum takes 19 us at a tolerance of 1e-9 (25 at 1e-12),
a Kepler orbit 131 (182), of which the exact state is 1.8, the draw 0.2 and the counts 0.6. So the integrator bounds both:
1e7 pendulums are 100 s on two cores, 1e6 Kepler orbits 66 s.
"""

from typing import Any

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.ensembles.draws import choose_varied
from gnomon.harness.ensembles.ensemble_run import Job, execute
from gnomon.harness.ensembles.exact_formulas import exact_states
from gnomon.harness.ensembles.samples import Ensemble

pytestmark = pytest.mark.benchmark
CASES = ("pendulum_simple", "kepler_orbit")
SAMPLES = 2**17
"""The parts of so many samples have 2048 each."""


def ensemble(name: str) -> Ensemble:
    return Ensemble(name, "gnomon:Gauss 8-stage SIMD", 1e-9, choose_varied(get(name)))


@pytest.mark.parametrize("name", CASES)
def test_a_part(benchmark: Any, name: str) -> None:
    job = Job(ensemble(name), SAMPLES)
    assert len(benchmark(execute, job, 0)) < 200_000  # the result of a process does not grow with the samples


@pytest.mark.parametrize("name", CASES)
def test_exact_states(benchmark: Any, name: str) -> None:
    ready = ensemble(name).prepared
    parameters, starts = ready.split(ready.drawn(0, 2048)[1])
    states, _ = benchmark(exact_states, ready.case, parameters, starts, ready.times)
    assert np.all(np.isfinite(states))

"""Solutions of a chaotic motion are judged along the way: how long they keep to the conditioning, and how far above it."""

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.studies.horizon import along


@pytest.fixture(scope="module")
def scorer() -> Scorer:
    return Scorer.of(get("driven_pendulum").rounded())


def test_an_exact_solution_is_valid_to_its_end(scorer: Scorer) -> None:
    found = along(scorer, scorer.reference.exact)
    assert found.valid_time == scorer.reference.times[-1]
    assert found.times_conditioning < 1


def test_errors_of_twenty_times_the_conditioning_end_the_valid_time(scorer: Scorer) -> None:
    """The errors at the end may be smaller than the conditioning there: the time until which they were is found."""
    reference = scorer.reference
    states = reference.exact.copy()
    allowed = np.maximum.accumulate(np.maximum(reference.conditioning, reference.floor))
    states[30, 0] += 20 * allowed[30] * reference.sizes[0]
    found = along(scorer, states)
    assert found.valid_time == reference.times[29]
    assert found.times_conditioning == pytest.approx(20, rel=0.1)
    states[0] = np.nan
    assert along(scorer, states).valid_time == 0

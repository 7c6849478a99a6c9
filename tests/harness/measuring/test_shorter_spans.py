"""What is kept of a shorter span is what its sources compute, to the last bit; other times and numbers are computed."""

from pathlib import Path

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.cases.core.case import Case
from gnomon.harness.measuring import growth, shorter_spans
from gnomon.reference.storage import diskcache


@pytest.fixture(autouse=True)
def _empty(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(diskcache, "folder", lambda: tmp_path)


def test_states_are_computed_once(singly: list[float]) -> None:
    case = get("kepler_orbit").rounded()
    times = case.times[:4] / 8
    expected = case.sample(times)
    singly.clear()
    for _ in range(2):
        np.testing.assert_array_equal(shorter_spans.exact_states(case, times), expected)
    assert singly == times.tolist(), "the second is read"
    for other, asked in ((case, times / 2), (get("kepler_orbit", mu="1.5").rounded(), times)):
        np.testing.assert_array_equal(shorter_spans.exact_states(other, asked), other.sample(asked))


@pytest.mark.parametrize("case", [get("harmonic_oscillator").rounded(), get("bouncing_ball").rounded()], ids=str)
def test_growth_is_computed_once(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    """That there is none is kept too."""
    times, sizes = case.times[7::8] / 8, np.full(len(case.state), 2.0)
    expected = growth.growth(case, times, sizes)
    assert (expected is None) == (case.hybrid is not None)
    np.testing.assert_array_equal(shorter_spans.error_growth(case, times, sizes), expected)
    monkeypatch.setattr(growth, "growth", None)
    np.testing.assert_array_equal(shorter_spans.error_growth(case, times, sizes), expected)
    with pytest.raises(TypeError):
        shorter_spans.error_growth(case, times, 2 * sizes)

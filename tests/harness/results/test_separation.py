"""Tests of pairs and the false discovery rate: against other code, and simulated on the scatter that was measured."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from gnomon.harness.results import separation
from gnomon.harness.results.separation import LEAST_SCATTER, discoveries, paired, signs
from launches import measured, modes
from scipy.stats import binomtest, false_discovery_control, ttest_1samp

TRIALS = 2000
Scatter = Callable[[np.random.Generator, tuple[int, ...]], np.ndarray]


def test_the_scatter_that_is_simulated_is_the_measured_one() -> None:
    half, most = np.exp(np.quantile(np.abs(measured(np.random.default_rng(1), (200_000,))), [0.5, 0.9]))
    assert (half, most) == (pytest.approx(1.2, rel=0.01), pytest.approx(1.8, rel=0.05))


@pytest.mark.parametrize("scatter", [measured, modes])
@pytest.mark.parametrize("launches", [2, 3, 5, 10])
def test_identical_methods_tie_in_95_percent_of_trials(scatter: Scatter, launches: int) -> None:
    drawn = scatter(np.random.default_rng(7), (TRIALS, launches))
    # Its standard error is 0.5 % of the trials.
    assert np.mean([paired(row) <= separation.RATE for row in drawn]) < 0.055


@pytest.mark.parametrize("scatter", [measured, modes])
def test_methods_a_factor_of_1_5_apart_are_separated_in_80_percent(scatter: Scatter) -> None:
    drawn = math.log(1.5) + scatter(np.random.default_rng(7), (TRIALS, 10))
    assert np.mean([paired(row) <= separation.RATE for row in drawn]) > 0.8


def test_without_a_least_scatter_modes_separate_identical_methods(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two or three launches in one mode each show no scatter: the constant is for such launches."""
    monkeypatch.setattr(separation, "LEAST_SCATTER", 0.0)
    drawn = modes(np.random.default_rng(7), (TRIALS, 2))
    assert np.mean([paired(row) <= separation.RATE for row in drawn]) > 0.1


@pytest.mark.parametrize("seed", range(5))
def test_p_values_are_those_of_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    values = rng.normal(0.3, 3 * LEAST_SCATTER, 6)
    assert np.std(values, ddof=1) > LEAST_SCATTER
    assert paired(values) == pytest.approx(ttest_1samp(values, 0.0).pvalue, rel=1e-9)
    first, second = rng.integers(0, 12, 2).tolist()
    assert signs(first, second) == pytest.approx(
        binomtest(first, max(first + second, 1)).pvalue if first + second else 1
    )
    p = rng.uniform(0, 1, 50) ** 4
    np.testing.assert_array_equal(discoveries(p), false_discovery_control(p) <= separation.RATE)


def test_nothing_measured_separates_nothing() -> None:
    assert paired([]) == paired([3.0]) == signs(0, 0) == 1.0
    assert discoveries([]).tolist() == []
    assert discoveries([0.06, 1.0]).tolist() == [False, False]

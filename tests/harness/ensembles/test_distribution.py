"""Counts and quantiles agree with counts and quantiles of all errors; parts add to the whole in any order."""

import functools

import numpy as np
import pytest
from gnomon.harness.ensembles.distribution import EDGES, PER_DECADE, Distribution, as_data, count_samples
from gnomon.harness.ensembles.samples import Samples
from scipy.stats import binom

RANDOM = np.random.default_rng(1)
ERRORS = 10 ** RANDOM.uniform(-15, -1, 4096) * (RANDOM.random(4096) > 0.01)
"""A hundredth of them is exactly zero."""
ONE_BIN = 10 ** (1 / PER_DECADE)


def samples(errors: np.ndarray, first: int = 0, failed: int = 0) -> Samples:
    statuses = ["diverged"] * failed + ["ok"] * (len(errors) - failed)
    units = np.random.default_rng(first).random((len(errors), 2))
    shown = np.where(np.arange(len(errors)) < failed, np.nan, errors)
    return Samples(first, units, 2 * units, shown, statuses)


def test_bins_are_those_of_a_histogram() -> None:
    found = count_samples(samples(ERRORS), (0, 1), 5)
    counts, _ = np.histogram(ERRORS, bins=EDGES)
    assert np.array_equal(found.bins[1:-1], counts)
    assert found.bins[0] == np.sum(ERRORS < 1e-20)
    assert found.scored == 4096


def test_an_edge_belongs_to_the_bin_above() -> None:
    """A power of ten belongs to the bin above: the tail counts the samples with this error at least."""
    found = count_samples(samples(np.array([1e-9, np.nextafter(1e-9, 0), 1e-3, 1e-2])), (0, 1), 5)
    assert found.bins[1 + np.searchsorted(EDGES, 1e-9)] == 1
    assert dict(found.tail())[1e-3] == 2


def test_quantiles_are_those_of_the_errors() -> None:
    """The upper edge of the bin in which the order statistic is."""
    for row in count_samples(samples(ERRORS), (0, 1), 5).quantiles():
        right = np.quantile(ERRORS, row["level"], method="inverted_cdf")
        assert right < row["error"] <= right * ONE_BIN * (1 + 1e-15)
        assert row["low"] <= right <= row["high"]


@pytest.mark.parametrize("total", [100, 4096])
def test_bands_hold_the_quantile_as_often_as_they_say(total: int) -> None:
    """The number of errors below a quantile is binomial. With the errors 1, 2, ... as their ranks, the band covers the
    quantile for those numbers of which the lower rank is at most, and the upper above: at least 95 % in all."""
    errors = EDGES[np.linspace(1, len(EDGES) - 2, total).astype(int)]
    assert len(set(errors.tolist())) <= total
    ordered = np.searchsorted(EDGES, errors, side="right")
    for row in count_samples(samples(errors), (0, 1), 0).quantiles():
        low = np.searchsorted(ordered, np.searchsorted(EDGES, row["low"], side="right"), side="left") + 1
        high = np.searchsorted(ordered, np.searchsorted(EDGES, row["high"], side="left"), side="right")
        below = np.arange(total + 1)
        covered = binom.pmf(below, total, row["level"])[(below >= low) & (below < high)].sum()
        assert covered >= 0.95


def test_what_failed_counts_as_the_largest_errors() -> None:
    """With a fifth of the samples failed, nine tenths have no error bound."""
    found = count_samples(samples(ERRORS, failed=820), (0, 1), 3)
    by_level = {row["level"]: row["error"] for row in found.quantiles()}
    assert by_level[0.9] is None
    assert by_level[0.5] is not None
    assert found.statuses == {"diverged": 820, "ok": 4096 - 820}
    assert [start.index for start in found.failed["diverged"]] == [0, 1, 2]


def test_parts_add_to_the_whole_in_any_order() -> None:
    parts = [count_samples(samples(ERRORS[k : k + 512], k, failed=3), (0, 1), 7) for k in range(0, 4096, 512)]
    forwards = functools.reduce(Distribution.merged, parts, Distribution(7))
    pairs = [a.merged(b) for a, b in zip(parts[::2], parts[1::2], strict=True)]
    backwards = functools.reduce(Distribution.merged, pairs[::-1], Distribution(7))
    assert as_data(forwards) == as_data(backwards)
    assert (forwards.worst, forwards.failed) == (backwards.worst, backwards.failed)
    scored = np.array([k for k in range(4096) if k % 512 >= 3])
    assert [one.index for one in forwards.worst] == scored[np.argsort(-ERRORS[scored], kind="stable")][:7].tolist()


def test_equal_errors_are_sorted_by_index() -> None:
    parts = [count_samples(samples(np.full(64, 0.5), k), (0, 1), 3) for k in (128, 0, 64)]
    assert [one.index for one in functools.reduce(Distribution.merged, parts).worst] == [0, 1, 2]


def test_cells_hold_the_samples_of_their_place() -> None:
    found, given = count_samples(samples(ERRORS, failed=100), (1, 0), 3), samples(ERRORS, failed=100)
    cells, _, _ = np.histogram2d(given.units[100:, 1], given.units[100:, 0], bins=48, range=[[0, 1], [0, 1]])
    assert np.array_equal(found.cells[0], cells)
    assert found.cells[2].sum() == 100
    bins = np.arange(len(found.bins))
    assert found.cells[1].sum() == (found.bins * bins).sum()

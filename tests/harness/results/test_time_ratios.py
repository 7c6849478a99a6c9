"""The statistic of times: simulated on launches whose truth is known, and its parts against other code."""

import math

import numpy as np
import pytest
from gnomon.harness.results import time_ratios
from gnomon.harness.results.time_ratios import (
    EQUAL,
    FASTEST,
    OPEN,
    SLOWER,
    Compared,
    Timed,
    compare,
    compare_ratios,
    discoveries,
    run_paired_test,
    scatter_of,
    signs,
    states,
    wilson,
)
from launches import KNOWN, SCATTER, World, page
from scipy.stats import binomtest, false_discovery_control, ttest_1samp

FAR = [1.5, 2.0, 3.0, 5.0, 8.0]
PAGES = 12
WORLDS = {
    "normal": World(),
    "heavy tails": World(tails=4),
    "a mode 10 % slower": World(mode=0.1),
    "scatter that differs twofold": World(unlike=math.log(2) / 2),
    "heavy tails and a mode": World(tails=4, mode=0.1),
    "a machine that slows down": World(slower=1.3),
    "scatter that differs widely": World(unlike=0.7),
}


@pytest.mark.parametrize("launched", [1, 3])
@pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS.keys())
@pytest.mark.parametrize("same", [5, 10])
def test_claims_hold_and_intervals_cover(world: World, same: int, launched: int) -> None:
    """Of 5 or 10 identical methods and five others the false share is at most .05, and intervals cover 93 % at least.

    The standard error of the false share over these pages is .01.
    """
    rng = np.random.default_rng(5)
    found = [page(rng, world, [1.0] * same + FAR, launched) for _ in range(PAGES)]
    assert np.mean([one.false for one in found]) <= 0.05 + 0.01
    assert np.mean([one.covered for one in found]) >= 0.93
    clear = [state for one in found for state in one.states[8.0]]
    assert np.mean([state == SLOWER for state in clear]) > 0.97


@pytest.mark.parametrize(
    ("world", "launched"), [*((name, 1) for name in list(WORLDS)[:4]), ("heavy tails and a mode", 2)]
)
def test_a_factor_of_1_5_is_claimed_in_95_percent(world: str, launched: int) -> None:
    rng = np.random.default_rng(6)
    found = [page(rng, WORLDS[world], [1.0, 1.25, 1.5, 2.0], launched) for _ in range(PAGES)]
    assert np.mean([one.covered for one in found]) >= 0.93
    claimed = [state == SLOWER for one in found for factor in (1.5, 2.0) for state in one.states.get(factor, [])]
    assert np.mean(claimed) >= 0.95


def test_identical_methods_become_equal_with_launches() -> None:
    """With the scatter of a quiet machine three launches settle nearly all pairs of ten identical methods."""
    rng = np.random.default_rng(7)
    found = [state for _ in range(PAGES) for state in page(rng, World(), [1.0] * 10, 3).states[1.0]]
    assert np.mean([state == EQUAL for state in found]) > 0.9


def test_without_the_correction_the_fastest_of_ten_is_claimed_too_often(monkeypatch: pytest.MonkeyPatch) -> None:
    """The least of ten times is least by chance: as if it had been named before, intervals miss more often than they say."""
    rng = np.random.default_rng(8)
    monkeypatch.setattr(time_ratios, "STRICT", 9.0)  # no other method then counts as one that could be the fastest
    assert np.mean([page(rng, World(), [1.0] * 10, 1).covered for _ in range(PAGES)]) < 0.93


def test_the_shared_effect_of_launches_is_no_scatter() -> None:
    """A machine that slows down by 30 % between two launches of all series scatters as one that does not."""
    rng = np.random.default_rng(9)
    sizes = {n: math.log(1.3) if n > 3 else 0.0 for n in range(1, 7)}
    series = [
        Timed("a", {(1, n): math.exp(effect + SCATTER * rng.standard_normal()) for n, effect in sizes.items()})
        for _ in range(30)
    ]
    found = scatter_of(series)
    assert found.typical == pytest.approx(SCATTER, rel=0.2)
    assert math.sqrt(found.shared) == pytest.approx(np.std([*sizes.values()], ddof=1), rel=0.2)
    without = scatter_of([Timed(one.integrator_id, dict(list(one.times.items())[:3])) for one in series])
    assert math.sqrt(without.shared) < SCATTER


def test_series_with_few_and_many_launches_of_one_scatter_do_not_differ() -> None:
    """The variance from two launches scatters more, and lies lower in its logarithm, than the one from six."""
    rng = np.random.default_rng(12)
    series = [
        Timed("a", {(1, n): math.exp(SCATTER * rng.standard_normal()) for n in range(count)})
        for count in (2, 6)
        for _ in range(150)
    ]
    assert scatter_of(series).freedom > 10


def test_series_with_other_launches_are_charged_for_the_shared_effect() -> None:
    """A launch of another hour may have found the machine at another speed."""
    rng = np.random.default_rng(10)
    effect = {n: 0.2 * (n % 2) for n in range(1, 7)}
    series = [
        Timed("a", {(1, n): math.exp(effect[n] + 0.02 * rng.standard_normal()) for n in effect}) for _ in range(30)
    ]
    known = scatter_of(series)
    one, same = Timed("a", {(1, 1): 1.0}), Timed("a", {(1, 1): 1.3})
    other = Timed("a", {(1, 2): 1.3})
    (_, near), (_, far) = compare([one, same], known), compare([one, other], known)
    assert near.low > 1 > far.low
    assert near.ratio == pytest.approx(far.ratio) == pytest.approx(1.3)


def launched_with(rng: np.random.Generator, sizes: dict[str, float], count: int) -> list[Timed]:
    """So many series of each integrator in six launches, with this scatter of the logarithm of a time."""
    return [
        Timed(name, {(1, n): math.exp(size * rng.standard_normal()) for n in range(6)})
        for name, size in sizes.items()
        for _ in range(count)
    ]


def test_a_class_has_its_own_scatter() -> None:
    """One library scatters by 20 %, another by 1 %: a pair of the second is told apart at a factor that the first's is not."""
    rng = np.random.default_rng(11)
    sizes = {"rough": 0.2, "fine": 0.01}
    found = scatter_of(launched_with(rng, sizes, 20))
    for name, size in sizes.items():
        assert math.sqrt(found.of((name, "", 2)).variance) == pytest.approx(size, rel=0.5)
        _, slower = compare([Timed(name, {(1, 1): 1.0}), Timed(name, {(1, 1): 1.2})], found)
        assert (slower.low > 1) == (name == "fine")
    assert [row["library"] for row in found.table()] == ["fine", "rough"]


def test_calls_that_go_through_python_have_a_scatter_of_their_own() -> None:
    """Of one library: `native` calls of SUNDIALS stay in C, those of `binding` call Python for each right-hand side."""
    rng = np.random.default_rng(3)
    sizes = {"sksundae:IDA [native]": 0.02, "sksundae:IDA [binding]": 0.2}
    found = scatter_of(launched_with(rng, sizes, 30))
    native, binding = (found.of(Timed(name, {(1, 1): 1.0}).kind).variance for name in sizes)
    assert 6 < math.sqrt(binding / native) < 15
    assert len(found.table()) == 2


@pytest.mark.parametrize(
    ("count", "of", "low", "high"), [(4, 4, 0.510, 1.0), (0, 4, 0.0, 0.490), (9, 10, 0.596, 0.982)]
)
def test_a_share_has_the_interval_of_wilson(count: int, of: int, low: float, high: float) -> None:
    """The numbers are of SciPy's own code too."""
    assert wilson(count / of, of) == pytest.approx((low, high), abs=5e-4)
    own = binomtest(count, of).proportion_ci(method="wilson")
    assert wilson(count / of, of) == pytest.approx((own.low, own.high), rel=1e-9, abs=1e-12)


def test_a_series_with_launches_counts_by_its_own_scatter_too() -> None:
    """In a class of quiet series one scatters tenfold: after some launches its interval says so."""
    noisy = {(1, n): 1.3 * math.exp(0.3 * (-1) ** n) for n in range(6)}
    _, row = compare([Timed("x", {(1, n): 1.0 for n in range(6)}), Timed("x", noisy)], KNOWN)
    quiet = compare([Timed("x", {(1, n): 1.0 for n in range(6)}), Timed("x", dict.fromkeys(noisy, 1.3))], KNOWN)[1]
    assert row.high / row.low > quiet.high / quiet.low


def test_without_a_second_launch_the_scatter_is_assumed_and_says_so() -> None:
    found = scatter_of([Timed("x", {(1, 1): 1.0})])
    assert not found.counts
    assert "assumed" in found.text()
    rows = compare([Timed("x", {(1, 1): 1.0}), Timed("x", {(1, 1): 1.05}), Timed("x", {(1, 1): 9.0})], found)
    assert states([rows]) == [[FASTEST, OPEN, SLOWER]]


def test_each_pair_has_one_state() -> None:
    rows = [
        Compared(1.0, 1.0, 1.0, 1.0), Compared(1.1, 0.99, 1.22, 0.1), Compared(1.1, 0.8, 1.5, 0.4), Compared(2.0, 1.6, 2.5, 1e-9),
        Compared(1.1, 1.05, 1.15, 1e-6),
    ]  # fmt: skip
    assert states([rows]) == [[FASTEST, EQUAL, OPEN, SLOWER, SLOWER]]
    assert states([]) == []


def test_pairs_of_a_benchmark_are_judged_by_their_ratios() -> None:
    """A factor of 4.34 between 4.21 and 4.53 in five launches is a factor; one about 1 is none."""
    clear, none = compare_ratios([[4.21, 4.34, 4.3, 4.53, 4.4], [0.97, 1.02, 1.0, 1.03, 0.99]])
    assert 3.9 < clear.low < 4.34 < clear.high < 4.8
    assert clear.p < 1e-4 < none.p
    assert none.low < 1 < none.high


def test_the_interval_of_a_pair_has_all_of_its_scatter() -> None:
    """Also what the ratios of all pairs did at once: of ten pairs, each ten per cent up and down."""
    ratios = [2.0 * 1.1**sign for sign in (1, -1, 1, -1, 1)]
    for one in compare_ratios([ratios] * 10):
        assert one.high / one.low > 1.2


@pytest.mark.parametrize("seed", range(5))
def test_p_values_are_those_of_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    values = rng.normal(0.3, 0.3, 6)
    assert run_paired_test(values) == pytest.approx(ttest_1samp(values, 0.0).pvalue, rel=1e-9)
    first, second = rng.integers(0, 12, 2).tolist()
    assert signs(first, second) == pytest.approx(
        binomtest(first, max(first + second, 1)).pvalue if first + second else 1
    )
    p = rng.uniform(0, 1, 50) ** 4
    np.testing.assert_array_equal(discoveries(p), false_discovery_control(p) <= time_ratios.RATE)


def test_nothing_measured_separates_nothing() -> None:
    for few in ([], [3.0]):
        with pytest.raises(ValueError, match="two at least"):
            run_paired_test(few)
    assert signs(0, 0) == 1.0
    assert discoveries([]).tolist() == []
    assert discoveries([0.06, 1.0]).tolist() == [False, False]

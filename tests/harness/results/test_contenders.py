"""Further launches: the open cells that plain rows give are those of the page's tables, in each division."""

from pathlib import Path

import pytest
import synthetic
from gnomon.harness.results import analysis, contenders, rankings, reading, store
from gnomon.harness.results.contenders import MOST_LAUNCHES, OWN, THIRD, UNDECIDED, Time
from gnomon.harness.results.time_ratios import UNMEASURED

SCATTERS = dict.fromkeys((THIRD, OWN, contenders.YOURS), UNMEASURED)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return synthetic.write(tmp_path_factory.mktemp("contenders") / "results.sqlite")


def test_times_and_open_cells_are_those_of_the_page(results: Path) -> None:
    """A run must not launch what the page answers, nor leave what it does not."""
    frame = analysis.tidy(store.load(results))
    equal = analysis.equal_error(analysis.own(frame))
    found, scatter = contenders.times(reading.rows(results))
    assert scatter == rankings.scatter(frame)
    assert scatter[OWN].counts, "the file has repeated launches"
    expected = equal.set_index(["case", "integrator_id", "target"])
    assert {(one.case, one.integrator_id, one.target) for one in found} == set(expected.index)
    for one in found:
        row = expected.loc[(one.case, one.integrator_id, one.target)]
        assert one.seconds == pytest.approx(row["seconds"])
        assert one.times == row["times"]
        assert one.settings == row["settings"]
    ranked = rankings.divisions(equal, scatter)
    cells = ranked.drop_duplicates(["case", "target", "division"])
    for division, (few, many) in contenders.open_cells(found, scatter).items():
        of = cells[(cells["division"] == division) & (cells["cell"] != contenders.ALONE)]
        assert (few, many) == ((of["cell"] == UNDECIDED).sum(), len(of)), division
    left = set(ranked.loc[ranked["cell"] == UNDECIDED, "case"])
    assert {case for case, *_ in contenders.find_undecided(found, scatter)} <= left


def cell(times: dict[str, list[float]], settings: tuple[float, ...] = (1e-6, 1e-7)) -> list[Time]:
    return [
        Time("c", "", name.split(":")[0], name, 1e-6, s[0], {(1, n): x for n, x in enumerate(s, 1)}, settings)
        for name, s in times.items()
    ]


@pytest.mark.parametrize(
    ("times", "names"),
    [
        ({"x:a": [1.0], "x:b": [1.13], "x:c": [9.0]}, {"x:a", "x:b"}),
        ({"gnomon:a": [1.0], "scipy:b": [5.0], "heyoka:c": [5.6]}, {"scipy:b", "heyoka:c"}),  # each division for itself
        ({"x:a": [1.0, 1.0, 1.01, 1.0], "x:b": [1.9, 1.9, 1.9, 1.9]}, set()),  # slower
        ({"x:a": [1.0] * 6, "x:b": [1.0] * 6}, set()),  # equal
        ({"x:a": [1.0] * MOST_LAUNCHES, "x:b": [1.0, 1.6] * (MOST_LAUNCHES // 2)}, set()),  # no launch decides it
        ({"x:a": [1.0]}, set()),
    ],
)
def test_further_launches_are_of_the_series_beside_the_fastest(times: dict[str, list[float]], names: set[str]) -> None:
    found = contenders.find_undecided(cell(times), SCATTERS)
    assert {name for *_, name in found} == names
    assert all(settings == {1e-6, 1e-7} for settings in found.values())


def test_open_cells_are_counted_by_division() -> None:
    found = cell({"gnomon:a": [1.0], "scipy:b": [5.0], "heyoka:c": [5.6], "gnomon:d": [3.0]})
    counts = contenders.open_cells(found, SCATTERS)
    assert (counts[THIRD], counts[OWN]) == ((1, 1), (0, 1))

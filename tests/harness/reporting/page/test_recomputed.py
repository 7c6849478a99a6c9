"""Profiles, factors and states of the page again, from the exported rows alone, by code that has only numpy and scipy.

The rules are those that the page states: time at equal error, interpolated between neighbouring settings; in each division
intervals of factors from the scatter of launches, corrected for the choice of the fastest; Benjamini and Hochberg's rate of
5 %. The scatter itself is taken from the run: tests/harness/results/test_separation.py simulates it.
"""

import csv
import itertools
import math
import re
import statistics
import tomllib
from collections.abc import Callable, Mapping, Sequence
from html.parser import HTMLParser
from pathlib import Path
from typing import Any, NamedTuple

import invented_runs
import numpy as np
import pytest
from command_line import gnomon
from gnomon.harness import registry
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.reporting.page import first_screen
from gnomon.harness.reporting.report_charts import work_problems
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.reporting.report_words import page_words
from gnomon.harness.results.time_ratios import Scatter
from scipy import stats

THIRD = {"scipy": "SciPy", "rebound": "REBOUND", "heyoka": "heyoka", "sksundae": "SUNDIALS"}
EVERY = THIRD | {"gnomon": "gnomon", "mine": "stepper"}
EVERY_TITLES = {title: "mine:stepper" if library == "mine" else library for library, title in EVERY.items()}
"""By title, the name of a library, or of an integrator of the user's, in the data of the page."""
KIND = "Forces of position and time alone"
"""The kind of all invented systems."""
TARGETS = (1e-3, 1e-6, 1e-9, 1e-12)


class Series(NamedTuple):
    """Seconds by launch, their geometric mean, the share of the null call and the evaluations at an error; nan if not counted."""

    times: dict[int, float]
    seconds: float
    null_share: float
    calls: float


Cells = dict[tuple[str, float], dict[str, Series]]
"""By case and error the integrators that reach it."""


class Place(NamedTuple):
    """How the time of an integrator compares with the least of its cell."""

    state: str
    ratio: float
    low: float
    high: float
    p: float


Places = dict[tuple[str, float], dict[str, Place]]


def weights(
    sweep: Mapping[float, Mapping[str, Any]], values: Callable[[Any], float], target: float
) -> dict[float, float]:
    """The settings, by their size, on which the least value rests with which a sweep reaches an error.

    With their weights in the mean of the logarithms; none if no setting reaches it, or the value is not known.
    """
    loosest_first = sorted(sweep, reverse=True)
    errors = [sweep[setting]["error"] for setting in loosest_first]
    finite = sorted(error for error in errors if math.isfinite(error))
    if not finite:
        return {}
    floor = 3 * finite[min(1, len(finite) - 1)]
    end = max(k for k, error in enumerate(errors) if error <= floor) + 1
    held = [max(errors[k:end]) for k in range(end)]
    inside = [k for k, error in enumerate(held) if error <= target]
    if not inside:
        return {}
    k, there = inside[0], {loosest_first[inside[0]]: 1.0}
    if k and math.isfinite(held[k - 1]):
        share = math.log(held[k - 1] / target) / math.log(held[k - 1] / held[k])
        there = {loosest_first[k - 1]: 1 - share, loosest_first[k]: share}
    ways = [there, *({loosest_first[n]: 1.0} for n in inside)]
    costs = [mean(sweep, values, way) for way in ways]
    return {} if math.isnan(costs[0]) else ways[int(np.nanargmin(costs))]


def mean(sweep: Mapping[float, Mapping[str, Any]], values: Callable[[Any], float], way: Mapping[float, float]) -> float:
    """The weighted geometric mean of the values of settings; nan without a value of one."""
    if not way or any(setting not in sweep for setting in way):
        return math.nan
    return math.exp(sum(weight * math.log(values(sweep[setting])) for setting, weight in way.items()))


def number(text: str) -> float:
    return float(text) if text else math.nan


def cells_of(path: Path) -> Cells:
    """Every integrator at every error, from the exported rows of default variants."""
    launches: dict[tuple[str, str], dict[int, dict[float, dict[str, Any]]]] = {}
    with path.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            scored = row["status"] in ("ok", "inaccurate", "diverged") and row["seconds_median"]
            if not scored or (row["variant"], row["formulation"]) != ("default", "standard"):
                continue
            error = math.inf if row["status"] == "diverged" else float(row["error_max"])
            one = {"error": error, "seconds": float(row["seconds_median"])}
            one |= {"calls": number(row["rhs_calls"]), "null": float(row["null_seconds"])}
            of = launches.setdefault((row["case"], row["integrator_id"]), {}).setdefault(int(row["launch"]), {})
            of[float(row["setting"])] = one
    cells: Cells = {}
    for (case, name), by_launch in launches.items():
        null = statistics.median(one["null"] for sweep in by_launch.values() for one in sweep.values())
        for target in TARGETS:
            # The launch with most settings says on which the time rests, and all launches that timed these count.
            whole = max(sorted(by_launch), key=lambda n: len(by_launch[n]))
            way = weights(by_launch[whole], lambda one: one["seconds"], target)
            times = {n: mean(sweep, lambda one: one["seconds"], way) for n, sweep in by_launch.items()}
            times = {n: time for n, time in times.items() if not math.isnan(time)}
            if times:
                seconds = statistics.geometric_mean(times.values())
                fewest = weights(by_launch[1], lambda one: one["calls"], target)
                calls = mean(by_launch[1], lambda one: one["calls"], fewest)
                cells.setdefault((case, target), {})[name] = Series(times, seconds, null / seconds, calls)
    return cells


def margin(one: Series, other: Series, names: tuple[str, str], scatter: Scatter) -> tuple[float, float]:
    """The standard error of the difference of two logarithms of times and its degrees of freedom, with equal launches.

    The variance of a launch is the class's and the series' own in the weights of their degrees of freedom; by Welch and
    Satterthwaite, where an error of a class is one for both.
    """
    parts, classes = [], dict[Any, float]()
    for series, name in zip((one, other), names, strict=True):
        logs = np.log([*series.times.values()])
        library, _, method = name.partition(":")
        way = LIBRARIES[library].way(method) if library in LIBRARIES else ""
        kind = (library, way, int(np.searchsorted([1e-4, 1e-2], series.seconds)))
        variance, of_class = scatter.of(kind)
        freedom = scatter.freedom + len(logs) - 1
        whole = (scatter.freedom * variance + len(logs) * np.var(logs)) / freedom / len(logs)
        parts.append((whole, freedom))
        classes.setdefault((kind, of_class), 0.0)
        classes[kind, of_class] += scatter.freedom / freedom * variance / len(logs)
    total = sum(whole for whole, _ in parts)
    spread = sum(whole**2 / freedom for whole, freedom in parts) + sum(x**2 / n for (_, n), x in classes.items())
    return math.sqrt(total), min(total**2 / spread, 1e3)


def places_of(own: Mapping[str, Series], scatter: Scatter, first: str, candidates: int = 0) -> dict[str, Place]:
    """Factors to the first with their intervals, and p values in the place of states."""
    margins = {name: margin(one, own[first], (name, first), scatter) for name, one in own.items() if name != first}
    behind = {name: math.log(own[name].seconds / own[first].seconds) for name in margins}
    among = candidates or len(margins)
    if not candidates and among > 1:
        among = max(1, sum(behind[n] <= stats.t.isf(0.005 / among, f) * e for n, (e, f) in margins.items()))
    found = {}
    for name, (error, freedom) in margins.items():
        half = stats.t.isf(0.025 / among, freedom) * error
        p = min(1.0, 2 * among * stats.t.sf(abs(behind[name]) / error, freedom))
        low, high = math.exp(behind[name] - half), math.exp(behind[name] + half)
        found[name] = Place("", math.exp(behind[name]), low, high, p)
    return found


def with_states(places: Sequence[dict[str, Place]]) -> list[dict[str, Place]]:
    """The places with their states, at one false discovery rate."""
    values = [one.p for own in places for one in own.values()]
    held = iter(stats.false_discovery_control(values) <= 0.05) if values else iter(())
    found = []
    for own in places:
        states = {}
        for name, one in own.items():
            slower = next(held) and not one.low <= 1 <= one.high
            equal = one.low >= 0.8 and one.high <= 1.25
            states[name] = one._replace(state="slower" if slower else "equal" if equal else "open")
        found.append(states)
    return found


def ranks(cells: Cells, scatter: Scatter) -> Places:
    """The places of integrators that are ranked together: one false discovery rate covers all their cells."""
    firsts = {key: min(own, key=lambda name: own[name].seconds) for key, own in cells.items()}
    judged = with_states([places_of(own, scatter, firsts[key]) for key, own in cells.items()])
    return {
        key: own | {firsts[key]: Place("fastest", 1.0, 1.0, 1.0, 1.0)} for key, own in zip(cells, judged, strict=True)
    }


def stands() -> dict[str, str]:
    """The method of each library for the invented systems, by the file that chooses it, and the user's own."""
    file = Path(registry.__path__[0]) / "representatives.toml"
    table = tomllib.loads(file.read_text(encoding="utf-8"))
    chosen = {
        row["integrator"].partition(":")[0]: row["integrator"]
        for row in table["choice"]
        if KIND in row["kinds"] or any(KIND in table["groups"].get(name, ()) for name in row["kinds"])
    }
    return {library: name for library, name in chosen.items() if library in EVERY} | {"mine": "mine:stepper"}


def of_libraries(cells: Cells, libraries: Mapping[str, str], chosen: Mapping[str, str] | None = None) -> Cells:
    """The integrators of these libraries; with `chosen` those that stand for them."""
    names = set(chosen.values()) if chosen is not None else None
    kept = {
        key: {n: one for n, one in own.items() if n.partition(":")[0] in libraries and (names is None or n in names)}
        for key, own in cells.items()
    }
    return {key: own for key, own in kept.items() if own}


class Shown(NamedTuple):
    """What the page is given: the specifications of its first diagrams, and its words."""

    diagrams: list[dict[str, Any]]
    words: dict[str, Any]
    cells: Cells
    cases: list[str]
    scatter: Scatter
    whole: Scatter


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Shown:
    folder = tmp_path_factory.mktemp("recomputed")
    results = invented_runs.write(folder / "results.sqlite")
    assert gnomon("export", str(results), "--out", str(folder / "rows.csv")) == 0
    diagrams: list[dict[str, Any]] = []

    def keep(specifications: Sequence[dict[str, Any]]) -> list[str]:
        diagrams.extend(specifications)
        return ["<svg></svg>"] * len(specifications)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(first_screen, "stills", keep)
        run = Run.read(results)
        words = page_words(run, [folder], work_problems(run))
    return Shown(
        diagrams,
        words,
        cells_of(folder / "rows.csv"),
        list(invented_runs.cases(16)),
        run.scatter["third"],
        run.scatter["own"],
    )


def profile_rows(shown: Shown, axis: str) -> dict[tuple[float, str], list[tuple[float, float, float, float]]]:
    """Points of each curve that the page draws, by error and name: decade of the factor, share, and its band."""
    wide = next(one for one in shown.diagrams if "hconcat" in one and axis in str(one["hconcat"][0]["layer"][0]))
    found: dict[tuple[float, str], list[tuple[float, float, float, float]]] = {}
    for part in wide["hconcat"]:
        target = float(part["title"].split()[-1])
        for row in part["data"]["values"]:
            at = (row["x"], row["share"], row["low"], row["high"])
            found.setdefault((target, row["name"]), []).append(at)
    return found


def expected_share(shown: Shown, target: float, library: str, factor: float, axis: str) -> float:
    """The share of all cases on which a library is within a factor of the least third party; equal ones take the least."""
    chosen = stands()
    ranked = ranks(of_libraries(shown.cells, THIRD, chosen), shown.scatter)
    inside = 0
    for case in shown.cases:
        every = of_libraries({(case, target): shown.cells.get((case, target), {})}, EVERY, chosen).get(
            (case, target), {}
        )
        third = {name: one for name, one in every.items() if name.partition(":")[0] in THIRD}
        mine = every.get(chosen[library])
        if mine is None or (axis == "evaluations" and math.isnan(mine.calls)):
            continue
        if axis == "evaluations":
            least = min((one.calls for one in third.values() if not math.isnan(one.calls)), default=math.inf)
            ratio = mine.calls / least if math.isfinite(least) else 1.0
            ratio = 1.0 if library in THIRD and ratio <= 1.1 else ratio
        else:
            least = min((one.seconds for one in third.values()), default=math.inf)
            place = ranked.get((case, target), {}).get(chosen[library])
            ratio = (
                1.0
                if place is not None and place.state in ("fastest", "equal")
                else mine.seconds / least
                if math.isfinite(least)
                else 1.0
            )
        inside += ratio <= factor * (1 + 1e-9)
    return inside / len(shown.cases)


def test_all_that_the_first_diagram_draws_is_within_its_axes(shown: Shown) -> None:
    """The line of the conditioning once lay below the diagram, across its legend."""
    diagrams = [one for one in shown.diagrams if "layer" in one]
    assert len(diagrams) == 4, "two axes, two widths"
    for one in diagrams:
        rule, _, dots = one["layer"]
        scales = {name: dots["encoding"][name]["scale"]["domain"] for name in ("x", "y")}
        assert rule["data"]["values"]
        for row in [*one["data"]["values"], *rule["data"]["values"]]:
            assert all(low <= row[name] <= high for name, (low, high) in scales.items() if name in row), row


def test_the_legend_of_the_first_diagram_is_in_the_order_of_the_sentence_below_it(shown: Shown) -> None:
    """Third parties first, in each division the least first: in the order of the alphabet a reader had to match colours."""
    for one, axis in zip(
        [one for one in shown.diagrams if "layer" in one], ("time", "time", "calls", "calls"), strict=True
    ):
        colour = one["layer"][2]["encoding"]["color"]
        said = shown.words["first"]["lead"]["said"][axis].partition(": ")[2]
        parts = re.split("; and of gnomon’s own: |[,;] ", said)
        drawn = [name.removeprefix("gnomon ") for name in colour["scale"]["domain"]]
        places = [next((k for k, part in enumerate(parts) if part.startswith(name)), None) for name in drawn]
        known = [place for place in places if place is not None]
        assert len(known) > 2
        assert known == sorted(known)
        assert colour["sort"] is None, "Vega's order is that of the alphabet"


def test_lines_that_cover_each_other_are_named_apart_at_their_ends(shown: Shown) -> None:
    """With their shares, in the order of these: two libraries at 100 % were one line."""
    covered = 0
    for one in shown.diagrams:
        for part in one.get("hconcat", one.get("vconcat", [])):
            last = {row["name"]: row["share"] for row in part["data"]["values"]}
            ends = part["layer"][-1]["data"]["values"]
            assert {row["name"]: row["share"] for row in ends} == last
            places = [row["at"] for row in ends]
            assert [row["share"] for row in ends] == sorted(last.values(), reverse=True)
            assert all(high - low >= 11 / part["height"] for high, low in itertools.pairwise(places)), (
                "one line of text"
            )
            assert all(0 <= place <= 1 for place in places)
            covered += len(last) - len(set(last.values()))
    assert covered, "the run would have no two lines at one height"


@pytest.mark.parametrize("axis", ["time", "evaluations"])
def test_profiles_are_those_that_other_code_finds_in_the_exported_rows(shown: Shown, axis: str) -> None:
    """At three errors the share of every library at each factor up to 1000, the left and the right end among them."""
    curves = profile_rows(shown, axis)
    assert {target for target, _ in curves} == {1e-3, 1e-6, 1e-9}
    names = {title for title in EVERY.values() if axis == "time" or title != "heyoka"}  # heyoka counts nothing here
    assert {name for _, name in curves} == names
    different = set()
    for (target, name), points in curves.items():
        library = next(key for key, title in EVERY.items() if title == name)
        for decade, share, low, high in [points[0], *points[3:40:6], points[-1]]:
            expected = expected_share(shown, target, library, 10 ** (round(decade * 20) / 20), axis)
            assert share == pytest.approx(expected, abs=1e-4), (target, name, decade)
            assert low <= share <= high
            different.add(share)
    assert len(different) > 8, "the run would be too easy to tell a wrong profile from a right one"


def test_the_sentence_below_the_profiles_has_their_right_ends(shown: Shown) -> None:
    said = shown.words["first"]["profiles"]["said"]
    for library, title in EVERY.items():
        count = round(16 * expected_share(shown, 1e-6, library, 1000.0, "time"))
        assert re.search(rf"{title} on {count} of \d", said), (title, count, said)


def middle(factors: Sequence[float]) -> tuple[float, float, float, bool]:
    """The median, the ends of its interval from scipy's binomial distribution, or of the range, and whether it is one."""
    ordered, count = sorted(factors), len(factors)
    chances = [1 - 2 * stats.binom.cdf(k, count, 0.5) for k in range(count // 2)]  # of the k-th value from each end on
    k = max((k for k, chance in enumerate(chances) if chance >= 0.95), default=-1)
    return statistics.median(ordered), ordered[max(k, 0)], ordered[-1 - max(k, 0)], k >= 0


@pytest.mark.parametrize("group", ["third", "all"])
def test_the_table_of_kinds_is_that_of_other_code(shown: Shown, group: str) -> None:
    """At each error the median factor of every library to the fastest of its group, its interval, and what it reaches."""
    chosen = stands()
    kinds = shown.words["first"]["kinds"]
    told = set()
    for target in TARGETS:
        cells = [
            of_libraries({0: shown.cells.get((case, target), {})}, EVERY, chosen).get(0, {}) for case in shown.cases
        ]
        html = str(kinds["carried"]["tables"][f"seconds/{group}/{target:.0e}".replace("e-0", "e-")])
        found = dict(re.findall(r'<td[^>]*data-label="([^"]*)">(.*?)</td>', html))
        assert set(found) == {title for library, title in EVERY.items() if group == "all" or library != "gnomon"}
        for library, title in EVERY.items():
            if title not in found:
                continue
            factors, reached_ = [], 0
            for own in cells:
                scale = [one.seconds for name, one in own.items() if group == "all" or name.partition(":")[0] in THIRD]
                if chosen[library] in own:
                    reached_ += 1
                    factors += [own[chosen[library]].seconds / min(scale)] if scale else []
            text = re.sub(r"<[^>]+>", " ", found[title])
            assert f"{reached_} of {len(shown.cases)}" in text
            if factors:
                value, low, high, confident = middle(factors)
                said = [float(word.replace("\u202f", "")) for word in re.findall(r"[\d.\u202f]*\d", text)]
                assert said[0] == pytest.approx(value, rel=0.051)
                if len(factors) > 1:
                    assert said[1:3] == pytest.approx([low, high], rel=0.051)
                    assert ("[" not in text) == confident
                told.add(library)
    assert told >= set(THIRD)


def test_the_sentence_on_a_choice_is_of_the_first_in_its_order(shown: Shown) -> None:
    """Its numbers are those of the table; the first is the least factor of the libraries that reach half of the systems."""
    carried = shown.words["first"]["kinds"]["carried"]
    for place, names in carried["orders"].items():
        key = place.rpartition("/")[0]
        cells = re.findall(
            r"<td[^>]*data-label=\"([^\"]*)\"><b>([\d.\u202f]+) ×.*?(\d+) of (\d+)", str(carried["tables"][key])
        )
        titles = {title: EVERY_TITLES[title] for title, *_ in cells}
        half = {
            titles[title]: float(factor.replace("\u202f", "")) for title, factor, n, m in cells if 2 * int(n) >= int(m)
        }
        assert sorted(names) == sorted(titles.values())
        if half:
            assert half[names[0]] == min(half.values())
        for title, factor, reached_, systems in cells:
            said = re.sub(r"<[^>]+>", "", str(carried["said"][f"{place}/{titles[title]}"]))
            assert f"{factor} ×" in said
            assert f"on {reached_} of {systems} system" in said
            assert stands()[titles[title].partition(":")[0]].partition(":")[2] in said


class Table(HTMLParser):
    """The rows of the table of a case: by integrator its cells, each with its class and the words of the axis of time."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: dict[str, list[tuple[str, str]]] = {}
        self.division, self.inside, self.skipped, self.small = "", "", False, False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        if tag in ("th", "td"):
            self.inside, self.head = tag, ""
        if tag == "td":
            self.rows[self.name].append((given.get("class", ""), ""))
        self.small = tag == "small" or (self.small and tag not in ("th", "td"))
        if "data-axis" in given:
            self.skipped = given["data-axis"] == "calls"

    def handle_endtag(self, tag: str) -> None:
        if tag == "b":
            self.skipped = False
        if tag == "small":
            self.small = False
        if tag in ("th", "td"):
            self.inside = ""

    def handle_data(self, data: str) -> None:
        if self.inside == "th" and not self.small:
            self.name = data
            self.rows[data] = []
        elif self.inside == "td" and not self.skipped:
            kind, text = self.rows[self.name][-1]
            self.rows[self.name][-1] = (kind, f"{text} {data}".strip())


def label(name: str) -> str:
    library, _, own = name.partition(":")
    return f"{THIRD.get(library, library)} {own}"


FACTOR = r"([\d.e\u202f-]+) × \(([\d.e\u202f-]+) – ([\d.e\u202f-]+)\)( equal| open)?"


def numbers(said: re.Match[str]) -> list[float]:
    return [float(text.replace("\u202f", "")) for text in said.groups()[:3]]


def test_factors_and_states_of_every_case_are_those_that_other_code_finds(shown: Shown) -> None:
    """In its table the fastest third party is marked; all others have their factor to it, its interval and their state."""
    third = of_libraries(shown.cells, THIRD)
    places = ranks(third, shown.scatter)
    states = set()
    for case in shown.cases:
        table = Table(shown.words["times"][case]["default"]).rows
        for k, target in enumerate(TARGETS):
            own = places.get((case, target), {})
            for name, place in own.items():
                kind, text = table[label(name)][k]
                assert (kind == "best") == (place.state == "fastest" and len(own) > 1), (case, target, name)
                if place.state == "fastest":
                    assert ("fastest" if len(own) > 1 else "alone") in text, (case, target, name, text)
                    continue
                said = re.search(FACTOR, text)
                assert said is not None, (case, target, name, text)
                assert numbers(said) == pytest.approx([place.ratio, place.low, place.high], rel=0.051, abs=0.051)
                assert (said[4] or " slower").strip() == place.state
                states.add(place.state)
            others = {label(name) for name in third.get((case, target), {})}
            reached = {name for name, row in table.items() if row and row[k][0] != "none"}
            assert {name for name in reached if not name.startswith(("gnomon", "mine"))} == others
    assert states == {"slower", "equal", "open"}


@pytest.mark.parametrize("library", ["gnomon", "mine"])
def test_other_divisions_stand_beside_the_least_of_third_parties(shown: Shown, library: str) -> None:
    """Their factor is to the least third-party time, with its interval and state; they may be the faster ones."""
    third = of_libraries(shown.cells, THIRD)
    of_other = of_libraries(shown.cells, {library: "", ("mine" if library == "gnomon" else "gnomon"): ""})
    keys, judged = [], []
    for key, own in of_other.items():
        if key in third:
            best = min(third[key], key=lambda name: third[key][name].seconds)
            near = sum(one.seconds < 1.5 * third[key][best].seconds for one in third[key].values())
            keys.append(key)
            judged.append(places_of({**own, best: third[key][best]}, shown.whole, best, near))
    seen = set()
    for (case, target), own in zip(keys, with_states(judged), strict=True):
        for name, place in own.items():
            if name.startswith(library):
                text = Table(shown.words["times"][case]["default"]).rows[label(name)][TARGETS.index(target)][1]
                said = re.search(FACTOR, text)
                assert said is not None, (case, target, name, text)
                assert numbers(said) == pytest.approx([place.ratio, place.low, place.high], rel=0.051, abs=0.051)
                assert (said[4] or " slower").strip() == place.state
                seen.add(place.state)
    assert "slower" in seen

"""Judges recommendations on systems outside the catalogue: does its setting reach the error, does its order hold?

The systems are drawn at random (`own_systems.drawn`) and measured by `own_systems.outside`. One half of them chooses the
margin, the factor from the tightest setting of the catalogue to the recommended one; the other half, which chose nothing,
gives the shares that are published. Systems are independent and pairs of a system and a library are not: an interval rests
on the number of systems.
"""

import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.registry import representatives
from gnomon.harness.results import analysis, contenders, reading
from gnomon.harness.results.advice.needs import SUBJECTS, UNKNOWN, Measurements, kind_of
from gnomon.harness.results.summary import tidy
from gnomon.harness.results.time_ratios import EQUAL_WITHIN, discoveries, run_paired_test, wilson

from gnomon import cases

ERRORS = (1e-3, 1e-6, 1e-9)
MARGINS = (1.0, 1e-1, 1e-2, 1e-3, 1e-4)
WANTED = 0.975
"""The share of the half `margin` from which on a margin is enough."""
HALVES = MARGIN, TEST = "margin", "test"
"""The half of the systems that chooses the margin, and the half that gives the published shares."""
ROUND_OFF = 1e3
"""An error counts only if it is above this multiple of the conditioning: else no method in binary64 has to reach it."""
FLOOR = 10.0
"""And above this multiple of the bound of the reference's error."""
SAME = 1e-9
"""Settings closer than this are one."""

Row = Mapping[str, Any]


@dataclass(frozen=True)
class System:
    """The need, the family and the half of a drawn system."""

    need: str
    family: str
    half: str


class Pair(NamedTuple):
    """Two libraries and the ratio of their times; `faster` is published as the faster one for a need at an error."""

    need: str
    error: float
    faster: str
    slower: str
    ratio: float


class Trial(NamedTuple):
    """The result of a library on a system at its setting for an error, which it holds or not."""

    system: str
    need: str
    library: str
    error: float
    setting: float
    reached: float
    """The error of this setting; inf without a solution."""
    status: str

    @property
    def held(self) -> bool:
        return self.reached <= self.error


class Order(NamedTuple):
    """Whether the published order of two libraries holds on a system."""

    system: str
    need: str
    held: bool


class Setting(NamedTuple):
    """A measured setting: a tolerance, or a step over the time scale of the system."""

    relative: float
    kind: str
    error: float
    status: str


class Trials:
    """The drawn systems that were measured, with the sweep of each library, from the rows of a results file."""

    def __init__(self, rows: Iterable[Row], systems: Mapping[str, System]) -> None:
        known = [row for row in tidy(rows) if row["case"] in systems and row["status"] not in UNKNOWN]
        self.systems = {name: system for name, system in systems.items() if any(row["case"] == name for row in known)}
        self.sweeps: dict[tuple[str, str], list[Setting]] = {}
        self.methods: dict[tuple[str, str], str] = {}
        """The method of a library on a system."""
        self._reachable: dict[str, float] = dict.fromkeys(self.systems, 0.0)
        for row in known:
            if row["setting"] is None:
                continue
            unit = row["time_scale"] if row["setting_kind"] == "step" else 1.0
            scored = row["status"] in SCORED and row["status"] != Status.DIVERGED and row["error_max"] is not None
            error = row["error_max"] if scored else math.inf
            setting = Setting(row["setting"] / unit, row["setting_kind"], error, str(row["status"]))
            self.sweeps.setdefault((row["case"], row["library"]), []).append(setting)
            self.methods[row["case"], row["library"]] = row["integrator_id"]
            limits = ROUND_OFF * (row["conditioning"] or 0.0), FLOOR * (row["floor"] or 0.0)
            self._reachable[row["case"]] = max(self._reachable[row["case"]], *limits)
        for sweep in self.sweeps.values():
            sweep.sort(key=lambda setting: -setting.relative)
        times, _ = contenders.times(known)
        self.seconds = {(time.case, time.library, time.target): time.seconds for time in times}

    def counts(self, system: str, error: float) -> bool:
        """Whether binary64, and the reference, can tell this error on a system."""
        return self._reachable[system] < error

    def at(self, system: str, library: str, wanted: float) -> Setting:
        """The loosest measured setting that is not above the wanted one, or the tightest."""
        sweep = self.sweeps[system, library]
        return next((setting for setting in sweep if setting.relative <= wanted * (1 + SAME)), sweep[-1])


def select_recommended(rows: Iterable[Row]) -> dict[tuple[str, float, str], Row]:
    """The answers of a table that recommend a setting, by subject, error and library."""
    return {
        (row["subject"], row["error"], row["library"]): row
        for row in rows
        if not row.get("why") and row.get("systems") and "setting" in row
    }


def reliable(answer: Row, method: str, factor: float = 1.0) -> float:
    """The recommended setting of a method of an answer, tightened by a further factor, which steps do not have.

    An answer names one for each of its methods; of one that it does not name, it is the first one's.
    """
    first = answer["reliable"]
    setting = next((other for other in first.get("others", ()) if other["method"] == method), first)
    return float(setting["relative"] if setting["kind"] == "step" else setting["value"] * factor)


def median(answer: Row) -> float:
    """The setting of the median problem of the catalogue, in the unit of `Setting.relative`."""
    return float(answer["setting"]["relative"])


def try_settings(
    trials: Trials, answers: Mapping[tuple[str, float, str], Row], half: str, factor: float | None = 1.0
) -> list[Trial]:
    """The trials of all libraries on the systems of a half, at the recommended setting with the margin `factor`.

    If `factor` is None, at the setting of the median problem.
    """
    tried = []
    for (name, library), method in trials.methods.items():
        system = trials.systems[name]
        for error in ERRORS if system.half == half else ():
            answer = answers.get((system.need, error, library))
            if answer is None or not trials.counts(name, error):
                continue
            wanted = median(answer) if factor is None else reliable(answer, method, factor)
            at = trials.at(name, library, wanted)
            tried.append(Trial(name, system.need, library, error, at.relative, at.error, at.status))
    return tried


def choose_margin(trials: Trials, answers: Mapping[tuple[str, float, str], Row]) -> tuple[float, list[dict[str, Any]]]:
    """(margin, shares): the largest margin with a share of WANTED on its half, else the margin with the largest share.

    `answers`: the answers of a table whose settings have no margin yet.
    """
    shares = [{"margin": margin, **_share(try_settings(trials, answers, MARGIN, margin))} for margin in MARGINS]
    enough = [row for row in shares if row["of"] and row["share"] >= WANTED]
    best = enough[0] if enough else max(shares, key=lambda row: (row["share"] or 0.0, row["margin"]))
    return best["margin"], shares


def share(outcomes: Sequence[tuple[str, bool]]) -> dict[str, Any]:
    """The share of (system, holds) outcomes that hold, with its 95 % interval by Wilson; None without outcomes.

    The interval assumes one independent trial for each system.
    """
    of, held = len(outcomes), sum(holds for _, holds in outcomes)
    if not of:
        return {"held": 0, "of": 0, "systems": 0, "share": None, "low": None, "high": None}
    systems = len({system for system, _ in outcomes})
    low, high = wilson(held / of, systems)
    return {"held": held, "of": of, "systems": systems, "share": held / of, "low": low, "high": high}


def find_published_order(measured: Measurements, errors: Sequence[float] = ERRORS) -> list[Pair]:
    """The pairs of third-party libraries that a run of the catalogue separates, by need and error.

    Their medians over the systems that both reach differ by EQUAL_WITHIN or more, and a paired t test over these systems
    tells them apart, at one false discovery rate for all pairs.
    """
    pairs: list[tuple[Pair, float]] = []
    for subject in SUBJECTS.values():
        problems = measured.subject_problems(subject)
        for error in errors:
            times: dict[str, dict[str, float]] = {}
            for library in LIBRARIES:
                methods = dict[str, str]()
                for case, _ in problems:
                    stands = representatives.standing(library, measured.kind[case], subject.stands)
                    methods |= {} if stands is None else {case: stands.integrator}
                systems = measured.systems(problems, methods, error)
                times[library] = {case: system.seconds for case, system in systems.items() if system.reached}
            for first, second in combinations(LIBRARIES, 2):
                pairs += _pair(subject.key, error, (first, times[first]), (second, times[second]))
    held = discoveries([p for _, p in pairs])
    return [pair for (pair, _), holds in zip(pairs, held, strict=True) if holds and pair.ratio >= EQUAL_WITHIN]


def measurements(path: Path) -> Measurements:
    """The measurements of the catalogue in a results file."""
    frame = analysis.tidy(reading.load(path))
    forms = {str(case): set(of) for case, of in frame.groupby("case")["form"]}
    forms |= {
        name: {type(form).__name__ for form in cases.get(name).all_forms()} for name in forms if name in cases.names()
    }
    return Measurements(analysis.equal_error(frame), analysis.own_spans(frame), kind_of(forms))


def _pair(
    need: str, error: float, first: tuple[str, Mapping[str, float]], second: tuple[str, Mapping[str, float]]
) -> list[tuple[Pair, float]]:
    """[(pair, p value)] of two libraries; empty if they have fewer than two common systems."""
    common = [case for case in first[1] if case in second[1]]
    if len(common) < 2:
        return []
    differences = [math.log(second[1][case] / first[1][case]) for case in common]
    if sum(differences) < 0:
        first, second = second, first
    own, other = (statistics.median(of[case] for case in common) for _, of in (first, second))
    return [(Pair(need, error, first[0], second[0], other / own), run_paired_test(differences))]


def order(trials: Trials, pairs: Sequence[Pair], halves: Sequence[str]) -> list[Order]:
    """The order on each drawn system that both libraries of a pair reach."""
    orders = []
    for pair in pairs:
        for name, system in trials.systems.items():
            own, other = (trials.seconds.get((name, library, pair.error)) for library in (pair.faster, pair.slower))
            wanted = system.need == pair.need and system.half in halves and trials.counts(name, pair.error)
            if wanted and own is not None and other is not None:
                orders.append(Order(name, system.need, own < other))
    return orders


def judge(trials: Trials, answers: Callable[[float], Iterable[Row]], pairs: Sequence[Pair]) -> dict[str, Any]:
    """Judge the answers of a run of the catalogue: the margin, the shares of both settings, the order, the misses.

    `answers` gives the rows of the table with a margin; `pairs`: the published order.
    """
    margin, margins = choose_margin(trials, select_recommended(answers(1.0)))
    known = select_recommended(answers(margin))
    tests = try_settings(trials, known, TEST)
    by_need, of_all = order(trials, pairs, [TEST]), order(trials, pairs, HALVES)
    return {
        "systems": len(trials.systems),
        "margin": margin,
        "margins": margins,
        "half": {half: sum(system.half == half for system in trials.systems.values()) for half in HALVES},
        "share": _share(tests),
        "by_need": _by(tests, "need"),
        "by_library": _by(tests, "library"),
        "by_error": _by(tests, "error"),
        "by_need_and_library": _by(tests, "need", "library"),
        "median_share": _share(try_settings(trials, known, TEST, None)),
        "order": _share(by_need)
        | {
            "pairs": len(pairs),
            "by_need": _by(by_need, "need"),
            "all": _share(of_all),
        },
        "misses": [_miss(trial) for trial in tests if not trial.held],
    }


def _by(trials: Sequence[Trial | Order], *names: str) -> list[dict[str, Any]]:
    """The share of each group of trials, whose fields of these names are equal."""
    groups: dict[tuple[Any, ...], list[Trial | Order]] = {}
    for trial in trials:
        groups.setdefault(tuple(getattr(trial, name) for name in names), []).append(trial)
    return [dict(zip(names, group, strict=True)) | _share(members) for group, members in groups.items()]


def _share(trials: Sequence[Trial | Order]) -> dict[str, Any]:
    return share([(trial.system, trial.held) for trial in trials])


def _miss(trial: Trial) -> dict[str, Any]:
    """The row of a trial that does not reach its error, for a file: a number that is not finite is None."""
    row = {name: getattr(trial, name) for name in ("system", "need", "library", "error", "setting")}
    return row | {"found": trial.reached if math.isfinite(trial.reached) else None, "status": trial.status}

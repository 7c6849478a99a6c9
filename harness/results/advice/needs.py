"""Recommendations for a need: for each library a method, its setting, its cost, and the number of systems behind them.

A need is a subject of `needs.toml`: stiff systems, long times, events, high accuracy and more. The answer of a library is
its representative (`registry.representatives`), which was chosen before the run. A second answer is another method of the
library that the measurements show to be better: the best of several, chosen after the run.

Variants of one case are one system, because they are not independent. A method reaches a system if it reaches all problems
of the system on which it was tried. An answer has the share of systems that the method reaches, with its interval for any
number of systems, the setting of the median problem, and a recommended setting (`Reliable`).
"""

import math
import statistics
from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
from gnomon.cases.core import registry
from gnomon.cases.core.integrated import IntegratedCase
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Tolerance
from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.registry import kinds, lookup, representatives
from gnomon.harness.registry.families import exact_reason
from gnomon.harness.results.analysis import NEVER_RAN, SERIES, records, settings
from gnomon.harness.results.equal_error import credit_errors, crossing
from gnomon.harness.results.profiles import OURS
from gnomon.harness.results.time_ratios import discoveries, run_paired_test, signs, wilson

THIRD, OWN, YOURS = "third-party", "gnomon", "yours"
"""Divisions: libraries that gnomon drives, its own methods, and integrators that a user gave to the run."""
UNKNOWN = {*NEVER_RAN, Status.INTERRUPTED}
"""Statuses of settings without a result. A problem whose settings all have such a status was not tried."""
PAIRED = 2
"""The smallest number of systems on which two methods are compared: a scatter needs two differences."""
ORBITS = "Bodies under gravitation"
"""The kind of system whose motions may be Kepler orbits."""
SAME = 1 + 1e-9
"""Relative settings within this factor are equal: steps over a time scale are rounded."""
Problem = tuple[str, str]
"""A case and the name of its variant, empty for the default one."""


@dataclass(frozen=True)
class Subject:
    """A table of `needs.toml`."""

    key: str
    title: str
    about: str
    error: float
    """The error at which the page shows it."""
    need: bool = False
    """Whether the page shows it; `gnomon recommend` knows the others too."""
    stands: str | None = None
    """The kind whose representatives answer for the libraries; None for the kind of each case."""
    kinds: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()
    """Problems of the need in addition to the default variants of the cases of `kinds`."""
    decays: Mapping[str, float] = field(default_factory=dict)
    """For a stiff need, the number of decays within the span, by problem."""
    words: Sequence[str] = ()
    """Further names of the subject."""

    def of(self, case: str, variant: str, kind: str) -> bool:
        """Whether a problem counts."""
        name = f"{case}/{variant}" if variant else case
        return (not variant and kind in self.kinds) or name in self.problems or name in self.decays


def _subject(key: str, row: Mapping[str, Any]) -> Subject:
    lists = {"kinds": tuple(representatives.expand(row.get("kinds", ()))), "problems": tuple(row.get("problems", ()))}
    return Subject(key, **{**row, **lists})


SUBJECTS = {key: _subject(key, row) for key, row in read_declared("results", "advice/needs.toml").items()}


@dataclass(frozen=True)
class Setting:
    """The loosest setting with which a method holds an error on a problem."""

    integrator: str
    case: str
    variant: str
    kind: str
    """tolerance or step."""
    value: float
    """In the unit of the sweep: a relative tolerance, or a step in the equations' unit of time."""
    relative: float
    """The tolerance, or the step over the time scale of the problem."""
    error: float
    name: str
    """As `parameter_name`."""


@dataclass(frozen=True)
class Reliable:
    """The recommended setting of a method: it holds the error on as many systems as possible, with a margin.

    A tolerance is the tightest one that a problem needs, times the margin, rounded down to a tolerance of the sweep. It is
    looser only if this tolerance was not measured, or if its round-off exceeds the error. A step is the smallest step that a
    problem needs, without a margin.
    """

    integrator: str
    kind: str
    relative: float
    """The tolerance, or the step over the time scale."""
    systems: int
    """Systems on which the error was measured to hold at this setting."""
    of: int
    """Systems that the method reaches at some setting."""
    seconds: float
    """The median over `systems` of the measured time at this setting."""
    name: str
    """As `parameter_name`."""


@dataclass(frozen=True)
class Span:
    """The range of the systems on which an answer was measured; its settings were not tried outside of this range."""

    shortest: float
    """The shortest and the longest span, in time scales."""
    longest: float
    conditioning: float
    """The largest effect of half an ulp in the numbers of a system, as an error."""
    eccentricity: float
    """The largest of the Kepler orbits among them; nan without one."""


@dataclass(frozen=True)
class Answer:
    """The results of one library, or of one integrator of the user, on the systems of a need."""

    library: str
    division: str
    methods: tuple[str, ...]
    """Ids: one, or one for each kind of the systems that were tried."""
    why: str
    """The reason without measurements: the manual has no method for the need, or the method was not run; else empty."""
    tried: int
    """Systems on which they ran."""
    systems: int
    """Systems on which they reach the error; times, evaluations and settings are medians over these."""
    seconds: float = math.nan
    """The median over these systems; each one counts with the median of its problems."""
    low: float = math.nan
    high: float = math.nan
    evaluations: float = math.nan
    """The median number of right-hand sides; nan if they were not counted."""
    setting: Setting | None = None
    """Of the median problem."""
    loosest: float = math.nan
    tightest: float = math.nan
    """The range of the relative settings over the problems. `setting` and this range are of the method with most systems."""
    reliable: tuple[Reliable, ...] = ()
    """A recommended setting for each method, the method with most systems first."""
    rests_on: Span | None = None
    """The systems that are reached, or, without one, the systems that were tried."""
    best_error: float = math.nan
    """If no system is reached: the least error that is reached on at least half of the systems that were tried."""
    launches: int = 0
    """The least number of launches behind a time."""
    better: "Answer | None" = None
    """Another method of the library, which the measurements show to be better than these."""
    among: int = 0
    """In `better`: the number of methods of the library that were compared, this best one included."""
    how: str = ""
    """In `better`: the result by which it is better, in words."""

    @property
    def recommended(self) -> bool:
        return self.systems > 0

    @property
    def share(self) -> tuple[float, float]:
        """The 95 % interval of the share of systems that are reached."""
        return wilson(self.systems / max(self.tried, 1), self.tried)


@dataclass(frozen=True)
class Cost:
    """The cost of a method on one problem, or the fact that it does not reach the error."""

    library: str
    integrator: str
    case: str
    variant: str
    decays: float
    seconds: float
    """nan if the error is not reached."""
    evaluations: float


@dataclass(frozen=True)
class Need:
    """A need with the answers of each library: third parties, a user's own, then gnomon."""

    subject: Subject
    error: float
    systems: int
    """Systems in the run that count for it."""
    answers: list[Answer]
    costs: list[Cost]
    """The cost of every method for stiff equations by decades of stiffness, if the need is stiff."""


@dataclass(frozen=True)
class _Reached:
    """A series at an error that it reaches."""

    seconds: float
    null_share: float
    times: Mapping[tuple[int, int], float]
    evaluations: float
    setting: Setting
    sweep: Sequence[Mapping[str, Any]]
    """The scored settings, loosest first."""

    def near(self, relative: float) -> Mapping[str, Any] | None:
        """The loosest measured setting that is not above a relative setting; None without one."""
        return next((point for point in self.sweep if point["relative"] <= relative * SAME), None)


@dataclass(frozen=True)
class _System:
    """A method on the problems of one case."""

    reached: bool
    at: list[_Reached]
    least: float
    """The least error that is reached on all problems; inf without an answer."""
    problems: Sequence[Problem]

    @property
    def integrator(self) -> str:
        return self.at[0].setting.integrator

    def held(self, relative: float, error: float) -> bool:
        """Whether the measured error at a relative setting is at most `error` on all problems."""
        nearest = [series.near(relative) for series in self.at]
        return all(point is not None and point["error"] <= error for point in nearest)

    def seconds_at(self, relative: float) -> float:
        """The median over the problems of the measured time at a relative setting."""
        return _median(point["seconds"] for point in (series.near(relative) for series in self.at) if point is not None)

    @property
    def seconds(self) -> float:
        return statistics.median(series.seconds for series in self.at)

    @property
    def evaluations(self) -> float:
        return _median(series.evaluations for series in self.at)


class Measurements:
    """The measurements of a run, arranged by problem and integrator.

    `equal`: `rankings.rank_methods`; `timed`: `analysis.own_spans`; `kind`: the kind of each case.
    """

    def __init__(self, equal: pd.DataFrame, timed: pd.DataFrame, kind: Mapping[str, str]) -> None:
        own = timed[timed["formulation"] == ""]
        self.kind = kind
        self.libraries = dict(own[["integrator_id", "library"]].drop_duplicates().itertuples(index=False, name=None))
        self._tried: dict[Problem, dict[str, bool]] = {}
        for row in records(own, ("case", "variant", "integrator_id", "status")):
            of = self._tried.setdefault((row["case"], row["variant"]), {})
            of[row["integrator_id"]] = of.get(row["integrator_id"], False) or row["status"] not in UNKNOWN
        rows = equal[equal["formulation"] == ""]
        columns = ("case", "variant", "integrator_id", "target", "seconds", "null_share", "times")
        self._equal = {
            (row["case"], row["variant"], row["integrator_id"], row["target"]): row for row in records(rows, columns)
        }
        self._sweeps = _sweeps(own)
        self._held = {key: credit_errors([point["error"] for point in sweep]) for key, sweep in self._sweeps.items()}
        facts = own.assign(spans=own["span"] / own["time_scale"]).groupby(["case", "variant"])
        self._facts = facts[["spans", "conditioning"]].first().to_dict("index")

    @property
    def problems(self) -> AbstractSet[Problem]:
        """The problems of the measurements."""
        return self._tried.keys()

    def subject_problems(self, subject: Subject) -> list[Problem]:
        """The problems of the run that count for a subject, if any integrator was tried on them."""
        return [
            key
            for key, tried in self._tried.items()
            if any(tried.values()) and key[0] in self.kind and subject.of(*key, self.kind[key[0]])
        ]

    def tried(self, problem: Problem, integrator: str) -> bool:
        return self._tried[problem].get(integrator, False)

    def reached(self, problem: Problem, integrator: str, error: float) -> _Reached | None:
        """A series at an error; None if it does not reach it."""
        row = self._equal.get((*problem, integrator, error))
        if row is None:
            return None
        sweep = self._sweeps[(*problem, integrator)]
        held = self._held[(*problem, integrator)]
        within = np.flatnonzero(held <= error)
        # Errors of later launches may be larger than those of the launch that `equal_error` takes.
        place = int(within[0]) if len(within) else int(np.argmin(held))
        calls = [point["calls"] for point in sweep]
        evaluations = crossing(held, calls, error)[0] if min(calls) > 0 else math.nan
        point = sweep[place]
        name = parameter_name(integrator)
        setting = Setting(
            integrator, *problem, point["kind"], point["setting"], point["relative"], point["error"], name
        )
        return _Reached(row["seconds"], row["null_share"], row["times"], evaluations, setting, sweep)

    def exact(self, problem: Problem, integrator: str) -> bool:
        """Whether a series is exact by construction, as `exact_reason` declares."""
        return (*problem, integrator) in self._sweeps and exact_reason(integrator, problem[0]) is not None

    def least(self, problem: Problem, integrator: str) -> float:
        """The least error that a series reaches; inf without an answer."""
        held = self._held.get((*problem, integrator))
        return math.inf if held is None else float(held.min())

    def span(self, systems: Iterable[_System]) -> Span | None:
        """The range of these systems; None without systems."""
        problems = [problem for system in systems for problem in system.problems]
        if not problems:
            return None
        spans = [self._facts[problem]["spans"] for problem in problems]
        orbits = [eccentricity(*problem) for problem in problems if self.kind[problem[0]] == ORBITS]
        return Span(
            min(spans),
            max(spans),
            max(self._facts[problem]["conditioning"] for problem in problems),
            max((value for value in orbits if not math.isnan(value)), default=math.nan),
        )

    def systems(
        self, problems: Iterable[Problem], methods: Mapping[str, str] | str, error: float
    ) -> dict[str, _System]:
        """By case, the systems on which a method was tried. `methods`: its id, or the ids by case.

        A system on one of whose problems the method is exact by construction shows nothing about it, and is left out.
        """
        by_case: dict[str, list[tuple[Problem, str]]] = {}
        for problem in problems:
            name = methods if isinstance(methods, str) else methods.get(problem[0])
            if name is not None and self.tried(problem, name):
                by_case.setdefault(problem[0], []).append((problem, name))
        return {
            case: self._system(all_, error)
            for case, all_ in by_case.items()
            if not any(self.exact(problem, name) for problem, name in all_)
        }

    def _system(self, tried: Sequence[tuple[Problem, str]], error: float) -> _System:
        reached = [self.reached(problem, name, error) for problem, name in tried]
        least = max(self.least(problem, name) for problem, name in tried)
        at = [series for series in reached if series is not None]
        return _System(len(at) == len(tried), at, least, [problem for problem, _ in tried])


def _sweeps(timed: pd.DataFrame) -> dict[tuple[str, ...], list[dict[str, Any]]]:
    """The scored settings of each series, loosest first, by case, variant and integrator."""
    sweeps: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    columns = (*SERIES, "status", "setting", "setting_kind", "error_max", "rhs_calls", "time_scale", "seconds")
    for row in records(settings(timed[timed["status"].isin(SCORED)]), columns):
        error = math.inf if row["status"] == Status.DIVERGED else row["error_max"]
        relative = row["setting"] / (row["time_scale"] if row["setting_kind"] == "step" else 1.0)
        of = sweeps.setdefault((row["case"], row["variant"], row["integrator_id"]), [])
        point = {"setting": row["setting"], "kind": row["setting_kind"], "relative": relative, "error": error}
        point |= {"calls": row["rhs_calls"] if row["rhs_calls"] > 0 else math.nan, "seconds": row["seconds"]}
        of.append(point)
    return sweeps


@cache
def eccentricity(case: str, variant: str) -> float:
    """The eccentricity of a case's orbit; nan for a motion that is not a Kepler orbit, and for a case that is not installed."""
    if case not in registry.installed_names():
        return math.nan
    motion = registry.get(case, variant or None)
    # Other motions are integrated, and have no eccentricity: their derived quantities take seconds.
    known = {} if isinstance(motion, IntegratedCase) else motion.quantities()
    return float(known.get("eccentricity", math.nan))


def parameter_name(integrator: str) -> str:
    """The name of a setting with error control: rtol, or the library's own for a parameter that is not a tolerance."""
    known = lookup.own().get(integrator)
    return known.sweep.name if known is not None and isinstance(known.sweep, Tolerance) else "rtol"


def kind_of(forms: Mapping[str, AbstractSet[str]]) -> dict[str, str]:
    """The kind of each case, from the forms that it offers: the first kind of the page with one of them."""
    by_case = {case: kinds.kind_of(offered) for case, offered in forms.items()}
    return {case: kind for case, kind in by_case.items() if kind is not None}


def needs(
    measured: Measurements,
    subjects: Sequence[Subject] | None = None,
    errors: Sequence[float] | None = None,
    margin: float = 1.0,
) -> list[Need]:
    """The needs with their answers, each at its own error, or at each of `errors`. By default the needs of the page.

    `margin`: the factor of reliable tolerances (see `Reliable`). One false discovery rate covers all claims that a method is better than a representative.
    """
    chosen = [subject for subject in SUBJECTS.values() if subject.need] if subjects is None else subjects
    asked = [(subject, error) for subject in chosen for error in errors or (subject.error,)]
    answered = [_of(measured, subject, error, margin) for subject, error in asked]
    claims = [claim for answers in answered for _, others in answers for claim in others]
    holds = {id(claim) for claim, held in zip(claims, discoveries([claim.p for claim in claims]), strict=True) if held}
    all_needs = []
    for (subject, error), answers in zip(asked, answered, strict=True):
        completed = []
        for answer, others in answers:
            best = _best([claim for claim in others if id(claim) in holds])
            if best is not None:
                better = _answer(
                    measured, best.systems, answer.library, answer.division, (best.integrator,), error, margin
                )
                answer = replace(answer, better=replace(better, among=len(others) + 1, how=best.how))
            completed.append(answer)
        problems = measured.subject_problems(subject)
        costs = _costs(measured, subject, problems, error)
        all_needs.append(Need(subject, error, len({case for case, _ in problems}), completed, costs))
    return all_needs


@dataclass(frozen=True)
class _Claim:
    """The claim that a method is better than the representative, with its p value."""

    integrator: str
    systems: Mapping[str, _System]
    how: str
    p: float
    more: int
    """Systems that it reaches and the representative does not, less the reverse."""
    ratio: float
    """The median over the systems of its time over the representative's."""


def _of(measured: Measurements, subject: Subject, error: float, margin: float) -> list[tuple[Answer, list[_Claim]]]:
    """The answer of each library, with the claims for its other methods."""
    problems = measured.subject_problems(subject)
    answers = []
    for library, declared in LIBRARIES.items():
        if declared.suite is None or library in measured.libraries.values():
            answers.append(_library(measured, subject, problems, library, error, margin))
    for name, library in measured.libraries.items():
        if library not in LIBRARIES and library != OURS:
            answer = _answer(measured, measured.systems(problems, name, error), library, YOURS, (name,), error, margin)
            answers.append((answer, []))
    return [*answers, _library(measured, subject, problems, OURS, error, margin)]


def _library(
    measured: Measurements, subject: Subject, problems: Sequence[Problem], library: str, error: float, margin: float
) -> tuple[Answer, list[_Claim]]:
    """The answer of a library by its representatives, and the claims of its other methods against these."""
    division = OWN if library == OURS else THIRD
    methods, reasons = {}, {}
    for case in dict.fromkeys(case for case, _ in problems):
        kind = measured.kind[case]
        stands = representatives.standing(library, kind, subject.stands)
        if stands is not None:
            methods[case] = stands.integrator
        else:
            stiff = subject.stands == representatives.STIFF
            reasons[representatives.reason(library, representatives.STIFF if stiff else kind)] = True
    systems = measured.systems(problems, methods, error)
    named = tuple(dict.fromkeys(methods[case] for case in systems)) or tuple(dict.fromkeys(methods.values()))
    why = "; ".join(filter(None, reasons)) if not methods else ""
    answer = _answer(measured, systems, library, division, named, error, margin, why)
    others = [name for name, of in measured.libraries.items() if of == library and name not in set(methods.values())]
    claims = [_claim(measured.systems(problems, name, error), name, systems) for name in others]
    return answer, [claim for claim in claims if claim is not None]


def _answer(
    measured: Measurements,
    systems: Mapping[str, _System],
    library: str,
    division: str,
    methods: tuple[str, ...],
    error: float,
    margin: float,
    why: str = "",
) -> Answer:
    """The medians over the systems that are reached."""
    good = [system for system in systems.values() if system.reached]
    rests_on = measured.span(good or systems.values())
    why = why or ("" if systems else "not run")
    answer = Answer(library, division, methods, why, len(systems), len(good), rests_on=rests_on)
    if not good:
        least = sorted(system.least for system in systems.values())
        half = least[(len(least) - 1) // 2] if least else math.inf
        return replace(answer, best_error=half) if math.isfinite(half) else answer
    by_method: dict[str, list[_System]] = {}
    for system in good:
        by_method.setdefault(system.integrator, []).append(system)
    ordered = sorted(by_method.values(), key=lambda of: -len(of))
    chosen = sorted((series.setting for system in ordered[0] for series in system.at), key=lambda of: -of.relative)
    seconds = [system.seconds for system in good]
    return replace(
        answer,
        seconds=statistics.median(seconds),
        low=min(seconds),
        high=max(seconds),
        evaluations=_median(system.evaluations for system in good),
        setting=chosen[len(chosen) // 2],
        loosest=chosen[0].relative,
        tightest=chosen[-1].relative,
        reliable=tuple(_reliable(of, error, margin) for of in ordered),
        launches=min(len(series.times) for system in good for series in system.at),
    )


def _reliable(systems: Sequence[_System], error: float, margin: float) -> Reliable:
    """The recommended setting of one method, from the systems that it reaches."""
    each = [series for system in systems for series in system.at]
    needed = sorted(series.setting.relative for series in each)
    wanted, grid = needed[0], needed
    if each[0].setting.kind == Tolerance.kind:
        wanted, grid = margin * needed[0], sorted({point["relative"] for series in each for point in series.sweep})
    first = max(bisect_right(grid, wanted * SAME) - 1, 0)
    chosen, held = grid[first], list[_System]()
    for value in grid[first:]:  # of settings that hold on as many systems, the one nearest to the margin
        now = [system for system in systems if system.held(value, error)]
        if len(now) > len(held):
            chosen, held = value, now
        if len(held) == len(systems) or value > needed[-1]:
            break
    seconds = _median(system.seconds_at(chosen) for system in held)
    setting = each[0].setting
    return Reliable(setting.integrator, setting.kind, chosen, len(held), len(systems), seconds, setting.name)


def _median(values: Iterable[float]) -> float:
    """The median of the values that are known; nan without one."""
    known = [value for value in values if not math.isnan(value)]
    return statistics.median(known) if known else math.nan


def _claim(systems: Mapping[str, _System], name: str, base: Mapping[str, _System]) -> _Claim | None:
    """The claim of a method against the representatives; None if it was not tried on `PAIRED` of their systems.

    It is better if it reaches the error on more systems (sign test over the systems), or on no fewer ones and faster:
    the t test of the logarithms' differences, one a system, each the mean over common launches. Systems on which it is
    exact by construction show nothing about it.
    """
    both = [case for case in systems if case in base]
    if len(both) < PAIRED:
        return None
    more = [case for case in both if systems[case].reached and not base[case].reached]
    fewer = [case for case in both if base[case].reached and not systems[case].reached]
    differences = [
        value
        for case in both
        if systems[case].reached and base[case].reached
        for value in [_faster(systems[case], base[case])]
        if not math.isnan(value)
    ]
    reach = signs(len(more), len(fewer)) if len(more) > len(fewer) else 1.0
    speed, ratio = 1.0, math.exp(-statistics.median(differences)) if differences else math.nan
    if len(differences) >= PAIRED and len(more) >= len(fewer) and sum(differences) > 0:
        speed = run_paired_test(differences)
    gained = len(more) - len(fewer)
    how = f"reaches the error on {gained} more of {len(both)} systems" if reach <= speed else ""
    how = how or f"takes {ratio:.2g} of the time on {len(differences)} systems that both reach"
    # Either way of being better may hold by chance.
    return _Claim(name, systems, how, min(1.0, 2 * min(reach, speed)), gained, ratio)


def _faster(system: _System, base: _System) -> float:
    """The mean logarithm of the base's time over the system's, over its problems and their common launches."""
    means = []
    for mine, other in zip(system.at, base.at, strict=True):
        common = mine.times.keys() & other.times.keys()
        if common:
            means.append(statistics.fmean(math.log(other.times[key] / mine.times[key]) for key in common))
    return statistics.fmean(means) if means else math.nan


def _best(held: Sequence[_Claim]) -> _Claim | None:
    """The best of the methods that are separated from the representatives: most systems, then the least time."""
    good = [claim for claim in held if any(system.reached for system in claim.systems.values())]
    return min(
        good, key=lambda claim: (-claim.more, math.inf if math.isnan(claim.ratio) else claim.ratio), default=None
    )


def _costs(measured: Measurements, subject: Subject, problems: Sequence[Problem], error: float) -> list[Cost]:
    """The costs of the methods for stiff equations on each problem on which they were tried, by its number of decays."""
    if not subject.decays:
        return []
    rows = []
    for problem in sorted(problems, key=lambda problem: (subject.decays["/".join(problem)], problem)):
        for name, library in measured.libraries.items():
            users = library not in LIBRARIES and library != OURS
            if (name in lookup.STIFF or users) and measured.tried(problem, name):
                at = measured.reached(problem, name, error)
                cost = (math.nan, math.nan) if at is None else (at.seconds, at.evaluations)
                rows.append(Cost(library, name, *problem, subject.decays["/".join(problem)], *cost))
    return rows

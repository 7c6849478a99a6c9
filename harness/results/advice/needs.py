"""What to use for a need: for each library its method, the setting, the cost, and the number of systems it rests on.

A need is a subject of `needs.toml`: stiff systems, long times, events, high accuracy and more. Each library answers with
its representative (`registry.representatives`), which was chosen before the run. Another method of the library stands
beside it if the measurements separate it as better: the best of several, found after the run.

Variants of one case are one system, because they are not independent. A system is reached if all of its problems that
were tried are. Below `FEWEST` systems, nothing is recommended.
"""

import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.declared import declared
from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.registry import kinds, representatives
from gnomon.harness.registry.lookup import STIFF
from gnomon.harness.results.analysis import NEVER_RAN, SERIES, records, settings
from gnomon.harness.results.equal_error import credited, time_at
from gnomon.harness.results.number_text import counted
from gnomon.harness.results.profiles import OURS
from gnomon.harness.results.rankings import EXACT, FEWEST
from gnomon.harness.results.separation import discoveries, paired, signs

THIRD, OWN, YOURS = "third-party", "gnomon", "yours"
"""Divisions: libraries that gnomon drives, its own methods, and integrators that a user gave to the run."""
UNKNOWN = {*NEVER_RAN, Status.INTERRUPTED}
"""Statuses of settings of which nothing is known; a problem with no other ones was not tried."""
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
    """The kind whose representatives stand for the libraries; None for the kind of each case."""
    kinds: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()
    decays: Mapping[str, float] = field(default_factory=dict)
    """The number of decays by problem, if this is what makes it hard."""

    def of(self, case: str, variant: str, kind: str) -> bool:
        """Whether a problem counts."""
        if self.kinds:
            return not variant and kind in self.kinds
        return (f"{case}/{variant}" if variant else case) in (self.problems or self.decays)


def _subject(key: str, row: Mapping[str, Any]) -> Subject:
    lists = {"kinds": tuple(representatives.expanded(row.get("kinds", ()))), "problems": tuple(row.get("problems", ()))}
    return Subject(key, **{**row, **lists})


SUBJECTS = {key: _subject(key, row) for key, row in declared("results", "advice/needs.toml").items()}


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


@dataclass(frozen=True)
class Answer:
    """What the measurements say of one library, or of one integrator that a user gave, on the systems of a need."""

    library: str
    division: str
    methods: tuple[str, ...]
    """Ids: one, or one for each kind of the systems that were tried."""
    why: str
    """Why nothing is recommended; empty if `methods` are."""
    tried: int
    """Systems on which they ran."""
    systems: int
    """Systems on which they reach the error: the number on which times, evaluations and settings rest."""
    seconds: float = math.nan
    """The median over these systems; each one counts with the median of its problems."""
    low: float = math.nan
    high: float = math.nan
    evaluations: float = math.nan
    """Right-hand sides, likewise; nan if not counted."""
    setting: Setting | None = None
    """Of the median problem."""
    loosest: float = math.nan
    tightest: float = math.nan
    """The range of the relative settings over the problems."""
    launches: int = 0
    """The fewest launches that a time rests on."""
    better: "Answer | None" = None
    """Another method of the library that the measurements separate from these as better."""
    among: int = 0
    """In `better`: the number of methods of the library that were compared, of which it is the best."""
    how: str = ""
    """In `better`: what separates it."""

    @property
    def recommended(self) -> bool:
        return not self.why


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


@dataclass(frozen=True)
class _System:
    """A method on the problems of one case."""

    reached: bool
    at: list[_Reached]

    @property
    def seconds(self) -> float:
        return statistics.median(one.seconds for one in self.at)

    @property
    def evaluations(self) -> float:
        return _median(one.evaluations for one in self.at)


class Measurements:
    """The measurements of a run, arranged by problem and integrator.

    `equal`: `rankings.ranked`; `timed`: `analysis.own_spans`; `kind`: the kind of each case.
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
        held = credited([one["error"] for one in sweep])
        within = np.flatnonzero(held <= error)
        # Errors of later launches may be larger than those of the launch that `equal_error` takes.
        place = int(within[0]) if len(within) else int(np.argmin(held))
        calls = [one["calls"] for one in sweep]
        evaluations = time_at([one["error"] for one in sweep], calls, error)[0] if min(calls) > 0 else math.nan
        one = sweep[place]
        setting = Setting(integrator, *problem, one["kind"], one["setting"], one["relative"], one["error"])
        return _Reached(row["seconds"], row["null_share"], row["times"], evaluations, setting)

    def exact(self, problem: Problem, integrator: str) -> bool:
        """Whether a series is exact by construction (`rankings.EXACT`): its loosest setting has an error of round-off."""
        sweep = self._sweeps.get((*problem, integrator))
        return sweep is not None and sweep[0]["error"] <= EXACT

    def systems(
        self, problems: Iterable[Problem], methods: Mapping[str, str] | str, error: float
    ) -> dict[str, _System]:
        """By case, the systems on which a method was tried. `methods`: its id, or the ids by case.

        A system on one of whose problems the method is exact by construction shows nothing about it, and is left out.
        """
        found: dict[str, list[_Reached | None]] = {}
        exact = set()
        for problem in problems:
            name = methods if isinstance(methods, str) else methods.get(problem[0])
            if name is not None and self.tried(problem, name):
                if self.exact(problem, name):
                    exact.add(problem[0])
                found.setdefault(problem[0], []).append(self.reached(problem, name, error))
        return {
            case: _System(None not in all_, [one for one in all_ if one is not None])
            for case, all_ in found.items()
            if case not in exact
        }


def _sweeps(timed: pd.DataFrame) -> dict[tuple[str, ...], list[dict[str, Any]]]:
    """The scored settings of each series, loosest first, by case, variant and integrator."""
    found: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    columns = (*SERIES, "status", "setting", "setting_kind", "error_max", "rhs_calls", "time_scale")
    for row in records(settings(timed[timed["status"].isin(SCORED)]), columns):
        error = math.inf if row["status"] == Status.DIVERGED else row["error_max"]
        relative = row["setting"] / (row["time_scale"] if row["setting_kind"] == "step" else 1.0)
        of = found.setdefault((row["case"], row["variant"], row["integrator_id"]), [])
        one = {"setting": row["setting"], "kind": row["setting_kind"], "relative": relative, "error": error}
        of.append(one | {"calls": row["rhs_calls"] if row["rhs_calls"] > 0 else math.nan})
    return found


def kind_of(forms: Mapping[str, AbstractSet[str]]) -> dict[str, str]:
    """The kind of each case, from the forms that it offers: the first kind of the page with one of them."""
    found = {case: kinds.kind_of(offered) for case, offered in forms.items()}
    return {case: kind for case, kind in found.items() if kind is not None}


def needs(
    measured: Measurements, subjects: Sequence[Subject] | None = None, errors: Sequence[float] | None = None
) -> list[Need]:
    """The needs with their answers, each at its own error, or at each of `errors`. By default the needs of the page.

    One false discovery rate covers all claims that a method is better than a representative.
    """
    chosen = [one for one in SUBJECTS.values() if one.need] if subjects is None else subjects
    made = [(one, error, _of(measured, one, error)) for one in chosen for error in errors or (one.error,)]
    claims = [claim for *_, answers in made for _, found in answers for claim in found]
    holds = {id(claim) for claim, held in zip(claims, discoveries([one.p for one in claims]), strict=True) if held}
    found = []
    for subject, error, answers in made:
        kept = [_with_better(one, [claim for claim in of if id(claim) in holds], len(of) + 1) for one, of in answers]
        problems = measured.subject_problems(subject)
        costs = _costs(measured, subject, problems, error)
        found.append(Need(subject, error, len({case for case, _ in problems}), kept, costs))
    return found


@dataclass(frozen=True)
class _Claim:
    """The claim that a method is better than the representative, with its p value."""

    answer: Answer
    p: float
    more: int
    """Systems that it reaches and the representative does not, less the reverse."""
    ratio: float
    """The median over the systems of its time over the representative's."""


def _of(measured: Measurements, subject: Subject, error: float) -> list[tuple[Answer, list[_Claim]]]:
    """The answer of each library, with the claims for its other methods."""
    problems = measured.subject_problems(subject)
    found = []
    for library, one in LIBRARIES.items():
        if one.suite is None or library in measured.libraries.values():
            found.append(_library(measured, subject, problems, library, error))
    for name, library in measured.libraries.items():
        if library not in LIBRARIES and library != OURS:
            answer = _answer(measured.systems(problems, name, error), library, YOURS, (name,))
            found.append((answer, []))
    return [*found, _library(measured, subject, problems, OURS, error)]


def _library(
    measured: Measurements, subject: Subject, problems: Sequence[Problem], library: str, error: float
) -> tuple[Answer, list[_Claim]]:
    """The answer of a library by its representatives, and the claims of its other methods against these."""
    division = OWN if library == OURS else THIRD
    methods, reasons = {}, {}
    for case in dict.fromkeys(case for case, _ in problems):
        kind = measured.kind[case]
        stands = representatives.representative(library, subject.stands) if subject.stands else None
        if stands is None and subject.stands != representatives.STIFF:
            stands = representatives.representative(library, kind)
        if stands is not None:
            methods[case] = stands.integrator
        else:
            stiff = subject.stands == representatives.STIFF
            reasons[representatives.reason(library, representatives.STIFF if stiff else kind)] = True
    systems = measured.systems(problems, methods, error)
    named = tuple(dict.fromkeys(methods[case] for case in systems)) or tuple(dict.fromkeys(methods.values()))
    why = "; ".join(filter(None, reasons)) if not methods else ""
    answer = _answer(systems, library, division, named, why)
    others = [name for name, of in measured.libraries.items() if of == library and name not in set(methods.values())]
    claims = [_claim(measured, problems, name, systems, answer, error) for name in others]
    return answer, [claim for claim in claims if claim is not None]


def _answer(
    systems: Mapping[str, _System], library: str, division: str, methods: tuple[str, ...], why: str = ""
) -> Answer:
    """The medians over the systems that are reached."""
    good = [one for one in systems.values() if one.reached]
    few = len(good) < FEWEST
    if not why and not systems:
        why = "not run"
    if not why and few:
        count = str(len(good) or "none")
        why = f"reaches the error on {count} of {counted(len(systems), 'system')}; a recommendation takes {FEWEST}"
    elif not why and 2 * len(good) < len(systems):
        why = f"reaches the error on {len(good)} of {len(systems)} systems, fewer than half"
    answer = Answer(library, division, methods, why, len(systems), len(good))
    if not good:
        return answer
    each = sorted((one for system in good for one in system.at), key=lambda one: -one.setting.relative)
    seconds = [system.seconds for system in good]
    return replace(
        answer,
        seconds=statistics.median(seconds),
        low=min(seconds),
        high=max(seconds),
        evaluations=_median(system.evaluations for system in good),
        setting=each[len(each) // 2].setting,
        loosest=each[0].setting.relative,
        tightest=each[-1].setting.relative,
        launches=min(len(one.times) for one in each),
    )


def _median(values: Iterable[float]) -> float:
    """The median of the values that are known; nan without one."""
    known = [value for value in values if not math.isnan(value)]
    return statistics.median(known) if known else math.nan


def _claim(
    measured: Measurements,
    problems: Sequence[Problem],
    name: str,
    base: Mapping[str, _System],
    answer: Answer,
    error: float,
) -> _Claim | None:
    """The claim of a method against the representatives; None if it was not tried on `FEWEST` of their systems.

    It is better if it reaches the error on more systems (sign test over the systems), or on no fewer ones and faster:
    the t test of the logarithms' differences, one a system, each the mean over common launches. Systems on which it is
    exact by construction show nothing about it.
    """
    systems = measured.systems(problems, name, error)
    both = [case for case in systems if case in base]
    if len(both) < FEWEST:
        return None
    more = [case for case in both if systems[case].reached and not base[case].reached]
    fewer = [case for case in both if base[case].reached and not systems[case].reached]
    other = _answer(systems, answer.library, answer.division, (name,))
    differences = [
        value
        for case in both
        if systems[case].reached and base[case].reached
        for value in [_faster(systems[case], base[case])]
        if not math.isnan(value)
    ]
    reach = signs(len(more), len(fewer)) if len(more) > len(fewer) else 1.0
    speed, ratio = 1.0, math.exp(-statistics.median(differences)) if differences else math.nan
    if len(differences) >= FEWEST and len(more) >= len(fewer) and sum(differences) > 0:
        speed = paired(differences)
    gained = len(more) - len(fewer)
    how = f"reaches the error on {gained} more of {len(both)} systems" if reach <= speed else ""
    how = how or f"takes {ratio:.2g} of the time on {len(differences)} systems that both reach"
    # Either way of being better may hold by chance.
    return _Claim(replace(other, how=how), min(1.0, 2 * min(reach, speed)), gained, ratio)


def _faster(one: _System, base: _System) -> float:
    """The mean logarithm of the base's time over one's, over the problems of a system and their common launches."""
    found = []
    for mine, other in zip(one.at, base.at, strict=True):
        common = mine.times.keys() & other.times.keys()
        if common:
            found.append(statistics.fmean(math.log(other.times[key] / mine.times[key]) for key in common))
    return statistics.fmean(found) if found else math.nan


def _with_better(answer: Answer, held: Sequence[_Claim], among: int) -> Answer:
    """The answer with the best of the methods that are separated from it: most systems, then the least time."""
    good = [claim for claim in held if claim.answer.recommended]
    if not good:
        return answer
    best = min(good, key=lambda claim: (-claim.more, math.inf if math.isnan(claim.ratio) else claim.ratio))
    return replace(answer, better=replace(best.answer, among=among))


def _costs(measured: Measurements, subject: Subject, problems: Sequence[Problem], error: float) -> list[Cost]:
    """The costs of the methods for stiff equations on each problem that they were tried on, by its number of decays."""
    if not subject.decays:
        return []
    rows = []
    for problem in sorted(problems, key=lambda one: (subject.decays["/".join(one)], one)):
        for name, library in measured.libraries.items():
            users = library not in LIBRARIES and library != OURS
            if (name in STIFF or users) and measured.tried(problem, name):
                at = measured.reached(problem, name, error)
                cost = (math.nan, math.nan) if at is None else (at.seconds, at.evaluations)
                rows.append(Cost(library, name, *problem, subject.decays["/".join(problem)], *cost))
    return rows

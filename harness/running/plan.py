"""Plans a run: pairs each case with the integrators that accept one of its forms, and lists settings of sweeps."""

from __future__ import annotations

import json
import platform
import secrets
from collections.abc import Container, Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cache, cached_property
from typing import Any

from gnomon.cases import Case
from gnomon.cases.core.formulation import Formulation
from gnomon.cases.core.numbers import nearest
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract import sources
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Integrator, Problem
from gnomon.harness.contract.problem import find_accepted_form, takes
from gnomon.harness.contract.status import Status
from gnomon.harness.contract.validation import short
from gnomon.harness.measuring.settings import Chosen, sweep_settings
from gnomon.harness.registry import environment, lookup, references
from gnomon.harness.registry.selection import DEFAULT
from gnomon.harness.results.schema import TIMING_SPAN
from gnomon.reference.storage.import_closure import closure, imports

from gnomon import cases

STANDARD = "standard"
"""The name of a case's own formulation in results."""
LONG = 1000.0
"""Span, in time scales, above which the time limit of a variant grows with the span."""
NEAR_DUPLICATE = (
    Status.SKIPPED,
    "a suite takes this integrator on default settings only, once; name it to run it here",
)
"""Status and reason of a near-duplicate method on a hard variant. Results files hold this text: it must not change."""
_SPANS = read_declared("running", "timing_spans.toml")
TIMING_FACTORS: dict[str, int] = _SPANS["factors"]
ENDS: tuple[str, ...] = tuple(_SPANS["ends"]["cases"])
"""Foundation cases whose motion ends, so that a longer span is useless for timing."""
COMPILERS = ("numba", "llvmlite")
COMPILING = (*COMPILERS, "gnomon.harness.kernels")
"""An integrator depends on the versions of the COMPILERS if its modules import from these."""
INTEGRATORS = ("gnomon.harness.integrators", "gnomon.harness.adapters")
_THIS_PROCESS = secrets.token_hex(16)
"""Part of the key of a trial whose case or integrator has no source file: it runs again in every process."""


class Repeat(StrEnum):
    """The trials that run again although a results file has them."""

    NOTHING = ""
    FROM_OUTSIDE = "those that a cause outside ended"
    ALL = "all"


def is_engine(integrator: Integrator) -> bool:
    """Whether an integrator is a physics engine, which takes scenes and no equations."""
    return integrator.accepts == (SceneForm,)


@dataclass(frozen=True, kw_only=True)
class Scope:
    """What a suite runs: cases, methods and settings."""

    cases: tuple[str, ...] = ()
    """The cases that run unless the user names some; empty for all."""
    variants: bool
    """Whether the hard variants of its cases run too."""
    hardest: tuple[str, ...] = ()
    """The hard variants, as case/variant, that run unless the user names cases; empty for all if `variants`."""
    further: tuple[str, ...] = ()
    """Hard variants that run too, of any case."""
    formulations: bool = True
    """Whether cases run in their other formulations too."""
    turned: bool = True
    """Whether a default variant with a rotational symmetry is solved from turned starts too, in its first launch."""
    integrators: tuple[str, ...] = ()
    """The integrators that run unless the user names some; empty for all."""
    primary: bool = False
    """Whether near-duplicate methods run only if they are named."""
    engines: bool = False
    """Whether physics engines alone run unless the user names integrators."""
    for_stiff: tuple[str, ...] = ()
    """Methods that run on the stiff variants of the suite alone, near-duplicate ones too."""
    for_events: tuple[str, ...] = ()
    """Methods that run on motions with events alone."""
    settings: Chosen | None = field(default=None, hash=False)
    """The settings that the user chose, for all cases; None for the sweeps that the methods declare."""


@dataclass(frozen=True, kw_only=True)
class Timing:
    """How the trials of a suite are timed."""

    launches: int
    """Launches of each series on a default variant; on another variant a series is launched once."""
    scatter_launches: int = 0
    """Launches of one setting of some series of each library, for the scatter between launches (see `order`);
    none where series are launched so often."""
    first_use: bool = False
    """Whether the first use of each integrator is timed, once, which takes some seconds each."""
    timing_spans: bool = False
    """Whether default variants run over several spans too, for the time of one more period (see `lengthen`)."""
    block_seconds: float = 0.003
    """Seconds that the timed calls of a trial take together."""
    repeats: int = 40
    """The largest number of timed calls of a trial."""
    slow_seconds: float = 0.02
    """A trial that takes longer is timed in one call; the counting run before it serves as its warm-up."""
    timed: bool = True
    """Whether times are recorded; else a run has only errors."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What a suite may cost. The limits of a trial are several times the time of the started trials on a quiet machine."""

    limit_seconds: float
    """The time limit of a trial on a default variant."""
    variant_limit_seconds: float
    """The time limit of a trial on another variant."""
    long_limit_seconds: float = 0.4
    """The time limit of a trial on another variant with a long span."""
    engine_limit_seconds: float = 0.0
    """The least limit for physics engines, of which a step takes microseconds at the least."""
    minutes: float = 0.0
    """Minutes of a run after which no repeated launch begins; until then the open comparisons are launched again.
    0: no repeated launches."""
    minutes_with_peers: float = 0.0
    """`minutes` of a run in which a library of the extra `peers` takes part."""
    asked: bool = False
    """Whether the user gave the minutes: open comparisons then run even if an earlier run has spent its own."""


@dataclass(frozen=True)
class Suite:
    """What runs, how it is timed and what it may cost."""

    name: str
    scope: Scope
    timing: Timing
    limits: Limits
    rest: Suite | None = None
    """The suite for the cases outside `FOUNDATION`; None if they run like the others."""
    shard: tuple[int, int] = (1, 1)
    """The part of the series that runs, from 1, and the number of parts (see `cost.shard`)."""
    repeat: Repeat = Repeat.NOTHING

    def change(self, **values: Any) -> Suite:
        """A copy with other values of its own fields, or of the fields of its parts, which have different names."""
        parts = {
            part: replace(getattr(self, part), **{name: values.pop(name) for name in FIELDS[part] & values.keys()})
            for part in FIELDS
        }
        return replace(self, **(parts | values))

    def of(self, case: Case) -> Suite:
        """The suite for a case: this one or `rest`."""
        return self._of(case.name)

    def _of(self, name: str) -> Suite:
        return self if self.rest is None or name in FOUNDATION else self.rest

    def names(self) -> list[str]:
        """The names that run unless the user names cases: the default variants of its cases, then hard variants."""
        own = self.scope.cases or cases.names()
        hard = [
            f"{name}/{v.name}" for name in own if self._of(name).scope.variants for v in cases.case_class(name).variants
        ]
        return list(dict.fromkeys([*own, *(self.scope.hardest or hard), *self.scope.further]))

    def within(self, limit_seconds: float) -> Suite:
        """A copy with one time limit for every trial."""
        return self.change(
            limit_seconds=limit_seconds,
            variant_limit_seconds=limit_seconds,
            long_limit_seconds=limit_seconds,
            engine_limit_seconds=limit_seconds,
            rest=self.rest and self.rest.within(limit_seconds),
        )

    def untimed(self) -> Suite:
        """A copy for errors alone: each series is launched once, and each trial is one call of `solve`."""
        return self.once().change(
            timed=False,
            launches=1,
            timing_spans=False,
            scatter_launches=0,
            repeats=1,
            rest=self.rest and self.rest.untimed(),
        )

    def once(self) -> Suite:
        """A copy without further launches of open comparisons, and without the time of one more period."""
        if not self.limits.minutes:
            return self
        return self.change(minutes=0.0, minutes_with_peers=0.0, timing_spans=False)

    def methods(self, integrators: Iterable[Integrator]) -> tuple[Integrator, ...]:
        """Those of all `integrators` that run unless the user names some.

        Engines that are declared for one suite run in this suite alone.
        """

        def runs(integrator: Integrator) -> bool:
            library = LIBRARIES.get(integrator.library)
            if library is not None and library.suite not in (None, self.name):
                return False
            if self.scope.engines:
                return is_engine(integrator) and integrator.library != "engine"
            return not self.scope.primary or integrator.primary or integrator.id in self.scope.for_stiff

        return tuple(integrator for integrator in integrators if runs(integrator))

    def has(self, series: Series) -> bool:
        """Whether a series belongs to the suite; false for a method that is `for_stiff` or `for_events` elsewhere."""
        case, name = series.case, series.integrator.id
        if name in self.scope.for_stiff:
            return series.formulation is None and f"{case.name}/{case.variant}" in STIFF
        return name not in self.scope.for_events or case.hybrid is not None

    def budget(self, integrators: Iterable[Integrator]) -> float:
        """Minutes of a run with these integrators after which no repeated launch begins; missing ones take no time."""
        known = [integrator for integrator in integrators if integrator.library in LIBRARIES]
        extras = {LIBRARIES[integrator.library].extra for integrator in known if lookup.missing(integrator) is None}
        return self.limits.minutes_with_peers if "peers" in extras else self.limits.minutes

    def limit(self, case: Case, integrator: Integrator) -> float:
        """The time limit of one trial of a case (s).

        A variant has its own, longer if its span is above 1000 time scales; a trial of an engine has a longer one.
        """
        seconds = self.limits.limit_seconds
        if case.variant is not None:
            length = float(case.span) / case.time_scale / LONG
            seconds = min(self.limits.long_limit_seconds, self.limits.variant_limit_seconds * max(1.0, length))
        return max(seconds, self.limits.engine_limit_seconds) if is_engine(integrator) else seconds


PARTS: dict[str, type] = {"scope": Scope, "timing": Timing, "limits": Limits}
FIELDS = {name: {*part.__annotations__} for name, part in PARTS.items()}
"""The names of the fields of each part of a suite."""


def _make_suite(name: str, rest: dict[str, Any] | None = None, **row: Any) -> Suite:
    """A suite from a table of suites.toml, which has the fields of all its parts."""
    row = {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}
    if named := row.get("integrators"):
        quick = tuple(f"{library.name}:{name}" for library in LIBRARIES.values() for name in library.quick)
        row["integrators"] += () if any(name.partition(":")[0] in LIBRARIES for name in named) else quick
    parts = {part: kind(**{key: row.pop(key) for key in FIELDS[part] & row.keys()}) for part, kind in PARTS.items()}
    return Suite(name, **parts, **row, rest=None if rest is None else _make_suite("rest", **rest))


STIFF = frozenset(read_declared("results", "advice/needs.toml")["stiff"]["decays"])
"""The variants, as case/variant, of which the report says what stiffness costs."""
SUITES = {name: _make_suite(name, **row) for name, row in read_declared("running", "suites.toml").items()}
FOUNDATION = SUITES["foundation"].scope.cases
"""Cases that together have every form."""


def suite(name: str) -> Suite:
    """A suite by name; ValueError for an unknown one."""
    if name not in SUITES:
        raise ValueError(f"no suite is called {name!r}; {nearest(name, SUITES)}")
    return SUITES[name]


@dataclass(frozen=True)
class Trial:
    """One setting of a series. `key` is a hash of everything that its outcome depends on."""

    key: str
    setting: float | None


@dataclass(frozen=True)
class Series:
    """One case variant in one formulation with one integrator, at all settings of its sweep, from cheap to expensive.

    `left_out` is (status, reason) if the pair cannot run, else None.
    """

    case: Case
    formulation: Formulation | None
    integrator: Integrator
    left_out: tuple[Status, str] | None = None
    label: str = field(default="")

    @property
    def variant(self) -> str:
        return (self.case.variant or DEFAULT) + self.label

    @property
    def over_timing_span(self) -> bool:
        """Whether it runs over several spans of its case for the time of one more period, without turned starts."""
        return self.label.startswith(TIMING_SPAN)

    @property
    def formulation_name(self) -> str:
        return STANDARD if self.formulation is None else self.formulation.name

    @property
    def id(self) -> str:
        return f"{self.case.name}/{self.variant} | {self.formulation_name} | {self.integrator.id}"

    @cached_property
    def form(self) -> Any:
        return find_accepted_form(self.case, self.integrator.accepts, self.formulation)

    def trials(self, problem: Problem, machine: str | None = None, settings: Chosen | None = None) -> tuple[Trial, ...]:
        """The trials on `problem` at the settings of the sweep, or at chosen `settings`.

        A pair that is left out has one trial, without a setting. The keys of trials belong to a `machine`, by default to
        this one (see `environment.machine`).
        """
        base = [*self._key_parts(problem), machine or environment.machine()]
        if self.left_out is not None:
            return (Trial(sources.digest([*base, *self.left_out]), None),)
        values = sweep_settings(self.integrator, self.case, problem, settings)
        return tuple(Trial(sources.digest([*base, value.hex()]), value) for value in values)

    def _key_parts(self, problem: Problem) -> list[str]:
        numbers = {name: str(value) for name, value in self.case.numbers.items()} | {"span": str(self.case.span)}
        coding = (
            "" if self.formulation is None else sources.of_value((self.formulation.encode, self.formulation.decode))
        )
        pickle, modules = references.pickle_integrator(self.integrator)
        return [
            self.case.name,
            self.variant,
            json.dumps(numbers),
            problem.times.tobytes().hex(),
            json.dumps(problem.groups),
            self.formulation_name,
            coding,
            sources.of_value(self.form),
            closure(type(self.case).__module__) or _THIS_PROCESS,
            self.integrator.id,
            _THIS_PROCESS if pickle is None else pickle.hex(),
            closure(*modules) or _THIS_PROCESS,
            json.dumps(library_versions(self.integrator)),
        ]

    def describe(self, trial: Trial, **numbers: Any) -> dict[str, Any]:
        """The row of the store's table `trials`; `numbers` are columns from the problem and reference solution."""
        return {"trial_key": trial.key, "setting": trial.setting, **self._description, **numbers}

    @cached_property
    def _description(self) -> dict[str, Any]:
        case, integrator = self.case, self.integrator
        return {
            "series": self.id,
            "section": case.section,
            "title": case.title,
            "case": case.name,
            "variant": self.variant,
            "stresses": case.stresses,
            "formulation": self.formulation_name,
            "form": None if self.form is None else type(self.form).__name__,
            "library": integrator.library,
            "integrator": integrator.name,
            "policy": integrator.policy,
            "integrator_id": integrator.id,
            "order_declared": integrator.order,
            "sampling": integrator.sampling,
            "conserves": ", ".join(integrator.conserves),
            "setting_kind": integrator.sweep.kind,
            "span": float(case.span),
            "time_scale": case.time_scale,
            "numbers": {name: str(value) for name, value in case.numbers.items()},
            "machine": environment.machine(),
        }


@cache
def library_versions(integrator: Integrator) -> dict[str, str]:
    """The versions that a result of this integrator depends on: Python calls all integrators, the COMPILERS compile some."""
    versions = {"python": platform.python_version(), "numpy": environment.library_version("numpy") or ""}
    if imports(type(integrator).__module__, COMPILING, within=INTEGRATORS):
        versions |= {name: environment.library_version(name) or "" for name in COMPILERS}
    try:
        versions |= {name: str(value) for name, value in integrator.versions().items()}
    except ImportError:
        versions |= {integrator.library: "missing"}
    return versions


def list_series(
    chosen: Sequence[tuple[Case, str]],
    integrators: Sequence[Integrator],
    formulations: bool = True,
    near_duplicates: bool = True,
    always: Container[str] = (),
) -> list[Series]:
    """The series of every chosen case, in every formulation with every integrator.

    `chosen`: (case, label), where the label is "", or names the span as `lengthen` does. An integrator that cannot run a
    case has a series too, with the reason. If `near_duplicates` is False, a near-duplicate method on a hard variant is left
    out, unless `always` holds its id.
    """
    series = []
    absent = {integrator: lookup.missing(integrator) for integrator in integrators}
    for case, label in chosen:
        others = case.formulations if formulations and not label.startswith(TIMING_SPAN) else ()
        own: tuple[Formulation | None, ...] = (None, *others)
        for formulation in own:
            for integrator in integrators:
                form = find_accepted_form(case, integrator.accepts, formulation)
                if formulation is not None and form is None:
                    continue  # the case's own formulation has the row for this pair
                left_out = _find_left_out(case, integrator, form, absent[integrator])
                pair = Series(case, formulation, integrator, left_out, label)
                repeated = case.variant is not None or pair.over_timing_span
                wanted = near_duplicates or integrator.primary or integrator.id in always
                if left_out is None and repeated and not wanted:
                    pair = replace(pair, left_out=NEAR_DUPLICATE)
                series.append(pair)
    return series


def lengthen(case: Case, factor: int) -> tuple[Case, str]:
    """The case over `factor` times its span, with the label of its series."""
    return case.rounded().with_span(case.rounded().span * factor).rounded(), f"{TIMING_SPAN}{factor}"


def with_timing_spans(chosen: Sequence[tuple[Case, str]], suite: Suite) -> list[tuple[Case, str]]:
    """The chosen cases, and a lengthened copy of each case of which the suite measures one more period."""
    wanted = [case for case, label in chosen if suite.timing.timing_spans and not label and case.variant is None]
    return [*chosen, *(lengthen(case, TIMING_FACTORS[case.name]) for case in wanted if case.name in TIMING_FACTORS)]


def _find_left_out(case: Case, integrator: Integrator, form: Any, absent: str | None) -> tuple[Status, str] | None:
    """(status, reason) of a pair that cannot run, else None; `absent` is the reason if the library is missing."""
    if form is None:
        return Status.UNSUPPORTED, case.explain_form(" or ".join(kind.__name__ for kind in integrator.accepts))
    if absent is not None:
        return Status.NOT_INSTALLED, absent
    try:
        lacking = integrator.unsupported(form)
    except Exception as error:  # an exception in one integrator must not end the trials of the others
        return Status.CRASHED, f"its unsupported() raises {type(error).__name__}: {error}"
    if lacking is not None and not isinstance(lacking, str):
        return Status.CRASHED, f"its unsupported() returns {short(lacking)}: it is a text, or None"
    return None if lacking is None else (Status.UNSUPPORTED, lacking)


def launches(series: Series, suite: Suite, near_duplicates: bool = True) -> int:
    """The number of launches of a series in a suite.

    It is one for hard variants, and for near-duplicate methods that are not named. A case is launched equally often over
    its timing span and over its own, so that each launch gives a difference of times: the time of one more period.
    """
    often = series.case.variant is None and (near_duplicates or series.integrator.primary)
    return suite.of(series.case).timing.launches if often else 1


def wants_first_use(series: Series, suite: Suite, launch: int) -> bool:
    """Whether the first use of an integrator is timed at the first trial of this launch.

    It is timed on the first default variant in FOUNDATION that the integrator accepts, if a new process can import it.
    """
    wanted = suite.timing.first_use and suite.timing.timed and launch == 1
    own = series.formulation is None and series.case.variant is None and not series.label
    right_case = wanted and own and series.case.name == _first_case(series.integrator)
    return right_case and isinstance(references.reference(series.integrator), bytes)


@cache
def _first_case(integrator: Integrator) -> str | None:
    """The first foundation case with a form that the integrator accepts."""
    return next((name for name in FOUNDATION if takes(integrator, cases.get(name))), None)

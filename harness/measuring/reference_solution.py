"""The reference solution of a case, computed before anything runs: exact states at the samples, floor, conditioning."""

import json
import math
import os
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Self

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.formulation import Formulation
from gnomon.cases.core.turning import turned_cases
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.system.supervisor import calls
from gnomon.reference.storage import diskcache
from gnomon.reference.storage.import_closure import closure
from numpy.typing import NDArray

from gnomon import cases

PACK = Path(__file__).with_name("reference_solutions.zip")
"""The reference solutions of all default cases and of hard variants that users solve in their first minutes, made by
`make solutions`; a solution whose sources changed is computed again."""
OWN_SYSTEMS = "gnomon.harness.own_systems."
"""The package whose classes are made while a process runs."""
_OWN = (__name__, "gnomon.harness.contract.problem")


@dataclass(frozen=True)
class ReferenceSolution:
    """The reference solution of one case in one formulation.

    `times` (64,), `exact` (64, dim), `floor` and `conditioning` (64,) belong to the case; `problem_times` (64,),
    `start` (dim_y,) and `time_scale` are given to the integrator. `sizes` (dim,) is the scale of each coordinate's
    group in the metric; `crowded` (64,) marks the times at which the metric compares positions only.

    For a default variant with a rotational symmetry, `turned` (n, dim) are the turned starts, `turned_starts` (n,
    dim_y) are these starts as the integrator gets them, and `turned_exact` (n, 64, dim) their exact motions; else n is
    0.
    """

    times: Floats
    exact: Floats
    floor: Floats
    conditioning: Floats
    problem_times: Floats
    start: Floats
    sizes: Floats
    crowded: NDArray[np.bool_]
    time_scale: float
    turned: Floats
    turned_starts: Floats
    turned_exact: Floats


@dataclass(frozen=True)
class CaseSpec:
    """A case and a formulation as plain data, to send to another process."""

    path: str
    variant: str | None
    initial_state: tuple[str, ...]
    parameters: tuple[tuple[str, str], ...]
    span: str
    formulation: str | None = None

    @classmethod
    def of(cls, case: Case, formulation: Formulation | None = None) -> Self:
        kind = type(case)
        return cls(
            f"{kind.__module__}:{kind.__qualname__}",
            case.variant,
            tuple(map(str, case.initial_state)),
            tuple((name, str(value)) for name, value in case.parameters.items()),
            str(case.span),
            None if formulation is None else formulation.name,
        )

    @property
    def in_main(self) -> bool:
        """Whether the case is defined in the script that runs."""
        return self.path.startswith("__main__:")

    @property
    def in_process(self) -> bool:
        """Whether only this process and its forks have the case: it was made of a user's equations."""
        return self.path.startswith(OWN_SYSTEMS)

    def build(self) -> tuple[Case, Formulation | None]:
        kind = cases.case_class(self.path)
        case = kind(initial_state=self.initial_state, span=self.span, **dict(self.parameters))
        case.variant = self.variant
        named = [f for f in case.formulations if f.name == self.formulation]
        return case, named[0] if named else None


def reference_solution(spec: CaseSpec) -> ReferenceSolution:
    """The reference solution of a case, from the cache on disk unless a source of case or exact motion changed."""

    key = _key(spec)
    if key is None:
        return _compute(spec)
    return _read(diskcache.cached(key, lambda: _entry(_compute(spec)), PACK))


def find_kept(spec: CaseSpec) -> ReferenceSolution | None:
    """The reference solution that is in the cache on disk or comes with gnomon; None if it would have to be computed."""
    key = _key(spec)
    entry = None if key is None else diskcache.load(key, PACK)
    return None if entry is None else _read(entry)


def reference_solutions(
    specs: Sequence[CaseSpec], progress: Callable[[], None]
) -> dict[CaseSpec, ReferenceSolution | str]:
    """The reference solutions of several cases, computed in parallel if not on disk; `progress` runs after each.

    If a case fails, the value is the message of its exception: one broken case does not end a run.
    """
    by_spec: dict[CaseSpec, ReferenceSolution | str] = {}
    for spec in specs:
        solution = find_kept(spec)
        if solution is not None:
            by_spec[spec] = solution
            progress()
    missing = [spec for spec in specs if spec not in by_spec]
    if not missing:
        return by_spec
    workers = min(os.cpu_count() or 1, len(missing))
    how: dict[str, Any] = {"method": "fork"} if any(spec.in_process for spec in missing) else {}
    in_main = any(spec.in_main for spec in missing)
    with closing(calls(reference_solution, missing, workers, main=in_main, **how)) as solutions:
        for spec, result in solutions:
            by_spec[spec] = f"{type(result).__name__}: {result}" if isinstance(result, BaseException) else result
            progress()
    return by_spec


def make_entry(spec: CaseSpec, solution: ReferenceSolution | str) -> tuple[str, diskcache.Entry]:
    """The key and the content under which a solution is kept. Raises ValueError without a solution or key."""
    key = _key(spec)
    if key is None or isinstance(solution, str):
        raise ValueError(f"{spec.path} has no reference solution to keep: {solution}")
    return key, _entry(solution)


def _entry(solution: ReferenceSolution) -> diskcache.Entry:
    return diskcache.Entry({name: np.asarray(getattr(solution, name)) for name in solution.__dataclass_fields__})


def _key(spec: CaseSpec) -> str | None:
    """The key of a reference solution on disk; None if a source is not in a file, or was edited after it was loaded."""
    if spec.in_process:
        return None
    code, scoring = closure(spec.path.partition(":")[0]), closure(*_OWN, within=())
    if code is None or scoring is None:
        return None
    numbers = json.dumps([getattr(spec, name) for name in spec.__dataclass_fields__])
    return f"reference solution 1\n{code}{scoring}\n{numbers}"


def _read(entry: diskcache.Entry) -> ReferenceSolution:
    arrays = dict(entry.arrays)
    scale = float(arrays.pop("time_scale"))
    return ReferenceSolution(**arrays, time_scale=scale)


def _compute(spec: CaseSpec) -> ReferenceSolution:
    case, formulation = spec.build()
    times = case.times
    sizes = np.empty(len(case.state))
    for group in case.metric.groups:
        sizes[list(group.indices)] = group.scale
    conditioning = case.conditioning(times)
    start = initial_state(case, formulation)
    if formulation is not None:
        conditioning = np.hypot(conditioning, _encoding_effect(case, formulation, start))
    problem = problem_of(case, (object,), formulation)
    turned = turned_cases(case) if case.variant is None else []
    dimension = len(case.state)
    return ReferenceSolution(
        times,
        case.sample(times),
        case.floor(times),
        conditioning,
        problem.times,
        start,
        sizes,
        np.isin(times, list(case.metric.crowded)),
        problem.time_scale,
        np.array([[float(x) for x in turn.initial_state] for turn in turned]).reshape(-1, dimension),
        np.array([initial_state(turn, formulation) for turn in turned]).reshape(-1, len(start)),
        np.array([turn.sample(times) for turn in turned]).reshape(-1, len(times), dimension),
    )


def _encoding_effect(case: Case, formulation: Formulation, start: Floats) -> Floats:
    """The typical effect of half an ulp in each component of a formulation's initial state, shape (64,).

    Central differences of `decode` give the resulting change of the case's initial state (curvature contributes 1e-10
    of the half ulp); the exact motion gives the change at the samples.
    """
    parameters = [float(value) for value in case.parameter_values()]
    nominal = [case.exact(t, 40) for t in case.times.tolist()]
    total = np.zeros(len(case.times))
    for index, value in enumerate(start.tolist()):
        if value == 0 or index == formulation.clock:
            continue
        step = np.zeros_like(start)
        step[index] = abs(value) * 2.0**-20
        with np.errstate(invalid="ignore"):
            slope = formulation.decode(start + step, parameters) - formulation.decode(start - step, parameters)
            ratio = Fraction(math.ulp(value)) / 4 / Fraction(float(step[index]))
            if not np.all(np.isfinite(slope)):
                # At the edge of the domain of `decode`, for example next to a cusp: one ulp inward, halved.
                step[index] = math.copysign(math.ulp(value), value)
                here = np.array([float(x) for x in case.initial_state])
                slope, ratio = here - formulation.decode(start - step, parameters), Fraction(1, 2)
        changes = [Fraction(float(d)) * ratio for d in slope]
        neighbour = _perturb(case, changes)
        if neighbour is not None:
            states = [neighbour.exact(t, 40) for t in case.times.tolist()]
            total += _distances(case, states, nominal) ** 2
    return np.asarray(np.sqrt(total))


def _perturb(case: Case, changes: Sequence[Fraction]) -> Case | None:
    """The case with `changes` added to its initial state, or subtracted if the sum is outside the domain; else None."""
    for sign in (1, -1):
        state = [x + sign * change for x, change in zip(case.initial_state, changes, strict=True)]
        try:
            return case.with_numbers(state, case.parameters)
        except ValueError:
            continue
    return None


def _distances(case: Case, states: Sequence[tuple[Any, ...]], nominal: Sequence[tuple[Any, ...]]) -> Floats:
    """Distances of states that differ by far less than an ulp: the subtraction is in high precision."""
    rows = np.array([[float(x - y) for x, y in zip(a, b, strict=True)] for a, b in zip(states, nominal, strict=True)])
    return np.asarray(np.max(list(case.metric.by_group(rows, np.zeros_like(rows)).values()), axis=0))

"""How the error of energy grows over up to 1e5 periods: its power of time, fitted for every in-house smooth method.

Symplectic methods keep it bounded while their discretization error dominates (backward error analysis: Hairer, Lubich,
Wanner, Geometric Numerical Integration, IX.8). If round-off dominates and is unbiased, it grows as a random walk,
t^(1/2): Brouwer's law (Astronomical Journal 46, 1937; Hairer, McLachlan, Razakarivony, BIT 48, 2008). Else it grows
as t.

A law is named only if the interval of the power, by bootstrap over the starts, excludes every other law.

`python -m gnomon.harness.studies.growth --out reports/local/growth.json` is part of `make bench`.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import FirstOrder, SecondOrder
from gnomon.cases.core.registry import get
from gnomon.harness.contract import validation
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Floats, Integrator
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.integrators.base.step_control import Adaptive
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.measuring.score import NUMPY
from gnomon.harness.measuring.solved import outcome
from gnomon.harness.registry import lookup
from gnomon.harness.results.study_file import publish

SAMPLES = 4096
"""Number of samples. The earliest octave of the fit then has 32; a mean square over fewer is too often too small."""
DECADES = 2.0
"""The power is fitted over the last two decades of time, where effects of the start have decayed."""

STRETCH = 1.0123
"""Factor on steps and span: if a step divided the period, the same rounding errors would repeat in every period."""

PERIODS = ("period", "gyration_period", "body_period")
LAWS = {"bounded": 0.0, "sqrt t": 0.5, "t": 1.0, "t^1.5": 1.5, "t^2": 2.0}

FIT = 0.03
"""Largest bias of the power over a finite span, common to all starts, from bounded terms beside the growing ones."""

CONFIDENCE, RESAMPLES = 0.95, 10_000


@dataclass(frozen=True)
class Subject:
    """An integrator by its id on a case, over `periods` periods from `starts` starts.

    `setting`: steps in a period if above 1, else the tolerance. `expected`: the law of theory. `parts`: number of
    solves that the span is divided into, each from the last state of the one before, for methods that limit the number
    of their steps. `together`: maximum number of starts in one solve, for methods that use other code for an ensemble.
    """

    integrator: str
    setting: float
    expected: str
    case: str = "pendulum_simple"
    periods: float = 1e5
    starts: int = 24
    parts: int = 1
    together: int = 24
    samples: int = SAMPLES
    parameters: Mapping[str, Any] = field(default_factory=dict)


def subjects_of(methods: Iterable[Integrator]) -> list[Subject]:
    """The subjects of methods: as growth.toml lists them, or by the defaults of this file; none for a method without either."""
    table = read_declared("studies", "growth.toml")
    listed: dict[str, list[Subject]] = {}
    for row in table["subjects"]:
        for name in row.pop("integrators"):
            listed.setdefault(f"gnomon:{name}", []).append(Subject(f"gnomon:{name}", **row))
    return [subject for method in methods for subject in listed.get(method.id) or _find_default(method, table)]


def _find_default(method: Integrator, table: Mapping[str, Any]) -> list[Subject]:
    """Of a symplectic or reversible method the law is that its error is bounded, of any other that it grows as t."""
    if not {FirstOrder, SecondOrder} & {*method.accepts} or method.order is None:
        return []
    bounded = bool({"symplectic", "reversible"} & {*method.conserves})
    rows = table["pairs" if isinstance(method, Adaptive) else "bounded" if bounded else "fixed"]
    expected = "bounded" if bounded else "t"
    fitting = [row for row in rows if method.order <= row["order"]][:1]
    return [Subject(method.id, row["setting"], expected, periods=row["periods"]) for row in fitting]


SUBJECTS = subjects_of(lookup.in_house())


def measure_growth(subject: Subject) -> dict[str, Any]:
    """A row of the published table: the fitted power of time, its standard error and interval, and the law."""
    times, errors = energy_errors(subject)
    powers = fit_powers(times, errors)
    low, high = interval_of_mean(powers)
    return {
        "integrator": subject.integrator.removeprefix("gnomon:"),
        "case": subject.case,
        "setting": ("about {:g} steps a period" if subject.setting > 1 else "tolerance {:g}").format(subject.setting),
        "periods": subject.periods,
        "starts": subject.starts,
        "size": float(np.median(np.sqrt(np.mean(errors[:, -8:] ** 2, axis=1)))),
        "power": float(np.mean(powers)),
        "uncertainty": float(np.std(powers, ddof=1) / math.sqrt(len(powers))),
        "low": low,
        "high": high,
        "law": name_law(low, high),
        "expected": subject.expected,
    }


def name_law(low: float, high: float, words: Mapping[str, str] | None = None) -> str:
    """The only law that an interval of the power of time contains, or all of them, or its neighbours; in words.

    `words`: other spellings of the names in LAWS.
    """
    spelled = {law: (words or {}).get(law, law) for law in LAWS}
    laws = possible(low, high)
    if laws:
        *others, last = (spelled[law] for law in laws)
        return f"undecided between {', '.join(others)} and {last}" if others else last
    below = [spelled[law] for law, power in LAWS.items() if power < low]
    above = [spelled[law] for law, power in LAWS.items() if power > high]
    return f"between {below[-1]} and {above[0]}" if above else f"faster than {below[-1]}"


def possible(low: float, high: float) -> list[str]:
    """The laws that an interval of the power of time does not exclude. A negative power counts as bounded."""
    return [law for law, power in LAWS.items() if low - FIT <= power <= max(high, 0.0) + FIT]


def energy_errors(subject: Subject) -> tuple[Floats, Floats]:
    """Times in periods (SAMPLES,) and |energy / initial energy - 1| (starts, SAMPLES), in extended precision."""
    case = get(subject.case, **subject.parameters).rounded()
    times, start, states, _ = trajectories(subject, case, lookup.own()[subject.integrator])
    return times / period_of(case), relative_drift(case, start, states)


def relative_drift(case: Case, start: Floats, states: Floats) -> Floats:
    """|energy / initial energy - 1|, shape (starts, times), of states (starts, times, dim)."""
    energy = next(name for name in case.invariants if "energy" in name)
    parameters = np.array([float(x) for x in case.parameter_values()])
    value = in_extended_precision(case.invariants[energy].function, parameters)
    return np.asarray(np.abs(value(states) / value(start)[:, None] - 1), dtype=np.float64)


def trajectories(subject: Subject, case: Case, integrator: Integrator) -> tuple[Floats, Floats, Floats, float | None]:
    """Times (samples,), starts (starts, dim), states (starts, samples, dim), and the number of steps from a start.

    The number is None if the integrator does not count its steps. Start number k is the case's initial state times 1 -
    k/64. Raises Refused if an integration ends early, or if a solution equals its start at all samples.
    """
    count = subject.samples // subject.parts
    interval = twenty_bits(STRETCH * period_of(case) * subject.periods / subject.samples)
    whole = np.arange(1, subject.samples + 1, dtype=np.float64) * interval
    problem = replace(problem_of(case, integrator.accepts), times=whole[:count])
    setting = subject.setting
    if setting > 1:
        setting = interval / max(1, round(setting * subject.periods / subject.samples))
    start = initial_state(case) * (1 - np.arange(subject.starts)[:, None] / 64)
    state, pieces, steps = start, [], []
    with Prepared(integrator, problem, setting) as solver:
        for _ in range(subject.parts):
            parts = np.split(state, range(subject.together, len(state), subject.together))
            solutions = [outcome(partial(solver.counted, each)).whole for each in parts]
            pieces.append(np.concatenate([solution.states for solution in solutions]))
            steps += [solution.steps for solution in solutions]
            state = pieces[-1][:, -1]
    states = np.concatenate(pieces, axis=1)
    validation.require_motion(states, start)
    counted = [each for each in steps if each is not None]
    return whole, start, states, sum(counted) / len(start) if len(counted) == len(steps) else None


def period_of(case: Case) -> float:
    numbers = case.quantities()
    return next((float(numbers[name]) for name in PERIODS if name in numbers), 2 * math.pi * float(case.time_scale))


def twenty_bits(x: float) -> float:
    """`x` rounded down to twenty significant bits, so that its multiples are exact."""
    unit = math.ldexp(1.0, math.frexp(x)[1] - 20)
    return math.floor(x / unit) * unit


def in_extended_precision(function: Callable[..., Any], parameters: Floats) -> Callable[[Floats], Any]:
    """An invariant for arrays of states (..., dim) in long double, with a rounding error far below the states' own."""
    bound, wide = rebind(function, NUMPY), tuple(np.longdouble(x) for x in parameters)

    def value(states: Floats) -> Any:
        return bound(np.longdouble(0), tuple(np.moveaxis(states.astype(np.longdouble), -1, 0)), wide)[0]

    return value


def fit_powers(times: Floats, errors: Floats) -> Floats:
    """The power of time of the errors (starts, times) of each start; a start without any error in an octave has none.

    The power is the slope of a line through the logarithms of the root mean squares over octaves of time. Each start
    has its own power, so that a start whose rounding errors repeat (period and step in a simple ratio) does not
    dominate.
    """
    centres, sizes = by_octaves(times, errors, math.ceil(DECADES / math.log10(2)))
    usable = np.all(np.isfinite(sizes), axis=0)
    return np.polyfit(centres, sizes[:, usable], 1)[0] if len(centres) > 1 and np.any(usable) else np.zeros(0)


def by_octaves(times: Floats, errors: Floats, count: int) -> tuple[Floats, Floats]:
    """For the last `count` octaves of time with samples, latest first: the mean of log time, and logs of errors.

    The means have the shape (octaves,). The size is the root mean square of errors (series, times); its logarithms have
    the shape (octaves, series).
    """
    octave = np.floor(np.log2(times[-1] / times)).astype(int)
    chosen = [octave == k for k in np.unique(octave[octave < count])]
    centres = np.array([np.mean(np.log(times[mask])) for mask in chosen])
    with np.errstate(divide="ignore"):  # no error in an octave: its logarithm is -inf, and no power is found
        return centres, np.array([np.log(np.sqrt(np.mean(errors[:, mask] ** 2, axis=1))) for mask in chosen])


def interval_of_mean(values: Floats, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Bootstrap interval of the mean of `values`: percentiles of the means of RESAMPLES samples with replacement."""
    chosen = np.random.default_rng(len(values)).integers(len(values), size=(RESAMPLES, len(values)))
    low, high = np.quantile(values[chosen].mean(axis=1), [(1 - confidence) / 2, (1 + confidence) / 2])
    return float(low), float(high)


def main() -> None:
    publish(__doc__, measure_growth, SUBJECTS)


if __name__ == "__main__":
    main()

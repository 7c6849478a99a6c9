"""The settings of a sweep: tolerances or step sizes, as an integrator declares them or as a user chooses them."""

import math
from collections.abc import Iterable, Mapping, Sequence

from gnomon.cases import Case
from gnomon.harness.contract.integrator import Integrator, Problem, Steps, Tolerance
from gnomon.harness.contract.validation import is_finite, short

FEWEST = 8
"""Minimum number of step sizes of a sweep."""
DECIMAL_STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)
"""Step sizes (s) on the variants `engines*`, whose sample times are multiples of 0.01 s. A sweep of n halvings takes the
n + 1 largest of them: a method declares few halvings if smaller steps would only show its round-off."""
KINDS = (Tolerance.kind, Steps.kind)
Chosen = Mapping[str, Sequence[float]]
"""The settings that a user chose, by kind (`KINDS`), from cheap to expensive. Without an entry for its kind, a method runs its own sweep."""
EXAMPLE = "as 1e-6,1e-9 or, for a run of methods of both kinds, tolerance=1e-6,1e-9 and step=0.1,0.05"


def sweep_settings(
    integrator: Integrator, case: Case, problem: Problem, chosen: Chosen | None = None
) -> tuple[float, ...]:
    """The settings at which an integrator runs, from cheap to expensive: those `chosen` for its kind, else its own sweep.

    A chosen step size that does not divide the sampling interval is replaced by the next smaller step size that does.
    """
    sweep = integrator.sweep
    values = (chosen or {}).get(sweep.kind)
    if values is not None:
        steps = isinstance(sweep, Steps) and problem.uniform
        return tuple(dict.fromkeys(_divide(problem.interval, h) if steps else h for h in values))
    if isinstance(sweep, Tolerance):
        return _tolerances(sweep)
    if case.variant is not None and case.variant.startswith("engines"):
        return DECIMAL_STEPS[: sweep.halvings + 1]
    return _steps(sweep, problem.interval, problem.time_scale)


def _tolerances(sweep: Tolerance) -> tuple[float, ...]:
    decades = math.log10(sweep.loosest / sweep.tightest)
    count = max(round(decades * sweep.per_decade), 1)
    loosest = math.log10(sweep.loosest)
    return tuple(float(f"{10 ** (loosest - decades * k / count):.3e}") for k in range(count + 1))


def _steps(sweep: Steps, interval: float, time_scale: float) -> tuple[float, ...]:
    """Step sizes: the sample interval over powers of two, which is exact, as the interval has 20 significant bits."""
    first = max(0, math.ceil(math.log2(interval / (sweep.coarsest * time_scale))))
    count = max(sweep.halvings + 1, FEWEST)
    return tuple(math.ldexp(interval, -(first + k)) for k in range(count))


def _divide(interval: float, step: float) -> float:
    """`step` if it divides the interval to rounding, else the next smaller step size that divides it."""
    count = max(1, round(interval / step))
    if abs(count * step - interval) <= 2 * math.ulp(interval):
        return step
    return interval / max(1, math.ceil(interval / step))


def choose_settings(asked: Chosen | Iterable[float], integrators: Iterable[Integrator]) -> Chosen:
    """Validate the settings that a user gives for these integrators, and sort them from cheap to expensive.

    `asked` is a list by kind, "tolerance" or "step", or one list if all integrators take settings of one kind. Raises
    ValueError for an impossible setting, an unknown kind, a kind that no integrator takes, and one list for two kinds.
    """
    example_of = {integrator.sweep.kind: integrator.id for integrator in reversed([*integrators])}
    if not isinstance(asked, Mapping):
        asked = [*asked]
        if len(example_of) > 1:
            tolerance, step = (example_of[kind] for kind in KINDS)
            raise ValueError(
                f"settings {_text(asked)}: {tolerance} takes tolerances and {step} step sizes; name the kind, {EXAMPLE}"
            )
        asked = {kind: asked for kind in example_of}
    settings = {}
    for kind, values in asked.items():
        if kind not in KINDS:
            raise ValueError(f"settings {kind}={_text(values)}: a setting is a {' or a '.join(KINDS)}, {EXAMPLE}")
        if kind not in example_of:
            raise ValueError(f"settings {kind}={_text(values)}: no integrator of this run takes a {kind}")
        for value in values:
            if not (is_finite(value) and 0 < value < (1 if kind == Tolerance.kind else math.inf)):
                rule = "a positive number" + (" below 1" if kind == Tolerance.kind else ", in the unit of time")
                raise ValueError(f"settings: {short(value)} is not a {kind}; a {kind} is {rule}")
        if not values:
            raise ValueError(f"settings: no {kind} is given; write some, {EXAMPLE}")
        settings[kind] = tuple(sorted({float(value) for value in values}, reverse=True))
    return settings


def read_settings(texts: Sequence[str]) -> dict[str, list[float]] | list[float]:
    """The settings in texts such as ``1e-6,1e-9`` or ``step=0.1,0.05``, as `choose_settings` takes them.

    Raises ValueError for a text without numbers, and for kinds that are named in some of the texts only.
    """
    named: dict[str, list[float]] = {}
    for text in texts:
        kind, equals, numbers = text.rpartition("=")
        if equals and not kind.strip():
            raise ValueError(f"settings {text!r}: write numbers, {EXAMPLE}")
        try:
            values = [float(number) for number in numbers.split(",")]
        except ValueError:
            raise ValueError(f"settings {text!r}: write numbers, {EXAMPLE}") from None
        named.setdefault(kind.strip(), []).extend(values)
    if "" not in named:
        return named
    if len(named) > 1:
        raise ValueError(f"settings {' '.join(texts)}: name the kind in every text or in none, {EXAMPLE}")
    return named[""]


def _text(values: Iterable[float]) -> str:
    return ",".join(f"{value:g}" if is_finite(value) else short(value) for value in values)

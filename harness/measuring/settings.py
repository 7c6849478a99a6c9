"""The settings of a sweep: tolerances or step sizes."""

import math

from gnomon.cases import Case
from gnomon.harness.contract.integrator import Integrator, Problem, Steps, Tolerance

FEWEST = 8
"""Minimum number of settings of a sweep."""
DECIMAL_STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)
"""Step sizes (s) on the variants `engines*`, whose sample times are multiples of 0.01 s. A method that declares few
halvings, because finer steps only show its round-off, has the first of them."""


def sweep_settings(integrator: Integrator, case: Case, problem: Problem) -> tuple[float, ...]:
    """The settings of a sweep, from cheap to expensive; at least FEWEST but on the variants `engines*`."""
    sweep = integrator.sweep
    if isinstance(sweep, Tolerance):
        return _tolerances(sweep)
    if case.variant is not None and case.variant.startswith("engines"):
        return DECIMAL_STEPS[: sweep.halvings + 1]
    return _steps(sweep, problem.interval, problem.time_scale)


def _tolerances(sweep: Tolerance) -> tuple[float, ...]:
    decades = math.log10(sweep.loosest / sweep.tightest)
    count = max(round(decades * sweep.per_decade), FEWEST - 1)
    loosest = math.log10(sweep.loosest)
    return tuple(float(f"{10 ** (loosest - decades * k / count):.3e}") for k in range(count + 1))


def _steps(sweep: Steps, interval: float, time_scale: float) -> tuple[float, ...]:
    """Step sizes: the sample interval over powers of two, which is exact, as the interval has 20 significant bits."""
    first = max(0, math.ceil(math.log2(interval / (sweep.coarsest * time_scale))))
    count = max(sweep.halvings + 1, FEWEST)
    return tuple(math.ldexp(interval, -(first + k)) for k in range(count))

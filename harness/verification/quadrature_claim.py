"""The claim that needs no case: a method is exact for forces that are polynomials in time, below its order."""

import math
from typing import Any

import numpy as np
from gnomon.cases.core.forms import FirstOrder, SecondOrder, Values
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.measuring.trials import HALF_ULP, ROOT_OF_ULP, Trials
from gnomon.harness.verification.claims import Finding, claim, fail_claim, not_applicable, pass_claim

SAMPLES = 4
"""Few samples make steps long and few: the error of a coefficient is then larger than the sum of the roundings."""
CUBIC = 3
"""Largest degree in time: it tests the sum of the weights, the nodes, and their second and third moments."""
HALVED = 6
"""Number of steps, each half of the one before, that an integrator may decline before the claim does not apply."""
ROUNDINGS = 64
"""Largest number of roundings in a step: stages, extrapolations and sums."""
TIGHTER, LESS = 1e-2, 10.0
"""Ratio of a second tolerance to the first, and the least factor by which the error falls: the ratio to the power 1/2,
the lowest for order 1, as for `proportional`."""


DIFFERENCES = 'a method that differentiates f numerically declares jacobian="differences"'
"""Said where an error is so small that differences explain it."""


def polynomial(t: Any, state: Values, parameters: Values) -> Values:
    """y' = a + b t + c t^2 + d t^3, and its negative."""
    a, b, c, d = parameters
    slope = a + t * (b + t * (c + t * d))
    return slope, -slope


def force(t: Any, place: Values, parameters: Values) -> Values:
    """q'' = a + b t + c t^2 + d t^3, and its negative."""
    a, b, c, d = parameters
    slope = a + t * (b + t * (c + t * d))
    return slope, -slope


def _applies(trials: Trials) -> str | None:
    if trials.integrator.order is None:
        return "it declares no order"
    if not {FirstOrder, SecondOrder} & set(trials.integrator.accepts):
        return "it takes no plain equations"
    if FirstOrder not in trials.integrator.accepts and trials.integrator.order < 2:
        return "a method of order 1 need not be exact for accelerations"
    return None


@claim("quadrature", _applies, once=True)
def _quadrature(trials: Trials) -> Finding:
    """With f = f(t) a method of order p is a rule of quadrature, exact for polynomials of degree p - 1.

    For accelerations the degree is p - 2. A method that is not exact by construction has an error that falls with its
    order.
    """
    if trials.steps:
        intervals = (1.0 / (SAMPLES * 2.0 ** np.arange(HALVED))).tolist()
        declined = {h: _error(trials, h)[2] for h in intervals}
        usable = [h for h, why in declined.items() if not why]
        if not usable:
            return not_applicable(
                f"it has no solution where the force is a polynomial in time: {declined[intervals[-1]]}"
            )
        first, second, less = usable[0], usable[0] / 2, 2.0 ** (trials.order - 0.5)
    else:
        first, less = trials.settings[0], LESS  # the fewest steps, and so the least round-off
        second = first * TIGHTER
    error, allowed, why = _error(trials, first)
    if why:
        return not_applicable(f"no solution at {trials.named(first)}: {why}")
    if error <= allowed:
        return pass_claim(f"{error:.2g}")
    finer, allowed_finer, why = _error(trials, second)
    if not why and finer <= max(allowed_finer, error / less):
        return pass_claim(f"{error:.2g}, then {finer:.2g}")
    expected = f"an error below {allowed:.2g}, or {less:.3g} times less at {trials.named(second)}"
    if error < ROOT_OF_ULP and trials.integrator.jacobian == "exact":
        expected += f"; {DIFFERENCES}"
    return fail_claim(trials.named(first), expected, f"{error:.2g}, then {why or format(finer, '.2g')}")


def is_right_at_end(trials: Trials) -> bool:
    """Whether the claim holds at the last sample, at which the last step ends, even if it fails at other samples."""
    error, allowed, why = _error(trials, trials.settings[0], end=True)
    return not why and error <= allowed


def _error(trials: Trials, setting: float, end: bool = False) -> tuple[float, float, str | None]:
    """(error, error allowed for rounding, reason without a solution) for the polynomial from y = 0 over a time of 1.

    With `end` the only sample is at the end.
    """
    twice = FirstOrder not in trials.integrator.accepts
    powers = np.arange(1.0, CUBIC + 2)  # of t in the first components of the exact solution; one more for accelerations
    included = np.arange(CUBIC + 1) <= trials.order - 1 - twice
    samples = max(SAMPLES, math.ceil(1 / setting)) if trials.steps else SAMPLES
    times = np.arange(1, samples + 1)[-1 if end else 0 :] / samples
    coefficients = np.where(included, powers * (powers + 1) if twice else powers, 0.0)
    form = SecondOrder(force) if twice else FirstOrder(polynomial)
    counted = trials.integrator.counts_rhs
    problem = Problem(form, 4 if twice else 2, coefficients, times, 1.0, counted=counted)
    outcome = trials.outcome(problem, setting, np.zeros(problem.dimension))
    solution = outcome.solution
    if solution is None:
        return math.nan, math.nan, outcome.reason
    place = sum(times ** (n + twice) for n in powers[included])
    slope = sum((n + 1) * times**n for n in powers[included])
    exact = np.stack([place, -place, slope, -slope][: problem.dimension], axis=1)
    apart = np.abs(solution.states[0] - exact)[-1 if trials.integrator.sampling == "dense output" else slice(None)]
    size = float(np.max(np.abs(exact)))
    work = solution.steps or outcome.calls or samples
    allowed = 2 * HALF_ULP * ROUNDINGS * work + (ROOT_OF_ULP if trials.integrator.jacobian == "differences" else 0.0)
    return float(np.max(apart)) / size, allowed, solution.stopped

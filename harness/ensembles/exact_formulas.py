"""Exact states of many motions: by compiled formulas for some cases, otherwise by the exact motion of each sample.

A formula computes in double-double and tells which motions it knows. Each value of a known motion is the nearest
double, or within 0.51 ulp away from zeros. The exact motion computes all motions that the formula does not know.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from gnomon.cases import Case
from gnomon.reference.flight import projectile_ensemble
from gnomon.reference.orbits import kepler_ensemble
from gnomon.reference.oscillators import harmonic_ensemble
from gnomon.reference.pendulums import pendulum_ensemble
from numpy.typing import NDArray

from gnomon import cases

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Formula = Callable[[Floats, Floats, Floats], tuple[Floats, Bools]]
"""A function (parameters (n, p), starts (n, dim), times (k,)) -> (states (n, k, dim), flags of known motions (n,)). A
motion whose numbers break a joint rule of the domain is not known."""

OUTSIDE, NO_EXACT_STATE = "outside", "no_exact_state"
"""Statuses of samples that no integrator is given: outside the domain, or with an exact motion out of reach."""

SMALL, LARGE = 1e-100, 1e100
"""Limits of a formula's numbers: between them its products, and their low parts, neither underflow nor overflow."""

FORMULAS: dict[str, Formula] = {
    "pendulum_simple": pendulum_ensemble.states,
    "kepler_orbit": kepler_ensemble.states,
    "harmonic_oscillator": harmonic_ensemble.states,
    "projectile_parabola": projectile_ensemble.states,
}


def formula(case: Case) -> Formula | None:
    """The formula of a case of gnomon; None for a case without a formula."""
    own = FORMULAS.get(case.name)
    return own if own is not None and type(case) is cases.case_class(case.name) else None


def admit(case: Case, parameters: Floats, starts: Floats) -> Bools:
    """Flags of the rows of parameters (n, p) and starts (n, dim) that lie within the ranges of the domain."""
    inside = np.ones(len(starts), dtype=np.bool_)
    columns = zip([*case.parameters, *(c.name for c in case.state)], [*parameters.T, *starts.T], strict=True)
    for name, column in columns:
        allowed = case.domain.ranges.get(name)
        if allowed is not None:
            inside &= (column > allowed.low) if allowed.low_open else (column >= allowed.low)
            inside &= (column < allowed.high) if allowed.high_open else (column <= allowed.high)
    return inside


def exact_states(case: Case, parameters: Floats, starts: Floats, times: Floats) -> tuple[Floats, list[str]]:
    """Exact states (n, k, dim), and for each motion OUTSIDE or NO_EXACT_STATE if its states are nan, otherwise ""."""
    states = np.full((len(starts), len(times), len(case.state)), np.nan)
    inside = admit(case, parameters, starts)
    reasons = ["" if is_inside else OUTSIDE for is_inside in inside.tolist()]
    left = np.flatnonzero(inside)
    own = formula(case)
    if own is not None:
        exact, known = own(parameters[left], starts[left], times)
        sizes = np.abs(np.hstack([parameters[left], starts[left]]))
        known &= np.all((sizes == 0) | ((sizes > SMALL) & (sizes < LARGE)), axis=1)
        states[left[known]] = exact[known]
        left = left[~known]
    for i in left.tolist():
        try:
            states[i] = with_numbers(case, parameters[i], starts[i]).sample(times)
        except ArithmeticError:  # an OutOfReachError is a ValueError too
            reasons[i] = NO_EXACT_STATE
        except ValueError:
            reasons[i] = OUTSIDE
    return states, reasons


def with_numbers(case: Case, parameters: Floats, start: Floats) -> Case:
    """The case with these parameters (p,) and this start (dim,). Raises ValueError if they are outside its domain."""
    return case.with_numbers(start.tolist(), dict(zip(case.parameters, parameters.tolist(), strict=True)))

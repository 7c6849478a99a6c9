"""Initial states perturbed by ulps, for every call that is not scored: no two calls start from the same bits.

An integrator therefore gains nothing by keeping results of an earlier call.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.formulation import Formulation
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.contract.problem import groups_of, initial_state

SHARE = 1e-3
"""A component is perturbed by ulps of the larger of its value and this share of its group's size."""
PROBE = 2.0**-20
"""Relative perturbation that decides whether equal solutions from starts an ulp apart are a coincidence of rounding."""
_ATTEMPTS = 10_000
_ENCODED_ATTEMPTS = 100


def perturb_start(case: Case, formulation: Formulation | None, sizes: Floats, ulps: int = 1) -> Iterator[Floats]:
    """Distinct initial states (dim,) in the case's domain, the nearest first, without the case's own initial state.

    The perturbations are multiples of `ulps` units in the last place.
    """
    state = np.array([float(value) for value in case.initial_state])
    unit = np.array([math.ulp(max(abs(x), SHARE * size)) for x, size in zip(state, sizes, strict=True)])
    return _distinct(case, formulation, state, ulps * unit, ulps * 2.0**-52)


def probe_state(case: Case, formulation: Formulation | None, sizes: Floats) -> Floats:
    """An initial state so far from the case's own that solutions from both differ in their bits."""
    state = np.array([float(value) for value in case.initial_state])
    unit = np.maximum(np.abs(state), SHARE * sizes) * PROBE
    return next(_distinct(case, formulation, state, unit, PROBE))


def _distinct(
    case: Case, formulation: Formulation | None, state: Floats, unit: Floats, relative: float
) -> Iterator[Floats]:
    names = [coordinate.name for coordinate in case.state]

    def admitted(perturbed: Floats) -> bool:
        return case.domain.admits(
            case.parameters | {n: Fraction(x) for n, x in zip(names, perturbed.tolist(), strict=True)}
        )

    def ways() -> list[list[int]]:
        return [[way for way in (1, -1) if admitted(state + way * direction)] for direction in directions]

    directions = np.diag(unit)
    if not any(ways()):
        # A rule of the domain relates the components: each group is perturbed in proportion to its values, by twice the
        # rounding error of the products.
        groups = np.array(groups_of(case))
        tied = [groups == number for number in range(max(groups) + 1)]
        directions = np.array([2 * relative * state * mask for mask in tied])
    start = initial_state(case, formulation)
    known = {start.tobytes()}
    least = 0.0 if formulation is None else math.ulp(SHARE * float(np.max(np.abs(start))))
    failures = 0
    for multiples in _multiples(ways()):
        perturbed = state + np.array(multiples) @ directions
        if admitted(perturbed):
            encoded = perturbed
            if formulation is not None:
                encoded = initial_state(case.with_numbers(perturbed.tolist(), case.parameters), formulation)
            if encoded.tobytes() not in known and np.any(np.abs(encoded - start) >= least):
                known.add(encoded.tobytes())
                failures = 0
                yield encoded
                continue
        failures += 1
        if formulation is not None and failures > _ENCODED_ATTEMPTS:
            break
        if failures > _ATTEMPTS:
            raise ValueError(f"{case.id}: no state next to the initial state is within the domain")
    # At an edge of the formulation (the cycloid's cusp in arc length) neighbours of the state have the same encoding to
    # rounding: there the encoded state is perturbed, inward.
    for k in itertools.count(1):
        yield start * (1.0 - k * relative)


def _multiples(ways: Sequence[Sequence[int]]) -> Iterator[tuple[int, ...]]:
    """Every vector of integers except zero, by the size of its largest component; `ways`: allowed signs of each.

    A component that the domain fixes has no sign and stays 0: with any other value nearly all vectors would be outside
    the domain. Vectors in which all others are perturbed come first.
    """
    for size in itertools.count(1):
        values = [[way * k for k in range(size, 0, -1) for way in signs] + [0] for signs in ways]
        for multiples in itertools.product(*values):
            if max(map(abs, multiples)) == size:
                yield multiples

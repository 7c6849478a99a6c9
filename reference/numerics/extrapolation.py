"""Motions by extrapolation in high precision, which shares only the equations with Taylor series.

Gragg's modified midpoint rule with 2, 4, 6, ... substeps, extrapolated in the square of the substep (Hairer, Norsett
and Wanner, Solving Ordinary Differential Equations I, II.9).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import flint
from gnomon.reference.numerics.balls import ball, precision
from gnomon.reference.numerics.taylor import MAX_STEPS, Field, _fraction

GROW, SHRINK = Fraction(5, 4), Fraction(1, 2)


def extrapolate(
    field: Field, state: Sequence[Fraction], times: Sequence[Fraction], digits: int, step: Fraction
) -> list[tuple[Fraction, ...]]:
    """States at increasing `times` from `state` at t = 0, by steps with an error below 10**-digits of the state.

    `step` (s) is the first step tried. Raises ArithmeticError where the steps fall below 1e-15 s, or for too many.
    """
    columns = max(6, digits // 2 - 2)
    # The table's weights grow to 10**(columns/2); 15 digits cover the round-off of many steps.
    with precision(math.ceil((digits + columns / 2 + 15) * math.log2(10))):
        now, here, states, steps = Fraction(0), [ball(x) for x in state], [], 0
        for time in times:
            while now < time:
                length = min(step, time - now)
                there, error = _extrapolated(field, now, here, length, columns)
                if error < -digits * math.log(10):
                    now, here, steps = now + length, there, steps + 1
                    step = max(step, (length * GROW).limit_denominator(10**9)) if error < -digits * 2.5 else step
                else:
                    step = length * SHRINK
                if steps > MAX_STEPS or step < Fraction(1, 10**15):
                    raise ArithmeticError(f"the extrapolation does not pass t = {float(now):g}")
            states.append(tuple(_fraction(x) for x in here))
        return states


def _extrapolated(field: Field, t: Fraction, y: list[Any], length: Fraction, columns: int) -> tuple[list[Any], float]:
    """The state after a step and the natural logarithm of its relative error."""
    row: list[list[Any]] = []
    error = 0.0
    for j in range(1, columns + 1):
        before, row = row, [_midpoint(field, t, y, length, 2 * j)]
        for k, coarse in enumerate(before, start=1):
            weight = ball(Fraction(j, j - k) ** 2 - 1)
            row.append([(a + (a - b) / weight).mid() for a, b in zip(row[-1], coarse, strict=True)])
    best, other = row[-1], row[-2]
    worst = max(
        float(abs(a - b).mid() / (abs(a) + abs(c) + flint.arb(2) ** -60))
        for a, b, c in zip(best, other, y, strict=True)
    )
    error = math.log(worst) if worst > 0 else -math.inf
    return best, error


def _midpoint(field: Field, t: Fraction, y: list[Any], length: Fraction, substeps: int) -> list[Any]:
    h = length / substeps
    step = ball(h)
    previous, here = y, [(x + step * f).mid() for x, f in zip(y, field(ball(t), tuple(y)), strict=True)]
    for i in range(1, substeps):
        rates = field(ball(t + i * h), tuple(here))
        previous, here = here, [(x + 2 * step * f).mid() for x, f in zip(previous, rates, strict=True)]
    return here

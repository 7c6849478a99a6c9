"""Motions by extrapolation of the linearly implicit Euler rule in high precision, for stiff equations.

It shares only the equations with collocation. 1, 2, 3, ... substeps are extrapolated in the substep; the order of a step
is the number of columns that it needs (Deuflhard, SIAM Review 27, 1985; Hairer and Wanner, Solving Ordinary Differential
Equations II, IV.9).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import flint
import numpy as np
from gnomon.reference.integration.collocation import (
    SMALLEST,
    Floats,
    Jacobian,
    TooLongError,
    component_sizes,
    first_step,
)
from gnomon.reference.numerics.balls import ball, precision
from gnomon.reference.numerics.taylor import Field, _fraction

GROW, SHRINK = 2.5, 0.25


def extrapolate_implicitly(
    field: Field, jacobian: Jacobian, state: Sequence[Fraction], times: Sequence[Fraction], digits: int, most_steps: int
) -> list[tuple[Fraction, ...]]:
    """States at increasing `times` from `state` at t = 0, each step's error about 10**-digits of the state.

    Raises TooLongError after `most_steps` steps, ArithmeticError where the steps become too short.
    """
    columns = digits + 8
    with precision(math.ceil((2 * digits + 15) * math.log2(10))):
        now, here, states, steps = Fraction(0), [ball(x) for x in state], [], 0
        span, largest = times[-1], np.array([abs(float(x)) for x in state])
        step = first_step(field, jacobian, here, span)
        for time in times:
            while now < time:
                length = min(step, time - now)
                if length < span * Fraction(SMALLEST):
                    raise ArithmeticError(
                        f"the steps of the extrapolation fall below {float(length):.1g} at t = {float(now):.6g}"
                    )
                there, error, used = _extrapolated(field, jacobian, now, here, length, columns, largest, digits)
                steps += 1
                if steps > most_steps:
                    raise TooLongError(
                        f"{steps} steps of extrapolation, the most that are taken, reach t = {float(now):.6g}"
                    )
                if there is None or not error <= 10.0**-digits:
                    step = length * Fraction(SHRINK)
                    continue
                now, here = now + length, there
                largest = np.maximum(largest, [abs(float(x)) for x in here])
                grown = length * Fraction(
                    GROW if used < columns - 10 else 1.5 if used < columns - 5 else 1.0 if used < columns - 2 else 0.7
                )
                step = max(step, grown) if length < step else grown
            states.append(tuple(_fraction(x) for x in here))
        return states


def _extrapolated(
    field: Field, jacobian: Jacobian, t: Fraction, y: list[Any], length: Fraction, columns: int, largest: Floats,
    digits: int,
) -> tuple[list[Any] | None, float, int]:  # fmt: skip
    """The state after a step, its relative error, and the columns that were used; None where it does not converge."""
    slope = jacobian(float(t), np.array([float(x) for x in y]))
    if not np.isfinite(slope).all():
        return None, math.inf, 0
    matrix = flint.arb_mat(slope.tolist())
    row: list[list[Any]] = []
    error = best = math.inf
    for j in range(1, columns + 1):
        start = _substeps(field, matrix, t, y, length, j)
        if start is None:
            return None, math.inf, j
        before, row = row, [start]
        for k, coarse in enumerate(before, start=1):
            weight = ball(Fraction(j, j - k) - 1)
            row.append([(a + (a - b) / weight).mid() for a, b in zip(row[-1], coarse, strict=True)])
        if j > 2:
            if not all(x.is_finite() for x in row[-1]):
                break
            sizes = component_sizes(row[-1], largest)
            # The difference along the diagonal too: on stiff equations two columns can agree by chance.
            error = max(_distance(row[-1], row[-2], sizes), _distance(row[-1], before[-1], sizes))
            if error <= 10.0**-digits:
                return row[-1], error, j
            if not math.isfinite(error) or (j > 6 and error > 1e3 * best):
                break
            best = min(best, error)
    return None, error, columns


def _distance(a: Sequence[Any], b: Sequence[Any], sizes: Floats) -> float:
    return float(np.max(np.array([abs(float((x - y).mid())) for x, y in zip(a, b, strict=True)]) / sizes))


def _substeps(field: Field, matrix: Any, t: Fraction, y: list[Any], length: Fraction, count: int) -> list[Any] | None:
    """`count` steps of the linearly implicit Euler rule y + (1 - h J)^-1 h f(t + h, y)."""
    h, dimension = length / count, len(y)
    step = ball(h)
    try:
        inverse = (
            flint.arb_mat([[int(i == k) for k in range(dimension)] for i in range(dimension)]) - matrix * step
        ).inv()
        for i in range(1, count + 1):
            rates = field(ball(t + i * h), tuple(y))
            change = inverse * flint.arb_mat([[flint.arb(f).mid() * step] for f in rates])
            y = [(x + change[k, 0]).mid() for k, x in enumerate(y)]
    except (ValueError, ZeroDivisionError):
        return None
    return y if all(x.is_finite() for x in y) else None

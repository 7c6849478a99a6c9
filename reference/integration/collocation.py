"""Motions by collocation in high precision, for stiff equations: the Radau IIA method of STAGES stages in balls.

Newton's method solves the stages. Its corrections are computed in binary64 from residuals in high precision, so that each
iteration adds digits until the residual is below the wanted error (Hairer and Wanner, Solving Ordinary Differential
Equations II, IV.8; the residual decides, so that an inexact Jacobian costs iterations, not digits).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import flint
import numpy as np
from gnomon.reference.numerics.balls import ball, precision
from gnomon.reference.numerics.taylor import Field, _fraction
from mpmath import mp, mpf
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Jacobian = Callable[[float, Floats], Floats]
"""(t, state) -> df/dy (dim, dim) in binary64."""
STAGES = 11
MOST_ITERATIONS = 25
GROW, SHRINK = 3.0, 0.2
SAFETY = 0.8
DEPTH = 1e-12
"""The least size of a component that has fallen, as a share of its largest."""
SMALLEST = 1e-40
"""Smallest step, as a share of the span."""


class TooLongError(ArithmeticError):
    """An integration takes more work than it may."""


@cache
def radau(stages: int, digits: int) -> tuple[list[Any], list[list[Any]]]:
    """The nodes and the matrix of the Radau IIA method, as numbers of mpmath with `digits` digits."""
    with mp.workdps(digits + 3 * stages):
        # c is a root of P_s - P_{s-1} on [0, 1]: the shifted Legendre polynomials.
        def legendre(n: int) -> list[Any]:
            return [mpf((-1) ** (n + k) * math.comb(n, k) * math.comb(n + k, k)) for k in range(n, -1, -1)]

        high, low = legendre(stages), [mpf(0), *legendre(stages - 1)]
        roots = mp.polyroots([a - b for a, b in zip(high, low, strict=True)], maxsteps=500, extraprec=400)
        nodes = sorted((mp.re(x) for x in roots), key=float)
        nodes[-1] = mpf(1)
        powers = mp.matrix([[c**k for k in range(stages)] for c in nodes])
        integrals = mp.matrix([[c ** (k + 1) / (k + 1) for k in range(stages)] for c in nodes])
        matrix = integrals * powers**-1
        return nodes, [[matrix[i, j] for j in range(stages)] for i in range(stages)]


class _Method:
    """The method for some equations: its coefficients in balls at the precision that holds, and in binary64."""

    def __init__(self, field: Field, jacobian: Jacobian, stages: int, wanted: int) -> None:
        self.field, self.jacobian, self.wanted, digits = field, jacobian, wanted, wanted + 30
        nodes, matrix = radau(stages, digits)
        self.nodes = [_ball(c) for c in nodes]
        self.matrix = flint.arb_mat([[_ball(x) for x in row] for row in matrix])
        self.plain = np.array([[float(x) for x in row] for row in matrix])
        with mp.workdps(digits + 3 * stages):
            values = mp.matrix([[mp.legendre(k, 2 * c - 1) for k in range(stages)] for c in nodes]) ** -1
        self.modes = flint.arb_mat([[_ball(values[i, j]) for j in range(stages)] for i in range(stages)])
        """From values at the nodes to Legendre coefficients: how fast they fall tells the error of a step."""


def _ball(x: Any) -> Any:
    return flint.arb(mp.nstr(x, 100))


def collocate(
    field: Field, jacobian: Jacobian, state: Sequence[Fraction], times: Sequence[Fraction], digits: int,
    most_steps: int, stages: int = STAGES,
) -> list[tuple[Fraction, ...]]:  # fmt: skip
    """States at increasing `times` from `state` at t = 0, each step's error about 10**-digits of the state.

    Raises TooLongError after `most_steps` steps, ArithmeticError where the steps become too short.
    """
    with precision(math.ceil((digits + 25) * math.log2(10))):
        method, now, here, states, steps = (
            _Method(field, jacobian, stages, digits),
            Fraction(0),
            [ball(x) for x in state],
            [],
            0,
        )
        span, largest = times[-1], np.array([abs(float(x)) for x in state])
        step = first_step(field, jacobian, here, span)
        guess: _Solved | None = None
        for time in times:
            while now < time:
                length = min(step, time - now)
                if length < span * Fraction(SMALLEST):
                    raise ArithmeticError(
                        f"the steps of the collocation fall below {float(length):.1g} at t = {float(now):.6g}"
                    )
                solved = _stages(method, now, here, length, largest, guess)
                steps += 1
                if steps > most_steps:
                    raise TooLongError(
                        f"{steps} steps of collocation, the most that are taken, reach t = {float(now):.6g}"
                    )
                if solved is None:
                    step, guess = length * Fraction(SHRINK), None
                    continue
                factor = SAFETY * (10.0**-digits / max(solved.error, 1e-300)) ** (1 / (1.5 * stages))
                if factor < SAFETY * 0.7:
                    step = length * Fraction(max(factor, SHRINK)).limit_denominator(1000)
                    continue
                now, here, guess = now + length, solved.end, solved
                largest = np.maximum(largest, [abs(float(x)) for x in here])
                grown = length * Fraction(min(factor, GROW)).limit_denominator(1000)
                step = max(step, grown) if length < step else grown
            states.append(tuple(_fraction(x) for x in here))
        return states


class _Solved:
    def __init__(self, start: list[Any], length: Fraction, rises: Any, error: float) -> None:
        self.start, self.length, self.rises, self.error = start, length, rises, error
        count = rises.nrows()
        self.end = [(y + rises[count - 1, j]).mid() for j, y in enumerate(start)]


def component_sizes(state: Sequence[Any], largest: Floats) -> Floats:
    """The sizes of the components by which errors are divided: of a component that falls, at least DEPTH of its largest.

    A component that has been zero so far gets the same share of the largest of all.
    """
    own = np.where(largest > 0, DEPTH * largest, DEPTH * DEPTH * max(float(np.max(largest)), 1e-200))
    return np.maximum(own, [abs(float(x.mid())) for x in map(flint.arb, state)])


def first_step(field: Field, jacobian: Jacobian, here: list[Any], span: Fraction) -> Fraction:
    """A step that resolves the fastest mode: a fast transient that no column sees would leave an error of its own."""
    rates = [abs(float(x)) for x in field(ball(Fraction(0)), tuple(here))]
    state = [float(x) for x in here]
    times = [abs(y) / r for y, r in zip(state, rates, strict=True) if r > 0 and y]
    slope = float(np.linalg.norm(jacobian(0.0, np.array(state)), 2))
    times += [10 / slope] if slope > 0 and math.isfinite(slope) else []
    return min(span / 100, Fraction(min(times, default=float(span)) / 100))


def _stages(
    method: _Method, t: Fraction, y: list[Any], length: Fraction, largest: Floats, before: _Solved | None
) -> _Solved | None:
    """The stages of a step; None if Newton's method does not converge."""
    stages, dimension, h = len(method.nodes), len(y), ball(length)
    now = ball(t)
    rises = _extrapolated(method, before, y, length) if before is not None else flint.arb_mat(stages, dimension)
    size = component_sizes(y, largest)
    last, factors = math.inf, None
    for iteration in range(MOST_ITERATIONS):
        places = [[y[j] + rises[i, j] for j in range(dimension)] for i in range(stages)]
        try:
            slopes = flint.arb_mat(
                [
                    [x.mid() for x in map(flint.arb, method.field(now + h * c, tuple(p)))]
                    for c, p in zip(method.nodes, places, strict=True)
                ]
            )
        except (ValueError, ZeroDivisionError):
            return None
        rising = np.abs([[_double(rises[i, j]) for j in range(dimension)] for i in range(stages)]).max(axis=0)
        size = np.maximum(component_sizes(places[-1], np.maximum(largest, rising)), 1e-3 * rising)
        residual = rises - method.matrix * slopes * h
        rest = np.array([[_double(residual[i, j]) for j in range(dimension)] for i in range(stages)]) / size
        worst = float(np.max(np.abs(rest)))
        if not math.isfinite(worst):
            return None
        if worst < 10.0 ** -(method.wanted + 3):
            modes = method.modes * slopes * h
            values = np.array([[_double(modes[i, j]) for j in range(dimension)] for i in range(stages)]) / size
            return _Solved(y, length, rises, _tail(values))
        if iteration > 3 and worst > 0.5 * last:
            return None
        if factors is None or worst > 1e-3 * last:
            slow = np.zeros((stages, dimension, stages, dimension))
            for k, p in enumerate(places):
                here = np.array([_double(x) for x in p])
                own = (
                    method.jacobian(float(t) + float(length) * float(method.nodes[k]), here)
                    * size[None, :]
                    / size[:, None]
                )
                slow[:, :, k, :] = float(length) * method.plain[:, k][:, None, None] * own[None]
            matrix = np.eye(stages * dimension) - slow.reshape(stages * dimension, -1)
            if not np.isfinite(matrix).all():
                return None
            factors = np.linalg.inv(matrix)
        last = worst
        change = (factors @ (rest / worst).ravel()).reshape(stages, dimension)
        if not np.isfinite(change).all():
            return None
        scale = flint.arb(worst)
        rises = flint.arb_mat(
            [
                [(rises[i, j] - scale * flint.arb(float(change[i, j] * size[j]))).mid() for j in range(dimension)]
                for i in range(stages)
            ]
        )
    return None


def _tail(modes: Floats) -> float:
    """The error of a step over the sizes of the state, from the last Legendre coefficients of its slopes.

    The stages have the order of the last coefficient, the end of a step about twice as many: the geometric mean of both.
    """
    high, low = np.max(np.abs(modes[-2:]), axis=0), np.max(np.abs(modes), axis=0)
    share = np.divide(high, low, out=np.zeros_like(high), where=low > 0)
    return float(np.max(high * np.sqrt(np.minimum(share, 1.0))))


def _double(x: Any) -> float:
    return float(x.mid()) if isinstance(x, flint.arb) else float(x)


def _extrapolated(method: _Method, before: _Solved, y: list[Any], length: Fraction) -> Any:
    """The polynomial of the step before, continued over this step: a first guess, in binary64."""
    stages, dimension = len(method.nodes), len(y)
    c = np.array([0.0, *(float(x) for x in method.nodes)])
    values = np.vstack(
        [np.zeros(dimension), [[_double(before.rises[i, j]) for j in range(dimension)] for i in range(stages)]]
    )
    ratio = float(length / before.length)
    at = 1 + ratio * c[1:]
    degree = min(stages, 5) if ratio > 1 else stages
    fit = np.polynomial.chebyshev.chebfit(2 * c - 1, values, degree)
    guess = np.polynomial.chebyshev.chebval(2 * at - 1, fit).T.reshape(stages, dimension) - values[-1]
    return flint.arb_mat([[flint.arb(float(x)) for x in row] for row in guess])

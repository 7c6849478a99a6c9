"""The fast Gauss method: eight stages in the eight lanes of one vector, steps from the tolerance."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from gnomon.cases.core.forms import FirstOrder, SecondOrder, first_order
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Solution, Solver, Tolerance
from gnomon.harness.integrators.base.fixed_step import DIGITS, Table, kept, rounded
from gnomon.harness.integrators.base.step_control import check_tolerance
from gnomon.harness.integrators.base.stepping import blank
from gnomon.harness.integrators.gauss import gauss, gauss_fast_constants, gauss_fast_kernel, radau
from gnomon.harness.integrators.gauss.gauss import integrals, lagrange, nodes, rounding_residuals
from gnomon.harness.integrators.gauss.gauss_fast_constants import SCRATCH, SCRATCH_ROWS, TUNING
from gnomon.harness.integrators.gauss.gauss_fast_layout import layout
from gnomon.reference.numerics.precision import nearest_double, working
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LEAST_TOLERANCE = 1e-16

FINEST_SHARE = 1e-14
"""Share of the largest component: where the finest absolute tolerance of Radau IIA 5 is above it, Radau is not used."""

REASONS = {
    gauss_fast_constants.NOT_FINITE: "the equations gave a value that is not finite",
    gauss_fast_constants.STEP_TOO_SMALL: "the step size fell below the spacing of times",
    gauss_fast_constants.TOO_MANY_STEPS: f"more than {gauss_fast_constants.MOST_STEPS} steps",
    gauss_fast_constants.STIFF: "the equations are stiff, and Radau IIA 5 stops too or has too coarse a tolerance",
    gauss_fast_constants.OUT_OF_RANGE: "the largest component of the start is not between "
    f"{gauss_fast_constants.SMALLEST:g} and {gauss_fast_constants.LARGEST:g}; choose other units",
}


class GaussFast(Integrator):
    """Gauss-Legendre collocation with 8 stages in SIMD lanes, adaptive. Order 16.

    Kuntzmann 1961; Butcher, Mathematics of Computation 18, 1964. Stages by fixed-point iteration from the last step's
    polynomial (Hairer, Lubich, Wanner, Geometric Numerical Integration, VIII.6), accelerated by the equations'
    derivatives where these are few and the equations expensive, many components in groups (Gauss-Seidel). The error is
    estimated from the decay of the stage polynomial; steps stay equal, or follow the frequency of the motion, as long as
    it allows. Sums are compensated. Samples are separate steps within a step, of the same order.

    A trajectory whose steps are limited by convergence, while it moves slowly, is stiff: Radau IIA 5 integrates it, to
    the same tolerance.

    Tolerances above 1e-4 are replaced by 1e-4. At 1e-16 only round-off is left, and the error of energy grows as t^(1/2)
    (Brouwer's law).

    Ensembles: each vector holds eight trajectories with common steps, on all cores, as accurate as one by one.
    """

    name, order = "Gauss 8-stage SIMD", 16
    accepts = (FirstOrder, SecondOrder)
    sampling = "dense output"
    sweep = Tolerance(TUNING.loosest, LEAST_TOLERANCE)

    def prepare(self, problem: Problem, setting: float) -> Solver:
        check_tolerance(setting, LEAST_TOLERANCE)
        problem = problem.since_start()
        setting, form = min(setting, TUNING.loosest), problem.form
        assert isinstance(form, FirstOrder | SecondOrder)
        form = form.source if isinstance(form, FirstOrder) and form.source is not None else form
        arguments = (form, len(problem.parameters), problem.dimension)
        run = gauss_fast_kernel.compiled(*arguments)
        coefficients = table(layout(*arguments).second_order, bandwidth(setting))
        buffer, times = problem.buffer, problem.times

        def solve(initial: Floats) -> Solution:
            out = blank(problem, initial)
            stop = np.zeros(4, dtype=np.int64)
            if len(initial) >= TUNING.ensemble:
                return together(initial, out, stop)
            taken = alone(initial, out, stop) if len(initial) == 1 else one_by_one(initial, out, stop, 0)
            return Solution(out, taken, reason(stop))

        def alone(initial: Floats, out: Floats, stop: NDArray[np.int64]) -> int:
            taken = run(buffer, coefficients, initial, times, setting, out, stop)
            buffer[-1] += problem.counted * stop[3]
            if stop[0] == gauss_fast_constants.STIFF:
                instead = stiffly(problem, setting, initial)
                if instead is not None:
                    taken, out[:], stop[0] = taken + (instead.steps or 0), instead.states, 0
            return taken

        def one_by_one(initial: Floats, out: Floats, stop: NDArray[np.int64], first: int) -> int:
            taken = 0
            for i in range(len(initial)):
                one, end = slice(i, i + 1), np.zeros(4, dtype=np.int64)
                taken += alone(initial[one], out[one], end)
                if end[0] and not stop[0]:
                    stop[:3] = end[0], first + i, end[2]
            return taken

        @cache
        def compiled_ensemble() -> tuple[Callable[..., int], int]:
            return gauss_fast_kernel.compiled_ensemble(*arguments)

        def together(initial: Floats, out: Floats, stop: NDArray[np.int64]) -> Solution:
            eight, rows = compiled_ensemble()

            def part(first: int) -> tuple[int, int, list[int]]:
                here = slice(first, first + TUNING.chunk)
                left_over = np.zeros(TUNING.chunk // 8 + 1, dtype=np.int64)
                taken = eight(buffer, coefficients, initial[here], times, setting, out[here], left_over, lines(rows))
                return taken, int(left_over[-1]), [first + 8 * int(i) for i in np.flatnonzero(left_over[:-1])]

            with ThreadPoolExecutor(os.cpu_count() or 1) as threads:
                parts = threads.map(part, range(0, len(initial), TUNING.chunk))
                accepted, evaluations, left = zip(*parts, strict=True)
            steps = sum(accepted)
            buffer[-1] += problem.counted * sum(evaluations)
            for first in (first for firsts in left for first in firsts):
                steps += one_by_one(initial[first : first + 8], out[first : first + 8], stop, first)
            return Solution(out, int(steps), reason(stop))

        return Solver(solve)


def stiffly(problem: Problem, tolerance: float, initial: Floats) -> Solution | None:
    """One trajectory by Radau IIA 5, whose tolerance is absolute below 1; None where that stops too or is too coarse."""
    form = first_order(problem.form)  # type: ignore[arg-type]
    problem, finest = replace(problem, form=form), 1e-16  # type: ignore[arg-type]
    try:
        found = radau.prepared(problem, max(tolerance, finest), 0.0)(initial)
        # Which components stay small is known only from this solution.
        sizes = np.max(np.abs(found.states[0]), axis=0)
        if max(tolerance, FINEST_SHARE) * np.max(sizes) < finest:
            return None
        smallest = np.min(sizes[sizes > 0], initial=1.0)
        if smallest < 1 and found.stopped is None:
            found = radau.prepared(problem, max(tolerance * smallest, finest), 0.0)(initial)
    except Refused:
        return None
    return found if found.stopped is None else None


@cache
def table(second_order: bool, width: float = 0.0) -> Floats:
    """The coefficients as the kernel takes them, rounded once from high precision; each row is one cache line.

    `width`: the bandwidth of the slopes for which first guesses are made, in radians a step.

    They take .06 s and are kept on disk, under a key of the sources that compute them.
    """

    def build() -> Floats:
        with working(DIGITS) as mp:
            return rounded(rows(mp, second_order, width))

    found = kept(f"Gauss SIMD, second order: {second_order}, {width:g}", (__name__, gauss.__name__), build)
    whole = lines(SCRATCH + SCRATCH_ROWS)
    whole[: len(found)] = found
    return whole


def lines(count: int) -> Floats:
    """Zeros (count, 8), each row of which is one line of the processor's cache."""
    space = np.zeros(8 * count + 8)
    return space[-space.ctypes.data % 64 // 8 :][: 8 * count].reshape(count, 8)


def rows(mp: Any, second_order: bool, width: float) -> Table:
    """Rows of the kernel's table, eight numbers each, in the sequence of `gauss_fast_constants`."""
    c = nodes(mp, 8)
    s = range(8)
    once, b = [integrals(mp, c, node) for node in c], integrals(mp, c, mp.mpf(1))
    a, ahead = once, extrapolation_weights(mp, c, width)
    if second_order:
        a = [[mp.fsum(a[j][m] * a[m][k] for m in s) for k in s] for j in s]
    a, once = ([summing(mp, row) for row in matrix] for matrix in (a, once))
    # The stage polynomial about its end, where c = 1 + x, from its values at small x: exact, it has degree 7.
    points = [mp.mpf(k - 4) / 8 for k in s]
    few = [mp.nint(node * 2**24) / 2**24 for node in c]
    positions = [b[j] * (1 - c[j]) for j in s]
    vandermonde = mp.matrix([[x**k for k in s] for x in points])
    monomials = vandermonde**-1 * mp.matrix(lagrange(mp, c, [1 + x for x in points]))
    legendre = [[(2 * n + 1) * b[j] * mp.legendre(n, 2 * c[j] - 1) for j in s] for n in s]
    return [
        *([a[j][k] for j in s] for k in s),
        *([monomials[j, k] for j in s] for k in s),
        *([node**k for node in c] for k in s),
        c,
        b,
        positions,
        *([ahead[j][k] for j in s] for k in s),
        *([once[j][k] for j in s] for k in s),
        *([mp.fsum(m[j][i] * ahead[i][k] for i in s) for j in s] for m in (a, once) for k in s),
        few,
        [node - high for node, high in zip(c, few, strict=True)],
        *(rounding_residuals(mp, row, mp.mpf(2) ** -52) for row in (b, positions)),
        *([mp.fsum(m[j][i] * c[i] ** k for i in s) for j in s] for m in (a, once) for k in s),
        lagrange(mp, c, [mp.mpf(1)])[0],
        *([legendre[n][j] for n in s] for j in s),
        *legendre[4:],
    ]


def bandwidth(tolerance: float) -> float:
    """The assumed bandwidth of the slopes, in radians a step, of steps that err by this tolerance."""
    width = TUNING.usual_width * float((tolerance / 1e-6) ** TUNING.width_exponent)
    return round(min(TUNING.most_width, width), 1)


def extrapolation_weights(mp: Any, c: list[Any], width: float) -> list[list[Any]]:
    """Weights of a function's values at the nodes `c` in its values at 1 + c: a matrix (8, 8).

    The best linear estimate for random functions whose frequencies have a normal distribution of this width (Rasmussen,
    Williams, Gaussian Processes for Machine Learning, 2006, 2.2), which tends to the interpolating polynomial as the width
    goes to 0. Over a long step a polynomial that is continued is worse than no guess.
    """
    if width == 0:
        return lagrange(mp, c, [1 + node for node in c])
    near, ahead = (
        mp.matrix([[mp.exp(-((width * (there + x - y)) ** 2) / 2) for y in c] for x in c]) for there in (0, 1)
    )
    found: list[list[Any]] = (ahead * near**-1).tolist()
    return found


def summing(mp: Any, row: Sequence[Any]) -> list[Any]:
    """A row rounded to binary64 so that its sum is not: each number is corrected by the residuals of the larger ones."""
    found, left = list(row), mp.mpf(0)
    for k in sorted(range(len(row)), key=lambda k: -abs(row[k])):
        found[k] = mp.mpf(nearest_double(row[k] + left))
        left += row[k] - found[k]
    return found


def reason(stop: NDArray[np.int64]) -> str | None:
    """Why a trajectory ended early, as a sentence; None where it did not."""
    if stop[0] == 0:
        return None
    what = f"{REASONS[int(stop[0])]}, before sample {stop[2] + 1}"
    return what + (f" of trajectory {stop[1] + 1}" if stop[1] else "")


INTEGRATORS: tuple[type[Integrator], ...] = (GaussFast,)

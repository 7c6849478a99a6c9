"""The fast Gauss method: eight stages in the eight lanes of one vector, with steps chosen from the tolerance."""

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
from gnomon.harness.integrators.base.fixed_step import DIGITS, Table, keep_table, round_table
from gnomon.harness.integrators.base.step_control import check_tolerance
from gnomon.harness.integrators.base.stepping import blank
from gnomon.harness.integrators.gauss import constants, gauss, gauss_fast_kernel, radau
from gnomon.harness.integrators.gauss.constants import SCRATCH, SCRATCH_ROWS, TUNING
from gnomon.harness.integrators.gauss.gauss import integrals, lagrange, nodes, rounding_residuals
from gnomon.harness.integrators.gauss.gauss_fast_layout import layout
from gnomon.reference.numerics.precision import nearest_double, working
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LEAST_TOLERANCE = 1e-16

FINEST_SHARE = 1e-14
"""Radau IIA 5 is not used if its finest absolute tolerance, as a share of the largest component, is above this number
and above the tolerance."""

REASONS = {
    constants.NOT_FINITE: "the equations gave a value that is not finite",
    constants.STEP_TOO_SMALL: "the step size fell below the spacing of times",
    constants.TOO_MANY_STEPS: f"more than {constants.MOST_STEPS} steps",
    constants.STIFF: "the equations are stiff, and Radau IIA 5 stops too or has too coarse a tolerance",
    constants.OUT_OF_RANGE: "the largest component of the start is not between "
    f"{constants.SMALLEST:g} and {constants.LARGEST:g}; choose other units",
}


class GaussFast(Integrator):
    """Gauss-Legendre collocation with 8 stages in SIMD lanes, adaptive. Order 16.

    Kuntzmann 1961; Butcher, Mathematics of Computation 18, 1964. The stages are solved by fixed-point iteration, which
    starts from the last step's polynomial (Hairer, Lubich, Wanner, Geometric Numerical Integration, VIII.6). For
    expensive equations with few components, their derivatives accelerate it; many components are iterated in groups
    (Gauss-Seidel). The error is estimated from the decay of the coefficients of the stage polynomial. Steps stay equal,
    or follow the frequency of the motion, as long as the error allows it. Sums are compensated. A sample is a separate
    step from the start of the step in which it lies, of the same order.

    A trajectory is stiff if it moves slowly while convergence limits its steps. Radau IIA 5 then integrates it, to the
    same tolerance.

    Tolerances above 1e-4 are replaced by 1e-4. At 1e-16 only round-off is left, and the error of energy grows as
    t^(1/2) (Brouwer's law).

    In an ensemble each vector holds eight trajectories with common steps, and all cores are used. Each trajectory is as
    accurate as one that is integrated alone.
    """

    name, order = "Gauss 8-stage SIMD", 16
    accepts = (FirstOrder, SecondOrder)
    sampling = "dense output"
    sweep = Tolerance(constants.LOOSEST, LEAST_TOLERANCE)

    def prepare(self, problem: Problem, setting: float) -> Solver:
        check_tolerance(setting, LEAST_TOLERANCE)
        problem = problem.since_start()
        setting, form = min(setting, constants.LOOSEST), problem.form
        assert isinstance(form, FirstOrder | SecondOrder)
        form = form.source if isinstance(form, FirstOrder) and form.source is not None else form
        arguments = (form, len(problem.parameters), problem.dimension)
        run = gauss_fast_kernel.compile_advance(*arguments)
        coefficients = table(layout(*arguments).second_order, bandwidth(setting))
        buffer, times = problem.buffer, problem.times

        def solve(initial: Floats) -> Solution:
            out = blank(problem, initial)
            stop = np.zeros(4, dtype=np.int64)
            if len(initial) >= constants.ENSEMBLE:
                return together(initial, out, stop)
            taken = alone(initial, out, stop) if len(initial) == 1 else one_by_one(initial, out, stop, 0)
            return Solution(out, taken, reason(stop))

        def alone(initial: Floats, out: Floats, stop: NDArray[np.int64]) -> int:
            taken = run(buffer, coefficients, initial[0], times, setting, out[0], stop)
            buffer[-1] += problem.counted * stop[3]
            if stop[0] == constants.STIFF:
                instead = stiffly(problem, setting, initial)
                if instead is not None:
                    taken, out[:], stop[0] = taken + (instead.steps or 0), instead.states, 0
            return taken

        def one_by_one(initial: Floats, out: Floats, stop: NDArray[np.int64], first: int) -> int:
            taken = 0
            for i in range(len(initial)):
                end = np.zeros(4, dtype=np.int64)
                taken += alone(initial[i : i + 1], out[i : i + 1], end)
                if end[0] and not stop[0]:
                    stop[:3] = end[0], first + i, end[2]
            return taken

        @cache
        def compiled_ensemble() -> tuple[Callable[..., int], int]:
            return gauss_fast_kernel.compile_ensemble(*arguments)

        def together(initial: Floats, out: Floats, stop: NDArray[np.int64]) -> Solution:
            eight, rows = compiled_ensemble()

            def part(first: int) -> tuple[int, int, list[int]]:
                here = slice(first, first + constants.CHUNK)
                left_over = np.zeros(constants.CHUNK // 8 + 1, dtype=np.int64)
                taken = eight(buffer, coefficients, initial[here], times, setting, out[here], left_over, lines(rows))
                return taken, int(left_over[-1]), [first + 8 * int(i) for i in np.flatnonzero(left_over[:-1])]

            with ThreadPoolExecutor(os.cpu_count() or 1) as threads:
                parts = threads.map(part, range(0, len(initial), constants.CHUNK))
                accepted, evaluations, left = zip(*parts, strict=True)
            steps = sum(accepted)
            buffer[-1] += problem.counted * sum(evaluations)
            for first in (first for firsts in left for first in firsts):
                steps += one_by_one(initial[first : first + 8], out[first : first + 8], stop, first)
            return Solution(out, int(steps), reason(stop))

        return Solver(solve)


def stiffly(problem: Problem, tolerance: float, initial: Floats) -> Solution | None:
    """Integrate one trajectory by Radau IIA 5, whose tolerance is absolute for components below 1.

    Gives None if Radau IIA 5 stops too or is too coarse.
    """
    form = first_order(problem.form)  # type: ignore[arg-type]
    problem, finest = replace(problem, form=form), 1e-16  # type: ignore[arg-type]
    try:
        solution = radau.prepare_solver(problem, max(tolerance, finest), 0.0)(initial)
        # Only this solution shows which components stay small.
        sizes = np.max(np.abs(solution.states[0]), axis=0)
        if max(tolerance, FINEST_SHARE) * np.max(sizes) < finest:
            return None
        smallest = np.min(sizes[sizes > 0], initial=1.0)
        if smallest < 1 and solution.stopped is None:
            solution = radau.prepare_solver(problem, max(tolerance * smallest, finest), 0.0)(initial)
    except Refused:
        return None
    return solution if solution.stopped is None else None


@cache
def table(second_order: bool, width: float = 0.0) -> Floats:
    """The coefficients of the kernel, rounded once from high precision; each row is one cache line.

    `width`: the bandwidth of the slopes for which first guesses are made, in radians a step.

    The coefficients take .06 s to compute and are kept on disk, under a key of the sources that compute them.
    """

    def build() -> Floats:
        with working(DIGITS) as mp:
            return round_table(rows(mp, second_order, width))

    coefficients = keep_table(f"Gauss SIMD, second order: {second_order}, {width:g}", (__name__, gauss.__name__), build)
    whole = lines(SCRATCH + SCRATCH_ROWS)
    whole[: len(coefficients)] = coefficients
    return whole


def lines(count: int) -> Floats:
    """An array (count, 8) of zeros in which each row is one line of the processor's cache."""
    space = np.zeros(8 * count + 8)
    return space[-space.ctypes.data % 64 // 8 :][: 8 * count].reshape(count, 8)


def rows(mp: Any, second_order: bool, width: float) -> Table:
    """Rows of the kernel's table, eight numbers each, in the sequence of `constants`."""
    c = nodes(mp, 8)
    s = range(8)
    once, b = [integrals(mp, c, node) for node in c], integrals(mp, c, mp.mpf(1))
    a, ahead = once, extrapolation_weights(mp, c, width)
    if second_order:
        a = [[mp.fsum(a[j][m] * a[m][k] for m in s) for k in s] for j in s]
    a, once = ([summing(mp, row) for row in matrix] for matrix in (a, once))
    # Monomials of the stage polynomial in x = c - 1, from its values at eight small x: exact, as its degree is 7.
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
    """The assumed bandwidth of the slopes, in radians a step, for steps whose error equals the tolerance."""
    width = TUNING.usual_width * float((tolerance / 1e-6) ** TUNING.width_exponent)
    return round(min(TUNING.most_width, width), 1)


def extrapolation_weights(mp: Any, c: list[Any], width: float) -> list[list[Any]]:
    """The matrix (8, 8) that extrapolates a function from its values at the nodes `c` to its values at 1 + c.

    It is the best linear estimate for random functions whose frequencies have a normal distribution of this width
    (Rasmussen, Williams, Gaussian Processes for Machine Learning, 2006, 2.2). It tends to the interpolating polynomial
    as the width goes to 0. Over a long step an extrapolated polynomial is worse than no guess.
    """
    if width == 0:
        return lagrange(mp, c, [1 + node for node in c])
    near, ahead = (
        mp.matrix([[mp.exp(-((width * (there + x - y)) ** 2) / 2) for y in c] for x in c]) for there in (0, 1)
    )
    weights: list[list[Any]] = (ahead * near**-1).tolist()
    return weights


def summing(mp: Any, row: Sequence[Any]) -> list[Any]:
    """Round a row to binary64 but keep its sum: to each number the residuals of the larger numbers are added first."""
    rounded, left = list(row), mp.mpf(0)
    for k in sorted(range(len(row)), key=lambda k: -abs(row[k])):
        rounded[k] = mp.mpf(nearest_double(row[k] + left))
        left += row[k] - rounded[k]
    return rounded


def reason(stop: NDArray[np.int64]) -> str | None:
    """The reason for the early end of a trajectory, as a sentence; None if it reached the last sample."""
    if stop[0] == 0:
        return None
    what = f"{REASONS[int(stop[0])]}, before sample {stop[2] + 1}"
    return what + (f" of trajectory {stop[1] + 1}" if stop[1] else "")


INTEGRATORS: tuple[type[Integrator], ...] = (GaussFast,)

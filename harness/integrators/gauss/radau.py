"""Radau IIA of order 5 for stiff equations, after RADAU5."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Solution, Solve, Tolerance
from gnomon.harness.integrators.base.fixed_step import Table
from gnomon.harness.integrators.base.step_control import tabulated
from gnomon.harness.integrators.base.stepping import blank, compiled_whole
from gnomon.harness.integrators.gauss.gauss import integrals
from gnomon.harness.integrators.gauss.radau_steps import (
    INLINED,
    MOST_STEPS,
    NOT_FINITE,
    NOT_SOLVED,
    SIGNATURE,
    STEP_TOO_SMALL,
    TOO_MANY_STEPS,
    integrate,
)
from gnomon.harness.kernels.equations import right_hand_side
from gnomon.harness.kernels.straight_line import compiled, jacobian_text
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LEAST_TOLERANCE = 1e-14
"""Newton's iteration must converge to a fraction of the tolerance, and that lies above round-off."""

REASONS = {
    NOT_FINITE: "the equations gave a value that is not finite",
    STEP_TOO_SMALL: "the step size fell below the spacing of times",
    NOT_SOLVED: "the stages of a step did not converge",
    TOO_MANY_STEPS: f"more than {MOST_STEPS} steps (too small a tolerance for so long a span)",
}


class Radau5(Integrator):
    """Radau IIA with three stages for stiff equations, adaptive. Order 5.

    Hairer and Wanner, Solving Ordinary Differential Equations II, 1996, IV.8 (RADAU5): simplified Newton iteration on the
    transformed system, the exact Jacobian (differentiated from the equations), Gustafsson's predictive step control, the
    embedded estimate of order 3 with the tolerance 0.1 tol^(2/3). Samples are values of the collocation polynomial, or
    separate steps where stiffness makes the polynomial less accurate than the steps. Sums are compensated. Evaluations of
    the Jacobian are not counted as right-hand sides. The error of each component is relative to the largest size so far of
    its group (see `sizes`); with `absolute`, to 1 + |y| in SI units.
    """

    name, order = "Radau IIA 5", 5
    accepts = (FirstOrder,)
    sampling = "dense output"
    sweep = Tolerance(1e-2, 1e-13)
    absolute: ClassVar[bool] = False

    def prepare(self, problem: Problem, setting: float) -> Solve:
        if not (math.isfinite(setting) and LEAST_TOLERANCE <= setting < 1):
            raise Refused(f"tolerance {setting} is not between {LEAST_TOLERANCE:g} and 1")
        return prepared(problem, 0.1 * setting ** (2 / 3), 0.0, self.absolute)


def prepared(problem: Problem, tolerance: float, fixed: float, absolute: bool = True) -> Solve:
    """`solve` with error control at `tolerance`, or with steps of `fixed` where that is > 0. `absolute`: errors are
    relative to 1 + |y|. Raises Refused where the equations cannot be differentiated."""
    assert isinstance(problem.form, FirstOrder)
    try:
        text = jacobian_text(problem.form, problem.dimension, len(problem.parameters))
    except ValueError as error:
        raise Refused(str(error)) from None
    derivative, kernel = compiled(text), right_hand_side(problem)
    run = compiled_whole(integrate, SIGNATURE, (("DIMENSION", problem.dimension), ("ABSOLUTE", int(absolute))), INLINED)
    address, buffer, times, scale = kernel.address, problem.buffer, problem.times, problem.time_scale
    coefficients, groups = table(), problem.grouping

    def solve(initial: Floats) -> Solution:
        out = blank(problem, initial)
        stop = np.zeros(2, dtype=np.int64)
        steps = run(
            address, derivative, buffer, coefficients, initial, times, tolerance, fixed, groups, scale, out, stop
        )
        stopped = f"{REASONS[int(stop[0])]}, before sample {stop[1] + 1}" if stop[0] else None
        return Solution(out, int(steps), stopped)

    return solve


@cache
def table() -> Floats:
    return tabulated(rows)


def nodes(mp: Any) -> list[Any]:
    """The zeros of the shifted Radau polynomial of degree 3."""
    root = mp.sqrt(mp.mpf(6))
    return [(4 - root) / 10, (4 + root) / 10, mp.mpf(1)]


def rows(mp: Any) -> Table:
    """c; gamma, alpha, beta; T; its inverse; weights of the stages in the error estimate; leading coefficients of the
    basis polynomials over x.

    The inverse of the Runge-Kutta matrix is T diag(gamma, ((alpha, -beta), (beta, alpha))) T^-1.
    """
    c = nodes(mp)
    matrix = inverse([integrals(mp, c, node) for node in c])
    three = mp.mpf(3) ** (mp.mpf(1) / 3)
    nine = three * three
    # The zeros of s^3 - 9 s^2 + 36 s - 60, the characteristic polynomial of that inverse; cube roots of 3 and 9.
    gamma = 3 + nine - three
    real, imaginary = 3 + (three - nine) / 2, mp.sqrt(mp.mpf(3)) / 2 * (three + nine)
    columns = [eigenvector(matrix, gamma, mp.mpf(0))[0], *eigenvector(matrix, real, -imaginary)]
    t = [list(row) for row in zip(*columns, strict=True)]
    root = mp.sqrt(mp.mpf(6))
    error = [-(13 + 7 * root) / 3, (7 * root - 13) / 3, -mp.mpf(1) / 3]
    lagrange = [1 / (c[k] * (c[k] - c[k - 1]) * (c[k] - c[k - 2])) for k in range(3)]
    return [c, [gamma, real, imaginary], *t, *inverse(t), error, lagrange]


def inverse(m: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """The inverse of a 3 x 3 matrix: cross products of its rows over the determinant."""
    first, second, third = m
    crossed = [cross(second, third), cross(third, first), cross(first, second)]
    determinant = sum(a * b for a, b in zip(first, crossed[0], strict=True))
    return [[crossed[j][i] / determinant for j in range(3)] for i in range(3)]


def cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def eigenvector(m: Sequence[Sequence[Any]], real: Any, imaginary: Any) -> tuple[list[Any], list[Any]]:
    """Real and imaginary part of the eigenvector for an eigenvalue of `m`, scaled so that its last component is 1.

    It is normal to the first two rows of m minus the eigenvalue: their cross product.
    """
    a, d = m[0][0] - real, m[1][1] - real
    crossed = [
        (m[0][1] * m[1][2] - m[0][2] * d, imaginary * m[0][2]),
        (m[0][2] * m[1][0] - m[1][2] * a, imaginary * m[1][2]),
        (a * d - imaginary * imaginary - m[0][1] * m[1][0], -imaginary * (a + d)),
    ]
    u, v = crossed[2]
    size = u * u + v * v
    return [(x * u + y * v) / size for x, y in crossed], [(y * u - x * v) / size for x, y in crossed]


INTEGRATORS: tuple[type[Integrator], ...] = (Radau5,)

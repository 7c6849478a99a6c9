"""Radau IIA of order 5 for stiff equations, after RADAU5."""

from collections.abc import Sequence
from functools import cache
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solver, Tolerance
from gnomon.harness.integrators.base import tableau
from gnomon.harness.integrators.base.fixed_step import DIGITS, Table, keep_table, round_table
from gnomon.harness.integrators.base.step_control import check_tolerance, limits_of, solving
from gnomon.harness.integrators.base.stepping import compile_whole
from gnomon.harness.integrators.base.tableau import ButcherTableau
from gnomon.harness.integrators.gauss import gauss
from gnomon.harness.integrators.gauss.radau_steps import INLINED, SIGNATURE, integrate
from gnomon.harness.kernels.equations import right_hand_side
from gnomon.harness.kernels.straight_line import derivatives_kernel
from gnomon.reference.numerics.precision import working
from numpy.typing import NDArray

MOST_STEPS = 1_000_000
LEAST_TOLERANCE = 1e-14
"""Newton's iteration must converge to a fraction of the tolerance, and this fraction must lie above round-off."""


class Radau5(Integrator):
    """Radau IIA with three stages for stiff equations, adaptive. Order 5.

    Hairer and Wanner, Solving Ordinary Differential Equations II, 1996, IV.8 (RADAU5): simplified Newton iteration on
    the transformed system, the exact Jacobian (differentiated from the equations), Gustafsson's predictive step
    control, the embedded estimate of order 3 with the tolerance 0.1 tol^(2/3). Samples are values of the collocation
    polynomial, or separate steps if stiffness makes the polynomial less accurate than the steps. Sums are
    compensated. Evaluations of the Jacobian are not counted as right-hand sides. The error of each component is
    relative to the largest size that its group has had (see `sizes`); with `absolute`, to 1 + |y| in SI units.
    """

    name, order = "Radau IIA 5", 5
    accepts = (FirstOrder,)
    sampling = "dense output"
    sweep = Tolerance(1e-2, 1e-13)
    takes = ("max_step", "first_step")
    absolute: ClassVar[bool] = False

    def prepare(self, problem: Problem, setting: float) -> Solver:
        check_tolerance(setting, LEAST_TOLERANCE)
        return prepare_solver(problem, 0.1 * setting ** (2 / 3), 0.0, self.absolute, limits_of(self, problem))

    @classmethod
    def tableau(cls, mp: Any) -> ButcherTableau:
        """Collocation at the zeros of the shifted Radau polynomial of degree 3."""
        root = mp.sqrt(mp.mpf(6))
        return gauss.collocation(mp, [(4 - root) / 10, (4 + root) / 10, mp.mpf(1)], 5)


def prepare_solver(
    problem: Problem, tolerance: float, fixed: float, absolute: bool = True, limits: Floats | None = None
) -> Solver:
    """A solver with error control at `tolerance`, or with steps of the size `fixed` if that is > 0.

    `absolute`: errors are relative to 1 + |y|. `limits`: see `step_control`; None: no limit. Raises Refused if the equations cannot be differentiated.
    """
    problem = problem.since_start()
    assert isinstance(problem.form, FirstOrder)
    try:
        derivative = derivatives_kernel(problem.form, problem.dimension, len(problem.parameters)).address
    except ValueError as error:
        raise Refused(str(error)) from None
    kernel = right_hand_side(problem)
    constants = ("DIMENSION", problem.dimension), ("ABSOLUTE", int(absolute)), ("MOST_STEPS", MOST_STEPS)
    run = compile_whole(integrate, SIGNATURE, constants, INLINED)
    address, buffer, times = kernel.address, problem.buffer, problem.times
    if limits is None:
        limits = np.array([problem.time_scale, np.inf, 0.0])
    coefficients, groups = table(), problem.grouping

    def loop(initial: Floats, out: Floats, stop: NDArray[np.int64]) -> int:
        return run(
            address, derivative, buffer, coefficients, initial, times, tolerance, fixed, groups, limits, out, stop
        )

    return solving(problem, loop, MOST_STEPS)


@cache
def table() -> Floats:
    def build() -> Floats:
        with working(DIGITS) as mp:
            return round_table(rows(mp))

    return keep_table("Radau IIA 5", (__name__, gauss.__name__, tableau.__name__), build)


def rows(mp: Any) -> Table:
    """The rows of the table.

    They are c; gamma, alpha, beta; T; its inverse; weights of the stages in the error estimate; leading coefficients of
    the basis polynomials over x.

    The inverse of the Runge-Kutta matrix is T diag(gamma, ((alpha, -beta), (beta, alpha))) T^-1.
    """
    c = [row[0] for row in Radau5.tableau(mp).rows(mp)[:3]]
    three = mp.cbrt(3)
    nine = three * three
    # The zeros of s^3 - 9 s^2 + 36 s - 60, the characteristic polynomial of the inverse; cube roots of 3 and 9.
    gamma = 3 + nine - three
    alpha, beta = 3 + (three - nine) / 2, mp.sqrt(3) / 2 * (three + nine)
    real, pair = eigenvector(c, gamma), eigenvector(c, mp.mpc(alpha, -beta))
    t = [[u, v.real, v.imag] for u, v in zip(real, pair, strict=True)]
    root = mp.sqrt(6)
    error = [-(13 + 7 * root) / 3, (7 * root - 13) / 3, -mp.mpf(1) / 3]
    lagrange = [1 / (c[k] * (c[k] - c[k - 1]) * (c[k] - c[k - 2])) for k in range(3)]
    return [c, [gamma, alpha, beta], *t, *(mp.matrix(t) ** -1).tolist(), error, lagrange]


def eigenvector(c: Sequence[Any], s: Any) -> list[Any]:
    """The eigenvector of the inverse of the Runge-Kutta matrix for the eigenvalue s, scaled to a last component of 1.

    With M the product of x - c_j its components are proportional to M'(c_i) s^2 + M''(c_i) s + 6. The matrix integrates
    polynomials: for the integral U of the eigenvector's polynomial, s U - U' vanishes at the nodes and is a multiple of
    M.
    """
    values = []
    for i in range(3):
        a, b = c[i] - c[i - 1], c[i] - c[i - 2]
        values.append(a * b * s * s + 2 * (a + b) * s + 6)
    return [value / values[-1] for value in values]


INTEGRATORS: tuple[type[Integrator], ...] = (Radau5,)

"""SUNDIALS through its Python binding scikit-sundae: CVODE's Adams methods and BDF, and IDA's BDF.

Adams methods have orders 1 to 12, BDF 1 to 5. `sundials` drives the same libraries by their C interface, which takes a
tenth of the time.

How it is driven, and why:

- Samples from `solve` with all times: steps go past a sample, which the polynomial of the step gives, with its order.
- The setting is `rtol`; `atol` = .1 `rtol`, the ratio of its defaults (1e-5 and 1e-6), in SI units.
- All iterate by Newton's method with a dense matrix: the binding has no option for the fixed point, which the manual of
  SUNDIALS names for Adams. They get the compiled Jacobian, as the manual recommends; if equations cannot be traced,
  SUNDIALS takes differences.
- IDA solves F(t, y, y') = 0, here y' - f(t, y) with the Jacobian c - df/dy and the slope at the start.
- The right-hand side is compiled. It is called through Python with a read-only array as the state, which the compiled
  function does not take, so the state is copied.
- `max_num_steps` is the limit of steps between two samples; its default of 500 ends long intervals early, so it is
  raised.

Traps: after a failure the last row is the state at which it stopped, not at a sample time. If it is given two times
only, it returns its own steps, without a limit of their number: a time between the two is added. It does not tell the
number of its steps. Towards a singularity it takes ever smaller steps, until the time limit of the trial.
"""

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.scipy_ivp import jacobian_of, step_sizes
from gnomon.harness.adapters.scipy_ode import STEPS
from gnomon.harness.adapters.sundials import Sundials, silence
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solver, each_start
from gnomon.harness.contract.validation import require_positive
from gnomon.harness.kernels.equations import right_hand_side

Equations = Callable[[float, Floats, Floats], None]
"""A function of (t, y, out), which fills `out`."""
Solve = Callable[[Floats, Floats], Any]
"""A function of (times, start), which returns scikit-sundae's result."""


class Binding(Sundials):
    """A solver of SUNDIALS by its binding. Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005) 363."""

    policy = "binding"
    primary = False  # the same methods by their C interface are faster

    @abstractmethod
    def solver(self, function: Equations, jacobian: Equations | None, options: dict[str, Any]) -> Solve:
        """A function of (times, start). `function` fills f(t, y), `jacobian` df/dy; keys are added to `options`."""

    def prepare(self, problem: Problem, setting: float) -> Solver:
        silence()
        import sksundae  # noqa: F401 - without the library the status is `not_installed`

        require_positive(setting, "tolerance")
        assert isinstance(problem.form, FirstOrder)
        options: dict[str, Any] = {"rtol": setting, "atol": self.atol_ratio * setting, "max_num_steps": STEPS}
        options |= step_sizes(self)
        kernel, buffer = right_hand_side(problem).pointer, problem.buffer
        jacobian = jacobian_of(problem.form, problem.dimension, buffer)
        state = np.empty(problem.dimension)

        def function(t: float, y: Floats, derivatives: Floats) -> None:
            state[:] = y
            kernel(t, state, buffer, derivatives)

        def fill(t: float, y: Floats, matrix: Floats) -> None:
            assert jacobian is not None
            state[:] = y
            matrix[:] = jacobian(t, state)

        solve = self.solver(function, None if jacobian is None else fill, options)
        samples_alone = np.concatenate([[problem.t0], problem.times])
        between = [samples_alone.mean()] if len(problem.times) == 1 else []
        times = np.insert(samples_alone, 1, between)

        def solve_one(start: Floats, samples: Floats) -> tuple[None, str | None]:
            solution = solve(times, start)
            reached = int(np.count_nonzero(np.isin(times, solution.t)))
            rows = solution.y[1 + len(between) : reached]
            samples[: len(rows)] = rows
            return None, None if solution.success else f"{solution.message} at t = {solution.t[-1]:g}"

        return Solver(each_start(problem, solve_one), options)


class Adams(Binding):
    """CVODE's Adams-Moulton methods of variable order and step."""

    name: ClassVar[str] = "CVODE Adams"
    method: ClassVar[str] = "Adams"

    def solver(self, function: Equations, jacobian: Equations | None, options: dict[str, Any]) -> Solve:
        from sksundae.cvode import CVODE

        options["method"] = self.method

        def fill(t: float, y: Floats, derivatives: Floats, matrix: Floats) -> None:
            assert jacobian is not None
            jacobian(t, y, matrix)

        solve: Solve = CVODE(function, jacfn=jacobian and fill, **options).solve
        return solve


class Bdf(Adams):
    """CVODE's backward differentiation formulas of variable order and step."""

    name, method = "CVODE BDF", "BDF"


class Ida(Binding):
    """IDA's backward differentiation formulas of variable order and step, for implicit equations."""

    name = "IDA"

    def solver(self, function: Equations, jacobian: Equations | None, options: dict[str, Any]) -> Solve:
        from sksundae.ida import IDA

        def residual(t: float, y: Floats, slope: Floats, left: Floats) -> None:
            function(t, y, left)
            np.subtract(slope, left, out=left)

        def fill(t: float, y: Floats, slope: Floats, left: Floats, c: float, matrix: Floats) -> None:
            assert jacobian is not None
            jacobian(t, y, matrix)
            np.negative(matrix, out=matrix)
            matrix.flat[:: len(y) + 1] += c

        ida = IDA(residual, jacfn=jacobian and fill, **options)

        def solve(times: Floats, start: Floats) -> Any:
            slope = np.empty(len(start))
            function(times[0], start, slope)
            return ida.solve(times, start, slope)

        return solve


INTEGRATORS: tuple[type[Integrator], ...] = (Adams, Bdf, Ida)

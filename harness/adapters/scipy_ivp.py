"""SciPy's `solve_ivp` for smooth problems: RK45, DOP853, Radau, BDF and LSODA.

How it is driven, and why:

- Samples through `t_eval`, as SciPy's manual recommends: steps stay as long as the tolerance allows and each sample
  comes from the interpolant of its step (order 4 for RK45, 7 for DOP853, 3 for Radau). `dense_output=True` would build
  an interpolant for every step, sampled or not.
- The setting is `rtol`; `atol` = 1e-3 `rtol`, the ratio of SciPy's defaults (1e-3 and 1e-6), in SI units.
- The right-hand side is compiled, and a function of C for Python, which adds no frame of Python. SciPy calls it from
  Python, which takes 3 to 5 us a call: that belongs to the library's time, since it takes no C pointer here
  (`LowLevelCallable` is for its quadratures).
- Radau, BDF and LSODA get the compiled Jacobian, as the manual recommends; it is differentiated from the equations as
  for the in-house Radau IIA. If these cannot be traced (a branch, abs), SciPy uses finite differences: `jac` = None.

Traps:

- SciPy raises an `rtol` below 100 ulp with only a warning; here it is refused.
- A right-hand side that is not finite at the start gives a first step that is NaN, and RK45 and DOP853 then never
  return; it is evaluated before (LSODA returns NaN and reports success).
- Towards a singularity LSODA takes ever smaller steps without end, until the time limit of the trial; the other methods
  stop with too small a step.
- Radau does not test whether a Jacobian is finite: off the domain of the equations (a step past a pericentre at a loose
  tolerance) LAPACK's wrapper raises `array must not contain infs or NaNs`, and the trial counts as crashed.
- Without a Jacobian Radau and BDF evaluate at columns of a matrix, which are not contiguous, and do not count these
  right-hand sides in their `nfev`; they are counted here.
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.installed import Installed
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solver, Tolerance, each_start
from gnomon.harness.contract.validation import require_positive
from gnomon.harness.kernels.equations import Kernel, right_hand_side
from gnomon.harness.kernels.straight_line import derivatives_if_traced

SMALLEST = 100 * float(np.finfo(float).eps)
"""The smallest rtol that SciPy does not change."""

STEP_SIZES = "max_step", "first_step"

Function = Callable[[float, Floats], Floats]
"""A function of (t, y)."""


class SolveIvp(Installed):
    """A method of `scipy.integrate.solve_ivp`; `method` is its name there."""

    library = "scipy"
    accepts: ClassVar[tuple[type, ...]] = (FirstOrder,)
    sampling = "dense output"
    sweep = Tolerance(1e-3, 1e-13)
    atol_ratio: float = 1e-3
    takes: ClassVar[tuple[str, ...]] = STEP_SIZES
    method: ClassVar[str]
    takes_jacobian: ClassVar[bool] = False

    def given(
        self, kernel: Kernel, form: FirstOrder, dimension: int, buffer: Floats
    ) -> tuple[Function, dict[str, Function | None]]:
        """The equations as SciPy calls them, and the option `jac` if the method takes a Jacobian."""
        function = kernel.bound(buffer)
        if not self.takes_jacobian:
            return function, {}
        jacobian = jacobian_of(form, dimension, buffer)
        if jacobian is not None:
            return function, {"jac": jacobian}
        return lambda t, y: function(t, np.ascontiguousarray(y)), {"jac": None}

    def options_of(self, setting: float) -> dict[str, Any]:
        """Method and tolerances for `solve_ivp`. Raises Refused for a tolerance that SciPy would change, or hang with."""
        require_positive(setting, "tolerance")
        if setting < SMALLEST:
            raise Refused(f"rtol = {setting:g}: SciPy would silently use {SMALLEST:.1e}; ask for no less")
        return {"method": self.method, "rtol": setting, "atol": self.atol_ratio * setting} | step_sizes(self)

    def prepare(self, problem: Problem, setting: float) -> Solver:
        from scipy.integrate import solve_ivp  # slow to load: only the trials of this library wait

        assert isinstance(problem.form, FirstOrder)
        buffer, times = problem.buffer, problem.times
        function, jacobian = self.given(right_hand_side(problem), problem.form, problem.dimension, buffer)
        options = self.options_of(setting) | jacobian
        finite = right_hand_side(replace(problem, counted=False)).array

        def solve_one(start: Floats, samples: Floats) -> tuple[None, str | None]:
            if not np.isfinite(finite(problem.t0, start, buffer)).all():
                return None, "the right-hand side is not finite at the start"
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                solution = solve_ivp(function, (problem.t0, times[-1]), start, t_eval=times, **options)
            reached = np.reshape(solution.y, (problem.dimension, -1)).T  # solution.y may be an empty list
            samples[: len(reached)] = reached
            return None, None if solution.success else reason(solution.message, caught)

        return Solver(each_start(problem, solve_one), record_options(options))


def step_sizes(integrator: Integrator, longest: str = "max_step", first: str = "first_step") -> dict[str, float]:
    """The options of a library, by its names, for the limits of steps that an integrator has."""
    limits = {} if integrator.max_step == np.inf else {longest: integrator.max_step}
    return limits if integrator.first_step is None else limits | {first: integrator.first_step}


def right_hand_side_of(problem: Problem) -> Function:
    """The compiled right-hand side as SciPy calls it; it counts its calls if `problem.counted`."""
    return right_hand_side(problem).bound(problem.buffer)


def jacobian_of(form: FirstOrder, dimension: int, buffer: Floats) -> Function | None:
    """The compiled Jacobian (dim, dim) of equations whose parameters are all of `buffer` but its last element.

    None if the equations cannot be traced.
    """
    kernel = derivatives_if_traced(form, dimension, len(buffer) - 1)
    if kernel is None:
        return None
    function = kernel.bound(buffer)
    return lambda t, y: function(t, y).reshape(dimension, dimension)


def record_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """The options given to SciPy, with the word "compiled" for a function."""
    return {name: "compiled" if callable(value) else value for name, value in options.items() if name != "method"}


def reason(message: str, caught: list[warnings.WarningMessage]) -> str:
    """The reason for the stop of SciPy: its message, and the last warning, which has the cause for LSODA."""
    return " ".join([message, *(str(entry.message) for entry in caught[-1:])])


class RK45(SolveIvp):
    """Dormand and Prince's 5(4) pair, interpolant of order 4. J. Comput. Appl. Math. 6 (1980) 19."""

    name = method = "RK45"
    order = 5


class DOP853(SolveIvp):
    """Dormand and Prince's 8(5,3) pair, interpolant of order 7. Hairer, Norsett, Wanner (1993), II.10."""

    name = method = "DOP853"
    order = 8


class Radau(SolveIvp):
    """Implicit Runge-Kutta of the Radau IIA family, for stiff problems. Hairer, Wanner (1996), IV.8."""

    name = method = "Radau"
    order = 5
    takes_jacobian = True
    takes: ClassVar[tuple[str, ...]] = (*STEP_SIZES, "jac")


class BDF(SolveIvp):
    """Backward differentiation of orders 1 to 5, for stiff problems.

    Shampine, Reichelt, SIAM J. Sci. Comput. 18 (1997) 1.
    """

    name = method = "BDF"
    takes_jacobian = True
    takes: ClassVar[tuple[str, ...]] = (*STEP_SIZES, "jac")
    primary = False  # never the fastest of SciPy's methods


class LSODA(SolveIvp):
    """ODEPACK's Adams and BDF methods, switched automatically. Petzold, SIAM J. Sci. Stat. Comput. 4 (1983) 136."""

    name = method = "LSODA"
    takes_jacobian = True
    takes: ClassVar[tuple[str, ...]] = (*STEP_SIZES, "jac")


INTEGRATORS: tuple[type[Integrator], ...] = (RK45, DOP853, Radau, BDF, LSODA)

"""SciPy's `odeint`: ODEPACK's LSODA, all samples in one call of compiled code.

How it is driven, and why:

- The same algorithm as `solve_ivp`'s LSODA, 3 to 4 times faster on the pendulum: only the right-hand side is called
  from Python. It takes no C function (`LowLevelCallable` is refused), so the compiled function is called from Python.
- The setting is `rtol`; `atol` is equal to it, as the defaults are (1.5e-8), in SI units. With 1e-3 `rtol`, as in
  `scipy_ivp`, the steps shrink where a component passes 0, LSODA then takes the pendulum for stiff, and at 1e-13 it
  makes 52 of 64 samples with BDF: 175,450 steps in place of 31,944, and 7 times the error.
- It gets the compiled Jacobian, which it evaluates only while it treats the problem as stiff.
- `tcrit`: no step goes past the last sample.
- `mxstep`, the limit of steps between two samples, is 500 by default, which ends long intervals early.

Traps: after a failure it warns, and all further samples are uninitialised memory; for `rtol` below 100 ulp (LSODA's own
limit) these are all samples but the initial state. Such tolerances are refused; `tcur` shows which samples were
reached. It reports values that are not finite as a success.
"""

import warnings
from dataclasses import replace

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.installed import Installed
from gnomon.harness.adapters.scipy_ivp import (
    SMALLEST,
    STEP_SIZES,
    jacobian_of,
    record_options,
    right_hand_side_of,
    step_sizes,
)
from gnomon.harness.adapters.scipy_ode import STEPS
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solver, Tolerance, each_start
from gnomon.harness.contract.validation import require_positive
from gnomon.harness.kernels.equations import right_hand_side

SUCCESS = "Integration successful."


class Odeint(Installed):
    """ODEPACK's Adams and BDF methods, switched automatically. Petzold, SIAM J. Sci. Stat. Comput. 4 (1983) 136."""

    name, library = "odeint", "scipy"
    accepts = (FirstOrder,)
    sampling = "dense output"
    sweep = Tolerance(1e-3, 1e-13)
    atol_ratio: float = 1.0
    takes = (*STEP_SIZES, "jac")

    def prepare(self, problem: Problem, setting: float) -> Solver:
        from scipy.integrate import odeint  # slow to load: only the trials of this library wait

        require_positive(setting, "tolerance")
        if setting < SMALLEST:
            raise Refused(
                f"rtol = {setting:g}: LSODA refuses it and returns no state; ask for no less than {SMALLEST:.1e}"
            )
        assert isinstance(problem.form, FirstOrder)
        function = right_hand_side_of(problem)
        finite = right_hand_side(replace(problem, counted=False)).array
        jacobian = jacobian_of(problem.form, problem.dimension, problem.buffer)
        options = {
            "rtol": setting,
            "atol": self.atol_ratio * setting,
            "mxstep": STEPS,
            "Dfun": jacobian,
            "tcrit": problem.times[-1:],
        }
        options |= step_sizes(self, "hmax", "h0")
        grid = np.concatenate([[problem.t0], problem.times])

        def solve_one(start: Floats, samples: Floats) -> tuple[int, str | None]:
            if not np.isfinite(finite(problem.t0, start, problem.buffer)).all():
                return 0, "the right-hand side is not finite at the start"
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # the message has the same information
                rows, facts = odeint(function, start, grid, tfirst=True, full_output=True, **options)
            if facts["message"] == SUCCESS:
                samples[:] = rows[1:]
                return int(facts["nst"][-1]), None
            reached = int(np.argmin(facts["tcur"] >= grid[1:]))
            samples[:reached] = rows[1 : reached + 1]
            return int(facts["nst"][reached]), f"{facts['message']} at t = {facts['tcur'][reached]:g}"

        return Solver(each_start(problem, solve_one), record_options(options))


INTEGRATORS: tuple[type[Integrator], ...] = (Odeint,)

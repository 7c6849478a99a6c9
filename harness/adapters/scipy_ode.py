"""SciPy's `ode('dop853')`: the compiled DOP853 of Hairer and Wanner, stepped from sample to sample.

How it is driven, and why:

- It has no interpolant to offer, so it stops at each sample, and begins there with a new first step: at loose tolerance
  the samples, not the tolerance, set the step.
- The knob is `rtol`; `atol` = 1e-6 `rtol`, the ratio of its defaults (1e-6 and 1e-12), in SI units.
- `nsteps` is the limit of steps between two samples; its default of 500 ends long intervals early, so it is raised.

Traps: where it gives up it warns, returns the state that it got to, and goes on if asked again; only `successful()`
tells. Here the remaining samples are NaN and the reason is kept. `atol` = 0 refuses every start with a component at 0.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import numpy as np
from gnomon.cases.forms import FirstOrder
from gnomon.harness.adapters.scipy_ivp import right_hand_side_of
from gnomon.harness.integrator import Floats, Integrator, Problem, Solution, Solve, Tolerance

ABSOLUTE = 1e-6
"""atol over rtol."""
STEPS = 10_000_000
"""Steps allowed between two samples: more than any time limit of a trial admits."""
ACCEPTED = 18
"""Where the solver's work array has the number of accepted steps of the last call (IWORK(19) in its manual)."""


class Dop853(Integrator):
    """Dormand and Prince's 8(5,3) pair, compiled. Hairer, Norsett, Wanner, Solving ODEs I (1993), II.10."""

    name, library, order = "ode dop853", "scipy", 8
    accepts = (FirstOrder,)
    sampling = "stops at samples"
    sweep = Tolerance(1e-3, 1e-13)

    def prepare(self, problem: Problem, setting: float) -> Solve:
        from scipy.integrate import ode

        options = {"rtol": setting, "atol": ABSOLUTE * setting, "nsteps": STEPS}
        solver = ode(right_hand_side_of(problem))
        solver.set_integrator("dop853", **options)
        times = problem.times.tolist()

        def solve_one(start: Floats, samples: Floats) -> tuple[int, str | None]:
            steps = 0
            solver.set_initial_value(start, 0.0)
            for k, time in enumerate(times):
                state = solver.integrate(time)
                steps += int(solver._integrator.iwork[ACCEPTED])
                if not solver.successful():
                    code = solver.get_return_code()
                    return steps, f"{solver._integrator.messages.get(code, f'code {code}')} at t = {solver.t:g}"
                samples[k] = state
            return steps, None

        def solve(initial_states: Floats) -> Solution:
            states = np.full((len(initial_states), len(times), problem.dimension), np.nan)
            steps, stopped = 0, None
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # what the warning says is in the return code
                for start, samples in zip(initial_states, states, strict=True):
                    taken, why = solve_one(start, samples)
                    steps, stopped = steps + taken, stopped or why
            return Solution(states, steps, stopped)

        solve.settings = options  # type: ignore[attr-defined]
        return solve

    def versions(self) -> Mapping[str, Any]:
        return {"scipy": version("scipy")}


INTEGRATORS: tuple[type[Integrator], ...] = (Dop853,)

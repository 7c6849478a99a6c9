"""SciPy's `ode`: the compiled DOP853 of Hairer and Wanner, and VODE with Adams' methods.

How they are driven, and why:

- DOP853 has no interpolant here, so it stops at each sample, and begins there with a new first step: at loose tolerance
  the samples, not the tolerance, determine the step. VODE steps past a sample and interpolates, but
  not past the last one.
- The setting is `rtol`; `atol` = 1e-6 `rtol`, the ratio of its defaults (1e-6 and 1e-12), in SI units.
- `nsteps` is the limit of steps between two samples; its default of 500 ends long intervals early, so it is raised.
- Adams' methods iterate without a Jacobian, as is VODE's default.

Traps: after a failure it warns, returns the state that it reached, and continues in the next call; only `successful()`
shows the failure. Here the remaining samples are NaN and the reason is kept. With `atol` = 0 every start with a
component at 0 is refused. If values are not finite, VODE halves its step without end, until the time limit of the
trial.
"""

import warnings
from typing import Any, ClassVar

from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.installed import Installed
from gnomon.harness.adapters.scipy_ivp import STEP_SIZES, right_hand_side_of, step_sizes
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solver, Tolerance, each_start
from gnomon.harness.contract.validation import require_positive

STEPS = 10_000_000
"""Steps allowed between two samples: more than any time limit of a trial admits."""


class Ode(Installed):
    """A method of `scipy.integrate.ode`; `engine` is its name there."""

    library = "scipy"
    accepts = (FirstOrder,)
    sweep = Tolerance(1e-3, 1e-13)
    atol_ratio: float = 1e-6
    takes = STEP_SIZES
    engine: ClassVar[str]
    method: ClassVar[dict[str, str]] = {}
    accepted: ClassVar[int]
    """The index of the number of accepted steps in the solver's work array (IWORK in its manual, from 1)."""
    accumulates: ClassVar[bool]
    """Whether the number of accepted steps counts all calls since the start, or only the last call."""

    def stop_at(self, solver: Any, end: float) -> None:
        """Forbid steps past a time; nothing to do for a method that stops at each sample."""

    def prepare(self, problem: Problem, setting: float) -> Solver:
        from scipy.integrate import ode  # slow to load: only the trials of this library wait

        require_positive(setting, "tolerance")
        options: dict[str, Any] = {"rtol": setting, "atol": self.atol_ratio * setting, "nsteps": STEPS, **self.method}
        options |= step_sizes(self)
        solver = ode(right_hand_side_of(problem))
        solver.set_integrator(self.engine, **options)
        times = problem.times.tolist()

        def solve_one(start: Floats, samples: Floats) -> tuple[int, str | None]:
            steps = 0
            solver.set_initial_value(start, problem.t0)
            self.stop_at(solver, times[-1])
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # the return code has the same information
                for k, time in enumerate(times):
                    state = solver.integrate(time)
                    accepted = int(solver._integrator.iwork[self.accepted - 1])
                    steps = accepted if self.accumulates else steps + accepted
                    if not solver.successful():
                        code = getattr(solver._integrator, "istate", 1)
                        return steps, f"{solver._integrator.messages.get(code, f'code {code}')} at t = {solver.t:g}"
                    samples[k] = state
            return steps, None

        return Solver(each_start(problem, solve_one), options)


class Dop853(Ode):
    """Dormand and Prince's 8(5,3) pair, compiled. Hairer, Norsett, Wanner, Solving ODEs I (1993), II.10."""

    name, order = "ode dop853", 8
    sampling = "stops at samples"
    engine, accepted, accumulates = "dop853", 19, False


class Adams(Ode):
    """VODE's Adams methods of orders 1 to 12. Brown, Byrne, Hindmarsh, SIAM J. Sci. Stat. Comput. 10 (1989) 1038."""

    name = "ode vode Adams"
    sampling = "dense output"
    engine, accepted, accumulates = "vode", 11, True
    method: ClassVar = {"method": "adams"}

    def stop_at(self, solver: Any, end: float) -> None:
        """By ITASK = 4 with TCRIT in RWORK(1), for which `ode` has no option."""
        engine = solver._integrator
        engine.call_args[2], engine.rwork[0] = 4, end


INTEGRATORS: tuple[type[Integrator], ...] = (Dop853, Adams)

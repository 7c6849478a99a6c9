"""diffrax: adaptive Runge-Kutta methods compiled by JAX together with the equations of each problem.

How it is driven, and why:

- The methods that its manual names: Tsit5 for usual problems, Dopri8 at tight tolerances, Kvaerno5 for stiff ones, each
  with its controller of step sizes. Its leapfrog and fixed steps are meant for other tasks (learning, noise).
- The setting is `rtol`; `atol` = .01 `rtol`, as in its example of accurate solutions (1e-7 and 1e-9). Arithmetic is
  binary64.
- Samples come from its interpolants, which have the order of the method, but order 3 for Kvaerno5. On the oscillator,
  at a tolerance of 1e-9, the interpolant of Dopri8 leaves 170 times the error of its steps, the interpolant of Tsit5
  adds no error.
- The case's own equations are evaluated in JAX's arithmetic. Compilation, about a second for a method and a case, is
  preparation. The tolerance is an argument of the compiled function, so that one compilation serves all tolerances.
- Times, parameters and tolerances become arrays of JAX before the first call. A call converts the start, and then the
  states back: a null call takes 0.73 to 0.78 of its time with all converted (medians of 25 pairs).
- The adjoint is the default, `RecursiveCheckpointAdjoint`. `ForwardMode` and `BacksolveAdjoint` give the same bits in 0.91 to
  1.10 of its time, on the pendulum and on Kepler's orbit; its manual does not recommend `DirectAdjoint`, whose time grows
  with the limit of steps.
- Ensembles by `vmap`: all trajectories of an ensemble in one loop.
- Right-hand sides are not called one by one, so they are not counted.

Traps: its default of 4096 steps would end long intervals early. If it accepts no step (a state that is not finite, a
singularity), it halves the step up to that limit and ignores its least step. After a failure the samples that were not
reached are infinite.
"""

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.arithmetic import FUNCTIONS, rebind
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.installed import Installed
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solution, Solver, Tolerance, Unsupported
from gnomon.harness.contract.sources import cache_by_content
from gnomon.harness.contract.validation import require_positive

STEPS = 500_000
"""The largest number of steps: some seconds."""
ENSEMBLE = 8
"""The least number of trajectories that are integrated together, by a function that is compiled for this. Dopri8 took
for two trajectories 3.5 times as long as one by one, for eight 1.1 times, for a hundred less than half (pendulum, 1e-6,
processor time)."""


class Tsit5(Installed):
    """Tsitouras' pair of order 5. Tsitouras, Comput. Math. Appl. 62 (2011) 770; Kidger, arXiv:2202.02435."""

    name: ClassVar[str] = "Tsit5"
    library = "diffrax"
    order: ClassVar[int | None] = 5
    accepts = (FirstOrder,)
    sampling = "dense output"
    sweep = Tolerance(1e-3, 1e-14)
    atol_ratio: float = 0.01
    counts_rhs = False

    def prepare(self, problem: Problem, setting: float) -> Solver:
        import diffrax  # without the library the status is `not_installed`
        import jax

        require_positive(setting, "tolerance")
        assert isinstance(problem.form, FirstOrder)
        sizes = problem.dimension, len(problem.times), len(problem.parameters)
        equations = problem.form.equations
        numbers = np.append(problem.t0, problem.times), problem.parameters, setting * np.array([1.0, self.atol_ratio])
        single = compile_solver(self.name, equations, sizes)
        with jax.enable_x64(True):
            arguments = jax.device_put(numbers)  # at each call JAX would convert them again

        def solve(initial_states: Floats) -> Solution:
            many = len(initial_states) if len(initial_states) >= ENSEMBLE else 0
            function = compile_solver(self.name, equations, sizes, many) if many else single
            states = np.empty((len(initial_states), len(problem.times), problem.dimension))
            steps, reasons = 0, []
            with jax.enable_x64(True):
                for k, start in enumerate([initial_states] if many else initial_states):
                    *arrays, result = function(start, *arguments)
                    rows, counts, good = map(np.asarray, arrays)  # NumPy's functions on arrays of JAX dispatch to JAX
                    states[slice(None) if many else k] = rows
                    steps += int(counts.sum())
                    failed = np.flatnonzero(~good)[:1]
                    reasons += [diffrax.RESULTS[jax.tree.map(lambda x, i=i: x.ravel()[i], result)] for i in failed]
            states[~np.isfinite(states)] = np.nan
            return Solution(states, steps, str(reasons[0]) if reasons else None)

        return Solver(solve, {"rtol": setting, "atol": self.atol_ratio * setting, "max_steps": STEPS})


class Dopri8(Tsit5):
    """The pair of order 8 by Prince and Dormand, J. Comput. Appl. Math. 7 (1981) 67."""

    name, order = "Dopri8", 8


class Kvaerno5(Tsit5):
    """A diagonally implicit, L-stable pair of order 5. Kvaerno, BIT 44 (2004) 489."""

    name = "Kvaerno5"


@cache_by_content
def compile_solver(method: str, equations: Callable[..., Any], sizes: tuple[int, int, int], ensemble: int = 0) -> Any:
    """A compiled function (start, times, parameters, (rtol, atol)) -> states, steps, success, result.

    The times begin with the time of the start. `sizes`: the numbers of components, samples and parameters. `ensemble`:
    the number of starts that are solved at once; 0: the start is one state. Raises Unsupported if JAX cannot evaluate
    the equations.
    """
    import diffrax
    import jax
    from diffrax import ODETerm, PIDController, SaveAt, diffeqsolve

    solver = getattr(diffrax, method)()
    case = rebind(equations, {name: getattr(jax.numpy, name) for name in FUNCTIONS})

    def slope(t: Any, y: Any, parameters: Any) -> Any:
        return jax.numpy.array(case(t, tuple(y), tuple(parameters)), dtype=float)

    def solve(start: Any, grid: Any, parameters: Any, tolerance: Any) -> Any:
        controller = PIDController(rtol=tolerance[0], atol=tolerance[1])
        path = diffeqsolve(
            ODETerm(slope), solver, grid[0], grid[-1], None, start, parameters,
            saveat=SaveAt(ts=grid[1:]), stepsize_controller=controller, max_steps=STEPS, throw=False,
        )  # fmt: skip
        return path.ys, path.stats["num_accepted_steps"], diffrax.is_successful(path.result), path.result

    dimension, samples, parameters = sizes
    start = (ensemble, dimension) if ensemble else (dimension,)
    with jax.enable_x64(True):
        shapes = [jax.ShapeDtypeStruct(shape, float) for shape in (start, (samples + 1,), (parameters,), (2,))]
        function = jax.vmap(solve, (0, None, None, None)) if ensemble else solve
        try:
            traced = jax.jit(function).lower(*shapes)
        except jax.errors.TracerBoolConversionError:
            raise Unsupported("the equations branch on computed values, which JAX does not compile") from None
        except Exception as error:  # equations of a user's own may raise anything
            raise Unsupported(f"JAX cannot evaluate the equations: {type(error).__name__}: {error}") from None
        return traced.compile()


INTEGRATORS: tuple[type[Integrator], ...] = (Tsit5, Dopri8, Kvaerno5)

"""heyoka: Taylor's method, order and step from the tolerance, compiled for each problem.

How it is driven, and why:

- The case's own equations are evaluated once in heyoka's expressions, with the parameters as numbers, which it folds.
- Samples by `propagate_grid`: each comes from the Taylor polynomial of its step, as accurate as the step itself.
- The setting is `tol`: the size of the remainder, relative to the largest component of the state, absolute while all
  components are below 1. The order follows from it (12 at 1e-9, 20 at the default, the epsilon of binary64).
- Ensembles in batch mode, one batch integrator a core. A batch has a separate step size for each trajectory.
- Two policies: the defaults, and `fast math`, the fastest that its manual documents. `fast_math` lets the compiler
  contract and reassociate, and 1/(u sqrt(u)) is written u^(-3/2), as in its own model of N bodies: one recurrence
  instead of three. Its time over the time with the defaults, best of 40 alternating runs: pendulum .73 to .81, Kepler
  .72 to .76, oscillator .72 to .87, heavy top .94 to 1.18, rigid body .94 to .99 (AMD EPYC, tolerances 1e-12 to 1e-6, a
  loaded machine).
- Plain mode, not compact mode, which its manual recommends for large systems: on five problems of the catalogue compact
  mode was slower, up to 7 times, and `parallel_mode` 35 to 100 times. `high_accuracy` gained nothing beyond noise,
  `slp_vectorize` lost up to a third; `force_avx512` was only tried on a processor without these instructions.
- Compilation, .03 to .4 s for each tolerance, is preparation. Right-hand sides are not called one by one, so they are
  not counted; the work of a step grows with its order.

Traps, seen in 7.13: the first point of the grid must be the present time. If a state is not finite, this sample and all
later ones are missing, and only the outcome shows it. `hypot` has no counterpart.
"""

import copy
import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from traceback import extract_tb
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core import arithmetic
from gnomon.cases.core.arithmetic import FUNCTIONS, rebind
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.installed import Installed
from gnomon.harness.contract.integrator import Integrator, Problem, Solution, Solver, Tolerance, Unsupported
from gnomon.harness.contract.validation import require_positive
from gnomon.harness.kernels import traced

ENSEMBLE, BATCH = 16, 8
"""At least ENSEMBLE trajectories are integrated in batches of BATCH, the lanes of heyoka's vectors: 8 with AVX-512."""


class Taylor(Installed):
    """Taylor's method of adaptive order and step. Biscani and Izzo, MNRAS 504 (2021) 2614."""

    name, library = "Taylor", "heyoka"
    accepts = (FirstOrder,)
    sampling = "dense output"
    sweep = Tolerance(1e-3, 1e-15)
    counts_rhs = False
    takes = ("max_step",)
    fast: ClassVar[bool] = False

    def prepare(self, problem: Problem, setting: float) -> Solver:
        import heyoka  # without the library the status is `not_installed`

        require_positive(setting, "tolerance")
        options = {"tol": setting, "fast_math": True} if self.fast else {"tol": setting}
        equations = system(problem, self.fast)
        integrator = heyoka.taylor_adaptive(equations, [0.0] * problem.dimension, **options)
        grid = np.concatenate([[problem.t0], problem.times])
        limit = {} if self.max_step == math.inf else {"max_delta_t": self.max_step}
        finished = heyoka.taylor_outcome.time_limit

        def solve(initial_states: Any) -> Solution:
            if len(initial_states) >= ENSEMBLE:
                return together(batches(), initial_states)
            states = np.full((len(initial_states), len(problem.times), problem.dimension), np.nan)
            steps, stopped = 0, None
            for start, samples in zip(initial_states, states, strict=True):
                integrator.time = problem.t0
                integrator.state[:] = start
                outcome, _, _, count, _, rows = integrator.propagate_grid(grid, **limit)
                samples[: len(rows) - 1] = rows[1:]
                steps += count
                if outcome != finished:
                    stopped = f"{outcome} at t = {integrator.time:g}"
            return Solution(states, steps, stopped)

        @cache
        def batches() -> list[Any]:
            """One batch integrator for each core, compiled at the first ensemble."""
            start, width = np.zeros((problem.dimension, BATCH)), os.cpu_count() or 1
            first = heyoka.taylor_adaptive_batch(equations, start, **options)
            return [first, *(copy.deepcopy(first) for _ in range(width - 1))]

        def together(integrators: list[Any], initial_states: Any) -> Solution:
            states = np.full((len(initial_states), len(problem.times), problem.dimension), np.nan)
            many = np.repeat(grid[:, None], BATCH, axis=1)
            firsts = range(0, len(initial_states), BATCH)

            def share(which: int) -> tuple[int, list[str]]:
                batch, steps, stopped = integrators[which], 0, []
                for first in firsts[which :: len(integrators)]:
                    here = initial_states[first : first + BATCH]
                    batch.set_time(problem.t0)
                    # The last batch is filled up with its last trajectory.
                    batch.state[:] = here[np.minimum(np.arange(BATCH), len(here) - 1)].T
                    _, rows = batch.propagate_grid(many, **limit)
                    states[first : first + BATCH] = np.moveaxis(rows[1:], 2, 0)[: len(here)]
                    outcomes = batch.propagate_res[: len(here)]
                    steps += sum(accepted for _, _, _, accepted in outcomes)
                    stopped += [str(outcome) for outcome, *_ in outcomes if outcome != finished]
                return steps, stopped

            with ThreadPoolExecutor(len(integrators)) as threads:
                shares = list(threads.map(share, range(len(integrators))))
            stopped = [reason for _, reasons in shares for reason in reasons]
            return Solution(states, sum(steps for steps, _ in shares), stopped[0] if stopped else None)

        return Solver(solve, options)


class FastTaylor(Taylor):
    """Taylor's method with the fastest of heyoka's documented options. Biscani and Izzo, MNRAS 504 (2021) 2614."""

    policy, fast = "fast math", True


def system(problem: Problem, powers: bool) -> list[tuple[Any, Any]]:
    """The problem's equations as pairs (variable, derivative) of heyoka's expressions.

    With `powers` every 1/(u sqrt(u)) is written u^(-3/2). Raises Unsupported if the equations cannot be evaluated in
    expressions: they branch, use abs or a function that heyoka does not have, or raise an exception.
    """
    import heyoka

    assert isinstance(problem.form, FirstOrder)
    functions = {name: either(getattr(heyoka, name), name) for name in FUNCTIONS if hasattr(heyoka, name)}
    under_roots: list[Any] = []

    def sqrt(u: Any) -> Any:
        if isinstance(u, heyoka.expression):
            under_roots.append(u)
        return root(u)

    functions["sqrt"], root = sqrt, functions["sqrt"]
    variables = tuple(heyoka.expression(f"y{i}") for i in range(problem.dimension))
    numbers, trace = tuple(problem.parameters.tolist()), traced.Trace(problem.dimension, 0)
    nodes = {name: either(function, name) for name, function in trace.functions.items()}
    try:
        # Symbols that refuse a branch come first: an expression of heyoka is true and unequal to every number.
        rebind(problem.form.equations, nodes)(trace.t, trace.state, numbers)
        derivatives = rebind(problem.form.equations, functions)(heyoka.time, variables, numbers)
    except Exception as error:  # equations of a user's own may raise anything
        frames = extract_tb(error.__traceback__)
        line = [frame.line for frame in frames if frame.filename not in (arithmetic.__file__, traced.__file__)][-1]
        raise Unsupported(f"heyoka has no expression for `{line}`: {type(error).__name__}: {error}") from None
    # A derivative may be a plain number, as for a clock or a constant force.
    expressions = [dy if isinstance(dy, heyoka.expression) else heyoka.expression(float(dy)) for dy in derivatives]
    if powers:
        expressions = heyoka.subs(expressions, {1 / (u * root(u)): u**-1.5 for u in under_roots})
    return list(zip(variables, expressions, strict=True))


def either(symbolic: Callable[..., Any], name: str) -> Callable[..., Any]:
    """A function that takes numbers (the sine of a latitude) as well as symbols."""
    numeric = getattr(math, name)

    def function(*arguments: Any) -> Any:
        chosen = numeric if all(isinstance(x, int | float) for x in arguments) else symbolic
        return chosen(*arguments)

    return function


INTEGRATORS: tuple[type[Integrator], ...] = (Taylor, FastTaylor)

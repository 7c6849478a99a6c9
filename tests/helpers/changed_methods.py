"""An integrator of gnomon with a planted fault: a changed tolerance, or changed states."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solution, Solver, Tolerance, solver_of
from gnomon.harness.registry.lookup import find_one


class Changed(Integrator):
    """`tolerance(given, start)` is the tolerance that the method gets, `states(found)` the states that it returns."""

    name, library, order, accepts, sampling = "changed", "planted", 5, (FirstOrder,), "dense output"
    sweep = Tolerance(1e-3, 1e-12)
    base: ClassVar[str]
    tolerance: ClassVar[Callable[[float, Floats], float]]
    states: ClassVar[Callable[[Floats], Floats]]

    def prepare(self, problem: Problem, setting: float) -> Solver:
        kind, base = type(self), find_one(self.base)

        def solve(starts: Floats) -> Solution:
            found = solver_of(base, problem, kind.tolerance(setting, starts[0]))(starts)
            return replace(found, states=kind.states(found.states))

        return Solver(solve)


def changed(
    base: str = "gnomon:Dormand-Prince 5(4)",
    tolerance: Callable[[float, Any], float] = lambda given, start: given,
    states: Callable[[Floats], Any] = np.array,
) -> Integrator:
    kept = {"base": base, "tolerance": staticmethod(tolerance), "states": staticmethod(states)}
    return type("Changed", (Changed,), kept)()

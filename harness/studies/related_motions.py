"""Motions that follow from the motion of a case: with a later clock, in other units, mirrored, exchanged, reversed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from gnomon.cases.core.clock import from_start
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.core.symmetry import Relation, defect
from gnomon.harness.contract.integrator import Floats, Problem
from gnomon.harness.measuring.trials import Trials

KEEPS = 2.0**-40
"""Largest difference of a derivative for equations that hold in other units: thousands of roundings of its terms."""


def later(problem: Problem) -> Problem | None:
    """The problem with a clock that starts at a power of two; None if its times cannot be shifted exactly."""
    late = 2.0 ** math.ceil(math.log2(float(problem.times[-1])))
    times = problem.times + late
    if not np.array_equal(times - late, problem.times):
        return None
    names = None if problem.names is None else replace(problem.names, case=f"{problem.names.case} from t = {late:g}")
    return replace(problem, form=from_start(problem.form, -late), times=times, t0=late, names=names)


@dataclass(frozen=True)
class Related:
    """A transformed problem with its start and setting, and the function that transforms states back."""

    problem: Problem
    start: Floats
    setting: float
    undone: Callable[[Floats], Floats] = lambda states: states
    larger: float = 1.0
    """Factor by which the numbers become larger whose rounding changes the motion."""


def relate(trials: Trials, problem: Problem, setting: float, relation: Relation) -> Related:
    """The problem, setting and start of the case, transformed by a relation."""
    case = trials.case
    coordinates = [coordinate.name for coordinate in case.state]
    transformed = replace(
        problem,
        parameters=relation.applied([parameter.name for parameter in case.parameter_list], problem.parameters),
        times=problem.times * relation.time,
        time_scale=problem.time_scale * relation.time,
    )
    setting = setting * relation.time if trials.steps else setting
    start = relation.applied(coordinates, trials.start)
    return Related(transformed, start, setting, lambda states: relation.undone(coordinates, states))


def holds(trials: Trials, relation: Relation) -> bool:
    """Whether a relation leaves the equations of the case unchanged, along its exact motion."""
    form = next((form for form in trials.case.all_forms() if isinstance(form, FirstOrder)), None)
    moments = list(zip(trials.reference.times.tolist(), trials.reference.exact, strict=True))
    parameters = trials.problem().parameters
    return form is not None and defect(trials.case, form.equations, relation, moments, parameters) <= KEEPS


def measure_return(trials: Trials, problem: Problem, setting: float) -> float | None:
    """The distance from the start after the motion goes forward, is reversed, and comes back; None without a reversal."""
    (there,) = trials.solutions(problem, setting, [trials.start])
    home, end = trials.case.reversed(tuple(trials.start.tolist())), tuple(there[-1].tolist())
    turned = trials.case.reversed(end) if np.all(np.isfinite(there[-1])) else None
    if turned is None or home is None:
        return None
    state, parameters = turned
    numbers = np.array([float(parameters[parameter.name]) for parameter in trials.case.parameter_list])
    way_back = replace(problem, parameters=numbers)
    (back,) = trials.solutions(way_back, setting, [np.array(state, dtype=np.float64)])
    return float(trials.distance(back[-1:], np.array([home[0]], dtype=np.float64))[0])

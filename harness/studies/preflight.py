"""Pre-flights of physics engines: short checks that say by name what an engine does that a scene does not declare."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from gnomon.cases import Case, get, names
from gnomon.cases.core.forms import first_order
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Floats, Integrator, Refused
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.contract.status import Status
from gnomon.harness.studies.preflight_checks import CHECKS, UNEXPLAINED, Measure, Scenes
from gnomon.harness.studies.preflight_rates import STATES, Engine, rate_error

TEXTS: dict[str, dict[str, str]] = read_declared("studies", "preflights.toml")
"""What each pre-flight states, what to look at if it fails, and the derivation of its bound."""
STRONGER = {"foucault_pendulum_nonlinear": "turntable"}
"""Variants in which a force is not lost in the rounding of the others."""
ACCELERATION = "acceleration"
"""The pre-flight whose scenes are cases."""
PASSED, FAILED, UNSUPPORTED = "passed", "failed", str(Status.UNSUPPORTED)


@dataclass(frozen=True)
class Row:
    """The result of a pre-flight on a scene or a case.

    Attributes
    ----------
    name, scene : str
        The pre-flight, a key of `TEXTS`, and its scene, or a case.
    verdict : str
        passed, failed or unsupported.
    measured, bound : float
        The number that was measured and the largest that passes; nan if nothing was measured.
    note : str
        What the number is, or why there is none.
    """

    name: str
    scene: str
    verdict: str
    measured: float = math.nan
    bound: float = math.nan
    note: str = ""


def preflights(
    integrator: Integrator, chosen: Sequence[str] | None = None, on: Sequence[Case] | None = None
) -> Iterator[Row]:
    """Run pre-flights of an engine.

    Parameters
    ----------
    integrator : Integrator
        An integrator that accepts scenes.
    chosen : sequence of str, optional
        Names of pre-flights, by default all of `TEXTS`.
    on : sequence of Case, optional
        The cases of the pre-flight `acceleration`, which leaves out those without a scene or with events; by default
        `smooth_cases`.

    Yields
    ------
    Row
        A row for each scene of each pre-flight, also for scenes that the engine lacks.
    """
    engine = Engine(integrator)
    for name in chosen or TEXTS:
        scenes = CHECKS[name](engine) if name in CHECKS else _acceleration(engine, smooth_cases() if on is None else on)
        for scene, (form, measure) in scenes.items():
            yield _row(engine, name, scene, form, measure)


def name_convention(integrator: Integrator) -> str | None:
    """The convention of an engine that explains a failure of the pre-flight `start`; None if there is none."""
    rows = preflights(integrator, ["start"])
    return next((row.note for row in rows if row.verdict == FAILED and row.note not in UNEXPLAINED), None)


def _row(engine: Engine, name: str, scene: str, form: SceneForm, measure: Measure) -> Row:
    lacks = engine.integrator.unsupported(form)
    if lacks is not None:
        return Row(name, scene, UNSUPPORTED, note=lacks)
    try:
        measured, bound, note = measure()
    except Refused as error:
        return Row(name, scene, UNSUPPORTED, note=str(error))
    except Exception as error:  # the user's code may raise anything; the next scenes still run
        return Row(name, scene, FAILED, note=f"{type(error).__name__}: {error}")
    return Row(name, scene, PASSED if measured <= bound else FAILED, measured, bound, note)


@cache
def smooth_cases() -> tuple[Case, ...]:
    """The cases that have a scene and no events, with the variants of STRONGER."""
    cases = [get(*name) for name in [*((name,) for name in names()), *STRONGER.items()]]
    return tuple(case for case in cases if _is_smooth(case))


def _is_smooth(case: Case) -> bool:
    return case.scene is not None and case.hybrid is None


def _acceleration(engine: Engine, on: Sequence[Case]) -> Scenes:
    chosen = [case.rounded() for case in on if _is_smooth(case)]
    return {case.id: (case.scene, partial(_on_case, engine, case)) for case in chosen if case.scene is not None}


def _on_case(engine: Engine, case: Case) -> tuple[float, float, str]:
    problem, form = problem_of(case, (SceneForm,)), next(form for form in map(first_order, case.all_forms()) if form)
    assert isinstance(problem.form, SceneForm)
    chosen = np.random.default_rng(0).choice(case.times, STATES, replace=False)
    t0 = float(chosen[0]) if "time_force" in problem.form.needs else 0.0
    parameters = tuple(map(float, case.parameter_values()))

    def rates(t: float, y: Floats) -> Floats:
        return np.array(form.equations(t, tuple(y.tolist()), parameters), dtype=float)

    groups = [[i for i, each in enumerate(problem.groups) if each == group] for group in dict.fromkeys(problem.groups)]
    angles = [coordinate.kind == "angle" for coordinate in case.state]
    scale = float(case.fastest_time)
    sizes = {"rad": 1.0, "rad/s": 1 / scale}
    turning = [max(sizes.get(case.state[i].unit, 0.0) for i in members) for members in groups]
    problem = replace(problem, t0=t0, time_scale=scale)
    return rate_error(engine, problem, rates, case.sample(np.sort(chosen)), groups, angles, turning)

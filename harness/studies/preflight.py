"""Pre-flights of physics engines: short checks that say by name what an engine does that a scene does not declare."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from gnomon.cases import Case, get, names
from gnomon.cases.core.forms import first_order
from gnomon.cases.core.scene import SceneForm
from gnomon.cases.scenes.attitude import matrix
from gnomon.harness.contract.declared import declared
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solver, solver_of
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.studies.preflight_scenes import (
    AT_REST,
    ATTITUDE,
    GRAVITY,
    POINT,
    POSITION,
    RADIUS,
    SMOOTH,
    SPIN,
    TUMBLING,
    TURNED,
    VELOCITY,
    Rates,
    ball,
    box,
    flow,
    oblique_hinge,
    oblique_slider,
    state,
    tumbling_rates,
)

TEXTS: dict[str, dict[str, str]] = declared("studies", "preflights.toml")
"""What each pre-flight states, what to look at if it fails, and the derivation of its bound."""
ROUNDINGS = 64
"""Roundings of a step, each by the unit round-off of the largest number."""
STATES = 16
TINY = float(np.finfo(float).tiny)
UNSETTLED = 2.0**-6
"""Rates that steps of h/2 and h/4 give may differ by this share."""
STRONGER = {"foucault_pendulum_nonlinear": "turntable"}
"""Variants in which a force is not lost in the rounding of the others."""
PASSED, FAILED, UNSUPPORTED = "passed", "failed", "unsupported"


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


@dataclass(frozen=True)
class Engine:
    """An integrator of scenes with what the checks need to run it."""

    integrator: Integrator

    @property
    def bits(self) -> int:
        """The bits of the significand of the engine's numbers: 53, or 24 for binary32."""
        return int(getattr(self.integrator, "bits", 53))

    @property
    def rounding(self) -> float:
        """The rounding of one step, relative to the largest number."""
        return ROUNDINGS * 2.0**-self.bits

    def solve(self, form: SceneForm, starts: Sequence[Floats], times: Sequence[float], step: float) -> Floats:
        """States after each start at each time, shape (starts, times, dimension), from a new world."""
        return self.run(Problem(form, len(starts[0]), np.empty(0), np.array(times), 1.0), starts, step)

    def run(self, problem: Problem, starts: Sequence[Floats] | Floats, step: float) -> Floats:
        solver = solver_of(self.integrator, problem, step)
        try:
            return solver(np.array(starts)).states
        finally:
            solver.close()


Measure = Callable[[], tuple[float, float, str]]
"""Gives the number measured, its bound, and what the number is."""
Scenes = dict[str, tuple[SceneForm, Measure]]


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
        scenes = (
            _acceleration(engine, smooth_cases() if on is None else on)
            if name == ACCELERATION
            else CHECKS[name](engine)
        )
        for scene, (form, measure) in scenes.items():
            yield _row(engine, name, scene, form, measure)


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
    found = [get(*name) for name in [*((name,) for name in names()), *STRONGER.items()]]
    return tuple(case for case in found if _smooth(case))


def _smooth(case: Case) -> bool:
    return case.scene is not None and case.hybrid is None


def _acceleration(engine: Engine, on: Sequence[Case]) -> Scenes:
    chosen = [case.rounded() for case in on if _smooth(case)]
    return {case.id: (case.scene, partial(_on_case, engine, case)) for case in chosen if case.scene is not None}


def _on_case(engine: Engine, case: Case) -> tuple[float, float, str]:
    problem, form = problem_of(case, (SceneForm,)), next(found for found in map(first_order, case.all_forms()) if found)
    assert isinstance(problem.form, SceneForm)
    chosen = np.random.default_rng(0).choice(case.times, STATES, replace=False)
    t0 = float(chosen[0]) if "time_force" in problem.form.needs else 0.0
    parameters = tuple(map(float, case.parameter_values()))

    def rates(t: float, y: Floats) -> Floats:
        return np.array(form.equations(t, tuple(y.tolist()), parameters), dtype=float)

    groups = [[i for i, each in enumerate(problem.groups) if each == group] for group in dict.fromkeys(problem.groups)]
    angles = [coordinate.kind == "angle" for coordinate in case.state]
    starts = case.sample(np.sort(chosen))
    return rate_error(
        engine, replace(problem, t0=t0, time_scale=float(case.fastest_time)), rates, starts, groups, angles
    )


def rate_error(
    engine: Engine,
    problem: Problem,
    rates: Rates,
    starts: Floats,
    groups: Sequence[Sequence[int]],
    angles: Sequence[bool] | None = None,
) -> tuple[float, float, str]:
    """The largest error of the rates of change, relative to their size in a group of coordinates, over its bound.

    `angles`: the coordinates whose whole turns are ignored. The text `acceleration` of `TEXTS` has the bound.
    """
    longest = problem.time_scale * 2.0 ** -(engine.bits // 4)
    estimates = []
    for step in (longest, longest / 2, longest / 4):
        change = engine.run(replace(problem, times=np.array([problem.t0 + step])), starts, step)[:, 0] - starts
        if angles is not None:
            change[:, angles] = np.remainder(change[:, angles] + np.pi, 2 * np.pi) - np.pi
        estimates.append(change / step)
    coarse, fine = 2 * estimates[1] - estimates[0], 2 * estimates[2] - estimates[1]
    expected = np.array([rates(problem.t0, start) for start in starts])
    worst = -1.0, 0.0, 0.0, ""
    for members in map(list, groups):
        largest = np.max(np.linalg.norm(starts[:, members], axis=1))
        size = np.maximum(np.linalg.norm(expected[:, members], axis=1), largest / problem.time_scale)
        size[size == 0] = 1.0
        spread = np.linalg.norm((fine - coarse)[:, members], axis=1) / size
        error = np.linalg.norm((fine - expected)[:, members], axis=1) / size
        bound = spread + 10 * engine.rounding * largest / (longest * size)
        for each, most, unsettled in zip(error.tolist(), bound.tolist(), spread.tolist(), strict=True):
            if unsettled > UNSETTLED:
                judged = unsettled, UNSETTLED, "difference of the rates from steps of h/2 and h/4, relative"
            else:
                judged = each, most, "error of the rates of change, relative"
            # Numbers that are not finite are worst, and 0 / 0 is right.
            quotient = judged[0] / max(judged[1], TINY) if math.isfinite(judged[0]) else math.inf
            worst = max(worst, (quotient, *judged))
    return worst[1:]


def _free(form: SceneForm, engine: Engine, start: Floats, steps: int, step: float) -> Floats:
    """The state of a free body after some steps."""
    found: Floats = engine.solve(form, [start], [steps * step], step)[0, 0]
    return found


def _relative(found: Floats, expected: Floats) -> float:
    return float(np.linalg.norm(found - expected) / np.linalg.norm(expected))


def _drift(engine: Engine) -> Scenes:
    start = state(velocity=(1.0, -2.0, 3.0), spin=(0.0, 0.0, 1.5))

    def kept(form: SceneForm, part: slice, what: str) -> tuple[float, float, str]:
        end = _free(form, engine, start, 100, 2.0**-7)
        return _relative(end[part], start[part]), 100 * engine.rounding, f"change of {what} over 100 steps, relative"

    return {
        "moving_body": (AT_REST, partial(kept, AT_REST, VELOCITY, "velocity")),
        "spinning_body": (TUMBLING, partial(kept, TUMBLING, SPIN, "spin")),
    }


def _moves(engine: Engine, speed: float, steps: int, step: float) -> tuple[float, float, str]:
    start = state(velocity=speed * np.array([1.0, -2.0, 2.0]) / 3)
    end = _free(AT_REST, engine, start, steps, step)
    error = max(_relative(end[VELOCITY], start[VELOCITY]), _relative(end[POSITION], steps * step * start[VELOCITY]))
    return error, steps * engine.rounding, "error of velocity or path, relative"


def _spins(engine: Engine, rate: float, steps: int, step: float) -> tuple[float, float, str]:
    start = state(spin=(0.0, 0.0, rate))
    end = _free(TUMBLING, engine, start, steps, step)
    return _relative(end[SPIN], start[SPIN]), steps * engine.rounding, "change of spin, relative"


def _turns(engine: Engine, rate: float, steps: int, step: float) -> tuple[float, float, str]:
    quaternion = _free(TUMBLING, engine, state(spin=(0.0, 0.0, rate)), steps, step)[ATTITUDE]
    angle = 2 * math.atan2(float(np.linalg.norm(quaternion[:3])), abs(float(quaternion[3])))
    wanted = rate * steps * step
    return abs(angle / wanted - 1), rate * step + steps * engine.rounding, "error of the angle, relative"


def _clamp(engine: Engine) -> Scenes:
    return {
        "speed_1e3": (AT_REST, partial(_moves, engine, 1e3, 4, 2.0**-7)),
        "speed_1e4": (AT_REST, partial(_moves, engine, 1e4, 4, 2.0**-7)),
        "spin_1e3": (TUMBLING, partial(_spins, engine, 1e3, 4, 1e-4)),
        "turn_1e3": (TUMBLING, partial(_turns, engine, 1e3, 4, 1e-4)),
    }


def _sleep(engine: Engine) -> Scenes:
    return {
        "slow_body": (AT_REST, partial(_moves, engine, 1e-6, 320, 2.0**-6)),
        "slow_spin": (TUMBLING, partial(_spins, engine, 1e-6, 320, 2.0**-6)),
        "slow_turn": (TUMBLING, partial(_turns, engine, 1e-6, 320, 2.0**-6)),
    }


def _problem(form: SceneForm, dimension: int) -> Problem:
    return Problem(form, dimension, np.empty(0), np.array([1.0]), 1.0)


def _spin_rates(engine: Engine, starts: Sequence[Floats]) -> tuple[float, float, str]:
    spin = list(range(13))[SPIN]
    return rate_error(engine, _problem(TUMBLING, 13), tumbling_rates, np.array(starts), [spin])


def _gyroscopic_term(engine: Engine) -> Scenes:
    starts = [state(spin=spin) for spin in np.random.default_rng(0).uniform(-2, 2, (STATES, 3))]
    return {"body_along_the_axes": (TUMBLING, partial(_spin_rates, engine, starts))}


def _inertia_frame(engine: Engine) -> Scenes:
    """The columns of a rotation matrix are the body's axes in space."""
    turn = np.array(matrix(tuple(state(attitude=TURNED)[ATTITUDE].tolist()))).reshape(3, 3)  # type: ignore[arg-type]
    starts = [state(attitude=TURNED, spin=1.5 * axis) for axis in turn.T]
    return {"turned_body": (TUMBLING, partial(_spin_rates, engine, starts))}


def _joint_axes(engine: Engine) -> Scenes:
    starts = np.random.default_rng(0).uniform(-2, 2, (STATES, 2))
    found: Scenes = {}
    for axis, name in enumerate("xyz"):
        gravity = (GRAVITY * (axis == 0), GRAVITY * (axis == 1), GRAVITY * (axis == 2))
        for kind, (form, rates) in {"hinge": oblique_hinge(gravity), "slider": oblique_slider(gravity)}.items():
            found[f"{kind}_gravity_{name}"] = (
                form, partial(rate_error, engine, _problem(form, 2), rates, starts, [[0], [1]], [kind == "hinge", False]),
            )  # fmt: skip
    return found


def _along(found: Floats, like: Floats) -> Floats:
    """A state of a free body with the sign of the quaternion that is nearer to another state's: both are one attitude."""
    sign = np.ones(13)
    sign[ATTITUDE] = math.copysign(1.0, float(found[ATTITUDE] @ like[ATTITUDE]))
    return sign * found


def _distance(found: Floats, exact: Floats, part: list[int]) -> float:
    return float(np.linalg.norm((_along(found, exact) - exact)[part]))


def _first_step(engine: Engine) -> Scenes:
    h = 2.0**-8

    def compared(form: SceneForm, rates: Rates, start: Floats, part: list[int]) -> tuple[float, float, str]:
        one, two = engine.solve(form, [start], [h, 2 * h], h)[0]
        if part == POINT:
            one = np.where(np.isin(range(13), POINT), one, start)
        errors = [_distance(end, flow(rates, begin, h, 16), part) for begin, end in ((start, one), (one, two))]
        size = float(np.linalg.norm(start[part]))
        return errors[0] / size, 2 * errors[1] / size + 2 * engine.rounding, "error of the first step, relative"

    return {name: (found[0], partial(compared, *found)) for name, found in SMOOTH.items()}


@cache
def _exact(name: str, steps: int) -> Floats:
    """The state of a smooth scene after 1 s, with this number of steps."""
    _, rates, start, _ = SMOOTH[name]
    return flow(rates, start, 1.0, steps)


def _declared_order(engine: Engine) -> Scenes:
    def falls(name: str) -> tuple[float, float, str]:
        form, _, start, part = SMOOTH[name]
        order = engine.integrator.order
        if order is None:
            raise Refused("it declares no order")
        exact = _exact(name, 512)
        size = float(np.linalg.norm(exact[part]))
        own = _distance(_exact(name, 256), exact, part) / size
        coarse, fine = (_distance(_free(form, engine, start, n, 1 / n), exact, part) / size for n in (128, 256))
        bound = max(coarse * 2.0 ** (0.5 - order), 20 * (256 * engine.rounding + own))
        return fine, bound, f"error after 256 steps, relative ({coarse:.2g} after 128 steps)"

    return {name: (found[0], partial(falls, name)) for name, found in SMOOTH.items()}


def _restitution(engine: Engine) -> Scenes:
    def bounced(form: SceneForm, e: float, speed: float) -> tuple[float, float, str]:
        start = state((0.0, 0.0, 2 * RADIUS), velocity=(0.0, 0.0, -speed))
        fall = RADIUS / speed
        end = engine.solve(form, [start], [2 * fall], fall / 256)[0, 0]
        left = float(end[VELOCITY][2]) / speed
        return abs(left - e), 1 / 256, f"error of the speed after impact over the speed before it, which is {left:.4g}"

    return {
        f"{kind}_ball_e_{e:g}": (form, partial(bounced, form, e, speed))
        for e in (0.0, 0.5, 1.0)
        for form in [ball(e)]
        for kind, speed in (("fast", 1.0), ("slow", 2.0**-6))
    }


def _friction(engine: Engine) -> Scenes:
    friction, speed, time, steps = 0.5, 4.0, 0.5, 256
    form, lost = box(friction), friction * GRAVITY * time

    def slid(angle: float) -> tuple[float, float, str]:
        along = np.array([math.cos(angle), math.sin(angle), 0.0])
        start = state((0.0, 0.0, RADIUS), velocity=speed * along)
        end = _free(form, engine, start, steps, time / steps)
        error = float(np.linalg.norm(end[VELOCITY] - (speed - lost) * along))
        return (
            error / lost,
            2 / steps,
            f"error of the velocity over mu g t; it lost {speed - float(end[VELOCITY] @ along):.4g} of {lost:.4g} m/s",
        )

    return {f"box_at_{degrees}_degrees": (form, partial(slid, math.radians(degrees))) for degrees in (0, 45)}


def _same_bits(engine: Engine) -> Scenes:
    def again(form: SceneForm, start: Floats, other: Floats) -> tuple[float, float, str]:
        problem = replace(_problem(form, len(start)), times=np.array([0.25, 0.5]))
        step = 2.0**-8

        def solve(solver: Solver, begin: Floats) -> Floats:
            if solver.reset is not None:
                solver.reset()
            return solver(begin[None]).states

        solver = solver_of(engine.integrator, problem, step)
        try:
            first = solve(solver, start)
            found = {"in a second solve": solve(solver, start)}
            solve(solver, other)
            found["after another solve"] = solve(solver, start)
            found["in a new world"] = engine.run(problem, [start], step)
        finally:
            solver.close()
        for when, states in found.items():
            if not np.array_equal(first, states, equal_nan=True):
                return float(np.max(np.abs(states - first))), 0.0, f"largest difference {when}"
        return 0.0, 0.0, "largest difference"

    tilted, _ = oblique_hinge((0.0, 0.0, -GRAVITY))
    landing = state((0.0, 0.0, 2 * RADIUS), velocity=(0.25, 0.0, -1.0))
    sliding = state((0.0, 0.0, RADIUS), velocity=(4.0, 1.0, 0.0))
    scenes = {
        **{name: (form, start) for name, (form, _, start, _) in SMOOTH.items()},
        "ball": (ball(0.5), landing),
        "box": (box(0.5), sliding),
        "hinge": (tilted, np.array([0.5, 1.0])),
    }
    return {name: (form, partial(again, form, start, _other(start))) for name, (form, start) in scenes.items()}


def _other(start: Floats) -> Floats:
    """A start with twice the rates."""
    found = start.copy()
    found[len(start) // 2 + len(start) % 2 :] *= 2
    return found


ACCELERATION = "acceleration"
CHECKS: dict[str, Callable[[Engine], Scenes]] = {
    "same_bits": _same_bits,
    "drift": _drift,
    "clamp": _clamp,
    "sleep": _sleep,
    "gyroscopic_term": _gyroscopic_term,
    "inertia_frame": _inertia_frame,
    "joint_axes": _joint_axes,
    "first_step": _first_step,
    "declared_order": _declared_order,
    "restitution": _restitution,
    "friction": _friction,
}
"""The scenes of each pre-flight but `acceleration`, whose scenes are cases."""

"""The pre-flights on small scenes of their own: `CHECKS` has the scenes of each, with what is measured."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import groupby, pairwise
from typing import Any

import numpy as np
from gnomon.cases.core.scene import SceneForm
from gnomon.cases.scenes.attitude import matrix
from gnomon.harness.contract.integrator import Floats, Problem, Refused, Solver, solver_of
from gnomon.harness.studies.conventions import conventions, explain_reading, free_body_error, with_turning
from gnomon.harness.studies.preflight_rates import STATES, Engine, rate_error
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

Measure = Callable[[], tuple[float, float, str]]
"""Gives the number measured, its bound, and what the number is."""
Scenes = dict[str, tuple[SceneForm, Measure]]


def _free(form: SceneForm, engine: Engine, start: Floats, steps: int, step: float) -> Floats:
    """The state of a free body after some steps."""
    end: Floats = engine.solve(form, [start], [steps * step], step)[0, 0]
    return end


def _relative(computed: Floats, expected: Floats) -> float:
    return float(np.linalg.norm(computed - expected) / np.linalg.norm(expected))


def _drift(engine: Engine) -> Scenes:
    start = state(velocity=(1.0, -2.0, 3.0), spin=(0.0, 0.0, 1.5))

    def change(form: SceneForm, part: slice, what: str) -> tuple[float, float, str]:
        end = _free(form, engine, start, 100, 2.0**-7)
        return _relative(end[part], start[part]), 100 * engine.rounding, f"change of {what} over 100 steps, relative"

    return {
        "moving_body": (AT_REST, partial(change, AT_REST, VELOCITY, "velocity")),
        "spinning_body": (TUMBLING, partial(change, TUMBLING, SPIN, "spin")),
    }


LOST = 2.0**-10
"""A limit or a switch takes a large share of a velocity; what is smaller, `drift` measures. Engines that hold positions far
from their origin round the path by more than its own ulps."""


def _moves(engine: Engine, speed: float, steps: int, step: float) -> tuple[float, float, str]:
    start = state(velocity=speed * np.array([1.0, -2.0, 2.0]) / 3)
    end = _free(AT_REST, engine, start, steps, step)
    error = max(_relative(end[VELOCITY], start[VELOCITY]), _relative(end[POSITION], steps * step * start[VELOCITY]))
    return error, max(LOST, steps * engine.rounding), "error of velocity or path, relative"


def _spins(engine: Engine, rate: float, steps: int, step: float) -> tuple[float, float, str]:
    start = state(spin=(0.0, 0.0, rate))
    end = _free(TUMBLING, engine, start, steps, step)
    return _relative(end[SPIN], start[SPIN]), max(LOST, steps * engine.rounding), "change of spin, relative"


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
    return rate_error(engine, _problem(TUMBLING, 13), tumbling_rates, np.array(starts), [list(range(13))[SPIN]])


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
    scenes: Scenes = {}
    for axis, name in enumerate("xyz"):
        gravity = (GRAVITY * (axis == 0), GRAVITY * (axis == 1), GRAVITY * (axis == 2))
        for kind, (form, rates) in {"hinge": oblique_hinge(gravity), "slider": oblique_slider(gravity)}.items():
            scenes[f"{kind}_gravity_{name}"] = (
                form, partial(rate_error, engine, _problem(form, 2), rates, starts, [[0], [1]], [kind == "hinge", False]),
            )  # fmt: skip
    return scenes


def _along(computed: Floats, like: Floats) -> Floats:
    """A state of a free body with the sign of the quaternion that is nearer to another state's: both are one attitude."""
    sign = np.ones(13)
    sign[ATTITUDE] = math.copysign(1.0, float(computed[ATTITUDE] @ like[ATTITUDE]))
    return sign * computed


def _distance(computed: Floats, exact: Floats, part: list[int]) -> float:
    return float(np.linalg.norm((_along(computed, exact) - exact)[part]))


def _first_step(engine: Engine) -> Scenes:
    h = 2.0**-8

    def compared(form: SceneForm, rates: Rates, start: Floats, part: list[int]) -> tuple[float, float, str]:
        once, twice = engine.solve(form, [start], [h, 2 * h], h)[0]
        if part == POINT:
            once = np.where(np.isin(range(13), POINT), once, start)
        errors = [_distance(end, flow(rates, begin, h, 16), part) for begin, end in ((start, once), (once, twice))]
        size = float(np.linalg.norm(start[part]))
        return errors[0] / size, 2 * errors[1] / size + 2 * engine.rounding, "error of the first step, relative"

    return {name: (scene[0], partial(compared, *scene)) for name, scene in SMOOTH.items()}


@cache
def _exact(name: str, steps: int) -> Floats:
    """The state of a smooth scene after 1 s, with this number of steps."""
    _, rates, start, _ = SMOOTH[name]
    return flow(rates, start, 1.0, steps)


def _check_declared_order(engine: Engine) -> Scenes:
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

    return {name: (scene[0], partial(falls, name)) for name, scene in SMOOTH.items()}


SPEEDS = tuple(2.0**k for k in range(-6, 6))
"""Speeds of impact, 1/64 to 32 m/s: they are exact in binary32, and from 0.1 to 30 m/s no gap is longer than a factor 2."""
NARROWED = 7
"""Times that the gap between a kept speed and one that is not is halved: a threshold is found to 2^(2^-7) - 1 = 0.5 %."""
BOUNCE = 1 / 256
"""The largest error of a speed after impact over the speed before it."""


def _restitution(engine: Engine) -> Scenes:
    def leave(form: SceneForm, speed: float) -> float:
        """The speed after an impact over the speed before it."""
        start = state((0.0, 0.0, 1.5 * RADIUS), velocity=(0.0, 0.0, -speed))
        step = RADIUS / speed / 256
        return float(_free(form, engine, start, 384, step)[VELOCITY][2]) / speed

    def bounced(form: SceneForm, e: float) -> tuple[float, float, str]:
        left = {speed: leave(form, speed) for speed in SPEEDS}
        for slow, fast in pairwise(SPEEDS):
            if _keeps(left[slow], e) != _keeps(left[fast], e):
                for _ in range(NARROWED):
                    middle = math.sqrt(slow * fast)
                    left[middle] = leave(form, middle)
                    slow, fast = (middle, fast) if _keeps(left[middle], e) == _keeps(left[slow], e) else (slow, middle)
        errors = [abs(each - e) for each in left.values()]
        worst = max(errors, key=lambda error: math.inf if math.isnan(error) else error)
        return worst, BOUNCE, f"error of the speed after impact over the speed before it: {name_thresholds(left, e)}"

    return {f"ball_e_{e:g}": (form, partial(bounced, form, e)) for e in (0.0, 0.5, 1.0) for form in [ball(e)]}


def _keeps(left: float, e: float) -> bool:
    return abs(left - e) <= BOUNCE


def name_thresholds(left: Mapping[float, float], e: float) -> str:
    """The speeds at which a coefficient of restitution is kept, and the behaviour of the ball at the others.

    `left`: for each speed of impact the speed after it over the speed before it.

    >>> name_thresholds({0.1: 0.0, 0.2: 0.0, 0.4: 0.5, 0.8: 0.5}, 0.5)
    'e = 0.5 is kept from 0.4 m/s on; below it the ball does not rebound (an engine may document such a threshold)'
    >>> name_thresholds({0.1: 0.5, 0.2: 0.5, 0.4: 0.25}, 0.5)
    'e = 0.5 is kept up to 0.2 m/s; above it the ball has 0.25 of its speed after the impact'
    """
    runs = [(keeps, list(speeds)) for keeps, speeds in groupby(sorted(left), key=lambda speed: _keeps(left[speed], e))]
    if len(runs) == 1:
        tried = f"kept from {min(left):.2g} to {max(left):.2g} m/s"
        return f"e = {e:g} is {tried if runs[0][0] else f'not {tried}: the ball {_behaviour(list(left.values()))}'}"
    ranges, rest = [], ""
    for place, (keeps, speeds) in enumerate(runs):
        first, last = place == 0, place == len(runs) - 1
        if keeps:
            low, high = f"{speeds[0]:.2g}", f"{speeds[-1]:.2g}"
            ranges.append(
                f"up to {high} m/s" if first else f"from {low} m/s on" if last else f"from {low} to {high} m/s"
            )
        else:
            where = "below it" if first else "above it" if last else "between"
            rest += f"; {where} the ball {_behaviour([left[speed] for speed in speeds])}"
    bounces_fast = runs[-1][0] and not runs[0][0]
    return (
        f"e = {e:g} is kept {' and '.join(ranges)}{rest}" + " (an engine may document such a threshold)" * bounces_fast
    )


def _behaviour(left: Sequence[float]) -> str:
    """What a ball does that keeps these shares of its speed; below 0 it goes on towards the plane."""
    least, most = min(left), max(left)
    if not all(map(math.isfinite, left)):
        return "has a speed that is not finite"
    if most < -BOUNCE:
        return "is not stopped"
    if max(abs(least), abs(most)) <= BOUNCE:
        return "does not rebound"
    low, high = f"{least:.4g}", f"{most:.4g}"
    return f"has {low if low == high else f'{low} to {high}'} of its speed after the impact"


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
            solutions = {"in a second solve": solve(solver, start)}
            solve(solver, other)
            solutions["after another solve"] = solve(solver, start)
            solutions["in a new world"] = engine.run(problem, [start], step)
        finally:
            solver.close()
        for when, states in solutions.items():
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
    other = start.copy()
    other[len(start) // 2 + len(start) % 2 :] *= 2
    return other


FIRST_STEP = 2.0**-8
SOON = 0.5
"""The largest error of the first step, as a share of its change."""
UNEXPLAINED = ("difference from the start right after load, relative", "error of the first step over its change")
"""The numbers of `start`, where no convention explains them."""


def _start(engine: Engine) -> Scenes:
    """Readings right after `load`, from engines that have them apart from a step, then the first step of a turned body."""
    turned = state((0.5, -0.25, 1.0), TURNED, (1.0, 0.5, -2.0), (1.0, -0.5, 1.5))

    def read(form: SceneForm, start: Floats, part: list[int]) -> tuple[float, float, str]:
        reader: Any = engine.integrator  # an engine that has readings
        readings: Floats = np.array(reader.read_start(form, start), dtype=np.float64)
        error = _apart(readings[None], start[None], part)
        text = explain_reading(readings[None], start[None]) if len(part) == 13 else ""
        return error, 2.0 ** -(engine.bits // 2), text or UNEXPLAINED[0]

    def first(form: SceneForm) -> tuple[float, float, str]:
        exact = np.array([flow(tumbling_rates, turned, n * FIRST_STEP, 16) for n in (1, 2)])

        def solve(start: Floats) -> Floats:
            states: Floats = engine.solve(form, [start], [FIRST_STEP, 2 * FIRST_STEP], FIRST_STEP)[0]
            return states

        readings = solve(turned)
        error = _apart_in_a_step(readings[0], exact[0], turned)
        text = "" if error <= SOON else _explain_step(solve, readings, exact, turned)
        return error, SOON, text or UNEXPLAINED[1]

    hinge, slider = oblique_hinge((0.0, 0.0, 0.0))[0], oblique_slider((0.0, 0.0, 0.0))[0]
    at = {
        "turned_body": (TUMBLING, turned, list(range(13))),
        "moving_body": (AT_REST, turned, POINT),
        "hinge": (hinge, np.array([0.5, 1.0]), [0, 1]),
        "slider": (slider, np.array([0.5, 1.0]), [0, 1]),
    }
    scenes: Scenes = {}
    if hasattr(engine.integrator, "read_start"):
        scenes |= {name: (form, partial(read, form, start, part)) for name, (form, start, part) in at.items()}
    return scenes | {"first_step_of_a_turned_body": (TUMBLING, partial(first, TUMBLING))}


def _apart(readings: Floats, exact: Floats, part: list[int]) -> float:
    """The largest relative difference of a quantity of a free body, or of the state of a joint."""
    if len(exact[0]) == 13:
        return free_body_error(
            readings, exact, [group for group in (POSITION, ATTITUDE, VELOCITY, SPIN) if group.start in part]
        )
    return float(np.max(np.abs(readings - exact) / np.abs(exact)))


def _apart_in_a_step(readings: Floats, exact: Floats, start: Floats) -> float:
    """The error of a step: of position and attitude over their change, of the velocities over their size."""
    readings = _along(readings, exact)
    shares = [
        float(np.linalg.norm((readings - exact)[part]) / np.linalg.norm((exact - start)[part]))
        for part in (POSITION, ATTITUDE)
    ]
    error = float(max(*shares, _relative(readings[VELOCITY], exact[VELOCITY]), _relative(readings[SPIN], exact[SPIN])))
    return math.inf if math.isnan(error) else error


def _explain_step(solve: Callable[[Floats], Floats], readings: Floats, exact: Floats, start: Floats) -> str:
    """A convention that explains the first steps: of the readings, of start and readings, or of their time."""
    if _apart_in_a_step(readings[1], exact[0], start) <= SOON:
        return "readings are one step late: read the state after the step"
    reading = explain_reading(readings, exact)
    if reading:
        return reading
    for convention in conventions():
        begin = with_turning(start[None], convention.apply)[0]
        if _apart_in_a_step(with_turning(solve(begin), convention.undo)[0], exact[0], start) <= SOON:
            return f"at load and in readings, {convention.text}"
    return ""


CHECKS: dict[str, Callable[[Engine], Scenes]] = {
    "start": _start,
    "same_bits": _same_bits,
    "drift": _drift,
    "clamp": _clamp,
    "sleep": _sleep,
    "gyroscopic_term": _gyroscopic_term,
    "inertia_frame": _inertia_frame,
    "joint_axes": _joint_axes,
    "first_step": _first_step,
    "declared_order": _check_declared_order,
    "restitution": _restitution,
    "friction": _friction,
}
"""The scenes of each pre-flight but `acceleration`, whose scenes are cases."""

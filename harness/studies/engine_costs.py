"""What a step of a physics engine costs and what it keeps: time by part, memory of a world, growth, the same bits.

A step is divided by differences: all steps in one call; the same scene without its forces; one call a step; one reading
a step. Forces count as Python's if their steps enter a function of Python that the others do not. Everything is measured on one scene with one step size, in a process of its own.
"""

import contextlib
import gc
import math
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np
from gnomon.cases.core.case import Case
from gnomon.cases.core.registry import get
from gnomon.cases.core.scene import Readings, Scene, SceneForm
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator, World
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.measuring.solved import solve_within

SCENES = ("spring_pendulum", "pendulum_simple/engines", "projectile_parabola/engines")
"""The first of these that an engine runs: with a force that depends on position, with a joint, or without both."""
STEP, STEPS = 1e-3, 1000
"""The step (s), and the number of steps that are timed together."""
BATCHES = 5
"""Batches of which the fastest counts: other processes only add to the time."""
WORLDS, IN_A_ROW = 20, 200
HOUR, HOUR_STEP = 3600.0, 0.01
"""Seconds over which the energy of the pendulum is followed, and the step."""


def costs(integrator: SceneIntegrator) -> dict[str, Any]:
    """A row for an engine, driven in one way; with `reason` in place of numbers if it runs none of the scenes."""
    row: dict[str, Any] = {"integrator": integrator.id}
    for name, case, form in _scenes(integrator):
        try:
            return row | {"scene": name} | _measure(integrator, case, form)
        except Refused as error:
            row["reason"] = str(error)
    return {"reason": "it runs none of the scenes"} | row


def is_same_in_threads(integrator: SceneIntegrator) -> bool:
    """Whether two worlds that run in two threads give the bits of one alone; the process may end in the attempt."""
    _, case, form = next(_scenes(integrator))
    scene = _scene(case, form)
    return _is_same(integrator, form, scene, _run(integrator, form, scene))


def _scenes(integrator: SceneIntegrator) -> Iterator[tuple[str, Case, SceneForm]]:
    """The scenes whose tokens an engine has."""
    for name in SCENES:
        case = get(*name.split("/")).rounded()
        if case.scene is not None and integrator.unsupported(case.scene) is None:
            yield name, case, case.scene


def _measure(integrator: SceneIntegrator, case: Case, form: SceneForm) -> dict[str, Any]:
    """The costs of an engine's way on one scene: times of a step, of a call and of a reading, memory, equal bits."""
    scene = _scene(case, form)
    # First, as later worlds would take memory that is free again.
    world_kilobytes = _world_kilobytes(integrator, form, scene)
    first = _run(integrator, form, scene)
    worlds = [_place(integrator, form, scene) for _ in range(2)]
    together = _least(lambda: worlds[0].advance(STEPS))
    single = _least(lambda: _singly(worlds[0]))
    read = _least(lambda: [worlds[0].read() for _ in range(STEPS)])
    bare = worlds[1] if scene.forces else worlds[0]
    if scene.forces:
        bare.build(replace(_scene(case, form), forces=()))
        bare.place(replace(scene, forces=()))
    engine = _least(lambda: bare.advance(STEPS))
    in_python = _python_calls(worlds[0]) - _python_calls(bare) >= STEPS
    for world in worlds:
        world.close()
    return {
        "step_us": 1e6 * together,
        "engine_us": 1e6 * engine,
        "forces_us": 1e6 * max(0.0, together - engine) if scene.forces else None,
        "python_share": max(0.0, 1 - engine / together) * in_python if scene.forces else None,
        "call_us": 1e6 * max(0.0, single - together),
        "read_us": 1e6 * read,
        "world_kilobytes": _if_known(world_kilobytes),
        "grown_kilobytes": _if_known(_measure_growth(integrator, form, scene)),
        "same_bits": {
            "in a new world": _run(integrator, form, scene) == first,
            "with another world beside it": _run_beside_another(integrator, form, scene) == first,
        },
        "energy_an_hour": _energy_an_hour(integrator),
    }


def _scene(case: Case, form: SceneForm) -> Scene:
    return form.build(tuple(map(float, case.initial_state)), tuple(map(float, case.parameter_values())))


def _place(integrator: SceneIntegrator, form: SceneForm, scene: Scene) -> World:
    """A new world with the bodies of the scene at their start."""
    world = integrator.world(form, STEP)
    world.build(scene)
    world.place(scene)
    return world


def _run(integrator: SceneIntegrator, form: SceneForm, scene: Scene) -> Readings:
    """The readings of a new world after STEPS steps."""
    world = _place(integrator, form, scene)
    for _ in range(STEPS // 10):
        world.advance(10)
    readings = world.read()
    world.close()
    return readings


def _run_beside_another(integrator: SceneIntegrator, form: SceneForm, scene: Scene) -> Readings:
    """The readings of a world after STEPS steps, in turn with the steps of a second world in the same process."""
    world, second = (_place(integrator, form, scene) for _ in range(2))
    for _ in range(STEPS // 10):
        second.advance(3)
        world.advance(10)
    readings = world.read()
    world.close()
    second.close()
    return readings


def _is_same(integrator: SceneIntegrator, form: SceneForm, scene: Scene, first: Readings) -> bool:
    readings: list[Readings] = []

    def call() -> None:
        # Callbacks of an engine that belong to the process may fail: then bits are missing.
        with contextlib.suppress(Exception):
            readings.append(_run(integrator, form, scene))

    threads = [threading.Thread(target=call) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return readings == [first, first]


def _singly(world: World) -> None:
    for _ in range(STEPS):
        world.advance(1)


def _python_calls(world: World) -> int:
    """The number of functions of Python that a batch of steps enters: an engine that is given compiled forces enters few."""
    calls = 0

    def count(frame: Any, event: str, called: Any) -> None:
        nonlocal calls
        calls += event == "call"

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        world.advance(STEPS)
    finally:
        sys.setprofile(before)
    return calls


def _least(call: Callable[[], object]) -> float:
    """Seconds of a step in the fastest batch."""
    times = []
    for _ in range(BATCHES):
        began = perf_counter()
        call()
        times.append(perf_counter() - began)
    return min(times) / STEPS


def _world_kilobytes(integrator: SceneIntegrator, form: SceneForm, scene: Scene) -> float:
    """The growth of the process for each of several worlds that are open together, after one."""
    first = _place(integrator, form, scene)
    before = _resident()
    worlds = [_place(integrator, form, scene) for _ in range(WORLDS)]
    after = _resident()
    for world in (first, *worlds):
        world.close()
    return (after - before) / WORLDS


def _measure_growth(integrator: SceneIntegrator, form: SceneForm, scene: Scene) -> float:
    """The growth of the process over worlds that are opened and closed in a row, after as many before."""
    for _ in range(IN_A_ROW):
        _place(integrator, form, scene).close()
    before = _resident()
    for _ in range(IN_A_ROW):
        _place(integrator, form, scene).close()
    return _resident() - before


def _if_known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _resident() -> float:
    """The memory of this process now (kB); nan where the system does not say it."""
    gc.collect()
    try:
        with open("/proc/self/status", encoding="ascii") as file:
            return next(float(line.split()[1]) for line in file if line.startswith("VmRSS:"))
    except OSError:
        return math.nan


def _energy_an_hour(integrator: SceneIntegrator) -> float | None:
    """The largest departure of the pendulum's energy from the start over an hour, over the depth of its potential.

    None if the engine runs no pendulum, or holds it where it was released.
    """
    case = get("pendulum_simple", "engines").rounded()
    problem = problem_of(case, integrator.accepts)
    if integrator.unsupported(problem.form) is not None:
        return None
    problem = replace(problem, times=np.arange(1, 65) * HOUR / 64)
    outcome = solve_within(integrator, problem, HOUR_STEP, initial_state(case)[None], moves=True)
    if outcome.solution is None:
        return None
    parameters = [float(value) for value in case.parameter_values()]
    theta, omega = np.vstack([initial_state(case), outcome.states[0]]).T
    depth = 2 * parameters[0] / parameters[1]
    energy = omega**2 / 2 + parameters[0] / parameters[1] * (1 - np.cos(theta))
    return float(np.max(np.abs(energy - energy[0])) / depth)

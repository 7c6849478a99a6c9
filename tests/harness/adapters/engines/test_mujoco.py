"""MuJoCo reaches the errors of its best known configuration, and models the declared parts of a scene, nothing else.

Errors are absolute, at steps of 1e-2, 1e-3 and 1e-4 s.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from breadth import tenth
from gnomon.cases import Case, get, names
from gnomon.cases.core.scene import TOKENS, Body, Contact, Force, Readings, Scene, SceneForm, Vector
from gnomon.harness.adapters.engines.compliant import damping_ratio, rebound
from gnomon.harness.adapters.engines.mujoco import INTEGRATORS, Euler, EulerAsShipped, ImplicitFast, RungeKutta
from gnomon.harness.adapters.engines.mujoco_world import World
from gnomon.harness.adapters.engines.scene_run import SceneRun
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.contract.problem import initial_state, problem_of

mujoco = pytest.importorskip("mujoco")

STEPS = (1e-2, 1e-3, 1e-4)
SCENES = [case for case in map(get, names()) if case.scene is not None]


@contextmanager
def running(policy: type[Euler], case: Case, dt: float, times: Floats | None = None) -> Iterator[SceneRun]:
    """A prepared run on a case, closed at the end; `times` in place of the case's own."""
    problem = problem_of(case, Euler.accepts)
    if times is not None:
        problem = replace(problem, times=times)
    run = policy().prepare(problem, dt)
    assert isinstance(run, SceneRun)
    try:
        yield run
    finally:
        run.close()


def states(policy: type[Euler], case: Case, dt: float, times: Floats | None = None) -> Floats:
    with running(policy, case, dt, times) as run:
        return run(initial_state(case)[None]).states[0]


def angle_over_the_path(policy: type[Euler], case: Case, dt: float) -> float:
    off = states(policy, case, dt)[:, 0] - case.sample(case.times)[:, 0]
    return float(np.max(np.abs(np.remainder(off + np.pi, 2 * np.pi) - np.pi)))


def angle_at_the_end(policy: type[Euler], case: Case, dt: float) -> float:
    return abs(float(states(policy, case, dt)[-1, 0] - case.sample(case.times[-1:])[0, 0]))


def position_at_the_end(policy: type[Euler], case: Case, dt: float) -> float:
    lengths = [i for i, coordinate in enumerate(case.state) if coordinate.kind == "length"]
    off = states(policy, case, dt)[-1] - case.sample(case.times[-1:])[0]
    return float(np.linalg.norm(off[lengths]))


def attitude_at_the_end(policy: type[Euler], case: Case, dt: float) -> float:
    """The angle of the rotation between two attitudes, |A - B| = 2 sqrt(2) sin(angle/2) in the Frobenius norm."""
    off = states(policy, case, dt)[-1, 3:] - case.sample(case.times[-1:])[0, 3:]
    return 2 * float(np.arcsin(min(np.linalg.norm(off) / 8**0.5, 1.0)))


def axis_at_the_end(policy: type[Euler], case: Case, dt: float) -> float:
    """The distance of the directions of the body's third axis."""
    off = states(policy, case, dt)[-1, [5, 8, 11]] - case.sample(case.times[-1:])[0, [5, 8, 11]]
    return float(np.linalg.norm(off))


def time_of_the_tenth_impact(policy: type[Euler], case: Case, dt: float) -> float:
    """The engine's impact is where its velocity, interpolated over the step in which it turns upward, is zero."""
    times = np.arange(1, round(1.5 * float(case.span) / dt)) * dt  # late impacts included
    v = states(policy, case, dt, times)[:, 1]
    turns = np.nonzero((v[:-1] < 0) & (v[1:] > 0))[0]
    assert len(turns) >= 10
    before = turns[9]
    found = times[before] + dt * v[before] / (v[before] - v[before + 1])
    return abs(float(found - case.events()[9].time))


Measure = Callable[[type[Euler], Case, float], float]
if __name__ == "__main__":
    for policy, name, label, measure in (
        (Euler, "pendulum_simple", "engines", angle_over_the_path), (RungeKutta, "pendulum_simple", "engines", angle_over_the_path),
        (Euler, "euler_top", "engines", attitude_at_the_end), (ImplicitFast, "euler_top", "engines", attitude_at_the_end), (RungeKutta, "euler_top", "engines", attitude_at_the_end),
        (Euler, "lagrange_top_attitude", "engines", axis_at_the_end), (RungeKutta, "lagrange_top_attitude", "engines", axis_at_the_end),
        (Euler, "kepler_orbit", "engines", position_at_the_end), (RungeKutta, "kepler_orbit", "engines", position_at_the_end),
        (Euler, "forced_oscillator", "engines", position_at_the_end), (RungeKutta, "forced_oscillator", "engines", position_at_the_end),
        (Euler, "rotating_pendulum", "engines", angle_at_the_end), (RungeKutta, "rotating_pendulum", "engines", angle_at_the_end),
        (Euler, "charge_in_E_and_B", "engines", position_at_the_end), (RungeKutta, "charge_in_E_and_B", "engines", position_at_the_end),
        (Euler, "block_incline_friction", "engines_stop", position_at_the_end),(Euler, "block_incline_friction", "engines_slide", position_at_the_end),
        (Euler, "block_incline_friction", "engines_stick", position_at_the_end), (EulerAsShipped, "block_incline_friction", "engines_stick", position_at_the_end),
        (Euler, "billiard_ball", "engines", position_at_the_end), (RungeKutta, "billiard_ball", "engines", position_at_the_end),(EulerAsShipped, "billiard_ball", "engines", position_at_the_end),
        (Euler, "bouncing_ball", "engines_e1", time_of_the_tenth_impact), (RungeKutta, "bouncing_ball", "engines_e08", time_of_the_tenth_impact), (Euler, "bouncing_ball", "engines_e08", time_of_the_tenth_impact),
        (Euler, "double_pendulum", "engines", angle_over_the_path), (RungeKutta, "double_pendulum", "engines", angle_over_the_path),
        (Euler, "projectile_stokes_drag", "engines", position_at_the_end), (RungeKutta, "projectile_stokes_drag", "engines", position_at_the_end),
    ):
        found = []
        for dt in STEPS:
            try: found.append("%.2g" % measure(policy, get(name, label).rounded(), dt))
            except Exception as e: found.append(repr(e)[:60])
        print(policy.name, name, label, found, flush=True)

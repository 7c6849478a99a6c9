"""PyBullet: Bullet's rigid bodies, built from scenes. A step is a kick, then a drift: symplectic Euler.

Positions and rates are read through the functions that return doubles (`getLinkState` gives float32 velocities).
"""

from dataclasses import replace
from typing import ClassVar

import numpy as np
from gnomon.cases.core.forms import Form
from gnomon.cases.core.scene import Body, Hinge, Readings, Scene, SceneForm, Slider, Vector
from gnomon.harness.adapters.installed import Installed
from gnomon.harness.adapters.pybullet_world import World
from gnomon.harness.contract.integrator import Floats, Problem, Refused, Solution, Solver, Steps
from gnomon.harness.contract.validation import require_positive


class PyBullet(Installed):
    """PyBullet with every option chosen so that it models the scene and nothing else. Order 1, for charges 2.

    Coumans, pybullet.org.

    Bodies are multibodies in reduced coordinates (Featherstone). Scenes with bouncing bodies are in maximal
    coordinates, as a multibody gains energy at impacts.
    """

    name, library = "stepSimulation", "pybullet"
    order: ClassVar[int | None] = 1
    policy = "configured"
    accepts, sampling, counts_rhs = (SceneForm,), "grid", False
    sweep = Steps(coarsest=0.5, halvings=9)
    tokens: ClassVar[frozenset[str]] = frozenset(
        {
            "hinge",
            "slider",
            "rigid_impact",
            "coulomb_isotropic",
            "gyroscopic",
            "position_force",
            "velocity_force",
            "time_force",
            "mutual_force",
            "body_contact",
        }
    )
    configured: ClassVar[bool] = True
    staggered: ClassVar[bool] = False
    maximal: ClassVar[frozenset[str]] = frozenset({"rigid_impact"})
    """Scenes with one of these tokens are in maximal coordinates."""

    def unsupported(self, form: Form | SceneForm) -> str | None:
        if not isinstance(form, SceneForm):
            return "no scene"
        missing = sorted(form.needs - self.tokens)
        if missing:
            return f"lacks {', '.join(missing)}"
        if self.staggered and not form.conservative:
            return "a staggered start needs accelerations that depend on position alone"
        return None

    def prepare(self, problem: Problem, setting: float) -> Solver:
        require_positive(setting, "step size")
        return Run(self, problem, setting)


class PyBulletStaggered(PyBullet):
    """PyBullet as a leapfrog: its velocities belong to a time half a step before its positions. Order 2.

    It starts from v0 - dt/2 a(q0) and reads v + dt/2 a(q), both from the change of the velocity over one step.
    """

    order, policy, staggered = 2, "staggered", True


class PyBulletMaximal(PyBullet):
    """PyBullet in maximal coordinates for scenes that both kinds of coordinates can model. Order 1.

    Gyroscopic torque is then implicit, and a hinge is a point-to-point constraint.
    """

    policy = "configured, maximal coordinates"
    maximal = frozenset({"gyroscopic", "hinge"})

    def unsupported(self, form: Form | SceneForm) -> str | None:
        if isinstance(form, SceneForm) and not form.needs & self.maximal:
            return "runs hinges and gyroscopic motion only; the rest is as configured"
        if isinstance(form, SceneForm) and "hinge" in form.needs and form.needs & {"position_force", "velocity_force"}:
            return "a force on a hinged body is applied as a torque of its joint, which maximal coordinates lack"
        return super().unsupported(form)


class PyBulletAsShipped(PyBullet):
    """PyBullet with its defaults: only the properties that the scene declares are set.

    It converges to a motion with its damping and its joints' motors, so it has no order against the exact motion.
    """

    policy, configured, order = "as shipped", False, None
    sweep = Steps(coarsest=0.5, halvings=7)  # its errors come from damping and motors: finer steps do not help
    maximal = frozenset()


INTEGRATORS = (PyBullet, PyBulletStaggered, PyBulletMaximal, PyBulletAsShipped)


class Run(Solver):
    """A solver with one world, which it runs from each initial state to the sample times."""

    def __init__(self, policy: PyBullet, problem: Problem, dt: float) -> None:
        import pybullet  # without the library the status is `not_installed`

        problem = problem.since_start()
        if not isinstance(problem.form, SceneForm):
            raise Refused("PyBullet takes scenes only")
        self.form, self.staggered = problem.form, policy.staggered
        self.counts = step_counts(problem.times, dt)
        self.parameters = tuple(map(float, problem.parameters))
        self.at_zero = self.form.build((0.0,) * problem.dimension, self.parameters)
        maximal = bool(self.form.needs & policy.maximal)
        # A staggered start first takes a step for the accelerations, in a separate world, because steps leave state
        # behind.
        self.worlds = [
            World(pybullet, self.form, dt, policy.configured, maximal) for _ in range(2 if self.staggered else 1)
        ]
        self.world = self.worlds[0]
        super().__init__(self._solve, self.world.options, self._rebuild, self._disconnect)
        self._rebuild()

    def _rebuild(self) -> None:
        """Rebuild the worlds: contacts keep state from earlier steps that no function clears."""
        for world in self.worlds:
            world.build(self.at_zero)
        self.fresh = True

    def _disconnect(self) -> None:
        for world in self.worlds:
            world.close()

    def _solve(self, initial_states: Floats) -> Solution:
        states = np.full((len(initial_states), len(self.counts), initial_states.shape[1]), np.nan)
        stopped = None
        for rows, start in zip(states, initial_states, strict=True):
            try:
                self._follow(self.form.build(tuple(map(float, start)), self.parameters), rows)
            except ArithmeticError as error:  # a singularity of a force law
                stopped = f"{type(error).__name__}: {error}"
        return Solution(states, steps=len(states) * self.counts[-1], stopped=stopped)

    def _follow(self, scene: Scene, rows: Floats) -> None:
        if not self.fresh:
            self._rebuild()
        self.fresh = False
        if self.staggered:
            trial = self.worlds[1]
            trial.place(scene)
            start = trial.read()
            trial.advance(1)
            scene = backed_up(scene, start, trial.read())
        world = self.world
        world.place(scene)
        for row, count in zip(rows, self.counts, strict=True):
            world.advance(count - world.steps)
            readings = world.read()
            if self.staggered:
                world.advance(1)
                readings = with_mean_rates(readings, world.read())
            row[:] = self.form.observe(readings, self.parameters)


def step_counts(times: Floats, dt: float) -> list[int]:
    """The number of steps from the start to each time. Raises Refused if a time is not a multiple of the step."""
    counts = np.rint(times / dt)
    # 1e-6 of a step: far above the rounding of times and step, far below any error of order 1.
    if np.any(np.abs(counts * dt - times) > 1e-6 * dt) or np.any(np.diff(counts, prepend=0.0) < 1):
        raise Refused(f"the sample times are not multiples of the step {dt:g} s")
    return [int(count) for count in counts]


def backed_up(scene: Scene, start: Readings, after: Readings) -> Scene:
    """The scene with its rates half a step earlier: v0 - (v1 - v0)/2, where v1 - v0 = dt a(q0)."""

    def rate(joint: Hinge | Slider) -> float:
        return joint.rate - (after.joints[joint.name][1] - start.joints[joint.name][1]) / 2

    def earlier(body: Body) -> Body:
        if body.name not in start.bodies:
            return body
        v0, v1 = start.bodies[body.name][2], after.bodies[body.name][2]
        x, y, z = (v - (b - a) / 2 for v, a, b in zip(body.velocity, v0, v1, strict=True))
        return replace(body, velocity=(x, y, z))

    return replace(
        scene,
        bodies=tuple(earlier(body) for body in scene.bodies),
        hinges=tuple(replace(hinge, rate=rate(hinge)) for hinge in scene.hinges),
        sliders=tuple(replace(slider, rate=rate(slider)) for slider in scene.sliders),
    )


def with_mean_rates(now: Readings, after: Readings) -> Readings:
    """The positions of `now` with the rates at this time: the mean of the rates half a step before and after it."""
    joints = {name: (q, (rate + after.joints[name][1]) / 2) for name, (q, rate) in now.joints.items()}
    bodies = {
        name: (position, attitude, _mean(v, after.bodies[name][2]), _mean(w, after.bodies[name][3]))
        for name, (position, attitude, v, w) in now.bodies.items()
    }
    return Readings(joints, bodies)


def _mean(a: Vector, b: Vector) -> Vector:
    return (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2

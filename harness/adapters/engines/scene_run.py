"""The part of an adapter that all physics engines share: a world is built once, set in a start, advanced and read.

The adapter of an engine writes a `World` and declares a `SceneIntegrator`. Everything that differs between engines is in
these two; nothing of it is in a scene.
"""

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, Protocol

import numpy as np
from gnomon.cases.core.forms import Form
from gnomon.cases.core.scene import TOKENS, Quaternion, Readings, Scene, SceneForm, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN, along
from gnomon.harness.adapters.installed import Installed
from gnomon.harness.contract.integrator import Floats, Problem, Refused, Solution, Solver, Steps, Tolerance
from gnomon.harness.contract.validation import require_positive

TIGHTER = "tighter solver"
"""The policy with `tight`. It runs only the scenes on which the engine iterates, beside "configured" at the same step."""
COARSE = Steps(coarsest=0.5, halvings=2)
"""Its sweep: the difference to "configured" is taken at one step, and ten times the iterations take ten times as long."""

MOTION, LOAD = 13, 6
"""The numbers of a motion: angular velocity, velocity, position, attitude (scalar first). Of a load: force, torque."""


class World(Protocol):
    """A world of an engine, made for one scene form and one step size."""

    @property
    def options(self) -> Mapping[str, Any]:
        """Everything that is set on the engine and differs from its defaults, apart from the step and what the scene declares."""

    def build(self, scene: Scene) -> None:
        """Empty the world and create the bodies, joints, forces and contacts of `scene`; not timed."""

    def place(self, scene: Scene) -> None:
        """Set the initial state of this scene, whose things are the built ones, at t = 0; timed."""

    def advance(self, steps: int) -> None:
        """Take this number of steps."""

    def read(self) -> Readings:
        """The present state: (coordinate, rate) of each joint, pose and velocities of each body without a joint."""

    def close(self) -> None:
        """Free what the engine holds."""


class SceneIntegrator(Installed):
    """A physics engine, driven in one way.

    Attributes
    ----------
    lacks : mapping of str to str
        The tokens of scenes that the engine cannot model, each with what the engine lacks.
    lines : mapping of str to str
        For each option that the adapter records, the line of code that sets it; {} stands for the value, {upper} for it
        in capitals. What the name of an option has in brackets is left out here.
    tight : bool
        Whether iterative solvers have ten times the iterations, for the part of the error that is the solver's.
    bits : int
        The bits of the significand of the engine's numbers: 24 for an engine that computes in binary32.
    """

    accepts, sampling, counts_rhs = (SceneForm,), "grid", False
    policy = "configured"
    sweep: ClassVar[Tolerance | Steps] = Steps(coarsest=0.5, halvings=9)
    lacks: ClassVar[Mapping[str, str]] = {}
    lines: ClassVar[Mapping[str, str]] = {}
    bits: ClassVar[int] = 53
    tight: ClassVar[bool] = False

    @abstractmethod
    def world(self, form: SceneForm, dt: float) -> World:
        """A new world for scenes of this form. Raises ImportError without the library, Refused if it declines the form."""

    def unsupported(self, form: Form | SceneForm) -> str | None:
        return find_unsupported(form, frozenset(TOKENS) - self.lacks.keys(), self.lacks)

    def prepare(self, problem: Problem, setting: float) -> Solver:
        require_positive(setting, "step size")
        return SceneRun(lambda form: self.world(form, setting), problem, setting)


def find_unsupported(form: Form | SceneForm, tokens: frozenset[str], lacks: Mapping[str, str]) -> str | None:
    """The needs of a scene that are not among the tokens, each with the reason that `lacks` has for it."""
    if not isinstance(form, SceneForm):
        return "no scene"
    missing = sorted(form.needs - tokens)
    named = (f"{token} ({lacks[token]})" if token in lacks else token for token in missing)
    return f"lacks {', '.join(named)}" if missing else None


def idle(form: Form | SceneForm, tokens: frozenset[str]) -> str | None:
    """Why a tighter solver does not run a scene: it has none of the tokens on which the engine iterates."""
    return "no iterative solver on this scene" if isinstance(form, SceneForm) and not form.needs & tokens else None


class SceneRun(Solver):
    """A solver with one world, which it runs from each initial state to the sample times."""

    def __init__(self, make: Callable[[SceneForm], World], problem: Problem, dt: float) -> None:
        problem = problem.since_start()
        if not isinstance(problem.form, SceneForm):
            raise Refused("an engine takes scenes only")
        self.form = problem.form
        self.counts = self.count(problem.times, dt)
        self.parameters = tuple(map(float, problem.parameters))
        self.at_zero = self.form.build((0.0,) * problem.dimension, self.parameters)
        self.world = make(self.form)
        super().__init__(self._solve, self.world.options, self._rebuild, self.world.close)
        self._rebuild()

    def count(self, times: Floats, dt: float) -> list[int]:
        """The number that `advance` is given from the start to each time."""
        return step_counts(times, dt)

    def _rebuild(self) -> None:
        """Contacts, warm starts and sleeping bodies keep state from earlier steps: each start has a world built anew."""
        self.world.build(self.at_zero)
        self.fresh = True

    def _solve(self, initial_states: Floats) -> Solution:
        states = np.full((len(initial_states), len(self.counts), initial_states.shape[1]), np.nan)
        stopped = None
        for rows, start in zip(states, initial_states, strict=True):
            if not self.fresh:
                self._rebuild()
            self.fresh = False
            try:
                self._follow(self.form.build(tuple(map(float, start)), self.parameters), rows)
            except ArithmeticError as error:  # a singularity of a force law
                stopped = f"{type(error).__name__}: {error}"
        return Solution(states, steps=len(states) * self.counts[-1], stopped=stopped)

    def _follow(self, scene: Scene, rows: Floats) -> None:
        self.world.place(scene)
        reached = 0
        for row, count in zip(rows, self.counts, strict=True):
            self.world.advance(count - reached)
            reached = count
            row[:] = self.form.observe(self.world.read(), self.parameters)


def step_counts(times: Floats, dt: float) -> list[int]:
    """The number of steps from the start to each time. Raises Refused if a time is not a multiple of the step."""
    counts = np.rint(times / dt)
    # 1e-6 of a step: far above the rounding of times and step, far below any error of order 1.
    if np.any(np.abs(counts * dt - times) > 1e-6 * dt) or np.any(np.diff(counts, prepend=0.0) < 1):
        raise Refused(f"the sample times are not multiples of the step {dt:g} s")
    return [int(count) for count in counts]


def forces_at(
    scene: Scene, t: float, motion: Callable[[str], tuple[Vector, Vector]]
) -> Iterator[tuple[str, Vector, Vector]]:
    """(body, force, position) of each force at time t, also the opposite one on a partner; forces act on centres of mass.

    `motion(body)` gives the position and the velocity of the centre of mass of any body, jointed or free.
    """
    for force in scene.forces:
        place, velocity = motion(force.body)
        if not force.partner:
            yield force.body, force.law(t, place, velocity), place
            continue
        there, other = motion(force.partner)
        pull = force.law(t, along(place, there, -1.0), along(velocity, other, -1.0))
        yield force.body, pull, place
        yield force.partner, along(ORIGIN, pull, -1.0), there


def torques_at(
    scene: Scene, t: float, rotation: Callable[[str], tuple[Quaternion, Vector]]
) -> Iterator[tuple[str, Vector]]:
    """(body, torque) at time t; `rotation(body)` gives attitude and angular velocity."""
    for torque in scene.torques:
        yield torque.body, torque.law(t, *rotation(torque.body))


def loads_of(
    scene: Scene, bodies: tuple[str, ...], t: Any, y: Sequence[Any], in_arithmetic: Callable[[Any], Callable[..., Any]]
) -> list[Any]:
    """Force and torque on each body from the motions of all, in the arithmetic into which `in_arithmetic` takes a law."""
    motions = {name: y[MOTION * k : MOTION * (k + 1)] for k, name in enumerate(bodies)}
    loads: dict[str, list[Any]] = {name: [0.0] * LOAD for name in bodies}
    for force in scene.forces:
        moving = tuple(motions[force.body][3:9])
        if force.partner:
            moving = tuple(a - b for a, b in zip(moving, motions[force.partner][3:9], strict=True))
        for i, value in enumerate(in_arithmetic(force.law)(t, moving[3:], moving[:3])):
            loads[force.body][i] += value
            if force.partner:
                loads[force.partner][i] -= value
    for torque in scene.torques:
        spin, (w, i, j, k) = motions[torque.body][:3], motions[torque.body][9:]
        for n, value in enumerate(in_arithmetic(torque.law)(t, (i, j, k, w), tuple(spin))):
            loads[torque.body][3 + n] += value
    return [value for name in bodies for value in loads[name]]


def impulses_within(scene: Scene, start: float, dt: float) -> Iterator[tuple[str, Vector, Vector]]:
    """(body, linear, angular) of each impulse in the step [start, start + dt)."""
    for impulse in scene.impulses:
        if start <= impulse.time < start + dt:
            yield impulse.body, impulse.linear, impulse.angular

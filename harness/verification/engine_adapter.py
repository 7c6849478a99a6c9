"""The adapter for physics engines that only step: load a scene, step, read. The harness does the rest.

An engine is given a `Scene` (see `cases.core.scene`), which holds the initial state and the force laws. It gets only scenes
whose needs are among the tokens that it declares.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from numbers import Real
from typing import Any, Protocol

from gnomon.cases.core.forms import Form
from gnomon.cases.core.scene import Readings, Scene, SceneForm
from gnomon.harness.adapters.pybullet import step_counts
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solver, Steps, each_start
from gnomon.harness.contract.validation import Unusable, short
from gnomon.harness.registry import declaration
from gnomon.reference.storage.import_closure import closure

POSE = {"position": 3, "quaternion": 4, "velocity": 3, "angular velocity": 3}
"""What is read of a body without a joint, and how many numbers each has."""


class Engine(Protocol):
    """What the adapter drives. A new engine is made for each trial; `load` is called for each initial state."""

    def load(self, scene: Scene) -> None:
        """Discard what was loaded before and build the scene in its initial state, at t = 0."""

    def step(self, dt: float) -> None:
        """Advance by dt (s)."""

    def read(self) -> Readings:
        """The state now: (coordinate, rate) of each joint, and the pose and velocities of each body without a joint."""


class EngineIntegrator(Integrator):
    """An engine as an integrator; `path` is its module and name, `declared` what `from_engine` was given."""

    library = "engine"
    accepts, sampling, counts_rhs = (SceneForm,), "grid", False

    def __init__(self, engine: Callable[[], Engine], path: tuple[str, str], declared: Mapping[str, Any]) -> None:
        self.engine, self.path, self.declared = engine, path, dict(declared)
        self.tokens = frozenset(self.declared["tokens"])
        self.__dict__.update(name=declared["name"], order=declared["order"], sweep=Steps(**declared["sweep"]))
        self.__dict__.update(conserves=tuple(declared["conserves"]))

    def __reduce__(self) -> tuple[Any, ...]:
        return EngineIntegrator, (self.engine, self.path, self.declared)

    def versions(self) -> Mapping[str, Any]:
        """A hash of the sources of the engine's module and of what it imports beside it; "" where it has no file."""
        return {"engine": closure(self.path[0]) or ""}

    def unsupported(self, form: Form | SceneForm) -> str | None:
        missing = sorted(form.needs - self.tokens) if isinstance(form, SceneForm) else ["scenes"]
        return f"lacks {', '.join(missing)}" if missing else None

    def prepare(self, problem: Problem, setting: float) -> Solver:
        problem = problem.since_start()
        form, parameters = problem.form, tuple(map(float, problem.parameters))
        if not isinstance(form, SceneForm):
            raise Refused("an engine takes scenes only")
        counts = step_counts(problem.times, setting)
        engine = self.engine()

        def follow(start: Floats, rows: Floats) -> tuple[int, None]:
            scene = form.build(tuple(map(float, start)), parameters)
            engine.load(scene)
            done = 0
            for row, count in zip(rows, counts, strict=True):
                for _ in range(count - done):
                    engine.step(setting)
                done = count
                row[:] = form.observe(checked(engine.read(), scene), parameters)
            return done, None

        return Solver(each_start(problem, follow))


def from_engine(
    engine: Callable[[], Engine],
    *,
    name: str,
    order: int | None = None,
    tokens: Iterable[str] = (),
    conserves: Iterable[str] = (),
    coarsest: float = 0.5,
    halvings: int = 9,
) -> EngineIntegrator:
    """The integrator that drives `engine`, a class at the top level of a module (or a function there that makes one).

    `tokens`: what the engine can model, as `velocity_force` or `hinge`; a free body under gravity needs none. `conserves`:
    what is claimed to be conserved at any step size, see `Integrator`. The sweep
    starts at steps of `coarsest` time scales and halves them `halvings` times. Raises ValueError for a wrong declaration.
    """
    module, qualified = getattr(engine, "__module__", None), getattr(engine, "__qualname__", "")
    if not isinstance(module, str) or not qualified.isidentifier():
        raise ValueError(f"{short(engine)}: name a class or function at the top level of a module; workers import it")
    declared = {
        "name": name,
        "order": order,
        "tokens": sorted(tokens),
        "conserves": list(conserves),
        "sweep": {"coarsest": coarsest, "halvings": halvings},
    }
    made = EngineIntegrator(engine, (module, qualified), declared)
    declaration.validate(made, f"{module}:{qualified}")
    return made


def checked(readings: Any, scene: Scene) -> Readings:
    """The readings, if they hold every joint and every body without a joint. Raises Unusable for anything else."""
    if not isinstance(readings, Readings):
        raise Unusable(f"read() returned {short(readings)}, not Readings")
    joints = (*scene.joints, *scene.guides)
    jointed = {joint.body for joint in joints}
    for joint in joints:
        _numbers(readings.joints.get(joint.name), 2, f"joints[{joint.name!r}]", "(coordinate, rate)")
    for body in scene.bodies:
        if body.name in jointed:
            continue
        where = f"bodies[{body.name!r}]"
        parts = readings.bodies.get(body.name)
        if not isinstance(parts, tuple | list) or len(parts) != len(POSE):
            raise Unusable(f"read() has {where} = {short(parts)}: it is ({', '.join(POSE)})")
        for part, (name, count) in zip(parts, POSE.items(), strict=True):
            _numbers(part, count, f"{where}, {name},", f"{count} numbers")
    return readings


def _numbers(values: Any, count: int, where: str, rule: str) -> None:
    """Raises Unusable unless these are `count` numbers; nan and inf are numbers, of a motion that diverged."""
    try:
        right = len(values) == count and all(isinstance(x, Real) for x in values)
    except TypeError:
        right = False
    if not right:
        raise Unusable(f"read() has {where} = {short(values)}: it is {rule}")

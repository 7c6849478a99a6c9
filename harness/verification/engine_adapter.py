"""Integrators made of physics engines that can only load a scene, step and read; the harness does the rest.

An engine receives a `Scene` (see `cases.core.scene`) with the initial state and the force laws. It receives only scenes
whose needs are among the tokens that it declares.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from numbers import Real
from typing import Any, Protocol

from gnomon.cases.core.forms import Form
from gnomon.cases.core.scene import Readings, Scene, SceneForm
from gnomon.harness.adapters.engines.scene_run import find_unsupported, step_counts
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solver, Steps, each_start
from gnomon.harness.contract.validation import Unusable, short
from gnomon.harness.registry import declaration
from gnomon.reference.storage.import_closure import closure

POSE = {"position": 3, "quaternion": 4, "velocity": 3, "angular velocity": 3}
"""The quantities read from a body without a joint, each with its number of components."""


class Engine(Protocol):
    """The interface of an engine. A new engine is made for each trial; `load` is called for each initial state."""

    def load(self, scene: Scene) -> None:
        """Discard an earlier scene and build this one in its initial state, at t = 0."""

    def step(self, dt: float) -> None:
        """Advance by dt (s)."""

    def read(self) -> Readings:
        """The present state: (coordinate, rate) of each joint, and pose and velocities of each body without a joint."""


class EngineIntegrator(Integrator):
    """An engine as an integrator. `path`: module and name of the engine; `declared`: the arguments of `from_engine`."""

    library = "engine"
    accepts, sampling, counts_rhs = (SceneForm,), "grid", False

    def __init__(self, engine: Callable[[], Engine], path: tuple[str, str], declared: Mapping[str, Any]) -> None:
        self.engine, self.path, self.declared = engine, path, dict(declared)
        self.tokens, self.bits = frozenset(self.declared["tokens"]), self.declared["bits"]
        self.__dict__.update(name=declared["name"], order=declared["order"], sweep=Steps(**declared["sweep"]))
        self.__dict__.update(conserves=tuple(declared["conserves"]))

    def __reduce__(self) -> tuple[Any, ...]:
        return EngineIntegrator, (self.engine, self.path, self.declared)

    def versions(self) -> Mapping[str, Any]:
        """A hash of the engine's module and of the modules of its folder that it imports; "" if it has no file."""
        return {"engine": closure(self.path[0]) or ""}

    def unsupported(self, form: Form | SceneForm) -> str | None:
        return find_unsupported(form, self.tokens, {})

    def read_start(self, form: SceneForm, start: Floats) -> tuple[float, ...]:
        """The state that the engine reads right after it has loaded a scene without parameters in this start."""
        engine, scene = self.engine(), form.build(tuple(start.tolist()), ())
        engine.load(scene)
        return form.observe(check_readings(engine.read(), scene), ())

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
            steps = 0
            for row, count in zip(rows, counts, strict=True):
                for _ in range(count - steps):
                    engine.step(setting)
                steps = count
                row[:] = form.observe(check_readings(engine.read(), scene), parameters)
            return steps, None

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
    bits: int = 53,
) -> EngineIntegrator:
    """Make an integrator from a physics engine.

    Parameters
    ----------
    engine : callable
        A class with the methods of `Engine`, or a function that makes an instance, at the top level of a module.
    name : str
        The name of the engine.
    order : int, optional
        The order of convergence that the engine claims.
    tokens : iterable of str
        The abilities of the engine, as ``velocity_force`` or ``hinge``; a free body under gravity needs no token.
    conserves : iterable of str
        The properties that hold at any step size, see `Integrator`.
    coarsest : float
        The largest step size, in time scales of the case.
    halvings : int
        The number of times that the sweep halves the largest step size.
    bits : {53, 24}
        The bits of the significand of the engine's numbers: 24 if it computes in binary32.

    Returns
    -------
    EngineIntegrator
        It loads the scene of a case, steps the engine and reads its state at the samples.

    Raises
    ------
    ValueError
        For a wrong declaration, or an engine that workers cannot import.

    Examples
    --------
    >>> class Frozen:
    ...     def load(self, scene): ...
    ...     def step(self, dt): ...
    ...     def read(self): ...
    >>> from_engine(Frozen, name="Frozen", tokens=["hinge"]).id
    'engine:Frozen'
    """
    module, qualified = getattr(engine, "__module__", None), getattr(engine, "__qualname__", "")
    if not isinstance(module, str) or not qualified.isidentifier():
        raise ValueError(f"{short(engine)}: name a class or function at the top level of a module; workers import it")
    if bits not in (53, 24):
        raise ValueError(f"bits = {short(bits)}; it is 53, or 24 for an engine that computes in binary32")
    declared = {
        "name": name,
        "order": order,
        "tokens": sorted(tokens),
        "conserves": list(conserves),
        "sweep": {"coarsest": coarsest, "halvings": halvings},
        "bits": bits,
    }
    integrator = EngineIntegrator(engine, (module, qualified), declared)
    declaration.validate(integrator, f"{module}:{qualified}")
    return integrator


def check_readings(readings: Any, scene: Scene) -> Readings:
    """The readings, if they hold every joint and every body without a joint; else raises Unusable."""
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
    """Raise Unusable unless `values` are `count` numbers. nan and inf are allowed: the motion may have diverged."""
    try:
        right = len(values) == count and all(isinstance(x, Real) for x in values)
    except TypeError:
        right = False
    if not right:
        raise Unusable(f"read() has {where} = {short(values)}: it is {rule}")

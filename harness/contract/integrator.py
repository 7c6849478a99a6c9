"""The contract between the harness and an integrator: what it declares, is given and returns."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from gnomon.cases.core.clock import from_start
from gnomon.cases.core.forms import Form
from gnomon.cases.core.scene import SceneForm
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Refused(Exception):  # noqa: N818 - named for the status that it becomes
    """Raised by an integrator that declines a problem or a setting; the message says why. Status `refused`."""


class Unsupported(Refused):
    """Raised by an integrator that lacks what a problem needs; the message names it. Status `unsupported`."""


@dataclass(frozen=True)
class Tolerance:
    """The setting is a relative tolerance; the sweep goes from `loosest` to `tightest`, `per_decade` settings a decade."""

    loosest: float = 1e-3
    tightest: float = 1e-13
    per_decade: int = 1
    kind: ClassVar[str] = "tolerance"


@dataclass(frozen=True)
class Steps:
    """The setting is a step size: the sampling interval over a power of two.

    The sweep starts at the largest such step not above `coarsest` time scales and halves it `halvings` times.
    """

    coarsest: float = 0.5
    halvings: int = 10
    kind: ClassVar[str] = "step"


@dataclass(frozen=True)
class Names:
    """The names of a problem's numbers, and of its case, for programs in other languages."""

    case: str
    coordinates: tuple[str, ...]
    parameters: tuple[str, ...]


@dataclass(frozen=True)
class Problem:
    """What `prepare` is given: the equations, the parameters, the sample times. Never the initial state.

    `form` is of a type that the integrator accepts. `dimension`: the number of components of the state. `parameters`:
    float64, those of the case. `times`: float64 (64,), the values of the independent variable at the samples, from the
    start on multiples of an exact interval unless the formulation has a clock. `time_scale`: in the units of `times`.
    """

    form: Form | SceneForm
    dimension: int
    parameters: Floats
    times: Floats
    time_scale: float
    counted: bool = False
    """True in the untimed run that counts right-hand sides: the kernels of `gnomon.harness.kernels.equations` then count
    their calls."""
    groups: tuple[int, ...] = ()
    """For each component the index of its group, from 0. The components of a group have one unit and one size, by which
    errors are divided, as in the case's metric. Empty: each component is a group."""
    names: Names | None = None
    """None for a problem that was made without a case."""
    t0: float = 0.0
    """The time of the initial state. Times are absolute: `times`, the t of the equations, and those of events."""

    @property
    def elapsed(self) -> Floats:
        """The times since the start, float64 (64,)."""
        return self.times - self.t0

    @property
    def uniform(self) -> bool:
        """True where the times since the start are exact multiples of `interval` (always, unless the formulation has a
        clock)."""
        elapsed = self.elapsed
        return bool(np.array_equal(elapsed, np.arange(1, len(elapsed) + 1) * elapsed[0]))

    @property
    def interval(self) -> float:
        """The sampling interval; with a clock the mean one, rounded down to 20 bits."""
        elapsed = self.elapsed
        if self.uniform:
            return float(elapsed[0])
        mean = float(elapsed[-1]) / len(elapsed)
        unit = math.ldexp(1.0, math.frexp(mean)[1] - 20)
        return math.floor(mean / unit) * unit

    def since_start(self) -> Self:
        """The same motion by a clock that shows 0 at the start, for methods that start at 0: f(t0 + t, y) in place of
        f(t, y). Right-hand sides are counted in the same `buffer`; itself where t0 is 0."""
        if self.t0 == 0:
            return self
        found = replace(self, form=from_start(self.form, self.t0), times=self.elapsed, t0=0.0)
        vars(found)["buffer"] = self.buffer
        return found

    @cached_property
    def grouping(self) -> NDArray[np.int64]:
        """`groups` as an array (dimension,). Raises ValueError where `groups` has another length."""
        if self.groups and len(self.groups) != self.dimension:
            raise ValueError(
                f"{len(self.groups)} numbers of groups for {self.dimension} components; state one for each"
            )
        return np.array(self.groups or range(self.dimension), dtype=np.int64)

    @cached_property
    def buffer(self) -> Floats:
        """The argument `p` of kernels: the parameters and one more element, to which counting kernels add 1 each call."""
        return np.append(self.parameters, 0.0)


@dataclass
class Solution:
    """What `solve` returns for initial states (n, dim).

    `states`: float64 (n, len(problem.times), dim). `steps`: the number of steps taken, None where not defined. `stopped`:
    why the integration ended early, None where it did not (remaining states are nan). `events`: for hybrid problems with
    n = 1, the (time, transition name) pairs that were located.
    """

    states: Floats
    steps: int | None = None
    stopped: str | None = None
    events: tuple[tuple[float, str], ...] | None = None


@dataclass
class Solver:
    """What `prepare` returns: called with initial states (n, dim), which are copies, it returns a Solution.

    `solve` is the function that does it, and what is timed. `options`: the engine's options that differ from its defaults.
    `reset`: called before each call, timed and shown separately; None where nothing is to be reset. `close`: called once,
    at the end.
    """

    solve: Callable[[Floats], Solution]
    options: Mapping[str, Any] = field(default_factory=dict)
    reset: Callable[[], None] | None = None
    close: Callable[[], None] = lambda: None

    def __call__(self, initial_states: Floats) -> Solution:
        return self.solve(initial_states)


class Integrator(ABC):
    """An integrator: a declaration of what it is and accepts, and `prepare`.

    1. `prepare(problem, setting)` is not timed: build, compile, switch off what is not needed. It sees no initial
       state.
    2. It returns a plain function `solve`, which is timed: it takes copies of initial states, float64 (n, dim), and
       returns a Solution. It changes neither these nor the arrays of the problem.
    3. Or it returns a `Solver`, where an engine has options, is to be reset before each call, or holds what must be freed.
    4. Raise `Refused` for a problem or setting that it declines. Any other exception is status `crashed`.
    5. `counts_rhs` is False where the library has its own equations: right-hand sides are then not counted.
    6. Times since the start, `problem.t0`, are multiples of `problem.interval` where `problem.uniform`; with a clock or
       decimal times they are not. Runs start at 0; `problem.since_start()` is the same motion from 0.
    """

    name: ClassVar[str]
    library: ClassVar[str] = "gnomon"
    order: ClassVar[int | None] = None
    accepts: ClassVar[tuple[type, ...]]
    sampling: ClassVar[str] = "grid"
    """How samples are made: dense output | stops at samples | grid."""
    dense_order: ClassVar[int | None] = None
    """The order q of the dense output, whose error in a step is proportional to h^(q + 1); None: not declared."""
    sweep: ClassVar[Tolerance | Steps]
    policy: ClassVar[str] = ""
    counts_rhs: ClassVar[bool] = True
    conserves: ClassVar[tuple[str, ...]] = ()
    """What the method claims to conserve to round-off at any step size: the symplectic form (symplectic), volume in phase
    space, reversal of time (reversible), linear and angular momentum where the forces conserve them, rotations on their
    group (attitude), the constraint."""
    jacobian: str = "exact"
    """How the method gets Jacobians: exact, which includes none, or differences (of one side or both)."""
    compensated: ClassVar[bool] = False
    """Whether its sums over steps are compensated, so that their rounding does not grow with the number of steps."""
    primary: ClassVar[bool] = True
    """False for a near-duplicate method: a suite runs it only on the default variants, in one launch, unless it is
    named."""

    @abstractmethod
    def prepare(self, problem: Problem, setting: float) -> Solver | Callable[[Floats], Solution]: ...

    def unsupported(self, form: Form | SceneForm) -> str | None:
        """Why this integrator cannot run a form that it accepts by type (a missing token), None where it can."""
        return None

    @property
    def id(self) -> str:
        return f"{self.library}:{self.name}" + (f" [{self.policy}]" if self.policy else "")

    def versions(self) -> Mapping[str, Any]:
        """Versions of the libraries that its results depend on, by name. They are in the keys of its trials, which run again
        where one has changed; what changes unseen, as a native library that is rebuilt, stands here, as a hash of its file.
        """
        return {}


def solver_of(integrator: Integrator, problem: Problem, setting: float) -> Solver:
    """What an integrator prepares, as a Solver: a plain function with its attributes `options`, `reset` and `close`, if any.

    Raises TypeError where it is neither.
    """
    found = integrator.prepare(problem, setting)
    if isinstance(found, Solver):
        return found
    if not callable(found):
        raise TypeError(f"prepare returned {found!r}; let it return a function of initial states, or a Solver")
    named = {name: getattr(found, name) for name in ("options", "reset", "close") if hasattr(found, name)}
    return Solver(found, **named)


def each_start(
    problem: Problem, solve_one: Callable[[Floats, Floats], tuple[int | None, str | None]]
) -> Callable[[Floats], Solution]:
    """A function for `prepare` that solves from one start after the other.

    `solve_one(start, out)` writes the states that it reaches into `out` (len(times), dim), which is nan, and returns the
    number of steps and why it ended early, each None where there is none.
    """

    def solve(initial_states: Floats) -> Solution:
        states = np.full((len(initial_states), len(problem.times), problem.dimension), np.nan)
        ends = [solve_one(start, out) for start, out in zip(initial_states, states, strict=True)]
        steps = [count for count, _ in ends if count is not None]
        stopped = next((why for _, why in ends if why), None)
        return Solution(states, sum(steps) if len(steps) == len(ends) else None, stopped)

    return solve

"""The contract between the harness and an integrator."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import Form
from gnomon.cases.core.scene import SceneForm
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Refused(Exception):  # noqa: N818 - named for the status that it becomes
    """Raised by an integrator that declines a problem or a setting; the message says why. Status `refused`."""


@dataclass(frozen=True)
class Tolerance:
    """The one knob is a relative tolerance, swept from `loosest` to `tightest`, `per_decade` settings a decade."""

    loosest: float = 1e-3
    tightest: float = 1e-13
    per_decade: int = 1
    kind: ClassVar[str] = "tolerance"


@dataclass(frozen=True)
class Steps:
    """The one knob is the step size: the sampling interval over powers of two.

    The sweep starts at the largest such step not above `coarsest` time scales and halves it `halvings` times.
    """

    coarsest: float = 0.5
    halvings: int = 10
    kind: ClassVar[str] = "step"


@dataclass(frozen=True)
class Problem:
    """What `prepare` sees: the equations, the numbers of the problem, the sample times. Never the initial state.

    `form` is of a type that the integrator accepts. `times`: float64 (64,), the values of the independent variable at
    which states are wanted, multiples of an exact interval unless the formulation has a clock. The start is at 0.
    """

    form: Form | SceneForm
    dimension: int
    parameters: Floats
    times: Floats
    time_scale: float
    counted: bool = False
    """True in the untimed run that counts right-hand sides: `gnomon.harness.kernels.equations` then hands out counting twins."""
    groups: tuple[int, ...] = ()
    """The number, from 0, of the group of each component: those of a group have one unit and are measured by one size,
    as in the case's metric. Empty: each component by its own."""

    @property
    def uniform(self) -> bool:
        """True where the times are exact multiples of `interval` (always, unless the formulation has a clock)."""
        return bool(np.array_equal(self.times, np.arange(1, len(self.times) + 1) * self.times[0]))

    @property
    def interval(self) -> float:
        """The sampling interval; with a clock, the whole over the number of samples, to 20 bits."""
        if self.uniform:
            return float(self.times[0])
        mean = float(self.times[-1]) / len(self.times)
        unit = math.ldexp(1.0, math.frexp(mean)[1] - 20)
        return math.floor(mean / unit) * unit

    @cached_property
    def grouping(self) -> NDArray[np.int64]:
        """`groups` as an array, one number a component. Raises ValueError where that is not their number."""
        if self.groups and len(self.groups) != self.dimension:
            raise ValueError(
                f"{len(self.groups)} numbers of groups for {self.dimension} components; state one for each"
            )
        return np.array(self.groups or range(self.dimension), dtype=np.int64)

    @cached_property
    def buffer(self) -> Floats:
        """The parameters and one more element, which counting kernels raise by 1 a call; hand this to kernels."""
        return np.append(self.parameters, 0.0)


@dataclass
class Solution:
    """What `solve` returns for initial states (n, dim).

    `states`: float64 (n, len(problem.times), dim). `steps`: steps taken, None where not defined. `stopped`: why the
    integration ended early, if it did (remaining states are nan). `events`: for hybrid problems with n = 1, the
    (time, transition name) pairs that were located.
    """

    states: Floats
    steps: int | None = None
    stopped: str | None = None
    events: tuple[tuple[float, str], ...] | None = None


Solve = Callable[[Floats], Solution]


class Integrator(ABC):
    """An integrator: a declaration of what it is and accepts, and `prepare`.

    1. `prepare(problem, setting)` is not timed: build, compile, switch off what is not needed. It sees no initial
       state.
    2. It returns `solve`, which is timed. `solve` takes copies of initial states, float64 (n, dim), and returns a
       Solution.
    3. `solve` may carry attributes: `reset()` (timed, shown apart), `close()`, and `settings`, a mapping of the engine
       settings that differ from the engine's default.
    4. Raise `Refused` for what it declines. Anything else that it raises is status `crashed`.
    5. `counts_rhs` is False where the library owns its equations: right-hand sides are then not counted.
    6. Times are multiples of `problem.interval` where `problem.uniform`; with a clock or decimal times they are not.
    """

    name: ClassVar[str]
    library: ClassVar[str] = "gnomon"
    order: ClassVar[int | None] = None
    accepts: ClassVar[tuple[type, ...]]
    sampling: ClassVar[str] = "grid"
    """How samples are delivered: dense output | stops at samples | grid."""
    sweep: ClassVar[Tolerance | Steps]
    policy: ClassVar[str] = ""
    counts_rhs: ClassVar[bool] = True
    conserves: ClassVar[tuple[str, ...]] = ()
    """What the method claims to keep, whatever its step: the form (symplectic), volume in phase space, reversal of time
    (reversible), linear and angular momentum where the forces keep them, rotations on their group (attitude), the
    constraint. To round-off, each."""
    primary: ClassVar[bool] = True
    """False for a sibling of a method that runs everywhere: a suite takes it on default settings in one launch, and
    elsewhere where it is named."""

    @abstractmethod
    def prepare(self, problem: Problem, setting: float) -> Solve: ...

    def unsupported(self, form: Form | SceneForm) -> str | None:
        """Why this integrator cannot run a form that it accepts by type (a missing token), or None."""
        return None

    @property
    def id(self) -> str:
        return f"{self.library}:{self.name}" + (f" [{self.policy}]" if self.policy else "")

    def versions(self) -> Mapping[str, Any]:
        """Versions of the libraries that its results depend on."""
        return {}

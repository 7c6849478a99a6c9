"""The contract between the harness and an integrator: its declaration, the problem it is given, its solution."""

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
    """Raised by an integrator that declines a problem or a setting; the message says why. Status `refused`.

    Examples
    --------
    >>> from gnomon.verify import from_step
    >>> def step(f, t, y, h):
    ...     if h > 0.5:
    ...         raise Refused("a step above 0.5 s")
    ...     return y + h * f(t, y)
    >>> from_step(step, name="careful Euler", order=1).id
    'mine:careful Euler'
    """


class Unsupported(Refused):
    """Raised by an integrator that lacks an ability that the problem needs; the message names it. Status `unsupported`."""


class TooManyCalls(Exception):  # noqa: N818 - named for the limit
    """Raised by the right-hand side of a plain function after `Problem.most_calls` calls. Status `crashed`."""


@dataclass(frozen=True)
class Tolerance:
    """The sweep of an integrator whose setting is a relative tolerance: from 1e-6 to 1e-12 these are seven tolerances.

    Attributes
    ----------
    loosest, tightest : float
        The first and the last tolerance of the sweep, without unit.
    per_decade : int
        The number of tolerances in a decade.
    name : str
        The library's name of a parameter that sets the accuracy and is not a tolerance; `gnomon.solve` takes it by this
        name.

    Examples
    --------
    >>> Tolerance(loosest=1e-3, tightest=1e-12)
    Tolerance(loosest=0.001, tightest=1e-12, per_decade=1, name='rtol')
    """

    loosest: float = 1e-3
    tightest: float = 1e-13
    per_decade: int = 1
    name: str = "rtol"
    kind: ClassVar[str] = "tolerance"


@dataclass(frozen=True)
class Steps:
    """The sweep of an integrator whose setting is a step size: the sampling interval over a power of two.

    Attributes
    ----------
    coarsest : float
        An upper limit of the first step, in time scales of the problem: the sweep starts at the largest step up to it.
    halvings : int
        The number of times that the sweep halves the first step. Runs have at least 8 step sizes.

    Examples
    --------
    >>> Steps(coarsest=0.125, halvings=7)
    Steps(coarsest=0.125, halvings=7)
    """

    coarsest: float = 0.5
    halvings: int = 10
    kind: ClassVar[str] = "step"


@dataclass(frozen=True)
class Names:
    """The names of a problem's case, coordinates and parameters, for programs in other languages.

    Attributes
    ----------
    case : str
        The name of the case.
    coordinates, parameters : tuple of str
        Names in the sequence of the state and of `Problem.parameters`.
    """

    case: str
    coordinates: tuple[str, ...]
    parameters: tuple[str, ...]


@dataclass(frozen=True)
class Problem:
    """The problem that `prepare` is given: equations, parameters and sample times, but not the initial state.

    All numbers are in the units of the case. Times are absolute: `times`, the t of the equations, times of events.

    Attributes
    ----------
    form : Form or SceneForm
        The equations or the scene, of a type that the integrator accepts.
    dimension : int
        The number of components of the state.
    parameters : float64 array, shape (m,)
        The parameters of the case.
    times : float64 array, shape (s,)
        The values of the independent variable at the samples, 64 for a case. Since the start they are multiples of an
        exact interval, unless the formulation has a clock.
    time_scale : float
        A time in which the motion changes by its own size, in the unit of `times`.
    counted : bool
        True in the untimed run that counts right-hand sides: the kernels of `gnomon.harness.kernels.equations` then
        count their calls.
    groups : tuple of int
        For each component the index of its group, from 0. The components of a group have one unit and one size, which
        divides their errors, as in the case's metric. Empty: each component is a group.
    names : Names or None
        Names of the case, coordinates and parameters; None for a problem that was made without a case.
    t0 : float
        The time of the initial state.
    most_calls : float
        The number of right-hand sides after which a plain function (`from_step`, `from_solve`) is given up, in each
        call of `solve`; only a verification sets it.

    Examples
    --------
    >>> import numpy as np
    >>> from gnomon.cases.core.forms import FirstOrder
    >>> def decay(t, y, p):
    ...     return (-p[0] * y[0],)
    >>> problem = Problem(FirstOrder(decay), 1, np.array([2.0]), np.array([0.5, 1.0]), time_scale=0.5)
    >>> problem.interval, problem.uniform
    (0.5, True)
    """

    form: Form | SceneForm
    dimension: int
    parameters: Floats
    times: Floats
    time_scale: float
    counted: bool = False
    groups: tuple[int, ...] = ()
    names: Names | None = None
    t0: float = 0.0
    most_calls: float = math.inf

    @property
    def elapsed(self) -> Floats:
        """The times since the start, float64 array of shape (s,)."""
        return self.times - self.t0

    @property
    def uniform(self) -> bool:
        """Whether the times since the start are exact multiples of `interval`; always without a clock."""
        elapsed = self.elapsed
        return bool(np.array_equal(elapsed, np.arange(1, len(elapsed) + 1) * elapsed[0]))

    @property
    def interval(self) -> float:
        """The sampling interval; with a clock the mean interval, rounded down to 20 bits."""
        elapsed = self.elapsed
        if self.uniform:
            return float(elapsed[0])
        mean = float(elapsed[-1]) / len(elapsed)
        unit = math.ldexp(1.0, math.frexp(mean)[1] - 20)
        return math.floor(mean / unit) * unit

    def since_start(self) -> Self:
        """The problem with times that begin at 0, for methods that start at 0: f(t0 + t, y) replaces f(t, y).

        Both problems count right-hand sides in one `buffer`. Returns the problem itself if t0 is 0.
        """
        if self.t0 == 0:
            return self
        shifted = replace(self, form=from_start(self.form, self.t0), times=self.elapsed, t0=0.0)
        vars(shifted)["buffer"] = self.buffer
        return shifted

    @cached_property
    def grouping(self) -> NDArray[np.int64]:
        """`groups` as an array of shape (dimension,). Raises ValueError if `groups` has another length."""
        if self.groups and len(self.groups) != self.dimension:
            raise ValueError(
                f"{len(self.groups)} numbers of groups for {self.dimension} components; state one for each"
            )
        return np.array(self.groups or range(self.dimension), dtype=np.int64)

    @cached_property
    def buffer(self) -> Floats:
        """The argument `p` of kernels, shape (m + 1,): the parameters, then the number of calls of counting kernels."""
        return np.append(self.parameters, 0.0)


@dataclass
class Solution:
    """The result of `solve` for n initial states.

    Attributes
    ----------
    states : float64 array, shape (n, len(problem.times), dimension)
        The states at the sample times, in the units of the case.
    steps : int or None
        The number of steps of all trajectories; None if it is not defined.
    stopped : str or None
        The reason for an early end of the integration, after which states are nan; None without an early end.
    events : tuple of (float, str), or None
        For hybrid problems with n = 1, the time and the transition's name of each event that was located.

    Examples
    --------
    >>> import numpy as np
    >>> Solution(np.zeros((1, 64, 2)), steps=640).states.shape
    (1, 64, 2)
    """

    states: Floats
    steps: int | None = None
    stopped: str | None = None
    events: tuple[tuple[float, str], ...] | None = None


@dataclass
class Solver:
    """The result of `prepare`: a function that solves from initial states, with the options of its engine.

    Attributes
    ----------
    solve : callable
        The function that is timed: it takes copies of initial states, float64 array of shape (n, dimension), and
        returns a Solution.
    options : mapping of str to any
        The options of the engine that differ from its defaults.
    reset : callable or None
        Called before each call of `solve`, and timed separately; None without a reset.
    close : callable
        Called once, at the end.

    Examples
    --------
    >>> import numpy as np
    >>> solver = Solver(lambda starts: Solution(np.repeat(starts[:, None], 64, axis=1)), options={"rtol": 1e-9})
    >>> solver(np.ones((1, 2))).states.shape
    (1, 64, 2)
    """

    solve: Callable[[Floats], Solution]
    options: Mapping[str, Any] = field(default_factory=dict)
    reset: Callable[[], None] | None = None
    close: Callable[[], None] = lambda: None

    def __call__(self, initial_states: Floats) -> Solution:
        """Call `solve` with initial states, float64 array of shape (n, dimension)."""
        return self.solve(initial_states)


class Integrator(ABC):
    """An integrator: a declaration in class attributes, and the method `prepare`.

    1. `prepare(problem, setting)` is not timed: build, compile, switch off everything that is not needed. It does not
       see an initial state.
    2. It returns a plain function `solve`, which is timed: it takes copies of initial states, float64 (n, dimension),
       and returns a Solution. It changes neither these nor the arrays of the problem.
    3. Or it returns a `Solver`, if an engine has options, needs a reset before each call, or holds resources that must
       be freed.
    4. Raise `Refused` for a problem or setting that the integrator declines. Any other exception is status `crashed`.
    5. `counts_rhs` is False if the library has its own equations: right-hand sides are then not counted.
    6. If `problem.uniform`, times since the start, `problem.t0`, are multiples of `problem.interval`; with a clock or
       decimal times they are not. Runs start at 0; `problem.since_start()` is the same motion from 0.

    Attributes
    ----------
    name, library, policy : str
        The method, its library, and the way in which it is driven, if there are several ways; `id` joins them.
    order : int or None
        The order of convergence; None if the method has no fixed order.
    accepts : tuple of types
        The forms that it takes, such as `gnomon.FirstOrder`, or `SceneForm`.
    sampling : str
        The origin of samples: "dense output", "stops at samples" or "grid".
    dense_order : int or None
        The order q of the dense output, whose error in a step is proportional to h^(q + 1); None: not declared.
    sweep : Tolerance or Steps
        The kind of setting, and the settings of a sweep.
    counts_rhs : bool
        Whether right-hand sides are counted.
    conserves : tuple of str
        Quantities that the method claims to conserve to round-off at any step size: "symplectic" (the symplectic form),
        "volume" (in phase space), "reversible" (reversal of time), "momentum" (linear and angular, if the forces
        conserve them), "energy" (if the forces conserve it), "attitude" (rotations stay rotations), "constraint".
    jacobian : str
        The origin of Jacobians: "exact", also for a method that uses no Jacobian, or "differences".
    compensated : bool
        Whether its sums over steps are compensated, so that their rounding does not grow with the number of steps.
    atol_ratio : float or None
        The absolute tolerance over the relative one; None for a method without an absolute tolerance.
    takes : tuple of str
        The options of `gnomon.solve` that it takes beside its setting: "max_step" and "first_step", which it finds in its
        attributes of these names, and "jac" (the Jacobian of the form, which may be a function of the user's).
    max_step : float
        The longest step.
    first_step : float or None
        The first step; None if the method chooses it.
    primary : bool
        False for a near-duplicate method: a suite runs it only on the default variants, in one launch, unless it is
        named.

    Examples
    --------
    >>> import numpy as np
    >>> import gnomon
    >>> class Euler(gnomon.Integrator):
    ...     name, library, order = "Euler", "mine", 1
    ...     accepts, sweep = (gnomon.FirstOrder,), gnomon.Steps(coarsest=0.125, halvings=7)
    ...
    ...     def prepare(self, problem, setting):
    ...         f, p = gnomon.right_hand_side(problem).array, problem.buffer
    ...
    ...         def solve_one(y, out):
    ...             t, steps = problem.t0, 0
    ...             for k, end in enumerate(problem.times):
    ...                 count = max(1, round((end - t) / setting))
    ...                 h = (end - t) / count
    ...                 for i in range(count):
    ...                     y = y + h * f(t + h * i, y, p)
    ...                 t, steps, out[k] = end, steps + count, y
    ...             return steps, None
    ...
    ...         return gnomon.each_start(problem, solve_one)
    >>> gnomon.solve(lambda t, y: [y[1], -np.sin(y[0])], (0, 1), [0.1, 0.0], Euler, step=2**-10).y.shape
    (2, 64)
    """

    name: ClassVar[str]
    library: ClassVar[str] = "gnomon"
    order: ClassVar[int | None] = None
    accepts: ClassVar[tuple[type, ...]]
    sampling: ClassVar[str] = "grid"
    dense_order: ClassVar[int | None] = None
    sweep: ClassVar[Tolerance | Steps]
    policy: ClassVar[str] = ""
    counts_rhs: ClassVar[bool] = True
    conserves: ClassVar[tuple[str, ...]] = ()
    jacobian: str = "exact"
    compensated: ClassVar[bool] = False
    atol_ratio: float | None = None
    takes: ClassVar[tuple[str, ...]] = ()
    max_step: float = math.inf
    first_step: float | None = None
    primary: ClassVar[bool] = True

    @abstractmethod
    def prepare(self, problem: Problem, setting: float) -> Solver | Callable[[Floats], Solution]:
        """Build and compile everything that does not depend on the initial state; not timed.

        Parameters
        ----------
        problem : Problem
            The equations, parameters and sample times.
        setting : float
            The relative tolerance, or the step size in the unit of `problem.times`: see `sweep`.

        Returns
        -------
        Solver or callable
            The function that is timed: initial states, float64 array of shape (n, dimension), to a Solution.

        Raises
        ------
        Refused
            If the integrator declines the problem or the setting.
        """
        ...

    def unsupported(self, form: Form | SceneForm) -> str | None:
        """Say why this integrator cannot run a form whose type it accepts.

        Parameters
        ----------
        form : Form or SceneForm
            A form of a type in `accepts`.

        Returns
        -------
        str or None
            The reason, such as a missing token of a scene; None if the integrator can run the form.
        """
        return None

    @property
    def id(self) -> str:
        """The name of the integrator in results: `library:name`, with the policy in brackets if there is one."""
        return f"{self.library}:{self.name}" + (f" [{self.policy}]" if self.policy else "")

    def versions(self) -> Mapping[str, Any]:
        """Versions of the libraries on which its results depend.

        Returns
        -------
        mapping of str to any
            Versions by name. They are in the keys of its trials, which run again after a version has changed. For a
            change that gnomon cannot see, such as a native library that is rebuilt, give a hash of the file.

        Raises
        ------
        ImportError
            If a library is not installed: its trials then have the status `not_installed`.
        """
        return {}


def solver_of(integrator: Integrator, problem: Problem, setting: float) -> Solver:
    """Prepare an integrator, and give the result as a Solver.

    A plain function becomes a Solver with the function's attributes `options`, `reset` and `close`, if it has them.
    Raises TypeError for any other result.
    """
    answer = integrator.prepare(problem, setting)
    if isinstance(answer, Solver):
        return answer
    if not callable(answer):
        raise TypeError(f"prepare returned {answer!r}; let it return a function of initial states, or a Solver")
    named = {name: getattr(answer, name) for name in ("options", "reset", "close") if hasattr(answer, name)}
    return Solver(answer, **named)


def each_start(
    problem: Problem, solve_one: Callable[[Floats, Floats], tuple[int | None, str | None]]
) -> Callable[[Floats], Solution]:
    """Make the function that `prepare` returns from a function that solves from one start.

    Parameters
    ----------
    problem : Problem
        The problem that `prepare` was given.
    solve_one : callable
        `solve_one(start, out)` writes the states that it reaches into `out`, float64 array of shape
        (len(problem.times), dimension), which is filled with nan. It returns the number of steps, or None, and the
        reason for an early end, or None.

    Returns
    -------
    callable
        A function of initial states, float64 array of shape (n, dimension), that calls `solve_one` for one start after
        the other and returns a Solution. Its `steps` is None unless every call gave a number.

    Examples
    --------
    >>> import numpy as np
    >>> import gnomon
    >>> def resting(t, y, p):
    ...     return (0.0,)
    >>> problem = gnomon.Problem(gnomon.FirstOrder(resting), 1, np.empty(0), np.array([0.5, 1.0]), time_scale=1.0)
    >>> def stay(start, out):
    ...     out[:] = start
    ...     return 1, None
    >>> each_start(problem, stay)(np.ones((3, 1))).states.shape
    (3, 2, 1)
    """

    def solve(initial_states: Floats) -> Solution:
        states = np.full((len(initial_states), len(problem.times), problem.dimension), np.nan)
        ends = [solve_one(start, out) for start, out in zip(initial_states, states, strict=True)]
        steps = [count for count, _ in ends if count is not None]
        stopped = next((why for _, why in ends if why), None)
        return Solution(states, sum(steps) if len(steps) == len(ends) else None, stopped)

    return solve

"""One-step methods at a fixed step size: a subclass is a declaration of a step function and its coefficients."""

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder, Form, SecondOrder
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solution, Solver, Steps
from gnomon.harness.contract.validation import require_positive
from gnomon.harness.integrators.base import stepping
from gnomon.harness.kernels.equations import Kernel, check_values, function_kernel, right_hand_side
from gnomon.reference.numerics.precision import nearest_double, working
from gnomon.reference.storage import diskcache
from gnomon.reference.storage.import_closure import closure
from numpy.typing import NDArray

Table = Sequence[Sequence[Any]]
Loop = Callable[[Floats, Floats, NDArray[np.int64]], int]
"""A function (initial states, out, stop) -> number of steps. It writes the states at the samples into `out`, and the
reason, the trajectory and the sample of the first early end into `stop`."""

DIGITS = 60
"""Coefficients are computed to this many digits and rounded once to binary64."""

MOST_STEPS = 10**10
"""About three minutes of the cheapest method: a setting that needs more steps is refused as a mistake."""


class FixedStep(Integrator):
    """A one-step method whose setting is the step size h.

    A subclass declares `step` (for its contract see `stepping`), `coefficients` and the number of rows that its step
    stores. If it is `compensated`, increments are added with Kahan's compensation.
    """

    sweep = Steps()
    sampling = "grid"
    may_stop_aside: ClassVar[bool] = True
    """Whether a sample may lie between steps, where it is the end of a shorter step."""
    stops_aside: bool = False
    """Whether samples lie between steps even if they are evenly spaced: they may then be closer than steps."""
    step: ClassVar[stepping.Step]
    function: ClassVar[str] = ""
    """The name of the function of the form that the step calls; "": its acceleration, else its equations."""
    function_widths: ClassVar[tuple[int, int] | None] = None
    """The result of `widths` where all forms that the method accepts have it."""

    @classmethod
    @abstractmethod
    def coefficients(cls, mp: Any) -> Table:
        """The method's coefficients in the mpmath context `mp`, at its precision."""

    def rows(self, form: Form) -> int:
        """The number of rows, each as long as the state, that the step stores."""
        return 1

    def equations(self, form: Form) -> Callable[..., Any]:
        """The plain function that the step calls."""
        if self.function:
            named: Callable[..., Any] = getattr(form, self.function)
            return named
        if isinstance(form, SecondOrder):
            return form.acceleration
        assert isinstance(form, FirstOrder)
        return form.equations

    def widths(self, form: Form, dimension: int) -> tuple[int, int]:
        """The number of values that `equations` takes as its state, and the number that it returns."""
        if self.function_widths is not None:
            return self.function_widths
        width = dimension // 2 if isinstance(form, SecondOrder) else dimension
        return width, width

    def shape(self, form: Form, dimension: int, parameters: int) -> tuple[tuple[int, int], int]:
        """`widths` and `rows`, for methods that tell them from the number of parameters besides."""
        return self.widths(form, dimension), self.rows(form)

    def constants(self, shape: tuple[tuple[int, int], int]) -> tuple[tuple[str, int], ...]:
        """Numbers that the step reads, by their names, which are compiled into it."""
        return ()

    def kernel(self, problem: Problem) -> Kernel:
        """The compiled `equations`, which count their calls if `problem.counted`."""
        form = problem.form
        assert not isinstance(form, SceneForm)
        function, known = self.equations(form), len(problem.parameters)
        (inputs, outputs), _ = self.shape(form, problem.dimension, known)
        if isinstance(form, FirstOrder) and function is form.equations:
            return right_hand_side(problem)
        return function_kernel(function, inputs, known, outputs, problem.counted)

    def table(self, mp: Any, form: Form, parameters: Sequence[Any], roundoff: Any) -> Table:
        """The coefficients, with other numbers that the step needs: parameters of the case, the unit round-off."""
        return self.coefficients(mp)

    def table_for(self, mp: Any, form: Form, parameters: Sequence[Any], roundoff: Any, h: Any) -> Table:
        """The table for steps of size h; methods whose coefficients depend on h override this."""
        return self.table(mp, form, parameters, roundoff)

    def binary64(self, form: Form, parameters: Sequence[float], h: float) -> Floats:
        """The table, rounded once from high precision. Methods that need milliseconds for it keep it (see `keep_table`)."""
        with working(DIGITS) as mp:
            numbers = [mp.mpf(x) for x in parameters]
            return round_table(self.table_for(mp, form, numbers, mp.mpf(2) ** -52, mp.mpf(h)))

    def step_for(self, form: Form) -> stepping.Step:
        return type(self).step

    def prepare(self, problem: Problem, setting: float) -> Solver:
        problem = problem.since_start()
        substeps = substeps_of(problem, setting, self.stops_aside)
        h = problem.interval / substeps if substeps else setting
        run = self.loop(problem, h, substeps)

        def solve(initial: Floats) -> Solution:
            out = stepping.blank(problem, initial)
            stop = np.zeros(3, dtype=np.int64)
            taken = run(initial, out, stop)
            return Solution(out, taken, reason(stop))

        return Solver(solve)

    def loop(self, problem: Problem, h: float, substeps: int) -> Loop:
        """The loop with steps of h; `substeps`: their number in a sampling interval, 0 if samples lie between steps."""
        form = problem.form
        assert not isinstance(form, SceneForm)
        step, address = self.step_for(form), self.kernel(problem).address
        table = self.binary64(form, problem.parameters.tolist(), h)
        shape = self.shape(form, problem.dimension, len(problem.parameters))
        return self.advancing(problem, h, substeps, step, address, table, shape)

    def advancing(
        self, problem: Problem, h: float, substeps: int, step: stepping.Step, address: int, table: Floats,
        shape: tuple[tuple[int, int], int],
    ) -> Loop:  # fmt: skip
        """The compiled loop around a step, with the equations at an address.

        `shape`: that of the method for the form.
        """
        run, compensated = stepping.compile_step(step, self.constants(shape)), self.compensated
        widths, rows = shape
        buffer, times = problem.buffer, problem.times

        def advance(initial: Floats, out: Floats, stop: NDArray[np.int64]) -> int:
            return run(address, buffer, table, *widths, rows, initial, times, h, substeps, compensated, out, stop)

        return advance


def substeps_of(problem: Problem, h: float, aside: bool = False) -> int:
    """The number of steps of h in a sampling interval; 0 if samples lie between steps, for `aside` in any case.

    Raises Refused for an h that is not positive, takes too many steps or does not divide the interval.
    """
    span = float(problem.elapsed[-1])
    require_positive(h, "step size")
    if span / h > MOST_STEPS or span + h == span:
        least = f"take at least {span / MOST_STEPS:.1g}"
        raise Refused(f"step size {h:g} would take more than {MOST_STEPS:g} steps to reach t = {span:g}; {least}")
    if aside or not problem.uniform:
        return 0
    count = round(problem.interval / h)
    if count < 1 or abs(count * h - problem.interval) > 2 * math.ulp(problem.interval):
        nearest = problem.interval / max(1, count)
        raise Refused(f"step size {h!r} does not divide the sampling interval {problem.interval!r}; {nearest!r} does")
    return count


def take_numbers(mp: Any, function: Callable[[Any], Any], parameters: Sequence[Any], count: int) -> list[Any]:
    """The `count` numbers that a form's function of the parameters returns. Raises ValueError for another count."""
    check_values(function, (len(parameters),), count)
    return [mp.mpf(x) for x in function(tuple(parameters))]


def round_table(table: Table, double: Callable[[Any], float] = nearest_double) -> Floats:
    """Convert rows of numbers to doubles by `double`, by default from mpmath numbers; zeros fill short rows."""
    rounded = np.zeros((len(table), max(map(len, table))))
    for row, values in zip(rounded, table, strict=True):
        row[: len(values)] = [double(x) for x in values]
    return rounded


def keep_table(name: str, modules: Sequence[str], build: Callable[[], Floats]) -> Floats:
    """The table from the disk, or else by `build`, which the disk then keeps until a source of `modules` changes."""
    sources = closure(__name__, *modules, within=())
    if sources is None:
        return build()
    return diskcache.cached(f"table {name} {sources}", lambda: diskcache.Entry({"rows": build()})).arrays["rows"]


def reason(stop: NDArray[np.int64]) -> str | None:
    """The reason for the early end of a trajectory, as a sentence; None if it reached the last sample."""
    if stop[0] == 0:
        return None
    what = {
        stepping.NOT_FINITE: "the state was not finite",
        stepping.NOT_SOLVED: "the stages of a step did not converge",
    }[int(stop[0])]
    where = f"{what} before sample {stop[2] + 1}" + (f" of trajectory {stop[1] + 1}" if stop[1] else "")
    return f"{where}; take shorter steps" if stop[0] == stepping.NOT_SOLVED else where

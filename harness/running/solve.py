"""`solve`: any integrator that gnomon knows, on equations of the reader's own, with the arguments of SciPy's `solve_ivp`."""

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any, Self

import numpy as np
from gnomon.cases.core.consistent import violation
from gnomon.cases.core.forms import Constrained, FirstOrder, Form, first_order
from gnomon.harness.contract.integrator import (
    Floats,
    Integrator,
    Problem,
    Refused,
    Solution,
    Steps,
    Tolerance,
)
from gnomon.harness.contract.problem import first_taken
from gnomon.harness.contract.validation import Unusable, short
from gnomon.harness.kernels.compiling import shown
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.registry import lookup
from gnomon.harness.running.own_functions import (
    Arguments,
    CaseEquations,
    Clock,
    OwnEquations,
    at_rest,
    counts,
    place,
    with_events,
)

SAMPLES = 64
DEFAULT_RTOL = 1e-9
EVEN = 1e-9
"""Times count as evenly spaced if they are so to this share of their spacing: decimals have round-off."""
INSTEAD = {
    "dense_output": "give the times in t_eval",
    "tolerance": "write rtol=..., or step=... for a method of fixed steps",
    "parameters": "write args=(...), which are further arguments of fun",
    "times": "write t_eval=...",
}


@dataclass
class OdeResult:
    """The result of `solve`, with the names of SciPy's.

    Attributes
    ----------
    t : ndarray, shape (n,)
        The times: `t_eval`, up to a terminal event or a failure.
    y : ndarray, shape (dim, n)
        The states at these times.
    t_events, y_events : list of ndarray, or None
        For each event, its times and states; None without events.
    nfev : int or None
        The number of right-hand sides; None if the library has its own equations.
    status : int
        0: the end was reached; 1: a terminal event; -1: the method gave up.
    message : str
        The reason for the end.
    success : bool
        Whether `status` is not negative.

    Examples
    --------
    >>> from gnomon import solve
    >>> solve(lambda t, y: -y, (0, 1), [1.0], t_eval=[1.0]).y.round(6)
    array([[0.367879]])
    """

    t: Floats
    y: Floats
    t_events: list[Floats] | None
    y_events: list[Floats] | None
    nfev: int | None
    status: int
    message: str

    @property
    def success(self) -> bool:
        return self.status >= 0


def solve(
    fun: Callable[..., Any] | Form,
    t_span: Sequence[float],
    y0: Sequence[float] | Floats,
    method: str | Integrator | type[Integrator] = "gnomon:DOP853",
    t_eval: Sequence[float] | Floats | None = None,
    dense_output: bool = False,
    events: Callable[..., Any] | Sequence[Callable[..., Any]] | None = None,
    vectorized: bool = False,
    args: Sequence[Any] | None = None,
    *,
    rtol: float | None = None,
    atol: float | None = None,
    step: float | None = None,
    accelerations: bool = False,
    **options: Any,
) -> OdeResult:
    """Solve an initial value problem with any integrator that gnomon knows; the arguments are those of SciPy's `solve_ivp`.

    Parameters
    ----------
    fun : callable or Form
        ``fun(t, y, *args)`` returns the derivatives as a list, tuple or array; with `accelerations` it is
        ``fun(t, q, *args)``. It is read as formulas once, and compiled. If it branches on the motion or reads a table,
        it is called from Python, on every method that needs no derivatives. Or a form, as `gnomon.RigidBody`.
    t_span : (float, float)
        The first and the last time; the second may be the earlier one.
    y0 : array_like, shape (dim,)
        The state at the first time; with `accelerations` (q..., q'...).
    method : str, Integrator or type
        An id of `gnomon list integrators`, a name that only one method for these equations has, or an integrator.
    t_eval : array_like, shape (n,), optional
        The times of the result, from the first to the last time; by default 64 equally spaced ones.
    dense_output : bool
        Not available: give the times in `t_eval`.
    events : callable or list of callables, optional
        ``event(t, y, *args)`` is located where it crosses zero after the start; its attributes `terminal` and
        `direction` are as in SciPy.
        They need a method with events, as `gnomon:DOP853 [events]`.
    vectorized : bool
        Ignored.
    args : tuple, optional
        Further arguments of `fun` and of the events. Other numbers there do not compile `fun` again.
    rtol : float, optional
        The relative tolerance, by default 1e-9; not for methods of fixed steps.
    atol : float, optional
        The absolute tolerance, for libraries that have one; by default in the ratio that the library recommends.
    step : float, optional
        The step size of a method of fixed steps, shortened so that steps end at equally spaced times.
    accelerations : bool
        Whether `fun` returns accelerations, for methods that solve q'' = a(t, q).
    **options : dict
        Other options of `solve_ivp` are refused by name.

    Returns
    -------
    OdeResult
        Times, states and events. If the method gives up, `success` is False and `message` says why.

    Raises
    ------
    Refused
        If the method declines these equations or this setting.
    ValueError
        For a wrong argument, for an exception in `fun`, and for a start that violates its constraints: with the nearest
        velocities that do not.

    Examples
    --------
    >>> import numpy as np
    >>> from gnomon import solve
    >>> swing = solve(lambda t, y: [y[1], -np.sin(y[0])], (0, 10), [1.0, 0.0], rtol=1e-10)
    >>> swing.y.shape, swing.success
    ((2, 64), True)
    >>> solve(lambda t, y: [y[1], -np.sin(y[0])], (0, 10), [1.0, 0.0], "RK4", step=0.01).message
    'gnomon:RK4 reached the end of the interval.'
    """
    _refuse_old_order(fun, t_span, y0, method, t_eval, options)
    refused = {"dense_output": dense_output, **options}
    for name in (name for name, value in refused.items() if value is not False):
        raise ValueError(f"{name}={refused[name]!r}: solve has no such option; {INSTEAD.get(name, 'leave it out')}")
    start = _state(y0, accelerations)
    times = Times.of(t_span, t_eval, len(start) // 2 if accelerations else 0)
    arguments = Arguments(tuple(args or ()))
    located = list(events) if isinstance(events, Sequence) else [] if events is None else [events]
    own: OwnEquations | None = None
    forms: tuple[Form, ...] = ()
    if isinstance(fun, CaseEquations):
        if args:
            raise ValueError(f"args={args!r}: the equations of a case have its numbers; give others to gnomon.case")
        forms, arguments = fun.forms, Arguments(tuple(fun.parameters.values()))
    elif isinstance(fun, Form):
        forms = (fun, *(x for x in (first_order(fun),) if x not in (None, fun)))
    else:
        own = OwnEquations(fun, times.clock, arguments, start, accelerations)
        forms = (with_events(own, located),) if located else own.forms
    if own is None and (located or times.clock.direction < 0):
        raise ValueError(
            "a form states its own events, and runs forward: leave out events, and give t_span=(t0, t1), t0 < t1"
        )
    for form in forms:
        if isinstance(form, Constrained) and (
            wrong := violation(form, float(t_span[0]), start.tolist(), arguments.numbers)
        ):
            raise ValueError(f"y0 violates its constraints: {wrong}")
    integrator, setting = _with_setting(_method(method, forms), rtol, atol, step)
    parameters = arguments.numbers if own is None else own.parameters
    problem = times.problem(first_taken(integrator, forms), start, parameters, integrator, own is None)
    return _solved(integrator, problem, setting, start, times, own, located)


@dataclass(frozen=True)
class Times:
    """The times of a call: `wanted` by the user, and `sampled` by the problem: since the start, up to the end."""

    clock: Clock
    wanted: Floats
    sampled: Floats
    first: int
    """1 if the first wanted time is the start, else 0."""

    @classmethod
    def of(cls, t_span: Sequence[float], t_eval: Sequence[float] | Floats | None, rates: int) -> Self:
        try:
            t0, end = map(float, t_span)
        except (TypeError, ValueError):
            raise ValueError(f"t_span={t_span!r}: give the first and the last time") from None
        if not (math.isfinite(t0) and math.isfinite(end)) or t0 == end:
            raise ValueError(f"t_span={t_span!r}: give two different finite times")
        direction = 1.0 if end > t0 else -1.0
        wanted = np.linspace(t0, end, SAMPLES) if t_eval is None else _array(t_eval, "t_eval")
        elapsed = direction * (wanted - t0)
        if not np.all(np.diff(elapsed) > 0) or elapsed[0] < 0 or elapsed[-1] > abs(end - t0):
            raise ValueError(f"t_eval={short(t_eval)}: give times in order, from {t0:g} to {end:g}")
        first = int(elapsed[0] == 0)
        sampled = elapsed[first:]
        if not len(sampled) or sampled[-1] < abs(end - t0):
            sampled = np.append(sampled, abs(end - t0))
        return cls(Clock(t0, direction, rates), wanted, sampled, first)

    def problem(
        self, form: Form, start: Floats, parameters: Sequence[float], integrator: Integrator, by_own_clock: bool
    ) -> Problem:
        """The problem from t = 0; of a form, which may read the time, from its own start.

        Times that are evenly spaced but for round-off are exactly so for fixed steps, which then end at them.
        """
        times, count = self.sampled, len(self.sampled)
        even = np.arange(1, count + 1) * (times[-1] / count)
        if isinstance(integrator.sweep, Steps) and np.allclose(times, even, rtol=0, atol=EVEN * even[0]):
            times = even
        t0 = self.clock.t0 if by_own_clock else 0.0
        numbers = np.array(parameters, dtype=np.float64)
        return Problem(form, len(start), numbers, t0 + times, times[-1] / count, integrator.counts_rhs, t0=t0)


def _solved(
    integrator: Integrator, problem: Problem, setting: float, start: Floats, times: Times,
    own: OwnEquations | None, events: Sequence[Callable[..., Any]],
) -> OdeResult:  # fmt: skip
    found, calls = _run(integrator, problem, setting, start, own)
    count, message = len(times.wanted), f"{integrator.id} reached the end of the interval."
    y = np.concatenate([start[None], times.clock.own(found.states[0])])[1 - times.first :][:count].T
    status, clock = 0, times.clock
    if found.stopped is not None:
        status, message = -1, f"{integrator.id}: {found.stopped}"
        count = int(np.argmax([*~np.isfinite(y).all(axis=0), True]))
    t_events: list[Floats] | None = None
    y_events: list[Floats] | None = None
    if events:
        happened = _happened(found, events)
        t_events = [np.array([clock.t0 + clock.direction * t for t in each]) for each in happened]
        y_events = [clock.own(x) for x in _states_at(integrator, problem, setting, start, own, happened)]
        ends = [t[-1] for t, event in zip(happened, events, strict=True) if t and getattr(event, "terminal", False)]
        if ends:
            status, message = 1, "A terminal event occurred."
            count = min(count, int(np.searchsorted(clock.direction * (times.wanted - clock.t0), min(ends), "right")))
    return OdeResult(times.wanted[:count], y[:, :count], t_events, y_events, calls, status, message)


def _run(
    integrator: Integrator, problem: Problem, setting: float, start: Floats, own: OwnEquations | None
) -> tuple[Solution, int | None]:
    """The solution, and the number of right-hand sides, if they are counted."""
    if isinstance(integrator.sweep, Steps) and problem.uniform:
        setting = problem.interval / math.ceil(problem.interval / setting * (1 - EVEN))
    with shown(integrator.id):
        try:
            prepared = Prepared(integrator, problem, setting)
        except Exception as error:
            if own is None or own.called is None:
                raise
            with Prepared(integrator, replace(problem, form=FirstOrder(at_rest)), setting):
                pass  # raises if the method declines more than these equations
            why = f"{place(own.own.function)} has none: {own.reason[:160]}"
            raise Refused(f"{integrator.id} needs the equations as formulas, and {why}") from error
        with prepared:
            try:
                found, calls = prepared.counted(start[None] if own is None else own.clock.own(start[None]))
            except Unusable as error:
                raise ValueError(f"{integrator.id} {error}") from None
            finally:
                if own is not None:
                    own.raise_failure()
    return found, calls if integrator.counts_rhs else None


def _happened(found: Solution, events: Sequence[Callable[..., Any]]) -> list[list[float]]:
    """The times since the start of each event."""
    times: list[list[float]] = [[] for _ in events]
    for time, name in found.events or ():
        number, way = name.split()
        if counts(events[int(number)], 1 if way == "up" else -1):
            times[int(number)].append(time)
    return times


def _states_at(
    integrator: Integrator, problem: Problem, setting: float, start: Floats, own: OwnEquations | None,
    times: Sequence[Sequence[float]],
) -> list[Floats]:  # fmt: skip
    """The states at the events, from a second integration that has samples there."""
    every = np.unique(np.concatenate([*times, []]))
    if not len(every):
        return [np.empty((0, len(start))) for _ in times]
    again = replace(problem, times=np.unique(np.append(every, problem.times[-1])))
    found, _ = _run(integrator, again, setting, start, own)
    return [found.states[0][np.searchsorted(again.times, each)] for each in times]


def _method(method: str | Integrator | type[Integrator], forms: Sequence[Form]) -> Integrator:
    """The integrator with this id, or the only one with this name that takes one of the forms."""
    if not isinstance(method, str):
        found = lookup.made(method, getattr(method, "__name__", f"method={method!r}"))
    else:
        known = lookup.everything()
        suited = {name: one for name, one in known.items() if _takes(one, forms)}
        try:
            found = lookup.find_one(method, suited)
        except ValueError:
            found = lookup.find_one(method, known)  # it takes other equations, or its error says more
    if not _takes(found, forms):
        needs = " or ".join(kind.__name__ for kind in found.accepts)
        raise ValueError(
            f"{found.id} needs equations as {needs}, not {forms[0].__class__.__name__}; see `gnomon list integrators`"
        )
    reason = lookup.missing(found)
    if reason is not None:
        raise ValueError(f"{found.id} cannot run here: {reason}")
    return found


def _takes(integrator: Integrator, forms: Sequence[Form]) -> bool:
    return first_taken(integrator, forms) is not None


def _with_setting(
    integrator: Integrator, rtol: float | None, atol: float | None, step: float | None
) -> tuple[Integrator, float]:
    """The integrator, with another ratio of the tolerances if `atol` is given, and its setting."""
    fixed = isinstance(integrator.sweep, Steps)
    for name, value, wrong in (("rtol", rtol, fixed), ("atol", atol, fixed), ("step", step, not fixed)):
        if value is not None and wrong:
            instead = "step=..., the size of its steps" if fixed else "rtol=..., its relative tolerance"
            raise ValueError(f"{name}={value!r}: {integrator.id} has no such setting; give {instead}")
        if value is not None and not (np.ndim(value) == 0 and 0 <= value < math.inf and (value > 0 or name == "atol")):
            kind = "; a vector is not supported" if np.ndim(value) else ""
            raise ValueError(f"{name}={value!r}: give a positive number{kind}")
    if fixed:
        if step is None:
            raise ValueError(f"{integrator.id} takes fixed steps: give step=..., the size of its steps")
        return integrator, float(step)
    sweep = integrator.sweep
    assert isinstance(sweep, Tolerance)
    setting = min(max(DEFAULT_RTOL, sweep.tightest), sweep.loosest) if rtol is None else float(rtol)
    if atol is not None:
        if integrator.atol_ratio is None:
            raise ValueError(
                f"atol={atol!r}: {integrator.id} has no absolute tolerance: its errors are relative to the size of the"
                " motion; leave it out"
            )
        integrator = copy.copy(integrator)
        integrator.atol_ratio = float(atol) / setting
    return integrator, setting


def _state(y0: Sequence[float] | Floats, accelerations: bool) -> Floats:
    start = _array(y0, "y0")
    if accelerations and len(start) % 2:
        raise ValueError(f"y0={short(y0)}: give the coordinates and then their rates, as many of each")
    return start


def _array(values: Any, name: str) -> Floats:
    try:
        found = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.ndim != 1 or not len(found) or not np.isfinite(found).all():
        raise ValueError(f"{name}={short(values)}: give a sequence of finite numbers")
    return found


def _refuse_old_order(fun: Any, t_span: Any, y0: Any, method: Any, t_eval: Any, options: dict[str, Any]) -> None:
    """Raise ValueError with the new call for a call as solve(f, t0, y0, times, tolerance, "method")."""
    if not isinstance(t_span, Real) or isinstance(method, str):
        return
    times = np.ravel(np.asarray(method)).tolist()
    name = getattr(fun, "__name__", "fun")
    raise ValueError(
        "the arguments are those of scipy.integrate.solve_ivp now: write "
        f"solve({name}, ({t_span!r}, {times[-1]!r}), {y0!r}, method=..., t_eval={times!r}, rtol={t_eval!r}),"
        " or step=... for a method of fixed steps; args=... for parameters"
    )

"""`solve`: any integrator that gnomon knows, on equations of the reader's own, with the arguments of SciPy's `solve_ivp`."""

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any

import numpy as np
from gnomon.cases.core.consistent import violation
from gnomon.cases.core.forms import Constrained, Form, SecondOrder
from gnomon.harness.contract.integrator import Floats, Integrator, Steps, Tolerance
from gnomon.harness.contract.problem import first_taken
from gnomon.harness.contract.validation import short
from gnomon.harness.registry import lookup
from gnomon.harness.running.clock import Clock
from gnomon.harness.running.dense import MOST_HALVINGS, DenseSolution, interpolate
from gnomon.harness.running.own_functions import Arguments, CaseEquations, OwnEquations
from gnomon.harness.running.pieces import EVEN, SAMPLES, Course, Motion, Stated, Times, array, piece_clock
from gnomon.harness.system.extras import require
from gnomon.harness.system.notebook import view

__all__ = ["Arguments", "Clock", "OdeResult", "OwnEquations", "Times", "solve"]

DEFAULT_RTOL = 1e-9
TIGHT = 1e-10
"""Relative tolerances below this are compared with the effect of rounding the start, by one more integration."""
MOVED = 2.0**20
"""Units in the last place by which its start is moved: far more than the error of the method that both have."""
FIXED_ERROR, FIXED_HALVINGS = 1e-10, 5
"""The error of `sol` that is small enough with fixed steps, and the halvings of polynomials: each step of a method of low
order has a kink at its ends."""
FAR_APART, TINY = 100.0, 1e-300
"""The message warns if states from an integration to other times differ from the result by FAR_APART tolerances or more."""
SAID = {
    "rtol": "its relative tolerance",
    "epsilon": "which bounds the last term of its series and is not an error; the manual advises 1e-9",
}
"""The meaning of the parameters that set the accuracy of a method with error control."""
OWN_NAMES = SAID.keys() - {"rtol"}
INSTEAD = {
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
    sol : DenseSolution or None
        With `dense_output`, the solution as a function of time; its `error` is the error of the interpolation.

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
    sol: DenseSolution | None = None

    @property
    def success(self) -> bool:
        return self.status >= 0

    def plot(self) -> Any:
        """Draw the components against the time.

        Returns
        -------
        altair.Chart
            A chart, which a notebook shows and whose `save` writes .html, .svg or .png.

        Raises
        ------
        ValueError
            Without the packages of the extra `report`.
        """
        require("report", "a chart")
        import altair  # an optional package

        rows = [
            {"t": t, "component": f"y[{i}]", "value": value}
            for i, component in enumerate(self.y.tolist())
            for t, value in zip(self.t.tolist(), component, strict=True)
        ]
        return (
            altair.Chart(altair.Data(values=rows), width=600, height=300)
            .mark_line()
            .encode(x="t:Q", y=altair.Y("value:Q", title=None), color=altair.Color("component:N", title=None))
        )

    def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, Any]:
        return view(f"{self.message}\n{self.y.shape[0]} components at {len(self.t)} times", self.plot)


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
    jumps: Sequence[float] | Floats | None = None,
    max_step: float | None = None,
    first_step: float | None = None,
    jac: Callable[..., Any] | Sequence[Any] | Floats | None = None,
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
        The times of the result, from the first to the last time; by default 64 equally spaced ones, up to a terminal
        event if there is one.
    dense_output : bool
        Whether the result has `sol`, the solution at any time: polynomials through states of the method from further
        integrations, which `nfev` leaves out, until their error is below `rtol` (with fixed steps: below 1e-10, or as
        small as shorter polynomials make it).
    events : callable or list of callables, optional
        ``event(t, y, *args)`` is located where it crosses zero after the start; its attributes `terminal`, also as a
        number of occurrences, and `direction` are as in SciPy.
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
        The step size of a method of fixed steps, shortened so that steps end at equally spaced times; `message` has the
        size that was used. Times may be closer than steps.
    accelerations : bool
        Whether `fun` returns accelerations, for methods that solve q'' = a(t, q).
    jumps : array_like, optional
        Times at which an input of `fun` jumps, such as a held input from a table. The motion is integrated from jump to
        jump, so that no step crosses one; a piece sees only times between its ends.
    max_step, first_step : float, optional
        The longest step and the first step, for methods with error control that have such options.
    jac : callable or array_like, optional
        The Jacobian ``jac(t, y, *args)`` of `fun`, shape (dim, dim), or a constant one, for libraries that take one. By
        default it is derived from the formulas of `fun`; without formulas a library takes differences.
    **options : dict
        `epsilon`, in place of `rtol`, for a method whose accuracy is set by a parameter of this name, as `rebound:IAS15`.
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
    >>> solve(lambda t, y: [y[1], -np.sin(y[0])], (0, 10), [1.0, 0.0], "RK4", [5, 10], step=0.01).message
    'gnomon:RK4 reached the end of the interval, in steps of 0.01.'
    """
    _refuse_old_order(fun, t_span, y0, method, t_eval, options)
    for name in options:
        if name not in OWN_NAMES:
            raise ValueError(f"{name}={options[name]!r}: solve has no such option; {INSTEAD.get(name, 'leave it out')}")
    start = _state(y0, accelerations)
    is_form = isinstance(fun, Form | CaseEquations)
    times = Times.of(t_span, t_eval, len(start) // 2 if accelerations else 0, 1.0 if is_form else None)
    bounds = _bounds(jumps, times)
    located = list(events) if isinstance(events, Sequence) else [] if events is None else [events]
    if is_form:
        _refuse_for_forms(located, times.clock.direction < 0, jumps, args, isinstance(fun, CaseEquations))
    if jac is not None and (is_form or accelerations):
        raise ValueError("jac: only derivatives fun(t, y) have one; it is derived from the formulas: leave jac out")
    stated = Stated(fun, Arguments(tuple(args or ())), located, accelerations, jac)
    clock = piece_clock(times.clock, bounds, bounds[0], bounds[1])
    equations = stated.by(clock, start)
    try:
        chosen = _method(method, equations.forms)
    except ValueError:
        stated = replace(stated, derived=True)
        equations = stated.by(clock, start)
        chosen = _method(method, equations.forms, equations.lacking)
    for form in equations.forms:
        if isinstance(form, Constrained) and (
            wrong := violation(form, float(t_span[0]), start.tolist(), equations.parameters)
        ):
            raise ValueError(f"y0 violates its constraints: {wrong}")
    integrator, setting = _with_setting(chosen, {"rtol": rtol, **options}, atol, step)
    integrator = _with_options(integrator, times.clock, max_step, first_step, jac)
    motion = Motion(stated, integrator, setting, start, times, bounds, {bounds[0]: equations})
    return _result(motion, times, t_eval, bool(dense_output))


def _refuse_for_forms(located: Sequence[Any], backward: bool, jumps: Any, args: Any, is_case: bool) -> None:
    """Raise ValueError for arguments that only a function of the user's can have."""
    if is_case and args:
        raise ValueError(f"args={args!r}: the equations of a case have its numbers; give others to gnomon.case")
    if located or backward:
        raise ValueError(
            "a form states its own events, and runs forward: leave out events, and give t_span=(t0, t1), t0 < t1"
        )
    if jumps is not None:
        raise ValueError(f"jumps={jumps!r}: a form is compiled, without branches or tables; leave jumps out")


def _bounds(jumps: Sequence[float] | Floats | None, times: Times) -> list[float]:
    """The ends of the pieces: the start, the jumps within the span in the direction of time, and the end."""
    clock = times.clock
    ends = sorted((clock.first, clock.last), key=lambda t: clock.direction * t)
    if jumps is None or not np.size(jumps):
        return ends
    inside = {t for t in array(jumps, "jumps").tolist() if clock.first < t < clock.last}
    return [ends[0], *sorted(inside, key=lambda t: clock.direction * t), ends[1]]


def _result(motion: Motion, times: Times, t_eval: Any, is_dense: bool) -> OdeResult:
    wanted, start, events = times.wanted, motion.start, motion.stated.events
    course = motion.at(wanted[times.first :])
    y = np.concatenate([start[None], course.states])[1 - times.first :].T
    status, message = 0, f"{motion.integrator.id} reached the end of the interval{_steps(motion, course)}."
    t_events = y_events = None
    if course.stopped is not None:
        status, message = -1, f"{motion.integrator.id}: {course.stopped}"
        arrived = int(np.argmax([*~np.isfinite(y).all(axis=0), True]))
        wanted, y = wanted[:arrived], y[:, :arrived]
    elif not events and isinstance(motion.integrator.sweep, Tolerance) and motion.setting < TIGHT:
        message += _reach(motion, wanted[times.first :], course.states)
    if events:
        t_events = [np.array(each) for each in course.t_events]
        direction = times.clock.direction
        if course.end is not None:
            status, message = 1, f"A terminal event occurred{_steps(motion, course)}."
            count = int(np.searchsorted(direction * wanted, direction * course.end, "right"))
            wanted, y = wanted[:count], y[:, :count]
            if t_eval is None:
                wanted = np.linspace(motion.bounds[0], course.end, SAMPLES)
        anew = wanted[1:] if course.end is not None and t_eval is None else np.empty(0)
        every = direction * np.unique(direction * np.concatenate([*t_events, anew]))
        states = motion.at(every, to_end=False).states if len(every) else np.empty((0, len(start)))
        y_events = [states[np.searchsorted(direction * every, direction * each)] for each in t_events]
        if len(anew):
            y = np.concatenate([start[None], states[np.searchsorted(direction * every, direction * anew)]]).T
    calls = course.calls if motion.integrator.counts_rhs else None
    sol = None
    end = motion.bounds[-1] if course.end is None else course.end
    if course.stopped is not None:
        end = float(wanted[-1]) if len(wanted) else motion.bounds[0]
    if is_dense and end != motion.bounds[0]:
        sol = _dense(motion, course, end, y)
        if sol.error > 10 * motion.setting and course.step is None:
            message += f" `sol` has an error of {sol.error:.1g}: does an input jump? Name its times in jumps=[...]."
        if wanted.size and not course.changes and course.stopped is None and course.step is None:
            apart = float(np.max(np.abs(sol(wanted) - y).max(axis=1) / np.maximum(np.abs(y).max(axis=1), TINY)))
            if apart > FAR_APART * motion.setting:
                message += (
                    f" `sol` and the states at these times differ by {apart:.1g} of their size: the error of this method"
                    " depends on the times at which its steps end."
                )
    return OdeResult(wanted, y, t_events, y_events, calls, status, message, sol)


def _reach(motion: Motion, wanted: Floats, states: Floats) -> str:
    """Why a tolerance cannot be reached, for messages: the effect of rounding the start, from a start further away."""
    if not len(wanted):
        return ""
    moved = motion.start * (1 + MOVED * 2.0**-52 * (-1.0) ** np.arange(len(motion.start)))
    away = replace(motion, start=moved, is_repeated=True).at(wanted).states
    sizes = np.max(np.abs([motion.start, *states]), axis=0)
    effect = np.max(np.abs(away - states) / np.where(sizes > 0, sizes, 1.0), axis=1) / (2 * MOVED)
    worst = int(np.nanargmax(effect)) if np.isfinite(effect).any() else 0
    if not effect[worst] > motion.setting:
        return ""
    return (
        f" Rounding of the start alone moves this motion by {effect[worst]:.1g} of its size at t = {wanted[worst]:.4g}:"
        f" rtol={motion.setting:g} cannot be reached."
    )


def _dense(motion: Motion, course: Course, end: float, y: Floats) -> DenseSolution:
    """The solution as a function of time, up to its end: the end of the span, a terminal event, or the last time."""
    direction = motion.whole.clock.direction
    inside = {t for t in (*motion.bounds[1:-1], *course.changes) if direction * motion.bounds[0] < direction * t}
    ends = sorted((t for t in inside if direction * t < direction * end), key=lambda t: direction * t)
    sizes = np.abs(y).max(axis=1)
    sizes[sizes == 0] = 1.0
    tolerance, halvings = (FIXED_ERROR, FIXED_HALVINGS) if course.step is not None else (motion.setting, MOST_HALVINGS)
    again = replace(motion, setting=motion.setting if course.step is None else course.step)
    return interpolate(lambda times: again.at(times).states, [motion.bounds[0], *ends, end], sizes, tolerance, halvings)


def _steps(motion: Motion, course: Course) -> str:
    """The size of fixed steps, and why it is not the size that was asked for, for messages."""
    if course.step is None:
        return ""
    asked = motion.setting
    if not course.exact:
        return f", in steps of about {course.step:.6g} that end at the times of the result"
    text = f", in steps of {course.step:.6g}"
    if not math.isclose(course.step, asked, rel_tol=EVEN):
        text += f": step={asked:g} is shortened so that steps end at the times of the result"
    return text


def _method(method: str | Integrator | type[Integrator], forms: Sequence[Form], lacking: str = "") -> Integrator:
    """The integrator with this id, or the only integrator with this name that accepts one of the forms.

    `lacking`: the reason why the forms have no accelerations that depend only on positions.
    """
    if not isinstance(method, str):
        integrator = lookup.make(method, getattr(method, "__name__", f"method={method!r}"))
    else:
        known = lookup.everything()
        suited = {name: integrator for name, integrator in known.items() if _takes(integrator, forms)}
        try:
            integrator = lookup.find_one(method, suited)
        except ValueError:
            integrator = lookup.find_one(method, known)  # it takes other equations, or its error says more
    if not _takes(integrator, forms):
        needs = " or ".join(kind.__name__ for kind in integrator.accepts)
        why = f"; {lacking}" if lacking and SecondOrder in integrator.accepts else ""
        raise ValueError(
            f"{integrator.id} needs equations as {needs}, not {forms[0].__class__.__name__}{why}; see `gnomon list integrators`"
        )
    reason = lookup.missing(integrator)
    if reason is not None:
        raise ValueError(f"{integrator.id} cannot run here: {reason}")
    return integrator


def _takes(integrator: Integrator, forms: Sequence[Form]) -> bool:
    return first_taken(integrator, forms) is not None


def _with_setting(
    integrator: Integrator, accuracy: dict[str, Any], atol: float | None, step: float | None
) -> tuple[Integrator, float]:
    """The integrator, with another ratio of the tolerances if `atol` is given, and its setting.

    `accuracy`: the relative tolerance, and parameters that libraries have in its place, by name.
    """
    fixed = isinstance(integrator.sweep, Steps)
    own = "" if isinstance(integrator.sweep, Steps) else integrator.sweep.name
    accuracies = [(name, value, name != own) for name, value in accuracy.items()]
    for name, value, wrong in (*accuracies, ("atol", atol, fixed), ("step", step, not fixed)):
        if value is not None and wrong:
            instead = "step=..., the size of its steps" if fixed else f"{own}=..., {SAID[own]}"
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
    rtol = accuracy.get(own)
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


def _with_options(
    integrator: Integrator, clock: Clock, max_step: float | None, first_step: float | None, jac: Any
) -> Integrator:
    """The integrator with the options of `solve_ivp` that it takes. Raises ValueError for others, with their names."""
    integrator = copy.copy(integrator)
    for name, value in (("max_step", max_step), ("first_step", first_step), ("jac", jac)):
        if value is None or (name == "max_step" and value == math.inf):
            continue
        if name not in integrator.takes:
            instead = (
                "it needs none, or derives it from the formulas" if name == "jac" else "its steps follow from rtol"
            )
            if isinstance(integrator.sweep, Steps):
                instead = "all its steps have the size step=..."
            raise ValueError(f"{name}: {integrator.id} has no such option: {instead}; leave it out")
        if name == "jac":
            continue
        if not (isinstance(value, Real) and 0 < float(value) < math.inf):
            raise ValueError(f"{name}={value!r}: give a positive number, in the unit of t_span")
        setattr(integrator, name, float(value) / clock.scale)
    return integrator


def _state(y0: Sequence[float] | Floats, accelerations: bool) -> Floats:
    start = array(y0, "y0")
    if accelerations and len(start) % 2:
        raise ValueError(f"y0={short(y0)}: give the coordinates and then their rates, as many of each")
    return start


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

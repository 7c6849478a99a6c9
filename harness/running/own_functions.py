"""A user's functions of (t, y, *args) as the form of a problem: by their formulas, or else by calls from Python."""

import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import product
from numbers import Real
from typing import Any

import numpy as np
from gnomon.cases.core.forms import FirstOrder, Form, Hybrid, Mode, SecondOrder, Transition, Values, first_order
from gnomon.harness.contract.integrator import Floats, Refused
from gnomon.harness.contract.validation import short
from gnomon.harness.kernels.called_equations import Called
from gnomon.harness.kernels.equations import check_values, kernel
from gnomon.harness.kernels.read_function import NoFormulasError, formulas
from gnomon.harness.kernels.straight_line import WithJacobian
from gnomon.harness.running.call_watch import CallWatch, place, user_line
from gnomon.harness.running.clock import Clock

MOST_EVENTS = 6
"""Events of one call: each combination of their signs is a mode of the motion."""
ENDED = "ended"
CALLS, LONG = 5, 0.02
"""CALLS: most calls of a function that are timed, for a message about their cost. LONG: seconds after which none is timed."""
SOON = 1e-9
"""Time, for a start of size 1, after which an event that is zero at the start is evaluated again."""
IN_PARTS = "integrate real and imaginary parts as coordinates of their own, y = [*z.real, *z.imag]"
OUTSIDE = 1e-9
"""Times that are outside of a span by this share of it are there by rounding."""
SAME = 1e-9
"""Formulas and function differ by round-off, which is less in functions that are not ill-conditioned."""


_TOLD = set[str]()
"""The places of functions without formulas that were already named in a warning."""


@dataclass(frozen=True)
class Arguments:
    """The arguments `args` of a user's functions. Their numbers are parameters of the equations, unless they are `fixed`."""

    args: tuple[Any, ...]
    fixed: bool = False

    @property
    def numbers(self) -> list[float]:
        return [] if self.fixed else [float(each) for each in self.args if _is_number(each)]

    def with_parameters(self, parameters: Sequence[Any]) -> list[Any]:
        """The arguments with `parameters` in place of their numbers; all as given if there are none."""
        if not len(parameters):
            return list(self.args)
        values = iter(parameters)
        return [next(values) if _is_number(each) else each for each in self.args]


class NotRealError(ValueError):
    """Raised for values that are not real numbers; the message has the values and the way out."""


def real(values: Any) -> Floats:
    """The values as a float64 array; never without an imaginary part that they have. Raises NotRealError."""
    array = np.asarray(values)
    if array.dtype.kind == "c":
        raise NotRealError(f"gives complex numbers, {short(array.tolist())}: {IN_PARTS}")
    if array.dtype.kind not in "iuf":
        raise NotRealError(f"gives {short(array.tolist())}; let it give real numbers")
    return array.astype(np.float64)


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool | np.bool_)


class OwnFunction:
    """A user's function of (t, y, *args) that gives `outputs` numbers, as a list or in `shape`, by the clock of the problem.

    Its values are multiplied by `factor`. It is called once at the start, a state of the user's: raises ValueError, with
    its name and line, for an exception and for another number of values.
    """

    def __init__(
        self, function: Callable[..., Any], clock: Clock, arguments: Arguments, outputs: int, start: Floats,
        factor: float = 1.0, shape: tuple[int, ...] | None = None,
    ) -> None:  # fmt: skip
        self.function, self.clock, self.arguments, self.outputs = function, clock, arguments, outputs
        self.factor, self.start = factor, start
        values = self.at(clock.within(0.0), start)
        if values.shape not in ((outputs,), shape):
            gives = f"{values.size} values" if values.ndim == 1 else f"an array of shape {values.shape}"
            wanted = (
                f"{outputs} {'is' if outputs == 1 else 'are'}" if shape is None else f"an array of shape {shape} is"
            )
            raise ValueError(f"{place(function)} gives {gives}; {wanted} wanted{self.hint(start)}")

    def at(self, t: float, y: Floats) -> Floats:
        """The values at a time of the user's clock."""
        if not callable(self.function):
            raise ValueError(f"fun={self.function!r}: give a function of (t, y), or a form")
        try:
            with np.errstate(all="ignore"):
                values = np.asarray(self.function(t, y.copy(), *self.arguments.args))
        except Exception as error:
            raise ValueError(self.failed(error, t, y)) from error
        try:
            return np.atleast_1d(real(values))
        except NotRealError as error:
            raise ValueError(f"{place(self.function)} {error}, at t={t:g}") from None

    def failed(self, error: BaseException, t: float, y: Floats) -> str:
        """The text for an exception of the function."""
        state = ", ".join(f"{x:.6g}" for x in y)
        hint = self.hint(y) if isinstance(error, TypeError | IndexError | AttributeError) else ""
        return f"{place(self.function)} raised {type(error).__name__}: {error}, at t={t:.6g}, y=[{state}]{hint}"

    def hint(self, y: Floats) -> str:
        """The advice to exchange t and y, for a function that gives the wanted values only if they are exchanged."""
        try:
            with np.errstate(all="ignore"):
                values = real(self.function(y.copy(), self.clock.within(0.0), *self.arguments.args))
        except Exception:  # it takes neither order
            return ""
        return "; it takes (y, t): gnomon, as solve_ivp, gives (t, y)" if values.shape == (self.outputs,) else ""

    def bound(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """A function with the arguments of the user's as one of (t, state, parameters) by the clock of the problem."""

        def equations(t: Any, state: Any, parameters: Any) -> Any:
            args = self.arguments.with_parameters(parameters)
            return self._scaled(function(self.clock.time(t), self.clock.own(state), *args))

        return equations

    def _scaled(self, values: Any) -> Any:
        if self.factor == 1:
            return values
        return [-each if self.factor == -1 else self.factor * each for each in np.ravel(values)]

    def formulas(self) -> Callable[..., Any]:
        """The function as formulas (t, state, parameters). Raises NoFormulasError."""
        name = getattr(self.function, "__name__", "equations")
        sizes = len(self.start), len(self.arguments.numbers), self.outputs
        own_formulas = formulas(self.function, self.bound, name if name.isidentifier() else "equations", sizes)
        try:
            check_values(own_formulas, sizes[:2], self.outputs)  # before it is compiled, which does the same
        except ValueError as error:
            raise NoFormulasError(str(error)) from error
        plain, start = self.bound(self.function), self.clock.given(self.start)
        for t, y in ((0.0, start), (0.125, 1.125 * start + 0.125)):
            try:
                with np.errstate(all="ignore"):
                    wanted = np.ravel(plain(t, y.copy(), ())).astype(np.float64)
                    got = own_formulas(t, tuple(y.tolist()), tuple(self.arguments.numbers))
            except Exception:  # outside of its domain there is nothing to compare
                continue
            if not np.allclose(got, wanted, rtol=SAME, atol=SAME * np.abs(wanted).max(), equal_nan=True):
                raise NoFormulasError("it gives other values on symbols than on numbers")
        return own_formulas

    def called(self) -> Called:
        """The function as equations that are called from Python, at times between the limits of the clock."""
        return Called(self._from_python, self.outputs)

    def _from_python(self, t: float, y: Floats) -> Any:
        clock, args = self.clock, self.arguments.args
        state, wanted, time = clock.own(y), clock.time(t), clock.within(t)
        values = real(self.function(time, state.copy(), *args))
        if abs(wanted - time) > OUTSIDE * (clock.last - clock.first):
            # Substeps of some splitting methods leave their step. That is no harm if the time does not matter.
            for other in (clock.first, 0.5 * (clock.first + clock.last)):
                if not np.array_equal(values, real(self.function(other, state.copy(), *args)), equal_nan=True):
                    raise Refused(
                        f"{place(self.function)} depends on time, and this method evaluates it outside of its steps, at"
                        f" t={wanted:g}, where it may not be known: take a method whose"
                        " substeps stay within its steps, as gnomon:Störmer-Verlet or gnomon:RKN 12(10)"
                    )
        return self._scaled(values)

    def seconds(self) -> float:
        """The least time of some calls; of one if it is long."""
        spent = list[float]()
        while len(spent) < CALLS and sum(spent) < LONG:
            began = time.perf_counter()
            self.at(self.clock.within(0.0), self.start)
            spent.append(time.perf_counter() - began)
        return min(spent)


class OwnEquations:
    """A user's `fun`, which gives derivatives or accelerations, as forms; `called` if it has no formulas, with the reason."""

    def __init__(
        self, function: Callable[..., Any], clock: Clock, arguments: Arguments, start: Floats, accelerations: bool
    ) -> None:
        half = len(start) // 2
        of, by = (start[:half], replace(clock, mirrored=0)) if accelerations else (start, clock)
        factor = clock.scale**2 if accelerations else clock.rate
        self.clock, self.start = clock, start
        self.called: Called | None = None
        self.jacobian: Called | None = None
        for each in (arguments, replace(arguments, fixed=True)):  # it may branch on a number of `args`
            self.own = OwnFunction(function, by, each, len(of), of, factor)
            self.own_jacobian = self.own
            self.parameters = each.numbers
            try:
                equations = self.own.formulas()
            except NoFormulasError as error:
                self.reason = str(error)
            else:
                form: Form = SecondOrder(equations) if accelerations else FirstOrder(equations)
                self.forms = tuple(dict.fromkeys(x for x in (form, first_order(form)) if x is not None))
                return
        self._call_from_python(accelerations)

    def with_jacobian(self, jacobian: Any) -> None:
        """Give the equations of first order a Jacobian of the user's, a function of (t, y, *args) or a matrix."""
        n = len(self.start)
        constant = None if callable(jacobian) else np.asarray(jacobian)
        function = jacobian if constant is None else lambda t, y, *args: constant
        own = OwnFunction(function, self.clock, self.own.arguments, n * n, self.start, self.clock.rate, (n, n))
        try:
            partials: Any = own.formulas()
        except NoFormulasError:
            partials = self.jacobian = own.called()
            self.own_jacobian = own
        self.forms = tuple(
            WithJacobian(x.equations, source=x.source, jacobian=partials) if isinstance(x, FirstOrder) else x
            for x in self.forms
        )

    def _call_from_python(self, accelerations: bool) -> None:
        called = self.called = self.own.called()
        called.watch = CallWatch(place(self.own.function), self.own.clock)
        self.forms = (FirstOrder(called),)
        if accelerations:
            half = self.own.outputs

            def motion(t: float, state: Floats) -> Floats:
                return np.concatenate([state[half:], called.values(t, state[:half])])

            self.forms = (SecondOrder(called), FirstOrder(Called(motion, 2 * half)))
        where = place(self.own.function)
        if where not in _TOLD:
            _TOLD.add(where)
            warnings.warn_explicit(
                f"{where} has no formulas ({self.reason[:160]}): gnomon compiles only arithmetic and functions of math and NumPy,"
                f" without decisions by values of the motion. It is called from Python, {1e6 * self.own.seconds():.2g} µs a"
                " call; compiled equations take some 0.1 µs",
                UserWarning,
                *user_line(),
            )

    def raise_failure(self) -> None:
        """Raise the exception that stopped a call from Python, if there was one."""
        for called, own in ((self.called, self.own), (self.jacobian, self.own_jacobian)):
            if called is None or called.failure is None:
                continue
            error, t, y = called.failure
            if not isinstance(error, Exception) or isinstance(error, Refused | Warning):
                raise error
            clock = own.clock
            raise ValueError(own.failed(error, clock.within(t), clock.own(y))) from error


@dataclass(frozen=True)
class CaseEquations:
    """The equations of motion of a case: `print` shows them, a call gives the derivatives, `gnomon.solve` takes them.

    Attributes
    ----------
    forms : tuple of forms
        The forms of the dynamics, the most structured first.
    case : str
        The name of the case.
    coordinates : tuple of str
        The names of the coordinates of the state.
    parameters : dict of str to float
        The parameters by name.

    Examples
    --------
    >>> import gnomon
    >>> equations = gnomon.case("harmonic_oscillator").equations
    >>> equations(0.0, [1.0, 0.0])
    array([ 0., -1.])
    """

    forms: tuple[Form, ...]
    case: str
    coordinates: tuple[str, ...]
    parameters: dict[str, float]
    text: Callable[[], tuple[list[str], list[str]]] = field(repr=False)
    """The lines of the equations as text, and in LaTeX."""

    def __repr__(self) -> str:
        return "\n".join(self.text()[0])

    def _repr_latex_(self) -> str:
        return "\n".join(f"$${each}$$" for each in self.text()[1])

    @cached_property
    def _kernel(self) -> Any:
        form = next((x for x in self.forms if isinstance(x, FirstOrder)), None)
        if form is None:
            raise ValueError(
                f"{self.case} has no equations of one smooth motion; `gnomon show {self.case}` prints its modes"
            )
        return kernel(form, len(self.parameters), len(self.coordinates))

    def __call__(self, t: float, y: Sequence[float] | Floats) -> Floats:
        """The derivatives of a state (dim,) at a time."""
        numbers = np.array([*self.parameters.values()])
        derivatives: Floats = self._kernel.array(float(t), np.array(y, dtype=np.float64), numbers)
        return derivatives


def with_events(equations: OwnEquations, events: Sequence[Callable[..., Any]], before: Sequence[int] = ()) -> Hybrid:
    """The hybrid form of equations with events: a mode for each combination of the signs of the events.

    A transition is named `number up` or `number down` if event `number` rises or falls through zero. A terminal event leads
    to a mode in which nothing moves. An event whose `terminal` is a number n leads there at its n-th occurrence; `before` has
    the occurrences of each event in earlier pieces of the motion.
    """
    if len(events) > MOST_EVENTS:
        raise ValueError(f"events: {len(events)} are given; solve locates at most {MOST_EVENTS} in one call")
    own, form = equations.own, equations.forms[-1]
    if equations.called is not None:
        raise ValueError(f"{place(own.function)} has no formulas ({equations.reason[:160]}), which events need")
    assert isinstance(form, FirstOrder)
    guards, most = [], [most_occurrences(event) for event in events]
    for event in events:
        try:
            guards.append(OwnFunction(event, equations.clock, own.arguments, 1, equations.start).formulas())
        except NoFormulasError as error:
            raise ValueError(f"{place(event)} has no formulas ({str(error)[:160]}); write the event as one") from None
    signs = list(product((-1, 1), repeat=len(events)))
    modes = [Mode(_mode(each), form.equations) for each in signs] + [Mode(ENDED, at_rest)]
    occurred = Occurrences(tuple(before) or (0,) * len(events))
    transitions = []
    for sign in signs:
        for k, (event, guard) in enumerate(zip(events, guards, strict=True)):
            target: Any = _mode((*sign[:k], -sign[k], *sign[k + 1 :]))
            if most[k] and is_counted(event, -sign[k]):
                target = ENDED if most[k] == 1 else partial(occurred.next_mode, k, most[k], target)
            name = f"{k} {'up' if sign[k] < 0 else 'down'}"
            transitions.append(Transition(name, _mode(sign), guard, -sign[k], _same, target))
    start = partial(_first_mode, occurred, guards, form.equations)
    return Hybrid(tuple(modes), start, tuple(transitions), 0.0, frozenset({ENDED}))


def most_occurrences(event: Callable[..., Any]) -> int:
    """The occurrence of an event that ends the integration, 1 for the first, 0 if none does. Raises ValueError."""
    ends = getattr(event, "terminal", False)
    if ends is None or ends is False or ends is True or isinstance(ends, np.bool_):
        return int(bool(ends))
    if not _is_number(ends) or ends != round(ends) or ends < 0:
        raise ValueError(
            f"{place(event)}: terminal={ends!r}: give True, False, or the number of the occurrence that ends the"
            " integration"
        )
    return int(ends)


@dataclass
class Occurrences:
    """The numbers of occurrences of each event: `before` the start of a trajectory, and in all `so_far`."""

    before: tuple[int, ...]
    so_far: list[int] = field(default_factory=list)

    def next_mode(self, event: int, most: int, mode: str, t: Any, state: Values, parameters: Values) -> str:
        """Count an occurrence of an event, and give the next mode: `mode`, or the end at occurrence `most`."""
        self.so_far[event] += 1
        return ENDED if self.so_far[event] >= most else mode


def is_counted(event: Callable[..., Any], direction: float) -> bool:
    """Whether an event counts if it crosses zero in this direction, rising (1) or falling (-1), during the integration."""
    wanted = getattr(event, "direction", 0)
    return bool(wanted == 0 or wanted * direction > 0)


def _mode(signs: Sequence[int]) -> str:
    return "".join("+" if sign > 0 else "-" for sign in signs)


def _same(t: Any, state: Values, parameters: Values) -> Values:
    return state


def at_rest(t: Any, state: Values, parameters: Values) -> Values:
    """Equations in which nothing moves."""
    return tuple(0.0 * x for x in state)


def _first_mode(
    occurred: Occurrences, guards: Sequence[Callable[..., Any]], equations: Callable[..., Any], t: Any, state: Values,
    parameters: Values,
) -> str:  # fmt: skip
    """The mode at the start. An event that is zero at the start counts with its sign right after."""
    occurred.so_far = list(occurred.before)
    signs = []
    for guard in guards:
        value = guard(t, state, parameters)[0]
        if value == 0:
            ahead = SOON * max(1.0, max(map(abs, state)))
            later = tuple(x + ahead * rate for x, rate in zip(state, equations(t, state, parameters), strict=True))
            value = guard(t + ahead, later, parameters)[0]
        signs.append(1 if value > 0 else -1)
    return _mode(signs)

"""A case: one initial value problem whose exact motion is known."""

from __future__ import annotations

import bisect
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import isfinite, isnan, tau
from operator import attrgetter
from typing import Any, ClassVar, Self

import numpy as np
from gnomon.cases.core import accuracy, sampling
from gnomon.cases.core.declared import Attitude, Coordinate, Declared
from gnomon.cases.core.forms import FirstOrder, Form, Hybrid, SecondOrder, first_order
from gnomon.cases.core.formulation import Formulation
from gnomon.cases.core.interface import Between
from gnomon.cases.core.metric import Metric
from gnomon.cases.core.numbers import DURATION, LARGEST, SMALLEST, OutOfReachError, given, show
from gnomon.cases.core.scene import SceneForm
from gnomon.cases.core.turning import Turning
from gnomon.reference.numerics.motion import MANY, Motion
from gnomon.reference.numerics.pointwise import SAMPLE_DIGITS
from gnomon.reference.numerics.precision import Number, exact, nearest_double, quantity
from mpmath import mpf
from numpy.typing import NDArray

Floats = NDArray[np.float64]
MOST_EVENTS = 10_000
"""Most events within a span: each takes about a millisecond to compute."""
EVENT_DIGITS = 20
"""Digits of the times of events, between which the motion is smooth."""


UNITS = {"time scale": 1.0, "turn": tau}
"""Units of a `Span` in time scales of the case."""


@dataclass(frozen=True)
class Span:
    """A span that follows from the numbers of a case.

    A case whose span depends on its numbers in another way has its own `natural_span`, which may read `periods`.

    Parameters
    ----------
    periods : number
        Number of units, as a parameter is given: 10.37 or "10.37".
    unit : str or Callable
        "time scale", "turn" (2 pi time scales), or a function of the exact motion that returns a time (s).
    otherwise : number
        Number of time scales in the span where that time is None or infinite.

    Examples
    --------
    >>> turns = Span(10.37, "turn")
    >>> swings = Span(10.37, lambda motion: motion.period(20), otherwise=9)
    """

    periods: Number
    unit: str | Callable[[Any], Any]
    otherwise: Number = 10


@dataclass(frozen=True, slots=True)
class Event:
    """One event of a hybrid motion.

    Attributes
    ----------
    time : mpf
        The time (s).
    name : str
        The name of its transition, or ``limit``.
    before, after : tuple of mpf
        The states before and after the event, as the case has them.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> get("bouncing_ball").events()[0].name
    'bounce'
    """

    time: Any
    name: str
    before: tuple[Any, ...]
    after: tuple[Any, ...]


@dataclass(frozen=True)
class Invariant:
    """A quantity with a known law. `function(t, state, parameters)` -> (value,), written with the rules of equations.

    `law` is "constant", or "decays" for a quantity that never grows.
    """

    function: Callable[[Any, tuple[Any, ...], tuple[Any, ...]], tuple[Any, ...]]
    law: str = "constant"


def conserved(**functions: Callable[[Any, tuple[Any, ...], tuple[Any, ...]], tuple[Any, ...]]) -> dict[str, Invariant]:
    """Invariants that are constant on the motion.

    Parameters
    ----------
    **functions : Callable
        (t, state, parameters) -> (value,), by the name of the invariant.

    Returns
    -------
    dict[str, Invariant]
        For `Case.invariants`; a case with both kinds states `conserved(...) | decaying(...)`.

    Examples
    --------
    >>> def energy(t, state, p):
    ...     return (state[1] ** 2 / 2 + state[0] ** 2 / 2,)
    >>> conserved(energy=energy)["energy"].law
    'constant'
    """
    return {name: Invariant(function) for name, function in functions.items()}


def decaying(**functions: Callable[[Any, tuple[Any, ...], tuple[Any, ...]], tuple[Any, ...]]) -> dict[str, Invariant]:
    """Quantities that never grow on the motion, such as an energy with friction.

    Parameters
    ----------
    **functions : Callable
        (t, state, parameters) -> (value,), by the name of the quantity.

    Returns
    -------
    dict[str, Invariant]
        For `Case.invariants`.

    Examples
    --------
    >>> decaying(energy=lambda t, state, p: (state[1] ** 2 / 2,))["energy"].law
    'decays'
    """
    return {name: Invariant(function, "decays") for name, function in functions.items()}


@dataclass(frozen=True)
class Level:
    """One level of a model hierarchy, which begins with the crudest model.

    Parameters
    ----------
    case : Case
        The model.
    project : Callable
        Maps states of the model, shape (n, dim), to states of the case that has the hierarchy.
    effect : str
        The effect that this level adds to the level before.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> Level(get("harmonic_oscillator"), same, "a linear spring").effect
    'a linear spring'
    """

    case: Case
    project: Callable[[Floats], Floats]
    effect: str


def same(states: Floats) -> Floats:
    """The projection of a level whose model has the same state as the case that has the hierarchy.

    Parameters
    ----------
    states : ndarray, shape (n, dim)
        States of the model.

    Returns
    -------
    ndarray, shape (n, dim)
        The array `states` itself.

    Examples
    --------
    >>> same(np.zeros((3, 2))).shape
    (3, 2)
    """
    return states


class Case(Declared):
    """One initial value problem with exact numbers. A subclass is one case; an instance is that case with given numbers.

    A subclass declares its numbers, exact motion, variants and `forms`. It also declares each attribute and method below
    whose default does not suit the case. A property below may be a class attribute if it does not depend on the numbers:
    `forms = (FirstOrder(f),)`. If the book describes a system without equations, `conventions` begins with [inferred] and
    states the model. `gnomon.cases.get` makes an instance from a name.

    Parameters
    ----------
    variant : str, optional
        The name of a variant, whose numbers replace the defaults.
    initial_state : sequence of number, optional
        The initial state in the order of the coordinates, in their units.
    span : number, optional
        The duration (s).
    **parameters : number
        Parameters, and starts of coordinates, by name, in their units.

    Raises
    ------
    ValueError
        For an unknown variant or name, and for numbers outside the domain.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> circle = get("kepler_orbit", span=10)
    >>> [coordinate.name for coordinate in circle.state]
    ['x', 'y', 'vx', 'vy']
    >>> circle.sample(circle.times).shape
    (64, 4)
    """

    state: ClassVar[tuple[Coordinate, ...]]
    default_state: ClassVar[tuple[Number, ...]]
    """The starts of the coordinates, which a case may state together."""
    default_span: ClassVar[Number | Span]
    """The span if neither the caller nor the variant gives one, in seconds or as a `Span`."""
    invariants: ClassVar[Mapping[str, Invariant]] = {}
    turning: ClassVar[Turning | None] = None
    """The rotational symmetry of the case, if it has one: errors are then medians over turned starts."""
    autonomous: ClassVar[bool] = True
    mirror: ClassVar[tuple[str, ...]] = ()
    """Coordinates and parameters: if all of them change sign, these coordinates of the motion do too; () if there are none."""
    alike: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """For each of several like bodies or axes, the names of its coordinates and parameters. If each body takes the numbers
    of the next body, and the last body the numbers of the first, then each takes the motion of the next; () without any."""
    default_horizon: ClassVar[Number | None] = None
    """For a chaotic motion, the time (s) at which the conditioning of the default reaches 1."""
    certified_digits: ClassVar[int] = 45
    """Digits of the motion that its certificate must confirm: 45 of a closed form, 30 of a motion by integration."""

    exact_motion: Motion
    """The exact motion, which a case declares by `bind`."""
    initial_state: tuple[Fraction, ...]
    span: Fraction

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if any(isinstance(each, Coordinate | Attitude) for each in vars(cls).values()):
            cls.state = tuple(each for each in cls._declared().values() if isinstance(each, Coordinate))
            if "default_state" not in vars(cls):
                cls.default_state = tuple(each.start for each in cls.state)

    def __init__(
        self,
        variant: str | None = None,
        initial_state: Sequence[Number] | None = None,
        span: Number | None = None,
        **parameters: Number,
    ) -> None:
        setting = self._variant(variant)
        start = initial_state if initial_state is not None else setting.initial_state
        start = self.default_state if start is None else start
        self.variant = variant
        names = [coordinate.name for coordinate in self.state]
        starts = {name: parameters.pop(name) for name in names if name in parameters}
        self.parameters = self._parameters(setting, parameters, names)
        if len(start) != len(names):
            raise ValueError(
                f"{self.name}: the initial state has {len(start)} numbers, not {len(names)} ({', '.join(names)})"
            )
        if initial_state is not None and starts:
            raise ValueError(f"{self.name}: {next(iter(starts))} is given, and an initial state; give one of the two")
        self.initial_state = tuple(map(self._given, names, (dict(zip(names, start, strict=True)) | starts).values()))
        with self._within_reach():
            self.domain.check(self.name, self.numbers)
            self._span_given = False
            wanted = span if span is not None else setting.span
            self.span = self._natural() if wanted is None else given(wanted, f"{self.name}: span", DURATION)
        self._span_given = wanted is not None
        if self.span <= 0:
            raise ValueError(f"{self.name}: span = {show(self.span)} is not positive; give a duration in seconds")

    def _natural(self) -> Fraction:
        span = exact(self.natural_span(), "its natural span")
        if not SMALLEST <= span <= LARGEST:
            raise ArithmeticError(f"its natural span, {show(span)} s, is not within 1e-300 and 1e300 s")
        return span

    def motion(self) -> Motion:
        """The exact motion of these numbers."""
        return self.exact_motion

    @classmethod
    def motion_of(cls, numbers: Mapping[str, Fraction]) -> Any:
        """The exact motion of numbers by name, for rules of the domain; `exact_motion` binds a dataclass."""
        bound: Any = cls.exact_motion
        return bound.of(numbers)

    @property
    def forms(self) -> tuple[Form, ...]:
        """The forms of the dynamics, the most structured first. `all_forms` adds the first-order form that follows."""
        raise NotImplementedError

    def scales(self) -> dict[str, float]:
        """The largest norm of each group over the span (of angles at most pi), by which the metric divides.

        Computed on a grid; a case with peaks narrower than the grid spacing overrides this with closed forms.
        """
        return accuracy.grid_scales(self)

    @property
    def time_scale(self) -> float:
        """The characteristic time (s): a period over 2 pi or a decay time, the shortest that the solution shows."""
        raise NotImplementedError

    @property
    def fastest_time(self) -> float:
        """The shortest time in the equations (s), also of modes that decay at once."""
        return self.time_scale

    @property
    def periods(self) -> float:
        """How many units of its `Span` the natural span has: by the variant, else by the case."""
        wanted = self._variant(self.variant).periods
        assert isinstance(self.default_span, Span)
        return self._count(self.default_span.periods if wanted is None else wanted, "the periods of its span")

    def _count(self, wanted: Number, what: str) -> float:
        return float(given(wanted, f"{self.name}: {what}", DURATION))

    def natural_span(self) -> Number:
        """The span (s) that is used if neither the caller nor the variant gives one."""
        span = self.default_span
        if not isinstance(span, Span):
            return span
        if isinstance(span.unit, str):
            if span.unit not in UNITS:
                raise ValueError(
                    f"{self.name}: Span has the unit {span.unit!r}; give {' or '.join(map(repr, UNITS))}, a function of the "
                    "exact motion that returns a time, or write a method natural_span"
                )
            return self.periods * UNITS[span.unit] * self.time_scale
        period = span.unit(self.exact_motion)
        return (
            self.periods * float(period)
            if period is not None and isfinite(period)
            else self._count(span.otherwise, "`otherwise` of its span") * self.time_scale
        )

    @property
    def quantity_names(self) -> tuple[str, ...]:
        """Derived quantities that attributes of the exact motion have: numbers, or methods of the number of digits.

        "period" is a quantity and its attribute. "rise=swing.height" gives the attribute `swing.height` the name "rise".
        "least largest=turning_points" names both numbers of the attribute `turning_points`, which is a tuple.
        """
        return ()

    def derived(self, digits: int) -> dict[str, Any]:
        """Other derived quantities by name.

        Each is an exact number, a function of an mpmath context, an mpf, or None where the motion has no such quantity.
        """
        return {}

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """Derived quantities by name, SI units, to `digits` significant digits: period, stop time and others.

        They are the `quantity_names` and `derived`, without quantities that this motion does not have.
        """
        quantities: dict[str, Any] = {}
        for entry in self.quantity_names:
            names, _, attribute = entry.partition("=")  # "names=attribute" or one word for both
            value = attrgetter(attribute or names)(self.exact_motion)
            value = value(digits) if callable(value) else value
            if value is not None:
                quantities |= zip(names.split(), value if isinstance(value, tuple) else (value,), strict=True)
        quantities |= self.derived(digits)
        return {name: _rounded(value, digits) for name, value in quantities.items() if value is not None}

    @property
    def reversal(self) -> tuple[str, ...] | None:
        """The coordinates and parameters whose signs time reversal changes; None for a case without time reversal.

        The velocities of a second-order form whose acceleration depends on position alone; other cases state it.
        """
        if self.second_order is None or not self.autonomous:
            return None
        return tuple(coordinate.name for coordinate in self.state[len(self.state) // 2 :])

    def events(self, digits: int = 15) -> tuple[Event, ...]:
        """The events of a hybrid motion within the span, sorted by time; computed once for each precision."""
        if digits not in self._events:
            with self._within_reach():
                self._events[digits] = self.list_events(digits)
        return self._events[digits]

    @cached_property
    def _events(self) -> dict[int, tuple[Event, ...]]:
        return {}

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """Compute the events; a hybrid case overrides this."""
        return ()

    def limit_events(self, events: float, most: int = MOST_EVENTS) -> None:
        """Raise ArithmeticError if `events`, the expected number within the span, is above `most`."""
        if events > most:
            span = float(self.span)
            raise ArithmeticError(
                f"span = {show(self.span)} s holds about {events:.2g} events, and at most {most:,} are listed; "
                f"give at most {span * (most / events):g} s"
            )

    def between(self, t: float) -> Between:
        """The events around the time t (s), their times to 20 digits."""
        times = [event.time for event in self.events(20)]
        past = bisect.bisect_right(times, t)
        edges = [mpf(0), *times, mpf("inf")]
        last, following = edges[past], edges[past + 1]
        return Between(past, last, following, following - last if past < len(times) else last - edges[max(past - 1, 0)])

    def event_time(self, n: int, digits: int = 15) -> Any:
        """Time (s) of event n = 1, 2, ...; infinite if the motion has fewer events."""
        events = self.events(digits)
        return events[n - 1].time if n <= len(events) else mpf("inf")

    @property
    def formulations(self) -> tuple[Formulation, ...]:
        """Other ways to write the same case."""
        return ()

    @property
    def scene(self) -> SceneForm | None:
        """The scene for a physics engine; None if bodies, joints, forces and contacts cannot express the case."""
        return None

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The models from the crudest up to this case, which is not listed."""
        return ()

    def same_course(self, other: Case) -> bool:
        """Whether a case with numbers half an ulp away passes through the same modes; conditioning uses only such cases."""
        return True

    def reversed(self, state: Sequence[Any]) -> tuple[tuple[Any, ...], dict[str, Fraction]] | None:
        """The state and parameters whose motion retraces this one backwards; None if there is no time reversal."""
        changed = self.reversal
        if changed is None:
            return None
        back = (-x if c.name in changed else x for c, x in zip(self.state, state, strict=True))
        return tuple(back), {name: -x if name in changed else x for name, x in self.parameters.items()}

    @property
    def numbers(self) -> dict[str, Fraction]:
        """Parameters and initial state by name."""
        names = [coordinate.name for coordinate in self.state]
        return self.parameters | dict(zip(names, self.initial_state, strict=True))

    @contextmanager
    def _within_reach(self) -> Iterator[None]:
        """Turns errors of the exact motion into OutOfReachError, which names the case and its numbers."""
        try:
            yield
        except (ArithmeticError, ValueError, RecursionError) as error:
            if isinstance(error, ValueError) and str(error).startswith(f"{self.name}: "):
                raise
            given_span = f", span = {show(self.span)} s" if self._span_given and "span = " not in str(error) else ""
            unusual = self.domain.unusual(self.numbers)
            raise OutOfReachError(f"{self.name}: {unusual}{given_span}: {error}") from error

    def rounded(self) -> Case:
        """The same case with every number rounded to binary64; its exact motion belongs to the rounded numbers."""
        parameters: dict[str, Any] = {name: float(value) for name, value in self.parameters.items()}
        start = [float(value) for value in self.initial_state]
        copy = type(self)(initial_state=start, span=float(self.span), **parameters)
        copy.variant = self.variant
        with copy._within_reach():
            _ = copy.time_scale
        return copy

    def with_numbers(self, initial_state: Sequence[Number], parameters: Mapping[str, Number]) -> Self:
        """The same case and span with other numbers."""
        named: dict[str, Any] = dict(parameters)
        copy = type(self)(initial_state=initial_state, span=self.span, **named)
        copy.variant = self.variant
        return copy

    def level(self, kind: type[Case], effect: str, **changed: Any) -> Level:
        """A level of the hierarchy with the same state: a model with this case's start, span and numbers of equal names."""
        own = {each.name: self.parameters[each.name] for each in kind.parameter_list if each.name in self.parameters}
        return Level(kind(initial_state=self.initial_state, span=self.span, **(own | changed)), same, effect)

    def with_span(self, span: Number) -> Case:
        """The same case over another span."""
        named: dict[str, Any] = dict(self.parameters)
        return type(self)(initial_state=self.initial_state, span=span, **named)

    @cached_property
    def _motion(self) -> Motion:
        return self.motion()

    def exact(self, t: Number, digits: int = 15) -> tuple[Any, ...]:
        """The exact state at time t to `digits` significant digits; at an event, the state after it.

        At 0 it is the initial state: a formula would leave a remainder in place of a zero.
        """
        with self._within_reach():
            if not exact(t, "t"):
                return tuple(_rounded(x, digits) for x in self.initial_state)
            return self._motion.state(t, digits)

    def all_forms(self) -> tuple[Form, ...]:
        """`forms`, with the first-order form that they imply; hybrid forms with the time in which they settle."""
        forms = tuple(map(self._settled, self.forms))
        if any(isinstance(form, FirstOrder) for form in forms):
            return forms
        implied = next((f for f in map(first_order, forms) if f is not None), None)
        return forms if implied is None else (*forms, implied)

    def _settled(self, form: Form) -> Form:
        if isinstance(form, Hybrid) and isnan(form.settle):
            return replace(form, settle=1e-9 * self.time_scale)
        return form

    def parameter_values(self) -> tuple[Fraction, ...]:
        """The values of the parameters as the tuple that equations take."""
        return tuple(self.parameters[p.name] for p in self.parameter_list)

    @cached_property
    def times(self) -> Floats:
        """The 64 sample times (s), shape (64,): equally spaced, exact in binary64, away from events."""
        with self._within_reach():
            return sampling.sample_times(self)

    def sample(self, times: Floats) -> Floats:
        """Exact states at `times`, shape (len(times), len(state)), each value within 0.51 ulp; fast for many times.

        Next to zeros each value is the nearest double.
        """
        with self._within_reach():
            moments = np.asarray(times, dtype=np.float64)
            if type(self).exact is not Case.exact:  # a case with its own way to the exact state, without a motion
                return np.array([[nearest_double(x) for x in self.exact(t, SAMPLE_DIGITS)] for t in moments.tolist()])
            states = np.tile([float(x) for x in self.initial_state], (len(moments), 1))  # at 0 as in `exact`
            late = moments != 0
            if len(moments) >= MANY:
                breaks = [event.time for event in self.events(EVENT_DIGITS)]
                states[late] = self._motion.sample(moments[late], float(self.span), breaks)
            elif np.any(late):
                states[late] = self._motion.sample(moments[late])
            return states

    @cached_property
    def metric(self) -> Metric:
        """The distance between two states."""
        return Metric.scaled(self, self.scales(), accuracy.crowded(self) if self.hybrid is not None else frozenset())

    def floor(self, times: Floats) -> Floats:
        """Half an ulp of the exact state in the metric, shape (len(times),): no binary64 answer can be closer."""
        return accuracy.floor(self, np.asarray(times, dtype=np.float64))

    def conditioning(self, times: Floats) -> Floats:
        """Typical effect in the metric of half an ulp in initial state, parameters and time, shape (len(times),).

        Kept on disk.
        """
        return accuracy.conditioning(self, np.asarray(times, dtype=np.float64))

    @property
    def horizon(self) -> float | None:
        """The time (s) at which the conditioning of a chaotic motion reaches 1: beyond it no digit can be right.

        None for a motion that is not chaotic, and for numbers other than those of a variant or the default.
        """
        setting = self._variant(self.variant)
        stated = self.default_horizon if self.variant is None else setting.horizon
        start = self.default_state if setting.initial_state is None else setting.initial_state
        own = (*self._parameters(setting, {}).values(), *map(exact, start))
        same_numbers = [float(x) for x in own] == [float(x) for x in self.numbers.values()]
        return float(exact(stated)) if stated is not None and same_numbers else None

    @property
    def scored(self) -> tuple[str, ...]:
        """The groups that count in the distance; all groups if it is empty."""
        return self._variant(self.variant).scored

    @property
    def stresses(self) -> str:
        """The difficulty of its variant, in words; "" for the default."""
        return "" if self.variant is None else self._variant(self.variant).stresses

    def explain_form(self, accepted: str) -> str:
        """Why an integrator that takes the `accepted` forms cannot have this case."""
        offered = [type(form).__name__ for form in self.all_forms()] + (["Scene"] if self.scene is not None else [])
        return f"takes {accepted}; the case offers {', '.join(offered)}"

    @property
    def hybrid(self) -> Hybrid | None:
        return next((form for form in map(self._settled, self.forms) if isinstance(form, Hybrid)), None)

    @property
    def second_order(self) -> SecondOrder | None:
        return next((form for form in self.forms if isinstance(form, SecondOrder)), None)

    def __repr__(self) -> str:
        numbers = ", ".join(f"{name}={float(value):g}" for name, value in self.numbers.items())
        return f"<{self.id}: {numbers}, span {float(self.span):g} s>"


def _rounded(value: Any, digits: int) -> Any:
    if callable(value):
        return quantity(digits, value)
    return quantity(digits, lambda mp: mp.mpf(value)) if isinstance(value, int | Fraction) else value

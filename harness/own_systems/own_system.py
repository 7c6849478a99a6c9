"""A user's own equations as a case, whose exact motion is a computed reference: runs, scores and figures take it as any."""

from __future__ import annotations

import hashlib
import inspect
import re
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core import accuracy
from gnomon.cases.core.case import Event
from gnomon.cases.core.declared import Coordinate, Parameter
from gnomon.cases.core.forms import FirstOrder, Form, Hybrid
from gnomon.cases.core.metric import Metric
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.contract.sources import of_value
from gnomon.harness.kernels.called_equations import Called
from gnomon.harness.kernels.derived_forms import derive_forms
from gnomon.harness.measuring.rounding_effect import Rates, RoughMotion, rough_motion, rounding_effect
from gnomon.harness.own_systems.hybrid_reference import (
    HybridMotion,
    binary64_events,
    case_events,
    hybrid_effect,
    hybrid_in_binary64,
    hybrid_reference,
    rough_hybrid,
)
from gnomon.harness.own_systems.lines import call_lines, explain_form, name_of
from gnomon.harness.own_systems.smooth_reference import EXPLICIT_WORK, Reference, smooth_reference
from gnomon.harness.running.pieces import Stated, Times, array
from gnomon.reference.numerics.precision import Number

from gnomon import cases

LOST = 0.1
"""Effect of rounding, over the size of a coordinate, at which no digit of it is left."""


class OwnSystem(Case):
    """A user's own equations, from their start, over their span. A subclass for each is made by `make_system`.

    The state is in the sequence `order` of the user's coordinates, and the time by the problem's clock: from 0, forward.
    """

    section = "own"
    autonomous: ClassVar[bool] = False
    forms_: ClassVar[tuple[Form, ...]]
    smooth: ClassVar[bool]
    order: ClassVar[tuple[int, ...]]
    factors: ClassVar[Floats | None] = None
    """The velocity over the user's coordinate of each component, by the user's sequence, if the user's are momenta."""
    lacking: ClassVar[str]
    """Why the equations have no accelerations that depend on the positions alone; "" if they have."""
    stated: ClassVar[Stated]
    place: ClassVar[tuple[str, str] | None] = None
    """The module and the name by which a form can be imported; a function knows its own."""
    span_given: ClassVar[tuple[float, float]]
    start_given: ClassVar[tuple[float, ...]]
    whole: ClassVar[Times]
    rough: ClassVar[RoughMotion]
    reference: ClassVar[Reference]
    """The states at `moments`, with the bound of their error."""
    moments: ClassVar[Floats]
    effects: ClassVar[tuple[Floats, Floats]]
    """The effects of rounding the start alone, and all numbers, at `moments`."""
    found_events: ClassVar[tuple[Event, ...]] = ()

    @property
    def forms(self) -> tuple[Form, ...]:  # type: ignore[override]
        return self.forms_

    @property
    def hybrid(self) -> Hybrid | None:
        return None if self.smooth else super().hybrid

    @property
    def time_scale(self) -> float:  # type: ignore[override]
        return self.rough.time_scale

    @property
    def stresses(self) -> str:
        return "; ".join([*self.reach(), self.reference.text()])

    def explain_form(self, accepted: str) -> str:
        return explain_form(accepted, self.stated, self.order, self.lacking)

    def lines(self, method: str, setting: float, kind: str) -> str:
        """The lines of Python that run a method on these equations, at a tolerance or a step of the problem's time."""
        setting = setting * self.whole.clock.scale if kind == "step" else setting
        return call_lines(self.stated, self.span_given, self.start_given, method, setting, kind, self.place)

    def scales(self) -> dict[str, float]:
        return {c.group: float(size) for c, size in zip(self.state, self.rough.sizes, strict=True)}

    @cached_property
    def metric(self) -> Metric:
        return Metric.scaled(self, self.scales(), frozenset())

    def list_events(self, digits: int) -> tuple[Event, ...]:
        return self.found_events

    def sample(self, times: Floats) -> Floats:
        """The states of the reference; raises ValueError for a time without one."""
        return np.asarray(self.reference.states[self._places(times)])

    def exact(self, t: Number, digits: int = 15) -> tuple[Any, ...]:
        return tuple(self.sample(np.array([float(t)]))[0].tolist())

    def floor(self, times: Floats) -> Floats:
        """Half an ulp of the reference, or the bound of its error if that is larger."""
        return np.asarray(
            np.maximum(accuracy.floor(self, np.asarray(times)), self.reference.error[self._places(times)])
        )

    def conditioning(self, times: Floats) -> Floats:
        effects = self.effects[1][self._places(times)]
        known = np.where(np.isfinite(effects), effects, 0.0)
        return np.asarray(np.where(np.isfinite(effects), effects, np.maximum.accumulate(known)))

    def _places(self, times: Floats) -> Any:
        places = np.searchsorted(self.moments, times)
        if not np.array_equal(self.moments[np.minimum(places, len(self.moments) - 1)], times):
            raise ValueError(f"{self.name}: its reference has no state at one of these times")
        return places

    @property
    def reference_error(self) -> float:
        """The bound of the error of the reference over the span, relative to the largest value of each coordinate."""
        return float(self.reference.error[-1])

    @property
    def lost_after(self) -> float | None:
        """The time, by the user's clock, after which rounding leaves no digit in binary64; None if digits are left."""
        lost = np.flatnonzero(self.effects[1] > LOST)
        return float(self.whole.clock.time(self.moments[lost[0]])) if len(lost) else None

    @property
    def end(self) -> Floats:
        """The state (dim,) of the reference at the end of the span, in the user's sequence."""
        state = np.empty(len(self.order))
        state[list(self.order)] = self.sample(np.array([float(self.span)]))[0]
        return state if self.factors is None else state / self.factors

    def reach(self) -> list[str]:
        """Sentences about what a method in binary64 can reach."""
        clock, effect = self.whole.clock, self.effects[0]
        known = np.flatnonzero(np.isfinite(effect))
        if not len(known):
            return ["the effect of rounding the start was not computed"]
        last, lost = int(known[-1]), np.flatnonzero(effect >= 1)
        sentences = [
            f"rounding the start to double precision changes the state at t = {clock.time(self.moments[last]):.4g}"
            f" by {effect[last]:.1g} of its largest value"
        ]
        if len(lost):  # a multiple of the motion is no change: it follows from derivatives alone
            sentences = [
                f"rounding the start to double precision changes all digits by t = {clock.time(self.moments[lost[0]]):.4g}"
            ]
        if self.lost_after is not None:
            sentences.append(
                f"after t = {self.lost_after:.4g} rounding leaves no digit to a method in double precision"
            )
        return sentences


def make_system(
    stated: Stated,
    t_span: Sequence[float],
    y0: Any,
    name: str | None = None,
    tell: Callable[[str], None] = lambda text: None,
    explicit_work: int = EXPLICIT_WORK,
) -> OwnSystem:
    """The equations as a case with a reference. Raises ValueError for wrong arguments, and without a reference.

    `tell` takes the sentences about each part as soon as it is known. `explicit_work`: as EXPLICIT_WORK, for a reference
    that may take minutes.
    """
    start = array(y0, "y0")
    whole = Times.of(t_span, None, len(start) // 2 if stated.accelerations else 0)
    clock = whole.clock
    if isinstance(stated.fun, Form) and (clock.t0 != 0 or clock.direction < 0 or clock.scale != 1):
        raise ValueError(f"t_span={t_span!r}: a form runs forward from t = 0: give (0, T), with T from .1 to 1e9")
    equations = stated.by(clock, clock.given(start))
    kind = _kind(name or name_of(stated.fun), stated, clock.given(start), equations.parameters, equations.forms)
    kind.whole, kind.stated = whole, stated
    kind.span_given, kind.start_given = (float(t_span[0]), float(t_span[1])), tuple(start.tolist())
    case = kind(span=float(whole.sampled[-1]))
    own = np.array([float(x) for x in case.initial_state])
    if kind.smooth:
        _solve_smooth(kind, case, own, equations.parameters, tell, explicit_work)
    else:
        _solve_with_events(kind, case, own, equations.parameters, tell)
    return case


def _solve_smooth(
    kind: type[OwnSystem],
    case: OwnSystem,
    start: Floats,
    parameters: Sequence[float],
    tell: Callable[[str], None],
    explicit_work: int,
) -> None:
    rates = Rates(first_equations(case.forms), parameters)
    kind.moments = np.unique(np.append(case.times, float(case.span)))

    def solve(rough: RoughMotion) -> None:
        kind.rough, kind.effects = rough, rounding_effect(rates, start, kind.moments, rough)
        effect = float(np.nanmax(np.append(kind.effects[1], 0.0)))  # 0 where it is not known
        kind.reference = smooth_reference(case.forms, start, parameters, kind.moments, rough, effect, explicit_work)

    solve(rough_motion(rates, start, float(case.span), kind.moments))
    times, states = np.append(0.0, kind.moments), np.vstack([start, kind.reference.states])
    if kind.rough.is_astray(times, states):
        solve(RoughMotion.of(times, states, rates.largest(times, states), kind.rough.stiff))
    for text in (*case.reach(), kind.reference.text()):
        tell(text)


def _solve_with_events(
    kind: type[OwnSystem], case: OwnSystem, start: Floats, parameters: Sequence[float], tell: Callable[[str], None]
) -> None:
    form, span = next(form for form in case.forms if isinstance(form, Hybrid)), float(case.span)
    try:
        motion = HybridMotion(form, case.initial_state, [Fraction(x) for x in parameters], span)
        kind.found_events, kind.rough = case_events(motion), rough_hybrid(motion)
        kind.moments = np.unique(np.append(case.times, span))
        kind.effects = hybrid_effect(motion, kind.moments, kind.rough)
        kind.reference = hybrid_reference(motion, kind.moments, kind.rough)
    except (ArithmeticError, AttributeError, TypeError, ValueError) as error:  # a function that balls do not have
        vars(case).pop("times", None)
        kind.found_events, kind.rough = binary64_events(form, start, parameters, span)
        kind.moments = np.unique(np.append(case.times, span))
        unknown = np.full(len(kind.moments), np.nan)
        kind.effects = unknown, unknown
        kind.reference = hybrid_in_binary64(form, start, parameters, kind.moments, kind.rough, str(error))
    for text in (*case.reach(), kind.reference.text()):
        tell(text)


def first_equations(forms: Sequence[Form]) -> Callable[..., Any]:
    """The equations of the first-order form among several forms."""
    return next(form.equations for form in forms if isinstance(form, FirstOrder))


def _kind(
    name: str, stated: Stated, start: Floats, parameters: Sequence[float], forms: Sequence[Form]
) -> type[OwnSystem]:
    """The class of the system, as an attribute of this module, from which a forked process takes it."""
    name = re.sub(r"\W", "_", name)
    name = f"own_{name}" if name in cases.names() else name
    first = next((form for form in forms if isinstance(form, FirstOrder)), None)
    order, lacking, autonomous, factors = tuple(range(len(start))), "", False, None
    offered: tuple[Form, ...] = tuple(forms)
    if type(first) is FirstOrder and first.source is None and not isinstance(first.equations, Called):
        derived = derive_forms(first, len(start), len(parameters))
        others = tuple(form for form in derived.forms if type(form) is not FirstOrder)
        is_same = derived.factors is None and derived.order == order
        lacking, autonomous = derived.lacking, derived.autonomous
        if isinstance(stated.fun, Form) or stated.accelerations:  # its state stays as it is
            offered = (*forms, *(form for form in others if is_same and type(form) not in map(type, forms)))
        else:
            order, offered = derived.order, derived.forms
            if derived.factors is not None:
                factors = np.array(derived.factors(tuple(parameters)), dtype=np.float64)
                start = start * factors
    members = {
        "title": f"{name}, own equations",
        "name": name,
        "state": tuple(Coordinate("1", float(start[i]), group=f"y[{i}]", kind="dimensionless", name=f"y[{i}]") for i in order),
        "default_state": tuple(float(start[i]) for i in order),
        "parameter_list": tuple(
            Parameter("1", float(value), "", name=label)
            for label, value in zip(_parameter_names(stated, len(parameters)), parameters, strict=True)
        ),
        "forms_": offered, "order": order, "lacking": lacking, "autonomous": autonomous, "factors": factors,
        "smooth": not any(isinstance(form, Hybrid) for form in forms),
        "__module__": __name__,
    }  # fmt: skip
    content = "\n".join([*map(of_value, offered), repr(start.tolist()), repr(list(parameters))])
    unique = f"{name}_{hashlib.sha256(content.encode()).hexdigest()[:12]}"
    kind: type[OwnSystem] = type(unique, (OwnSystem,), members)
    setattr(sys.modules[__name__], unique, kind)
    return kind


def _parameter_names(stated: Stated, count: int) -> list[str]:
    """The names of the numbers in `args`, from the function's signature where it has them."""
    names: list[str] = []
    with suppress(TypeError, ValueError):
        names = [*inspect.signature(stated.fun).parameters][2:]  # type: ignore[arg-type]
    of_numbers = [
        label for label, value in zip(names, stated.arguments.args, strict=False) if isinstance(value, int | float)
    ]
    return of_numbers if len(of_numbers) == count else [f"p[{k}]" for k in range(count)]

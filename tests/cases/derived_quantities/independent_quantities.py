"""Independent values of derived quantities: the tools that compute them from motion, events and equations of a case.

The modules independent_quantities_* use these: no formula of the case is used, only differences, roots and extremes.
"""

from collections.abc import Callable
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import mpmath
from gnomon.cases import Case, get, names
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.harness.certification.agreement import first_order_equations

mp = mpmath.mp
DIGITS = 40
"""The precision of all computations here; an integrated motion has 33 digits."""
Oracle = Callable[["ObservedMotion", Any], Any]
SMOOTH: dict[str, Oracle] = {}
HYBRID: dict[str, Oracle] = {}
"""The independent computation of each quantity, for motions without and with events.

The modules independent_quantities_* fill both.
"""


def number(value: Any) -> Any:
    return mpmath.mpf(value.numerator) / value.denominator


class ObservedMotion:
    """A case and its exact motion; coordinates are attributes of `at(t)`, parameters of `p`, in the caller's precision."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self.names = [c.name for c in case.state]
        self.p = SimpleNamespace(**{name: number(v) for name, v in case.parameters.items()})
        self.span = number(case.span)
        self.found = case.quantities(30)

    def at(self, t: Any) -> SimpleNamespace:
        return SimpleNamespace(**dict(zip(self.names, self.state(t), strict=True)))

    def state(self, t: Any, digits: int = DIGITS) -> tuple[Any, ...]:
        return tuple(map(mpmath.mpf, self.case.exact(mpmath.mpf(t), min(digits, self._most))))

    @property
    def _most(self) -> int:
        return 200 if self.case.certified_digits > 30 else 33

    def slope(self, function: Callable[[Any], Any], t: Any = 0) -> Any:
        """The derivative of a function of time from one side, so also at the start and at an event.

        The step is 1e-12 time scales: the error is 1e-24 of the third derivative, and 12 digits cancel.
        """
        h = mpmath.mpf(self.case.time_scale) * mpmath.mpf("1e-12")
        return (4 * function(t + h) - 3 * function(t) - function(t + 2 * h)) / (2 * h)

    def rate(self, name: str, t: Any = 0) -> Any:
        return self.slope(lambda s: getattr(self.at(s), name), t)

    def equations(self, state: Any, t: Any = 0, **changed: Any) -> tuple[Any, ...]:
        """The right-hand sides at a state (a mapping replaces coordinates of the start), with changed parameters."""
        if isinstance(state, dict):
            state = [state.get(name, x) for name, x in zip(self.names, self.state(0), strict=True)]
        values = [changed.get(name, v) for name, v in vars(self.p).items()]
        return tuple(rebind(first_order_equations(self.case), mpmath_arithmetic(mp))(t, tuple(state), tuple(values)))

    def jacobian(self, state: Any, t: Any = 0) -> Any:
        """The Jacobian by central differences over 1e-12: the error is about 1e-24 of the third derivative."""
        if isinstance(state, dict):
            state = [state.get(name, x) for name, x in zip(self.names, self.state(0), strict=True)]
        h, columns = mpmath.mpf("1e-12"), []
        for i in range(len(state)):
            there, back = ([x + (sign * h if j == i else 0) for j, x in enumerate(state)] for sign in (1, -1))
            columns.append(
                [(a - b) / (2 * h) for a, b in zip(self.equations(there, t), self.equations(back, t), strict=True)]
            )
        return mpmath.matrix(columns).T

    def invariant(self, name: str, t: Any = 0, state: Any = None) -> Any:
        function = rebind(self.case.invariants[name].function, mpmath_arithmetic(mp))
        return function(mpmath.mpf(t), self.state(t) if state is None else state, tuple(vars(self.p).values()))[0]

    def events(self, name: str = "") -> list[Any]:
        """The events whose names start with `name`; coordinates of their states are attributes."""
        return [
            SimpleNamespace(
                time=mpmath.mpf(event.time),
                name=event.name,
                before=SimpleNamespace(**dict(zip(self.names, event.before, strict=True))),
                after=SimpleNamespace(**dict(zip(self.names, event.after, strict=True))),
            )
            for event in self.case.events(DIGITS)
            if event.name.startswith(name)
        ]

    def extremes(self, function: Callable[[SimpleNamespace], Any], until: Any = None, steps: int = 48) -> list[Any]:
        """(t, value) of a function of the state at both ends and at its extremes, refined by secants on its slope."""
        until = mpmath.mpf(self.span if until is None else until)

        def slope(t: Any) -> Any:
            return self.slope(lambda s: function(self.at(s)), t)

        times = [until * k / steps for k in range(steps + 1)]
        values = [function(self.at(t)) for t in times]
        found = [(times[0], values[0]), (times[-1], values[-1])]
        for k in range(1, steps):
            if (values[k] - values[k - 1]) * (values[k + 1] - values[k]) <= 0:
                # near an extreme the error of the value is the square of the error of the time
                t = mpmath.findroot(slope, (times[k - 1], times[k + 1]), solver="anderson", tol=1e-24, verify=False)
                found.append((t, function(self.at(t))))
        return sorted(found)

    def least(self, function: Callable[[SimpleNamespace], Any], until: Any = None, steps: int = 48) -> Any:
        return min(value for _, value in self.extremes(function, until, steps))

    def largest(self, function: Callable[[SimpleNamespace], Any], until: Any = None, steps: int = 48) -> Any:
        return max(value for _, value in self.extremes(function, until, steps))


class LaterMotion(ObservedMotion):
    """The same motion, with time counted from `late`."""

    def __init__(self, observed: ObservedMotion, late: Any) -> None:
        vars(self).update(vars(observed))
        self.late = late

    def state(self, t: Any, digits: int = DIGITS) -> tuple[Any, ...]:
        return super().state(t + self.late, digits)


def period_of(observed: ObservedMotion) -> Any:
    return observed.found.get("period") or observed.found.get("turn_time") or observed.found.get("nutation_period")


def swing(observed: ObservedMotion, rest: Any, coordinate: int = 0) -> Any:
    """Angular frequency about an equilibrium `rest` of a motion in one coordinate."""
    found = observed.jacobian(rest)
    return mpmath.sqrt(-found[coordinate + len(observed.names) // 2, coordinate])


def angle_at_rest(observed: ObservedMotion, angle: Any) -> dict[str, Any]:
    return {observed.names[0]: mpmath.mpf(angle), observed.names[1]: mpmath.mpf(0)}


def close(a: Any, b: Any, digits: float = 18) -> bool:
    """Whether two numbers agree to `digits`: differences and their cancellation may take half of the 40 digits."""
    if mpmath.isinf(a) or mpmath.isinf(b):
        return bool(a == b)
    return bool(a == b or abs(a - b) <= mpmath.mpf(10) ** -digits * max(abs(a), abs(b), mpmath.mpf(10) ** -6))


def default_cases(hybrid: bool) -> list[tuple[str, str | None]]:
    """Every case on its defaults."""
    return [(name, None) for name in names() if (get(name).hybrid is not None) is hybrid]


def uneven(case: Case) -> Case:
    """The case with parameters without simple ratios, so that a missing factor shows; itself if its domain forbids."""
    changed = {n: v * Fraction(100 + 3 * k, 100) for k, (n, v) in enumerate(case.parameters.items(), 1)}
    try:
        return get(case.name, initial_state=case.initial_state, **changed)
    except ValueError:
        return case


def oracle(*labels: str, of: dict[str, Oracle] = SMOOTH) -> Callable[[Oracle], Oracle]:
    """Registers a function that returns the value of a quantity, or whether a value is right; by `label` or `case.label`."""

    def keep(function: Oracle) -> Oracle:
        of.update(dict.fromkeys(labels, function))
        return function

    return keep


def missing_oracle(name: str, label: str) -> str:
    return (
        f"{name} has no independent computation of its quantity {label}: write a function "
        f'@oracle("{name}.{label}") into tests/cases/mass_points/independent_{name}.py or a file beside it'
    )


def label_of(observed: ObservedMotion, value: Any) -> str:
    return next(label for label, found in observed.found.items() if found is value)


def assert_quantities(oracles: dict[str, Oracle], name: str, variant: str | None) -> None:
    """Compare every quantity with its independent computation, by `case.label` or else `label`; one without fails."""
    with mpmath.workdps(DIGITS):
        observed = ObservedMotion(get(name, variant) if variant else uneven(get(name)))
        for label, value in observed.found.items():
            oracle = oracles.get(f"{name}.{label}") or oracles.get(label)
            assert oracle is not None, missing_oracle(name, label)
            expected = oracle(observed, value)
            if not isinstance(expected, bool):
                expected = close(value, expected), expected
                assert expected[0], (label, value, expected[1])
            assert expected, (label, value)

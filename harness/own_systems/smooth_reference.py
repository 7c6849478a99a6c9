"""The reference of smooth equations: in high precision by two methods that share nothing, or by two tight ones in binary64.

The pairs: Taylor series and the extrapolated midpoint rule; for stiff equations collocation and the extrapolated linearly
implicit Euler rule. Time and state are scaled by powers of two, so that a span of 1e-13 s is like one of 1 s.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.forms import FirstOrder, Form
from gnomon.harness.contract.integrator import Floats, Problem, Solution
from gnomon.harness.contract.problem import first_taken
from gnomon.harness.kernels.called_equations import Called
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.measuring.rounding_effect import Rates, RoughMotion
from gnomon.harness.registry import lookup
from gnomon.harness.system.supervisor import calls
from gnomon.reference.integration.collocation import collocate
from gnomon.reference.integration.implicit_extrapolation import extrapolate_implicitly
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.certified import Scout
from gnomon.reference.numerics.extrapolation import extrapolate
from gnomon.reference.numerics.taylor import Field, flint_arithmetic, integrate

DIGITS, IMPLICIT_DIGITS, SPARE = 21, 17, 2
"""Digits of the first attempt; digits by which the first method of a pair has more than the second."""
WANTED, IMPLICIT_WANTED = 17, 16
"""Digits in which both must agree, or a second attempt has more."""
MOST_DIGITS = 120
USUAL = 1e-12
"""Effects of rounding up to this cost no further digits."""
MARGIN = 10.0
"""The error of the reference is this multiple of the difference of the two methods."""
EXPLICIT_WORK = 150_000
"""Steps times operations of the scout that the explicit pair may take: some 30 s each."""
IMPLICIT_STEPS = 3000
TIGHT = 1e-13
PAIRS = {
    (False, False): ("gnomon:Taylor", "gnomon:DOP853"),
    (True, False): ("gnomon:Radau IIA 5", "scipy:LSODA"),
    (False, True): ("gnomon:DOP853", "gnomon:Gragg-Bulirsch-Stoer"),
    (True, True): ("scipy:Radau", "scipy:LSODA"),
}
"""The methods in binary64 by (stiff, called from Python)."""

States = list[tuple[Fraction, ...]]


@dataclass(frozen=True)
class Reference:
    """States at the times: `states` (n, dim), rounded to binary64, and the `differences` (n,) of both methods over the sizes."""

    states: Floats
    differences: Floats
    methods: tuple[str, str]
    digits: int
    """Digits of the arithmetic; 16 for binary64."""
    why: str = ""
    """Why it is in binary64; "" in high precision."""
    event_error: float = 0.0
    """The bound of the error of the times of events (s)."""

    @property
    def error(self) -> Floats:
        """The bound of the error (n,): the largest difference so far, with a margin."""
        return np.maximum.accumulate(np.maximum(MARGIN * self.differences, 1e-30))

    def text(self) -> str:
        """A sentence about the reference."""
        largest, bound = float(self.differences.max()), float(self.error[-1])
        how = f"in binary64 ({self.why})" if self.why else f"with {self.digits} digits"
        names = " and ".join(self.methods)
        if bound >= 1:
            return f"no reference {how} at the end of the span: {names} differ by {largest:.1g} of a coordinate's size; take a shorter span"
        words = f"reference {how}: {names} agree to {largest:.1g} of the size of each coordinate"
        return f"{words}; errors below {bound:.1g} cannot be measured"


def smooth_reference(
    forms: Sequence[Form],
    start: Floats,
    parameters: Sequence[float],
    times: Floats,
    motion: RoughMotion,
    effect: float,
    explicit_work: int = EXPLICIT_WORK,
) -> Reference:
    """The reference at increasing times since the start. Raises ValueError where no two methods reach the end.

    `effect` is the largest effect of rounding to binary64: as many digits as it has lost are added. `explicit_work`: as
    EXPLICIT_WORK.
    """
    form = next(form for form in forms if isinstance(form, FirstOrder))
    if isinstance(form.equations, Called):
        return _in_binary64(forms, start, parameters, times, motion, "the equations have no formulas")
    scaled = _Scaled(form, start, parameters, motion)
    try:
        return _in_high_precision(scaled, times, motion, effect, explicit_work)
    except (ArithmeticError, ValueError, TypeError) as error:
        return _in_binary64(forms, start, parameters, times, motion, str(error))


class _Scaled:
    """Equations in high precision for the state over powers of two, and the time over a power of two."""

    def __init__(self, form: FirstOrder, start: Floats, parameters: Sequence[float], motion: RoughMotion) -> None:
        self.unit = Fraction(2) ** math.frexp(motion.time_scale)[1]
        self.sizes = [Fraction(2) ** math.frexp(x)[1] for x in motion.sizes.tolist()]
        self.start = [Fraction(x) / s for x, s in zip(start.tolist(), self.sizes, strict=True)]
        self.span = Fraction(float(motion.times[-1])) / self.unit
        self._equations = rebind(form.equations, flint_arithmetic())
        self._parameters = [Fraction(x) for x in parameters]
        self._rates = Rates(form.equations, parameters)
        self._plain = np.array([float(s) for s in self.sizes]), float(self.unit)

    def field(self) -> Field:
        """The equations in balls of the precision that holds when they are first called."""
        unit, sizes, balls = self.unit, self.sizes, dict[str, Any]()

        def field(t: Any, state: tuple[Any, ...]) -> tuple[Any, ...]:
            if not balls:
                balls["sizes"] = [ball(s) for s in sizes]
                balls["weights"] = [ball(unit / s) for s in sizes]
                balls["unit"], balls["parameters"] = ball(unit), tuple(map(ball, self._parameters))
            own = tuple(x * s for x, s in zip(state, balls["sizes"], strict=True))
            rates = self._equations(t * balls["unit"], own, balls["parameters"])
            return tuple(x * w for x, w in zip(rates, balls["weights"], strict=True))

        return field

    def jacobian(self, t: float, state: Floats) -> Floats:
        sizes, unit = self._plain
        nothing = np.zeros((len(self._parameters), len(sizes)))
        derivatives = self._rates.along(t * unit, state * sizes, np.diag(sizes), nothing, sizes)
        return np.asarray(derivatives * unit / sizes[:, None])


def _in_high_precision(
    scaled: _Scaled, times: Floats, motion: RoughMotion, effect: float, explicit_work: int
) -> Reference:
    explicit = not motion.stiff and _is_short_enough(scaled, explicit_work)
    lost = max(0, math.ceil(math.log10(effect / USUAL))) if USUAL < effect < math.inf else 0
    return _attempt(scaled, times, motion, explicit, min((DIGITS if explicit else IMPLICIT_DIGITS) + lost, MOST_DIGITS))


def _attempt(scaled: _Scaled, times: Floats, motion: RoughMotion, explicit: bool, digits: int) -> Reference:
    """Integrate in two independent ways to `digits` digits, and again with more digits if too few of them agree."""
    moments = [Fraction(t) / scaled.unit for t in times.tolist()]
    ways: dict[str, Callable[[], States]] = {
        "Taylor series": lambda: integrate(scaled.field(), scaled.start, moments, digits + SPARE),
        "the extrapolated midpoint rule": lambda: extrapolate(
            scaled.field(), scaled.start, moments, digits, Fraction(1, 4)
        ),
    }
    if not explicit:
        ways = {
            "collocation at Radau's points": lambda: collocate(
                scaled.field(), scaled.jacobian, scaled.start, moments, digits + SPARE, IMPLICIT_STEPS
            ),
            "the extrapolated linearly implicit Euler rule": lambda: extrapolate_implicitly(
                scaled.field(), scaled.jacobian, scaled.start, moments, digits, IMPLICIT_STEPS
            ),
        }
    first, second = _both(list(ways.values()))
    relative = [Fraction(x) / s for x, s in zip(motion.sizes.tolist(), scaled.sizes, strict=True)]
    differences = np.array(
        [
            max(float(abs(a - b) / s) for a, b, s in zip(x, y, relative, strict=True))
            for x, y in zip(first, second, strict=True)
        ]
    )
    agreed = -math.log10(max(float(differences.max()), 10.0**-MOST_DIGITS))
    more = math.ceil(digits + (WANTED if explicit else IMPLICIT_WANTED) - agreed + 1)
    if digits < more <= MOST_DIGITS:
        with suppress(ArithmeticError):  # it may take too long: then the digits that agree stand
            return _attempt(scaled, times, motion, explicit, more)
    states = [[float(x * s) for x, s in zip(row, scaled.sizes, strict=True)] for row in first]
    names: Any = tuple(ways)
    return Reference(np.array(states), differences, names, digits)


def _both(ways: Sequence[Callable[[], States]]) -> list[States]:
    """The results of two computations, in two processes. Raises the exception of one that fails."""
    results: dict[int, Any] = {}
    for index, result in calls(lambda which: ways[which](), range(len(ways)), len(ways), "fork"):
        if isinstance(result, BaseException):
            raise result
        results[index] = result
    return [results[index] for index in range(len(ways))]


def _is_short_enough(scaled: _Scaled, explicit_work: int) -> bool:
    """Whether an explicit integration of full order takes seconds: by one of low order."""
    try:
        Scout(scaled.field(), scaled.start, False, explicit_work).reach(scaled.span)
    except (ArithmeticError, AttributeError, TypeError):
        return False
    return True


def _in_binary64(
    forms: Sequence[Form], start: Floats, parameters: Sequence[float], times: Floats, motion: RoughMotion, why: str
) -> Reference:
    is_called = isinstance(next(form for form in forms if isinstance(form, FirstOrder)).equations, Called)
    names = PAIRS[motion.stiff, is_called]
    first, second = (
        solve_tightly(name, forms, start, parameters, times, motion.time_scale).states[0] for name in names
    )
    differences = np.max(np.abs(first - second) / motion.sizes, axis=1)
    return Reference(first, np.maximum(differences, 2.0**-53), names, 16, why)


def solve_tightly(
    name: str, forms: Sequence[Form], start: Floats, parameters: Sequence[float], times: Floats, time_scale: float
) -> Solution:
    """The solution by a method in binary64 at its tight tolerance. Raises ValueError if it does not reach the end."""
    integrator, numbers = lookup.find_one(name), np.array(parameters, dtype=np.float64)
    problem = Problem(first_taken(integrator, forms), len(start), numbers, times, time_scale)
    with Prepared(integrator, problem, max(TIGHT, getattr(integrator.sweep, "tightest", TIGHT))) as prepared:
        solution = prepared(start[None])
    if solution.stopped is not None or not np.isfinite(solution.states).all():
        raise ValueError(f"no reference: {name} does not reach the end of the span ({solution.stopped})")
    return solution

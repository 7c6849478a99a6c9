"""The effect on a motion of rounding its start and its parameters, from the variational equations in binary64.

For equations without an exact motion. The derivative of traced equations in a direction is the imaginary part at a complex
step, which is exact to rounding; that of other equations a central difference.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from gnomon.cases.core.arithmetic import rebind
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.kernels.called_equations import Called
from scipy.integrate import DOP853, ODEintWarning, Radau, odeint

GRID = 512
"""Equal intervals of the span at which a first, rough solution is read."""
EARLY = 12
"""Decades before the first of them at which it is read too, for transients."""
ROUGH = 1e-9
"""Relative tolerance of the rough solution."""
MOST_STEPS = 100_000
"""Steps of the rough solution between two times."""
DIRECTIONS = 24
"""Numbers that are each perturbed alone; more of them are perturbed together, with random signs, AVERAGED times."""
AVERAGED = 8
VARIATIONAL, VARIATIONAL_STIFF = 1e-8, 1e-6
"""Relative tolerances of the motion with its effects, of which two digits are shown."""
MOST_EVALUATIONS = 60_000
COMPLEX_STEP, DIFFERENCE = 1e-40, 1e-6
EXPLICIT_RADIUS, STIFF_TIMES = 3.3, 5.0
"""Equations are stiff if steps at the limit of stability of an explicit method, whose region reaches about this far, would
be this many times more than LSODA takes."""
ASTRAY = 0.6
"""Difference of the largest values of the rough motion and the reference, over the size, above which the former is wrong."""
SPECTRA = 17
"""Times at which the eigenvalues of the Jacobian are computed."""


class Rates:
    """Equations y' = f(t, y, p) on arrays, with their derivatives in several directions at once."""

    def __init__(self, equations: Callable[..., Any], parameters: Sequence[float]) -> None:
        self.equations, self.parameters = equations, tuple(map(float, parameters))
        self.called = isinstance(equations, Called)
        self._on_arrays = None if self.called else rebind(equations, COMPLEX)

    def __call__(self, t: float, y: Floats) -> Floats:
        if isinstance(self.equations, Called):
            return self.equations.values(t, y.copy())
        try:
            return np.array(self.equations(t, tuple(y.tolist()), self.parameters), dtype=np.float64)
        except (ArithmeticError, ValueError):  # outside of their domain
            return np.full(len(y), np.nan)

    def along(self, t: float, y: Floats, changes: Floats, of_parameters: Floats, sizes: Floats) -> Floats:
        """The derivatives (dim, k) in the directions `changes` (dim, k) of the state and (n, k) of the parameters."""
        if self._on_arrays is None:
            return self._differences(t, y, changes, sizes)
        state = tuple(x + 1j * COMPLEX_STEP * c for x, c in zip(y, changes, strict=True))
        numbers = tuple(x + 1j * COMPLEX_STEP * c for x, c in zip(self.parameters, of_parameters, strict=True))
        rates = self._on_arrays(t, state, numbers)
        return np.array([np.broadcast_to(np.imag(x), changes.shape[1]) for x in rates]) / COMPLEX_STEP

    def largest(self, times: Floats, states: Floats) -> Floats:
        """The largest absolute rate (dim,) of each component over states (m, dim) at times (m,)."""
        rates = [self(t, y) for t, y in zip(times.tolist(), states, strict=True)]
        return np.asarray(np.max(np.abs(rates), axis=0))

    def spectral_radius(self, t: float, y: Floats, sizes: Floats) -> float:
        """The largest absolute eigenvalue of the Jacobian; 0 where it is not finite."""
        nothing = np.zeros((len(self.parameters), len(y)))
        jacobian = self.along(t, y, np.eye(len(y)), nothing, np.where(sizes > 0, sizes, 1.0))
        return float(np.max(np.abs(np.linalg.eigvals(jacobian)))) if np.isfinite(jacobian).all() else 0.0

    def _differences(self, t: float, y: Floats, changes: Floats, sizes: Floats) -> Floats:
        columns = []
        for change in changes.T:
            largest = float(np.max(np.abs(change) / sizes))
            h = DIFFERENCE / largest if largest else 1.0
            columns.append((self(t, y + h * change) - self(t, y - h * change)) / (2 * h))
        return np.array(columns).T


def _atan2(y: Any, x: Any) -> Any:
    a, b = np.real(y), np.real(x)
    return np.arctan2(a, b) + 1j * (b * np.imag(y) - a * np.imag(x)) / (a * a + b * b)


COMPLEX: dict[str, Any] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "atan2": _atan2, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "asinh": np.arcsinh, "acosh": np.arccosh,
    "atanh": np.arctanh, "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "hypot": lambda a, b: np.sqrt(a * a + b * b),
}  # fmt: skip
"""Functions of complex arrays whose imaginary parts are infinitesimal."""


@dataclass(frozen=True)
class RoughMotion:
    """A motion in binary64: `states` (m, dim) at `times` (m,), the largest `sizes` (dim,), its shortest time.

    `stiff`: whether stability, not accuracy, limits the steps of explicit methods.
    """

    times: Floats
    states: Floats
    sizes: Floats
    time_scale: float
    stiff: bool

    @classmethod
    def of(cls, times: Floats, states: Floats, slopes: Floats, stiff: bool = False) -> Self:
        """The motion of known states (m, dim), with the largest absolute slope (dim,) of each component.

        Its shortest time is the least time in which a component moves by its size.
        """
        sizes = np.max(np.abs(states), axis=0)
        fastest = float(np.max(np.divide(slopes, sizes, out=np.zeros_like(slopes), where=sizes > 0)))
        span = float(times[-1])
        return cls(times, states, np.where(sizes > 0, sizes, 1.0), min(span, 1 / fastest if fastest else span), stiff)

    def is_astray(self, times: Floats, states: Floats) -> bool:
        """Whether its largest values at some of its times are not those of the known states: errors grew to other sizes."""
        own = np.max(np.abs(self.states[np.searchsorted(self.times, times)]), axis=0)
        known = np.max(np.abs(states), axis=0)
        return bool(np.any(np.abs(own - known) > ASTRAY * self.sizes))


def rough_motion(rates: Rates, start: Floats, span: float, moments: Floats) -> RoughMotion:
    """Solve by LSODA; the `moments` are among its times. Raises ValueError where the solution does not go on."""
    times = np.unique(
        np.concatenate([[0.0], span / GRID * 10.0 ** np.arange(-EARLY, 0), np.linspace(0, span, GRID + 1), moments])
    )
    end = float(times[-1])
    if not np.isfinite(first := rates(0.0, start)).all():
        raise ValueError(f"the right-hand side is not finite at the start: {first.tolist()}")
    largest = float(np.max(np.abs(start)))
    if largest == 0:  # of a system that begins at rest: the size to which it is driven in the first interval
        pushes = [np.abs(rates(t, start)) for t in times[:: len(times) // SPECTRA].tolist()]
        largest = span / GRID * float(np.nanmax(pushes)) or 1.0
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore", ODEintWarning)
        states, facts = odeint(
            lambda t, y: rates(min(t, end), y), start, times, rtol=ROUGH, atol=1e-12 * largest, mxstep=MOST_STEPS,
            full_output=True, tfirst=True,
        )  # fmt: skip
    solved = (facts["tcur"] >= times[1:]) | (facts["message"] == "Integration successful.")
    finite = np.isfinite(states).all(axis=1)
    reached = np.argmin(np.append(finite & np.append(True, solved), False))
    if reached < len(times):
        why = facts["message"].rstrip(".") if finite[reached] else "then the state is not finite"
        raise ValueError(
            f"the motion cannot be followed beyond t = {times[max(int(reached) - 1, 0)]:.6g} after the start ({why});"
            " give a span that ends before, or state the events there"
        )
    motion = RoughMotion.of(times, states, rates.largest(times, states))
    places = np.linspace(0, len(times) - 1, SPECTRA).astype(int)
    radii = [rates.spectral_radius(times[k], states[k], motion.sizes) for k in places.tolist()]
    explicit = float(np.trapezoid(radii, times[places])) / EXPLICIT_RADIUS
    return replace(motion, stiff=explicit > STIFF_TIMES * float(facts["nst"][-1]))


def rounding_effect(rates: Rates, start: Floats, times: Floats, motion: RoughMotion) -> tuple[Floats, Floats]:
    """The typical effect of half an ulp in each number, over the sizes: of the start alone, and of all numbers and the time.

    Both have the shape (len(times),). nan from the time on at which the equations would take too many evaluations.
    """
    dimension, sizes = len(start), motion.sizes
    numbers = np.array([*start, *(() if rates.called else rates.parameters)])
    moved = np.flatnonzero(numbers)
    units = np.zeros((len(numbers), len(moved)))
    units[moved, np.arange(len(moved))] = numbers[moved]
    halves = np.array([math.ulp(x) / 2 / abs(x) for x in numbers[moved].tolist()])
    if len(moved) > DIRECTIONS:
        signs = np.random.default_rng(27).choice([-1.0, 1.0], (len(moved), 2, AVERAGED)) / math.sqrt(AVERAGED)
        signs[moved >= dimension, 0] = 0.0  # the first half has the start alone
        units = (units * halves) @ signs.reshape(len(moved), -1)
        halves, own = np.ones(2 * AVERAGED), np.arange(2 * AVERAGED) < AVERAGED
        whole = ~own
    else:
        own, whole = moved < dimension, np.ones(len(moved), dtype=bool)
    changes, of_parameters = units[:dimension], units[dimension:]
    late = np.array([rates(t, y) for t, y in zip(times.tolist(), _at(motion, times), strict=True)])
    ticks = np.max(np.abs(late) / sizes, axis=1) * np.spacing(times) / 2
    if not len(moved):  # a start of zeros without parameters has no rounding
        return np.zeros(len(times)), ticks
    grown = _changes(rates, start, times, motion, changes, of_parameters)
    effects = np.max(np.abs(grown * halves) / sizes[:, None], axis=1)  # (times, directions)
    of_start = np.sqrt(np.sum(effects[:, own] ** 2, axis=1))
    return of_start, np.sqrt(np.sum(effects[:, whole] ** 2, axis=1) + ticks**2)


def _at(motion: RoughMotion, times: Floats) -> Floats:
    return motion.states[np.minimum(np.searchsorted(motion.times, times), len(motion.times) - 1)]


def _changes(
    rates: Rates, start: Floats, times: Floats, motion: RoughMotion, changes: Floats, of_parameters: Floats
) -> Floats:
    """The changes (len(times), dim, k) of the states that begin as `changes` (dim, k)."""
    (dimension, count), sizes = changes.shape, motion.sizes
    nothing = np.zeros((len(of_parameters), dimension))

    def variational(t: float, whole: Floats) -> Floats:
        y, own = whole[:dimension], whole[dimension:].reshape(dimension, count)
        return np.concatenate([rates(t, y), rates.along(t, y, own, of_parameters, sizes).ravel()])

    def jacobian(t: float, whole: Floats) -> Floats:
        """Without the derivatives of the variational part with respect to the state, which Newton's method can miss."""
        own = rates.along(t, whole[:dimension], np.eye(dimension), nothing, sizes)
        blocks = np.zeros((len(whole), len(whole)))
        blocks[:dimension, :dimension], blocks[dimension:, dimension:] = own, np.kron(own, np.eye(count))
        return blocks

    whole, until = np.concatenate([start, changes.ravel()]), float(times[-1])
    atol = 1e-8 * np.concatenate([sizes, np.repeat(sizes, count)])
    changed = np.full((len(times), dimension, count), np.nan)
    with np.errstate(all="ignore"):
        solver: Any = (
            Radau(variational, 0.0, whole, until, rtol=VARIATIONAL_STIFF, atol=atol, jac=jacobian)
            if motion.stiff
            else DOP853(variational, 0.0, whole, until, rtol=VARIATIONAL, atol=atol)
        )
        known = 0
        while known < len(times) and solver.nfev < MOST_EVALUATIONS and solver.status == "running":
            solver.step()
            if solver.status == "failed" or not np.isfinite(solver.y).all():
                break
            inside = times[known:][times[known:] <= solver.t]
            if len(inside):
                states = solver.dense_output()(inside)[dimension:].T
                changed[known : known + len(inside)] = states.reshape(-1, dimension, count)
                known += len(inside)
    return changed

"""The error of a physics engine on a scene in four parts: integration, model, precision and solver."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from gnomon.harness.results.convergence_order import line, slopes

BITS = 53
"""Bits of binary64, in which floors are computed; binary32 has 24."""
BINARY32 = 24
WITHIN = 0.3
"""Slopes between neighbouring steps differ by at most so much on a line whose order is given."""
FLAT = 2.0
"""Ratio of errors, over a factor of at least 4 in the step, up to which the error no longer falls."""
CLEAR = 10.0
"""Ratio to the floor of the arithmetic from which the rest of an error is not rounding."""
TARGETS = (1e-2, 1e-3, 1e-4)


@dataclass(frozen=True)
class Parts:
    """`order` and `constant`: the error is constant (step / time scale)^order ; None without a steady order. `rest`: the error that remains as the step goes to zero, if it stops falling; `rest_is`: "precision" if the floor
    of the arithmetic is as large, else "model". `solver`: the change of the error with a tighter solver at the same step.
    `steps`: the largest measured step from which on the error stays below each target.
    """

    order: float | None
    constant: float | None
    rest: float | None
    rest_is: str
    precision: float
    solver: float | None
    steps: Mapping[str, float | None]

    def row(self) -> dict[str, Any]:
        return asdict(self)


def floor_of(bits: int, floor64: float) -> float:
    """The effect of half an ulp of a format on the exact motion, from its effect in binary64: it is linear in the ulp."""
    return min(1.0, floor64 * 2.0 ** (BITS - bits))


def parts(
    steps: Sequence[float],
    errors: Sequence[float],
    time_scale: float,
    precision: float,
    tighter: Mapping[float, float] | None = None,
) -> Parts:
    """The parts of the errors at these steps; nan or inf is a step without an answer.

    `precision`: the floor of the engine's arithmetic. `tighter`: errors with a tighter solver, by step.
    """
    known = sorted((h, e) for h, e in zip(steps, errors, strict=True) if math.isfinite(e) and e > 0)
    own_steps, own = [h for h, _ in known], [e for _, e in known]
    rest = _rest(known)
    # Errors near what remains are not of the leading term: they are left out as those near round-off are.
    least = max(precision, rest or 0.0)
    order = _order(own_steps, own, least)
    return Parts(
        order=order,
        constant=None if order is None else _constant(known, order, time_scale, least),
        rest=rest,
        rest_is="" if rest is None else "precision" if rest < CLEAR * precision else "model",
        precision=precision,
        solver=_solver(dict(known), tighter or {}),
        steps={f"{target:g}": _largest_step(steps, errors, target) for target in TARGETS},
    )


def _order(steps: Sequence[float], errors: Sequence[float], least: float) -> float | None:
    """The slope over the finest steps, if the slopes between neighbours differ from it by at most WITHIN."""
    fit = slopes(steps, errors, least / 10)
    if fit is not None and max(fit[0] - fit[1], fit[2] - fit[0]) <= WITHIN:
        return fit[0]
    straight = line(steps, errors, least / 4, WITHIN)
    return straight[0] if straight else None


def _rest(known: Sequence[tuple[float, float]]) -> float | None:
    """The median error of the finest steps over which it stays within FLAT; None if it still falls."""
    flat = [known[0]] if known else []
    for step, error in known[1:]:
        values = [e for _, e in flat] + [error]
        if max(values) > FLAT * min(values):
            break
        flat.append((step, error))
    if len(flat) < 3 or flat[-1][0] < 4 * flat[0][0]:
        return None
    return sorted(e for _, e in flat)[len(flat) // 2]


def _constant(known: Sequence[tuple[float, float]], order: float, time_scale: float, least: float) -> float:
    """From the finest step whose error is at least ten times the floor, with the order rounded to a whole number."""
    step, error = next(((h, e) for h, e in known if e > CLEAR * least), known[-1])
    return error / (step / time_scale) ** max(1, round(order))


def _solver(errors: Mapping[float, float], tighter: Mapping[float, float]) -> float | None:
    """At the finest step that both have."""
    common = sorted(errors.keys() & tighter.keys())
    return abs(errors[common[0]] - tighter[common[0]]) if common else None


def _largest_step(steps: Sequence[float], errors: Sequence[float], target: float) -> float | None:
    largest = None
    for step, error in sorted(zip(steps, errors, strict=True)):
        if not error <= target:
            break
        largest = step
    return largest

"""The panel of stiffness: the steps and calls that a fast decay costs, and the errors on it.

u' = -L (u - cos t) - sin t with u(0) = 1 has the solution cos t for every L (Prothero and Robinson, Mathematics of
Computation 28, 1974): nothing fast happens, and only stability limits the step. Time is explicit: if cos and sin were
in the state, their errors would decay too, and every method would look L-stable.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from math import cos, sin
from typing import Any

import numpy as np
from gnomon.cases.core.forms import FirstOrder, SemiLinear, Values
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Tolerance
from gnomon.harness.contract.problem import first_taken
from gnomon.harness.measuring.solved import Solved, solve_within
from gnomon.harness.registry.lookup import find_one
from gnomon.harness.stability.panel import Column, Mark, panel
from gnomon.harness.stability.subjects import multiples, processor_seconds

SPAN = 10.0
RATE, FAST, VERY_FAST = 1e3, 1e4, 1e6
"""Rates L in 1/s: steps are counted at the first two; the last one shows errors between long steps."""
LOOSE, TIGHT = 1e-4, 1e-8
FREE = 0.25
"""If stability does not limit a method's steps, its calls grow more slowly than with this power of the rate."""
BLIND = 30.0
"""Error of the worst sample over the last one's that shows an inaccurate interpolant; below it is usual scatter."""
WRONG = 0.5
"""Error above which a solution is useless, whatever its steps cost."""
PER_SECOND = (1, 2, 4, 8, 16, 32)
"""Steps per second by which the order of methods of fixed steps is measured on the very fast decay."""
STIFF_SPAN = 8
ROUND_OFF = 1e-12
"""Smaller errors show no order: this is some ten times the round-off of a sum of terms that L makes large."""
STIFF = ("gnomon:Radau IIA 5", "scipy:LSODA", "scipy:BDF")
"""Methods for stiff equations that come with gnomon and SciPy: their fewest calls are the measure of cost."""
FACTOR = 10.0
"""Largest multiple of the fewest calls with which a method is called suited to stiff decay."""
REDUCED = 0.5
"""A measured order is called reduced if it is lower than the declared one by more than this."""


def relaxation(t: Any, state: Values, parameters: Values) -> Values:
    (u,) = state
    (rate,) = parameters
    return (-(rate * (u - cos(t))) - sin(t),)


def decay_matrix(parameters: Values) -> Values:
    (rate,) = parameters
    return (-rate,)


def attraction(t: Any, state: Values, parameters: Values) -> Values:
    """The part of `relaxation` without u."""
    (rate,) = parameters
    return (rate * cos(t) - sin(t),)


FORMS = (FirstOrder(relaxation), SemiLinear(relaxation, linear=decay_matrix, rest=attraction))


def form_for(integrator: Integrator) -> FirstOrder | None:
    form: FirstOrder | None = first_taken(integrator, FORMS)
    return form


def first_order_reason(integrator: Integrator) -> str | None:
    return None if form_for(integrator) is not None else "it takes no equations of first order, which a decay needs"


def sentences(data: Mapping[str, Any]) -> list[str]:
    return _at_fixed_steps(data) if "stiff_order" in data else _by_tolerance(data)


def _at_fixed_steps(data: Mapping[str, Any]) -> list[str]:
    order, declared, steps = data["stiff_order"], data["declared"], f"{PER_SECOND[-1]} steps a second"
    if not data["stable"]:
        return [f"Not for stiff decay: errors above 1 at rate {VERY_FAST:g} with 1 to {steps}."]
    advice = _cost(data.get("rows", []))
    if order is not None and declared is not None and order < declared - REDUCED:
        advice.append(f"Not for its order {declared} on stiff decay: measured {order:.2f}.")
    return advice


def _by_tolerance(data: Mapping[str, Any]) -> list[str]:
    first, power = data["rows"][0], data["power"]
    if first["worst"] is None or first["worst"] > WRONG:
        size = "not finite" if first["worst"] is None else f"{first['worst']:.2g}"
        return [
            f"Not for stiff decay: its error is {size} at rate {first['rate']:g}, tolerance {first['tolerance']:g}."
        ]
    if power is None or power > FREE:
        steps = f"h rate = {first['h_rate']:.4g} a step" if first["h_rate"] else "stability limits its steps"
        calls = f", {first['calls_per_rate']:.2g} calls for a unit of rate times time" if first["calls"] else ""
        return [f"Not for stiff decay: {steps}{calls}."]
    advice = _cost(data["rows"])
    for row in data["rows"]:
        if row["rate"] != VERY_FAST:
            continue
        if row["worst"] is None:
            advice.append(f"Not for stiff decay at rate {VERY_FAST:g}: states are not finite.")
        elif row["worst"] > BLIND * max(row["last"], row["tolerance"]):
            advice.append(
                f"Not for states between its steps on stiff decay at tolerance {row['tolerance']:g}: error"
                f" {row['worst']:.2g} at the worst sample, {row['last']:.2g} at the last."
            )
    return advice


def _cost(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """The calls against the fewest of `STIFF`, as measured: one equation does not justify a recommendation."""
    if not rows or any(row.get("fewest") is None for row in rows):
        return []
    for row in rows:
        if row["calls"] is None:
            return [f"Not compared on stiff decay: {row['why']}."] if "why" in row else []
    ratios = [row["calls"] / row["fewest"] for row in rows]
    worst = max(range(len(rows)), key=lambda k: ratios[k])
    row, rates = rows[worst], [row["rate"] for row in rows]
    if ratios[worst] > FACTOR:
        return [f"Not for stiff decay: {row['calls']} calls at rate {row['rate']:g}, tolerance {row['tolerance']:g}, where"
                f" the best of {', '.join(STIFF)} takes {row['fewest']}."]  # fmt: skip
    return [f"Suited to stiff decay, on one equation at rates {min(rates):g} to {max(rates):g}: at most"
            f" {ratios[worst]:.2g} times the calls of the best of {', '.join(STIFF)}."]  # fmt: skip


COLUMNS = (
    Column("power", "calls grow as rate to the power", ends=(-0.1, 1.1)),
    Column("h_rate", "h rate of a step at tolerance 1e-4", True),
    Column("stiff_order", "order of fixed steps on stiff decay"),
    Column("worst", "error at tolerance 1e-4, rate 1e6", True),
)


def marks(data: Mapping[str, Any]) -> list[Mark]:
    """For an adaptive method the growth of the calls, the step, and the last and worst errors; else the order."""
    if "stiff_order" in data:
        order, text = data["stiff_order"], "unstable" if not data["stable"] else "errors at round-off"
        return [Mark("stiff_order", order, text=text if order is None else f"{order:.2f}, declared {data['declared']}")]
    marks = [
        Mark("power", data["power"], text="not measured" if data["power"] is None else f"rate^{data['power']:.2f}")
    ]
    if data["rows"][0]["h_rate"]:
        marks.append(Mark("h_rate", data["rows"][0]["h_rate"], text=f"h rate = {data['rows'][0]['h_rate']:.4g}"))
    for row in data["rows"]:
        if row["rate"] == VERY_FAST and row["tolerance"] == LOOSE and row["worst"] is not None:
            text = f"{row['last']:.2g} at the last sample, {row['worst']:.2g} at the worst"
            marks.append(Mark("worst", row["worst"], row["last"], row["worst"], text))
    return marks


@panel("stiffness", "Stiffness", sentences, COLUMNS, marks, first_order_reason)
def stiffness(integrator: Integrator, seconds: float) -> dict[str, Any]:
    if not isinstance(integrator.sweep, Tolerance):
        return follow_fixed_steps(integrator)
    rows: list[dict[str, Any]] = []
    row(integrator, RATE / 100, LOOSE)  # compiles
    first = processor_seconds(lambda: rows.append(row(integrator, RATE, LOOSE)))
    factor = min(FAST / RATE, 2.0 ** math.floor(math.log2(max(seconds / first, 1.0))))
    power = None
    if factor >= 2:
        rows.append(row(integrator, factor * RATE, LOOSE))
        work = [each["calls"] or each["steps"] or math.nan for each in rows]
        power = math.log(work[1] / work[0]) / math.log(factor)
    if power is not None and power < FREE:
        rows += [row(integrator, VERY_FAST, tolerance) for tolerance in (LOOSE, TIGHT)]
        rows = [each | {"fewest": fewest(each["rate"], each["tolerance"])} for each in rows]
        if not integrator.counts_rhs:
            rows = [each | {"why": "its calls are not counted"} for each in rows]
    return {"rows": rows, "power": power, "span": SPAN}


def row(integrator: Integrator, rate: float, tolerance: float) -> dict[str, Any]:
    """Steps, calls and errors over the span. Raises Refused if the method gives up."""
    outcome, errors = solve_at(integrator, rate, multiples(64, SPAN / 64), tolerance)
    try:
        steps = outcome.whole.steps
    except Refused as reason:
        raise Refused(f"rate {rate:g}, tolerance {tolerance:g}: {reason}") from None
    return {
        "rate": rate,
        "tolerance": tolerance,
        "steps": steps,
        "calls": outcome.calls or None,
        "h_rate": rate * SPAN / steps if steps else None,
        "calls_per_rate": outcome.calls / (rate * SPAN) if outcome.calls else None,
        "last": float(errors[-1]),
        "worst": float(np.max(errors)),
    }


@cache
def fewest(rate: float, tolerance: float) -> int | None:
    """The fewest calls of the methods `STIFF` over the span."""
    counts = [row(find_one(name), rate, tolerance)["calls"] for name in STIFF]
    return min((count for count in counts if count), default=None)


def measure_fixed_steps(integrator: Integrator, rate: float) -> dict[str, Any]:
    """The calls over the span with the fewest of `PER_SECOND` steps that have an error of `LOOSE` at most.

    None if all errors are larger, or calls are not counted.
    """
    error = math.nan
    for count in PER_SECOND:
        solution, errors = solve_at(integrator, rate, multiples(STIFF_SPAN), 1 / count)
        error = float(np.max(errors))
        if error <= LOOSE:
            break
    costs = {"rate": rate, "tolerance": LOOSE, "calls": None, "worst": error, "fewest": fewest(rate, LOOSE)}
    if not integrator.counts_rhs:
        return costs | {"why": "its calls are not counted"}
    if not error <= LOOSE:
        return costs | {"why": f"its error is {error:.2g} at rate {rate:g} with {count} steps a second"}
    return costs | {"calls": round(solution.calls * SPAN / STIFF_SPAN)}


def follow_fixed_steps(integrator: Integrator) -> dict[str, Any]:
    """The order and the errors of a method of fixed steps at h rate from 3e4 to 1e6.

    The order is None if an error is not below 1, or if fewer than three errors are above round-off. `rows`: the calls
    of a stable method.
    """
    outcomes = (solve_at(integrator, VERY_FAST, multiples(STIFF_SPAN), 1 / count) for count in PER_SECOND)
    errors = [float(np.max(errors)) for _, errors in outcomes]
    points = [(math.log(n), math.log(e)) for n, e in zip(PER_SECOND, errors, strict=True) if ROUND_OFF < e < 1]
    stable = all(error < 1 for error in errors)
    order, declared = None, integrator.order
    if stable and len(points) > 2:
        order = -float(np.polyfit([x for x, _ in points], [y for _, y in points], 1)[0])
    rows = [measure_fixed_steps(integrator, rate) for rate in (RATE, FAST, VERY_FAST)] if stable else []
    return {
        "stable": stable, "stiff_order": order, "declared": declared, "errors": errors, "per_second": PER_SECOND,
        "rows": rows,
    }  # fmt: skip


def solve_at(integrator: Integrator, rate: float, times: Floats, setting: float) -> tuple[Solved, Floats]:
    """The outcome on the decay, and its errors (samples,)."""
    problem = Problem(form_for(integrator), 1, np.array([rate]), times, 1.0, counted=integrator.counts_rhs)  # type: ignore[arg-type]
    outcome = solve_within(integrator, problem, setting, np.ones((1, 1)))
    return outcome, np.abs(outcome.states[0, :, 0] - np.cos(times))

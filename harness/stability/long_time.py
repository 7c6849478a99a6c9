"""Energy and position over many periods, and the drift of a linear method's own invariant: powers of time, and biases."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import FirstOrder, Hybrid, SecondOrder, Values, first_order
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Steps, Tolerance
from gnomon.harness.contract.problem import takes
from gnomon.harness.contract.status import Status
from gnomon.harness.results.convergence_order import mean_and_half
from gnomon.harness.stability.panel import Column, Mark, panel
from gnomon.harness.stability.solving import multiples, processor_seconds, solved
from gnomon.harness.stability.subjects import Budget
from gnomon.harness.studies.growth import (
    DECADES,
    LAWS,
    Subject,
    by_octaves,
    named,
    period_of,
    possible,
    relative_drift,
    trajectories,
)

CASES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("pendulum_simple", {}),
    ("kepler_orbit", {}),
    ("charge_in_E_and_B", {"Ez": 0}),
    ("euler_top", {}),
    ("holonomic_constraint_dae", {}),
)
"""The first that an integrator accepts is solved. Each has an energy that is constant, and a period."""
PERIODS, MOST_PERIODS = 64, 2**20
STARTS, MANY_STARTS, MANY_SECONDS = 8, 24, 30.0
"""Starts, and how many where there is more processor time than `MANY_SECONDS`."""
FEWEST_STARTS, SLOW = 3, 1.5
"""Starts of a method so slow that more would take over 1.5 times its share; the interval is wider then."""
SAMPLES_FEWEST, SAMPLES_MOST, A_PERIOD = 256, 2048, 4
EXACT = 20
"""Times at which the exact motion is computed for each start, in equal ratios."""
USUAL = 1e-8
STEPS_A_PERIOD = ((2, 64), (4, 48), (6, 32), (8, 24))
"""Order of a method up to which a period has this number of steps; 16 above. More where its longest step needs them."""
LOST = 0.3
"""Errors above this say nothing of a power: the energy, or the phase, is lost."""
STEP, STEPS, FIT = 13 / 128, 2**20, 64
"""The step on the oscillator is below the limit of every method here, and no simple share of the period."""
KEPT = 2.0**-40
"""The spread of a quadratic form along FIT samples, relative to its size, up to which it is the method's invariant."""
ULP = 2.0**-52


def _applies(integrator: Integrator) -> str | None:
    hybrid = all(issubclass(kind, Hybrid) for kind in integrator.accepts)
    return "it takes equations with events only, which have no long smooth motion" if hybrid else None


def sentences(data: Mapping[str, Any]) -> list[str]:
    """What follows for one who chooses, from the data of `long_time`."""
    found = []
    for row in data["runs"]:
        if Status.REFUSED in row:
            found.append(f"Not for {data['case']} over {PERIODS} periods at {row['named']}: {row[Status.REFUSED]}.")
            continue
        over = f"{row['periods']:g} periods of {data['case']} at {row['named']}"
        energy, position = row["energy"], row["position"]
        if energy["class"] == "lost":
            found.append(f"Not for {over}: its energy is lost (error {_size(energy)}).")
        elif energy["class"] == "no error":
            found.append(f"Use it for {over}: its energy has no error.")
        elif _slow(energy):
            found.append(f"Use it for {over}: its energy error is {_law(energy)}, {_size(energy)} at the end.")
        else:
            found.append(f"Not for much more than {over}: its energy error grows as {_law(energy)}, {_size(energy)}"
                         " at the end.")  # fmt: skip
        if position["lost_after"] is not None:
            found.append(f"Not for positions after {position['lost_after']:.3g} periods at {row['named']}: the phase is"
                         " lost.")  # fmt: skip
        if row["stopped"]:
            found.append(f"Not for {row['stopped']}.")
        if row["brouwer"]:
            found.append(f"Brouwer's law is {row['brouwer']} at {row['named']}.")
    linear = data.get("oscillator") or {}
    if linear.get("drift_ulp") is not None:
        law = _law(linear | {"class": linear["law"]})
        steps, drift = linear["steps"], f"{linear['drift_ulp']:.3g} ulp"
        found.append(f"Round-off changes its own invariant of the oscillator by {drift} in {steps} steps: {law}.")
    return found


def _size(row: Mapping[str, Any]) -> str:
    return "not finite" if row["size"] is None else f"{row['size']:.2g}"


def _law(row: Mapping[str, Any]) -> str:
    return f"{row['class']} (power {row['low']:.2f} to {row['high']:.2f})" if row["low"] is not None else row["class"]


COLUMNS = (
    Column("usual", "power of time of the energy error", ends=(-0.5, 2.5)),
    Column("tightest", "the same at the tightest tolerance", ends=(-0.5, 2.5)),
    Column("position", "power of time of the position error", ends=(-0.5, 2.5)),
    Column("drift", "drift of its invariant (ulp)", True),
)


def marks(data: Mapping[str, Any]) -> list[Mark]:
    """The powers with which energy and position err, and the drift by round-off."""
    found = []
    for column, row in zip(("usual", "tightest"), data["runs"], strict=False):
        if Status.REFUSED in row:
            found.append(Mark(column, text=row[Status.REFUSED]))
            continue
        text = f"{_law(row['energy'])}, {_size(row['energy'])} after {row['periods']:g} periods, {row['named']}"
        energy = row["energy"]
        found.append(Mark(column, energy["power"], energy["low"], energy["high"], text))
        position = row["position"]
        if column == "usual" and position.get("power") is not None:
            found.append(Mark("position", position["power"], position["low"], position["high"], _law(position)))
    linear = data.get("oscillator") or {}
    if linear.get("drift_ulp") is not None:
        text = f"{linear['drift_ulp']:.3g} ulp in {linear['steps']} steps: {linear['law']}"
        found.append(Mark("drift", linear["drift_ulp"], text=text))
    return found


@panel("long_time", "Long motions and round-off", sentences, COLUMNS, marks, _applies)
def long_time(integrator: Integrator, seconds: float) -> dict[str, Any]:
    """Runs at a usual setting and, where the setting is a tolerance, at the tightest; fixed steps on the oscillator.

    Raises Refused for an integrator that accepts none of the cases.
    """
    name, case = _case(integrator)
    settings = _settings(integrator)
    parts = len(settings) + isinstance(integrator.sweep, Steps)
    starts = MANY_STARTS if seconds > MANY_SECONDS else STARTS
    runs = []
    for setting in settings:
        subject = Subject(integrator.id, setting, "", name, PERIODS, starts, together=starts, samples=SAMPLES_FEWEST)
        word = f"{setting:g} steps a period" if setting > 1 else f"tolerance {setting:g}"
        runs.append({"setting": setting, "named": word} | run(integrator, case, subject, seconds / parts))
    found: dict[str, Any] = {"case": name, "runs": runs}
    if isinstance(integrator.sweep, Steps) and {FirstOrder, SecondOrder} & set(integrator.accepts):
        try:
            found["oscillator"] = oscillator(integrator, seconds / parts, starts)
        except Refused as reason:
            found["oscillator"] = {Status.REFUSED: str(reason)}
    return found


def _case(integrator: Integrator) -> tuple[str, Case]:
    for name, parameters in CASES:
        case = get(name, **parameters).rounded()
        if takes(integrator, case):
            return name, case
    raise Refused(f"it accepts none of {', '.join(name for name, _ in CASES)}")


def _settings(integrator: Integrator) -> list[float]:
    sweep = integrator.sweep
    if isinstance(sweep, Tolerance):
        return [min(max(USUAL, sweep.tightest), sweep.loosest), sweep.tightest]
    order = integrator.order or 2
    steps = next((steps for most, steps in STEPS_A_PERIOD if order <= most), 16)
    return [float(max(steps, math.ceil(2 * math.pi / sweep.coarsest)))]


def run(integrator: Integrator, case: Case, subject: Subject, seconds: float) -> dict[str, Any]:
    """The growth of the errors of energy and position over as many periods as the processor time allows."""
    try:
        short = replace(subject, periods=8.0, samples=64, starts=1)
        trajectories(short, case, integrator)  # compiles
        each = processor_seconds(lambda: trajectories(short, case, integrator)) * subject.periods / short.periods
        starts = Budget(max(SLOW * seconds, 1.0)).affords(each, FEWEST_STARTS, subject.starts)
        subject = replace(subject, starts=starts, together=starts)
        budget, periods = Budget(seconds), float(subject.periods)
        first = trajectories(subject, case, integrator)
        each = max(seconds - budget.left, 1e-6)
        factor = 2.0 ** math.floor(math.log2(max(1.0, budget.left / each)))
    except (Refused, RuntimeError) as reason:
        return {Status.REFUSED: str(reason)}
    longer = longer_subject(subject, min(factor * periods, MOST_PERIODS))
    stopped: str | None = None
    try:
        found = trajectories(longer, case, integrator) if longer.periods > periods else first
    except (Refused, RuntimeError) as reason:  # some methods limit the number of their steps
        found, stopped = first, f"{longer.periods:g} periods: {reason}"
    times, start, states = found
    counted = times / period_of(case)
    energy = grown(counted, relative_drift(case, start, states))
    tightest = subject.setting < 1 and subject.setting == getattr(integrator.sweep, "tightest", None)
    return {
        "periods": float(counted[-1]),
        "starts": len(start),
        "energy": energy,
        "position": _position(case, times, start, states),
        "brouwer": brouwer(energy) if tightest else None,
        "stopped": stopped,
    }


def longer_subject(subject: Subject, periods: float) -> Subject:
    samples = int(min(SAMPLES_MOST, max(SAMPLES_FEWEST, A_PERIOD * periods)))
    return replace(subject, periods=periods, samples=samples)


def grown(times: Floats, errors: Floats) -> dict[str, Any]:
    """The power of time of errors (starts, times) with its 95 % interval over the starts (Student's t), and its class.

    `size`: the median over starts of the root mean square of the last samples. The class is "lost" where that is above
    0.3, else a law of `growth.LAWS`, or those that the interval does not exclude.
    """
    last = max(1, errors.shape[1] // 16)
    with np.errstate(all="ignore"):
        size = float(np.median(np.sqrt(np.mean(errors[:, -last:] ** 2, axis=1))))
    nothing = {"size": size, "power": None, "low": None, "high": None}
    if not size <= LOST:
        return nothing | {"class": "lost"}
    centres, sizes = by_octaves(times, errors, math.ceil(DECADES / math.log10(2)))
    usable = np.all(np.isfinite(sizes), axis=0)  # a start without any error in an octave has no power
    powers = np.polyfit(centres, sizes[:, usable], 1)[0] if len(centres) > 1 and np.any(usable) else np.array([])
    if len(powers) < 2:
        return nothing | {"class": "no error" if size == 0 else "undecided"}
    power, half = mean_and_half(powers)
    low, high = power - half, power + half
    return {"size": size, "power": power, "low": low, "high": high, "class": named(low, high)}


def brouwer(energy: Mapping[str, Any]) -> str:
    """Whether round-off makes the energy a random walk: kept, not kept, or undecided with the interval of the power."""
    if energy["low"] is None:
        return "not kept" if energy["class"] == "lost" else "undecided"
    words = {True: "kept", False: "not kept", None: "undecided"}
    return f"{words[_slow(energy)]} (power {energy['low']:.2f} to {energy['high']:.2f})"


def _slow(energy: Mapping[str, Any]) -> bool | None:
    """Whether the energy error grows no faster than a random walk; None if the interval of the power does not say."""
    if energy["low"] is None:
        return None
    laws = possible(energy["low"], energy["high"])
    if not laws:
        return bool(energy["high"] < LAWS["sqrt t"])
    slow = [law for law in laws if LAWS[law] <= LAWS["sqrt t"]]
    return None if 0 < len(slow) < len(laws) else bool(slow)


def _position(case: Case, times: Floats, start: Floats, states: Floats) -> dict[str, Any]:
    """The growth of the distance from the exact motion; `lost_after`: the period at which it is above 0.3."""
    wanted = np.geomspace(times[0], times[-1], EXACT)
    at = np.unique(np.searchsorted(times, wanted).clip(max=len(times) - 1))
    errors = np.full((len(start), len(at)), np.nan)
    for row, one, path in zip(errors, start, states, strict=True):
        try:
            exact = case.with_numbers(one.tolist(), case.parameters)
        except ValueError:
            continue  # a start outside the domain of the case has no exact motion
        with np.errstate(all="ignore"):
            row[:] = case.metric.distance(path[at], exact.sample(times[at]))
    errors = errors[~np.all(np.isnan(errors), axis=1)]
    periods = times[at] / period_of(case)
    if not len(errors):
        return {"class": "no exact motion", "lost_after": None}
    lost = np.flatnonzero(~(np.median(errors, axis=0) <= LOST))
    if not len(lost):
        return grown(periods, errors) | {"lost_after": None}
    known = slice(0, max(1, lost[0]))  # afterwards the distance is that of any two states of the motion
    return grown(periods[known], errors[:, known]) | {"lost_after": float(periods[lost[0]])}


def spring(t: Any, q: Values, parameters: Values) -> Values:
    return (-q[0],)


def oscillator(integrator: Integrator, seconds: float, starts: int) -> dict[str, Any]:
    """The drift of the method's own quadratic invariant of q'' = -q over up to 2^20 equal steps, in ulp.

    The invariant is fitted to the first steps. `bias`: the mean drift a step over the starts, with its standard error;
    a method without an invariant gives the change of the energy in a step.
    """
    own = SecondOrder(spring)
    form = next(f for f in (own, first_order(own)) if isinstance(f, integrator.accepts))
    angles = 0.3 + np.arange(starts)
    start = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    near = _solved(integrator, form, start, FIT, 1)
    forms, spread = invariant(near)
    if spread > KEPT:
        energy = np.sum(near[:, [0, -1]] ** 2, axis=2)
        loss = float(np.median(energy[:, 1] / energy[:, 0] - 1)) / (FIT - 1)
        return {"step": STEP, "steps": FIT, "starts": starts, "drift_ulp": None, "energy_change_a_step": loss}
    samples = 512
    each = processor_seconds(lambda: _solved(integrator, form, start, samples, 4)) / (4 * samples)
    substeps = 2 ** int(math.log2(min(STEPS / samples, max(4.0, seconds / each / samples))))
    states = _solved(integrator, form, start, samples, substeps)
    drift = _values(forms, states) / _values(forms, start[:, None]) - 1
    steps = substeps * samples
    row = grown(multiples(samples, float(substeps)), np.abs(drift).astype(np.float64))
    bias = drift[:, -1].astype(np.float64) / steps / ULP
    return {
        "step": STEP, "steps": steps, "starts": starts, "drift_ulp": row["size"] / ULP,
        "power": row["power"], "low": row["low"], "high": row["high"], "law": row["class"],
        "bias_ulp_a_step": float(np.mean(bias)), "bias_error": float(np.std(bias, ddof=1) / math.sqrt(starts)),
    }  # fmt: skip


def _solved(integrator: Integrator, form: Any, start: Floats, samples: int, substeps: int) -> Floats:
    """States (starts, samples, 2) with `substeps` steps of STEP a sample. Raises Refused where the method stops."""
    problem = Problem(form, 2, np.array([]), multiples(samples, STEP * substeps), 1.0)
    solution = solved(integrator, problem, STEP, start)
    if solution.stopped is not None or not np.all(np.isfinite(solution.states)):
        raise Refused(solution.stopped or "states on the oscillator are not finite")
    return solution.states


def invariant(states: Floats) -> tuple[Floats, float]:
    """The quadratic form (a, b, c) of a q^2 + 2 b q v + c v^2 that changes least along states (starts, times, 2), and
    its root mean square change relative to its mean."""
    q, v = states.astype(np.longdouble)[..., 0], states.astype(np.longdouble)[..., 1]
    rows = np.stack([q * q, 2 * q * v, v * v], axis=-1)
    changes = (rows - rows.mean(axis=1, keepdims=True)).reshape(-1, 3).astype(np.float64)
    form = np.linalg.svd(changes)[2][-1]
    size = abs(float(np.mean(rows @ form)))
    return form, float(np.sqrt(np.mean((changes @ form) ** 2))) / size if size > 0 else math.inf


def _values(form: Floats, states: Floats) -> Any:
    q, v = np.moveaxis(states.astype(np.longdouble), -1, 0)
    a, b, c = form.astype(np.longdouble)
    return a * q * q + 2 * b * q * v + c * v * v

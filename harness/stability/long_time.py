"""Growth of energy and position errors over many periods, and drift of a method's own invariant of the oscillator."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import FirstOrder, SecondOrder, Values, first_order
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Steps, Tolerance
from gnomon.harness.contract.problem import takes
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.solved import solve_within
from gnomon.harness.results.convergence_order import mean_and_half
from gnomon.harness.stability.panel import Column, Mark, panel
from gnomon.harness.stability.subjects import Budget, multiples, processor_seconds, smooth_reason
from gnomon.harness.studies.growth import FIT as BIAS
from gnomon.harness.studies.growth import LAWS, Subject, fit_powers, name_law, period_of, relative_drift, trajectories

CASES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("pendulum_simple", {}),
    ("kepler_orbit", {}),
    ("charge_in_E_and_B", {"Ez": 0}),
    ("euler_top", {}),
    ("holonomic_constraint_dae", {}),
)
"""The first case that an integrator accepts is solved. Each has a constant energy and a period."""
PERIODS, MOST_PERIODS = 64, 2**20
STARTS, MANY_STARTS, MANY_SECONDS = 8, 24, 30.0
"""Number of starts, and number of starts if there is more processor time than `MANY_SECONDS`."""
FEWEST_STARTS, SLOW = 3, 1.5
"""Number of starts, with a wider interval, if more of them would take over 1.5 times the method's share of the time."""
SAMPLES_FEWEST, SAMPLES_MOST, A_PERIOD = 256, 2048, 4
EXACT = 20
"""Number of times, in equal ratios, at which the exact motion is computed for each start."""
USUAL = 1e-8
STEPS_A_PERIOD = ((2, 64), (4, 48), (6, 32), (8, 24))
"""Steps of a period, by the largest order of a method; 16 above. More if the longest step of the method needs them."""
LOST = 0.3
"""Errors above this have no power of time: the energy, or the phase, is lost."""
STEP, STEPS, FIT = 13 / 128, 2**20, 64
"""The step on the oscillator is below the stability limit of every method here, and no simple share of the period."""
KEPT = 2.0**-40
"""Largest relative spread of a quadratic form along FIT samples for it to be the method's invariant."""
ULP = 2.0**-52
ROUNDED = 4.0
"""Change of the energy by the roundings of a step, in ulp in the root mean square, up to which Brouwer's law is kept. A
rounding changes the state by less than one ulp, and the energy by a few times as much. Measured are 0.02 to 0.5 where
the law is kept, and 9 or more where truncation dominates."""
NEARER = 0.25
"""Half of the distance between two laws. The power of a law is an upper bound if the measured interval begins at or
below it, and ends nearer to it than to the next law."""
BIASED, FALLS = 5.0, 0.5
"""A mean drift of more than BIASED standard errors is a bias. If half the step reduces it to less than the part FALLS,
it comes from truncation, which falls by four at least; the rounding of a step does not depend on its size."""
APART = 16
"""Number of steps between the positions from which the principal root is fitted: a quarter of a period."""


def sentences(data: Mapping[str, Any]) -> list[str]:
    """Advice for the choice of an integrator, from the data of `long_time`."""
    advice = []
    for row in data["runs"]:
        if Status.REFUSED in row:
            advice.append(f"Not for {data['case']} over {PERIODS} periods at {row['named']}: {row[Status.REFUSED]}.")
            continue
        over = f"{row['periods']:.0f} periods of {data['case']} at {row['named']}"
        energy, position = row["energy"], row["position"]
        if energy["class"] == "lost":
            advice.append(f"Not for {over}: its energy is lost (error {_size(energy)}).")
        elif energy["class"] == "no error":
            advice.append(f"Use it for {over}: its energy has no error.")
        else:
            slow, size = at_most(energy, "sqrt t"), f"{_law(energy)}, {_size(energy)} at the end"
            how = "Use it for" if slow else "Undecided for more than" if slow is None else "Not for much more than"
            advice.append(f"{how} {over}: its energy error {'grows as' if slow is False else 'is'} {size}.")
        if position["lost_after"] is not None:
            advice.append(f"Not for positions after {position['lost_after']:.3g} periods at {row['named']}: the phase is"
                         " lost.")  # fmt: skip
        if row["stopped"]:
            advice.append(f"Not for {row['stopped']}.")
        if row.get("tightest"):
            advice.append(f"Brouwer's law is {brouwer(row)} at {row['named']}.")
    return advice + _on_invariant(data.get("oscillator") or {})


def _on_invariant(linear: Mapping[str, Any]) -> list[str]:
    if linear.get("drift_ulp") is None or "half_step" not in linear:
        return []
    if is_truncation(linear):
        return [f"Truncation, not round-off, changes its own invariant of the oscillator: by {linear['bias_ulp_a_step']:.3g}"
                f" ulp a step of h w = {linear['step']:.4g}."]  # fmt: skip
    law, drift = _law({**linear, "class": linear["law"]}), f"{linear['drift_ulp']:.3g} ulp"
    return [f"Round-off changes its own invariant of the oscillator by {drift} in {linear['steps']} steps: {law}."]


def is_truncation(linear: Mapping[str, Any]) -> bool:
    """Whether a bias of the invariant falls with the step, as for truncation but not for round-off."""
    half = linear["half_step"]
    return half is not None and abs(half) < FALLS * abs(linear["bias_ulp_a_step"])


def _size(row: Mapping[str, Any]) -> str:
    return "not finite" if row["size"] is None else f"{row['size']:.2g}"


def _law(row: Mapping[str, Any]) -> str:
    known = row.get("low") is not None
    return f"{row['class']} (power {row['low']:.2f} to {row['high']:.2f})" if known else str(row["class"])


COLUMNS = (
    Column("usual", "power of time of the energy error", ends=(-0.5, 2.5)),
    Column("tightest", "the same at the tightest tolerance", ends=(-0.5, 2.5)),
    Column("position", "power of time of the position error", ends=(-0.5, 2.5)),
    Column("drift", "drift of its invariant (ulp)", True),
)


def marks(data: Mapping[str, Any]) -> list[Mark]:
    """The powers of time of the energy and position errors, and the drift by round-off."""
    marks = []
    for column, row in zip(("usual", "tightest"), data["runs"], strict=False):
        if Status.REFUSED in row:
            marks.append(Mark(column, text=row[Status.REFUSED]))
            continue
        text = f"{_law(row['energy'])}, {_size(row['energy'])} after {row['periods']:.0f} periods, {row['named']}"
        energy = row["energy"]
        marks.append(Mark(column, energy["power"], energy["low"], energy["high"], text))
        position = row["position"]
        if column == "usual" and position.get("power") is not None:
            marks.append(Mark("position", position["power"], position["low"], position["high"], _law(position)))
    linear = data.get("oscillator") or {}
    if linear.get("drift_ulp") is not None and "half_step" in linear and not is_truncation(linear):
        text = f"{linear['drift_ulp']:.3g} ulp in {linear['steps']} steps: {linear['law']}"
        marks.append(Mark("drift", linear["drift_ulp"], text=text))
    return marks


@panel("long_time", "Long motions and round-off", sentences, COLUMNS, marks, smooth_reason)
def long_time(integrator: Integrator, seconds: float) -> dict[str, Any]:
    """Runs at a usual setting, for tolerances also at the tightest one, and for fixed steps on the oscillator.

    Raises Refused for an integrator that does not accept any of the cases.
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
    data: dict[str, Any] = {"case": name, "runs": runs}
    if isinstance(integrator.sweep, Steps) and {FirstOrder, SecondOrder} & set(integrator.accepts):
        try:
            data["oscillator"] = oscillator(integrator, seconds / parts, starts)
        except Refused as reason:
            data["oscillator"] = {Status.REFUSED: str(reason)}
    return data


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
    """The growth of the energy and position errors over as many periods as the processor time allows.

    `steps`: the number of steps from one start, None if the integrator does not count them.
    """
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
    except Refused as reason:
        return {Status.REFUSED: str(reason)}
    longer = longer_subject(subject, min(factor * periods, MOST_PERIODS))
    stopped: str | None = None
    try:
        trajectory = trajectories(longer, case, integrator) if longer.periods > periods else first
    except Refused as reason:  # some methods limit the number of their steps
        trajectory, stopped = first, f"{longer.periods:.0f} periods: {reason}"
    times, start, states, steps = trajectory
    counted = times / period_of(case)
    energy = fit_growth(counted, relative_drift(case, start, states))
    return {
        "periods": float(counted[-1]),
        "starts": len(start),
        "steps": steps,
        "energy": energy,
        "position": _position(case, times, start, states),
        "tightest": subject.setting < 1 and subject.setting == getattr(integrator.sweep, "tightest", None),
        "stopped": stopped,
    }


def longer_subject(subject: Subject, periods: float) -> Subject:
    samples = int(min(SAMPLES_MOST, max(SAMPLES_FEWEST, A_PERIOD * periods)))
    return replace(subject, periods=periods, samples=samples)


def fit_growth(times: Floats, errors: Floats) -> dict[str, Any]:
    """The power of time of errors (starts, times) with its 95 % interval over the starts (Student's t), and its class.

    `size`: the median over starts of the root mean square of the last samples. The class is "lost" if the size is above
    0.3, else a law of `growth.LAWS`, or the laws that the interval does not exclude.
    """
    last = max(1, errors.shape[1] // 16)
    with np.errstate(all="ignore"):
        size = float(np.median(np.sqrt(np.mean(errors[:, -last:] ** 2, axis=1))))
    nothing = {"size": size, "power": None, "low": None, "high": None}
    if not size <= LOST:
        return nothing | {"class": "lost"}
    powers = fit_powers(times, errors)
    if len(powers) < 2:
        return nothing | {"class": "no error" if size == 0 else "undecided"}
    power, half = mean_and_half(powers)
    low, high = power - half, power + half
    return {"size": size, "power": power, "low": low, "high": high, "class": name_law(low, high)}


def brouwer(row: Mapping[str, Any]) -> str:
    """Whether the error of a run is a random walk of round-off: "kept", "not kept" or "undecided", with the numbers.

    The law is kept if the energy error grows at most as t^(1/2), the position error grows at most as t^(3/2), and the
    energy error is below `ROUNDED` ulp times the square root of the number of steps.
    """
    energy, position, steps = row["energy"], row["position"], row.get("steps")
    size = energy["size"] / ULP / math.sqrt(steps) if steps and energy["size"] is not None else None
    verdicts = [at_most(energy, "sqrt t"), at_most(position, "t^1.5"), None if size is None else size <= ROUNDED]
    word = "not kept" if False in verdicts else "undecided" if None in verdicts else "kept"
    numbers = [f"{of} error {_law(each)}" for of, each in (("energy", energy), ("position", position))]
    numbers.append("steps not counted" if size is None else f"{size:.2g} ulp of energy times the root of the steps")
    return f"{word} ({'; '.join(numbers)})"


def at_most(row: Mapping[str, Any], law: str) -> bool | None:
    """Whether errors grow no faster than a law; None if the interval of the power is too wide to tell."""
    low, high = row.get("low"), row.get("high")
    if low is None or high is None:
        return False if row["class"] == "lost" else None
    if low > LAWS[law] + BIAS:
        return False
    return True if high < LAWS[law] + NEARER else None


def _position(case: Case, times: Floats, start: Floats, states: Floats) -> dict[str, Any]:
    """The growth of the distance from the exact motion; `lost_after`: the periods after which it is above 0.3."""
    wanted = np.geomspace(times[0], times[-1], EXACT)
    at = np.unique(np.searchsorted(times, wanted).clip(max=len(times) - 1))
    errors = np.full((len(start), len(at)), np.nan)
    for row, initial, path in zip(errors, start, states, strict=True):
        try:
            exact = case.with_numbers(initial.tolist(), case.parameters)
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
        return fit_growth(periods, errors) | {"lost_after": None}
    known = slice(0, max(1, lost[0]))  # later the distance is as large as between any two states of the motion
    return fit_growth(periods[known], errors[:, known]) | {"lost_after": float(periods[lost[0]])}


def spring(t: Any, q: Values, parameters: Values) -> Values:
    return (-q[0],)


def oscillator(integrator: Integrator, seconds: float, starts: int) -> dict[str, Any]:
    """The drift of the method's own quadratic invariant of q'' = -q over up to 2^20 equal steps, in ulp.

    The invariant is fitted to the first steps. `bias_ulp_a_step`: the mean drift a step over the starts; `bias_error`:
    its standard error; `half_step`: the mean drift with half the step, if it is a bias. For a method without an
    invariant the result is the change of energy in a step.
    """
    own = SecondOrder(spring)
    form = next(f for f in (own, first_order(own)) if isinstance(f, integrator.accepts))
    angles = 0.3 + np.arange(starts)
    start = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    near = _solve(integrator, form, start, FIT, 1)
    if invariant(near)[1] > KEPT:
        change = principal(near)
        return {"step": STEP, "steps": FIT, "starts": starts, "drift_ulp": None, "energy_change_a_step": change}
    samples = 512
    each = processor_seconds(lambda: _solve(integrator, form, start, samples, 4)) / (4 * samples)
    substeps = 2 ** int(math.log2(min(STEPS / samples, max(4.0, seconds / each / samples))))
    steps = substeps * samples
    drift = _drift(integrator, form, start, samples, substeps, STEP)
    row = fit_growth(multiples(samples, float(substeps)), np.abs(drift))
    bias, error = _bias(drift, steps)
    half = None
    if abs(bias) > BIASED * error:
        half, _ = _bias(_drift(integrator, form, start, samples, substeps, STEP / 2), steps)
    return {
        "step": STEP, "steps": steps, "starts": starts, "drift_ulp": row["size"] / ULP,
        "power": row["power"], "low": row["low"], "high": row["high"], "law": row["class"],
        "bias_ulp_a_step": bias, "bias_error": error, "half_step": half,
    }  # fmt: skip


def _drift(integrator: Integrator, form: Any, start: Floats, samples: int, substeps: int, step: float) -> Floats:
    """The change (starts, samples) of the invariant fitted to the first steps, relative to its value at the start."""
    form_of_invariant, _ = invariant(_solve(integrator, form, start, FIT, 1, step))
    states = _solve(integrator, form, start, samples, substeps, step)
    drift = _values(form_of_invariant, states) / _values(form_of_invariant, start[:, None]) - 1
    return np.asarray(drift, dtype=np.float64)


def _bias(drift: Floats, steps: int) -> tuple[float, float]:
    """The mean drift in ulp a step, and its standard error over the starts."""
    rates = drift[:, -1] / steps / ULP
    return float(np.mean(rates)), float(np.std(rates, ddof=1) / math.sqrt(len(rates)))


def principal(states: Floats) -> float:
    """The change of energy in a step, |r|^2 - 1 for the principal root r, from states (starts, times, 2) on q'' = -q.

    Positions `APART` steps apart satisfy q_2 = (r^n + conj r^n) q_1 - |r|^2n q_0, for a multistep method after its
    other roots have decayed. Raises Refused for positions that do not vibrate.
    """
    q = states[..., 0]
    before, at, after = q[:, : -2 * APART], q[:, APART:-APART], q[:, 2 * APART :]
    coefficients = np.linalg.lstsq(np.column_stack([at.ravel(), -before.ravel()]), after.ravel())[0]
    if not coefficients[1] > 0:
        raise Refused("its positions on the oscillator do not vibrate")
    return math.expm1(math.log(float(coefficients[1])) / APART)


def _solve(integrator: Integrator, form: Any, start: Floats, samples: int, substeps: int, step: float = STEP) -> Floats:
    """States (starts, samples, 2) with `substeps` steps a sample. Raises Refused if the method stops."""
    problem = Problem(form, 2, np.array([]), multiples(samples, step * substeps), 1.0)
    states = solve_within(integrator, problem, step, start, moves=True).whole.states
    if not np.all(np.isfinite(states)):
        raise Refused("states on the oscillator are not finite")
    return states


def invariant(states: Floats) -> tuple[Floats, float]:
    """The quadratic form (a, b, c) of a q^2 + 2 b q v + c v^2 that changes least along states (starts, times, 2).

    The second result is its root mean square change relative to its mean.
    """
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

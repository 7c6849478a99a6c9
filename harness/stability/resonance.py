"""The panel of step resonances and of the nonlinear limit, for methods of fixed steps.

Resonances: on x'' = -w^2 (x - x^2) a step turns the phase by an angle that the matrix of the linear problem gives. If
the angle is 2 pi/3 or 2 pi/4, the nonlinear terms of successive steps add up, and a small motion may grow until it
escapes (Schlick, Mandziuk, Skeel and Srinivas, Journal of Computational Physics 140, 1998). Methods without a linear
limit have resonances too.

Nonlinear limit: the linear limit, divided by the largest modulus of an eigenvalue of the Jacobian along the exact
motion, predicts the step at which a motion fails. The prediction holds on a linear case, where steps below it are
tried; elsewhere the ratio is shown.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.forms import FirstOrder, SecondOrder, Values, first_order
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused
from gnomon.harness.contract.problem import find_accepted_form, first_taken, initial_state, problem_of
from gnomon.harness.measuring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.measuring.score import NUMPY
from gnomon.harness.measuring.solved import solve_within
from gnomon.harness.stability.linear import first_limit, scan, several_steps, steps_reason
from gnomon.harness.stability.linear_problems import problem_for
from gnomon.harness.stability.panel import Column, Mark, panel
from gnomon.harness.stability.step_matrix import Flags, StepMatrix
from gnomon.harness.stability.subjects import Budget, multiples, processor_seconds

STEPS_A_SAMPLE, SAMPLES = 32, 64
AMPLITUDES = (0.05, 0.2)
ESCAPED = 10.0
"""Size at which a motion has escaped: from x = 1 the force points outwards, so a motion that grows leaves at once."""
GROWN = 1.5
"""Growth that counts as a resonance. Without one the size grows at most 1.2 times, from the asymmetry of the force."""
ORDERS = (3, 4)
WINDOW = 0.06
"""Half the width of the scan around a prediction, as a part of the prediction."""
POINTS = (121, 61, 31, 15)
UP_TO = 6.0
"""Largest h w at which a resonance is searched."""
FEWEST, MOST = 40, 1691
"""Points of the scan up to the linear limit; the scan is left out if time does not allow for the fewest."""
CONSERVES = 1e-6
"""Largest difference of the modulus of an eigenvalue from 1: a method that damps has no resonance."""

CASES = (("small_vibrations_3dof_chain", True), ("pendulum_simple", False), ("spring_pendulum", False),
         ("kepler_orbit", False))  # fmt: skip
"""Cases of the nonlinear limit, each with whether its motion is linear."""
RATIOS = (0.25, 2.0)
RATIO_STEP = 1.02
FAILED = 10.0
"""Distance from the start, in sizes of a coordinate, at which a motion has failed."""
TRIALS, TRIAL_STEPS = 200, 65536
"""Number of step sizes, up to a recommended one, with which a linear case is solved, and number of steps of each."""
AFFORDED = 16.0
"""The trials are left out if they would take more than this multiple of the time for a case."""
GROWS = 2.0
"""A motion grows if the largest size in the second half of a trial is more than this multiple of the first half's."""


def cubic_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = -k (x - x^2), k constant."""
    x, k = q
    return -(k * (x - x * x)), 0 * k


CUBIC = SecondOrder(cubic_acceleration)


def cubic_form(integrator: Integrator) -> SecondOrder | FirstOrder | None:
    form: SecondOrder | FirstOrder | None = first_taken(integrator, (CUBIC, first_order(CUBIC)))
    return form


def reason(integrator: Integrator) -> str | None:
    why = steps_reason(integrator)
    if why is None and cubic_form(integrator) is None:
        return "it takes neither q'' = a(q) nor y' = f(y)"
    return why


def sentences(data: Mapping[str, Any]) -> list[str]:
    advice = []
    for row in data["resonances"]:
        seen = [each for each in row["seen"] if each is not None]
        if seen:
            low, high = min(each["from"] for each in seen), max(each["to"] for each in seen)
            escapes = any(each["escapes"] for each in seen)
            what = "escape" if escapes else f"grow {max(each['factor'] for each in seen):.2g} times"
            advice.append(
                f"Not for nonlinear vibrations at h w from {low:.4g} to {high:.4g}: they {what}"
                f" (resonance of order {row['order']}, predicted at {row['predicted']:.4g})."
            )
    unseen = ", ".join(f"{row['predicted']:.4g}" for row in data["resonances"] if not any(row["seen"]))
    if unseen:
        advice.append(f"Use it at the predicted resonances h w = {unseen}: no motion grew within 2048 steps.")
    elsewhere = [
        f"{low:.4g} to {high:.4g}"
        for low, high in (data["scan"] or {"escapes": []})["escapes"]
        if not any(
            abs(x - row["predicted"]) < WINDOW * row["predicted"] for row in data["resonances"] for x in (low, high)
        )
    ]
    if elsewhere:
        advice.append(f"Not for nonlinear vibrations at h w from {', '.join(elsewhere)}: they escape there too.")
    for row in data["limits"]:
        trial = row.get("trial")
        if trial is not None and trial["grows_at"] is not None:
            advice.append(f"Not for {row['case']} at h = {trial['grows_at']:.6g}, though linear theory allows steps up to"
                         f" {row['predicted']:.4g}: it grows within {TRIAL_STEPS} steps.")  # fmt: skip
        elif trial is not None and trial["tried"] == TRIALS:
            advice.append(f"Use it on {row['case']} up to h = {trial['up_to']:.3g}, below the linear limit"
                         f" {row['predicted']:.4g}: at {TRIALS} steps up to it no motion grew within {TRIAL_STEPS} steps.")  # fmt: skip
    return advice


COLUMNS = (
    *(Column(f"order_{order}", f"resonance of order {order} at h w", ends=(0.0, UP_TO)) for order in ORDERS),
    Column("limit", "motion fails at, over the predicted step", ends=RATIOS),
)


def marks(data: Mapping[str, Any]) -> list[Mark]:
    """The predicted and the observed resonances, and the ratios of the nonlinear limit."""
    marks = []
    for row in data["resonances"]:
        seen = [each for each in row["seen"] if each is not None]
        low = min((each["from"] for each in seen), default=None)
        high = max((each["to"] for each in seen), default=None)
        text = f"predicted {row['predicted']:.4g}, " + (f"seen {low:.4g} to {high:.4g}" if seen else "not seen")
        marks.append(Mark(f"order_{row['order']}", row["predicted"], low, high, text))
    ratios = ((row["case"], row["ratio"]) for row in data["limits"] if row["ratio"] is not None)
    return marks + [Mark("limit", ratio, text=f"{case}: {ratio:.3g} times the prediction") for case, ratio in ratios]


@panel("resonance", "Step resonances and nonlinear limit", sentences, COLUMNS, marks, reason)
def resonance(integrator: Integrator, seconds: float) -> dict[str, Any]:
    problem = problem_for(integrator)
    assert problem is not None
    step = StepMatrix(integrator, problem)
    cost = len(AMPLITUDES) * cost_of_motion(integrator)
    limit = first_limit(scan(step, 1j, cost / (STEPS_A_SAMPLE * SAMPLES), seconds / 8))
    if problem.alone or several_steps(step, 1j, limit)[0]:
        raise Refused("its step is not a matrix, because it uses earlier steps")
    predictions = predict(step)
    count = next((n for n in POINTS if n * cost * max(len(predictions), 1) < seconds / 2), POINTS[-1])
    limits = []
    if 0 < limit < math.inf:
        limits = [nonlinear_limit(integrator, *each, limit, cost, seconds / 8) for each in CASES]
    if not predictions and not limit:
        raise Refused("vibrations grow at any step, so there is no resonance and no limit to predict")
    return {
        "resonances": [resonance_at(integrator, order, x, count) for order, x in predictions],
        "amplitudes": AMPLITUDES,
        "scan": scan_of_escapes(integrator, limit, cost, seconds / 4) if limit > 0 else None,
        "limits": [row for row in limits if row is not None],
    }


def resonance_at(integrator: Integrator, order: int, x: float, count: int) -> dict[str, Any]:
    """The predicted resonance at frequency times step x, and for each amplitude the nearest interval in which motions grow.

    `count`: the number of step sizes that are tried around x.
    """
    window = window_around(x, count)
    seen: list[dict[str, Any] | None] = []
    for factors in growth(integrator, window):
        intervals = runs(window, factors > GROWN)
        if not intervals:
            seen.append(None)
            continue
        low, high = min(intervals, key=lambda ends: max(ends[0] - x, x - ends[1]))
        factor = float(np.max(factors[(window >= low) & (window <= high)]))
        seen.append({"from": low, "to": high, "factor": factor, "escapes": math.isinf(factor)})
    return {"order": order, "predicted": x, "seen": seen, "spacing": np.diff(window)[[count // 2, 0]]}


def scan_of_escapes(integrator: Integrator, limit: float, cost: float, seconds: float) -> dict[str, Any] | None:
    """All intervals of h w up to the linear limit in which motions of some amplitude escape; None if time is short."""
    to = min(limit, UP_TO)
    count = int(min(seconds / cost, MOST))
    if count < FEWEST:
        return None
    x = np.linspace(to / count, to, count, endpoint=False)
    return {"to": to, "spacing": x[1] - x[0], "escapes": runs(x, np.any(np.isinf(growth(integrator, x)), axis=0))}


def predict(step: StepMatrix) -> list[tuple[int, float]]:
    """(order q, h w) at which a step turns an undamped phase by 2 pi/q, by increasing h w."""
    x = np.arange(0.02, UP_TO, 0.02)
    cosine, size = step.turning(x)
    resonances = []
    for order in ORDERS:
        away = cosine - math.cos(2 * math.pi / order)
        for k in np.flatnonzero(away[1:] * away[:-1] < 0):
            if np.all(np.abs(size[k : k + 2] - 1) < CONSERVES) and np.all(np.abs(cosine[k : k + 2]) < 1):
                resonances.append((order, float(x[k] - away[k] * 0.02 / (away[k + 1] - away[k]))))
    return sorted(resonances, key=lambda each: each[1])


def window_around(x: float, count: int) -> Floats:
    """`count` points (odd) around x, denser towards it: some resonances are narrow."""
    side = np.linspace(-1, 1, count)
    return np.asarray(x * (1 + WINDOW * side * np.abs(side)))


def growth(integrator: Integrator, x: Floats) -> Floats:
    """The growth within 2048 steps of 1, for each amplitude (rows) and frequency of `x`; infinity for an escape.

    The growth is the largest size over the initial one.
    """
    sizes = np.max(np.abs(positions(integrator, x, STEPS_A_SAMPLE)), axis=1)
    sizes[~(sizes < ESCAPED)] = np.inf  # nan too
    return np.asarray(sizes.reshape(len(AMPLITUDES), -1) / np.array(AMPLITUDES)[:, None])


def positions(integrator: Integrator, x: Floats, steps: int) -> Floats:
    """The positions (n, 64) at samples `steps` steps apart, for each amplitude in turn and each frequency of `x`."""
    form, times = cubic_form(integrator), multiples(SAMPLES, float(steps))
    assert form is not None
    zero, ones = np.zeros(len(x)), np.ones(len(x))
    starts = np.concatenate([np.column_stack([size * ones, x**2, zero, zero]) for size in AMPLITUDES])
    return solve_within(integrator, Problem(form, 4, np.zeros(0), times, 1.0), 1.0, starts).states[:, :, 0]


def runs(x: Floats, flags: Flags) -> list[list[float]]:
    """The first and the last point of each run of flagged points."""
    edges = np.diff(np.concatenate([[False], flags, [False]]).astype(int))
    firsts, lasts = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    return [[float(x[first]), float(x[last])] for first, last in zip(firsts, lasts, strict=True)]


def cost_of_motion(integrator: Integrator) -> float:
    """Processor time of one motion of 2048 steps."""
    positions(integrator, np.array([0.5]), 1)  # compiles
    return max(processor_seconds(lambda: growth(integrator, np.array([0.5]))) / len(AMPLITUDES), 1e-6)


def nonlinear_limit(
    integrator: Integrator, name: str, linear: bool, limit: float, cost: float, seconds: float
) -> dict[str, Any] | None:
    """The smallest step, of a scan from a quarter of the predicted limit upwards, at which a case fails within 2048 steps.

    None if the integrator accepts no form of the case. `trial`: see `try_below`; None for a nonlinear case, and if it would
    take too much time.
    """
    case = get(name).rounded()
    if find_accepted_form(case, integrator.accepts) is None:
        return None
    reference = reference_solution(CaseSpec.of(case))
    at = limit / fastest(case, reference.exact)
    low, high = RATIOS
    count = math.log(high / low) / math.log(RATIO_STEP)
    ratio = math.exp(math.log(high / low) / max(8, min(count, seconds / cost)))
    affordable = cost * TRIALS * TRIAL_STEPS / (STEPS_A_SAMPLE * SAMPLES) < AFFORDED * seconds
    whole, start = problem_of(case, integrator.accepts), initial_state(case)[None]
    failing, tried = None, low
    while failing is None and tried <= high:
        h = tried * at
        problem = replace(whole, times=multiples(SAMPLES, STEPS_A_SAMPLE * h))
        states = solve_within(integrator, problem, h, start).states[0]
        away = np.max(np.abs(states - start) / reference.sizes)
        if not away < FAILED:
            failing = tried
        tried *= ratio
    return {
        "case": case.id, "linear": linear, "predicted": at, "ratio": failing, "ratio_step": ratio,
        "fails_at": None if failing is None else failing * at, "scanned_to": high,
        "trial": try_below(integrator, case, at, AFFORDED * seconds) if linear and affordable else None,
    }  # fmt: skip


def try_below(integrator: Integrator, case: Case, limit: float, seconds: float) -> dict[str, Any]:
    """Search steps for growth of a case: `up_to`, the largest one of three digits below a limit, and random ones below
    it.

    `grows_at`: the first of `TRIALS` steps with which it grows. `tried`: the number of steps tried, within `seconds`.
    """
    unit = 10.0 ** (math.floor(math.log10(limit)) - 2)
    up_to = float(f"{(math.ceil(limit / unit) - 1) * unit:.3g}")
    steps = [up_to, *(up_to * (1 - np.random.default_rng(0).random(TRIALS - 1))).tolist()]
    trial: dict[str, Any] = {"up_to": up_to, "tried": 0, "grows_at": None}
    budget = Budget(seconds)
    for h in steps:
        trial["tried"] += 1
        if grows(integrator, case, h):
            return trial | {"grows_at": h}
        if budget.left <= 0:
            break
    return trial


def grows(integrator: Integrator, case: Case, h: float) -> bool:
    """Whether the motion of a case grows from the first to the second half of `TRIAL_STEPS` steps."""
    problem = replace(problem_of(case, integrator.accepts), times=multiples(SAMPLES, TRIAL_STEPS // SAMPLES * h))
    states = solve_within(integrator, problem, h, initial_state(case)[None]).states[0]
    first, second = (float(np.max(np.abs(half))) for half in np.split(states, 2))
    return not second <= GROWS * first  # nan too


def fastest(case: Case, states: Floats) -> float:
    """The largest modulus of an eigenvalue of the Jacobian of a smooth case at the states (n, dim), by differences."""
    form = next(form for form in map(first_order, case.all_forms()) if form is not None)
    equations = rebind(form.equations, NUMPY)
    parameters = tuple(float(value) for value in case.parameter_values())
    sizes = np.maximum(np.max(np.abs(states), axis=0), 1e-300)
    columns = []
    for i, size in enumerate(sizes):
        offset = np.zeros(len(sizes))
        offset[i] = 2.0**-17 * size
        up, down = (
            np.stack(np.broadcast_arrays(*equations(0.0, tuple((states + sign * offset).T), parameters)), axis=-1)
            for sign in (1, -1)
        )
        columns.append((up - down) / (2 * offset[i]))
    return float(np.max(np.abs(np.linalg.eigvals(np.stack(columns, axis=-1)))))

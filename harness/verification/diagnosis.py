"""The likely cause of all failures of an integrator, in one line: from which claims fail on which cases, and from a few
solutions on one case where it fails."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.harness.contract.integrator import solver_of
from gnomon.harness.results.convergence_order import LARGEST_ERROR
from gnomon.harness.verification.trials import Answer, Floats, Trials

NEAR = 0.05
"""A shift in time explains samples if it leaves less of their error than this share."""
FLAT = 3.0
"""Errors that differ by less do not fall."""
SINGLE = (1e-10, 1e-4)
"""Between these lie errors that single precision, or printing six to nine digits, leaves."""
DIGITS = range(4, 13)
HISTORY = "history: "
"""Begins a diagnosis that solutions depend on earlier calls."""
STRUCTURE = {"symplectic", "reversible", "momentum"}
CONTROL = {"tolerance", "tolerance_short", "tolerance_effect", "proportional", "work"}
ACCURACY = {"order", "step_order", "order_short", "error", "proportional", "work_order", "event_order"}

Facts = dict[str, Any]


@dataclass(frozen=True)
class Failures:
    """The claims that failed and passed, as (claim, case) pairs, and the cases by name."""

    failed: frozenset[tuple[str, str]]
    passed: frozenset[tuple[str, str]]
    cases: dict[str, Case]

    @property
    def claims(self) -> set[str]:
        return {claim for claim, _ in self.failed}

    def probed(self) -> str:
        """The case on which the integrator is probed: the one with most failures, a smooth one if there is any."""
        count = {name: sum(case == name for _, case in self.failed) for name in self.cases}
        return max(count, key=lambda name: (count[name] > 0 and self.cases[name].hybrid is None, count[name]))

    def only_with_time(self) -> bool:
        """Whether claims fail only on cases whose equations have the time in them, and those of accuracy pass on others."""
        others = {name for name, case in self.cases.items() if case.autonomous}
        right = any(claim in ACCURACY and case in others for claim, case in self.passed)
        return right and not any(case in others for claim, case in self.failed if claim != "quadrature")


def digest(trials: Trials) -> Facts:
    """The bits of the first solution of a process."""
    return {"bits": _bits(_states(trials, trials.usual()))}


def facts(trials: Trials) -> Facts:
    """What a few solutions on one case show."""
    setting = trials.usual()
    other = trials.reference.exact[8]
    found: Facts = {}
    try:
        solve, given = solver_of(trials.integrator, trials.problem(), trials.settings[0]), other[None].copy()
        solve(given)
        found["changed_start"] = not np.array_equal(given[0], other)
        found["bits"] = _bits(_states(trials, setting))
    except Exception:  # the user's code may raise anything
        return found | {"raises": True}
    answers = [each for each in trials.answers() if each.states is not None and math.isfinite(each.error)]
    found["several"] = trials.case.hybrid is None and _mixed(trials, setting)
    found["bits_again"] = _bits(_states(trials, setting))
    if not answers:
        return found | {"answers": False}
    best = answers[-1]
    found |= {
        "points": [(a.setting, a.error, a.roundoff, a.work or 0) for a in answers],
        "still": _still(best.states, trials.reference.exact),
        "single": bool(np.array_equal(best.states, _rounded(best.states))) and not _rests(trials),
        "digits": _digits(best.states) if not _rests(trials) else None,
        "shift": None if best.error < 100 * best.roundoff else _shift(trials, answers[len(answers) // 2]),
        "bumps": _bumps(trials) if not trials.steps and trials.integrator.sampling == "dense output" else False,
    }
    return found | (_steps(trials) if trials.steps and trials.case.hybrid is None else {})


def _states(trials: Trials, setting: float) -> Floats:
    (states,) = trials.solutions(trials.problem(), setting, [trials.start])
    return states


def _bits(states: Floats) -> str:
    return hashlib.sha256(np.ascontiguousarray(states).tobytes()).hexdigest()


def _mixed(trials: Trials, setting: float) -> bool:
    """Whether a motion that is solved beside others differs from the motion alone by more than its own error."""
    alone = trials.whole(setting)
    starts = np.array([trials.reference.exact[8], trials.start, trials.reference.exact[16]])
    solved = solver_of(trials.integrator, trials.problem(), setting)(starts).states[1]
    if alone.states is None or math.isnan(alone.error):
        return False
    return not float(np.max(trials.distance(solved, alone.states))) <= 4 * alone.error + 100 * alone.roundoff


def _still(states: Any, exact: Floats) -> bool:
    return bool(np.all(states == states[0]) and not np.all(exact == exact[0]))


def _rests(trials: Trials) -> bool:
    """Whether the exact states have few digits themselves, as a motion on a line with simple numbers."""
    exact = trials.reference.exact
    return bool(np.mean(exact == _rounded(exact)) > 0.5)


def _rounded(states: Any) -> Floats:
    return np.asarray(states, dtype=np.float32).astype(np.float64)


def _digits(states: Any) -> int | None:
    """The number of decimal digits of states that have few."""
    values = np.asarray(states).ravel()[:128].tolist()
    return next((n for n in DIGITS if all(float(f"{x:.{n}g}") == x for x in values)), None)


def _shift(trials: Trials, answer: Answer) -> tuple[str, str] | None:
    """(what, by how much): all states, positions or velocities fit the exact motion at other times."""
    times, interval, half = trials.reference.times, float(trials.problem().interval), len(trials.start) // 2
    moves = {"a sample": interval}
    if trials.steps:
        moves = {"h": answer.setting, "h / 2": answer.setting / 2} | moves
    parts = {"states": slice(None)}
    if len(trials.start) % 2 == 0 and trials.case.second_order is not None:
        parts |= {"velocities": slice(half, None), "positions": slice(half)}
    states, exact = np.asarray(answer.states), trials.reference.exact
    for name, move in moves.items():
        for sign in (1, -1):
            moved = times + sign * move
            inside = (moved >= 0) & (moved <= times[-1])
            other = trials.case.sample(moved[inside])
            for what, part in parts.items():
                mixed = exact[inside].copy()
                mixed[:, part] = other[:, part]
                before = np.max(trials.distance(states[inside], exact[inside]))
                if np.max(trials.distance(states[inside], mixed)) < NEAR * before:
                    return what, f"t {'+' if sign > 0 else '-'} {name}"
    return None


def _bumps(trials: Trials) -> bool:
    """Whether errors vanish again at ends of steps: samples of one or few steps, over a short span."""
    for halvings in range(2, 9):
        for tolerance in trials.settings[len(trials.settings) // 2 :]:
            answer = trials.short(halvings, tolerance)
            if answer.states is None or not 100 * answer.roundoff < answer.error < LARGEST_ERROR:
                continue
            errors = trials.distance(answer.states, trials.exact(halvings))
            top = np.maximum.accumulate(errors)
            if np.any(errors[8:] < top[8:] / 30):
                return True
    return False


def _steps(trials: Trials) -> Facts:
    """Errors of single steps: their power of h and size, and the components from which on they are wrong."""
    points, parts = [], []
    for h, answer in trials.single_steps():
        if answer.states is None or not answer.roundoff / 8 < answer.error < LARGEST_ERROR:
            continue
        halvings = round(math.log2(float(trials.problem().interval) / h))
        first = np.abs(np.asarray(answer.states)[0] - trials.exact(halvings)[0])
        points.append((h, answer.error, answer.roundoff))
        parts.append(first)
    found: Facts = {"single_steps": points}
    order = trials.integrator.order
    if order is None or len(points) < 3:
        return found
    coarse, fine = parts[len(parts) // 2 - 1], parts[len(parts) // 2]
    ratio = points[len(parts) // 2 - 1][0] / points[len(parts) // 2][0]
    with np.errstate(all="ignore"):
        powers = np.log(coarse / fine) / math.log(ratio)
    low = np.nonzero((powers < order) & (coarse > 1e-14 * np.max(np.abs(trials.start))))[0]
    count = len(trials.start)
    if trials.case.second_order is not None:
        low, count = np.unique(low % (count // 2)), count // 2
    found["first_wrong"] = int(low[0]) + 1 if len(low) and low[0] >= 2 and count > 2 else None
    return found


def conclude(
    failures: Failures, alone: Facts, found: Facts, order: int | None, stepped: bool, steps: bool
) -> str | None:
    """The cause as `id: sentence`; None where nothing is known."""
    claims = failures.claims
    for cause in (_of_conduct, _of_samples, _of_cases, _of_control, _of_order):
        text = cause(failures, claims, {"alone": alone, "order": order, "stepped": stepped, "steps": steps, **found})
        if text is not None:
            return text
    return None


def _of_conduct(failures: Failures, claims: set[str], found: Facts) -> str | None:
    if found.get("changed_start") or "start_kept" in claims:
        return "input: it changes the start that it is given"
    if found.get("bits") is not None and found["bits"] != found.get("bits_again"):
        return (
            HISTORY
            + "the same call gives another solution the second time: something is kept from call to call, or random"
        )
    kept = {"history", "other_problems", "repeatable"} & claims
    if kept or (found.get("bits") is not None and found["alone"].get("bits") not in (None, found["bits"])):
        return HISTORY + "its solutions depend on earlier calls: something is kept between runs"
    if "aliasing" in claims:
        return "aliasing: states that it returned change with the next call: a buffer is used again"
    if found.get("several"):
        return "ensemble: of several starts in one call it solves one otherwise than alone"
    if claims and claims <= {"bad_start", "bad_setting", "blow_up"}:
        return "finite: it gives finite states where there is no solution: what is not a number is replaced, or not looked at"
    if found.get("raises") or found.get("answers") is False:
        return "no answer: it raises, or has no finite states at any setting"
    return None


def _of_samples(failures: Failures, claims: set[str], found: Facts) -> str | None:
    if found.get("still"):
        return "still: all samples are equal, where the exact motion moves"
    if found.get("single"):
        return "precision: every state is a number of single precision"
    if found.get("digits"):
        return f"precision: every state has {found['digits']} decimal digits: digits that were printed"
    if found.get("shift"):
        what, when = found["shift"]
        return f"shift: its {what} fit the exact motion at {when}"
    floor = _floor(found)
    if floor is not None:
        return (
            f"precision: its error stays near {floor:.0e} however short the steps are, in a short span as in a long one:"
            " single precision, printed digits, or an iteration that stops early"
        )
    return None


def _floor(found: Facts) -> float | None:
    """An error that neither shorter steps nor shorter spans make smaller, in the range of single precision."""
    points = found.get("points", [])
    tail = [error for _, error, roundoff, _ in points[-3:] if error > 20 * roundoff and SINGLE[0] < error < SINGLE[1]]
    if len(tail) < 2 or max(tail) > 30 * min(tail):
        return None
    tiny = found.get("single_steps", [])[-3:]
    if found["steps"] and (len(tiny) < 3 or tiny[0][1] > FLAT * tiny[-1][1]):
        return None
    return float(tail[-1])


def _of_cases(failures: Failures, claims: set[str], found: Facts) -> str | None:
    """What the failing cases have in common, and others lack."""
    hybrid = {name for name, case in failures.cases.items() if case.hybrid is not None}
    if claims & {"events", "event_order"} and all(case in hybrid for _, case in failures.failed):
        return "events: motions without events are right: an event is missed, in the wrong place, or its reset is wrong"
    if claims == {"clock"}:
        return "time: it is wrong only where the start is not at t = 0: the time since the start is taken for the time"
    if failures.only_with_time():
        return "time: it is wrong only where the equations have the time in them: the time of a stage, or of a step"
    if claims == {"more_variables"}:
        return "component: it is wrong only where there are more than six variables"
    if found.get("first_wrong") is not None:
        return f"component: it is wrong from component {found['first_wrong']} on, the ones before are right"
    if claims and claims <= {"permuted", "turned"}:
        return "component: it does not treat all components alike"
    if claims == {"mirror"}:
        return "sign: it treats positive and negative numbers differently"
    if claims and claims <= {"units", "rounded_times"}:
        return "absolute: a number inside it has a unit: a length, a time or a bound that belongs to no problem"
    return None


def _of_control(failures: Failures, claims: set[str], found: Facts) -> str | None:
    if found["steps"]:
        return None
    if "dense" in claims or found.get("bumps"):
        return "dense: samples between steps are worse than the ends of steps: the interpolation is wrong"
    points = found.get("points", [])
    if len(points) > 2 and points[0][3] and points[-1][3] <= 1.05 * points[0][3]:
        return (
            f"tolerance: it takes as many steps at tolerance {points[0][0]:g} as at {points[-1][0]:g}: it has no effect"
        )
    if claims & CONTROL and not claims & {"work_order", "quadrature"}:
        worst = max((error / setting for setting, error, _, _ in points if error < LARGEST_ERROR), default=math.nan)
        return f"control: its error is up to {worst:.1g} times its tolerance: the error estimate, or what is done with it, is wrong"
    return None


def _of_order(failures: Failures, claims: set[str], found: Facts) -> str | None:
    order, line = found["order"], found.get("single_steps") if found["steps"] else None
    if claims and claims <= STRUCTURE:
        return f"structure: its errors are right, but it does not keep what it declares ({', '.join(sorted(claims))})"
    if order is None:
        return None
    if line and len(line) >= 2:
        (h0, e0, _), (h1, e1, _) = line[-2:]
        power = math.log(e0 / e1) / math.log(h0 / h1)
        if power < order + found["stepped"] - 0.5:
            return _lower(power - found["stepped"], order, e1, h1)
    points = [(s, e, w) for s, e, r, w in found.get("points", []) if 20 * r < e < LARGEST_ERROR]
    if len(points) < 2:
        return None
    if found["steps"]:
        power = math.log(points[-2][1] / points[-1][1]) / math.log(points[-2][0] / points[-1][0])
    else:
        (_, e0, w0), (_, e1, w1) = points[0], points[-1]
        power = math.log(e0 / e1) / math.log(w1 / w0) if w1 > w0 > 0 else math.nan
    if power < order - 0.5:
        return _lower(power, order, points[-1][1], points[-1][0])
    return None


def _lower(power: float, order: int, error: float, h: float) -> str:
    what = "it does not converge" if power < 0.3 else f"it converges with order {power:.1f}"
    return f"order: {what} where {order} is declared: a coefficient, a sign or a term of the formula is wrong"

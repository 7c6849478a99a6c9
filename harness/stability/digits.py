"""Digits that a method loses on hard variants beyond the loss of the problem, and the horizon of chaotic motions.

The conditioning of a case is the effect of rounding its numbers. The digits lost by a method are log10 of its smallest
error over the conditioning, at least 0. They are claimed only if the sweep has levelled off: otherwise a setting
tighter than the last one may lose fewer.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Floats, Integrator, Refused
from gnomon.harness.measuring.trials import Answer, Trials
from gnomon.harness.stability.panel import Column, Mark, panel
from gnomon.harness.stability.subjects import Budget, accepts, trials_of

CASES = (
    "kepler_orbit",
    "pendulum_simple",
    "euler_top",
    "spherical_pendulum",
    "spring_pendulum",
    "two_body",
    "lagrange_top_attitude",
    "equilateral_three_body",
    "symmetric_top_torque_free",
)
"""The methods for gravitating bodies, and the methods for rigid bodies, accept three of these cases."""
OTHERS = (
    "charge_in_E_and_B",
    "relativistic_charge",
    "holonomic_constraint_dae",
    "damped_oscillator",
    "block_incline_friction",
)
"""Cases for an integrator that accepts only their forms, and so no case of `CASES`."""
LONG = ("orbits", "long", "speed", "engines", "revolutions", "precessions", "flips", "drifting")
"""Words in the names of variants that are long, or measured for other reasons."""
CHAOTIC = (("double_pendulum", "upright"), ("bouncing_ball_table", "chaotic"))
FEWEST = 2
MANY_SECONDS = 10.0
"""Processor seconds from which all hard variants share the time; with fewer, the first two have at least half each."""
SOLVE_SECONDS = 30.0
"""Processor seconds after which a solve is stopped, as a method whose steps shrink to nothing would take hours."""
TARGET = 1e-6
"""Relative error at which calls of the right-hand side are compared."""
INACCURATE = 0.1
"""An error above this, and above 10 times the conditioning, is a failure."""
FEW = 2.0
"""Largest number of lost digits with which a sentence recommends a method."""
CASES_FEWEST = 5
"""Smallest number of cases for a recommendation: variants of one case are not independent."""
LAST, HALF = 2, 0.5
"""A sweep has levelled off if its LAST settings do not reduce the smallest earlier error to the part HALF. Two settings
reduce a truncation error at least by four: they halve a step twice, or divide a tolerance by a hundred."""


def sentences(data: Mapping[str, Any]) -> list[str]:
    """Advice for the choice of an integrator, from the data of `digits`."""
    rows = data["variants"]
    advice = _of_all(rows)
    advice += _failures({name: row for name, row in rows.items() if row["failed"] and row["complete"]})
    for name, row in rows.items():
        horizon = None if row["failed"] and row["complete"] else row.get("horizon")
        if horizon is not None and horizon < row["horizon_of_problem"]:
            advice.append(f"Not for {name} after {horizon:.2f} of its span: its error is then above {INACCURATE:g};"
                         f" that of rounding the start, after {row['horizon_of_problem']:.2f}.")  # fmt: skip
    return advice


def _of_all(rows: Mapping[str, Any]) -> list[str]:
    """The sentence about the median of the lost digits, which is a bound if sweeps end before they level off."""
    known = bounds(rows)
    cases = len({name.partition("/")[0] for name in known})
    if cases < CASES_FEWEST:
        return []
    least, most = _medians(known)
    if least <= FEW < most:
        return []  # its sweeps end too early to say
    how, median, bound = (
        ("Use it", most, "at most ") if most <= FEW else ("Not where each digit counts", least, "at least ")
    )
    lost = "all digits" if math.isinf(median) else f"{bound if least < most else ''}{median:.1f} digits"
    return [f"{how} on hard motions: it loses {lost} in the median of {len(known)} variants of {cases} cases, beyond those"
            " that the problem loses."]  # fmt: skip


def bounds(rows: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """The least and the most digits lost, by variant, if the sweep was measured to its end; infinite for failures.

    The least is 0 for a sweep that has not levelled off, because a setting tighter than the last one may lose no
    digits.
    """
    lost = {}
    for name, row in rows.items():
        if row["complete"]:
            most = math.inf if row["failed"] else float(row["lost"])
            lost[name] = (most if row.get("levelled") else 0.0, most)
    return lost


def _medians(known: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
    least, most = np.median(list(known.values()), axis=0).tolist()
    return least, most


def find_levelled(rows: Mapping[str, Any]) -> dict[str, float]:
    """The digits lost, by variant, if the sweep has levelled off."""
    return {name: most for name, (_, most) in bounds(rows).items() if rows[name].get("levelled")}


def _failures(rows: Mapping[str, Any]) -> list[str]:
    """One sentence for all variants that a method solves too badly, and one for each other reason of a failure."""
    bad = {name: row["error"] for name, row in rows.items() if "error" in row}
    texts = []
    if bad:
        low, high = min(bad.values()), max(bad.values())
        errors = f"error is {low:.2g}" if len(bad) == 1 else f"errors are {low:.2g} to {high:.2g}"
        texts.append(f"Not for {', '.join(bad)}: its smallest {errors}.")
    for reason in dict.fromkeys(row["failed"] for name, row in rows.items() if name not in bad):
        texts.append(f"Not for {', '.join(name for name, row in rows.items() if row['failed'] == reason)}: {reason}.")
    return texts


COLUMNS = (
    Column("lost", "digits lost by the method"),
    Column("calls", "right-hand sides to an error of 1e-6", True),
    Column("horizon", "horizon over that of the problem", ends=(0.0, 1.2)),
)


def marks(data: Mapping[str, Any]) -> list[Mark]:
    """The digits lost in the median and over all hard variants, the calls, and the horizons of chaotic motions."""
    marks, rows = [], data["variants"]
    known = bounds(rows)
    failed = sum(math.isinf(most) for _, most in known.values())
    if known:
        low, high = _medians(known)
        text = f"{failed} of {len(known)} variants failed, {len(find_levelled(rows))} sweeps level off;"
        text += (
            f" in the median {low:.1f} digits are lost" if low == high else f" in the median {low:.1f} to {high:.1f}"
        )
        marks.append(Mark("lost", low if low == high else None, low, high, text))
    for name, row in rows.items():
        if row["calls"]:
            marks.append(Mark("calls", row["calls"], text=f"{name}: {row['calls']:.3g}"))
        if row.get("horizon") is not None and tuple(name.split("/")) in CHAOTIC:
            share = row["horizon"] / row["horizon_of_problem"]
            marks.append(Mark("horizon", share, text=f"{name}: {row['horizon']:.2f} of the span, the problem's"
                              f" {row['horizon_of_problem']:.2f}"))  # fmt: skip
    return marks


@panel("digits", "Digits lost on hard motions", sentences, COLUMNS, marks)
def digits(integrator: Integrator, seconds: float) -> dict[str, Any]:
    """For each hard variant the digits lost, the calls at an error of 1e-6, and the measured part of the sweep.

    Raises Refused for an integrator that does not accept any of the cases.
    """
    budget, known = Budget(seconds), hard_variants(integrator)
    if not known:
        raise Refused(f"it accepts none of {', '.join(CASES + OTHERS)}")
    rows: dict[str, Any] = {}
    for place, (name, variant) in enumerate(known):
        left = max(1, (len(known) if seconds >= MANY_SECONDS else FEWEST) - place)
        if budget.left <= 0 and place >= FEWEST:
            break
        before = budget.left
        trials = trials_of(integrator, name, variant)
        budget.extend(before - budget.left)  # the reference solution is kept: its time is not the method's
        share = max(budget.left, 0.1 * seconds) / left
        if trials.settings:  # empty if fixed steps over a long span take too much time
            rows[f"{name}/{variant}"] = count_lost(trials, share) | {"stresses": _stresses(name, variant)}
    return {"variants": rows, "of": len(known), "target": TARGET}


def hard_variants(integrator: Integrator) -> list[tuple[str, str]]:
    """(case, variant) of the hard variants in `CASES` and `CHAOTIC` that the integrator accepts, else in `OTHERS`."""
    hard = [pair for pair in _variants(CASES, CHAOTIC) if accepts(integrator, *pair)]
    return hard or [pair for pair in _variants(OTHERS) if accepts(integrator, *pair)]


def every_variant() -> list[tuple[str, str]]:
    """(case, variant) of all variants that the panel may use. Their reference solutions come with the package."""
    return [*_variants(CASES, CHAOTIC), *_variants(OTHERS)]


def _variants(cases: Sequence[str], between: Sequence[tuple[str, str]] = ()) -> list[tuple[str, str]]:
    """A hard variant of each case, those `between`, then the second variant of each case, and so on."""
    chosen = []
    for name in cases:
        variants = [variant.name for variant in get(name).variants]
        chosen.append([(name, each) for each in variants if not any(word in each for word in LONG)])
    first, *others = itertools.zip_longest(*chosen)
    return [pair for pair in itertools.chain(first, between, *others) if pair is not None]


def _stresses(name: str, variant: str) -> str:
    return next(each.stresses for each in get(name).variants if each.name == variant)


def count_lost(trials: Trials, seconds: float) -> dict[str, Any]:
    """The digits lost at the setting with the smallest error; cheap settings are solved first, while time is left.

    The row has the numbers of `settings` solved and `of` all. `lost` is an upper bound if the sweep is not `complete`
    or not `levelled`, and None if no setting is accurate; `failed` then says why.
    """
    conditioning, settings = trials.conditioning(), trials.settings
    answers: list[Answer] = []
    budget, trials.longest = Budget(seconds), SOLVE_SECONDS
    for setting in settings:
        if budget.left <= 0 and answers:
            break
        left = budget.left
        answers.append(trials.whole(setting))
        if len(answers) == 1 and answers[0].states is not None:
            budget.extend(left - budget.left)  # the first call compiles: its time does not count
    finite = [answer for answer in answers if not math.isnan(answer.error)]
    row: dict[str, Any] = {
        "settings": len(answers),
        "of": len(settings),
        "complete": len(answers) == len(settings),
        "conditioning": conditioning,
    }
    row |= {"lost": None, "failed": None, "calls": calls_at([(each.calls, each.error) for each in finite], TARGET)}
    if not finite:
        reasons = [answer.reason for answer in answers if answer.reason]
        return row | {"failed": reasons[-1] if reasons else "no setting has finite states", "levelled": True}
    best = min(finite, key=lambda answer: answer.error)
    error = best.error
    row |= {"levelled": error <= conditioning or levels_off([answer.error for answer in finite]), "error": error}
    row |= {"horizon": horizon(best.errors), "horizon_of_problem": horizon(trials.reference.conditioning)}
    if error > max(INACCURATE, 10 * conditioning):
        return row | {"failed": f"its smallest error is {error:.2g}"}
    return row | {"lost": math.log10(max(1.0, error / conditioning))}


def levels_off(errors: Sequence[float]) -> bool:
    """Whether the last settings of a sweep, from cheap to expensive, hardly reduce the smallest error."""
    return len(errors) > LAST and min(errors[-LAST:]) > HALF * min(errors[:-LAST])


def calls_at(points: list[tuple[int | None, float]], target: float) -> float | None:
    """Calls at an error, to three digits by a power law between neighbouring settings.

    None if the error is not reached or the calls are not counted.
    """
    for (before, coarse), (after, fine) in itertools.pairwise([(None, math.inf), *points]):
        if fine <= target and after:
            if not before or not coarse > target or math.isinf(coarse) or fine == 0:
                return float(after)
            part = math.log(coarse / target) / math.log(coarse / fine)
            return float(f"{before * (after / before) ** part:.3g}")
    return None


def horizon(errors: Floats) -> float:
    """The share of the span before the error first exceeds 0.1; 1 if it never does."""
    above = np.flatnonzero(~(errors <= INACCURATE))
    return 1.0 if not len(above) else float(above[0] / len(errors))

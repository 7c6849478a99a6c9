"""Relations between two solutions, which need no exact motion: other units, axes, frames, bodies, clock, reversal.

The transformed motion is solved, its solution transformed back, and the result compared with the plain solution.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from gnomon.cases.core.scene import SceneForm
from gnomon.cases.core.symmetry import Relation, in_units, mirrored, permuted
from gnomon.cases.core.turning import Turning
from gnomon.harness.contract.integrator import Floats, Integrator, Refused, Steps
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.trials import Answer, Trials
from gnomon.harness.stability.panel import Column, Mark, panel
from gnomon.harness.stability.subjects import Budget, smooth_reason, subjects
from gnomon.harness.studies.related_motions import Related, holds, later, measure_return, relate

SUBJECTS = ("two_body", "kepler_orbit", "pendulum_simple")
TOLERANCE, STEPS_IN_INTERVAL = 1e-8, 64
BINARY = 2.0**10
UNITS = {
    "length_binary": (BINARY, 1.0), "time_binary": (1.0, BINARY),
    "megametres": (1e-6, 1.0), "milliseconds": (1.0, 1e3),
}  # fmt: skip
"""Number of the new units in a metre and in a second."""
SHIFT, BOOST = 2.0**20, 64.0
"""Shift in lengths and boost in velocities of the case: powers of two, so that the start stays exact."""
WORSE = 2.0
"""Factor of the error above which a sentence names a relation."""
TWO_BODY = Turning((("x1", "y1"), ("x2", "y2"), ("vx1", "vy1"), ("vx2", "vy2")))
_PLANE = [("x1", "y1"), ("x2", "y2"), ("vx1", "vy1"), ("vx2", "vy2")]
QUARTER = Relation(dict.fromkeys([x for x, _ in _PLANE], -1.0), {a: b for x, y in _PLANE for a, b in ((x, y), (y, x))})
"""A rotation by 90 degrees: x becomes -y, y becomes x."""
AXES = {
    "mirrored_axis": Relation(dict.fromkeys([y for _, y in _PLANE], -1.0)),
    "quarter_turn": QUARTER,
    "swapped_axes": Relation(sources=dict(QUARTER.sources)),
}
"""Relations of two bodies."""


TEXTS = {
    "length_binary": "lengths in units of 1/1024 m",
    "time_binary": "times in units of 1/1024 s",
    "megametres": "lengths in megametres",
    "milliseconds": "times in milliseconds",
    "mirrored": "mirrored axes",
    "mirrored_axis": "one mirrored axis",
    "quarter_turn": "axes turned by a quarter",
    "swapped_axes": "exchanged axes",
    "permuted": "exchanged bodies or axes",
    "turned": "axes turned by 1 rad",
    "shifted": "an origin 2^20 lengths away",
    "boosted": "a frame that moves at 64 units of velocity",
    "clock": "a clock that starts later",
}


def sentences(data: Mapping[str, Any]) -> list[str]:
    """Advice for the choice of an integrator, from the data of `relations`."""
    rows, advice = data["relations"], []
    for result, words in (("same bits", "bit for bit"), ("round-off", "to round-off")):
        equal = [TEXTS[name] for name, row in rows.items() if row["found"] == result]
        if equal:
            advice.append(f"Use it where results must not depend on {', '.join(equal)}: equal {words}.")
    for name, row in rows.items():
        if row["found"] == Status.REFUSED:
            advice.append(f"Not for {TEXTS[name]}: {row['why']}.")
        elif row["found"] == "factor" and (row["factor"] is None or row["factor"] > WORSE):
            times = "not finite" if row["factor"] is None else f"{row['factor']:.3g} times as large"
            cause = f" (rounding of these numbers causes {row['rounding']:.1g})" if row.get("rounding") else ""
            advice.append(f"Not for {TEXTS[name]}: the error is {times}{cause}.")
    back = data.get("returned") or {}
    if back.get("apart") is not None:
        how = "Use it" if back["round_off"] else "Not"
        advice.append(f"{how} for motions that must reverse: it returns to the start within {back['apart']:.2g}.")
    return advice


MANY_TIMES = 1e6
"""Factor of the error with the darkest shade."""


def marks(data: Mapping[str, Any]) -> list[Mark]:
    """A cell for each relation: same bits, round-off, or the factor of the error."""
    marks = []
    for name, row in data["relations"].items():
        if row["found"] == "factor" and row["factor"] is not None:
            shade = min(max(math.log(max(row["factor"], 1.0)) / math.log(MANY_TIMES), 0.0), 1.0)
            marks.append(Mark(name, shade, text=f"{row['factor']:.2g}"))
        elif row["found"] == "factor":
            marks.append(Mark(name, 1.0, text="lost"))
        else:
            marks.append(Mark(name, 0.0 if row["found"] in ("same bits", "round-off") else None, text=row["found"]))
    return marks


@panel(
    "relations",
    "Units, axes, frames, reversal",
    sentences,
    [Column(name, text) for name, text in TEXTS.items()],
    marks,
    smooth_reason,
    cells=True,
)
def relations(integrator: Integrator, seconds: float) -> dict[str, Any]:
    """The result for each relation: same bits, round-off, or the error over the error of the plain solution."""
    trials = next(subjects(integrator, SUBJECTS))
    setting = choose_setting(trials)
    plain = trials.whole(setting)
    if plain.states is None or not math.isfinite(plain.error):
        raise Refused(f"no plain solution of {trials.case.name} at {trials.named(setting)}: {plain.why}")
    budget = Budget(seconds)
    rows: dict[str, Any] = {}
    for name, other in list_related(trials, setting).items():
        rows[name] = compare_solutions(trials, plain, other) if budget.left > -seconds else {"found": "out of time"}
    data = {"case": trials.case.name, "setting": setting, "error": plain.error, "round_off": plain.roundoff}
    return data | {"relations": rows, "returned": reversal(trials, setting)}


def choose_setting(trials: Trials) -> float:
    """The setting at which motions are compared: a 64th of the sampling interval, or tolerance 1e-8 within the sweep."""
    sweep = trials.integrator.sweep
    if isinstance(sweep, Steps):
        return float(trials.problem().interval / STEPS_IN_INTERVAL)
    return max(sweep.tightest, min(sweep.loosest, TOLERANCE))


def compare_solutions(trials: Trials, plain: Answer, other: Related) -> dict[str, Any]:
    """Compare a related solution with the plain one: the largest difference, the error, its factor, and the verdict."""
    assert plain.states is not None
    outcome = trials.outcome(other.problem, other.setting, other.start)
    if outcome.solution is None:
        return {"found": Status.REFUSED, "why": outcome.reason}
    back = other.undone(outcome.states[0])
    if np.array_equal(back, plain.states):
        return {"found": "same bits", "difference": 0.0, "factor": 1.0}
    difference = float(np.max(trials.distance(back, plain.states)))
    error = float(np.max(trials.distance(back, trials.reference.exact)))
    factor = error / plain.error if math.isfinite(error) and plain.error > 0 else None
    row: dict[str, Any] = {"difference": difference, "error": error, "factor": factor}
    if other.larger > 1:
        row["rounding"] = trials.conditioning() * other.larger
    row["found"] = "round-off" if difference <= plain.roundoff else "factor"
    return row


def reversal(trials: Trials, setting: float) -> dict[str, Any] | None:
    """The distance from the start after the motion goes forward and comes back, and the distance that rounding allows."""
    if trials.case.hybrid is not None or isinstance(trials.form, SceneForm):
        return None
    apart = measure_return(trials, trials.counting, setting)
    if apart is None:
        return None
    allowed = 2 * trials.whole(setting).roundoff  # the way back undoes the growth of earlier roundings
    return {"apart": apart, "round_off": apart <= allowed, "allowed": allowed}


def list_related(trials: Trials, setting: float) -> dict[str, Related]:
    """The related problems that the case and the integrator have, by name."""
    case, shifted = trials.case, later(trials.counting)
    if case.hybrid is not None:
        return {}
    clock = {} if shifted is None else {"clock": Related(shifted, trials.start, setting)}
    if isinstance(trials.form, SceneForm):
        return clock
    scaled = {name: in_units(case, *units) for name, units in UNITS.items()}
    maps: dict[str, Relation | None] = {
        name: relation
        for name, relation in scaled.items()
        if relation is not None and {*relation.factors.values()} != {1.0} and holds(trials, relation)
    }
    maps |= {"mirrored": mirrored(case)} | (AXES if case.name == "two_body" else {}) | {"permuted": permuted(case)}
    related = {name: relate(trials, trials.counting, setting, r) for name, r in maps.items() if r is not None}
    turning = TWO_BODY if case.name == "two_body" else case.turning
    if turning is not None:
        rotation = turning.rotation(1)
        if len(rotation) == 2:
            rotation = np.array([[math.cos(1.0), -math.sin(1.0)], [math.sin(1.0), math.cos(1.0)]])
        start = turning.turned(case, trials.start, rotation)
        related["turned"] = Related(
            trials.counting, start, setting, lambda states: turning.turned(case, states, rotation.T)
        )
    if case.name == "two_body":
        related["shifted"] = _moving(trials, setting, np.array([SHIFT] * 4 + [0.0] * 4), np.zeros(8))
        rate = np.array([BOOST] * 4 + [0.0] * 4)
        related["boosted"] = _moving(trials, setting, np.roll(rate, 4), rate)
    return related | clock


def _moving(trials: Trials, setting: float, offset: Floats, rate: Floats) -> Related:
    """Two bodies with `offset` + `rate` t added to their states."""
    problem, start = trials.counting, trials.start + offset
    added = offset + problem.times[:, None] * rate
    larger = float(np.max(np.abs(start)) / np.max(np.abs(trials.start)))
    return Related(problem, start, setting, lambda states: states - added, larger)

"""Relations between two solutions, which need no exact motion: other units, axes, frames, bodies, clock, reversal.

The transformed motion is solved, its solution transformed back, and the result compared with the plain solution.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from gnomon.cases.core.forms import Hybrid
from gnomon.cases.core.scene import SceneForm
from gnomon.cases.core.symmetry import Relation, in_units, mirrored, permuted
from gnomon.cases.core.turning import Turning
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Steps
from gnomon.harness.contract.status import Status
from gnomon.harness.stability.panel import Column, Mark, panel
from gnomon.harness.stability.subjects import Budget, require_motion, subjects
from gnomon.harness.verification.relation_claims import holds, later, related
from gnomon.harness.verification.trials import Answer, Trials

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
SWAPPED_AXES = Relation(sources=dict(QUARTER.sources))
MIRRORED_AXIS = Relation(dict.fromkeys([y for _, y in _PLANE], -1.0))


@dataclass(frozen=True)
class Related:
    """A transformed problem with its start and setting, and the function that transforms states back."""

    problem: Problem
    start: Floats
    setting: float
    undone: Callable[[Floats], Floats] = field(default=lambda states: states)
    larger: float = 1.0
    """Factor by which the numbers become larger whose rounding changes the motion."""


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
    rows, found = data["relations"], []
    for result, words in (("same bits", "bit for bit"), ("round-off", "to round-off")):
        kept = [TEXTS[name] for name, row in rows.items() if row["found"] == result]
        if kept:
            found.append(f"Use it where results must not depend on {', '.join(kept)}: equal {words}.")
    for name, row in rows.items():
        if row["found"] == Status.REFUSED:
            found.append(f"Not for {TEXTS[name]}: {row['why']}.")
        elif row["found"] == "factor" and (row["factor"] is None or row["factor"] > WORSE):
            times = "not finite" if row["factor"] is None else f"{row['factor']:.3g} times as large"
            cause = f" (rounding of these numbers causes {row['rounding']:.1g})" if row.get("rounding") else ""
            found.append(f"Not for {TEXTS[name]}: the error is {times}{cause}.")
    back = data.get("returned") or {}
    if back.get("apart") is not None:
        how = "Use it" if back["round_off"] else "Not"
        found.append(f"{how} for motions that must reverse: it returns to the start within {back['apart']:.2g}.")
    return found


def _applies(integrator: Integrator) -> str | None:
    hybrid = all(issubclass(kind, Hybrid) for kind in integrator.accepts)
    return "it takes equations with events only, whose times depend on units" if hybrid else None


MANY_TIMES = 1e6
"""Factor of the error with the darkest shade."""


def marks(data: Mapping[str, Any]) -> list[Mark]:
    """A cell for each relation: same bits, round-off, or the factor of the error."""
    found = []
    for name, row in data["relations"].items():
        if row["found"] == "factor" and row["factor"] is not None:
            shade = min(max(math.log(max(row["factor"], 1.0)) / math.log(MANY_TIMES), 0.0), 1.0)
            found.append(Mark(name, shade, text=f"{row['factor']:.2g}"))
        elif row["found"] == "factor":
            found.append(Mark(name, 1.0, text="lost"))
        else:
            found.append(Mark(name, 0.0 if row["found"] in ("same bits", "round-off") else None, text=row["found"]))
    return found


@panel(
    "relations",
    "Units, axes, frames, reversal",
    sentences,
    [Column(name, text) for name, text in TEXTS.items()],
    marks,
    _applies,
    cells=True,
)
def relations(integrator: Integrator, seconds: float) -> dict[str, Any]:
    """The result for each relation: same bits, round-off, or the error over the error of the plain solution."""
    (trials,) = subjects(integrator, SUBJECTS)
    setting = usual(trials)
    plain = trials.whole(setting)
    if plain.states is None or not math.isfinite(plain.error):
        raise Refused(f"no plain solution of {trials.case.name} at {trials.named(setting)}: {plain.why}")
    require_motion(trials, plain.states)
    budget = Budget(seconds)
    rows: dict[str, Any] = {}
    for name, build in related_problems().items():
        other = build(trials, setting)
        if other is not None:
            rows[name] = compared(trials, plain, other) if budget.left > -seconds else {"found": "out of time"}
    found = {"case": trials.case.name, "setting": setting, "error": plain.error, "round_off": plain.roundoff}
    return found | {"relations": rows, "returned": returned(trials, setting)}


def usual(trials: Trials) -> float:
    """Tolerance 1e-8, or the nearest one within the sweep; for step sizes a 64th of the sampling interval."""
    sweep = trials.integrator.sweep
    if isinstance(sweep, Steps):
        return float(trials.problem().interval / STEPS_IN_INTERVAL)
    return max(sweep.tightest, min(sweep.loosest, TOLERANCE))


def compared(trials: Trials, plain: Answer, related: Related) -> dict[str, Any]:
    """The related solution beside the plain one: largest difference, error, factor of the error, and verdict."""
    assert plain.states is not None
    try:
        (states,) = trials.solutions(related.problem, related.setting, [related.start])
    except Refused as refusal:
        return {"found": Status.REFUSED, "why": str(refusal) or "declined without a reason"}
    back = related.undone(states)
    if np.array_equal(back, plain.states):
        return {"found": "same bits", "difference": 0.0, "factor": 1.0}
    difference = float(np.max(trials.distance(back, plain.states)))
    error = float(np.max(trials.distance(back, trials.reference.exact)))
    factor = error / plain.error if math.isfinite(error) and plain.error > 0 else None
    row: dict[str, Any] = {"difference": difference, "error": error, "factor": factor}
    if related.larger > 1:
        row["rounding"] = trials.conditioning() * related.larger
    row["found"] = "round-off" if difference <= plain.roundoff else "factor"
    return row


def returned(trials: Trials, setting: float) -> dict[str, Any] | None:
    """The distance from the start after a motion goes forward, is reversed, and comes back; None without a reversal."""
    problem, case = _problem(trials), trials.case
    if case.hybrid is not None or isinstance(trials.form, SceneForm):
        return None
    there = trials.solutions(problem, setting, [trials.start])[0][-1]
    turned, home = case.reversed(tuple(there.tolist())), case.reversed(tuple(trials.start.tolist()))
    if turned is None or home is None or not np.all(np.isfinite(there)):
        return None
    state, parameters = turned
    numbers = np.array([float(parameters[parameter.name]) for parameter in case.parameter_list])
    back = trials.solutions(replace(problem, parameters=numbers), setting, [np.array(state, dtype=np.float64)])[0][-1]
    apart = float(trials.distance(back[None], np.array([home[0]], dtype=np.float64))[0])
    allowed = 2 * trials.whole(setting).roundoff  # the way back undoes the growth of earlier roundings
    return {"apart": apart, "round_off": apart <= allowed, "allowed": allowed}


def related_problems() -> dict[str, Callable[[Trials, float], Related | None]]:
    """Functions by name that give the related problem, or None for a case or integrator without the relation."""
    found: dict[str, Callable[[Trials, float], Related | None]] = {}
    for name, (length, time) in UNITS.items():
        found[name] = lambda trials, setting, units=(length, time): _in_units(trials, setting, *units)  # type: ignore[misc]
    found["mirrored"] = lambda trials, setting: _related(trials, setting, mirrored(trials.case))
    for name, relation in (
        ("mirrored_axis", MIRRORED_AXIS),
        ("quarter_turn", QUARTER),
        ("swapped_axes", SWAPPED_AXES),
    ):
        found[name] = lambda trials, setting, own=relation: (  # type: ignore[misc]
            _related(trials, setting, own) if trials.case.name == "two_body" else None
        )
    found["permuted"] = lambda trials, setting: _related(trials, setting, permuted(trials.case))
    return found | {"turned": _turned, "shifted": _shifted, "boosted": _boosted, "clock": _clock}


def _problem(trials: Trials) -> Problem:
    return trials.problem(counted=trials.integrator.counts_rhs)


def _related(trials: Trials, setting: float, relation: Relation | None) -> Related | None:
    if relation is None or isinstance(trials.form, SceneForm) or trials.case.hybrid is not None:
        return None
    coordinates = [coordinate.name for coordinate in trials.case.state]
    problem, setting, start = related(trials, _problem(trials), setting, relation)
    return Related(problem, start, setting, lambda states: relation.undone(coordinates, states))


def _in_units(trials: Trials, setting: float, length: float, time: float) -> Related | None:
    """The problem in other units; None for a case whose equations hold in one system of units only."""
    relation = in_units(trials.case, length, time)
    if relation is None or set(relation.factors.values()) == {1.0} or not holds(trials, relation):
        return None
    return _related(trials, setting, relation)


def _turned(trials: Trials, setting: float) -> Related | None:
    turning = TWO_BODY if trials.case.name == "two_body" else trials.case.turning
    if turning is None or trials.case.hybrid is not None or isinstance(trials.form, SceneForm):
        return None
    rotation = turning.rotation(1)
    if len(rotation) == 2:
        rotation = np.array([[math.cos(1.0), -math.sin(1.0)], [math.sin(1.0), math.cos(1.0)]])
    start = turning.turned(trials.case, trials.start, rotation)
    return Related(_problem(trials), start, setting, lambda states: turning.turned(trials.case, states, rotation.T))


def _shifted(trials: Trials, setting: float) -> Related | None:
    return _moving(trials, setting, np.array([SHIFT] * 4 + [0.0] * 4), np.zeros(8))


def _boosted(trials: Trials, setting: float) -> Related | None:
    return _moving(trials, setting, np.array([0.0] * 4 + [BOOST] * 4), np.array([BOOST] * 4 + [0.0] * 4))


def _moving(trials: Trials, setting: float, offset: Floats, rate: Floats) -> Related | None:
    """Two bodies with `offset` + `rate` t added to their states."""
    if trials.case.name != "two_body" or isinstance(trials.form, SceneForm):
        return None
    problem = _problem(trials)
    added = offset + problem.times[:, None] * rate
    larger = float(np.max(np.abs(trials.start + offset)) / np.max(np.abs(trials.start)))
    return Related(problem, trials.start + offset, setting, lambda states: states - added, larger)


def _clock(trials: Trials, setting: float) -> Related | None:
    shifted = None if trials.case.hybrid is not None else later(_problem(trials))
    return None if shifted is None else Related(shifted, trials.start, setting)

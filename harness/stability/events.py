"""Events found, missed, late and invented: at grazing passages, in a Zeno sequence, two within one step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import acos, cos, sin, sqrt
from typing import Any

import numpy as np
from gnomon.cases.core.forms import Equations, Hybrid, Mode, Transition, Values
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Steps
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.events import score_events
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.stability.panel import Column, Mark, panel
from gnomon.harness.stability.subjects import Budget, processor_seconds, trials_of
from scipy.special import betaincinv

TOLERANCES, STEP_SIZES = (1e-4, 1e-8, 1e-12), (1 / 4, 1 / 32, 1 / 256)
DEPTHS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""Height of the motion above the ceiling, in amplitudes."""
GAPS = (1e-6, 1e-9, 1e-12)
"""Height of the ceiling above the motion, in amplitudes."""
LAYERS = (1e-1, 1e-3, 1e-6)
"""Distance of two guards that are passed one after the other, in amplitudes."""
FIRST, LAST, SPAN = 1.8, 5.6, 8.0
"""First and last phase of the starts, and the span: motions start below all guards and meet each guard once."""
FEWEST, MOST = 6, 24
PHASES = [FIRST + (LAST - FIRST) * (7 * k % MOST + 0.5) / MOST for k in range(MOST)]
"""Phases of the starts, in a sequence of which each beginning is evenly spread."""
SLOW = 3.0
"""Largest time for the fewest phases at all sizes, in multiples of the processor time given: beyond it, every second
size is left out."""
NEAR = 0.1
"""Largest error of the time at which an event counts as found: a tenth of the oscillator's time scale."""
ZENO = "bouncing_ball"


@dataclass(frozen=True)
class Passage:
    """A motion of unit size past guards: its equations, its starts and the exact times of its events by phase (s).

    `levels(size)`: the heights of the guards, passed upward one after the other. `times(phase, size)`: the times of
    passage.
    """

    name: str
    equations: Equations
    start: Callable[[float], Values]
    levels: Callable[[float], Values]
    times: Callable[[float, float], Values]
    sizes: Sequence[float]


def oscillator(t: Any, state: Values, parameters: Values) -> Values:
    """q'' = -q, as equations of first order."""
    return state[1], -state[0]


def falling(t: Any, state: Values, parameters: Values) -> Values:
    """A free fall with the acceleration -1."""
    return state[1], -1


def lower_guard(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - parameters[0],)


def upper_guard(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - parameters[1],)


def keep_state(t: Any, state: Values, parameters: Values) -> Values:
    return state


def _turning(phase: float) -> Values:
    """The start of x = cos(t - phase), whose top is at t = phase."""
    return cos(phase), sin(phase)


PASSAGES = (
    Passage("grazing_oscillator", oscillator, _turning, lambda d: (1 - d,), lambda p, d: (p - acos(1 - d),), DEPTHS),
    Passage("grazing_fall", falling, lambda p: (-p * p / 2, p), lambda d: (-d,), lambda p, d: (p - sqrt(2 * d),), DEPTHS),
    Passage("invented", oscillator, _turning, lambda gap: (1 + gap,), lambda p, gap: (), GAPS),
    Passage(
        "two_in_one_step", oscillator, _turning, lambda w: (0.0, w), lambda p, w: (p - acos(0.0), p - acos(w)), LAYERS
    ),
)  # fmt: skip


def problem_of(passage: Passage, size: float) -> Problem:
    """The passage as a hybrid problem, whose last mode has no guard.

    It has one sample, so that no step ends near an event because of a sample.
    """
    levels = passage.levels(size)
    modes = ("below", "beyond") if len(levels) == 1 else ("below", "between", "beyond")
    guards = (lower_guard, upper_guard)
    transitions = tuple(
        Transition(f"guard {k + 1}", modes[k], guards[k], 1, keep_state, modes[k + 1]) for k in range(len(levels))
    )
    form = Hybrid(
        modes=tuple(Mode(name, passage.equations) for name in modes),
        start=lambda t, state, parameters: "below",
        transitions=transitions,
        settle=1e-9,
        terminal=frozenset({"beyond"}),
    )
    return Problem(form, 2, np.array((*levels, 0.0)[:2]), np.array([SPAN]), 1.0)


def _applies(integrator: Integrator) -> str | None:
    return None if Hybrid in integrator.accepts else "it takes no equations with events"


def sentences(data: Mapping[str, Any]) -> list[str]:
    """Advice for the choice of an integrator, from the data of `events`."""
    advice = []
    for name, what in (
        ("grazing_oscillator", "grazing events of an oscillator"),
        ("grazing_fall", "grazing events of free fall"),
        ("two_in_one_step", "two events close together"),
    ):
        usable, lost = [], []
        for setting, rows in _by_setting(data[name]):
            missed = [row for row in rows if row["found"] < row["starts"]]
            if missed:
                worst = max(missed, key=lambda row: (row["size"], -row["found"]))
                lost.append(f"{worst['size']:g} at setting {setting:g} ({worst['found']} of {worst['starts']} found)")
            else:
                least = min(row["size"] for row in rows)
                usable.append(f"{least:g} at setting {setting:g} ({rows[-1]['found']} of {rows[-1]['starts']} found)")
        if usable:
            advice.append(f"Use it for {what} down to a size of {', '.join(usable)}.")
        if lost:
            advice.append(f"Not for {what} from a size of {', '.join(lost)} down.")
    invented = []
    for setting, rows in _by_setting(data["invented"]):
        worst = max(rows, key=lambda row: row["extra"])
        if worst["extra"]:
            invented.append(f"at setting {setting:g} {worst['extra']} events are invented in {worst['starts']} motions"
                            f" {worst['size']:g} below the guard")  # fmt: skip
    if invented:
        advice.append(f"Not for guards that are nearly reached: {', '.join(invented)}.")
    accumulated = [
        f"at setting {row['setting']:g} {row['missing']} of {row['events']} are missed, {row['extra']} invented"
        for row in data["zeno"]
        if row.get("missing") or row.get("extra")
    ]
    if accumulated:
        advice.append(f"Not for events that accumulate: {', '.join(accumulated)}.")
    return advice


def _by_setting(rows: Sequence[Mapping[str, Any]]) -> list[tuple[float, list[Mapping[str, Any]]]]:
    usable = [row for row in rows if Status.REFUSED not in row]
    settings = dict.fromkeys(row["setting"] for row in usable)
    return [(setting, [row for row in usable if row["setting"] == setting]) for setting in settings]


KINDS = {
    "grazing_oscillator": "grazing, oscillator",
    "grazing_fall": "grazing, free fall",
    "two_in_one_step": "two in one step",
    "invented": "none, guard not reached",
}
PLACES = ("loose", "middle", "tight")


def marks(data: Mapping[str, Any]) -> list[Mark]:
    """A cell for each kind and setting: the share of starts with all events found, or without invented events."""
    marks = []
    for name in KINDS:
        for place, (setting, rows) in zip(PLACES, _by_setting(data[name]), strict=False):
            starts = sum(row["starts"] for row in rows)
            good = sum(
                row["found"] if name != "invented" else row["starts"] - min(row["extra"], row["starts"]) for row in rows
            )
            marks.append(Mark(f"{name}_{place}", 1 - good / starts, text=f"{good}/{starts} at {setting:g}"))
    return marks


@panel(
    "events",
    "Events",
    sentences,
    [Column(f"{name}_{place}", f"{title}: {place}") for name, title in KINDS.items() for place in PLACES],
    marks,
    _applies,
    cells=True,
)
def events(integrator: Integrator, seconds: float) -> dict[str, Any]:
    """A row for each setting and size of each kind of passage, and a row for each setting of the bouncing ball.

    Raises Refused for an integrator that reports no events.
    """
    settings = settings_of(integrator)
    count = sum(len(passage.sizes) for passage in PASSAGES) * len(settings)
    measure_passage(integrator, PASSAGES[0], DEPTHS[0], settings[-1], 0.0)  # compiles
    each = processor_seconds(partial(measure_passage, integrator, PASSAGES[0], DEPTHS[0], settings[-1], 0.0))
    skipped = 2 if each * count > SLOW * seconds else 1
    data: dict[str, Any] = {}
    for passage in PASSAGES:
        rows = [(setting, size) for setting in settings for size in passage.sizes[::skipped]]
        data[passage.name] = [
            measure_passage(integrator, passage, size, setting, seconds / count) for setting, size in rows
        ]
    return data | {"zeno": [_zeno(integrator, setting) for setting in settings]}


def settings_of(integrator: Integrator) -> list[float]:
    """The settings of the panel within the integrator's sweep; its loosest and tightest tolerance if there are none."""
    sweep = integrator.sweep
    if isinstance(sweep, Steps):
        return [h for h in STEP_SIZES if h <= sweep.coarsest]
    tolerances = [t for t in TOLERANCES if sweep.tightest <= t <= sweep.loosest]
    return tolerances or [sweep.loosest, sweep.tightest]


def measure_passage(
    integrator: Integrator, passage: Passage, size: float, setting: float, seconds: float
) -> dict[str, Any]:
    """The row of a passage at one size and setting.

    `found`: the number of starts whose events were all located in sequence, with a 95 % interval of the share (Clopper
    and Pearson). `missed`, `extra`: numbers of events. `time_error`: the largest error of the times from these starts.
    """
    row: dict[str, Any] = {"setting": setting, "size": size}
    problem = problem_of(passage, size)
    try:
        solver = Prepared(integrator, problem, setting)
    except Refused as refusal:
        return row | {Status.REFUSED: str(refusal)}
    scores: list[tuple[int, int, float]] = []
    budget = Budget(seconds)
    with solver:
        for phase in PHASES:
            if len(scores) >= FEWEST and budget.left <= 0:
                break
            scores.append(_score(_locate(solver, passage.start(phase)), passage.times(phase, size)))
            if len(scores) == 1:
                budget = Budget(seconds)  # the first solution may have compiled
    missed, extra, late = np.array(scores).T
    complete = int(np.count_nonzero(missed == 0))
    low, high = share(complete, len(scores))
    times = late[missed == 0]
    return row | {
        "starts": len(scores), "found": complete, "found_low": low, "found_high": high,
        "missed": int(missed.sum()), "extra": int(extra.sum()), "time_error": float(times.max(initial=0.0)),
    }  # fmt: skip


def share(count: int, of: int, confidence: float = 0.95) -> tuple[float, float]:
    """The interval of Clopper and Pearson (Biometrika 26, 1934) of a share, from `count` hits in `of` trials."""
    tail = (1 - confidence) / 2
    low = 0.0 if count == 0 else float(betaincinv(count, of - count + 1, tail))
    return low, 1.0 if count == of else float(betaincinv(count + 1, of - count, 1 - tail))


def _locate(solver: Prepared, start: Values) -> tuple[tuple[float, str], ...]:
    solution = solver(np.array([start], dtype=np.float64))
    if solution.events is None:
        raise Refused("it reports no events")
    return solution.events


def _score(located: Sequence[tuple[float, str]], exact: Values) -> tuple[int, int, float]:
    """(missed, extra, largest error of the times); the first event at each guard is compared with its exact time."""
    times = [next((t for t, name in located if name == f"guard {k + 1}"), np.inf) for k in range(len(exact))]
    errors = [abs(time - right) for time, right in zip(times, exact, strict=True)]
    hits = sum(error <= NEAR for error in errors)
    return len(exact) - hits, len(located) - hits, max(errors, default=0.0)


def _zeno(integrator: Integrator, setting: float) -> dict[str, Any]:
    """The row of a ball that bounces until it rests: missing and extra events, and the largest error of a time."""
    trials = trials_of(integrator, ZENO)
    if trials.steps:
        interval = float(trials.problem().interval)
        setting = interval * 2.0 ** min(0, round(np.log2(setting * float(trials.reference.time_scale) / interval)))
    answer = trials.whole(setting)
    exact = trials.case.events()
    if answer.events is None:
        return {"setting": setting, "events": len(exact), Status.REFUSED: answer.why}
    score = score_events(answer.events, exact)
    return {
        "setting": setting, "events": len(exact), "missing": score.missing, "extra": score.extra,
        "time_error": score.time_error,
    }  # fmt: skip

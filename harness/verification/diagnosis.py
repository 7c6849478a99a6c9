"""The likely cause of all failures of an integrator, in one line.

It follows from the claims that fail on each case, and from a few more solutions on one of these cases.
"""

from __future__ import annotations

import contextlib
import hashlib
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.forms import Charged, Constrained, FirstOrder, RigidBody, Values
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.measuring.trials import Answer, Floats, Trials
from gnomon.harness.results.convergence_order import LARGEST_ERROR
from gnomon.harness.studies.preflight import name_convention
from gnomon.harness.verification.causes import (
    NEAR,
    OF_EQUATIONS,
    causes,
    count_printed_digits,
    round_to_single,
    say_low_order,
)
from gnomon.harness.verification.claims import Outcome
from gnomon.harness.verification.convergence_claims import is_dense
from gnomon.harness.verification.equation_claims import compensates, takes_plain
from gnomon.harness.verification.fmu.adapter import FmuIntegrator
from gnomon.harness.verification.function_adapter import Stepped
from gnomon.harness.verification.program_adapter import ProgramIntegrator
from gnomon.harness.verification.quadrature_claim import is_right_at_end
from gnomon.harness.verification.structure_claims import from_constraint, from_rotations

MOST = 0.9
"""The samples are late if, for this share of them, some shift in time of the sample leaves less than NEAR of its error."""
FLAT = 1.3
"""Errors that fall by less than this between settings do not fall: half the step should give 2^(1/2) or more."""
FLOOR = 3.0
"""Errors of three settings that fall by less than this have reached a floor: with order 1 they fall by 4 or more."""
SINGLE = (1e-10, 1e-4)
"""The range of errors that come from single precision, or from printing six to nine digits."""
STIFF = 10.0
"""After one step of a stiff decay an implicit method is below, an explicit one far above."""
LEFT = 1e-9
"""Largest relative departure, by round-off, from a property that a method keeps by construction."""
HISTORY = "history: "
"""Beginning of a diagnosis that solutions depend on earlier calls."""
ENDLESS = ("work: ", "hang: ")
"""Beginnings of diagnoses after which nothing more is solved: it would take as long again."""
STRUCTURE = {"symplectic", "reversible", "momentum", "energy", "attitude", "constraint", "time_structure"}
CONTROL = {"tolerance", "tolerance_short", "tolerance_effect", "proportional", "work"}
ACCURACY = {"order", "step_order", "order_short", "error", "proportional", "work_order", "event_order"}

Facts = dict[str, Any]


@dataclass(frozen=True)
class Failures:
    """The claims that failed and passed, as (claim, case) pairs, and the cases by name."""

    failed: frozenset[tuple[str, str]]
    passed: frozenset[tuple[str, str]]
    cases: dict[str, Case]

    got: tuple[str, ...] = ()
    """The results of the failed claims about order, as "h^1.02 ..."."""

    @property
    def claims(self) -> set[str]:
        return {claim for claim, _ in self.failed}

    def slopes(self) -> list[float]:
        return [float(match[1]) for text in self.got if (match := re.match(r"h\^(-?[0-9.]+)", text))]

    def right_below(self, component: int) -> bool:
        """Whether claims about accuracy pass, and never fail, on the cases with fewer coordinates than `component`."""
        few = {name for name, case in self.cases.items() if coordinates(case) < component}
        return any(claim in ACCURACY and case in few for claim, case in self.passed) and not any(
            claim in ACCURACY and case in few for claim, case in self.failed
        )

    def probed(self) -> str:
        """The name of the case to probe: if possible smooth with failures, then autonomous, then with most failures."""
        count = {name: sum(case == name for _, case in self.failed) for name in self.cases}
        smooth = {name: number > 0 and self.cases[name].hybrid is None for name, number in count.items()}
        return max(count, key=lambda name: (smooth[name], smooth[name] and self.cases[name].autonomous, count[name]))

    def only_with_time(self) -> bool:
        """Whether claims fail only on cases with time in their equations, and claims about accuracy pass on others."""
        others = {name for name, case in self.cases.items() if case.autonomous}
        right = any(claim in ACCURACY and case in others for claim, case in self.passed)
        return right and not any(case in others for claim, case in self.failed if claim != "quadrature")


def digest(trials: Trials) -> Facts:
    """A hash of the first solution in a new process."""
    return {"bits": _bits(_states(trials, trials.usual()))}


def facts(trials: Trials) -> Facts:
    """Facts about an integrator from a few solutions on one case."""
    setting, other = trials.usual(), trials.reference.exact[8]
    facts: Facts = {}
    try:
        start = other[None].copy()
        with trials.prepared(trials.problem(), trials.settings[0]) as solver:
            solver.given(start)
        facts["changed_start"] = not np.array_equal(start[0], other)
        facts["bits"] = _bits(_states(trials, setting))
        facts["several"] = trials.case.hybrid is None and _is_mixed(trials, setting)
        answers = [each for each in trials.answers() if each.states is not None and math.isfinite(each.error)]
        facts["bits_again"] = _bits(_states(trials, setting))
    except Exception:  # the user's code may raise anything
        return facts | {"raises": True}
    if not answers:
        return facts | {"answers": False}
    best, states = answers[-1], np.asarray(answers[-1].states)
    exact, rests = trials.reference.exact, _has_few_digits(trials.reference.exact)
    facts |= {
        "points": [(each.setting, each.error, each.roundoff, each.work or 0) for each in answers],
        "still": bool(np.all(states == states[0]) and not np.all(exact == exact[0])),
        "single": not rests and bool(np.array_equal(states, round_to_single(states))),
        "digits": None if rests else count_printed_digits(states),
        "start": name_convention(trials.integrator) if isinstance(trials.form, SceneForm) else None,
        "model": isinstance(trials.integrator, FmuIntegrator),
        "causes": [] if best.error < 100 * best.roundoff else _causes(trials, best),
        "late": not trials.steps and best.error > 100 * best.roundoff and _is_late(trials, best),
        "left": _explain_departure(trials, answers[0]),
        "bumps": not trials.steps and is_dense(trials) and _has_bumps(trials),
    }
    return facts | probe(trials) | (_steps(trials) if trials.steps and trials.case.hybrid is None else {})


def at_rest(t: Any, state: Values, parameters: Values) -> Values:
    """Nothing changes."""
    return 0 * state[0], 0 * state[1]


def decay(t: Any, state: Values, parameters: Values) -> Values:
    """y' = -k y, twice."""
    (k,) = parameters
    return -k * state[0], -k * state[1]


def rotation(t: Any, state: Values, parameters: Values) -> Values:
    """A harmonic oscillator: linear equations."""
    return state[1], -state[0]


def probe(trials: Trials) -> Facts:
    """Facts from solving small problems. A problem that the integrator does not solve gives no fact."""

    def solve(equations: Callable[[Any, Values, Values], Values], step: float, *parameters: float) -> Floats:
        problem = Problem(FirstOrder(equations), 2, np.array(parameters), np.array([step]), 1.0)
        setting = step if trials.steps else trials.usual()
        states: Floats = trials.solutions(problem, setting, [np.array([1.0, 0.5])])[0][-1]
        return states

    def assumes_velocities() -> bool:
        return bool(abs(solve(at_rest, 0.25)[0] - 1.125) < 1e-12)

    def is_implicit() -> bool:
        """A polynomial of the step, which an explicit method computes, is large after one step of a stiff decay."""
        return bool(np.all(np.abs(solve(decay, 1.0, 1e4)) < STIFF))

    def is_right_on_linear() -> bool:
        h = 1 / 16
        errors = [float(np.max(np.abs(solve(rotation, step) - _rotate(step)))) for step in (h, h / 2)]
        return errors[1] <= max(errors[0] / 2 ** (trials.order + 0.5), LEFT)

    probes: dict[str, Callable[[], bool]] = {}
    if FirstOrder in trials.integrator.accepts:
        probes["assumes_velocities"] = assumes_velocities
        if isinstance(trials.integrator, Stepped) and trials.integrator.order is not None:
            probes |= {"implicit": is_implicit, "linear": is_right_on_linear}
    if takes_plain(trials) is None:
        probes["right_at_end"] = partial(is_right_at_end, trials)
        if trials.integrator.compensated:
            probes["compensates_to_end"] = lambda: compensates(trials, end=True).outcome == Outcome.PASSED
    facts: Facts = {}
    for name, probe in probes.items():
        with contextlib.suppress(Exception):  # the user's code may raise anything
            facts[name] = probe()
    return facts


def _rotate(t: float) -> Floats:
    return np.array([math.cos(t) + math.sin(t) / 2, math.cos(t) / 2 - math.sin(t)])


def _states(trials: Trials, setting: float) -> Floats:
    (states,) = trials.solutions(trials.problem(), setting, [trials.start])
    return states


def _bits(states: Floats) -> str:
    return hashlib.sha256(np.ascontiguousarray(states).tobytes()).hexdigest()


def _is_mixed(trials: Trials, setting: float) -> bool:
    """Whether a solution among three starts differs from the solution of one start by far more than its error."""
    alone = trials.whole(setting)
    starts = np.array([trials.reference.exact[8], trials.start, trials.reference.exact[16]])
    with trials.prepared(trials.problem(), setting) as solver:
        solved = solver(starts).states[1]
    if alone.states is None or math.isnan(alone.error):
        return False
    return not float(np.max(trials.distance(solved, alone.states))) <= 4 * alone.error + 100 * alone.roundoff


def _has_few_digits(exact: Floats) -> bool:
    """Whether most exact states are single-precision numbers, as for a motion with simple numbers."""
    return bool(np.mean(exact == round_to_single(exact)) > 0.5)


def _causes(trials: Trials, answer: Answer) -> list[str]:
    """The causes of the errors of an answer, each as `id: sentence`."""
    moves = {"h": answer.setting, "h / 2": answer.setting / 2} if trials.steps else {}
    has_own = isinstance(trials.form, SceneForm) or isinstance(trials.integrator, ProgramIntegrator | FmuIntegrator)
    likely = causes(trials.case, trials.reference.times, np.asarray(answer.states), moves, has_own)
    return [f"{each.kind}: {each}" for each in likely]


def _is_late(trials: Trials, answer: Answer) -> bool:
    """Whether most states are exact states of a later time, which differs from state to state, up to a small error."""
    times, exact, sample = trials.reference.times, trials.reference.exact, trials.case.sample
    little = float(trials.problem().interval) * 2.0**-10
    weights = 1 / np.maximum(np.max(np.abs(exact), axis=0), 1e-300)
    speed = (sample(times + little) - sample(times - little)) / (2 * little) * weights
    later = np.sum((np.asarray(answer.states) - exact) * weights * speed, axis=1) / np.sum(speed * speed, axis=1)
    inside = (later > 0) & (times + later <= times[-1])
    if np.mean(inside) < MOST:
        return False
    states = np.asarray(answer.states)[inside]
    left = trials.distance(states, sample(times[inside] + later[inside]))
    return bool(np.mean(left < NEAR * trials.distance(states, exact[inside])) > MOST)


def _explain_departure(trials: Trials, answer: Answer) -> str | None:
    """The violation, in words, of a rotation or constraint that the method declares to keep; None if it is kept."""
    states, form, conserved = np.asarray(answer.states), trials.form, trials.integrator.conserves
    if isinstance(form, RigidBody) and "attitude" in conserved and from_rotations(states) > LEFT:
        return "its attitudes are not rotations"
    if isinstance(form, Constrained) and "constraint" in conserved and from_constraint(trials, states)[1] > LEFT:
        return "its velocities are not tangent to the constraint"
    return None


def _has_bumps(trials: Trials) -> bool:
    """Whether errors over a short span rise and fall: small errors at ends of steps, large ones of the interpolant between."""
    for halvings in range(2, 9):
        for tolerance in trials.settings[len(trials.settings) // 2 :]:
            answer = trials.short(halvings, tolerance)
            if answer.states is None or not 100 * answer.roundoff < answer.error < LARGEST_ERROR:
                continue
            top = np.maximum.accumulate(answer.errors)
            if np.any(answer.errors[8:] < top[8:] / 30):
                return True
    return False


def _steps(trials: Trials) -> Facts:
    """Errors of single steps by step size, and the first component whose error falls too slowly."""
    points, parts = [], []
    for h, answer in trials.single_steps():
        if answer.states is None or not answer.roundoff / 8 < answer.error < LARGEST_ERROR:
            continue
        halvings = round(math.log2(float(trials.problem().interval) / h))
        first = np.abs(np.asarray(answer.states)[0] - trials.exact(halvings)[0])
        points.append((h, answer.error, answer.roundoff))
        parts.append(first)
    facts: Facts = {"single_steps": points}
    order = trials.integrator.order
    if order is None or len(points) < 3:
        return facts
    coarse, fine = parts[len(parts) // 2 - 1], parts[len(parts) // 2]
    ratio = points[len(parts) // 2 - 1][0] / points[len(parts) // 2][0]
    with np.errstate(all="ignore"):
        powers = np.log(coarse / fine) / math.log(ratio)
    low = np.nonzero((powers < order) & (coarse > 1e-14 * np.max(np.abs(trials.start))))[0]
    if trials.case.second_order is not None or isinstance(trials.form, Charged | Constrained):  # positions, velocities
        low = np.unique(low % coordinates(trials.case))
    facts["first_wrong"] = int(low[0]) + 1 if len(low) and low[0] >= 2 else None
    return facts


def coordinates(case: Case) -> int:
    """The number of coordinates; a position and its velocity, in second-order equations, count once."""
    return len(case.state) // (2 if case.second_order is not None else 1)


def conclude(failures: Failures, facts: Facts) -> str | None:
    """The cause as `id: sentence`; None if unknown. `facts`: the facts, the digest as `alone`, and the declarations."""
    for cause in (_of_calls, _of_samples, _of_cases, _of_control, _of_order):
        text = cause(failures, failures.claims, facts)
        if text is not None:
            return text
    return None


def of_many_calls(limit: str) -> str:
    """The cause if a solution was given up after many times the right-hand sides of a right method."""
    return f"work: it needs {limit}, many times those of a right method: its error estimate, or a coefficient, is wrong"


def of_no_answer(where: str, why: str) -> str:
    """The cause if a claim had no answer in time."""
    return f"hang: {where} has {why}: steps that collapse, or a loop without an end"


def _of_calls(failures: Failures, claims: set[str], facts: Facts) -> str | None:
    bits = facts.get("bits")
    if facts.get("assumes_velocities"):
        return (
            "form: it moves positions by velocities (q' = v), not by f: where f is 0 the first half of y still moves; use both"
            " halves of f(t, y), or declare accelerations=True, which makes f(t, q) the accelerations"
        )
    if facts.get("changed_start") or "start_kept" in claims:
        return "input: it changes the start that it is given"
    if bits is not None and bits != facts.get("bits_again", bits):
        again = "the same call has another solution the second time"
        return f"{HISTORY}{again}: something is kept from call to call, or random"
    alone = bits and facts["alone"].get("bits", bits)
    if {"history", "repeatable"} & claims or claims == {"other_problems"} or alone != bits:
        return HISTORY + "its solutions depend on earlier calls: something is kept between runs"
    if "aliasing" in claims:
        return "aliasing: states that it returned change with the next call: a buffer is used again"
    if facts.get("several") or ("ensemble" in claims and not claims & ACCURACY):
        return "ensemble: of several starts in one call it solves one otherwise than alone"
    if claims and claims <= {"bad_start", "bad_setting", "blow_up"}:
        return "finite: it gives finite states where there is no solution: it replaces nan, or does not look for it"
    if facts.get("raises") or facts.get("answers") is False:
        return "no answer: it raises, or has no finite states at any setting"
    return None


def _of_samples(failures: Failures, claims: set[str], facts: Facts) -> str | None:
    if facts.get("still"):
        return "still: all samples are equal, where the exact motion moves"
    if facts.get("single"):
        return "precision: every state is a number of single precision"
    if facts.get("digits"):
        return f"precision: every state has {facts['digits']} decimal digits: digits that were printed"
    if facts.get("start"):
        return f"convention: {facts['start']}"
    return next((text for text in facts.get("causes", ()) if not _is_of_equations(text)), None) or _of_bits(
        failures, claims, facts
    )


def _is_of_equations(text: str) -> bool:
    return text.partition(": ")[0] in OF_EQUATIONS


def _of_bits(failures: Failures, claims: set[str], facts: Facts) -> str | None:
    if facts.get("late"):
        return "late: its states fit the exact motion at later times: a step goes beyond a sample, or is counted short"
    if (text := _of_iterations(failures, claims, facts)) is not None:
        return text
    if (floor := _floor(facts)) is not None:
        return (
            f"precision: its error stays near {floor:.0e} however fine the setting: single precision, printed digits,"
            " a coefficient with few digits, or an iteration that stops early"
        )
    if facts.get("left"):
        return f"left: {facts['left']}: a projection, or a normalisation, is missing or wrong"
    return None


def _of_iterations(failures: Failures, claims: set[str], facts: Facts) -> str | None:
    """The cause of an implicit method that is correct only on linear equations, where Newton's method needs one iteration."""
    autonomous = {name for name, case in failures.cases.items() if case.autonomous}
    of_formula = {claim for claim, case in failures.failed if case in autonomous and claim in ACCURACY | STRUCTURE}
    if not (facts.get("implicit") and facts.get("linear") and of_formula):
        return None
    floor, order, powers = _floor(facts), facts["order"], failures.slopes() or _slopes(facts)
    if floor is not None:
        shown = f": its error stays near {floor:.0e}"
    else:
        shown = f": it converges with order {min(powers):.1f} where {order} is declared" if powers else ""
    return (
        f"iteration: it is right on linear equations alone{shown}: Newton's iteration stops after one step, at a loose"
        " tolerance, or with an old Jacobian"
    )


def _floor(facts: Facts) -> float | None:
    """An error in the range of single precision that finer settings, or shorter spans, do not reduce."""
    points = [error for _, error, roundoff, _ in facts.get("points", []) if error > 20 * roundoff]
    single = [error for _, error, _ in facts.get("single_steps", [])]
    for tail in (*(single[k : k + 4] for k in range(len(single) - 3)), points[-3:]):
        if len(tail) >= 3 and SINGLE[0] < min(tail) <= max(tail) < SINGLE[1] and tail[0] < FLOOR * tail[-1]:
            return float(tail[-1])
    return None


def _of_cases(failures: Failures, claims: set[str], facts: Facts) -> str | None:
    """A cause that follows from the common property of the failing cases and claims."""
    hybrid = {name for name, case in failures.cases.items() if case.hybrid is not None}
    if claims & {"events", "event_order"} and all(case in hybrid for _, case in failures.failed):
        return "events: an event is missed, at the wrong time, or changes the state wrongly"
    if claims == {"backward"}:
        return "sign: where times fall its steps go forward, or are wrong: a step has lost its sign"
    if claims == {"clock"}:
        return "time: it is wrong only where the start is not at t = 0: the equations get the time since the start"
    if claims == {"compensated"}:
        when = "at each sample" if facts.get("compensates_to_end") else "in each step, or have the wrong sign"
        return f"compensation: the rounding residuals of its sums are lost {when}: the second number is reset"
    if claims == {"quadrature"} and not facts["steps"] and facts.get("right_at_end"):
        return (
            "dense: the ends of its steps are right, samples between them are not: its interpolant has a lower order than"
            " its steps; declare that order as dense_order"
        )
    if claims == {"quadrature"} and facts.get("may_take_differences"):
        return (
            'quadrature: it differentiates f by differences, and must declare jacobian="differences"; or a weight or a time'
            " of its stages is wrong in a late digit"
        )
    if claims == {"quadrature"} and any(claim in ACCURACY for claim, _ in failures.passed):
        return "quadrature: a weight or a time of its stages is wrong, by little if it is a weight: only forces of time show it"
    if failures.only_with_time():
        return "time: it is wrong only where the equations have the time in them: the time of a stage, or of a step"
    first = facts.get("first_wrong")
    if claims == {"more_variables"} and facts.get("implicit"):
        return (
            "iteration: equations solved together have another solution than alone: its iteration stops at a loose tolerance,"
            " which all variables share"
        )
    if claims == {"more_variables"}:
        return "component: it is wrong only where there are more than six variables"
    if first is not None and failures.right_below(first):
        return f"component: it is wrong from component {first} on, where there are so many"
    if claims and claims <= {"permuted", "turned"}:
        return "component: it does not treat all components alike"
    if claims == {"mirror"}:
        return "sign: it treats positive and negative numbers differently"
    if "units" in claims and claims <= {"units", "rounded_times", "quadrature"}:
        return "absolute: a number inside it has a unit: a length, a time or a bound that belongs to no problem"
    return next(filter(_is_of_equations, facts.get("causes", ())), None)


def _of_control(failures: Failures, claims: set[str], facts: Facts) -> str | None:
    points = facts.get("points", [])
    if facts["steps"]:
        return None
    if "error_norm" in claims and claims <= {"error_norm", *CONTROL, *ACCURACY}:
        return (
            "norm: its error estimate does not count all components alike: one is left out, signs cancel, or a size is"
            " another component's"
        )
    if claims == {"many_samples"}:
        return (
            "samples: with many samples a step it is worse: a slope is kept after a sample, or a sample within a step has"
            " another time or polynomial"
        )
    if "dense" in claims and facts.get("bumps"):
        return "dense: samples between steps are worse than the ends of steps: the interpolation is wrong"
    if len(points) > 2 and points[0][3] and points[-1][3] <= 1.05 * points[0][3]:
        return (
            f"tolerance: it takes as many steps at tolerance {points[0][0]:g} as at {points[-1][0]:g}: it has no effect"
        )
    if "quadrature" not in claims and claims & CONTROL and (_is_flat(points) or not claims & {"work_order", "dense"}):
        worst = max((error / setting for setting, error, _, _ in points if error < LARGEST_ERROR), default=math.nan)
        return f"control: its error is up to {worst:.1g} times its tolerance: the error estimate, or its use, is wrong"
    return "dense: the interpolation between steps is wrong" if claims <= {"dense", "tolerance_short"} else None


def _is_flat(points: Sequence[Sequence[float]]) -> bool:
    """Whether the errors at the two finest settings, well above round-off, do not fall."""
    tail = points[-2:]
    return len(tail) == 2 and tail[1][1] > 20 * tail[1][2] and tail[0][1] < FLAT * tail[1][1]


def _of_order(failures: Failures, claims: set[str], facts: Facts) -> str | None:
    order = facts["order"]
    if claims and claims <= STRUCTURE:
        names = ", ".join(sorted(claims))
        return f"structure: its order is right, but not {names}, which it declares: a step without symmetry, or few iterations"
    if facts.get("model") and facts["steps"] and _is_inconsistent(failures, facts):
        return (
            "equations: shorter steps do not lead to the motion of the case: a parameter, the start or a term of its equations"
            " differs, or its formula is not consistent"
        )
    return None if order is None else _lower(failures.slopes() or _slopes(facts), order)


def _slopes(facts: Facts) -> list[float]:
    """The power of the step with which errors fall, over single steps or else over the whole span; empty if unknown."""
    points = facts.get("points", [])
    single = [point for point in facts.get("single_steps", []) if point[1] > 20 * point[2]]
    if len(single) >= 2:
        (h0, e0, _), (h1, e1, _) = single[-2:]
        return [math.log(e0 / e1) / math.log(h0 / h1) - facts["stepped"]]
    if _is_flat(points):
        return [0.0]
    used = [(s if facts["steps"] else 1 / w, e) for s, e, r, w in points if w and 20 * r < e < LARGEST_ERROR]
    if len(used) < 2:
        return []
    (h0, e0), (h1, e1) = used[-2 if facts["steps"] else 0], used[-1]
    return [math.log(e0 / e1) / math.log(h0 / h1) if h0 > h1 else 0.0]


def _is_inconsistent(failures: Failures, facts: Facts) -> bool:
    """Whether the order is 0: errors over a span do not fall with the step, errors of a step fall in proportion to it."""
    powers = failures.slopes()
    if powers:
        return min(powers) < 0.5
    single = _slopes(facts) if facts.get("single_steps") else []
    return bool(single) and min(single) + facts["stepped"] < 1.5


def _lower(powers: Sequence[float], order: int) -> str | None:
    if not powers or min(powers) >= order - 0.5:
        return None
    return f"order: {say_low_order(min(powers), order)}"

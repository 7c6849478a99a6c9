"""Claims about structure: properties that an integrator declares to keep at any step size (`Integrator.conserves`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from gnomon.cases.core.forms import Constrained, RigidBody, Separable
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.measuring.trials import HALF_ULP, Answer, Floats, Trials
from gnomon.harness.studies.related_motions import measure_return
from gnomon.harness.verification.claims import Finding, claim, fail_claim, not_applicable, pass_claim

DIFFERENCE = 2.0**-17
"""Relative distance of central differences, extrapolated with twice the distance. Rounding leaves about 1e-11,
truncation less, even near a pericentre, where third derivatives are a thousand times as large."""
DECLINED = 6
"""Number of step sizes that are tried, each half of the one before, while an integrator declines or does not converge."""
STEPS = 4
"""Number of steps whose map is differentiated."""
SYMPLECTIC = 1e-7
"""Largest defect: ten thousand times the error of a difference, for the products and the growth of rounding in STEPS."""
HIGH = 8
"""The order that is assumed for a method without a declared one."""
ROUNDINGS = 64
"""Largest number of roundings in a step that change an invariant: stages, iterations and sums."""


def _declares(word: str, more: Callable[[Trials], str | None] = lambda trials: None) -> Callable[[Trials], str | None]:
    """A function that gives the reason why a claim does not apply: `word` is not declared, a tolerance, events, or `more`."""

    def applies(trials: Trials) -> str | None:
        if word not in trials.integrator.conserves:
            return f"it does not declare {word}"
        if not trials.steps:
            return "its setting is a tolerance"
        # An engine takes an impact as a part of its steps, and may keep an energy that the case keeps.
        eventful = trials.case.hybrid is not None and not (word == "energy" and isinstance(trials.form, SceneForm))
        return "events change the state" if eventful else more(trials)

    return applies


def _canonical(trials: Trials) -> str | None:
    if any(isinstance(form, Separable) for form in trials.case.forms):
        return None
    return "the case does not state canonical coordinates"


@claim("symplectic", _declares("symplectic", _canonical))
def _symplectic(trials: Trials) -> Finding:
    """J^T W J = W for the map of a few coarse steps, with J from central differences in scaled coordinates."""
    sizes, n = trials.reference.sizes, len(trials.start)
    offsets = [DIFFERENCE, -DIFFERENCE, 2 * DIFFERENCE, -2 * DIFFERENCE]
    starts = [trials.start + offset * sizes * np.eye(n)[i] for i in range(n) for offset in offsets]
    zero, identity = np.zeros((n // 2, n // 2)), np.eye(n // 2)
    form = np.block([[zero, identity], [-identity, zero]]) * np.outer(sizes, sizes)

    def defect(halvings: int, problem: Problem) -> _Defect:
        ends = np.array([states[STEPS - 1] for states in trials.solutions(problem, problem.interval, starts)])
        near, nears, far, fars = np.moveaxis(ends.reshape(n, len(offsets), n), 1, 0)
        jacobian = ((8 * (near - nears) - (far - fars)) / (12 * DIFFERENCE * sizes)).T
        departure = float(np.max(np.abs(jacobian.T @ form @ jacobian - form)) / np.max(np.abs(form)))
        return _Defect(problem.interval, halvings, departure, SYMPLECTIC)

    return _at_the_longest(trials, (defect(*coarse) for coarse in _coarse(trials)), "J^T W J = W")


def _has_reversal(trials: Trials) -> str | None:
    return None if trials.case.reversed(trials.case.initial_state) is not None else "the case has no time reversal"


@claim("reversible", _declares("reversible", _has_reversal))
def _reversible(trials: Trials) -> Finding:
    """The distance from the start after integrating forward, reversing the velocities, and integrating back."""

    def defect(halvings: int, problem: Problem) -> _Defect:
        apart = measure_return(trials, problem, problem.interval)
        if apart is None:
            return _Defect(problem.interval, halvings, math.nan, 0.0)
        growth = max(1.0, trials.conditioning(halvings) / HALF_ULP)
        allowed = trials.roundoff(2 * len(problem.times), halvings) * growth * ROUNDINGS
        return _Defect(problem.interval, halvings, apart, allowed)

    return _at_the_longest(trials, (defect(*coarse) for coarse in _coarse(trials)), "return to the start")


def _has_momentum(trials: Trials) -> str | None:
    return None if _momenta(trials) else "the case keeps no momentum"


def _momenta(trials: Trials) -> list[str]:
    invariants, names = trials.case.invariants, ("momentum", "angular_momentum")
    return [name for name in names if name in invariants and invariants[name].law == "constant"]


def _check_invariants(trials: Trials, names: Sequence[str], what: str, carried: float = 1.0) -> Finding:
    """Whether the drift of these invariants is within the rounding of all steps."""

    def drift(states: Floats) -> float:
        drifts = trials.scorer.drift(states)
        return max(float(np.max(drifts[name])) for name in names)

    return _check_kept(trials, drift, what, carried)


@claim("momentum", _declares("momentum", _has_momentum))
def _momentum(trials: Trials) -> Finding:
    return _check_invariants(trials, _momenta(trials), "momentum kept")


def _energies(trials: Trials) -> list[str]:
    return [name for name, each in trials.case.invariants.items() if "energy" in name and each.law == "constant"]


def _has_energy(trials: Trials) -> str | None:
    return None if _energies(trials) else "the case keeps no energy"


def carry_roundings(trials: Trials, names: Sequence[str]) -> float:
    """The largest factor by which a relative rounding of the states changes an invariant, relative to the invariant's size.

    The rounding of a component is relative to the size of its group at this time: a small component may be a sum of larger
    numbers.
    """
    exact, groups = trials.reference.exact, trials.scorer.metric.groups
    total = {name: np.zeros(len(exact)) for name in names}
    for members in (list(group.indices) for group in groups):
        size = np.linalg.norm(exact[:, members], axis=1)
        for index in members:
            near = exact.copy()
            near[:, index] += DIFFERENCE * size
            drifts = trials.scorer.drift(near)
            for name in names:
                total[name] += drifts[name] / DIFFERENCE
    return max(1.0, *(float(np.max(each)) for each in total.values()))


@claim("energy", _declares("energy", _has_energy))
def _energy(trials: Trials) -> Finding:
    names = _energies(trials)
    return _check_invariants(trials, names, "energy kept", carry_roundings(trials, names))


def _check_kept(trials: Trials, departure: Callable[[Floats], float], what: str, carried: float = 1.0) -> Finding:
    """Whether the largest `departure` of states (samples, dim) is within the rounding of all steps, times `carried`."""
    answers = (trials.whole(setting) for setting in trials.settings[:DECLINED])
    usable = (a for a in answers if a.states is not None and not math.isnan(a.error))

    def defect(answer: Answer) -> _Defect:
        assert answer.states is not None
        half_ulp = 2.0 ** -getattr(trials.integrator, "bits", 53)  # an engine may compute in binary32
        allowed = ROUNDINGS * half_ulp * max(answer.work or 0, len(trials.reference.times)) * carried
        return _Defect(answer.setting, 0, departure(answer.states), allowed)

    return _at_the_longest(trials, map(defect, usable), what)


def _has_form(kind: type) -> Callable[[Trials], str | None]:
    return lambda trials: None if isinstance(trials.form, kind) else f"it takes no {kind.__name__}"


def from_rotations(states: Floats) -> float:
    """The largest element of R R^T - 1, for states (n, 12) of a rigid body."""
    rotations = states[:, 3:].reshape(-1, 3, 3)
    return float(np.max(np.abs(rotations @ rotations.transpose(0, 2, 1) - np.eye(3))))


def from_constraint(trials: Trials, states: Floats) -> tuple[float, float]:
    """The largest distance of positions from a constraint, and of velocities from its tangent, over their sizes."""
    form, p = trials.form, tuple(trials.problem().parameters.tolist())
    places, speeds = np.split(states, 2, axis=1)
    moments = [(t, tuple(q)) for t, q in zip(trials.reference.times.tolist(), places, strict=True)]
    values = np.array(form.constraint(0.0, tuple(np.split(trials.start, 2)[0]), p))
    slopes = np.array([form.gradient(t, q, p) for t, q in moments]).reshape(len(states), len(values), -1)
    rates = [form.constraint_rate(t, q, p) for t, q in moments] if form.constraint_rate else np.zeros(len(values))
    off = np.abs(np.array([form.constraint(t, q, p) for t, q in moments]) - values)
    along = np.abs(np.einsum("tkn,tn->tk", slopes, speeds) + rates)
    steep = np.linalg.norm(slopes, axis=2)
    sizes = [np.max(steep * np.linalg.norm(part, axis=1)[:, None], axis=0) for part in (places, speeds)]
    return float(np.max(off / sizes[0])), float(np.max(along / sizes[1]))


@claim("attitude", _declares("attitude", _has_form(RigidBody)))
def _attitude(trials: Trials) -> Finding:
    return _check_kept(trials, from_rotations, "rotations kept")


@claim("constraint", _declares("constraint", _has_form(Constrained)))
def _constraint(trials: Trials) -> Finding:
    return _check_kept(trials, lambda states: max(from_constraint(trials, states)), "constraint kept")


def _coarse(trials: Trials) -> Iterator[tuple[int, Problem]]:
    """(halvings, problem) of short spans with steps of one sampling interval, from the longest step of the sweep down.

    Steps that the integrator declines as too long (stages that do not converge) are left out.
    """
    ratio = trials.problem().interval / trials.longest_step
    longest = max(0, math.ceil(math.log2(ratio)))
    for halvings in range(longest, longest + DECLINED):
        problem = trials.problem(halvings)
        if not trials.short(halvings, problem.interval).declined:
            yield halvings, problem


@dataclass(frozen=True)
class _Defect:
    """The defect that a claim finds at a step size over the span divided by 2^halvings, and the allowed defect."""

    setting: float
    halvings: int
    departure: float
    allowed: float


def _at_the_longest(trials: Trials, defects: Iterator[_Defect], what: str) -> Finding:
    """The finding at the longest step; at half of it, and so on, as long as the iterations of a step do not converge.

    Half the step reduces a defect by at most 2^(2 order + 1) if iterations converge. A larger fall shows that they did not
    converge before.
    """
    first = before = next(defects, None)
    if first is None or before is None:
        return not_applicable(f"no solution with finite states at its {DECLINED} longest steps")
    if first.departure <= first.allowed:
        return pass_claim(f"{first.departure:.2g}")
    for half in defects:
        if half.departure <= half.allowed:
            if not before.departure <= half.departure * 2.0 ** (2 * (trials.integrator.order or HIGH) + 2):
                return pass_claim(f"{half.departure:.2g} at h = {half.setting:.6g}")
            break
        before = half
    part = f" over 1/{2**first.halvings} of the span" if first.halvings else ""
    return fail_claim(f"h = {first.setting:.6g}{part}", f"{what} to {first.allowed:.2g}", f"{first.departure:.2g}")

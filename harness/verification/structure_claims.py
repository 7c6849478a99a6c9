"""Claims of structure: what an integrator declares to conserve at any step size (`Integrator.conserves`)."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from gnomon.cases.core.forms import Separable
from gnomon.harness.contract.integrator import Problem, Steps
from gnomon.harness.verification.claims import Finding, claim, failed, not_applicable, passed
from gnomon.harness.verification.trials import HALF_ULP, Trials

DIFFERENCE = 2.0**-17
"""Central differences over this share of the size and over twice of it, extrapolated: rounding leaves about 1e-11, and
truncation less, also where a pericentre makes third derivatives a thousand times as large."""
DECLINED = 6
"""Steps, each half of the one before, that an integrator may decline before the longest counts as its failure."""
STEPS = 4
"""Steps whose map is differentiated."""
SYMPLECTIC = 1e-7
"""Ten thousand times the error of one difference: for the growth of rounding in four steps, and products."""
ROUNDINGS = 64
"""Roundings in a step, at most, that change an invariant: stages, iterations and sums."""


def _declares(word: str, more: Callable[[Trials], str | None] = lambda trials: None) -> Callable[[Trials], str | None]:
    def applies(trials: Trials) -> str | None:
        if word not in trials.integrator.conserves:
            return f"it does not declare {word}"
        if not trials.steps:
            return "its setting is a tolerance"
        return "events change the state" if trials.case.hybrid is not None else more(trials)

    return applies


def _canonical(trials: Trials) -> str | None:
    if any(isinstance(form, Separable) for form in trials.case.forms):
        return None
    return "the case does not state canonical coordinates"


@claim("symplectic", _declares("symplectic", _canonical))
def _symplectic(trials: Trials) -> Finding:
    """J^T W J = W for the map of a few coarse steps, J from central differences in scaled coordinates."""
    halvings, problem = _coarse(trials)
    sizes, n = trials.reference.sizes, len(trials.start)
    offsets = [DIFFERENCE, -DIFFERENCE, 2 * DIFFERENCE, -2 * DIFFERENCE]
    starts = [trials.start + offset * sizes * np.eye(n)[i] for i in range(n) for offset in offsets]
    ends = np.array([states[STEPS - 1] for states in trials.solutions(problem, problem.interval, starts)])
    near, nears, far, fars = np.moveaxis(ends.reshape(n, len(offsets), n), 1, 0)
    jacobian = ((8 * (near - nears) - (far - fars)) / (12 * DIFFERENCE * sizes)).T
    zero, one = np.zeros((n // 2, n // 2)), np.eye(n // 2)
    form = np.block([[zero, one], [-one, zero]]) * np.outer(sizes, sizes)
    defect = float(np.max(np.abs(jacobian.T @ form @ jacobian - form)) / np.max(np.abs(form)))
    return _within(problem.interval, defect, SYMPLECTIC, "J^T W J = W", halvings)


def _has_reversal(trials: Trials) -> str | None:
    return None if trials.case.reversed(trials.case.initial_state) is not None else "the case has no time reversal"


@claim("reversible", _declares("reversible", _has_reversal))
def _reversible(trials: Trials) -> Finding:
    """The distance from the start after the way there, reversal of the velocities, and the way back."""
    halvings, problem = _coarse(trials)
    there = trials.solutions(problem, problem.interval, [trials.start])[0][-1]
    turned = trials.case.reversed(tuple(there.tolist()))
    home = trials.case.reversed(tuple(trials.start.tolist()))
    if not np.all(np.isfinite(there)) or turned is None or home is None:
        return not_applicable(f"no finite states at h = {problem.interval:.6g}")
    state, parameters = turned
    numbers = np.array([float(parameters[p.name]) for p in trials.case.parameter_list])
    way_back = replace(problem, parameters=numbers)
    back = trials.solutions(way_back, problem.interval, [np.array(state, dtype=np.float64)])[0][-1]
    apart = float(trials.distance(back[None], np.array([home[0]], dtype=np.float64))[0])
    growth = max(1.0, trials.conditioning(halvings) / HALF_ULP)
    allowed = trials.roundoff(2 * len(problem.times), halvings) * growth * ROUNDINGS
    return _within(problem.interval, apart, allowed, "return to the start", halvings)


def _has_momentum(trials: Trials) -> str | None:
    return None if _momenta(trials) else "the case keeps no momentum"


def _momenta(trials: Trials) -> list[str]:
    invariants = trials.case.invariants
    return [
        name for name in invariants if name in ("momentum", "angular_momentum") and invariants[name].law == "constant"
    ]


@claim("momentum", _declares("momentum", _has_momentum))
def _momentum(trials: Trials) -> Finding:
    answer = trials.whole(trials.settings[0])
    if answer.states is None or math.isnan(answer.error):
        return not_applicable(f"no solution at h = {answer.setting:.6g}: {answer.why}")
    drifts = trials.scorer.drift(answer.states)
    allowed = ROUNDINGS * HALF_ULP * max(answer.work or 0, len(trials.reference.times))
    worst = max(float(np.max(drifts[name])) for name in _momenta(trials))
    return _within(answer.setting, worst, allowed, "momentum kept", 0)


def _coarse(trials: Trials) -> tuple[int, Problem]:
    """The longest short span with steps of one sampling interval that are within the sweep, and that the integrator does
    not decline as too long (stages that do not converge): (halvings, problem)."""
    sweep = trials.integrator.sweep
    assert isinstance(sweep, Steps)
    ratio = trials.problem().interval / (sweep.coarsest * trials.reference.time_scale)
    longest = max(0, math.ceil(math.log2(ratio)))
    for halvings in range(longest, longest + DECLINED):
        problem = trials.problem(halvings)
        if not trials.short(halvings, problem.interval).declined:
            return halvings, problem
    return longest, trials.problem(longest)


def _within(setting: float, found: float, allowed: float, what: str, halvings: int) -> Finding:
    if found <= allowed:
        return passed(f"{found:.2g}")
    part = f" over 1/{2**halvings} of the span" if halvings else ""
    return failed(f"h = {setting:.6g}{part}", f"{what} to {allowed:.2g}", f"{found:.2g}")

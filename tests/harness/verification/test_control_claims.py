"""Many samples in each step, and error norms: faults that only these claims show, and right methods that must pass."""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
import planted_right
import pytest
import right_methods
from family_faults import family_planted, family_right
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator, Tolerance, Unsupported
from gnomon.harness.measuring.reference_solution import CaseSpec, ReferenceSolution, reference_solution
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.registry.lookup import find_one
from gnomon.harness.verification.claims import DEPTHS, Finding, Outcome
from gnomon.harness.verification.function_adapter import from_solve
from gnomon.harness.verification.verify import CLAIMS
from mutants import right
from planted_methods import good_pair, good_rk4
from scipy.integrate import solve_ivp

NAMES = ("many_samples", "error_norm")
PLANTED = {mutant.id: mutant for mutant in family_planted()}
RIGHT = {name: method for name, method in (right() | family_right()).items() if isinstance(method.sweep, Tolerance)}


CASE = get("pendulum_simple").rounded()


@cache
def reference() -> ReferenceSolution:
    return reference_solution(CaseSpec.of(CASE))


def found(claim: str, integrator: Integrator) -> Finding:
    return CLAIMS[claim].check(Trials(integrator, CASE, reference(), DEPTHS["low"]))


def restarted(method: str, f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
    """SciPy's solver, which starts anew at each sample: of variable order from order 1."""
    states = []
    for end in times:
        y0 = solve_ivp(f, (t0, end), y0, method=method, rtol=tolerance, atol=1e-3 * tolerance).y[:, -1]
        t0 = end
        states.append(y0)
    return np.array(states)


class ByName(Integrator):
    """Cash and Karp's pair, which knows cases by their names only, as a program may."""

    name, library, order, sampling = "by name", "planted", 5, "dense output"

    def __init__(self, method: Integrator) -> None:
        self.method = method
        self.__dict__.update(accepts=method.accepts, sweep=method.sweep)

    def prepare(self, problem: Any, setting: float) -> Any:
        if problem.names is None:
            raise Unsupported("no case has this name")
        return self.method.prepare(problem, setting)


def slope_before_a_sample(f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
    """Bogacki and Shampine's pair; after a step that ends at a sample it has the slope from before."""
    t, y, h, states = t0, y0, 1e-3 * times[-1], []
    a = f(t, y)
    for end in times:
        while t < end:
            last = t + h >= end
            step = end - t if last else h
            b = f(t + step / 2, y + step / 2 * a)
            c = f(t + 3 / 4 * step, y + 3 / 4 * step * b)
            new = y + step * (2 / 9 * a + 1 / 3 * b + 4 / 9 * c)
            d = f(t + step, new)
            error = np.linalg.norm(step * (-5 / 72 * a + b / 12 + c / 9 - d / 8)) / right_methods.norm(y, tolerance)
            if error <= 1:
                t, y, a = end if last else t + step, new, a if last else d
            h = step * min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** (-1 / 3)))
        states.append(y)
    return np.array(states)


@pytest.mark.parametrize(
    "fault",
    [
        "cash_karp: a later sample in a step is at the time of the one before",
        "cash_karp: the polynomial of the step before",
        "bogacki_shampine: after a sample the first slope is that of a stage",
        "fehlberg45: after a sample the first slope is the one before",
    ],
)
def test_many_samples_show_faults_at_samples(fault: str) -> None:
    assert found("many_samples", PLANTED[fault].integrator()).outcome == Outcome.FAILED


def test_many_samples_show_a_slope_from_before_a_sample() -> None:
    """It has no effect where steps are short beside the sampling interval."""
    method = from_solve(slope_before_a_sample, name="slope before", order=3, sweep=Tolerance(1e-3, 1e-10))
    assert found("many_samples", method).outcome == Outcome.FAILED


NORMS = [
    "cash_karp: the norm lacks the first component",
    "bogacki_dense: the norm lacks the last component",
    "fehlberg45: the norm lacks the middle component",
    "cash_karp: the norm lacks the velocities",
    "fehlberg45: the norm lacks the positions",
    "cash_karp: the mean of the errors with their signs",
    "fehlberg45: the largest error with its sign",
    "cash_karp: the smallest error",
    "cash_karp: each error over the size of the next component",
    "fehlberg78: each error over the size of the first component",
]


@pytest.mark.parametrize("fault", NORMS)
def test_a_norm_that_does_not_treat_all_components_alike_fails(fault: str) -> None:
    assert found("error_norm", PLANTED[fault].integrator()).outcome == Outcome.FAILED


def norm_of_accelerations(norm: Callable[[Any], Any]) -> Integrator:
    """Steps of Störmer and Verlet, once and as two halves, whose difference has this norm."""

    def verlet(f: Any, t: float, y: Any, h: float) -> Any:
        return right_methods.verlet(f, t, y, h)

    def solve(f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
        t, y, h, states = t0, y0, 1e-3 * times[-1], []
        for end in times:
            while t < end:
                last = t + h >= end
                step = end - t if last else h
                once, twice = verlet(f, t, y, step), verlet(f, t + step / 2, verlet(f, t, y, step / 2), step / 2)
                error = norm((twice - once) / 3) / tolerance
                if error <= 1:
                    t, y = end if last else t + step, twice
                h = step * min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** (-1 / 3)))
            states.append(y)
        return np.array(states)

    return from_solve(solve, name="Verlet", order=2, accelerations=True, sweep=Tolerance(1e-3, 1e-4))


def test_positions_are_counted_where_the_equations_are_accelerations() -> None:
    assert found("error_norm", norm_of_accelerations(lambda error: np.max(np.abs(error)))).outcome == Outcome.PASSED
    half = norm_of_accelerations(lambda error: np.max(np.abs(np.split(np.split(error, 2)[0], 2)[0])))
    assert found("error_norm", half).outcome == Outcome.FAILED


@pytest.mark.parametrize(
    "method",
    [
        *(RIGHT[name] for name in ("cash_karp", "bogacki_dense", "nystrom_doubled")),
        planted_right.adaptive()[0],
        good_pair,
        find_one("gnomon:RKN 6(4)"),
        find_one("gnomon:Gragg-Bulirsch-Stoer"),
        find_one("scipy:LSODA"),
        from_solve(partial(restarted, "LSODA"), name="LSODA from order 1 at each sample"),
        from_solve(RIGHT["cash_karp"].function, name="an interpolant that is not declared", order=5),  # type: ignore[attr-defined]
    ],
    ids=lambda method: method.name,
)
def test_right_methods_pass(method: Integrator) -> None:
    for claim in NAMES:
        assert found(claim, method).outcome == Outcome.PASSED, claim


def test_where_only_cases_are_known_the_samples_are_of_the_case() -> None:
    """Without plain equations nothing can be said about norms."""
    late = PLANTED["cash_karp: a later sample in a step is at the time of the one before"].integrator()
    assert found("many_samples", ByName(RIGHT["cash_karp"])).outcome == Outcome.PASSED
    assert found("many_samples", ByName(late)).outcome == Outcome.FAILED
    assert found("error_norm", ByName(late)).outcome == Outcome.NOT_APPLICABLE


def test_no_claim_passes_where_nothing_can_be_said() -> None:
    """Zeros have the same error at all samples, and without right-hand sides no bound; a step size is not a tolerance."""
    zeros = from_solve(lambda f, t0, y0, times, tolerance: np.zeros((len(times), len(y0))), name="zeros", order=4)
    assert found("many_samples", zeros).outcome == Outcome.NOT_APPLICABLE
    assert found("error_norm", zeros).outcome == Outcome.NOT_APPLICABLE
    for claim in NAMES:
        assert found(claim, good_rk4).outcome == Outcome.NOT_APPLICABLE

"""Each claim fails for a method with the fault that it is about, and right methods pass them all."""

from dataclasses import replace
from functools import cache
from typing import Any

import mutants
import numpy as np
import planted_engines
import planted_methods
import planted_right
import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Integrator, Solution, Steps, Unsupported
from gnomon.harness.measuring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.registry import lookup
from gnomon.harness.verification.claims import DEPTHS, Outcome
from gnomon.harness.verification.convergence_claims import above_line, in_range, slope_of
from gnomon.harness.verification.function_adapter import from_solve, from_step
from gnomon.harness.verification.structure_claims import carry_roundings
from gnomon.harness.verification.verify import CLAIMS
from planted_methods import good_rk4, pair, rk4, verlet


@cache
def trials(integrator: Integrator, name: str = "pendulum_simple") -> Trials:
    case = get(*name.split("/")).rounded()
    return Trials(integrator, case, reference_solution(CaseSpec.of(case)), DEPTHS["low"])


def outcome(claim: str, integrator: Integrator, name: str = "pendulum_simple") -> Outcome:
    return CLAIMS[claim].check(trials(integrator, name)).outcome


@pytest.mark.parametrize("method", planted_methods.GOOD, ids=lambda method: method.name)
def test_a_right_method_fails_no_claim(method: Integrator) -> None:
    found = {claim.id: claim.check(trials(method)) for claim in CLAIMS.values()}
    assert not {name: finding for name, finding in found.items() if finding.outcome == Outcome.FAILED}
    assert sum(finding.outcome == Outcome.PASSED for finding in found.values()) >= 8


@pytest.mark.parametrize(
    ("claim", "method", "case"),
    [
        ("order", rk4("coefficient_5"), "pendulum_simple"),
        ("step_order", rk4("coefficient_10"), "pendulum_simple"),
        ("step_order", rk4("sign"), "pendulum_simple"),
        ("step_order", rk4("float32"), "pendulum_simple"),
        ("step_order", rk4("time"), "forced_oscillator"),
        ("step_order", verlet("missing_half"), "pendulum_simple"),
        ("quadrature", rk4("coefficient_10"), "pendulum_simple"),
        ("quadrature", rk4("time"), "pendulum_simple"),
        ("quadrature", verlet("coefficient_10"), "pendulum_simple"),
        ("quadrature", verlet("missing_half"), "pendulum_simple"),
        ("quadrature", pair("coefficient_10"), "pendulum_simple"),
        ("quadrature", pair("last_step"), "pendulum_simple"),
        ("symplectic", verlet("float32"), "pendulum_simple"),
        ("reversible", verlet("coefficient_5"), "pendulum_simple"),
        ("repeatable", rk4("kept"), "pendulum_simple"),
        ("tolerance_short", pair("coefficient_5"), "pendulum_simple"),
        ("proportional", pair("float32"), "pendulum_simple"),
    ],
    ids=lambda value: getattr(value, "name", value),
)
def test_a_fault_fails_the_claim_that_it_is_about(claim: str, method: Integrator, case: str) -> None:
    assert outcome(claim, method, case) == Outcome.FAILED


def _started_with_euler(f: Any, t0: float, y0: Any, times: Any, h: float) -> Any:
    """Adams and Bashforth's method of order 2: its first step has an error of h^2, for linear forces too."""
    found, t, y, before = [], t0, y0, f(t0, y0)
    for k in range(1, 1 + round((times[-1] - t0) / h)):
        now = f(t, y)
        y, before, t = y + h * (1.5 * now - 0.5 * before), now, t0 + k * h
        found.append(y)
    return np.array(found)[round((times[0] - t0) / h) - 1 :: round((times[0] - t0) / h)]


def test_states_of_a_wrong_time_fail_though_no_error_is_small() -> None:
    """The states of the second step after a sample before: right where an interval has one or two steps."""

    def late(f: Any, t0: float, y0: Any, times: Any, step: float) -> Any:
        every = round((times[-1] - t0) / step) // len(times)
        h, y, found = (times[0] - t0) / every, y0, []
        for k in range(every * len(times)):
            t = t0 + k * h
            y = y + h * f(t + h / 2, y + h / 2 * f(t, y))
            if (k - 1) % every == 0:
                found.append(y)
        return np.array(found)

    assert outcome("order_short", from_solve(late, name="late", order=2, sweep=Steps(0.125, 8))) == Outcome.FAILED


def test_quadrature_allows_an_error_that_falls_with_the_order() -> None:
    method = from_solve(_started_with_euler, name="Adams", order=2, sweep=Steps(0.25, 8))
    found = CLAIMS["quadrature"].check(trials(method))
    assert found.outcome == Outcome.PASSED
    assert "then" in found.got
    higher = from_solve(_started_with_euler, name="Adams", order=3, sweep=Steps(0.25, 8))
    assert outcome("quadrature", higher) == Outcome.FAILED


def test_turned_starts_are_not_solved_at_a_setting_that_takes_too_long(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another claim may have solved there; the turned starts would pass the time limit of the claim."""
    fresh = Trials.of(pair(), CaseSpec.of(get("kepler_orbit").rounded()), DEPTHS["low"])
    *_, quick, slow = fresh.answers()
    fresh._answers[0, slow.setting, False] = replace(slow, seconds=2 * fresh.extent.seconds)
    fresh._answers[0, quick.setting, False] = replace(quick, seconds=0.0)
    settings: list[float] = []
    solutions = fresh.solutions
    monkeypatch.setattr(
        fresh, "solutions", lambda problem, at, starts: settings.append(at) or solutions(problem, at, starts)
    )
    assert CLAIMS["turned"].check(fresh).outcome == Outcome.PASSED
    assert settings == [quick.setting]


class _Changed(Integrator):
    """RK4 whose solutions a subclass changes."""

    name, library, order, accepts, sweep = "changed", "planted", 4, good_rk4.accepts, good_rk4.sweep

    def prepare(self, problem: Any, setting: float) -> Any:
        return self.change(good_rk4.prepare(problem, setting if setting > 0 else problem.interval))

    def change(self, solve: Any) -> Any:
        return solve


class OneBuffer(_Changed):
    def change(self, solve: Any) -> Any:
        buffer: list[Any] = []

        def again(starts: Any) -> Solution:
            found = solve(starts)
            buffer[:] = buffer or [found.states]
            buffer[0][...] = found.states
            return Solution(buffer[0], found.steps)

        return again


class FirstLeaksIntoSecond(_Changed):
    def change(self, solve: Any) -> Any:
        def again(starts: Any) -> Solution:
            found = solve(starts)
            found.states[1:] += 1e-6 * found.states[:1]
            return found

        return again


class FiniteNonsense(_Changed):
    def change(self, solve: Any) -> Any:
        return lambda starts: Solution(np.nan_to_num(solve(starts).states))


class StartsAtZero(_Changed):
    def prepare(self, problem: Any, setting: float) -> Any:
        return good_rk4.prepare(replace(problem, t0=0.0, times=problem.elapsed), setting)


class WrongAtOneSetting(_Changed):
    def prepare(self, problem: Any, setting: float) -> Any:
        return good_rk4.prepare(problem, setting * 4 if 30 < problem.interval / setting < 33 else setting)


class FirstAxisOnly(_Changed):
    """Right along the first axis, a percent off elsewhere."""

    def change(self, solve: Any) -> Any:
        def again(starts: Any) -> Solution:
            found = solve(starts)
            if np.any(starts[:, 1] != 0):
                found.states *= 1.01
            return found

        return again


def test_a_fault_off_the_first_axis_fails_from_turned_starts() -> None:
    assert outcome("turned", good_rk4, "kepler_orbit") == Outcome.PASSED
    assert outcome("turned", FirstAxisOnly(), "kepler_orbit") == Outcome.FAILED
    assert outcome("turned", good_rk4) == Outcome.NOT_APPLICABLE


def test_a_symplectic_map_that_bends_near_a_pericentre_passes() -> None:
    """Third derivatives of the map over a coarse step there are a thousand times as large as elsewhere."""
    assert outcome("symplectic", lookup.find_one("gnomon:Gauss 2-stage"), "kepler_orbit") == Outcome.PASSED


def test_samples_between_steps_have_the_order_declared() -> None:
    """Dormand and Prince's dense output of order 4, and a straight line."""
    linear = next(m for m in mutants.mutants() if m.id == "dormand_prince: linear interpolation")
    assert outcome("dense", mutants.right()["dormand_prince"]) == Outcome.PASSED
    assert outcome("dense", linear.integrator()) == Outcome.FAILED


@pytest.mark.parametrize(
    ("claim", "method"),
    [
        ("aliasing", OneBuffer()), ("ensemble", FirstLeaksIntoSecond()), ("bad_start", FiniteNonsense()),
        ("bad_setting", _Changed()), ("error", WrongAtOneSetting()),
    ],
    ids=lambda value: value if isinstance(value, str) else type(value).__name__,
)  # fmt: skip
def test_a_fault_in_calls_fails_its_claim(claim: str, method: Integrator) -> None:
    assert outcome(claim, good_rk4) == Outcome.PASSED
    assert outcome(claim, method) == Outcome.FAILED


def test_a_method_that_starts_at_another_time_fails_the_claim_of_the_clock() -> None:
    """Where equations do not depend on time, nothing is wrong with it."""
    assert outcome("clock", good_rk4, "forced_oscillator") == Outcome.PASSED
    assert outcome("clock", StartsAtZero()) == Outcome.PASSED
    assert outcome("clock", StartsAtZero(), "forced_oscillator") == Outcome.FAILED


def test_a_failure_says_what_was_expected_where_and_why() -> None:
    finding = CLAIMS["step_order"].check(trials(rk4("sign")))
    assert finding.setting.startswith("h = ")
    assert "h^5" in finding.expected
    assert finding.got.startswith("h^2.0")
    assert finding.why == CLAIMS["step_order"].reason


class Declines(_Changed):
    """It has no solution of anything."""

    def prepare(self, problem: Any, setting: float) -> Any:
        raise Unsupported("lacks this case")


def test_an_integrator_that_declines_everything_is_held_to_nothing() -> None:
    """Else claims about work that it declines would pass, and the exit code would be 0."""
    found = {claim.check(trials(Declines())).outcome for claim in CLAIMS.values()}
    assert found == {Outcome.NOT_APPLICABLE}


def test_a_claim_that_is_not_declared_is_not_made() -> None:
    finding = CLAIMS["symplectic"].check(trials(good_rk4))
    assert finding.outcome == Outcome.NOT_APPLICABLE
    assert finding.why == "it does not declare symplectic"


def test_errors_count_between_those_that_are_not_small_and_round_off() -> None:
    points = [(8.0, 1e-3, 1e-12), (4.0, 0.5, 1e-12), (2.0, 1e-3, 1e-12), (1.0, 1e-5, 1e-12), (0.5, 1e-12, 1e-12)]
    assert [h for h, _, _ in in_range(points)] == [2.0, 1.0], "after the last large error, before round-off"


def test_every_claim_states_its_bound_and_reason() -> None:
    for claim in CLAIMS.values():
        assert claim.states.endswith(".")
        assert claim.reason.endswith(".")
        assert claim.bound.endswith(".")


@pytest.mark.parametrize(("lowest", "expected"), [(5, Outcome.PASSED), (4, Outcome.FAILED)])
def test_an_order_is_that_of_the_finest_steps(lowest: int, expected: Outcome) -> None:
    """The first term of the error changes its sign near h = 1/60, so that the errors above fall by less than their order."""
    points = [(h, abs(h**5 * (1 - 60 * h)) + 0.1 * (lowest < 5) * h**lowest, 1e-17) for h in 2.0 ** -np.arange(5, 10)]
    assert slope_of(points, 5, "errors").outcome == expected


@pytest.mark.parametrize(("share", "expected"), [(0.0, Outcome.PASSED), (1.0, Outcome.FAILED)])
def test_the_last_two_errors_above_round_off_may_show_an_order_but_not_hide_a_fault(
    share: float, expected: Outcome
) -> None:
    """The terms of a right method's error cancel about h = 1/32: the four last errors well above round-off, from there to
    1/256, fall too slowly. The next one is closer to round-off and shows the order; with a fault of order 3 it does not."""
    points = []
    for k in range(3, 10):
        h, left = 2.0**-k, 1 - 0.99 * np.exp(-((k - 5) ** 2) / 8)
        points.append((h, left * h**5 + share * 1e-2 * h**3, 5e-15))
    assert [h for h, _, _ in in_range(points)][-1] == 2.0 ** -(8 if expected == Outcome.PASSED else 9)
    assert slope_of(points, 5, "errors").outcome == expected


def _still(f: Any, t: float, y: Any, h: float) -> Any:
    """RK4 that takes a change below 1e-8 for none: the line of longer steps shows it at tiny ones only."""
    change = good_rk4.function(f, t, y, h) - y
    return y + np.where(np.abs(change) < 1e-8, 0.0, change)


def test_tiny_steps_show_what_no_other_step_does() -> None:
    method = from_step(_still, name="still", order=4)
    finding = CLAIMS["step_order"].check(trials(method))
    assert finding.outcome == Outcome.FAILED
    assert float(finding.setting.removeprefix("h = ")) < 1e-6


def test_a_solver_of_fixed_steps_is_held_to_its_order_and_one_step_to_one_more() -> None:
    """A method of several steps may start with one of lower order: over 64 steps its error is then of its order only."""

    def rough_start(f: Any, t0: float, y0: Any, times: Any, h: float) -> Any:
        """Two steps of Adams and Bashforth, begun by Euler: of order 2, with one step whose error is h^2."""
        t, y, before, found = t0, y0, None, []
        count = round((times[0] - t0) / h)
        for _ in times:
            for _ in range(count):
                slope = f(t, y)
                y = y + h * (slope if before is None else 1.5 * slope - 0.5 * before)
                t, before = t + h, slope
            found.append(y)
        return np.array(found)

    method = from_solve(rough_start, name="rough start", order=2, sweep=Steps(0.25, 6))
    assert outcome("step_order", method) == Outcome.PASSED
    assert outcome("step_order", from_step(good_rk4.function, name="RK4 called of order 5", order=5)) == Outcome.FAILED


@pytest.mark.parametrize(
    ("claim", "name", "case"),
    [
        ("symplectic", "gnomon:Implicit midpoint", "kepler_orbit"),
        ("proportional", "gnomon:Gragg-Bulirsch-Stoer", "pendulum_simple"),
        ("proportional", "rebound:BS", "two_body"),
    ],
)
def test_right_methods_that_decline_a_long_step_or_are_exact_at_the_next_tolerance_pass(
    claim: str, name: str, case: str
) -> None:
    """Stages may not converge at the longest step of a sweep; extrapolation has one error at many loose tolerances."""
    assert outcome(claim, lookup.own()[name], case) == Outcome.PASSED


def test_a_slow_method_is_asked_for_no_setting_after_the_first_that_is_too_long(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its process would be ended, and the claim fail, as if it hung."""
    now = [0.0]
    monkeypatch.setattr("gnomon.harness.measuring.trials._clock", lambda: now[0])

    def solve(f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
        assert tolerance > 1e-6
        now[0] += 1.2 * DEPTHS["low"].seconds if tolerance < 1e-4 else 0.0
        return np.zeros((len(times), len(y0)))

    assert outcome("runs", from_solve(solve, name="slow", order=2)) == Outcome.PASSED
    assert now[0] > 0


@pytest.mark.parametrize(("claim", "case"), [("symplectic", "kepler_orbit"), ("reversible", "two_body")])
def test_a_right_method_whose_iterations_do_not_converge_at_a_long_step_keeps_what_it_declares(
    claim: str, case: str
) -> None:
    """At shorter steps they do, at once. A defect of the method itself falls as a power of the step, and counts."""
    assert outcome(claim, planted_right.right_midpoint, case) == Outcome.PASSED
    kept = planted_right.right_midpoint.conserves
    for step, order in ((good_rk4.function, 4), (planted_right.three_iterations, 2)):
        wrong = from_step(step, name="wrong", order=order, sweep=Steps(4.0, 9), conserves=kept)
        finding = CLAIMS[claim].check(trials(wrong, case))
        assert finding.outcome == Outcome.FAILED
        assert "Refused" in finding.why


def test_the_setting_that_is_worst_beside_its_bound_is_shown() -> None:
    """By the line of h = 1, which has 1e-3, half the step allows 1/4 of 1e-3; by the line of 1/2, which has 2e-3, a
    quarter allows 5e-4. Each is allowed four times."""
    h, error, allowed = above_line([(1.0, 1e-3, 0.0), (0.5, 2e-3, 0.0), (0.25, 9e-2, 0.0)], 2) or (0.0, 0.0, 0.0)
    assert (h, error) == (0.25, 9e-2)
    assert allowed == pytest.approx(4 * 2e-3 / 4)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


def average_vector_field(f: Any, t: float, y: Any, h: float) -> Any:
    """The mean of f over the line from y to the next y: its energy is constant, by quadrature to rounding."""
    after = y + h * f(t, y)
    for _ in range(200):
        before = after
        after = y + h / 2 * sum(w * f(t, y + (1 + x) / 2 * (before - y)) for x, w in zip(NODES, WEIGHTS, strict=True))
        if np.max(np.abs(after - before)) <= 2e-16 * np.max(np.abs(after)):
            return after
    return after


def conserving(step: Any, order: int) -> Integrator:
    return from_step(step, name=step.__name__, order=order, sweep=Steps(0.5, 4), conserves=("energy",))


@pytest.mark.parametrize("case", ["pendulum_simple", "kepler_orbit"])
def test_a_method_that_keeps_the_energy_passes_and_one_that_bounds_its_error_fails(case: str) -> None:
    """The implicit midpoint rule is symplectic, and its energy oscillates."""
    assert outcome("energy", conserving(average_vector_field, 2), case) == Outcome.PASSED
    assert outcome("energy", conserving(planted_right.midpoint, 2), case) == Outcome.FAILED
    assert outcome("energy", conserving(good_rk4.function, 4), case) == Outcome.FAILED


def test_a_rounding_is_carried_to_the_energy_by_its_terms() -> None:
    """A relative change d of the states changes v^2/2 - 1/r by at most d (v^2 + 1/r), by sqrt 2 more component by component;
    the energy of the orbit is -1/2, and both terms are largest near the pericentre, where they are 4 and 2.5."""
    made = trials(good_rk4, "kepler_orbit")
    places, speeds = np.split(made.reference.exact, 2, axis=1)
    terms = np.max(np.sum(speeds**2, axis=1) + 1 / np.linalg.norm(places, axis=1)) / 0.5
    assert 0.99 * terms < carry_roundings(made, ["energy"]) < 1.01 * np.sqrt(2) * terms
    assert terms > 10


def test_energy_is_claimed_where_it_is_declared_and_the_case_keeps_it() -> None:
    why = {
        CLAIMS["energy"].applies(trials(conserving(planted_right.midpoint, 2), "damped_oscillator")),
        CLAIMS["energy"].applies(trials(good_rk4)),
        CLAIMS["energy"].applies(trials(from_solve(planted_methods.seventh, name="x", order=1, conserves=("energy",)))),
    }
    assert len(why) == 3
    assert None not in why


@pytest.mark.parametrize(
    ("engine", "wrong", "tokens", "case"),
    [
        (planted_engines.Fall, planted_engines.EulerFall, (), "projectile_parabola"),
        (
            planted_engines.Line, planted_engines.LeakyLine, ("body_contact", "rigid_impact"),
            "restitution_impact_1d_2d",
        ),
    ],
)  # fmt: skip
def test_an_engine_keeps_the_energy_of_free_bodies_and_of_elastic_impacts(
    engine: Any, wrong: Any, tokens: tuple[str, ...], case: str
) -> None:
    for made, expected in ((engine, Outcome.PASSED), (wrong, Outcome.FAILED)):
        assert outcome("energy", planted_engines.planted(made, *tokens, conserves=("energy",)), case) == expected

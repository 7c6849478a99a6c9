"""The score of a solution: status, errors, drift, and the clock of a formulation."""

import math
import warnings
from fractions import Fraction
from math import exp
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core import accuracy
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.measuring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.measuring.score import Scorer, _to_time, above_text

from gnomon import cases

CASE = cases.get("pendulum_simple").rounded()


@pytest.fixture(scope="module")
def scorer() -> Scorer:
    return Scorer(CASE, None, reference_solution(CaseSpec.of(CASE)))


def test_the_exact_motion_is_ok_and_within_its_floor(scorer: Scorer) -> None:
    row = scorer.score(scorer.reference.exact.copy())
    assert (row["status"], row["error_max"], row["turns"]) == ("ok", 0.0, 0)
    assert row["invariant_drift"]["energy"] < 1e-15


def test_the_summary_has_the_largest_floor_and_conditioning(scorer: Scorer) -> None:
    found = scorer.summary()
    assert found["conditioning"] == max(scorer.reference.conditioning) > min(scorer.reference.conditioning)
    assert found["floor"] == max(scorer.reference.floor) > min(scorer.reference.floor)


def test_a_scorer_takes_its_metric_from_the_reference_solution(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run makes hundreds of scorers before it begins; computing scales and crowded times again would take minutes."""
    limit = cases.get("bouncing_ball", "zeno").rounded().quantities()["t_inf"]
    whole = cases.get("bouncing_ball", e="0.999", span=float(limit) * (1 - 2.0**-30)).rounded()
    metric, known = whole.metric, reference_solution(CaseSpec.of(whole))
    assert metric.crowded
    for name in ("grid_scales", "crowded"):
        monkeypatch.setattr(accuracy, name, pytest.fail)
    found = Scorer(whole.rounded(), None, known).metric
    assert (found.groups, found.positions, found.crowded) == (metric.groups, metric.positions, metric.crowded)


@pytest.mark.parametrize(
    ("error", "status"), [(0.09, "ok"), (0.11, "inaccurate"), (0.99, "inaccurate"), (1.1, "diverged")]
)
def test_thresholds(scorer: Scorer, error: float, status: str) -> None:
    found, reason = scorer.status(np.concatenate((np.zeros(63), [error])))
    assert found == status
    assert (reason == "") == (status == "ok")


def test_an_error_that_the_conditioning_explains_is_ok(scorer: Scorer) -> None:
    exact_ = scorer.reference
    excused = type(exact_)(**{**vars(exact_), "conditioning": np.full(64, 0.2)})
    status, _ = Scorer(CASE, None, excused).status(np.full(64, 1.9))
    assert status == "ok"
    assert Scorer(CASE, None, excused).status(np.full(64, 2.1))[0] == "diverged"


def test_errors_are_compared_with_the_largest_conditioning_up_to_their_time() -> None:
    exact_ = reference_solution(CaseSpec.of(CASE))
    peak = np.full(64, 1e-15)
    peak[10] = 0.2
    excused = Scorer(CASE, None, type(exact_)(**{**vars(exact_), "conditioning": peak}))
    assert excused.status(np.where(np.arange(64) < 10, 0.0, 1.9))[0] == "ok"
    assert excused.status(np.where(np.arange(64) == 9, 1.9, 0.0))[0] == "diverged"


def test_a_measurement_has_errors_and_times_in_the_right_columns(scorer: Scorer) -> None:
    states = scorer.reference.exact.copy()
    (scale,) = (group.scale for group in CASE.metric.groups if group.name == "angular velocity")
    states[[3, 5, 63], 1] += np.array([1e-3, 4e-3, 3e-3]) * scale
    seconds = tuple(np.arange(11) + 1.0)
    row, _ = scorer.measure(Outcome(states, None, None, 7, 21, seconds, 0.5, None), 1e-4)
    # the states are rounded after the addition
    assert row["error_max"] == pytest.approx(4e-3, rel=1e-9)
    assert row["error_start"] == pytest.approx(1e-3, rel=1e-9)
    assert row["error_end"] == pytest.approx(3e-3, rel=1e-9)
    assert row["error_rms"] == pytest.approx(26**0.5 * 1e-3 / 8, rel=1e-9)
    assert row["error_over_tolerance"] == pytest.approx(40, rel=1e-9)
    assert (row["seconds_low"], row["seconds_median"], row["seconds_high"]) == (2.0, 6.0, 10.0)
    assert (row["steps"], row["rhs_calls"], row["repeats"], row["prepare_seconds"]) == (7, 21, 11, 0.5)


def test_states_that_are_not_finite_name_the_time(scorer: Scorer) -> None:
    states = scorer.reference.exact.copy()
    states[10, 1] = math.inf
    row = scorer.score(states)
    assert row["status"] == "diverged"
    assert f"{scorer.reference.times[10]:.6g}" in row["reason"]


def test_very_large_states_are_diverged(scorer: Scorer) -> None:
    assert scorer.score(scorer.reference.exact * 1e200)["status"] == "diverged"
    assert scorer.score(np.full_like(scorer.reference.exact, 1e308))["status"] == "diverged"


def test_a_shift_in_time_is_phase_and_a_larger_swing_is_shape(scorer: Scorer) -> None:
    late = CASE.sample(scorer.reference.times - 1e-4 * CASE.time_scale)
    row = scorer.score(late)
    # along the flow to second order in the shift
    assert row["error_shape"] < 1e-3 * row["error_phase"]
    assert row["error_phase"] >= row["error_max"] * 0.999
    wider = scorer.reference.exact.copy()
    form = scorer._equations
    rates = np.array([form(0.0, tuple(x), scorer.parameters) for x in wider])
    groups = CASE.metric.groups
    scales = np.array([groups[0].scale, groups[1].scale])
    across = (rates / scales)[:, ::-1] * [-1, 1]
    row = scorer.score(wider + 1e-6 * across / np.linalg.norm(across, axis=1, keepdims=True) * scales)
    assert row["error_phase"] < 1e-12
    assert row["error_shape"] == pytest.approx(1e-6, rel=1e-9)


def test_extra_turns_are_counted_apart_from_the_error(scorer: Scorer) -> None:
    states = scorer.reference.exact.copy()
    states[-1, 0] += 4 * math.pi
    row = scorer.score(states)
    assert row["turns"] == 2
    # adding 4 pi rounds theta by an ulp of 16
    assert row["error_max"] < 1e-14


def test_drift_is_relative_and_sees_one_bad_sample(scorer: Scorer) -> None:
    states = scorer.reference.exact.copy()
    states[20, 1] *= 1 + 1e-6
    drift = scorer.drift(states)["energy"]
    omega = scorer.reference.exact[20, 1]
    energy = 2 * 9.81 * math.sin(1.0) ** 2
    assert drift[20] == pytest.approx(omega**2 * 1e-6 / energy, rel=1e-3)
    assert np.max(np.delete(drift, 20)) < 1e-15


def test_an_invariant_that_decays_may_not_grow() -> None:
    case = cases.get("damped_oscillator").rounded()
    decaying = [name for name, invariant in case.invariants.items() if invariant.law == "decays"]
    assert decaying, "the case has one"
    scorer = Scorer(case, None, reference_solution(CaseSpec.of(case)))
    exact = scorer.drift(scorer.reference.exact)[decaying[0]]
    assert np.max(exact) < 1e-15
    grown = scorer.reference.exact.copy()
    grown[30:] = grown[:34]
    assert np.max(scorer.drift(grown)[decaying[0]]) > 1e-3
    # It counts from the lowest so far: the start itself may not be exceeded by the first sample either.
    first = scorer.reference.exact.copy()
    first[0] = 1.001 * np.array([float(x) for x in case.initial_state])
    assert scorer.drift(first)[decaying[0]][0] == pytest.approx(1.001**2 - 1, rel=1e-6)


def test_the_size_of_an_invariant_that_vanishes_is_that_of_its_terms() -> None:
    case = cases.get("kepler_orbit", "parabolic").rounded()
    scorer = Scorer(case, None, reference_solution(CaseSpec.of(case)))
    for name, drift in scorer.drift(scorer.reference.exact * (1 + 1e-6)).items():
        assert np.max(drift) < 1e-4, name
    # Of v^2/2 - mu/r = 0 the terms |x dI/dx| add up to v^2 + mu/r = 3 mu/r, by which this scaling changes it per unit.
    drift = scorer.drift(scorer.reference.exact * (1 + 1e-6))["energy"]
    assert np.max(drift) == pytest.approx(1e-6, rel=1e-5)


@pytest.mark.parametrize(("speed", "by_terms"), [("1.4", False), ("1.4142", True)])
def test_drift_is_relative_to_a_small_invariant_unless_its_terms_cancel(speed: str, by_terms: bool) -> None:
    """v^2/2 - 1/r is -1/50 or -2e-5, with terms of size 3: below a thousandth of the terms, these are the size."""
    case = cases.get("kepler_orbit", initial_state=("1", "0", "0", speed), span=20).rounded()
    scorer = Scorer(case, None, reference_solution(CaseSpec.of(case)))
    moved = scorer.reference.exact * (1 + 1e-6)
    x, y, vx, vy = moved.T
    start = float(speed) ** 2 / 2 - 1
    departure = np.max(np.abs((vx**2 + vy**2) / 2 - 1 / np.hypot(x, y) - start))
    found = np.max(scorer.drift(moved)["energy"])
    if by_terms:
        assert found < departure  # over 3, the largest size of the terms, less the part that 64 samples miss
    else:
        assert found == pytest.approx(departure / abs(start), rel=1e-6)


def test_an_invariant_that_leaves_binary64_has_no_size_and_no_warning(scorer: Scorer) -> None:
    def bursting(t: Any, state: Any, parameters: Any) -> Any:
        return (exp(1000 * t) * state[0],)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not math.isfinite(scorer._size(bursting, 0.0))


def test_an_invariant_that_is_always_zero_drifts_by_its_own_value() -> None:
    """For example the angular momentum of a fall into the centre: its terms are zero too."""
    case = cases.get("kepler_orbit", "plunge").rounded()
    scorer = Scorer(case, None, reference_solution(CaseSpec.of(case)))
    assert np.max(scorer.drift(scorer.reference.exact)["angular_momentum"]) == 0.0
    aside = scorer.reference.exact.copy()
    aside[:, 3] += 1e-6
    assert np.max(scorer.drift(aside)["angular_momentum"]) == pytest.approx(1e-6 * np.max(aside[:, 0]), rel=1e-9)


@pytest.mark.parametrize(
    ("name", "apart"), [("forced_oscillator", False), ("bouncing_ball", False), ("euler_top", True)]
)
def test_phase_and_shape_are_defined_for_smooth_motions_that_nothing_drives(name: str, apart: bool) -> None:
    """In the others an error along the flow is not an error in time."""
    case = cases.get(name).rounded()
    scorer = Scorer(case, None, reference_solution(CaseSpec.of(case)))
    assert np.all(np.isfinite(scorer.split(scorer.reference.exact * (1 + 1e-9)))) == apart


def test_one_step_of_the_formulation_corrects_the_clock() -> None:
    def equations(s: float, y: tuple[float, ...], parameters: tuple[float, ...]) -> tuple[float, ...]:
        x, _ = y
        return x * (2 + x), 2 + x  # dx/dt = x

    start, wanted = (math.e**0.3, 0.3), 0.3 + 1e-3
    x, t = _to_time(equations, (), start, 1, wanted)
    assert abs(t - wanted) <= math.ulp(wanted)
    # the fifth power of the step, with a constant of about one
    assert x == pytest.approx(math.exp(wanted), rel=1e-14)


def test_a_formulation_is_scored_like_the_case() -> None:
    case = cases.get("kepler_orbit").rounded()
    formulation = next(f for f in case.formulations if f.clock is not None)
    scorer = Scorer(case, formulation, reference_solution(CaseSpec.of(case, formulation)))
    # The encoded start is the case's own and a clock: its rounding has the effect of half an ulp in each component.
    effects = [reference_solution(CaseSpec.of(case)).conditioning]
    times = case.times.tolist()
    for index, value in enumerate(case.initial_state):
        if value != 0:
            moved = [*case.initial_state]
            moved[index] += Fraction(math.ulp(float(value))) / 2
            other = case.with_numbers(moved, case.parameters)
            pairs = [(other.exact(t, 40), case.exact(t, 40)) for t in times]
            differences = np.array([[float(x - y) for x, y in zip(a, b, strict=True)] for a, b in pairs])
            by_group = case.metric.by_group(differences, np.zeros_like(differences))
            effects.append(np.max(list(by_group.values()), axis=0))
    expected = np.sqrt(np.sum(np.square(effects), axis=0))
    np.testing.assert_allclose(
        scorer.reference.conditioning, expected, rtol=1e-6
    )  # curvature over half an ulp is far below
    assert not np.allclose(np.diff(scorer.reference.problem_times), scorer.reference.problem_times[0])
    start = scorer.reference.start
    decoded = formulation.decode(start[np.newaxis], scorer.parameters)[0]
    np.testing.assert_allclose(decoded, [float(x) for x in case.initial_state], rtol=0, atol=1e-15)


def test_a_start_at_the_edge_of_the_domain_of_decode_is_perturbed_inward() -> None:
    case = cases.get("cycloidal_pendulum", "cusp_to_cusp").rounded()
    (formulation,) = case.formulations
    found = reference_solution(CaseSpec.of(case, formulation))
    assert np.all(np.isfinite(found.conditioning))
    assert np.all(found.conditioning >= reference_solution(CaseSpec.of(case)).conditioning * (1 - 1e-12))


@pytest.mark.parametrize("limit", [0.1, 1.0, 50.0])
def test_a_value_above_a_limit_reads_as_one(limit: float) -> None:
    """ "error 1, above 1" would be a contradiction: the value has as many digits as needed."""
    for excess in (1e-15, 1e-9, 0.004, 0.3, 7.0):
        value = limit * (1 + excess)
        text = above_text(value, limit)
        assert float(text) > limit
        assert float(text) == pytest.approx(value, rel=0.05)
    assert above_text(1.0345, 1.0) == "1.03"


def test_errors_over_turned_starts_are_those_of_the_start_in_the_middle() -> None:
    """Each solution is compared with the exact motion from its own start."""
    case = cases.get("kepler_orbit").rounded()
    known = reference_solution(CaseSpec.of(case))
    scorer = Scorer(case, None, known)
    count = len(known.turned)
    assert count >= 8
    sizes = np.array([3e-7, 1e-3, 2e-9, 5e-5, 4e-12, 6e-6, 7e-8, 8e-4, 9e-2])[:count]
    answers = known.turned_exact.copy()
    answers[:, :, 0] += (sizes * scorer.metric.groups[0].scale)[:, np.newaxis]
    outcome = Outcome(known.exact, None, None, 1, 4, (0.001,), 0.0, None, null_seconds=1e-5, turned=answers)
    row, states = scorer.measure(outcome, 1e-6)
    assert row["error_max"] == pytest.approx(np.median(sizes), rel=1e-6)
    assert row["error_over_tolerance"] == pytest.approx(np.median(sizes) / 1e-6, rel=1e-6)
    assert (row["error_low"], row["error_high"]) == (pytest.approx(4e-12, rel=1e-3), pytest.approx(9e-2, rel=1e-6))
    assert (row["turned_starts"], row["null_seconds"]) == (count, 1e-5)
    assert row["error_unturned"] < 1e-15, "the error of the timed call, from the start that is not turned"
    assert states is not answers
    np.testing.assert_array_equal(states, known.exact)


@pytest.mark.parametrize("lost", ["own", "turned", "both"])
def test_a_start_whose_solution_is_not_finite_decides_the_status(lost: str) -> None:
    """The median over the turned starts is finite in each of these: it would be ok, with an error of zero."""
    case = cases.get("kepler_orbit").rounded()
    known = reference_solution(CaseSpec.of(case))
    own, answers = known.exact.copy(), known.turned_exact.copy()
    if lost != "turned":
        own[20:] = math.nan
    if lost != "own":
        answers[:4, 7:] = math.inf
    outcome = Outcome(own, None, None, 1, 4, (0.001,), 0.0, None, turned=answers)
    row, _ = Scorer(case, None, known).measure(outcome, 1e-6)
    assert row["status"] == "diverged"
    assert math.isnan(row["error_max"])
    assert "error_over_tolerance" not in row
    assert row.get("error_end") is None, "no error of a start that is not the recorded one"
    assert row["turned_starts"] == len(answers)
    assert row["error_low"] < 1e-15
    assert math.isnan(row["error_high"]) == (lost != "own")
    assert ("turned starts" in row["reason"]) == (lost == "turned")


def test_where_an_integrator_stopped_stands_before_what_it_led_to(scorer: Scorer) -> None:
    states = scorer.reference.exact.copy()
    states[10:] = math.nan
    row, _ = scorer.measure(Outcome(states, "step below an ulp at t = 1", None, 1, 4, (0.001,), 0.0, None), None)
    assert row["reason"].startswith("step below an ulp at t = 1; states are not finite from t = ")

"""A diagnosis names the cause of a fault whose cause is known, and names no cause for a right method."""

import measure
import numpy as np
import pytest
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.verification.claims import DEPTHS
from gnomon.harness.verification.diagnosis import HISTORY, Failures, conclude, probe
from gnomon.harness.verification.verify import verify

from gnomon import cases
from gnomon.verify import Steps, from_solve, from_step

BOTH = ("pendulum_simple", "forced_oscillator")
ORDER = ("step_order", "order_short")
TIGHT = ("tolerance_short", "proportional")
CAUSES = (
    ("rk4: the last slope at the middle", "time", BOTH, ORDER),
    ("verlet: the half kick at the end is left out", "order", BOTH[:1], ORDER),
    ("dormand_prince: states are printed with seven digits", "precision", BOTH[:1], TIGHT),
    ("dormand_prince: samples are one sample early", "shift", BOTH[:1], TIGHT),
    ("dormand_prince: the tolerance is a constant", "tolerance", BOTH[:1], TIGHT),
    ("dormand_prince: the step size is kept between runs", "history", BOTH[:1], ("history", *TIGHT)),
    ("dormand_prince: linear interpolation", "dense", BOTH[:1], ("dense", *TIGHT)),
    ("bogacki_shampine: the last step is not shortened", "late", BOTH[:1], TIGHT),
    ("ensemble: the motions are returned in reverse", "ensemble", BOTH[:1], (*ORDER, "ensemble")),
    ("quaternion: the norm is the sum of sizes", "left", ("euler_top",), ORDER),
    ("rk4: single precision inside", "precision", BOTH[:1], ORDER),
    ("LeapfrogEngine: the force on the partner is left out", "component", ("kepler_orbit", "two_body"), ORDER),
    ("rk4_events: the reset is left out", "events", ("bouncing_ball",), ("event_order",)),
)  # fmt: skip
"""(fault, cause, cases, claims): a few claims that show it, so that it takes seconds."""


SLOW = ("quaternion", "LeapfrogEngine", "bogacki_shampine", "ensemble")
"""Methods whose solutions take long."""


@pytest.mark.parametrize(
    ("fault", "cause", "names", "claims"),
    [pytest.param(*row, id=row[0], marks=[pytest.mark.slow] if row[0].startswith(SLOW) else []) for row in CAUSES],
)
def test_the_cause_of_a_fault_is_named(fault: str, cause: str, names: tuple[str, ...], claims: tuple[str, ...]) -> None:
    mutant = next(mutant for mutant in measure.faulty() if mutant.id == fault)
    report = verify(mutant.integrator(), names, "low", claims, workers=1)
    assert report.diagnosis is not None, [(row.claim, row.case, row.finding) for row in report.rows]
    assert report.diagnosis.partition(": ")[0] == cause, report.diagnosis


def test_a_right_method_has_no_diagnosis() -> None:
    assert verify(measure.right()["rk4"], BOTH, "low", ORDER, workers=1).diagnosis is None


PENDULUM, FORCED = (cases.get(name) for name in BOTH)


def test_the_time_is_named_only_where_claims_of_accuracy_pass_without_it() -> None:
    """An integrator that is wrong on all motions is wrong on forced motions too."""
    on = {"pendulum_simple": PENDULUM, "forced_oscillator": FORCED}
    found = {"steps": True, "stepped": True, "order": 4, "alone": {}}
    wrong = frozenset({("order", "forced_oscillator")})
    passed = frozenset({("order", "pendulum_simple")})
    assert (conclude(Failures(wrong, passed, on), found) or "").startswith("time: ")
    for failed in (wrong | passed, wrong):
        assert conclude(Failures(failed, frozenset(), on, ("h^1.03 (2 to 1)",)), found) == (
            "order: it converges with order 1.0 where 4 is declared: a coefficient, a sign or a term of the formula is wrong"
        )


def test_bits_that_depend_on_earlier_calls_are_named_first() -> None:
    """States computed after a change of the start, or from data that another call left, say nothing of the method."""
    on = {"pendulum_simple": PENDULUM}
    failures = Failures(frozenset({("order", "pendulum_simple")}), frozenset(), on)
    found = {"steps": True, "stepped": True, "order": 4, "bits": "a", "bits_again": "a", "still": True}
    assert (conclude(failures, found | {"alone": {"bits": "b"}}) or "").startswith(HISTORY)
    assert (conclude(failures, found | {"alone": {"bits": "a"}}) or "").startswith("still: ")
    assert (conclude(failures, found | {"alone": {}, "changed_start": True}) or "").startswith("input: ")


def leapfrog(f, t, y, h):  # type: ignore[no-untyped-def]
    """Leapfrog with velocities in the force: right where q' = v, of order 1 where forces depend on velocities."""
    n = len(y) // 2
    half = y[n:] + h / 2 * f(t, y)[n:]
    place = y[:n] + h * half
    return np.concatenate([place, half + h / 2 * f(t + h, np.concatenate([place, half]))[n:]])


def midpoint(f, t, y, h):  # type: ignore[no-untyped-def]
    return y + h * f(t + h / 2, y + h / 2 * f(t, y))


def kahan(f, t0, y0, times, step):  # type: ignore[no-untyped-def]
    """Euler's method with compensated sums, whose residuals begin anew after each sample."""
    y, found, t = y0, [], t0
    for end in times:
        rest, count = 0 * y, max(1, round((end - t) / step))
        for k in range(count):
            change = (end - t) / count * f(t + k * (end - t) / count, y) + rest
            y, rest = y + change, change - ((y + change) - y)
        t = end
        found.append(y)
    return np.array(found)


def interpolated(f, t0, y0, times, tolerance):  # type: ignore[no-untyped-def]
    """Simpson's rule with steps that end at the last sample, and straight lines between them."""
    count = 4 * round(tolerance**-0.25)
    ends = np.linspace(t0, times[-1], count + 1)
    states, h = [y0], (times[-1] - t0) / count
    for t in ends[:-1]:
        y = states[-1]
        states.append(y + h / 6 * (f(t, y) + 4 * f(t + h / 2, y + h / 2 * f(t, y)) + f(t + h, y + h * f(t, y))))
    return np.array([np.interp(times, ends, column) for column in np.array(states).T]).T


def fault(name: str) -> Integrator:
    return next(mutant for mutant in measure.faulty() if mutant.id == name).integrator()


LEAP = from_step(leapfrog, name="leapfrog", order=2)
SUMS = from_solve(kahan, name="sums", order=1, sweep=Steps(0.125, 8))
type(SUMS).compensated = True
PROBED = (
    (LEAP, {"other_problems"}, "form"),
    (LEAP, {"order_short", "step_order", "quadrature"}, "form"),
    (SUMS, {"compensated"}, "compensation"),
    (fault("radau3: one iteration of Newton's method"), {"order_short"}, "iteration"),
    (fault("radau3: the iteration stops at 1e-4"), {"more_variables"}, "iteration"),
    (from_solve(interpolated, name="lines", order=3), {"quadrature"}, "dense"),
    (from_step(midpoint, name="midpoint", order=4), {"order_short"}, "order"),
    (from_step(midpoint, name="midpoint", order=2), {"quadrature"}, "quadrature"),
)  # fmt: skip


@pytest.mark.parametrize(("integrator", "claims", "cause"), PROBED)
def test_a_small_problem_shows_the_cause(integrator: Integrator, claims: set[str], cause: str) -> None:
    """The claims are those that the method fails; the last two methods are explicit and keep to their equations."""
    trials = Trials.of(integrator, CaseSpec.of(PENDULUM.rounded()), DEPTHS["low"])
    failed = frozenset((claim, "pendulum_simple") for claim in claims)
    on = {"pendulum_simple": PENDULUM}
    got = ("h^2.00 (2 to 1)",) if "order_short" in claims else ()
    failures = Failures(failed, frozenset({("follows", "pendulum_simple"), ("error", "pendulum_simple")}), on, got)
    found = probe(trials) | {"order": integrator.order, "stepped": True, "steps": trials.steps, "alone": {}}
    text = conclude(failures, found) or ""
    assert text.partition(": ")[0] == cause, text


def test_a_method_that_differentiates_by_differences_is_told_to_declare_it() -> None:
    """The rounding of a difference is no fault of a weight."""
    declared = measure.right()["rodas4"]
    undeclared = type("Undeclared", (type(declared),), {"jacobian": "exact"})()
    claims = ("quadrature", "order_short")
    report = verify(undeclared, BOTH[:1], "low", claims, workers=1)
    assert report.diagnosis is not None
    assert report.diagnosis.startswith("quadrature: it differentiates f by differences")
    assert verify(declared, BOTH[:1], "low", claims, workers=1).diagnosis is None

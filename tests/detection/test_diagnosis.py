"""A diagnosis names the cause of a fault whose cause is known, and names no cause for a right method."""

import measure
import pytest
from gnomon.harness.verification.diagnosis import HISTORY, Failures, conclude
from gnomon.harness.verification.verify import verify

from gnomon import cases

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

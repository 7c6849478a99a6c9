"""An answer is used only where it is a Solution of real states, with counts, and no more work than a processor can do."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from gnomon.harness.contract import validation
from gnomon.harness.contract.integrator import Solution
from gnomon.harness.contract.validation import Unusable

SHAPE = (1, 2, 3)
STATES = np.zeros(SHAPE)


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (None, "NoneType, not a Solution"),
        (Solution(STATES[:, :1]), r"states of shape \(1, 1, 3\), not \(1, 2, 3\)"),
        (Solution(STATES + 1e-3j), r"complex states \(imaginary parts up to 0.001\)"),
        (Solution(STATES.astype(str)), "states of type <U.*not real numbers"),
        (Solution(STATES, 10**30), r"steps = 1000.*a whole number from 0 to 2\^53"),
        (Solution(STATES, 10**400), r"steps = 1000.*a whole number from 0 to 2\^53"),
        (Solution(STATES, 10**5000), r"steps = <int .* whole number from 0 to 2\^53"),
        (Solution(STATES, Fraction(10**400, 3)), r"steps = Fraction.* whole number from 0 to 2\^53"),  # type: ignore[arg-type]
        (Solution(STATES, -5), "steps = -5: a count"),
        (Solution(STATES, np.nan), "steps = nan: a count"),  # type: ignore[arg-type]
        (Solution(STATES, stopped=17), "stopped = 17"),  # type: ignore[arg-type]
        (Solution(STATES, events=((np.nan, "bounce"),)), "a pair .time, name. with a finite time"),
        (Solution(STATES, events=((10**400, "bounce"),)), "a pair .time, name. with a finite time"),
    ],
)
def test_an_answer_that_is_no_solution_is_named(answer: Any, says: str) -> None:
    with pytest.raises(Unusable, match=says):
        validation.check(answer, SHAPE)


def test_numbers_of_numpy_are_counts_too_and_complex_states_may_be_real() -> None:
    found = validation.check(Solution(STATES.astype(np.float32), np.int32(7), None, [(1, "x")]), SHAPE)  # type: ignore[arg-type]
    assert (found.steps, found.states.dtype, found.events) == (7, np.float64, ((1.0, "x"),))
    assert validation.check(Solution(STATES + 0j), SHAPE).states.dtype == np.float64


@pytest.mark.parametrize(("count", "seconds", "fits"), [(10**9, 1e-3, False), (10**9, 0.1, True), (64, 0.0, True)])
def test_more_right_hand_sides_than_a_processor_can_do_are_named(count: int, seconds: float, fits: bool) -> None:
    if fits:
        validation.possible(count, seconds, "right-hand sides")
        return
    with pytest.raises(Unusable, match=r"claims 1000000000 right-hand sides in 0.001 s: one takes 1e-11 s at least"):
        validation.possible(count, seconds, "right-hand sides")

"""A failure of an integrator has one reason, whichever panel or claim solves with it."""

from typing import Any

import pytest
from changed_methods import changed
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.stability.digits import count_lost
from gnomon.harness.stability.relations import relations
from gnomon.harness.stability.stiffness import stiffness
from gnomon.harness.stability.subjects import trials_of
from gnomon.harness.stability.tolerance import proportionality


@pytest.mark.parametrize(
    ("error", "reason"),
    [(Refused("too stiff"), "too stiff"), (ZeroDivisionError("a\nb"), "ZeroDivisionError: a b")],
)
def test_a_failure_has_one_reason(error: Exception, reason: str) -> None:
    def fails(states: Any) -> Any:
        raise error

    broken = changed(states=fails)
    trials = trials_of(broken, "pendulum_simple")
    found = (
        trials.whole(1e-6).why,
        count_lost(trials, 1.0)["failed"],
        proportionality(trials, 0.1)["why"],
        relations.measured(broken, 0.1)["refused"].partition(": ")[2],
        stiffness.measured(broken, 0.1)["refused"],
    )
    assert set(found) == {reason}

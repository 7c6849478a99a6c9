"""Every integrator refuses a setting that is neither a step size nor a tolerance, before it calls its library."""

import pytest
from gnomon.harness.contract.integrator import Refused, solver_of
from gnomon.harness.contract.problem import find_accepted_form, problem_of
from gnomon.harness.registry import lookup
from gnomon.harness.verification.call_claims import IMPOSSIBLE

from gnomon import cases

CASES = ("pendulum_simple", "kepler_orbit", "bouncing_ball", "euler_top", "holonomic_constraint_dae")
OTHERS = {one.id: one for one in lookup.own().values() if type(one).__module__.startswith("gnomon.harness.adapters.")}


@pytest.mark.parametrize("name", OTHERS)
def test_an_impossible_setting_is_refused(name: str) -> None:
    """SciPy's Runge-Kutta methods would take steps for ever with a tolerance of nan, and REBOUND's go on with any."""
    one = OTHERS[name]
    if lookup.missing(one) is not None:
        pytest.skip(str(lookup.missing(one)))
    offered = [cases.get(name).rounded() for name in CASES]
    case = next(case for case in offered if find_accepted_form(case, one.accepts) is not None)
    for setting in IMPOSSIBLE:
        with pytest.raises(Refused, match="is not a positive number"):
            solver_of(one, problem_of(case, one.accepts), setting)

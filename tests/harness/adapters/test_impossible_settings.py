"""No library is given a setting that is no positive number: some replace it by one of their own, without a word."""

from __future__ import annotations

import math

import pytest
from gnomon.harness.contract.integrator import Integrator, Refused, solver_of
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.registry import lookup
from gnomon.harness.verification.verify import planned

OTHERS = [i for i in lookup.everything().values() if i.library not in ("gnomon", "pybullet")]


@pytest.mark.parametrize("integrator", OTHERS, ids=lambda integrator: integrator.id)
@pytest.mark.parametrize("setting", [0.0, -1e-3, math.nan, math.inf])
def test_a_setting_that_is_no_positive_number_is_refused(integrator: Integrator, setting: float) -> None:
    if lookup.missing(integrator) is not None:
        pytest.skip(f"{integrator.library} is not installed")
    case, _ = planned(integrator, None, "low")[0]
    with pytest.raises(Refused):
        solver_of(integrator, problem_of(case, integrator.accepts), setting)

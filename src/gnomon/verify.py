"""Verify an integrator of your own against exact motions.

`from_step` and `from_solve` make an integrator from a plain function; `verify` verifies it:

    from gnomon.verify import from_step
    mine = from_step(step, name="RK4", order=4)      # step(f, t, y, h) -> y at t + h

and then `gnomon verify package.module:mine`.
"""

from gnomon.cases.core.scene import IDENTITY, Readings
from gnomon.harness.contract.integrator import Refused, Steps, Tolerance
from gnomon.harness.verification.claim_tests import assert_follows, parametrize
from gnomon.harness.verification.engine_adapter import from_engine
from gnomon.harness.verification.function_adapter import from_solve, from_step
from gnomon.harness.verification.program_adapter import from_command
from gnomon.harness.verification.verify import CLAIMS, FirstTrialError, Report, verify

__all__ = [
    "CLAIMS",
    "IDENTITY",
    "FirstTrialError",
    "Readings",
    "Refused",
    "Report",
    "Steps",
    "Tolerance",
    "assert_follows",
    "from_command",
    "from_engine",
    "from_solve",
    "from_step",
    "parametrize",
    "verify",
]

"""The one way to an outcome: an integrator solves a problem at a setting from starts, or fails with a status and a reason."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from gnomon.harness.contract import validation
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solution
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.failures import status_of
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.system.supervisor import within


@dataclass(frozen=True)
class Solved:
    """The outcome of one call of `solve`: a solution, or None with the status and the reason of the failure.

    `calls`: the number of right-hand sides, 0 where the problem does not count them.
    """

    status: Status
    reason: str = ""
    solution: Solution | None = None
    calls: int = 0

    @property
    def whole(self) -> Solution:
        """The solution to the end of the span. Raises Refused for a failure, and for an integration that ended early."""
        if self.solution is None or self.solution.stopped is not None:
            raise Refused(self.reason if self.solution is None else self.solution.stopped)
        return self.solution

    @property
    def states(self) -> Floats:
        """The states (n, samples, dim), which may end early. Raises Refused for a failure."""
        if self.solution is None:
            raise Refused(self.reason)
        return self.solution.states


def solve_within(
    integrator: Integrator,
    problem: Problem,
    setting: float,
    starts: Floats,
    moves: bool = False,
    limit: float = math.inf,
) -> Solved:
    """The outcome from starts (n, dim), by one `prepare` and one `solve`, within `limit` seconds of processor time.

    If the exact motion `moves`, a solution that equals a start at all samples is refused.
    """

    def call() -> tuple[Solution, int]:
        late = Refused(f"no answer within {limit:g} s of processor time")
        with within(limit, late), Prepared(integrator, problem, setting) as solver:
            answer = solver.counted(starts)
        if moves:
            validation.require_motion(answer[0].states, starts)
        return answer

    return outcome(call)


def outcome(call: Callable[[], tuple[Solution, int]]) -> Solved:
    """The outcome of a call that returns a solution and the number of right-hand sides."""
    try:
        return Solved(Status.OK, "", *call())
    except Exception as error:  # the user's code may raise anything
        return Solved(*status_of(error))

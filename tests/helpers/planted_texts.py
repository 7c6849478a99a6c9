"""Integrators whose messages would steer a terminal, and the log of GitHub Actions."""

from collections.abc import Callable
from typing import Any

from gnomon.harness.contract.integrator import Problem, Solution
from planted import Sound, runge_kutta

MESSAGE = "λ\x1b]0;stolen\x07\x1b[31m\n::error::stolen\n  ::add-mask::a ##[error]stolen\r\x9b2J"


class RaisesText(Sound):
    """Raises the message in each trial."""

    name = "raises text"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        raise ValueError(MESSAGE)


class RaisesTextAtSmallSteps(Sound):
    """Raises the message from the sixth setting on."""

    name = "raises text at small steps"

    def prepare(self, problem: Problem, setting: float) -> Callable[[Any], Solution]:
        if round(problem.interval / setting) >= 64:
            raise ValueError(MESSAGE)
        return runge_kutta(problem, setting)

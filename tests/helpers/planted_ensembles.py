"""Integrators of pendulums whose error from every start is known, for tests of ensembles."""

import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.cases.core.forms import SecondOrder
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solution, Tolerance
from gnomon.reference.pendulums.pendulum_ensemble import states

MARK = "ended"
"""The file in the working directory by which `EndsOnce` records that it has ended a process."""

FIRST, ANSWERED = "first", "answered"
"""The files by which a test tells `EndsLate` in which block to end its process, and that another part was answered."""


class Off(Integrator):
    """The exact state, with an angular velocity that is wrong by 1e-10 to 1e-2, more from larger angles."""

    name, library, order = "off", "planted", 1
    accepts = (SecondOrder,)
    sweep = Tolerance()

    def prepare(self, problem: Problem, setting: float) -> Any:
        def solve(starts: Floats) -> Solution:
            found, _ = states(np.tile(problem.parameters, (len(starts), 1)), starts, problem.times)
            found[:, :, 1] += self.wrong(starts)[:, np.newaxis]
            return Solution(found)

        return solve

    def wrong(self, starts: Floats) -> Floats:
        return np.asarray(10 ** (-10 + 4 * (starts[:, 0] + 7) / 7))


class WrongBackwards(Off):
    """Right but for a hundredth of the starts, the fastest that turn backwards, where it is wrong by 0.01 rad/s."""

    name = "wrong backwards"

    def wrong(self, starts: Floats) -> Floats:
        return np.where(starts[:, 1] < -7.84, 0.01, 1e-12)


class SharesSteps(Off):
    """The answer from each start depends on all starts of the call, as where lanes of a vector share their steps."""

    name = "shares steps"

    def wrong(self, starts: Floats) -> Floats:
        return np.asarray(1e-6 * (1 + np.abs(np.mean(starts)))) * np.ones(len(starts))


class Fails(Off):
    """Declines angles above 6 and raises below -6, and with it every other start of the call; nan from fast starts."""

    name = "fails"

    def wrong(self, starts: Floats) -> Floats:
        if np.any(starts[:, 0] > 6):
            raise Refused("angles above 6 rad")
        if np.any(starts[:, 0] < -6):
            raise ArithmeticError("below -6 rad")
        return np.where(np.abs(starts[:, 1]) > 7, np.nan, 1e-9)


class EndsOnce(Off):
    """Kills its process once, in the middle of an ensemble."""

    name = "ends once"

    def wrong(self, starts: Floats) -> Floats:
        mark = Path(MARK)
        if len(starts) == 256 and not mark.exists():  # not in the probe
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return super().wrong(starts)


class EndsLate(Off):
    """Kills its process once: in the block whose first angle is in the file FIRST, when the file ANSWERED is there."""

    name = "ends late"

    def wrong(self, starts: Floats) -> Floats:
        mark, limit = Path(MARK), time.monotonic() + 60
        if float(starts[0, 0]).hex() == Path(FIRST).read_text() and len(starts) == 256 and not mark.exists():
            while not Path(ANSWERED).exists() and time.monotonic() < limit:
                time.sleep(0.01)
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return super().wrong(starts)


class EndsAlways(Off):
    name = "ends always"

    def wrong(self, starts: Floats) -> Floats:
        os.kill(os.getpid(), signal.SIGKILL)
        return starts


INTEGRATORS = (Off, WrongBackwards, SharesSteps, Fails, EndsOnce, EndsLate, EndsAlways)

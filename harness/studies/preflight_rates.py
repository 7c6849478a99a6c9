"""Run an engine in a pre-flight, and compare the rates of change that its small steps show with equations of motion."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, solver_of
from gnomon.harness.studies.preflight_scenes import Rates

ROUNDINGS = 64
"""Roundings of a step, each by the unit round-off of the largest number."""
STATES = 16
TINY = float(np.finfo(float).tiny)
UNSETTLED = 2.0**-6
"""Rates that steps of h/2 and h/4 give may differ by this share."""


@dataclass(frozen=True)
class Engine:
    """An integrator of scenes with what the checks need to run it."""

    integrator: Integrator

    @property
    def bits(self) -> int:
        """The bits of the significand of the engine's numbers: 53, or 24 for binary32."""
        return int(getattr(self.integrator, "bits", 53))

    @property
    def rounding(self) -> float:
        """The rounding of one step, relative to the largest number."""
        return ROUNDINGS * 2.0**-self.bits

    def solve(self, form: SceneForm, starts: Sequence[Floats], times: Sequence[float], step: float) -> Floats:
        """States after each start at each time, shape (starts, times, dimension), from a new world."""
        return self.run(Problem(form, len(starts[0]), np.empty(0), np.array(times), 1.0), starts, step)

    def run(self, problem: Problem, starts: Sequence[Floats] | Floats, step: float) -> Floats:
        solver = solver_of(self.integrator, problem, step)
        try:
            return solver(np.array(starts)).states
        finally:
            solver.close()


def rate_error(
    engine: Engine,
    problem: Problem,
    rates: Rates,
    starts: Floats,
    groups: Sequence[Sequence[int]],
    angles: Sequence[bool] | None = None,
    turning: Sequence[float] | None = None,
) -> tuple[float, float, str]:
    """The largest error of the rates of change, relative to their size in a group of coordinates, over its bound.

    `angles`: the coordinates whose whole turns are ignored. `turning`: for each group the size that its numbers have in an
    attitude, whose entries are of size 1, however small an angle is; 0 for lengths. The text `acceleration` of `TEXTS` has the bound.
    """
    longest = problem.time_scale * 2.0 ** -(engine.bits // 4)
    estimates = []
    for step in (longest, longest / 2, longest / 4):
        change = engine.run(replace(problem, times=np.array([problem.t0 + step])), starts, step)[:, 0] - starts
        if angles is not None:
            change[:, angles] = np.remainder(change[:, angles] + np.pi, 2 * np.pi) - np.pi
        estimates.append(change / step)
    coarse, fine = 2 * estimates[1] - estimates[0], 2 * estimates[2] - estimates[1]
    expected = np.array([rates(problem.t0, start) for start in starts])
    worst = -1.0, 0.0, 0.0, ""
    for members, natural in zip(map(list, groups), turning or [0.0] * len(groups), strict=True):
        largest = np.max(np.linalg.norm(starts[:, members], axis=1))
        size = np.maximum(np.linalg.norm(expected[:, members], axis=1), largest / problem.time_scale)
        size[size == 0] = 1.0
        spread = np.linalg.norm((fine - coarse)[:, members], axis=1) / size
        error = np.linalg.norm((fine - expected)[:, members], axis=1) / size
        bound = spread + 10 * engine.rounding * max(largest, natural) / (longest * size)
        for each, most, unsettled in zip(error.tolist(), bound.tolist(), spread.tolist(), strict=True):
            if unsettled > UNSETTLED:
                judged = unsettled, UNSETTLED, "difference of the rates from steps of h/2 and h/4, relative"
            else:
                judged = each, most, "error of the rates of change, relative"
            # Numbers that are not finite are worst, and 0 / 0 is right.
            quotient = judged[0] / max(judged[1], TINY) if math.isfinite(judged[0]) else math.inf
            worst = max(worst, (quotient, *judged))
    return worst[1:]

"""The fast Gauss method against heyoka at equal error, in pairs in one process.

Each integrator is swept over its one knob, the tolerance; its time at an error is interpolated between the two settings
around it, at the tight end of the sweep, where the errors last pass through it. The error is the maximum over the
samples, in the metric of the case; the equations, the formulation and the samples are the same for both.
`extra_info` of each benchmark holds milliseconds of both and their ratio at 1e-6, 1e-9 and 1e-12; null: not reached.
"""

from __future__ import annotations

import gc
import math
from collections.abc import Callable, Sequence
from time import perf_counter_ns
from typing import Any

import numpy as np
import pytest
from gnomon.cases.registry import get
from gnomon.harness.adapters.heyoka import Taylor
from gnomon.harness.integrator import Integrator
from gnomon.harness.integrators.gauss_fast import GaussFast
from gnomon.harness.problem import initial_state, problem_of

ERRORS = (1e-6, 1e-9, 1e-12)
TOLERANCES = [10.0 ** (-k / 2) for k in range(4, 32)]
REPEATS = 15

SCENES = [
    ("pendulum_simple", "speed", False),
    ("kepler_orbit", "speed_e06", False),
    ("kepler_orbit", "speed_e06", True),
    ("kepler_orbit", "speed_e099", True),
    ("lagrange_top_attitude", "speed", False),
    ("euler_top", "speed", False),
    ("forced_oscillator", "speed", False),
]


@pytest.mark.parametrize(
    ("name", "variant", "sundman"), SCENES, ids=lambda x: ("sundman" if x else "t") if isinstance(x, bool) else x
)
def test_against_heyoka(benchmark: Any, name: str, variant: str, sundman: bool) -> None:
    pytest.importorskip("heyoka", reason="heyoka is optional: pip install 'gnomon[peers]'")
    case = get(name, variant).rounded()
    formulation = case.formulations[0] if sundman else None
    start, exact = initial_state(case, formulation)[None], case.sample(case.times)

    def prepared(integrator: Integrator) -> list[tuple[float, Callable[[Any], Any]]]:
        problem = problem_of(case, integrator.accepts, formulation)
        found = []
        for tolerance in TOLERANCES:
            solve = integrator.prepare(problem, tolerance)
            solution = solve(start.copy())
            if solution.stopped is None:
                states = solution.states[0][:, : exact.shape[1]]
                found.append((float(np.max(case.metric.distance(states, exact))), solve))
        return found

    pair = [prepared(GaussFast()), prepared(Taylor())]
    milliseconds = interleaved([[solve for _, solve in side] for side in pair], start)
    rows = {}
    for error in ERRORS:
        ours, peer = (
            at_error(error, [e for e, _ in side], times) for side, times in zip(pair, milliseconds, strict=True)
        )
        rows[f"{error:g}"] = {"gauss": ours, "heyoka": peer, "ratio": peer / ours if ours and peer else None}
    benchmark.extra_info["at_equal_error"] = rows
    benchmark(next(solve for error, solve in pair[0] if error < ERRORS[0]), start)
    assert any(row["ratio"] for row in rows.values()), "neither comparison was possible"


TRAJECTORIES = 10_000
ENSEMBLE_TOLERANCES = [10.0 ** (-k / 2) for k in range(14, 27, 2)]
TURNS = 3


def test_an_ensemble_against_heyoka_in_batches(benchmark: Any) -> None:
    """1e4 pendulums of different amplitude, both on all the cores that this process may use, microseconds each.

    The error is the largest of eight of them, spread over the amplitudes.
    """
    pytest.importorskip("heyoka", reason="heyoka is optional: pip install 'gnomon[peers]'")
    case = get("pendulum_simple", "speed").rounded()
    starts = np.column_stack([np.linspace(0.5, 2.5, TRAJECTORIES), np.zeros(TRAJECTORIES)])
    judged = np.linspace(0, TRAJECTORIES - 1, 8).astype(int)
    span = float(case.span)
    exact = [get("pendulum_simple", "speed", tuple(starts[i].tolist()), span).rounded() for i in judged]
    truth = [own.sample(case.times) for own in exact]
    sides: list[tuple[list[float], list[Callable[[Any], Any]]]] = []
    for integrator in (GaussFast(), Taylor()):
        errors, solves = [], []
        for tolerance in ENSEMBLE_TOLERANCES:
            solve = integrator.prepare(problem_of(case, integrator.accepts), tolerance)
            solution = solve(starts[np.r_[judged, judged]])
            assert solution.stopped is None
            found = zip(exact, solution.states, truth, strict=False)
            errors.append(max(float(np.max(own.metric.distance(states, true))) for own, states, true in found))
            solves.append(solve)
        sides.append((errors, solves))
    milliseconds = interleaved([solves for _, solves in sides], starts, TURNS)
    rows = {}
    for error in ERRORS:
        ours, peer = (at_error(error, errors, times) for (errors, _), times in zip(sides, milliseconds, strict=True))
        each = [time and time / TRAJECTORIES * 1e3 for time in (ours, peer)]
        rows[f"{error:g}"] = {"gauss": each[0], "heyoka": each[1], "ratio": peer / ours if ours and peer else None}
    benchmark.extra_info["microseconds_a_trajectory"] = rows
    benchmark.pedantic(sides[0][1][0], (starts,), rounds=1)
    assert any(row["ratio"] for row in rows.values()), "no comparison was possible"


def interleaved(
    sides: Sequence[Sequence[Callable[[Any], Any]]], start: Any, repeats: int = REPEATS
) -> list[list[float]]:
    """Median milliseconds of each, the sides taking turns so that a slow spell of the machine falls on both."""
    times: list[list[list[int]]] = [[[] for _ in side] for side in sides]
    gc.disable()
    try:
        for _ in range(repeats):
            for k in range(max(map(len, sides))):
                for side, kept in zip(sides, times, strict=True):
                    if k < len(side):
                        begin = perf_counter_ns()
                        side[k](start)
                        kept[k].append(perf_counter_ns() - begin)
    finally:
        gc.enable()
    return [[float(np.median(t)) / 1e6 for t in kept] for kept in times]


def at_error(error: float, errors: Sequence[float], times: Sequence[float]) -> float | None:
    """The time where log time against log error, from loose to tight, last passes below `error`; None: it does not."""
    for k in range(len(errors) - 2, -1, -1):
        if errors[k] >= error > errors[k + 1]:
            share = math.log(errors[k] / error) / math.log(errors[k] / errors[k + 1])
            return math.exp((1 - share) * math.log(times[k]) + share * math.log(times[k + 1]))
    return None

"""Claims of speed, measured in pairs in one process; `make bench` launches this file five times, publishes the medians.

`extra_info["rows"]` of each benchmark holds its comparisons, as `gnomon.harness.studies.benchmarks` reads them. With
`--benchmark-disable` each runs once on a short sweep, which tests that it works.
"""

import importlib
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

import numpy as np
import pytest
from breadth import tenth
from gnomon.cases.core.registry import get
from gnomon.harness.adapters import diffrax, heyoka, scipy_ivp, scipy_ode, scipy_odeint
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.problem import counting, initial_state, problem_of
from gnomon.harness.integrators.gauss.gauss import Gauss4
from gnomon.harness.integrators.gauss.gauss_fast import GaussFast
from gnomon.harness.integrators.geometric.splitting import KahanLi8
from gnomon.harness.integrators.multistep_extrapolation.stormer import Stormer12
from gnomon.harness.integrators.runge_kutta.dop853 import Dop853
from gnomon.harness.integrators.runge_kutta.explicit import RK4
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.registry import lookup
from gnomon.harness.running.first_use import CACHES
from gnomon.harness.studies.pairs import Side, at_equal_error, null_call, swept, time_interleaved

HALF_DECADES = [10.0 ** (-k / 2) for k in range(4, 33)]
DECADES = [10.0**-k for k in range(6, 16)]

Problem = tuple[str, str, str, int]
"""Case, variant, a word of its formulation's name, and the span in multiples of the case's own. The span is so long that
null calls of both sides take less than a tenth of the time at every error (40 % for the forced oscillator's own span)."""

AGAINST_HEYOKA: dict[Problem, tuple[float, ...]] = {
    ("pendulum_simple", "speed", "", 2): (1e-6, 1e-9, 1e-12),
    ("kepler_orbit", "speed_e06", "", 1): (1e-6, 1e-9, 1e-12),
    ("kepler_orbit", "speed_e099", "sundman", 1): (1e-6, 1e-9),
    ("lagrange_top_attitude", "speed", "", 2): (1e-6, 1e-9, 1e-12),
    ("euler_top", "speed", "", 2): (1e-6, 1e-9, 1e-12),
    ("forced_oscillator", "speed", "", 16): (1e-6, 1e-9, 1e-12),
}
"""The errors at which times are compared. Half an ulp in v0 changes Kepler's orbit by 1.9e-12."""

SCIPY = (scipy_ivp.DOP853, scipy_ode.Dop853, scipy_ode.Adams, scipy_odeint.Odeint)
"""DOP853, in Python and compiled, and the two solvers with the fewest right-hand sides."""


def compare(
    benchmark: Any,
    pair: tuple[Integrator, Integrator],
    problem: Problem,
    errors: Sequence[float],
    tolerances: Sequence[float],
    repeats: int,
) -> None:
    """Run both integrators over their settings on a problem, time them at equal error, and store the rows."""
    name, variant, way, spans = problem
    case = get(name, variant, span=spans * get(name, variant).span).rounded()
    formulation = next((f for f in case.formulations if way and way in f.name.lower()), None)
    assert (formulation is None) == (way == "")
    if benchmark.disabled:
        tolerances, repeats = tolerances[-8:], 1
    (first, start), (second, _) = (
        swept(side, case, formulation, [t for t in tolerances if t >= side.sweep.tightest])  # type: ignore[union-attr]
        for side in pair
    )
    times, nulls = at_equal_error((first, second), start, errors, repeats)
    prepares = median(first.prepares), median(second.prepares)
    parts = [f"{name}/{variant}", formulation.name if formulation else "", f"{spans} spans" if spans > 1 else ""]
    benchmark.extra_info["rows"] = rows(
        f"against {pair[1].id}", ", ".join(filter(None, parts)), pair, errors, times, nulls, prepares
    )
    benchmark.pedantic(first.solvers[-1].solve, (start,), rounds=repeats)
    assert any(one and other for one, other in times), "no comparison was possible"


def rows(
    group: str,
    problem: str,
    pair: tuple[Integrator, Integrator],
    errors: Sequence[float],
    times: Sequence[tuple[float | None, float | None]],
    nulls: tuple[float, float],
    prepares: tuple[float, float],
    share: int = 1,
) -> list[dict[str, Any]]:
    """Rows as `gnomon.harness.studies.benchmarks` reads them: seconds for each of `share` trajectories of one call."""
    named = {
        "group": group, "problem": problem, "unit": "s", "first_name": pair[0].name, "second_name": pair[1].id,
        "first_null": nulls[0] / share, "second_null": nulls[1] / share,
        "first_prepare": prepares[0], "second_prepare": prepares[1],
    }  # fmt: skip
    return [
        named | {"level": f"{error:g}", "first": one and one / share, "second": other and other / share}
        for error, (one, other) in zip(errors, times, strict=True)
    ]


@pytest.mark.parametrize(
    "problem", tenth((one,) for one in AGAINST_HEYOKA), ids=lambda problem: "-".join(filter(None, problem[:3]))
)
def test_against_heyoka(benchmark: Any, problem: Problem) -> None:
    """With the fastest options that its documentation recommends."""
    pytest.importorskip("heyoka", reason="heyoka is not installed: make bench EXTRAS=dev,peers")
    compare(benchmark, (GaussFast(), heyoka.FastTaylor()), problem, AGAINST_HEYOKA[problem], HALF_DECADES, 25)


@pytest.mark.parametrize("peer", SCIPY, ids=lambda peer: peer.name.replace(" ", "-"))
@pytest.mark.parametrize("problem", [("pendulum_simple", "speed", "", 1), ("kepler_orbit", "speed_e06", "", 1)])
def test_dop853_against_scipy(benchmark: Any, problem: Problem, peer: type[Integrator]) -> None:
    if benchmark.disabled and peer is not scipy_ode.Dop853:
        pytest.skip("seconds a solve: make bench")
    compare(benchmark, (Dop853(), peer()), problem, (1e-3, 1e-6), DECADES, 3)


TOGETHER = [10.0 ** (-k / 2) for k in range(12, 28, 2)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("peer", "way", "trajectories"), [(heyoka.FastTaylor, "in batches", 10_000), (diffrax.Dopri8, "by vmap", 1000)]
)
def test_an_ensemble(benchmark: Any, peer: type[Integrator], way: str, trajectories: int) -> None:
    """Pendulums, each of another amplitude, both sides on all the cores that this process may use.

    The error is the largest of eight of them, spread over the amplitudes. For diffrax they are fewer, as it takes 1 to 5 ms
    each: from 100 on its time for one does not depend on their number.
    """
    pytest.importorskip(peer.library, reason=f"{peer.library} is not installed: make bench EXTRAS=dev,peers")
    count, tolerances, turns = (64, TOGETHER[-3:], 1) if benchmark.disabled else (trajectories, TOGETHER, 3)
    case = get("pendulum_simple", "speed").rounded()
    starts = np.column_stack([np.linspace(0.5, 2.5, count), np.zeros(count)])
    scored = np.linspace(0, count - 1, 8).astype(int)
    alone = [get("pendulum_simple", "speed", tuple(starts[i].tolist()), float(case.span)).rounded() for i in scored]
    exact = [own.sample(case.times) for own in alone]

    def side(integrator: Integrator) -> Side:
        problem = problem_of(case, integrator.accepts)
        found = Side([], [], null_call(integrator, problem, tolerances[0]))
        for tolerance in tolerances:
            prepared = Prepared(integrator, problem, tolerance)
            found.prepares.append(prepared.prepare_seconds)
            solution = prepared(starts)
            assert solution.stopped is None
            distances = [
                own.metric.distance(states, true)
                for own, states, true in zip(alone, solution.states[scored], exact, strict=True)
            ]
            found.errors.append(float(np.max(distances)))
            found.solvers.append(prepared.solver)
        return found

    pair = GaussFast(), peer()
    sides = side(pair[0]), side(pair[1])
    times, nulls = at_equal_error(sides, starts, errors := (1e-6, 1e-9, 1e-12), turns)
    prepares = median(sides[0].prepares), median(sides[1].prepares)
    group, problem = f"against {pair[1].id} {way}", f"1e{len(str(trajectories)) - 1} pendulums, a trajectory"
    benchmark.extra_info["rows"] = rows(group, problem, pair, errors, times, nulls, prepares, count)
    benchmark.pedantic(sides[0].solvers[0].solve, (starts,), rounds=1)
    assert any(one and other for one, other in times), "no comparison was possible"


@pytest.mark.parametrize("method", [RK4, KahanLi8, Stormer12, Dop853, Gauss4], ids=lambda method: method.name)
def test_nanoseconds_a_right_hand_side(benchmark: Any, method: type[Integrator]) -> None:
    """Time of a whole step divided by its right-hand sides, of methods that evaluate these one after the other."""
    case = get("pendulum_simple", "speed").rounded()
    problem = problem_of(case, method.accepts)
    setting = 1e-9 if method.sweep.kind == "tolerance" else problem.interval / 64
    start = initial_state(case)[None]
    counted = counting(problem)
    method().prepare(counted, setting)(start)
    ((seconds,),) = time_interleaved([[method().prepare(problem, setting)]], start, 1 if benchmark.disabled else 25)
    benchmark.extra_info["rows"] = [
        {
            "group": "a right-hand side", "problem": "pendulum_simple/speed", "level": None, "unit": "s",
            "first_name": method.name, "second_name": None, "value": seconds / counted.buffer[-1],
        }
    ]  # fmt: skip
    benchmark.pedantic(method().prepare(problem, setting).solve, (start,), rounds=1)


FIRST_RESULTS: dict[str, tuple[str, ...]] = {
    "gnomon:Gauss 8-stage SIMD": (
        "pendulum_simple", "kepler_orbit", "lagrange_top", "double_pendulum", "lagrange_top_attitude", "equilateral_three_body"
    ),
    "gnomon:Radau IIA 5": ("pendulum_simple", "damped_oscillator", "kepler_orbit", "small_vibrations_3dof_chain"),
    "gnomon:Taylor": ("pendulum_simple", "kepler_orbit", "equilateral_three_body"),
    "gnomon:Boris": ("charge_in_E_and_B", "relativistic_charge"),
    "gnomon:RATTLE": ("holonomic_constraint_dae",),
    "gnomon:DOP853 [events]": ("bouncing_ball", "coulomb_friction_oscillator"),
    "heyoka:Taylor": ("pendulum_simple", "kepler_orbit", "lagrange_top_attitude", "equilateral_three_body"),
    **dict.fromkeys(
        ("gnomon:RK4", "gnomon:Kahan-Li 8", "gnomon:Störmer 12", "gnomon:Gauss 2-stage", "gnomon:DOP853",
         "gnomon:RKN 12(10)", "gnomon:Gragg-Bulirsch-Stoer", "diffrax:Tsit5", "scipy:DOP853", "scipy:Radau"),
        ("pendulum_simple", "duffing_unforced"),
    ),
}  # fmt: skip
"""Methods of each family, and cases that each solves one after the other: the first one is the first on the machine."""


def test_first_results(benchmark: Any, tmp_path: Path) -> None:
    """Processor time from `prepare` to the end of the first solve, without imports, each method in processes of its own.

    The first process starts with empty caches, the second one finds the code that the first one kept.
    """
    rows = []
    for name, solved in list(FIRST_RESULTS.items())[: 1 if benchmark.disabled else None]:
        if lookup.missing(lookup.find_one(name)) is not None:
            continue
        folders = {variable: str(tmp_path / name.replace(":", "_") / variable) for variable in CACHES}
        for kept in (False, True):
            program = f"import runpy, sys; sys.path[:] = {sys.path}; runpy.run_path({str(Path(__file__))!r})['first_results']({name!r})"
            found = subprocess.run(
                [sys.executable, "-c", program], check=True, capture_output=True, text=True, env=os.environ | folders
            )
            for n, (case, value) in enumerate(zip(solved, json.loads(found.stdout), strict=True)):
                words = "with kept code" if kept else "on a machine" if n == 0 else "of a further system"
                rows.append({
                    "group": f"first result {words}", "problem": case, "level": None, "unit": "s", "first_name": name,
                    "second_name": None, "value": value,
                })  # fmt: skip
    benchmark.extra_info["rows"] = rows
    benchmark.pedantic(lambda: None, rounds=1)
    assert rows


def first_results(name: str) -> None:
    """Print the processor seconds of the first solve of each case, at 1e-9 or with 64 steps between samples."""
    method, seconds = lookup.find_one(name), []
    for module in ("scipy.integrate", method.library):
        with suppress(ImportError):
            importlib.import_module(module)
    for case in (get(name).rounded() for name in FIRST_RESULTS[name]):
        problem, start = problem_of(case, method.accepts), initial_state(case)[None]
        setting = 1e-9 if method.sweep.kind == "tolerance" else problem.interval / 64
        begin = process_time()
        with Prepared(method, problem, setting) as solve:
            solve(start)
        seconds.append(process_time() - begin)
    print(json.dumps(seconds))

"""Times at equal error of two sides with given errors; launches combined; their rows in the report."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.adapters import rebound_ode, scipy_odeint
from gnomon.harness.contract.integrator import Solution, Solver
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.integrators.gauss.gauss_fast import GaussFast
from gnomon.harness.integrators.runge_kutta.dop853 import Dop853
from gnomon.harness.reporting import report_benchmarks
from gnomon.harness.studies import benchmarks, pairs
from gnomon.harness.studies.pairs import Side, at_equal_error, null_call, time_interleaved

ERRORS = [1e-2, 1e-4, 1e-6, 1e-8]


def test_a_side_times_only_the_settings_near_its_targets() -> None:
    side = Side(ERRORS, [], Solver(Solution))
    assert side.near([1e-5]) == [1, 2]
    assert side.near([1e-4, 1e-7]) == [0, 1, 2, 3]
    assert side.near([1e-1]) == [0]
    assert side.near([1e-9]) == []
    assert side.time({1: 1.0, 2: 100.0}, 1e-5) == pytest.approx(10.0)
    assert side.time({1: 1.0, 2: 100.0}, 1e-9) is None
    assert side.time({1: 9.0, 2: 9.0, 3: 4.0}, 1e-5) == pytest.approx(4.0), "a tighter setting takes less time"


def test_two_sides_at_equal_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each setting takes a given time on a simulated clock; the slower side does not reach the second error."""
    clock = [0]
    monkeypatch.setattr(pairs, "perf_counter_ns", lambda: clock[0])

    def lasting(milliseconds: int) -> Any:
        def solve(start: Any) -> Solution:
            clock[0] += milliseconds * 1_000_000
            return Solution(start)

        return Solver(solve)

    fast = Side(ERRORS, [lasting(k) for k in (1, 2, 4, 8)], lasting(0))
    slow = Side(ERRORS[:3], [lasting(k) for k in (10, 20, 40)], lasting(5))
    (reached, missed), nulls = at_equal_error((fast, slow), np.zeros((1, 2)), (1e-4, 1e-8), repeats=1)
    assert nulls == (0.0, 5e-3)
    assert reached == (pytest.approx(2e-3), pytest.approx(20e-3))
    assert missed == (pytest.approx(8e-3), None)


@pytest.mark.parametrize("integrator", [GaussFast(), Dop853(), scipy_odeint.Odeint(), rebound_ode.OdeMode()])
def test_a_null_call_makes_the_same_calls_with_almost_no_steps(integrator: Any) -> None:
    """It returns as many states, all equal to the start to 1e-7, with at most one step from sample to sample."""
    case = get("pendulum_simple", "speed").rounded()
    problem, start = problem_of(case, integrator.accepts), initial_state(case)[None]
    null = null_call(integrator, problem, 1e-6)(start)
    whole = integrator.prepare(problem, 1e-6)(start)
    assert null.states.shape == whole.states.shape
    assert np.abs(null.states - start).max() < 1e-7, "1e-9 of a time scale, at speeds of size 1"
    assert null.steps <= 65 < whole.steps


def test_calls_of_the_sides_alternate() -> None:
    called: list[str] = []

    def noted(name: str) -> Any:
        return Solver(lambda start: called.append(name))  # type: ignore[arg-type,func-returns-value,return-value]

    time_interleaved([[noted("a"), noted("b")], [noted("c")]], np.zeros(1), repeats=1)
    assert called == ["a", "c", "b"] * 2


def row(**values: Any) -> dict[str, Any]:
    named = {"group": "against x", "problem": "s", "level": "1e-06", "unit": "s", "first_name": "o", "second_name": "x"}
    return named | values


@pytest.fixture
def published(tmp_path: Path) -> Path:
    """Three launches with four rows: a ratio and its range, one with large overhead, a missed error, a single time."""
    for launch, ratio in enumerate((3.0, 2.8, 3.3)):
        nulls = {"first_null": 5e-5, "second_null": 5e-5, "first_prepare": 0.01 * ratio, "second_prepare": 0.2}
        rows = [
            row(first=1e-3, second=ratio * 1e-3, **nulls),
            row(level="1e-04", first=1e-3, second=ratio * 1e-3, **nulls | {"first_null": 1.5e-4}),
            row(level="1e-12", first=1e-3, second=None if launch else 1.0, **nulls),
            row(group="first call", second_name=None, value=0.001 * ratio),
        ]
        found = {"benchmarks": [{"extra_info": {"rows": rows}}, {"extra_info": {}}]}
        (tmp_path / f"{launch}.json").write_text(json.dumps(found))
    gathered = benchmarks.gather(sorted(tmp_path.glob("?.json")))
    (tmp_path / "benchmarks.json").write_text(json.dumps(gathered))
    return tmp_path


def test_launches_are_combined(published: Path) -> None:
    found = json.loads((published / "benchmarks.json").read_text())
    assert found["launches"] == 3
    reached, _, missed, single = found["rows"]
    assert (reached["median"], reached["low"], reached["high"]) == (3.0, 2.8, 3.3)
    assert reached["ratios"] == [3.0, pytest.approx(2.8), 3.3], "of each launch: these separate the two, or not"
    assert reached["first_null"] == 5e-5
    assert reached["first_prepare"] == pytest.approx(0.03), "the median"
    assert missed["second"] is None
    assert missed["median"] is None
    assert single["median"] == 0.003


def test_the_report_claims_what_was_measured(published: Path) -> None:
    found = report_benchmarks.benchmarks(published / "nowhere", published) or {}
    reached, short, missed = found["pairs"]
    assert reached["ratio"] == "3.03", "the geometric mean"
    low, high = (float(end) for end in reached["range"].split(" – "))
    assert 2 < low < 2.8
    assert 3.3 < high < 4
    assert reached["note"] == ""
    assert reached["first_prepare"].startswith("prepared in 30.0 ms")
    assert reached["second_prepare"].startswith("prepared in 200 ms")
    assert short["note"] == "15 % of the time of o is overhead of its call"
    assert missed["note"] == "not so accurate: x"
    assert found["singles"][0]["median"] == "3.00 ms"
    assert report_benchmarks.benchmarks(published / "nowhere") is None
    assert report_benchmarks.growth(published) is None


def test_a_file_of_an_earlier_revision_has_no_claims_and_does_not_end_the_report(tmp_path: Path) -> None:
    old = {"launches": 5, "environment": {}, "rows": [{"ours_name": "o", "peer_name": "x"}]}
    (tmp_path / "benchmarks.json").write_text(json.dumps(old))
    found = report_benchmarks.benchmarks(tmp_path) or {}
    assert (bool(found["lacks"]), found["pairs"], found["singles"]) == (True, [], [])

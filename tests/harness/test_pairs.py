"""Times at equal error of two planted sides; launches gathered; what the report says of them."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.harness import benchmarks, report_benchmarks
from gnomon.harness.integrator import Solution
from gnomon.harness.pairs import Side, at_equal_error, interleaved

ERRORS = [1e-2, 1e-4, 1e-6, 1e-8]


def test_a_side_times_only_the_settings_near_its_targets() -> None:
    side = Side(ERRORS, [])
    assert side.near([1e-5]) == [1, 2]
    assert side.near([1e-4, 1e-7]) == [0, 1, 2, 3]
    assert side.near([1e-1]) == [0]
    assert side.near([1e-9]) == []
    assert side.time({1: 1.0, 2: 100.0}, 1e-5) == pytest.approx(10.0)
    assert side.time({1: 1.0, 2: 100.0}, 1e-9) is None
    assert side.time({1: 9.0, 2: 9.0, 3: 4.0}, 1e-5) == pytest.approx(4.0), "a tighter setting takes less time"


def test_two_sides_at_equal_error() -> None:
    """Each setting burns so many milliseconds; the slower side does not reach the second error."""

    def burning(milliseconds: float) -> Any:
        def solve(start: Any) -> Solution:
            end = time.process_time() + milliseconds * 1e-3
            while time.process_time() < end:
                pass
            return Solution(start)

        return solve

    fast = Side(ERRORS, [burning(k) for k in (1, 2, 4, 8)])
    slow = Side(ERRORS[:3], [burning(k) for k in (10, 20, 40)])
    (reached, missed) = at_equal_error((fast, slow), np.zeros((1, 2)), (1e-4, 1e-8), repeats=1)
    assert reached[0] is not None
    assert reached[1] is not None
    assert reached[0] >= 2e-3
    assert reached[1] >= 20e-3
    assert missed[0] is not None
    assert missed[1] is None


def test_sides_take_turns() -> None:
    order: list[str] = []

    def noted(name: str) -> Any:
        return lambda start: order.append(name)

    interleaved([[noted("a"), noted("b")], [noted("c")]], np.zeros(1), repeats=1)
    assert order == ["a", "c", "b"] * 2


def row(**values: Any) -> dict[str, Any]:
    named = {"group": "against x", "scene": "s", "level": "1e-06", "ours_name": "o", "peer_name": "x", "unit": "s"}
    return named | {"asked": 2.0} | values


@pytest.fixture
def published(tmp_path: Path) -> Path:
    """Three launches: one ratio with its range, one that a launch did not reach, one single time."""
    for launch, ratio in enumerate((3.0, 2.0, 5.0)):
        rows = [
            row(ours=1e-3, peer=ratio * 1e-3),
            row(level="1e-12", ours=1e-3, peer=None if launch else 1.0),
            row(group="first call", peer_name=None, asked=0.01, value=0.001 * ratio),
        ]
        found = {"benchmarks": [{"extra_info": {"rows": rows}}, {"extra_info": {}}]}
        (tmp_path / f"{launch}.json").write_text(json.dumps(found))
    gathered = benchmarks.gathered(sorted(tmp_path.glob("?.json")))
    (tmp_path / "benchmarks.json").write_text(json.dumps(gathered))
    return tmp_path


def test_launches_are_gathered(published: Path) -> None:
    found = json.loads((published / "benchmarks.json").read_text())
    assert found["launches"] == 3
    reached, missed, single = found["rows"]
    assert (reached["median"], reached["low"], reached["high"]) == (3.0, 2.0, 5.0)
    assert missed["peer"] is None
    assert missed["median"] is None
    assert single["median"] == 0.003


def test_the_report_says_what_was_reached(published: Path) -> None:
    found = report_benchmarks.benchmarks(published / "nowhere", published)
    assert found is not None
    reached, missed = found["pairs"]
    assert (reached["ratio"], reached["range"], reached["verdict"]) == ("3.00", "2.00 – 5.00", "reached")
    assert missed["verdict"] == "not reached by x"
    assert found["singles"][0]["verdict"] == "reached"
    assert report_benchmarks.benchmarks(published / "nowhere") is None
    assert report_benchmarks.growth(published) is None

"""The panel of events: findings on right methods at every depth, and the defects that each kind of passage shows."""

from typing import Any, ClassVar

import numpy as np
import pytest
import right_methods
from gnomon.cases.core.forms import Hybrid, Mode
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solution, Solver, Steps
from gnomon.harness.registry.lookup import find_one
from gnomon.harness.stability.events import GAPS, PASSAGES, events, measure_passage, settings_of, share

BY_NAME = {passage.name: passage for passage in PASSAGES}
SECONDS = 0.05


def _rk4(mode: Mode, parameters: Any, t: float, y: Floats, h: float) -> Any:
    def f(t: float, y: Floats) -> Floats:
        return np.array(mode.equations(t, tuple(y.tolist()), (*parameters, *mode.constants)), dtype=np.float64)

    return right_methods.rk4(f, t, y, h)


class Planted(Integrator):
    """RK4 with events between the ends of steps, each found by bisection; right, or with one fault."""

    library, order, accepts, sweep = "planted", 4, (Hybrid,), Steps()
    name = "planted"
    fault: ClassVar[str] = ""

    def prepare(self, problem: Problem, setting: float) -> Solver:
        return Solver(lambda starts: self.solution(problem, setting, starts))

    def solution(self, problem: Problem, h: float, starts: Floats) -> Solution:
        form, parameters = problem.form, tuple(problem.parameters.tolist())
        assert isinstance(form, Hybrid)
        y, events = starts[0].copy(), []
        mode = form.mode(form.start(0.0, tuple(y.tolist()), parameters))
        for k in range(round(float(problem.times[-1]) / h)):
            t, end = k * h, (k + 1) * h
            while t < end:
                t, y, event = self.advance(form, mode, parameters, t, y, end - t)
                if event is None:
                    break
                events.append((t + (0.3 if self.fault == "late" else 0.0), event.name))
                y = np.array(event.reset(t, tuple(y.tolist()), parameters), dtype=np.float64)
                mode = form.mode(event.lands(t, tuple(y.tolist()), parameters))
                if self.fault == "one_a_step":
                    t, y = end, _rk4(mode, parameters, t, y, end - t)
            t = end
        states = np.tile(y, (1, len(problem.times), 1))
        return Solution(states, None, None, tuple(events))

    def advance(self, form: Hybrid, mode: Mode, parameters: Any, t: float, y: Floats, h: float) -> Any:
        """The end of the step, or the first event in it: (time, state, transition or None)."""
        own = [e for e in form.transitions if e.mode == mode.name or self.fault == "all_modes"]
        margin = 2e-3 if self.fault == "nearly" else 0.0

        def side(event: Any, x: float) -> float:
            state = tuple(_rk4(mode, parameters, t, y, x).tolist())
            return float(event.guard(t + x, state, parameters)[0]) * event.direction + margin

        probes = [h] if self.fault == "ends_only" else [h * k / 16 for k in range(1, 17)]
        first: tuple[float, Any] | None = None
        for event in own:
            before = side(event, 0.0)
            for x in probes:
                after = side(event, x)
                crossed = before < 0 <= after
                if crossed and (first is None or x < first[0]):
                    first = self.bisected(side, event, x - probes[0], x), event
                    break
                before = after
        if first is None:
            return t + h, _rk4(mode, parameters, t, y, h), None
        return t + first[0], _rk4(mode, parameters, t, y, first[0]), first[1]

    def bisected(self, side: Any, event: Any, low: float, high: float) -> float:
        sign = np.sign(side(event, high)) or 1.0
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (low, middle) if side(event, middle) * sign >= 0 else (middle, high)
        return high


def planted(fault: str) -> Integrator:
    return type("Planted", (Planted,), {"fault": fault})()


@pytest.mark.parametrize(
    ("fault", "passage", "size", "wrong"),
    [
        ("ends_only", "grazing_oscillator", 1e-3, "missed"),
        ("late", "grazing_fall", 1e-1, "missed"),
        ("nearly", "invented", GAPS[-1], "extra"),
        ("one_a_step", "two_in_one_step", 1e-3, "missed"),
        ("all_modes", "grazing_oscillator", 1e-1, "extra"),
    ],
)
def test_each_planted_fault_is_seen_on_its_passage_and_the_right_method_passes_it(
    fault: str, passage: str, size: float, wrong: str
) -> None:
    right = measure_passage(planted(""), BY_NAME[passage], size, 1 / 4, 0.0)
    assert (right["missed"], right["extra"]) == (0, 0)
    assert right["found"] == right["starts"]
    seen = measure_passage(planted(fault), BY_NAME[passage], size, 1 / 4, 0.0)
    assert seen[wrong] > 0


@pytest.mark.parametrize("name", ["gnomon:DOP853 [events]", "gnomon:RK4 [events]"])
def test_in_house_methods_find_every_event_deeper_than_their_error_and_invent_none(name: str) -> None:
    """At the middle setting the error, 1e-8, is below every depth; a method that interpolates misses shallow ones."""
    integrator = find_one(name)
    setting = settings_of(integrator)[1]
    for passage in PASSAGES:
        rows = [measure_passage(integrator, passage, size, setting, SECONDS) for size in passage.sizes]
        assert all(row["found"] == row["starts"] and not row["extra"] for row in rows)


def test_interpolants_of_long_steps_miss_grazing_events() -> None:
    """The fifth-order pair solves the parabola of free fall without an error: steps of a quarter of the time scale, the
    longest that its adapter allows, pass over a shallow grazing, not over a deep one."""
    integrator = find_one("scipy:RK45 [events]")
    fall = [measure_passage(integrator, BY_NAME["grazing_fall"], depth, 1e-4, 0.0) for depth in (1e-1, 1e-6)]
    assert fall[0]["found"] > fall[1]["found"] == 0
    swing = measure_passage(integrator, BY_NAME["grazing_oscillator"], 1e-3, 1e-4, 0.0)
    assert swing["found"] < swing["starts"] / 2


def test_a_ball_that_comes_to_rest_has_all_its_impacts_and_the_sentences_name_what_is_missed() -> None:
    data = events.measured(find_one("gnomon:RK4 [events]"), 0.5)
    assert all(row["missing"] == row["extra"] == 0 and row["events"] > 90 for row in data["zeno"])
    data["zeno"][0] |= {"missing": 46}
    said = events.sentences(data)
    assert any(text.startswith("Not for events that accumulate") and "46 of 97" in text for text in said)
    assert any(text.startswith("Use it for two events close together down to a size of 1e-06") for text in said)


def test_a_method_without_events_is_not_measured() -> None:
    assert events.measured(find_one("gnomon:RK4"), 1.0) == {"not_applicable": "it takes no equations with events"}


@pytest.mark.parametrize(
    ("count", "of", "low", "high"), [(24, 24, 0.858, 1.0), (0, 24, 0.0, 0.142), (5, 10, 0.187, 0.813)]
)
def test_the_interval_of_a_share_is_that_of_clopper_and_pearson(count: int, of: int, low: float, high: float) -> None:
    """Published tables to three digits; of 24 none missed still allows one in seven."""
    assert share(count, of) == pytest.approx((low, high), abs=6e-4)

"""The costs of an engine tell a world that repeats its bits from one that does not, and what forces cost from the rest."""

from collections.abc import Mapping
from typing import Any, ClassVar

import pytest
from gnomon.cases.core.scene import IDENTITY, Readings, Scene, SceneForm
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator
from gnomon.harness.studies import engine_costs


class Counting:
    """A world that reads the number of its steps, and of earlier worlds if it `remembers`.

    By its clock a step takes 3 microseconds, and 10 more with forces.
    """

    made, clock = 0, 0.0

    def __init__(self, remembers: bool, compiled: bool) -> None:
        Counting.made += 1
        self.compiled = compiled
        self.options: dict[str, Any] = {}
        self.first = Counting.made if remembers else 0

    def build(self, scene: Scene) -> None:
        self.seconds = 13e-6 if scene.forces else 3e-6
        self.called = bool(scene.forces) and not self.compiled

    def place(self, scene: Scene) -> None:
        self.steps = 0

    def advance(self, steps: int) -> None:
        self.steps += steps
        Counting.clock += self.seconds * steps
        for _ in range(steps if self.called else 0):
            self.push()

    def push(self) -> None:
        pass

    def read(self) -> Readings:
        return Readings({}, {"bob": ((self.first + self.steps, 0.0, 0.0), IDENTITY, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))})

    def close(self) -> None:
        pass


class Engine(SceneIntegrator):
    """An engine of points."""

    name, library, remembers, compiled = "counting", "mine", False, False
    lacks: ClassVar[Mapping[str, str]] = {"hinge": "no joints"}

    def world(self, form: SceneForm, dt: float) -> Counting:
        return Counting(self.remembers, self.compiled)


class Remembering(Engine):
    """An engine that keeps something between worlds."""

    remembers = True


class Compiled(Engine):
    """An engine that is given compiled forces, which take as long."""

    compiled = True


@pytest.fixture(autouse=True)
def fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine_costs, "BATCHES", 1)
    monkeypatch.setattr(engine_costs, "perf_counter", lambda: Counting.clock)


def test_the_same_bits_and_the_time_of_forces() -> None:
    found = engine_costs.costs(Engine())
    assert found["same_bits"] == {"in a new world": True, "with another world beside it": True}
    assert [found[name] for name in ("step_us", "engine_us", "forces_us")] == pytest.approx([13, 3, 10])
    assert found["energy_an_hour"] is None
    assert engine_costs.is_same_in_threads(Engine())


def test_the_share_of_forces_in_python_beside_the_time_of_a_step() -> None:
    assert engine_costs.costs(Engine())["python_share"] == pytest.approx(10 / 13)
    assert engine_costs.costs(Compiled())["python_share"] == 0


def test_an_engine_that_remembers_earlier_worlds_has_other_bits() -> None:
    found = engine_costs.costs(Remembering())
    assert found["same_bits"] == {"in a new world": False, "with another world beside it": False}
    assert not engine_costs.is_same_in_threads(Remembering())

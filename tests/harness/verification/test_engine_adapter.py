"""An engine that can load, step and read is an integrator of scenes."""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import gnomon
from gnomon.cases.core.scene import Readings, Scene, SceneForm
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.contract.status import Status
from gnomon.harness.contract.validation import Unusable
from gnomon.harness.registry import lookup, references
from gnomon.harness.verification.engine_adapter import EngineIntegrator, from_engine
from timed_forms import FORMS
from waiting import LONG_SECONDS

from gnomon import cases

HERE = Path(__file__).parent
DOCS = HERE.parents[2] / "docs"


@pytest.fixture(autouse=True)
def toys() -> Iterator[None]:
    """The toy engine can be imported, by worker processes too."""
    sys.path.insert(0, str(HERE))
    yield
    sys.path.remove(str(HERE))


def toy() -> EngineIntegrator:
    import toy_engine

    found: EngineIntegrator = toy_engine.INTEGRATOR
    return found


def test_a_free_fall_follows_the_steps_of_the_engine() -> None:
    """Symplectic Euler has a closed form here: after n steps h the height is lower than the exact one by g h t / 2."""
    case = cases.get("projectile_parabola").rounded()
    problem = problem_of(case, toy().accepts)
    h = problem.interval / 4
    start = initial_state(case)
    solution = toy().prepare(problem, h)(np.array([start, start]))
    (g,) = problem.parameters
    wanted = case.sample(case.times)
    wanted[:, 1] -= g * h * case.times / 2
    assert np.allclose(solution.states, wanted, rtol=0, atol=1e-12 * np.max(np.abs(wanted)))
    assert solution.steps == 2 * 4 * 64


def test_an_engine_can_declare_what_it_conserves() -> None:
    """Symplectic Euler declares the symplectic form, and a worker that makes the engine again declares it too."""
    from toy_engine import ToyEngine

    made = from_engine(ToyEngine, name="toy", order=1, conserves=("symplectic",))
    again = references.dereference(references.reference(made))
    assert again.conserves == made.conserves == ("symplectic",)


@pytest.mark.parametrize("name", ["kepler_orbit", "two_body", "projectile_quadratic_drag", "free_fall_first_order"])
def test_forces_of_each_kind_converge_with_order_1(name: str) -> None:
    """Over the first four samples, at steps so small that errors are proportional to them."""
    case = cases.get(name).rounded()
    problem = problem_of(case, toy().accepts)
    problem = replace(problem, times=problem.times[:4])
    start, exact = initial_state(case)[None], case.sample(problem.times)
    errors = []
    for steps in (512, 1024):
        found = toy().prepare(problem, problem.interval / steps)(start).states[0]
        errors.append(np.max(np.abs(found - exact)))
    assert 0.4 * errors[0] < errors[1] < 0.6 * errors[0]


def test_an_engine_that_starts_at_0_gets_the_laws_of_a_late_start() -> None:
    form, start = FORMS[SceneForm]
    times = np.arange(1, 9) * 0.125
    states = [
        toy().prepare(Problem(form, 2, np.array([t0]), times + t0, 1.0, t0=t0), 2.0**-5)(np.array([start])).states
        for t0 in (0.0, 3.25)
    ]
    assert np.array_equal(*states)


def test_a_run_measures_the_engine_and_names_what_it_lacks(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    from gnomon.harness.results.store import load

    results = str(tmp_path / "results.sqlite")
    chosen = ("--case", "projectile_parabola", "--case", "pendulum_simple")
    asked = (
        "--integrator",
        "toy_engine:INTEGRATOR",
        "--suite",
        "quick",
        "--limit",
        str(LONG_SECONDS),
        "--out",
        results,
    )
    assert gnomon("run", *chosen, *asked) == 0
    capfd.readouterr()
    frame = load(results)
    fall = frame[(frame["case"] == "projectile_parabola") & (frame["launch"] == 1)]
    assert set(fall["status"]) == {Status.OK}
    assert set(fall["integrator_id"]) == {"engine:toy"}
    (swing,) = frame[frame["case"] == "pendulum_simple"].itertuples()
    assert (swing.status, swing.reason) == (Status.UNSUPPORTED, "lacks hinge")


def test_a_worker_gets_the_engine_with_its_declaration() -> None:
    again = references.dereference(references.reference(toy()))
    assert isinstance(again, EngineIntegrator)
    assert (again.id, again.order, again.tokens, again.sweep) == (toy().id, 1, toy().tokens, toy().sweep)
    assert lookup.is_users_own(again)
    assert again.versions()["engine"]


class Wrong:
    """Reads the given readings."""

    readings: Any = None

    def load(self, scene: Scene) -> None:
        pass

    def step(self, dt: float) -> None:
        pass

    def read(self) -> Any:
        return self.readings


REST = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("readings", "said"),
    [
        (None, "returned None, not Readings"),
        (Readings(), r"bodies\['projectile'\] = None: it is \(position, quaternion"),
        (Readings(bodies={"projectile": (REST, REST)}), "it is .position, quaternion"),  # type: ignore[dict-item]
        (Readings(bodies={"projectile": (REST, REST, REST, REST)}), "quaternion, = .*: it is 4 numbers"),  # type: ignore[dict-item]
        (Readings(bodies={"projectile": (REST, ("a",) * 4, REST, REST)}), "it is 4 numbers"),  # type: ignore[dict-item]
    ],
)
def test_readings_are_verified(readings: Any, said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Wrong, "readings", readings)
    integrator = from_engine(Wrong, name="wrong")
    case = cases.get("projectile_parabola").rounded()
    problem = problem_of(case, integrator.accepts)
    with pytest.raises(Unusable, match=said):
        integrator.prepare(problem, problem.interval)(initial_state(case)[None])


def test_a_wrong_declaration_is_refused() -> None:
    class Local(Wrong):
        pass

    with pytest.raises(ValueError, match="top level of a module"):
        from_engine(Local, name="local")
    with pytest.raises(ValueError, match="order = 0"):
        from_engine(Wrong, name="wrong", order=0)
    with pytest.raises(ValueError, match="coarsest is"):
        from_engine(Wrong, name="wrong", coarsest=-1.0)


def test_the_page_shows_the_engine_that_is_tested() -> None:
    assert (HERE / "toy_engine.py").read_text() in (DOCS / "engine.md").read_text()

"""Pre-flights pass a correct engine, and each names the fault that it is about."""

import re
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import planted_engines
import pytest
import rigid_engine
from gnomon.cases import get
from gnomon.cases.core.scene import Readings, Scene
from gnomon.harness.contract.integrator import Floats, Integrator
from gnomon.harness.studies import preflight
from gnomon.harness.studies.preflight import FAILED, PASSED, TEXTS, UNSUPPORTED, Row, preflights
from gnomon.harness.studies.preflight_checks import SPEEDS, name_thresholds
from gnomon.harness.studies.preflight_scenes import INERTIA, SMOOTH, flow, tumbling_rates
from gnomon.harness.verification.engine_adapter import from_engine
from planted_engines import planted
from rigid_engine import PLANTED, SINGLE, SOUND, RigidEngine
from scipy.spatial.transform import Rotation

ON = [get(name) for name in ("kepler_orbit", "euler_top", "pendulum_simple", "damped_oscillator", "forced_oscillator")]
"""A free body, a free attitude, a hinge, a slider, and a force of time."""
ALONE = ("clamp", "sleep", "joint_axes", "declared_order", "restitution", "friction", "same_bits")
"""The faults that no other pre-flight sees. A wrong moment, force or damping changes accelerations too."""


def run(engine: Integrator, *names: str) -> list[Row]:
    return list(preflights(engine, names or None, ON))


def failed(rows: Iterable[Row]) -> set[str]:
    return {row.name for row in rows if row.verdict == FAILED}


def test_each_pre_flight_has_a_text_and_a_planted_fault() -> None:
    assert {*preflight.CHECKS, preflight.ACCELERATION} == set(TEXTS) == set(PLANTED)


def test_a_correct_engine_passes_every_scene_of_every_pre_flight() -> None:
    rows = run(SOUND)
    assert {row.verdict for row in rows} == {PASSED}, [row for row in rows if row.verdict != PASSED]
    assert {row.name for row in rows} == set(TEXTS)


@pytest.mark.parametrize("name", PLANTED)
def test_a_fault_is_named_by_the_pre_flight_that_is_meant_for_it(name: str) -> None:
    assert failed(run(PLANTED[name], name)) == {name}


@pytest.mark.slow
@pytest.mark.parametrize("name", ALONE)
def test_no_other_pre_flight_fails(name: str) -> None:
    assert failed(run(PLANTED[name])) == {name}


@pytest.mark.slow
def test_an_engine_of_binary32_passes_by_the_rounding_of_binary32() -> None:
    assert failed(run(SINGLE)) == set()


def test_binary32_fails_by_the_rounding_of_binary64() -> None:
    declared = from_engine(rigid_engine.Single, name="Single", order=2, tokens=rigid_engine.TOKENS)
    assert failed(run(declared, "acceleration", "joint_axes")) == {"acceleration", "joint_axes"}
    assert failed(run(SINGLE, "acceleration", "joint_axes")) == set()


@pytest.mark.parametrize(
    ("engine", "words", "speed"),
    [
        (planted_engines.Threshold, r"kept from ([\d.]+) m/s on; below it the ball does not rebound", 1),
        (planted_engines.Capped, r"kept up to ([\d.]+) m/s; above it", 10),
    ],
)
def test_the_speed_from_which_or_up_to_which_a_restitution_is_kept_is_named(
    engine: Callable[[], Any], words: str, speed: float
) -> None:
    """Two digits, and half a per cent of the search; a cap is kept a little beyond it, within the bound of 1/256."""
    rows = {row.scene: row for row in run(planted(engine, "rigid_impact"), "restitution")}
    assert rows.pop("ball_e_0").verdict == PASSED
    for row in rows.values():
        found = re.search(words, row.note)
        assert row.verdict == FAILED
        assert found, row.note
        assert float(found[1]) == pytest.approx(speed, rel=0.03)


def test_restitution_is_tried_from_slow_to_fast_without_a_gap() -> None:
    """No threshold that users meet lies outside: 0.1 m/s of an engine's own, 30 m/s of a thrown ball."""
    assert min(SPEEDS) <= 0.1
    assert max(SPEEDS) >= 30
    assert {row.verdict for row in run(planted(planted_engines.Ball, "rigid_impact"), "restitution")} == {PASSED}


def test_each_range_of_speeds_that_keeps_a_restitution_is_named() -> None:
    said = name_thresholds({0.1: 0.0, 1.0: 0.5, 2.0: 0.5, 4.0: 0.0, 8.0: 0.5}, 0.5)
    assert "from 1 to 2 m/s and from 8 m/s on" in said
    assert "not finite" in name_thresholds({0.1: float("nan"), 1.0: 0.5}, 0.5)
    assert "not kept from 0.1 to 1 m/s" in name_thresholds({0.1: 0.0, 1.0: 0.0}, 0.5)


class Raises(RigidEngine):
    def step(self, dt: float) -> None:
        raise RuntimeError("no solver")


def test_an_engine_that_raises_fails_and_an_engine_that_lacks_a_token_is_unsupported() -> None:
    rows = run(from_engine(Raises, name="raises"), "drift", "friction")
    found = {row.scene: (row.verdict, row.note) for row in rows}
    assert found["moving_body"] == (FAILED, "RuntimeError: no solver")
    assert found["spinning_body"] == (UNSUPPORTED, "lacks gyroscopic")
    assert found["box_at_45_degrees"] == (UNSUPPORTED, "lacks coulomb_isotropic")


class Diverges(RigidEngine):
    def step(self, dt: float) -> None:
        self.y = np.full_like(self.y, np.nan)


def test_states_that_are_not_numbers_pass_nothing_but_the_same_bits() -> None:
    engine = from_engine(Diverges, name="diverges", order=2, tokens=rigid_engine.TOKENS)
    rows = run(engine)
    assert failed(rows) == set(TEXTS) - {"same_bits"}
    assert {row.verdict for row in rows if row.name not in ("same_bits", "start")} == {FAILED}
    assert {row.scene for row in rows if row.name == "start" and row.verdict == FAILED} == {
        "first_step_of_a_turned_body"
    }


class BodyRates(RigidEngine):
    def read(self) -> Readings:
        found = super().read()
        bodies = {}
        for name, (place, attitude, velocity, spin) in found.bodies.items():
            along: Any = Rotation.from_quat(attitude).inv().apply(spin).tolist()
            bodies[name] = place, attitude, velocity, along
        return Readings(found.joints, bodies)


class BodyRatesBoth(BodyRates):
    def load(self, scene: Scene) -> None:
        super().load(scene)
        for name in self.bodies.keys() - self.joints.keys():
            part = self.y[self.places[name]]
            part[10:] = Rotation.from_quat(part[3:7]).apply(part[10:])


class ScalarFirst(RigidEngine):
    def read(self) -> Readings:
        found = super().read()
        bodies: Any = {n: (x, (q[3], *q[:3]), v, w) for n, (x, q, v, w) in found.bodies.items()}
        return Readings(found.joints, bodies)


class ExchangedVelocities(RigidEngine):
    def read(self) -> Readings:
        found = super().read()
        return Readings(found.joints, {n: (x, q, w, v) for n, (x, q, v, w) in found.bodies.items()})


class Degrees(RigidEngine):
    def read(self) -> Readings:
        found = super().read()
        bodies: Any = {n: (x, q, v, tuple(np.degrees(w).tolist())) for n, (x, q, v, w) in found.bodies.items()}
        return Readings(found.joints, bodies)


class UpAlongY(RigidEngine):
    def read(self) -> Readings:
        """Its readings are in a frame whose y axis is up."""

        def up(vector: Any) -> Any:
            return vector[0], vector[2], -vector[1]

        found = super().read()
        bodies = {n: (up(x), (*up(q[:3]), q[3]), up(v), up(w)) for n, (x, q, v, w) in found.bodies.items()}
        return Readings(found.joints, bodies)


class StepLate(RigidEngine):
    def load(self, scene: Scene) -> None:
        super().load(scene)
        self.before = self.y.copy()

    def step(self, dt: float) -> None:
        self.before = self.y.copy()
        super().step(dt)

    def read(self) -> Readings:
        now, self.y = self.y, self.before
        found = super().read()
        self.y = now
        return found


@pytest.mark.parametrize(
    ("engine", "convention"),
    [
        (BodyRates, "angular velocity is along the body's axes"),
        (BodyRatesBoth, "at load and in readings, angular velocity is along"),
        (ScalarFirst, "order w, x, y, z"),
        (ExchangedVelocities, "exchanged"),
        (Degrees, "degrees"),
        (UpAlongY, "y axis is up"),
        (StepLate, "one step late"),
    ],
)
def test_the_start_names_the_convention_of_an_engine(engine: Callable[[], Any], convention: str) -> None:
    found = preflight.name_convention(rigid_engine.rigid(engine))
    assert found is not None
    assert convention in found


def test_an_engine_with_the_conventions_of_a_scene_has_no_other() -> None:
    assert preflight.name_convention(SOUND) is None
    assert preflight.name_convention(rigid_engine.PLANTED["gyroscopic_term"]) is None


class LosesCoordinates(RigidEngine):
    def step(self, dt: float) -> None:
        super().step(dt)
        self.y[0] = np.nan


def test_one_coordinate_that_is_not_a_number_fails() -> None:
    """The rate of the joint is right in the first step, and is compared after the coordinate."""
    engine = from_engine(LosesCoordinates, name="loses", tokens=rigid_engine.TOKENS)
    assert {row.verdict for row in run(engine, "joint_axes")} == {FAILED}


def test_an_engine_without_an_order_has_none_to_verify() -> None:
    engine = from_engine(RigidEngine, name="no order", tokens=rigid_engine.TOKENS)
    assert {row.note for row in run(engine, "declared_order")} == {"it declares no order"}


def test_the_motion_of_comparison_keeps_energy_and_angular_momentum() -> None:
    """Runge-Kutta steps of 1/512 err by about 1e-11."""
    start = SMOOTH["tumbling_body"][2]
    end = flow(tumbling_rates, start, 1.0, 512)
    for before, after in zip(*map(_conserved, (start, end)), strict=True):
        assert np.allclose(before, after, rtol=1e-9, atol=0)
    assert not np.allclose(start, end, atol=0.1)


def _conserved(state: Floats) -> tuple[Floats, float]:
    """Angular momentum and twice the energy of rotation."""
    turn, spin = Rotation.from_quat(state[3:7]), state[10:]
    momentum = turn.apply(np.array(INERTIA) * turn.inv().apply(spin))
    return momentum, float(momentum @ spin)


def test_pybullet_as_shipped_fails_all_pre_flights_of_motion() -> None:
    pytest.importorskip("pybullet", reason="pybullet has wheels up to CPython 3.11 only")
    from gnomon.harness.adapters.engines.bullet.pybullet import PyBulletAsShipped

    passed = {"start", "same_bits", "first_step", "declared_order"}  # it declares no order
    assert failed(run(PyBulletAsShipped())) == set(TEXTS) - passed


def test_pybullet_configured_passes() -> None:
    pytest.importorskip("pybullet", reason="pybullet has wheels up to CPython 3.11 only")
    from gnomon.harness.adapters.engines.bullet.pybullet import PyBullet

    rows = run(PyBullet())
    assert {row.verdict for row in rows} == {PASSED}

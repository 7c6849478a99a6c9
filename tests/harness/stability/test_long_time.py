"""The panel of long motions: laws of known methods, planted drifts, and the fits of known series."""

from collections.abc import Callable
from typing import Any, ClassVar

import mpmath
import numpy as np
import pytest
from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.forms import SecondOrder
from gnomon.cases.core.registry import get
from gnomon.harness.contract import validation
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solution, Solver, Steps
from gnomon.harness.integrators.multistep_extrapolation.stormer import stormer_weights
from gnomon.harness.measuring.score import NUMPY
from gnomon.harness.registry.lookup import find_one
from gnomon.harness.stability.long_time import (
    STEP,
    ULP,
    brouwer,
    fit_growth,
    invariant,
    is_truncation,
    long_time,
    oscillator,
    run,
)
from gnomon.harness.studies.growth import Subject

SECONDS = 0.01
Force = Callable[[Floats], Floats]


class Planted(Integrator):
    """A method of equal steps for q'' = a(q), all starts at once."""

    name, library, order, accepts, sweep = "planted", "planted", 2, (SecondOrder,), Steps()
    step: ClassVar[Callable[[Force, Floats, Floats, float], tuple[Floats, Floats]]]

    def prepare(self, problem: Problem, setting: float) -> Solver:
        form, parameters = problem.form, tuple(problem.parameters.tolist())
        assert isinstance(form, SecondOrder)
        equations, half = rebind(form.acceleration, NUMPY), problem.dimension // 2
        count = round(problem.interval / setting)

        def force(q: Floats) -> Floats:
            return np.stack(equations(0.0, tuple(np.moveaxis(q, -1, 0)), parameters), axis=-1)

        def solve(starts: Floats) -> Solution:
            q, v = starts[:, :half], starts[:, half:]
            states = np.empty((len(starts), len(problem.times), problem.dimension))
            for k in range(len(problem.times)):
                for _ in range(count):
                    q, v = type(self).step(force, q, v, problem.interval / count)
                states[:, k] = np.concatenate([q, v], axis=1)
            return Solution(states, steps=count * len(problem.times) * len(starts))

        return Solver(solve)


def verlet(force: Force, q: Floats, v: Floats, h: float) -> tuple[Floats, Floats]:
    middle = v + h / 2 * force(q)
    q = q + h * middle
    return q, middle + h / 2 * force(q)


def damped(force: Force, q: Floats, v: Floats, h: float) -> tuple[Floats, Floats]:
    q, v = verlet(force, q, v, h)
    return q, v * (1 - 1e-5)


def stale_force(force: Force, q: Floats, v: Floats, h: float) -> tuple[Floats, Floats]:
    a = force(q)
    return q + h * v + h * h / 2 * a, v + h * a


def chopped(force: Force, q: Floats, v: Floats, h: float) -> tuple[Floats, Floats]:
    """Each new velocity is rounded towards zero, to 48 bits."""
    q, v = verlet(force, q, v, h)
    unit = 2.0**-48
    return q, np.trunc(v / unit) * unit


def single(force: Force, q: Floats, v: Floats, h: float) -> tuple[Floats, Floats]:
    q, v = verlet(force, q, v, h)
    return q.astype(np.float32).astype(np.float64), v.astype(np.float32).astype(np.float64)


def does_not_move(force: Force, q: Floats, v: Floats, h: float) -> tuple[Floats, Floats]:
    return q, 0.0 * v


def made(step: Callable[..., Any]) -> Integrator:
    return type("Planted", (Planted,), {"step": staticmethod(step)})()


def test_verlet_keeps_energy_bounded_and_its_invariant_to_a_random_walk() -> None:
    data = long_time.measured(made(verlet), SECONDS)
    (row,) = data["runs"]
    assert (data["case"], row["energy"]["class"]) == ("pendulum_simple", "bounded")
    assert data["oscillator"]["drift_ulp"] < 100
    assert abs(data["oscillator"]["bias_ulp_a_step"]) < 0.02
    assert any(text.startswith("Use it for") and "bounded" in text for text in long_time.sentences(data))


@pytest.mark.parametrize(
    ("step", "seen"),
    [
        (damped, lambda data: data["runs"][0]["energy"]["low"] > 0.5),
        (stale_force, lambda data: data["runs"][0]["energy"]["class"] not in ("bounded", "sqrt t")),
        (chopped, lambda data: abs(data["oscillator"]["bias_ulp_a_step"]) > 5 * data["oscillator"]["bias_error"]),
        (single, lambda data: data["oscillator"]["drift_ulp"] is None or data["oscillator"]["drift_ulp"] > 1e6),
    ],
    ids=["damped", "stale force", "rounds towards zero", "single precision"],
)  # fmt: skip
def test_each_planted_drift_is_seen(step: Callable[..., Any], seen: Callable[[dict[str, Any]], bool]) -> None:
    assert seen(long_time.measured(made(step), SECONDS))


def test_a_method_that_limits_its_steps_is_measured_as_far_as_it_goes() -> None:
    class Limited(Planted):
        step = staticmethod(verlet)

        def prepare(self, problem: Problem, setting: float) -> Solver:
            if problem.elapsed[-1] / setting > 10_000:
                raise Refused("planted: more than 10000 steps")
            return super().prepare(problem, setting)

    case = get("pendulum_simple").rounded()
    subject = Subject("planted", 64.0, "", "pendulum_simple", 64, 8, together=8, samples=256)
    found = run(Limited(), case, subject, 1e4)
    assert found["energy"]["class"] == "bounded"
    assert found["stopped"].endswith("periods: planted: more than 10000 steps")
    data = {"case": "pendulum_simple", "runs": [{"setting": 64.0, "named": "64 steps a period"} | found]}
    assert any("planted: more than 10000 steps" in text for text in long_time.sentences(data))


def test_rk4_loses_the_energy_that_its_stability_function_says() -> None:
    """|R(ih)|^2 - 1 = -h^6/72 + h^8/576: it has no invariant, and its loss is not round-off."""
    found = oscillator(find_one("gnomon:RK4"), 0.1, 8)
    assert found["drift_ulp"] is None
    assert found["energy_change_a_step"] == pytest.approx(-(STEP**6) / 72 + STEP**8 / 576, rel=1e-4)


@pytest.mark.parametrize(("name", "law"), [("gnomon:RK4", ["t"]), ("gnomon:Kahan-Li 8", ["bounded"])])
def test_in_house_laws_of_energy(name: str, law: list[str]) -> None:
    (row,) = long_time.measured(find_one(name), 0.3)["runs"]
    assert [row["energy"]["class"]] == law
    assert row["energy"]["high"] - row["energy"]["low"] < 0.3


def test_brouwers_law_is_kept_by_ias15_and_its_phase_error_grows_with_the_power_three_halves() -> None:
    """An unbiased energy error of round-off is a random walk; the phase is its sum: t^(3/2) (Brouwer 1937)."""
    row = long_time.measured(find_one("rebound:IAS15"), 0.0)["runs"][-1]
    three_standard_errors = 0.33  # of 8 starts, whose powers of a random walk over two decades scatter by 0.3
    assert abs(row["energy"]["power"] - 0.5) < three_standard_errors
    assert abs(row["position"]["power"] - 1.5) < three_standard_errors
    assert not brouwer(row).startswith("not kept")


def test_pybullet_in_maximal_coordinates_loses_the_energy_which_is_not_called_bounded() -> None:
    pytest.importorskip("pybullet", reason="it has wheels up to CPython 3.11")
    row = long_time.measured(find_one("pybullet:stepSimulation [configured, maximal coordinates]"), SECONDS)["runs"][0]
    assert row["energy"]["class"] == "lost"


TIMES = np.arange(1.0, 1025.0)


def series(kind: str) -> Floats:
    rng = np.random.default_rng(5)
    noise = rng.normal(size=(24, 1024))
    walk = np.cumsum(noise, axis=1) * 1e-15
    waves = np.abs(np.sin(TIMES + rng.uniform(0, 6, size=(24, 1))))
    return {
        "bounded": 1e-6 * waves, "sqrt t": np.abs(walk), "t": 1e-9 * TIMES * (1 + 0.01 * noise),
        "t^2": 1e-9 * TIMES**2 * (1 + 0.01 * noise), "t^1.5": np.abs(np.cumsum(walk, axis=1)), "lost": 0.998 + 0 * noise,
    }[kind]  # fmt: skip


@pytest.mark.parametrize("kind", ["bounded", "t", "t^2", "lost"])
def test_the_class_of_a_known_series(kind: str) -> None:
    assert fit_growth(TIMES, series(kind))["class"] == kind


@pytest.mark.parametrize(("kind", "power"), [("sqrt t", 0.5), ("t^1.5", 1.5)])
def test_the_interval_of_a_random_walk_holds_its_power(kind: str, power: float) -> None:
    found = fit_growth(TIMES, series(kind))
    assert found["low"] < power < found["high"]
    assert found["high"] - found["low"] < 0.5


def a_run(
    energy: tuple[float, float], position: tuple[float, float], ulp: float, steps: float | None
) -> dict[str, Any]:
    """A run with these intervals of the powers and this energy error in ulp at the end."""
    (low, high), (below, above) = energy, position
    return {
        "energy": {"low": low, "high": high, "class": "", "size": ulp * ULP},
        "position": {"low": below, "high": above, "class": ""}, "steps": steps,
    }  # fmt: skip


KEPT = ((0.42, 0.59), (1.38, 1.61), 60.0, 2.6e6)


@pytest.mark.parametrize(
    ("row", "word"),
    [
        (KEPT, "kept"),
        (((0.11, 0.33), *KEPT[1:]), "kept"),  # slower than a random walk
        (((0.9, 1.1), *KEPT[1:]), "not kept"),
        (((0.72, 0.82), *KEPT[1:]), "not kept"),
        (((0.3, 1.2), *KEPT[1:]), "undecided"),
        (((0.0, 0.83), (1.05, 2.02), 247.0, None), "undecided"),  # SciPy's Radau from 3 starts
        (((0.33, 0.57), (1.98, 2.14), 6200.0, 1.5e5), "not kept"),  # diffrax Dopri8: the phase grows as t^2
        (((0.18, 0.31), (1.0, 1.2), 3e5, 3e4), "not kept"),  # Radau IIA 5: truncation
        (((0.52, 0.75), (1.51, 1.79), 3.7e4, 3e4), "not kept"),  # REBOUND BS: truncation
        ((*KEPT[:3], None), "undecided"),  # its steps are not counted
    ],
)
def test_brouwers_law_wants_the_powers_of_energy_and_position_and_an_error_of_the_size_of_round_off(
    row: Any, word: str
) -> None:
    said = brouwer(a_run(*row))
    assert said.startswith(f"{word} (")
    assert f"power {row[0][0]:.2f} to {row[0][1]:.2f}" in said


def test_brouwers_law_is_not_kept_where_the_energy_or_the_phase_is_lost() -> None:
    lost = {"low": None, "high": None, "class": "lost", "size": 0.5}
    assert brouwer(a_run(*KEPT) | {"energy": lost}).startswith("not kept")
    assert brouwer(a_run(*KEPT) | {"position": lost}).startswith("not kept")


def test_radau_does_not_keep_brouwers_law() -> None:
    """Its energy error at its tightest tolerance is truncation, some 1e5 ulp."""
    case, method = get("pendulum_simple").rounded(), find_one("gnomon:Radau IIA 5")
    subject = Subject(method.id, method.sweep.tightest, "", "pendulum_simple", 64, 4, together=4, samples=256)
    found = run(method, case, subject, 0.0)
    assert found["tightest"]
    assert brouwer(found).startswith("not kept")


def test_a_method_that_counts_steps_and_does_not_move_is_refused() -> None:
    """Its energy has no error, for any number of periods."""
    (row,) = long_time.measured(made(does_not_move), SECONDS)["runs"]
    assert row["refused"] == validation.DID_NOT_MOVE


def principal_root(order: int) -> mpmath.mpf:
    """|r|^2 of the root of q_n+1 - 2 q_n + q_n-1 = -h^2 sum w_m (differences of order m of q_n) nearest to exp(i h)."""
    with mpmath.workdps(40):
        h, one = mpmath.mpf(STEP), mpmath.mpf(1)
        weights = [one * w.numerator / w.denominator for w in stormer_weights(order)]

        def polynomial(r: Any) -> Any:
            back = 1 - 1 / r
            return r - 2 + 1 / r + h * h * sum(w * back**m for m, w in enumerate(weights))

        return abs(mpmath.findroot(polynomial, mpmath.exp(1j * h))) ** 2


def test_the_bias_of_stormer_12_is_truncation_by_its_principal_root() -> None:
    found = oscillator(find_one("gnomon:Störmer 12"), 1.0, 4)
    assert found["bias_ulp_a_step"] * ULP == pytest.approx(float(principal_root(12) - 1), rel=1e-3)
    data = {"case": "", "runs": [], "oscillator": found}
    (said,) = long_time.sentences(data)
    assert said.startswith("Truncation, not round-off")
    assert not any(mark.column == "drift" for mark in long_time.marks(data))


def test_a_bias_of_rounding_is_not_called_truncation() -> None:
    found = oscillator(made(chopped), 0.02, 8)
    assert found["half_step"] is not None
    assert not is_truncation(found)


def test_the_energy_of_a_multistep_method_changes_as_its_principal_root() -> None:
    found = oscillator(find_one("gnomon:Störmer 8"), 0.1, 8)
    assert found["energy_change_a_step"] == pytest.approx(float(principal_root(8) - 1), rel=0.02)


def test_explicit_euler_gains_the_square_of_its_step() -> None:
    """|1 + ih|^2 - 1 = h^2 in each step, not the mean over many, which compounds."""
    found = oscillator(find_one("gnomon:Explicit Euler"), 0.1, 8)
    assert found["energy_change_a_step"] == pytest.approx(STEP**2, rel=1e-9)


def test_the_invariant_of_a_turning_ellipse_is_found_and_a_spiral_has_none() -> None:
    phase = 0.1 * np.arange(64) + np.arange(3)[:, None]
    ellipse = np.stack([2 * np.cos(phase), np.sin(phase)], axis=-1)
    form, spread = invariant(ellipse)
    assert spread < 1e-15
    assert abs(form[1]) < 1e-14
    assert form[2] / form[0] == pytest.approx(4)
    spiral = ellipse * np.exp(-1e-6 * phase)[..., None]
    assert invariant(spiral)[1] > 1e-8


def test_events_have_no_long_motion() -> None:
    assert "not_applicable" in long_time.measured(find_one("gnomon:RK4 [events]"), 1.0)

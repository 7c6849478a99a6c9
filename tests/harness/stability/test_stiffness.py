"""Cost and errors on a fast decay agree with theory; planted faults of pairs and of implicit methods show."""

import math
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from gnomon.harness.contract.integrator import Integrator, Tolerance
from gnomon.harness.integrators.base.tableau import ButcherTableau
from gnomon.harness.integrators.runge_kutta.embedded import Embedded
from gnomon.harness.registry import lookup
from gnomon.harness.stability.stiffness import FREE, LOOSE, RATE, VERY_FAST, measure_fixed_steps, row, stiffness
from gnomon.harness.verification.function_adapter import from_solve, from_step

PAIRS = ("Bogacki-Shampine 3(2)", "Dormand-Prince 5(4)", "Tsitouras 5(4)", "Verner 6(5)", "DOP853")


def measured(integrator: Integrator, seconds: float = 2.0) -> dict[str, Any]:
    found = stiffness.measured(integrator, seconds)
    assert "refused" not in found, found
    return found


def limit_of(tableau: ButcherTableau) -> float:
    """The first x at which |R(-x)| exceeds 1, with R(z) = 1 + z b (1 - z A)^-1 1 (Hairer and Wanner, IV.3)."""
    rows, stages = tableau.rows(mpmath.mp), len(tableau.a)
    a, b = np.array([row[1 : stages + 1] for row in rows[:stages]], dtype=float), np.array(rows[stages][1 : stages + 1])
    weights, one = b.astype(float), np.eye(stages)

    def grows(x: float) -> bool:
        return bool(abs(1 - x * weights @ np.linalg.solve(one + x * a, np.ones(stages))) > 1)

    return next(float(x) for x in np.arange(0.001, 20, 0.001) if grows(x))


@pytest.mark.parametrize("name", PAIRS)
def test_steps_of_explicit_pairs_are_at_the_limit_of_their_tableau(name: str) -> None:
    """Within 2 %: the step control makes the steps go back and forth about the limit."""
    integrator = lookup.own()[f"gnomon:{name}"]
    assert isinstance(integrator, Embedded)
    found = measured(integrator)
    assert found["rows"][-1]["h_rate"] == pytest.approx(limit_of(integrator.tableau), rel=0.02)
    assert found["power"] == pytest.approx(1.0, abs=0.1)


def test_the_limits_of_two_pairs_are_those_in_the_books() -> None:
    """2.51 for the exponential series to order 3, 3.31 for Dormand-Prince (Hairer and Wanner, IV.2)."""
    methods = [lookup.own()[f"gnomon:{name}"] for name in PAIRS[:2]]
    limits = [limit_of(method.tableau) for method in methods if isinstance(method, Embedded)]
    assert limits == [pytest.approx(2.513, abs=2e-3), pytest.approx(3.307, abs=2e-3)]


@pytest.mark.parametrize("identity", ["gnomon:Radau IIA 5", "scipy:Radau", "scipy:LSODA"])
def test_stiff_solvers_do_not_pay_for_the_rate(identity: str) -> None:
    found = measured(lookup.own()[identity])
    assert found["power"] < FREE
    assert found["rows"][-1]["rate"] == VERY_FAST


def test_the_interpolant_of_scipys_radau_is_wrong_between_long_steps() -> None:
    """At tolerance 1e-4 and rate 1e6 its last state is right to 2e-6, a sample is off by more than 1; LSODA is right."""
    rows = {row["tolerance"]: row for row in measured(lookup.own()["scipy:Radau"])["rows"] if row["rate"] == 1e6}
    assert rows[1e-4]["last"] < 1e-5
    assert rows[1e-4]["worst"] > 1.0
    good = measured(lookup.own()["scipy:LSODA"])
    assert all(row["worst"] < row["tolerance"] for row in good["rows"])
    assert not any("between its steps" in text for text in stiffness.sentences(good))


@pytest.mark.parametrize("stages", [2, 3, 4, 5])
def test_the_order_of_gauss_methods_is_reduced_to_that_of_their_stages(stages: int) -> None:
    """Prothero and Robinson: s for even s, s + 1 for odd s, where R(-infinity) is 1 or -1 (Hairer and Wanner, IV.15)."""
    found = measured(lookup.own()[f"gnomon:Gauss {stages}-stage"])
    assert found["stiff_order"] == pytest.approx(stages + stages % 2, abs=0.1)
    assert any(f"Not for its order {2 * stages}" in text for text in stiffness.sentences(found))


def test_explicit_methods_of_fixed_steps_are_not_for_stiff_decay() -> None:
    (said,) = stiffness.sentences(measured(lookup.own()["gnomon:RK4"]))
    assert said.startswith("Not for stiff decay")


def test_methods_without_first_order_equations_are_not_measured() -> None:
    assert "first order" in stiffness.measured(lookup.own()["gnomon:Störmer-Verlet"], 2.0)["not_applicable"]


def a_row(rate: float, calls: int | None, fewest: int = 200, **more: str) -> dict[str, Any]:
    return {"rate": rate, "tolerance": LOOSE, "calls": calls, "steps": None, "h_rate": None, "calls_per_rate": None,
            "last": 1e-5, "worst": 1e-5, "fewest": fewest} | more  # fmt: skip


def test_a_method_whose_calls_fall_with_the_rate_is_not_suited_where_they_are_many() -> None:
    """Fast Gauss: 323,208 calls at rate 1e3, where Radau takes 463; from 1e4 on it is Radau."""
    rows = [a_row(1e3, 323_208), a_row(1e4, 38_976), a_row(1e6, 46_632)]
    (said,) = stiffness.sentences({"rows": rows, "power": -0.92})
    assert said.startswith("Not for stiff decay: 323208 calls at rate 1000")


def test_a_method_is_suited_only_where_its_calls_are_near_the_fewest_at_every_rate() -> None:
    (said,) = stiffness.sentences({"rows": [a_row(1e3, 463), a_row(1e4, 434), a_row(1e6, 427)], "power": -0.03})
    assert said.startswith("Suited to stiff decay, on one equation at rates 1000 to 1e+06: at most 2.3 times")
    (said,) = stiffness.sentences({"rows": [a_row(1e3, 463), a_row(1e4, 434), a_row(1e6, 6368)], "power": -0.2})
    assert said.startswith("Not for stiff decay: 6368 calls at rate 1e+06")
    (said,) = stiffness.sentences({"rows": [a_row(1e3, None, why="its calls are not counted")], "power": 0.0})
    assert said == "Not compared on stiff decay: its calls are not counted."


def test_no_sentence_recommends_a_method_from_one_equation() -> None:
    for name in ("gnomon:Radau IIA 5", "gnomon:Gauss 4-stage"):
        said = stiffness.sentences(measured(lookup.own()[name]))
        assert any(text.startswith("Suited to stiff decay, on one equation") for text in said)
        assert not any(text.startswith("Use it") for text in said)


def test_calls_of_fixed_steps_are_those_of_the_fewest_steps_with_the_error() -> None:
    """Implicit midpoint has an error of 2.4e-4 with the most steps that are measured: no number of calls."""
    row = measure_fixed_steps(lookup.own()["gnomon:Gauss 8-stage"], VERY_FAST)
    assert row["worst"] <= LOOSE
    assert 0 < row["calls"] < 10 * row["fewest"]
    assert measure_fixed_steps(lookup.own()["gnomon:Implicit midpoint"], VERY_FAST)["calls"] is None


def test_a_slow_method_is_measured_at_a_smaller_second_rate() -> None:
    """Less time than the first rate takes: no second one, and no power."""
    found = measured(lookup.own()["gnomon:Bogacki-Shampine 3(2)"], 1e-9)
    assert len(found["rows"]) == 1
    assert found["power"] is None


def euler_with_control(solve_stage: Callable[..., Any], interpolant: str = "linear") -> Callable[..., Any]:
    """Implicit Euler with step control by doubling; samples by interpolation between its steps."""

    def solve(f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
        t, y, h, found = t0, y0, 1e-3, []
        while len(found) < len(times):
            one = solve_stage(f, t + h, y, h)
            half = solve_stage(f, t + h / 2, y, h / 2)
            two = solve_stage(f, t + h, half, h / 2)
            error = float(np.max(np.abs(two - one))) / tolerance
            if error <= 1 or h < 1e-9:
                while len(found) < len(times) and times[len(found)] <= t + h:
                    share = (times[len(found)] - t) / h
                    found.append(y + share * (two - y) if interpolant == "linear" else (y if share < 1 else two))
                t, y = t + h, two
            h *= min(5.0, max(0.2, 0.9 / max(math.sqrt(error), 1e-3)))
        return np.array(found)

    return solve


def newton(f: Any, t: float, y: Any, h: float) -> Any:
    """u = y + h f(t, u) for one linear equation: exact after one step with the slope by a difference."""
    slope = (f(t, y + 1.0) - f(t, y)) / 1.0
    return y + h * f(t, y) / (1 - h * slope)


def explicit(f: Any, t: float, y: Any, h: float) -> Any:
    return y + h * f(t - h, y)


def late(f: Any, t: float, y: Any, h: float) -> Any:
    """The stage at the beginning of the step in place of its end."""
    slope = (f(t, y + 1.0) - f(t, y)) / 1.0
    return y + h * f(t - h, y) / (1 - h * slope)


def made(solve: Callable[..., Any], name: str) -> Integrator:
    return from_solve(solve, name=name, order=1, sweep=Tolerance(1e-2, 1e-8), dense_order=1)


def test_an_implicit_method_of_a_user_is_for_stiff_decay() -> None:
    found = measured(made(euler_with_control(newton), "implicit Euler"))
    assert found["power"] < FREE
    assert found["rows"][0]["worst"] < 0.05


def test_an_explicit_method_with_step_control_is_not() -> None:
    """Euler: h rate at most 2."""
    found = measured(made(euler_with_control(explicit), "explicit Euler with control"), 1.0)
    assert found["power"] is None or found["power"] > 0.7
    assert found["rows"][0]["h_rate"] is None
    assert found["rows"][0]["calls_per_rate"] > 1.0


def undamped(f: Any, t: float, y: Any, h: float) -> Any:
    """Half of the slope in Newton's step: a component that it should damp at once alternates in sign."""
    slope = (f(t, y + 1.0) - f(t, y)) / 1.0
    return y + h * f(t, y) / (1 - h * slope / 2)


def test_faults_of_an_implicit_method_show_at_one_rate() -> None:
    """In its errors at samples (a constant interpolant), or in its steps (a stage at the wrong time, a wrong slope)."""

    def found(solve: Callable[..., Any]) -> dict[str, Any]:
        return row(made(solve, "implicit Euler"), RATE / 10, LOOSE)

    good = found(euler_with_control(newton))
    assert good["worst"] < 0.05
    assert found(euler_with_control(newton, "constant"))["worst"] > 3 * good["worst"]
    assert found(euler_with_control(late))["calls"] > 2 * good["calls"]
    assert found(euler_with_control(undamped))["calls"] > 2 * good["calls"]


def test_fixed_iterations_in_place_of_a_solved_stage_show() -> None:
    def midpoint(f: Any, t: float, y: Any, h: float) -> Any:
        middle = y
        for _ in range(5):
            middle = y + h / 2 * f(t + h / 2, middle)
        return y + h * f(t + h / 2, middle)

    found = measured(from_step(midpoint, name="midpoint of five iterations", order=2))
    assert not found["stable"]


def test_a_time_argument_at_the_end_of_a_step_shows_in_the_order_on_stiff_decay() -> None:
    """The implicit midpoint rule keeps order 2 there (one stage: s + 1)."""

    def midpoint(share: float) -> Callable[..., Any]:
        def step(f: Any, t: float, y: Any, h: float) -> Any:
            slope = f(t, y + 1.0) - f(t, y)  # exact for one linear equation
            rate = f(t + share * h, y) / (1 - h / 2 * slope)
            return y + h * rate

        return step

    def found(share: float) -> dict[str, Any]:
        return measured(from_step(midpoint(share), name="midpoint", order=2))

    assert found(0.5)["stiff_order"] == pytest.approx(2, abs=0.2)
    assert found(1.0)["stiff_order"] < 1.5
    assert any("Not for its order 2" in text for text in stiffness.sentences(found(1.0)))

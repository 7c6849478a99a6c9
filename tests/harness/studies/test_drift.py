"""The fitted power and law of growths whose law is given."""

import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from gnomon.harness.results import analysis, store
from gnomon.harness.results.schema import TRIAL_COLUMNS
from gnomon.harness.studies.drift import growth, laws, rebuild_case
from gnomon.harness.studies.growth import LAWS
from on_cases import exact_states

from gnomon import cases

T = np.arange(1, 65) / 6.4


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        (1e-15 * T, "round-off"),
        (1e-6 * np.abs(np.sin(7 * T)), "bounded"),
        (1e-6 * np.sqrt(T), "sqrt t"),
        (1e-6 * T, "t"),
        (1e-6 * T * (1 + 0.1 * np.sin(9 * T)), "t"),
        (1e-6 * T**1.5, "t^1.5"),
        (1e-6 * T**2, "t^2"),
        (1e-6 * T**4, "faster than t^2"),
        (1e-6 * T**0.757, "between sqrt t and t"),
        (1e-6 * T * np.where(np.arange(64) % 4 == 3, 2.0, 0.1), "t"),
        (2e-13 * T / T[-1], "t"),
        (1e-6 * np.minimum(T, T[-1] / 4) ** 3, ""),  # growth that ends within the octaves: no power of time
        (1e-9 * np.exp(1.5 * T), "exponential"),
        (np.where(T > 5, np.nan, T), "diverged"),
        (1e-6 * T[:7], ""),  # three octaves
    ],
)
def test_laws(sizes: np.ndarray, expected: str) -> None:
    assert growth(T[: len(sizes)], sizes).law == expected


@pytest.mark.parametrize(
    ("power", "name"), [(0.0, "bounded"), (0.5, "sqrt t"), (1.0, "t"), (1.5, "t^1.5"), (2.0, "t^2")]
)
def test_a_wrong_law_is_named_less_than_once_in_twenty(power: float, name: str) -> None:
    """For oscillations that grow as a power, with a period from a third of the span to two samples."""
    random = np.random.default_rng(5)
    others = {law for law in LAWS if law != name}
    held = wrong = right = 0
    for rate, phase in zip(random.uniform(2, 20, 200), random.uniform(0, math.pi, 200), strict=True):
        found = growth(T, 1e-6 * T**power * (np.abs(np.sin(rate * T + phase)) + 1e-3))
        held += found.low <= power <= found.high
        wrong += found.law in others
        right += found.law == name
    assert held >= 190
    assert wrong < 10
    assert right > 100


def test_for_random_walks_the_interval_contains_one_half() -> None:
    """An interval from residuals of a line would in 73 to 90 of 100 only, as samples of a walk are not independent."""
    random = np.random.default_rng(6)
    found = [growth(T, np.abs(1e-6 * np.cumsum(random.standard_normal(64)))) for _ in range(300)]
    assert sum(one.low <= 0.5 <= one.high for one in found) >= 0.95 * 300 - 2 * math.sqrt(0.95 * 0.05 * 300)
    assert sum(one.law in ("t", "t^1.5", "t^2") for one in found) < 15


def test_a_case_is_rebuilt_from_its_stored_numbers() -> None:
    case = cases.get("pendulum_simple", "rotation").rounded()
    numbers = {name: str(value) for name, value in case.numbers.items()}
    again = rebuild_case(cases.case_class("pendulum_simple"), "rotation", numbers, float(case.span))
    assert (again.numbers, again.span, again.variant) == (case.numbers, Fraction(float(case.span)), "rotation")


def test_a_case_with_other_parameters_than_stored_is_refused() -> None:
    with pytest.raises(ValueError, match="theta"):
        rebuild_case(cases.case_class("pendulum_simple"), "", {"g": "1", "L": "1", "omega": "0"}, 1.0)


def test_laws_are_those_of_the_setting_whose_error_is_nearest_1e_5(tmp_path: Path) -> None:
    case = cases.get("pendulum_simple").rounded()
    exact, times = exact_states(case), case.times / case.times[-1]
    numbers = {name: str(value) for name, value in case.numbers.items()}
    texts = [name for name, kind in TRIAL_COLUMNS.items() if kind.startswith("TEXT")]
    trial = dict.fromkeys(texts, "") | {"case": case.name, "variant": "default", "series": "one"}
    trial |= {"formulation": "standard", "integrator_id": "l:one", "span": float(case.span), "numbers": numbers}
    growths = {1e-2: times**2, 2e-5: times, 1e-5: times**2, 1e-9: np.sqrt(times)}
    with store.Store(tmp_path / "results.sqlite") as results:
        run = results.begin_run("quick", "", {})
        results.plan(run, [trial | {"trial_key": str(size), "setting": size} for size in growths])
        for size, grown in growths.items():
            states = exact + np.outer(size * grown, [1.0, 0.0])
            status = "inaccurate" if size == 1e-5 else "ok"
            row = {"trial_key": str(size), "launch": 1, "status": status, "error_max": size}
            results.add(run, row, None, states)
    frame = analysis.tidy(store.load(tmp_path))
    found = laws(tmp_path, frame, frame["variant"] == "", {case.name: type(case)}).set_index("quantity")
    assert set(found.index) == {"error", "energy"}
    assert found.loc["error", ["setting", "law"]].tolist() == [2e-5, "t"]
    assert laws(tmp_path, frame, frame["variant"] == "", {}).empty  # no laws for a case that is not known
    # theta is scaled by its amplitude, 2 rad
    assert found.loc["error", "size"] == pytest.approx(1e-5, rel=1e-6)

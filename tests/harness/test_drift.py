"""The law of growth, on growths whose law is known."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from gnomon.harness import analysis, store
from gnomon.harness.drift import law, laws, rebuilt
from gnomon.harness.schema import TRIAL_COLUMNS

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
        (1e-6 * T**2, "t^2"),
        (1e-6 * T**4, "faster than t^2"),
        # halfway between two laws (t and its neighbours: at 0.75 and 1.5), a little on either side
        (1e-6 * T**0.2, "bounded"),
        (1e-6 * T**0.3, "sqrt t"),
        (1e-6 * T**0.7, "sqrt t"),
        (1e-6 * T**0.8, "t"),
        (1e-6 * T**1.45, "t"),
        (1e-6 * T**1.55, "t^2"),
        (1e-6 * T**2.45, "t^2"),
        (1e-6 * T**2.55, "faster than t^2"),
        (1e-6 * np.where(np.arange(64) % 16 == 15, T, 1e-9), "t"),  # of the largest so far, not of the last
        (2e-13 * T / T[-1], "t"),
        (1e-6 * np.minimum(T, T[-1] / 4) ** 3, "bounded"),  # a start-up
        (1e-9 * np.exp(1.5 * T), "exponential"),
        (np.where(T > 5, np.nan, T), "diverged"),
    ],
)
def test_laws(sizes: np.ndarray, expected: str) -> None:
    assert law(T, sizes) == expected


def test_a_case_is_rebuilt_from_its_stored_numbers() -> None:
    case = cases.get("pendulum_simple", "rotation").rounded()
    numbers = {name: str(value) for name, value in case.numbers.items()}
    again = rebuilt(cases.case_class("pendulum_simple"), "rotation", numbers, float(case.span))
    assert (again.numbers, again.span, again.variant) == (case.numbers, Fraction(float(case.span)), "rotation")


def test_a_case_that_has_changed_since_is_refused() -> None:
    with pytest.raises(ValueError, match="theta"):
        rebuilt(cases.case_class("pendulum_simple"), "", {"g": "1", "L": "1", "omega": "0"}, 1.0)


def test_laws_are_those_of_the_setting_whose_error_is_nearest_1e_5(tmp_path: Path) -> None:
    case = cases.get("pendulum_simple").rounded()
    exact, times = case.sample(case.times), case.times / case.times[-1]
    numbers = {name: str(value) for name, value in case.numbers.items()}
    texts = [name for name, kind in TRIAL_COLUMNS.items() if kind.startswith("TEXT")]
    trial = dict.fromkeys(texts, "") | {"case": case.name, "variant": "default", "series": "one"}
    trial |= {"formulation": "standard", "integrator_id": "l:one", "span": float(case.span), "numbers": numbers}
    growths = {1e-2: times**2, 2e-5: times, 1e-5: times**2, 1e-9: np.sqrt(times)}
    with store.Store(tmp_path / "results.sqlite") as results:
        run = results.begin_run("quick", "", {})
        results.plan(run, [trial | {"trial_key": str(size), "setting": size} for size in growths])
        for size, growth in growths.items():
            states = exact + np.outer(size * growth, [1.0, 0.0])
            status = "inaccurate" if size == 1e-5 else "ok"
            row = {"trial_key": str(size), "launch": 1, "status": status, "error_max": size}
            results.add(run, row, None, states)
    frame = analysis.tidy(store.load(tmp_path))
    found = laws(tmp_path, frame, frame["variant"] == "", {case.name: type(case)}).set_index("quantity")
    assert set(found.index) == {"error", "energy"}
    assert found.loc["error", ["setting", "law"]].tolist() == [2e-5, "t"]
    assert laws(tmp_path, frame, frame["variant"] == "", {}).empty  # a case that is not known is not looked for
    # theta is scaled by its amplitude, 2 rad
    assert found.loc["error", "size"] == pytest.approx(1e-5, rel=1e-6)

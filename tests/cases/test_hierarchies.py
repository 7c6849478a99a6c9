"""Each level's projection maps its states to states of the full case: the initial state, positions and their rates."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case, get, names
from gnomon.cases.core.forms import first_order
from gnomon.cases.core.metric import RATES

HIERARCHIES = [name for name in names() if get(name).hierarchy]
ANOTHER_START = {
    (spring, "pendulum_simple"): "a rod is as long as the spring at rest, which is stretched"
    for spring in ("spring_pendulum", "stiff_spring_pendulum")
}
OTHER_RATES = {
    ("lagrange_top", "lagrange_top_fast"): "its mean precession is not that of its tilt",
    ("lagrange_top", "lagrange_top_small_nutation"): "precession and spin are linear in the nutation",
    ("spherical_pendulum", "pendulum_simple"): "a plane swing has no azimuth that changes",
}
"""Levels whose model omits a rate or takes it from another formula, with the reason."""


def slopes(case: Case) -> Callable[[float, tuple[float, ...]], Any]:
    """The right-hand sides, of a hybrid case in its first mode: positions change at the same rates in all modes."""
    parameters = tuple(map(float, case.parameter_values()))
    if case.hybrid is None:
        form = next(found for found in map(first_order, case.all_forms()) if found is not None)
        return lambda t, state: form.equations(t, state, parameters)
    mode = case.hybrid.mode(case.hybrid.start(0.0, tuple(map(float, case.initial_state)), parameters))
    return lambda t, state: mode.equations(t, state, parameters + mode.constants)


@pytest.mark.parametrize("name", HIERARCHIES)
def test_a_projected_motion_starts_at_the_start_and_its_positions_change_at_its_rates(name: str) -> None:
    """A model is wrong only in how rates change. Rates of positions by central differences over 1e-5 time scales: the
    error is 1e-10 of the rates, plus some ulp of the position over 1e-5 by round-off."""
    full = get(name).rounded()
    start = np.array([list(map(float, full.initial_state))])
    places = [i for i, coordinate in enumerate(full.state) if coordinate.kind not in RATES]
    equations, times, h = slopes(full), full.times[2:60:19], 1e-5 * full.time_scale
    for level in full.hierarchy:
        pair = (name, level.case.name)
        first = level.project(np.array([list(map(float, level.case.initial_state))]))
        assert (full.metric.distance(first, start)[0] <= 1e-15) == (pair not in ANOTHER_START), pair
        ahead, here, behind = (level.project(level.case.sample(times + x)) for x in (h, 0.0, -h))
        changes = ((ahead - behind) / (2 * h))[:, places]
        rates = np.array([equations(t, tuple(y)) for t, y in zip(times.tolist(), here.tolist(), strict=True)])
        off = np.max(np.abs(changes - rates[:, places])) / np.max(np.abs(rates[:, places]))
        assert (off <= 1e-6) == (pair not in OTHER_RATES), (pair, off)


@pytest.mark.parametrize(
    ("name", "numbers", "factor"),
    [
        ("pendulum_simple", {"initial_state": ("0.5", 0)}, 50),
        ("foucault_pendulum_linear", {"span": 20, "L": 1, "Om": "0.3"}, 10),
        (
            "foucault_pendulum_nonlinear",
            {"initial_state": ("0.05", 0, "-0.99874921777190897", 0, 0, 0), "L": 1, "Om": "0.5", "span": 5},
            1,
        ),
    ],
)
def test_each_level_is_closer_to_the_case(name: str, numbers: dict[str, Any], factor: float) -> None:
    full = get(name, **numbers).rounded()
    exact, models = full.sample(full.times), [level.case for level in full.hierarchy]
    crude, near = (
        np.max(full.metric.distance(level.project(level.case.sample(full.times)), exact)) for level in full.hierarchy
    )
    assert crude > factor * near > 0
    assert {model.span for model in models} == {full.span}
    if name == "pendulum_simple":
        assert [model.name for model in models] == ["harmonic_oscillator", "duffing_unforced"]

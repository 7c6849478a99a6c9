"""Sizes and time scales, by which errors are divided and steps chosen, against the extremes of the exact motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case, get, names
from gnomon.cases.forms import FirstOrder, Hybrid

TIMES = 600
SHOT = (0.99, 12.0)
"""The span of a motion without a rate of its own, in time scales: it is one throw, one run or a few impacts."""
RATE = (0.33, 3.2)
"""The rate that linearised equations have on the way, times the time scale: half of the samples are above or below."""
IMPACTS = ("ballistic_pendulum",)
"""The time scale is that of the impact, which the swing after it is fifty times slower than."""


@pytest.mark.parametrize("name", names())
def test_sizes_are_the_largest_norms_of_the_exact_motion(name: str) -> None:
    """Every published error is divided by a size. Samples of a smooth peak fall short of it by less than 3 %."""
    case = get(name).rounded()
    rng = np.random.default_rng(1)
    states = case.sample(np.sort(rng.uniform(0.0, float(case.times[-1]), TIMES)))
    for group in case.metric.groups:
        largest = float(np.max(np.linalg.norm(states[:, list(group.indices)], axis=1)))
        if group.wrapped:
            largest = min(largest, math.pi)
        if largest > 0:
            assert 0.97 <= largest / group.scale <= 1.02, group.name


@pytest.mark.parametrize("name", [name for name in names() if name not in IMPACTS])
def test_a_time_scale_is_that_of_the_linearised_equations_or_of_the_span(name: str) -> None:
    case = get(name).rounded()
    rate = np.median([_rate(case, t, x) for t, x in zip(case.times[::5], case.sample(case.times[::5]), strict=True)])
    scale = float(case.time_scale)
    if rate * scale > 0.02:
        assert RATE[0] < rate * scale < RATE[1]
    else:
        assert SHOT[0] < float(case.times[-1]) / scale < SHOT[1]


def _rate(case: Case, time: float, state: Any) -> float:
    """The largest rate of the equations linearised about a state (1/s), of all modes of a hybrid case."""
    parameters = tuple(map(float, case.parameter_values()))
    sizes = np.array([case.metric.groups[_group(case, i)].scale for i in range(len(state))])
    largest = 0.0
    for equations in _equations(case):
        slopes = np.zeros((len(state), len(state)))
        for j, size in enumerate(sizes):
            there, back = (np.array(state), np.array(state))
            there[j] += 1e-6 * size
            back[j] -= 1e-6 * size
            rise = np.subtract(equations(time, tuple(there), parameters), equations(time, tuple(back), parameters))
            slopes[:, j] = rise / (2e-6 * size)
        if np.all(np.isfinite(slopes)):
            largest = max(largest, float(np.max(np.abs(np.linalg.eigvals(slopes)))))
    return largest


def _group(case: Case, index: int) -> int:
    return next(i for i, group in enumerate(case.metric.groups) if index in group.indices)


def _equations(case: Case) -> list[Callable[..., Any]]:
    form = next((form for form in case.all_forms() if isinstance(form, FirstOrder)), None)
    if form is not None:
        return [form.equations]
    hybrid = next(form for form in case.all_forms() if isinstance(form, Hybrid))
    return [mode.equations for mode in hybrid.modes]

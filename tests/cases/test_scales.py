"""The scales by which errors and times are divided, compared with the motion and its equations.

A scale that is wrong by a factor of 2 makes every error of its case wrong by the same factor; a time scale determines
steps, spans, and the time between events below which a sequence of events ends.
"""

import math
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case, case_class, get, names
from gnomon.cases.core.forms import first_order
from numpy.typing import NDArray
from on_cases import exact_states
from scipy.integrate import solve_ivp

Floats = NDArray[np.float64]
CLOSED = [name for name in names() if case_class(name).scales is not Case.scales]
"""Cases that state their scales; the scales of other cases are the largest norms of many samples."""
ANOTHER_TIME = {
    "ballistic_pendulum": "the flight of the bullet, far shorter than a swing",
    "billiard_ball_drill": "the duration of sliding, in which friction changes its direction faster and faster",
    "bouncing_ball_table": "a radian of the table's vibration, with many in a flight",
    "central_force_shortened_string": "a radian of the azimuth, which follows from the length of the string",
    "kapitza_pendulum_driven": "a radian of the pivot, whose force depends on time and is no mode of the equations",
    "rigid_body_stokes_medium": "a radian at the start; the medium slows the rotation tenfold",
    "spherical_pendulum": "a radian of the azimuth where it is fastest, close to a pole",
}
"""Cases whose time scale is not the time scale of their equations, with the time that it is instead."""


def visited(case: Case) -> Floats:
    """States at the start, at the samples, and before and after each event."""
    states = [tuple(map(float, case.initial_state)), *exact_states(case).tolist()]
    if case.hybrid is not None:
        states += [tuple(map(float, state)) for event in case.events()[:200] for state in (event.before, event.after)]
    return np.array(states)


@pytest.mark.parametrize(
    "name", [*CLOSED, *(pytest.param(name, marks=pytest.mark.slow) for name in names() if name not in CLOSED)]
)
def test_scales_are_those_of_the_motion(name: str) -> None:
    """A scale is a group's largest norm: 64 samples, with events, reach 5/6 of it, and none exceeds it, a scale that is
    stated. A scale of many samples misses the last rise before an impact: by half the time between samples, 1/600 of the span,
    in which the fall of the bouncing ball on the table adds 5 % to its speed."""
    case = get(name).rounded()
    states, scales = visited(case), case.scales()
    for group, scale in scales.items():
        members = [i for i, coordinate in enumerate(case.state) if coordinate.group == group]
        largest = float(np.max(np.linalg.norm(states[:, members], axis=1)))
        if case.state[members[0]].kind == "angle":
            largest = min(largest, math.pi)
        if largest == 0:
            assert scale == case.natural_sizes.get(group, 1.0), group
        else:
            assert 0.85 < largest / scale < (1.02 if name in CLOSED or case.hybrid is None else 1.05), group


def rates(equations: Any, t: float, state: Floats, steps: Floats, parameters: Any) -> float:
    """The largest rate of the equations linearised at a state, by central differences."""
    columns = []
    for i, step in enumerate(steps):
        ahead, behind = state.copy(), state.copy()
        ahead[i] += step
        behind[i] -= step
        values = (np.array(equations(t, tuple(x.tolist()), parameters), dtype=float) for x in (ahead, behind))
        columns.append(np.subtract(*values) / (2 * step))
    return float(np.max(np.abs(np.linalg.eigvals(np.array(columns).T))))


def usual_rate(case: Case) -> float:
    """The median of the largest rates along the motion: for a hybrid case from exact states in its first mode, else from
    a rough integration."""
    parameters = tuple(map(float, case.parameter_values()))
    times, start = case.times[4::8], tuple(map(float, case.initial_state))
    if case.hybrid is not None:
        mode = case.hybrid.mode(case.hybrid.start(0.0, start, parameters))
        equations, numbers, states = mode.equations, parameters + mode.constants, case.sample(times)
    else:
        form = next(found for found in map(first_order, case.all_forms()) if found is not None)
        equations, numbers = form.equations, parameters

        def slope(t: float, y: Floats) -> Any:
            return equations(t, tuple(y.tolist()), numbers)

        states = solve_ivp(slope, (0.0, times[-1]), start, "LSODA", times, rtol=1e-5, atol=1e-8).y.T
    steps = 1e-5 * np.maximum(np.max(np.abs(states), axis=0), 1e-3)
    found = []
    for t, state in zip(times.tolist(), states, strict=True):
        with suppress(ZeroDivisionError):  # without slip the direction of slip is not defined
            found.append(rates(equations, t, state, steps, numbers))
    return float(np.median(found))


@pytest.mark.parametrize("name", [name for name in names() if name not in ANOTHER_TIME])
def test_time_scales_are_those_of_the_equations(name: str) -> None:
    """The time of a radian or of growth by e of the fastest mode of the linearised equations, within a factor of three;
    for a motion without such a time, as a flight, the span holds one to a hundred time scales."""
    case = get(name).rounded()
    rate = usual_rate(case)
    if rate * case.time_scale > 0.05:
        assert 0.32 < rate * case.time_scale < 3.2
    else:
        assert rate * float(case.span) < 0.7, "the motion has a characteristic time, and the time scale is far shorter"
        assert 0.9 < float(case.span) / case.time_scale < 100

"""The drawn curve is the exact motion to a pixel, between its points too, and needs few points in high precision."""

import random
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case
from gnomon.harness.measuring import drawn_motion
from gnomon.harness.measuring.drawn_motion import curve

from gnomon import cases

PANEL, WIDTH = 180, 640
"""Pixels of a panel: its height is the range of a group of coordinates, its width the time."""


@pytest.mark.parametrize(
    ("name", "variant", "parameters"),
    [
        ("pendulum_simple", None, {}),
        ("pendulum_simple", "separatrix", {}),
        ("kepler_orbit", None, {"mu": "1.5"}),  # no kept states
        ("kepler_orbit", "e0999", {}),  # turns at the pericentre in a thousandth of a period
        ("kepler_orbit", "orbits_1e4", {}),  # only the beginning is drawn
        ("bouncing_ball", None, {}),  # jumps, with a limit
        ("coulomb_friction_oscillator", None, {}),
        ("billiard_ball", None, {}),  # equations that are singular at the end of a mode
        pytest.param("double_pendulum", None, {}, marks=pytest.mark.slow),  # chaotic, without a closed form
        ("euler_top", None, {}),
        ("gyrocompass_damped", None, {}),
    ],
)
def test_a_drawn_line_is_within_a_pixel_of_the_exact_motion(
    name: str, variant: str | None, parameters: dict[str, Any]
) -> None:
    case = cases.get(name, variant, **parameters)
    times, states = curve(case)
    assert times[0] == 0
    assert np.all(np.diff(times) >= 0)
    some = random.Random(name)
    places = [k for k in range(len(times) - 1) if times[k] < times[k + 1]]
    places = sorted(some.sample(places, min(len(places), 40)))
    share = np.array([some.random() for _ in places])[:, None]
    left, right = (np.array([k + each for k in places]) for each in (0, 1))
    at = times[left] + share[:, 0] * (times[right] - times[left])
    drawn = states[left] + share * (states[right] - states[left])
    kept = type(case)().rounded() if variant is None and not parameters else case  # as it is run
    groups = [coordinate.group for coordinate in case.state]
    ranges = np.ptp(states, axis=0)
    height = np.array([max(r for r, g in zip(ranges, groups, strict=True) if g == group) for group in groups])
    for t, state in zip(at, drawn, strict=True):
        away = np.abs(kept.sample(np.array([t])) - state) / height * PANEL
        if np.max(away) >= 1:  # on a slope that is steeper than the picture shows, it is near in time
            near = times[-1] / WIDTH * 0.5 ** np.arange(1, 22)
            around = kept.sample(np.clip(np.concatenate([t - near, t + near]), 0, times[-1]))
            assert np.max(np.min(np.abs(around - state), axis=0) / height) * PANEL < 1


def test_no_peak_between_two_points_is_lost() -> None:
    """The pericentre at e = 0.999, where the speed is a thousand times as large for some 1e-4 s."""
    case = cases.get("kepler_orbit", "e0999")
    times, states = curve(case)
    period = float(case.quantities()["period"])
    passages = period * np.arange(1, int(times[-1] / period) + 1)
    assert len(passages) > 5
    peaks = [np.max(states[np.abs(times - passage) < 1e-3, 3], initial=0.0) for passage in passages]
    assert peaks == pytest.approx([float(case.initial_state[3])] * len(passages), rel=0.02)


def test_a_default_case_is_drawn_from_kept_states(monkeypatch: pytest.MonkeyPatch) -> None:
    """The double pendulum has no closed form: its exact states take tens of seconds."""
    monkeypatch.setattr(Case, "sample", lambda *_: pytest.fail("computed an exact state"))
    case = cases.get("double_pendulum")
    times, _ = curve(case)
    assert times[-1] == pytest.approx(min(float(case.span), drawn_motion.SCALES * case.time_scale), rel=0.05)


def test_where_integration_fails_the_exact_motion_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawn_motion, "TOLERANCE", 0.1)
    times, states = curve(case := cases.get("pendulum_simple"))
    places = range(7, len(times), len(times) // 20)
    assert np.max(np.abs(states[places, :] - case.sample(times[places]))) < 0.01 * np.ptp(states)

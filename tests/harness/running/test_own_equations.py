"""The lines that the report gives for each integrator run, and give the motion that they describe."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.registry import lookup
from gnomon.harness.running.own_equations import LINES, lines
from scipy.integrate import solve_ivp

ALL = {one.id: one for one in lookup.everything().values() if lookup.missing(one) is None}
QUICK = {
    form.__name__: next(name for name, one in ALL.items() if form in one.accepts and lines(one) is not None)
    for form in LINES
}
SCIPY = {"rtol": 1e-10, "atol": 1e-12, "method": "DOP853"}


def states_of(name: str, folder: Path) -> Floats:
    file = folder / "own.py"
    file.write_text(lines(ALL[name]) or "")
    found: Floats = runpy.run_path(str(file))["found"].y.T
    return found


def expected(text: str) -> Floats:
    """The states by SciPy, or by the formula of a ball that bounces."""
    times = np.array([0.5, 1.0, 1.5])
    if "swing" in text:
        return _solved(lambda t, y: [y[1], -9.81 * np.sin(y[0])], [1.2, 0.0], times)
    if "falling" in text:
        fall = np.sqrt(2 / 9.81)
        up = 0.8 * 9.81 * fall
        after = np.array([0.6, 0.9]) - fall
        heights = [1 - 9.81 * 0.09 / 2, *(up * after - 9.81 * after**2 / 2)]
        return np.column_stack([heights, [-9.81 * 0.3, *(up - 9.81 * after)]])
    if "masses" in text:  # a circular motion of angular velocity 1
        angle = times[:, None]
        turned = np.hstack([np.cos(angle), np.sin(angle), 0 * angle, -np.sin(angle), np.cos(angle), 0 * angle])
        return np.hstack([-0.25 * turned, 0.75 * turned])
    if "inertia" in text:
        return _solved(lambda t, w: [w[1] * w[2] * -1, w[2] * w[0], w[0] * w[1] / -3], [0.1, 1.0, 0.2], times)
    if "gamma" in text:
        return _solved(relativistic, [0, 0, 0, 1, 0, 0.1], times)
    if "Charged" in text:
        return _solved(lambda t, s: [*s[3:], 0.5 + 2 * s[4], -2 * s[3], 0.0], [0, 0, 0, 1, 0, 0.1], times)
    if "Constrained" in text:
        angles = _solved(lambda t, y: [y[1], -9.81 * np.sin(y[0])], [np.pi / 2, 0.0], times)
        sine, cosine, rate = np.sin(angles[:, 0]), np.cos(angles[:, 0]), angles[:, 1]
        return np.column_stack([sine, -cosine, rate * cosine, rate * sine])
    particular = (1000 * np.cos(times) + np.sin(times)) / (1e6 + 1)
    return particular[:, None]


def relativistic(t: float, s: Floats) -> list[float]:
    u, v, w = s[3:] / np.sqrt(1 + s[3:] @ s[3:] / 100)
    return [u, v, w, 0.5 + 2 * v, -2 * u, 0.0]


def _solved(f: object, start: list[float], times: Floats) -> Floats:
    found: Floats = solve_ivp(f, (0, times[-1]), start, t_eval=times, **SCIPY).y.T  # type: ignore[call-overload]
    return found


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in QUICK.values() else pytest.mark.slow)
        for name, one in ALL.items()
        if lines(one)
    ],
)
def test_the_lines_of_every_integrator_give_the_motion(name: str, tmp_path: Path) -> None:
    found = states_of(name, tmp_path)
    text = lines(ALL[name]) or ""
    assert len([line for line in text.splitlines() if line]) <= 27
    right = expected(text)
    one_step = 9.81 * 2.0**-7  # the largest change of a velocity in a step of the shortest lines
    assert np.max(np.abs(found[:, : right.shape[1]] - right)) < (
        4 * one_step if ALL[name].order == 1 else 0.1 * one_step
    )


def test_only_engines_have_no_lines() -> None:
    without = [one for one in lookup.everything().values() if lines(one) is None]
    assert without
    assert all(kind.__name__ == "SceneForm" for one in without for kind in one.accepts)


def test_every_form_has_a_quick_integrator() -> None:
    assert set(QUICK) == {form.__name__ for form in LINES}

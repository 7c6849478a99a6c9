"""Mistakes that people make, planted in files: the report names each, and what would be left is small beside the error."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from motion_files import Floats, as_csv
from scipy.spatial.transform import Rotation

import gnomon

SWING, ORBIT, TOP = gnomon.case("pendulum_simple"), gnomon.case("kepler_orbit"), gnomon.case("euler_top")
TIMES = np.linspace(0, 8, 72)


def noisy(states: Floats) -> Floats:
    """An integration error of 1e-7 on top, which the cause is not to hide."""
    return np.asarray(states * (1 + 1e-7 * np.sin(np.arange(len(states)))[:, np.newaxis]))


def swing(**numbers: float) -> Floats:
    return noisy(gnomon.case("pendulum_simple", **numbers).sample(TIMES))


def damped(times: Floats) -> Floats:
    from scipy.integrate import solve_ivp

    found = solve_ivp(
        lambda t, y: [y[1], -9.81 * np.sin(y[0]) - 0.03 * y[1]],
        (0, 8),
        [2, 0],
        "DOP853",
        times,
        rtol=1e-10,
        atol=1e-10,
    )
    return np.asarray(found.y.T)


def turned(change: Callable[[Floats], Floats]) -> Floats:
    """The states of the top with changed quaternions x, y, z, w."""
    states = TOP.sample(TIMES)
    q = Rotation.from_matrix(states[:, 3:].reshape(-1, 3, 3)).as_quat()
    return np.column_stack([states[:, :3], Rotation.from_quat(change(q)).as_matrix().reshape(-1, 9)])


def in_space() -> Floats:
    states = TOP.sample(TIMES)
    rates = np.einsum("nij,nj->ni", states[:, 3:].reshape(-1, 3, 3), states[:, :3])
    return np.column_stack([rates, states[:, 3:]])


PLANTED: dict[str, tuple[gnomon.ExactCase, Callable[[], tuple[Floats, Floats]], str]] = {
    "degrees": (SWING, lambda: (TIMES, np.degrees(swing())), "degrees for radians"),
    "angle in degrees": (SWING, lambda: (TIMES, swing() * [180 / np.pi, 1]), "theta: degrees for radians"),
    "minus": (SWING, lambda: (TIMES, swing() * [1, -1]), "omega"),
    "velocity first": (SWING, lambda: (TIMES, swing()[:, ::-1]), "velocities stand before positions"),
    "kilometres": (ORBIT, lambda: (TIMES, 1e-3 * noisy(ORBIT.sample(TIMES))), "x, y, vx, vy"),
    "thousand": (ORBIT, lambda: (TIMES, noisy(ORBIT.sample(TIMES)) * [1e3, 1e3, 1, 1]), "x, y"),
    "x and y": (ORBIT, lambda: (TIMES, noisy(ORBIT.sample(TIMES))[:, [1, 0, 3, 2]]), "order|axes"),
    "woven": (ORBIT, lambda: (TIMES, noisy(ORBIT.sample(TIMES))[:, [0, 2, 1, 3]]), "each velocity stands beside"),
    "late": (SWING, lambda: (TIMES, noisy(SWING.sample(np.maximum(TIMES - TIMES[1], 0)))), "t - "),
    "early": (SWING, lambda: (TIMES, noisy(SWING.sample(TIMES + TIMES[1]))), r"t \+ "),
    "milliseconds": (SWING, lambda: (1e3 * TIMES, swing()), "ms|millisecond|1000|1e-3|0.001"),
    "gravity 9.8": (SWING, lambda: (TIMES, swing(g=9.8)), "g is 9.8"),
    "gravity 9.80665": (SWING, lambda: (TIMES, swing(g=9.80665)), "g is 9.80665"),
    "clock": (SWING, lambda: (1.2 * TIMES, swing()), "periods are 1.2 "),
    "exchanged": (SWING, lambda: (TIMES, swing(g=1, L=9.81)), "exchanged|for"),
    "damping": (SWING, lambda: (TIMES, damped(TIMES)), "damp"),
    "another start": (SWING, lambda: (TIMES, noisy(gnomon.case("pendulum_simple", initial_state=(1.8, 0)).sample(TIMES))), "start"),
    "conjugate": (TOP, lambda: (TIMES, turned(lambda q: q * [-1, -1, -1, 1])), "space to body"),
    "order of quaternion": (TOP, lambda: (TIMES, turned(lambda q: q[:, [3, 0, 1, 2]])), "quaternion"),
    "rates in space": (TOP, lambda: (TIMES, in_space()), "space"),
    "rates in degrees": (TOP, lambda: (TIMES, TOP.sample(TIMES) * np.repeat([180 / np.pi, 1], [3, 9])), "degrees"),
}  # fmt: skip


def test_the_start_of_a_file_is_the_one_of_its_first_row() -> None:
    """Half of the angle is another start, not a mistake of its own; the row says which."""
    (cause,) = gnomon.check(SWING, TIMES, swing(theta=1), within=1e-4).causes
    assert cause.startswith("another start: theta = 1 for 2 (a factor 1/2)")
    (cause,) = gnomon.check(SWING, TIMES, swing(theta=1.1), within=1e-4).causes
    assert cause.startswith("another start: theta = 1.1 for 2;")


@pytest.mark.parametrize("kind", PLANTED)
def test_a_planted_cause_is_named_in_a_file(kind: str, tmp_path: Path) -> None:
    case, plant, told = PLANTED[kind]
    times, states = plant()
    as_csv(tmp_path / "a.csv", {"t": times, **dict(zip(case.coordinates, states.T, strict=True))})
    found = gnomon.check(case, tmp_path / "a.csv", within=1e-4, accept=["sparse"])
    assert found.verdict.code == 1
    assert found.causes
    text = " ".join(found.causes)
    assert any(word.replace("\\", "") in text for word in told.split("|")), text
    assert found.causes[0] in str(found)

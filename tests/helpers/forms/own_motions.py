"""The motions of the systems in `systems.toml`, computed apart from their lines: closed forms, or other equations by SciPy."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from gnomon.harness.results.advice import code_lines
from scipy.integrate import solve_ivp

from gnomon import cases

Floats = npt.NDArray[np.float64]
G = 9.81
THIRDS = np.array([1.0, 2.0, 3.0])
HALVES = np.array([0.5, 1.0, 1.5])
E1, E2, E3 = np.eye(3)


def solved(f: Callable[[float, Floats], Any], start: Any, times: Floats, method: str = "DOP853") -> Floats:
    """The states (samples, dim) by SciPy at its tightest tolerance."""
    found: Floats = solve_ivp(f, (0, times[-1]), start, method, times, rtol=1e-13, atol=1e-14).y.T
    return found


def swings(times: Floats) -> Floats:
    """A pendulum, by elliptic functions."""
    case = cases.case_class("pendulum_simple")(initial_state=("1.2", 0))
    return np.array([[float(x) for x in case.exact(t, 20)] for t in times.tolist()])


def double_pendulum(t: float, y: Floats) -> list[float]:
    """Lagrange's equations, solved for the accelerations as a linear system."""
    a, b, u, v = y
    c, s = np.cos(a - b), np.sin(a - b)
    forces = [-s * v * v - 2 * G * np.sin(a), s * u * u - G * np.sin(b)]
    return [u, v, *np.linalg.solve([[2, c], [c, 1]], forces)]


def satellite(times: Floats) -> Floats:
    """Kepler's orbit, by his equation."""
    mu, start, speed = 398600.4418, np.array([7000.0, 0.0, 0.0]), np.array([0.0, 8.0, 5.66])
    axis = 1 / (2 / 7000.0 - speed @ speed / mu)
    e, rate = 1 - 7000.0 / axis, np.sqrt(mu / axis**3)
    ahead, aside = start / 7000.0, speed / np.linalg.norm(speed)
    found = []
    for t in times:
        anomaly = rate * t
        for _ in range(50):
            anomaly -= (anomaly - e * np.sin(anomaly) - rate * t) / (1 - e * np.cos(anomaly))
        c, s, root = np.cos(anomaly), np.sin(anomaly), np.sqrt(1 - e * e)
        turn = axis * rate / (1 - e * c)
        place = axis * ((c - e) * ahead + root * s * aside)
        found.append([*place, *(turn * (root * c * aside - s * ahead))])
    return np.array(found)


def attraction(masses: list[float]) -> Callable[[float, Floats], Floats]:
    """The attraction of bodies, each (x, y, z, vx, vy, vz)."""

    def rates(t: float, y: Floats) -> Floats:
        places, speeds = y.reshape(-1, 6)[:, :3], y.reshape(-1, 6)[:, 3:]
        apart = places[None] - places[:, None]
        distance = np.linalg.norm(apart, axis=2) + np.eye(len(masses))
        pull = np.einsum("j,ijk->ik", masses, apart / distance[..., None] ** 3)
        return np.hstack([speeds, pull]).ravel()

    return rates


def top(t: float, y: Floats) -> Floats:
    """The angular momentum in space, and the axes of the body in space, as rows."""
    momentum, axes = y[:3], y[3:].reshape(3, 3)
    spin = sum((axis @ momentum) / moment * axis for axis, moment in zip(axes, (1.0, 1.2, 0.4), strict=True))
    weight = np.cross(axes[2], [0.0, 0.0, -5.0])
    return np.concatenate([weight, *(np.cross(spin, axis) for axis in axes)])


def turning_top(times: Floats) -> Floats:
    c, s = np.cos(0.5), np.sin(0.5)
    axes = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    moments = np.array([1.0, 1.2, 0.4])
    states = solved(top, [*((moments * [0.2, 0.0, 12.0]) @ axes), *axes.ravel()], times)
    found = []
    for state in states:
        axes = state[3:].reshape(3, 3)
        found.append([*(axes @ state[:3] / moments), *axes.T.ravel()])
    return np.array(found)


def rod(times: Floats) -> Floats:
    angle, rate = solved(lambda t, y: [y[1], -G * np.sin(y[0])], [np.pi / 2, 0.0], times).T
    return np.column_stack([np.sin(angle), -np.cos(angle), rate * np.cos(angle), rate * np.sin(angle)])


def fast_charge(t: float, s: Floats) -> list[float]:
    u, v, w = s[3:] / np.sqrt(1 + s[3:] @ s[3:] / 100)
    return [u, v, w, 0.5 + 2 * v, -2 * u, 0.0]


def linear_motion(matrix: Any, drive: Any, frequency: float, start: Any, times: Floats) -> Floats:
    """The motion of y' = matrix y + drive cos(frequency t), of the real part: the forced motion and the modes."""
    forced = np.linalg.solve(1j * frequency * np.eye(len(start)) - np.array(matrix), drive)
    values, vectors = np.linalg.eig(matrix)
    shares = np.linalg.solve(vectors, np.array(start) - forced.real)
    turned = np.exp(1j * frequency * times)
    return np.array(
        [(vectors @ (shares * np.exp(values * t)) + forced * e).real for t, e in zip(times, turned, strict=True)]
    )


def spring_pendulum(t: float, y: Floats) -> list[float]:
    """In polar coordinates: the length, the angle from below, and their rates."""
    r, angle, dr, turn = y
    return [dr, turn, r * turn**2 + G * np.cos(angle) - 1e4 * (r - 1), (-G * np.sin(angle) - 2 * dr * turn) / r]


def vibrating(times: Floats) -> Floats:
    start = [np.hypot(0.6, 0.81), np.arctan2(0.6, 0.81), 0.0, 0.0]
    r, angle, dr, turn = solved(spring_pendulum, start, times).T
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([r * s, -r * c, dr * s + r * turn * c, -dr * c + r * turn * s])


def throw(t: float, y: Floats) -> Floats:
    speed = y[2:]
    return np.concatenate([speed, [0.0, -G] - 0.01 * np.linalg.norm(speed) * speed])


def decay(times: Floats) -> Floats:
    return np.column_stack(
        [(1000 * np.cos(times) + np.sin(times)) / (1e6 + 1) + np.exp(-1000 * times) * (1 - 1e3 / (1e6 + 1))]
    )


def bounced(times: Floats) -> Floats:
    """The height and the speed of a ball that keeps half of its speed at each impact, and rests after all of them."""
    found = []
    for t in times:
        begin, up = -np.sqrt(2 / G), np.sqrt(2 * G)  # as if it had been thrown up to the height of its start
        while up > 1e-12 and t >= begin + 2 * up / G:
            begin, up = begin + 2 * up / G, up / 2
        since = t - begin
        found.append([up * since - G * since**2 / 2, up - G * since] if up > 1e-12 else [0.0, 0.0])
    return np.array(found)


def slid(times: Floats) -> Floats:
    rest, friction = 3 * np.sqrt(2 / G), 0.3 * G  # of infinitely many impacts the last is at three times of the fall
    sliding = np.clip(times - rest, 0.0, 2 / friction)
    place = 2 * np.minimum(times, rest) + 2 * sliding - friction * sliding**2 / 2
    height, speed = bounced(times).T
    return np.column_stack([place, height, 2 - friction * sliding, speed])


TIMES = {
    "many_swings": np.array([1000.0, 2000.0]),
    **dict.fromkeys(["satellite", "satellite_as_body"], np.array([20000.0, 60000.0, 100000.0])),
    **dict.fromkeys(["ball", "ball_and_wall"], np.array([0.3, 0.9, 2.0])),
    "sliding_ball": np.array([0.9, 1.5, 3.0]),
    **dict.fromkeys(
        ["pendulum", "pendulum_accelerations", "two_bodies", "top", "rod", "charge", "fast_charge", "decay"], HALVES
    ),
}
"""The times of the lines; THIRDS for others."""
THREE = [[1.0, 0.0, 0.0, 0.0, 0.6, 0.1], [-0.5, 0.8, 0.0, -0.5, -0.3, 0.0], [-0.5, -0.7, 0.1, 0.5, -0.3, 0.0]]
TWO = [[-0.25, 0.0, 0.0, 0.0, -0.25, 0.0], [0.75, 0.0, 0.0, 0.0, 0.75, 0.0]]
COUPLED = [[0, 0, 1, 0], [0, 0, 0, 1], [-6, 2, -0.3, 0.1], [2, -6, 0.1, -0.3]]
CHARGE = [0.0, 0.0, 0.0, 1.0, 0.0, 0.1]
MOTIONS: Mapping[str, Callable[[Floats], Floats]] = {
    **dict.fromkeys(["pendulum", "pendulum_accelerations", "many_swings"], swings),
    "double_pendulum": lambda times: solved(double_pendulum, [2.0, 1.0, 0.0, 0.0], times),
    "throw": lambda times: solved(throw, [0.0, 2.0, 20.0, 15.0], times),
    "damped_spring": lambda times: linear_motion([[0, 1], [-1e4, -1e4]], [0, 1e4], 1.0, [0, 2], times),
    "spring_pendulum": vibrating,
    "two_bodies": lambda times: solved(attraction([0.75, 0.25]), np.ravel(TWO), times),
    **dict.fromkeys(["satellite", "satellite_as_body"], satellite),
    "three_bodies": lambda times: solved(attraction([1.0, 0.9, 1.1]), np.ravel(THREE), times),
    "top": turning_top,
    "rod": rod,
    "charge": lambda times: solved(lambda t, s: [*s[3:], 0.5 + 2 * s[4], -2 * s[3], 0.0], CHARGE, times),
    "fast_charge": lambda times: solved(fast_charge, CHARGE, times),
    "coupled_masses": lambda times: linear_motion(COUPLED, [0, 0, 1, 0], 2.0, [1, 0, 0, 0], times),
    "decay": decay,
    **dict.fromkeys(["ball", "ball_and_wall"], bounced),
    "sliding_ball": slid,
}


def error_of(system: str, states: Floats) -> float:
    """The largest distance of states (samples, dim) from the motion of a system, relative to the size of the motion.

    Places and velocities have their own sizes, and so have the attitude and the angular velocity.
    """
    times = TIMES.get(system, THIRDS)
    right, dim = MOTIONS[system](times), states.shape[1]
    place = [
        k % 6 < 3 if system in ("two_bodies", "three_bodies") else k < (3 if system == "top" else dim / 2)
        for k in range(dim)
    ]
    groups = [np.flatnonzero(place), np.flatnonzero(~np.array(place))]
    return max(float(np.max(abs(states - right)[:, of]) / np.max(abs(right[:, of]))) for of in groups if len(of))


assert set(MOTIONS) == set(code_lines.systems()), "each system has a motion that was computed apart from its lines"

"""Other conventions for the attitude and the velocities of a rigid body, as people mistake them."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from gnomon.harness.contract.integrator import Floats
from scipy.spatial.transform import Rotation

ANGLES = {180 / math.pi: "degrees/s", 60 / (2 * math.pi): "revolutions per minute"}
"""Units of an angular velocity beside rad/s, by their number in one rad/s."""


class Turning(NamedTuple):
    """Attitudes as quaternions x, y, z, w, shape (n, 4), and angular velocities, shape (n, 3)."""

    quaternion: Floats
    spin: Floats


Change = Callable[[Turning], Turning]


@dataclass(frozen=True)
class Convention:
    """Another convention. `undo` gives the convention of gnomon, `apply` the other one; `text`: what to change."""

    text: str
    undo: Change
    apply: Change


def turns(quaternion: Floats) -> Floats:
    """The rotation matrices, shape (n, 3, 3), body -> space; nan for a quaternion without a length."""
    matrices = np.full((len(quaternion), 3, 3), math.nan)
    with np.errstate(all="ignore"):
        usable = np.isfinite(quaternion).all(axis=1) & (np.linalg.norm(quaternion, axis=1) > 0)
    matrices[usable] = Rotation.from_quat(quaternion[usable]).as_matrix()
    return matrices


def _roll(places: int) -> Change:
    return lambda turning: Turning(np.roll(turning.quaternion, places, axis=1), turning.spin)


def _conjugate(turning: Turning) -> Turning:
    return Turning(turning.quaternion * [-1.0, -1.0, -1.0, 1.0], turning.spin)


def _into_space(turning: Turning) -> Turning:
    return Turning(turning.quaternion, np.einsum("nij,nj->ni", turns(turning.quaternion), turning.spin))


def _into_body(turning: Turning) -> Turning:
    return Turning(turning.quaternion, np.einsum("nji,nj->ni", turns(turning.quaternion), turning.spin))


def _scale(factor: float) -> Change:
    return lambda turning: Turning(turning.quaternion, turning.spin * factor)


def _then(first: Change, second: Change) -> Change:
    return lambda turning: second(first(turning))


def conventions(along_body: bool = False) -> Iterator[Convention]:
    """The conventions that people mistake, one mistake before two.

    `along_body`: whether gnomon's angular velocity is along the axes of the body here; an engine gives it in space.
    """
    attitudes = [
        Convention("quaternions are in the order w, x, y, z: give x, y, z, w", _roll(-1), _roll(1)),
        Convention("quaternions x, y, z, w are taken for w, x, y, z: do not reorder them", _roll(1), _roll(-1)),
        Convention("attitudes map space to body: give the conjugate quaternions", _conjugate, _conjugate),
    ]
    axes = ("in space", "along the body's axes")
    right, other = axes[::-1] if along_body else axes
    undo, apply = (_into_body, _into_space) if along_body else (_into_space, _into_body)
    spins = [
        Convention(f"angular velocity is {other}: give it {right}", undo, apply),
        *(
            Convention(f"angular velocity is in {unit}: give it in rad/s", _scale(1 / number), _scale(number))
            for number, unit in ANGLES.items()
        ),
    ]
    yield from (*attitudes, *spins)
    for attitude in attitudes:
        for spin in spins:
            yield Convention(
                f"{attitude.text}; {spin.text}", _then(attitude.undo, spin.undo), _then(spin.apply, attitude.apply)
            )


def rotations_of_axes() -> dict[str, Floats]:
    """The 23 rotations that map axes to other axes, y-up first; by the name of the axes that stand for x, y, z."""
    rotations: dict[str, Floats] = {}
    for turned in sorted(Rotation.create_group("O").as_matrix().round().tolist(), key=lambda rows: rows != Y_UP):
        named = ", ".join("-" * (min(row) < 0) + "xyz"[int(np.argmax(np.abs(row)))] for row in turned)
        rotations[named] = np.array(turned)
    del rotations["x, y, z"]
    return rotations


POSITION, ATTITUDE, VELOCITY, SPIN = slice(0, 3), slice(3, 7), slice(7, 10), slice(10, 13)
"""The parts of the state of a free body."""
NEAR = 0.05
"""A convention explains a reading if it leaves less than this share of the difference."""


def free_body_error(
    states: Floats, exact: Floats, parts: Sequence[slice] = (POSITION, ATTITUDE, VELOCITY, SPIN)
) -> float:
    """The largest difference between states (n, 13) of a free body, relative to the size of each quantity.

    A quaternion and its negative are one attitude. A quantity that is not finite is infinitely far.
    """
    states = states.copy()
    sign = np.where(np.sum(states[:, ATTITUDE] * exact[:, ATTITUDE], axis=1) < 0, -1.0, 1.0)
    states[:, ATTITUDE] *= sign[:, None]
    errors = [
        np.max(np.linalg.norm((states - exact)[:, part], axis=1))
        / (np.max(np.linalg.norm(exact[:, part], axis=1)) or 1.0)
        for part in parts
    ]
    return float(max(errors)) if np.isfinite(errors).all() else math.inf


def with_turning(states: Floats, change: Change) -> Floats:
    """States (n, 13) of a free body whose attitude and angular velocity are changed."""
    changed, turned = states.copy(), change(Turning(states[:, ATTITUDE], states[:, SPIN]))
    changed[:, ATTITUDE], changed[:, SPIN] = turned
    return changed


def explain_reading(readings: Floats, exact: Floats) -> str:
    """What to change in readings (n, 13) of a free body so that they are the exact states; "" if nothing explains them."""
    error = free_body_error(readings, exact)
    least = NEAR * min(error, 1.0)

    def fits(states: Floats) -> bool:
        return free_body_error(states, exact) < least

    for convention in conventions():
        if fits(with_turning(readings, convention.undo)):
            return convention.text
    exchanged = readings.copy()
    exchanged[:, VELOCITY], exchanged[:, SPIN] = readings[:, SPIN], readings[:, VELOCITY]
    if fits(exchanged):
        return "velocity and angular velocity are exchanged"
    for named, turn in rotations_of_axes().items():
        states = readings.copy()
        for part in (POSITION, VELOCITY, SPIN):
            states[:, part] = readings[:, part] @ turn.T
        body = Rotation.from_matrix(turn)
        up = " (its y axis is up)" * (turn.tolist() == Y_UP)
        for whole in (False, True):
            turned = body * Rotation.from_quat(readings[:, ATTITUDE])
            states[:, ATTITUDE] = (turned * body.inv() if whole else turned).as_quat()
            if fits(states):
                return f"x, y, z are {named} of the frame of its readings{up}: turn them"
    for part, name in ((POSITION, "positions"), (VELOCITY, "velocities"), (SPIN, "angular velocities")):
        states = readings.copy()
        factor = float(np.sum(readings[:, part] * exact[:, part]) / np.sum(exact[:, part] ** 2))
        if factor:
            states[:, part] /= factor
            if fits(states):
                return f"{name} have a factor {factor:.6g}"
    return ""


Y_UP = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
"""From a frame whose y axis is up to gnomon's, whose z axis is up."""

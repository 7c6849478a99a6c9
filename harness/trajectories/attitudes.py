"""Attitudes and rates of rotation in other conventions, as a rotation matrix body -> space and rates in a case's axes."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Floats

QUATERNIONS = {"wxyz": (1, 2, 3, 0), "xyzw": (0, 1, 2, 3)}
"""For each order of a file: the places of x, y, z, w."""
EULER = re.compile(r"(?=.{3}$)(?:[XYZ]{3}|[xyz]{3})")
"""A sequence as of SciPy: capitals about the axes of the body, small letters about the axes of space."""
Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""From a frame with y up to one with z up: (x, y, z) -> (x, -z, y)."""
LEAST_NORM = 1e-3
"""A quaternion or matrix further from unit size is not an attitude."""


def matrices(values: Floats, convention: str) -> Floats:
    """Rotation matrices (n, 3, 3), body -> space, from quaternions (n, 4), Euler angles in rad (n, 3) or matrices (n, 9).

    A quaternion keeps its size and a matrix its defects, which are errors of the motion. Raises ValueError for numbers
    that are not near an attitude.
    """
    if convention == "matrix":
        rotations = values.reshape(-1, 3, 3)
        _ensure_near_one(np.linalg.norm(rotations, axis=(1, 2)) / np.sqrt(3), "the size of a matrix")
        return rotations
    if convention in QUATERNIONS:
        q = values[:, list(QUATERNIONS[convention])]
        _ensure_near_one(np.linalg.norm(q, axis=1), "the norm of a quaternion")
        return np.asarray(_rotate_unnormalized(q))
    from scipy.spatial.transform import Rotation  # takes a tenth of a second to load

    finite = np.where(np.isfinite(values), values, 0.0)
    rotations = np.array(Rotation.from_euler(convention, finite).as_matrix())
    rotations[~np.all(np.isfinite(values), axis=1)] = np.nan
    return rotations


def _ensure_near_one(sizes: Floats, what: str) -> None:
    off = np.abs(sizes - 1)
    if np.any(off > 0.5):
        row = int(np.argmax(off > 0.5))
        raise ValueError(f"row {row + 1}: {what} is {sizes[row]:.6g}, far from 1; name the columns of an attitude")


def _rotate_unnormalized(q: Floats) -> Floats:
    """The matrices of quaternions x, y, z, w; of the second degree, so that a wrong norm shows in them."""
    x, y, z, w = q.T
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def rates_are_of_body(case: Case, rates: Sequence[int], attitude: Sequence[int]) -> bool | None:
    """Whether a case's rates are components along the body's axes: by its equations R' = R hat(w), or hat(w) R.

    None if the equations are neither.
    """
    if case.hybrid is not None:
        mode = case.hybrid.modes[0]
        equations, constants = mode.equations, mode.constants
    else:
        form = next((each for each in case.all_forms() if isinstance(each, FirstOrder)), None)
        if form is None:
            return None
        equations, constants = form.equations, ()
    state = np.array([float(x) for x in case.initial_state])
    turned = _rotate_unnormalized(np.array([[0.1, -0.5, 0.7, 0.5]]))[0]
    w = np.array([0.7, -0.4, 1.1])
    state[list(attitude)], state[list(rates)] = turned.reshape(-1), w
    parameters = (*(float(x) for x in case.parameter_values()), *constants)
    slope = np.array([float(x) for x in equations(0.0, tuple(state.tolist()), parameters)])
    derivative = slope[list(attitude)].reshape(3, 3)
    hat = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    if np.allclose(derivative, turned @ hat):
        return True
    return False if np.allclose(derivative, hat @ turned) else None

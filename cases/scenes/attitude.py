"""Scene of the torque-free top: one free rigid body, whose attitude is a quaternion in the engine."""

from math import sqrt

from gnomon.cases.core.scene import Body, Quaternion, Readings, Scene, SceneForm, Vector

Matrix = tuple[float, ...]
"""The nine entries of a 3 x 3 matrix, row by row."""


def euler_top_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    i1, i2, i3 = parameters
    attitude = state[3:]
    w1, w2, w3 = state[:3]
    spin = (
        attitude[0] * w1 + attitude[1] * w2 + attitude[2] * w3,
        attitude[3] * w1 + attitude[4] * w2 + attitude[5] * w3,
        attitude[6] * w1 + attitude[7] * w2 + attitude[8] * w3,
    )
    body = Body("top", 1.0, (i1, i2, i3), quaternion=quaternion(attitude), angular_velocity=spin)
    return Scene((0.0, 0.0, 0.0), (body,))


def euler_top_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    _, attitude, _, spin = readings.bodies["top"]
    r = matrix(attitude)
    return (*in_body(r, spin), *r)


def in_body(r: Matrix, vector: Vector) -> Vector:
    """The body components of a vector in space."""
    x, y, z = vector
    return r[0] * x + r[3] * y + r[6] * z, r[1] * x + r[4] * y + r[7] * z, r[2] * x + r[5] * y + r[8] * z


def quaternion(r: Matrix) -> Quaternion:
    """The quaternion (x, y, z, w) of a rotation matrix, from its largest component (Shepperd 1978)."""
    trace = r[0] + r[4] + r[8]
    squares = (1 + 2 * r[0] - trace, 1 + 2 * r[4] - trace, 1 + 2 * r[8] - trace, 1 + trace)
    largest = squares.index(max(squares))
    columns = (
        (squares[0], r[1] + r[3], r[2] + r[6], r[7] - r[5]),
        (r[1] + r[3], squares[1], r[5] + r[7], r[2] - r[6]),
        (r[2] + r[6], r[5] + r[7], squares[2], r[3] - r[1]),
        (r[7] - r[5], r[2] - r[6], r[3] - r[1], squares[3]),
    )
    x, y, z, w = columns[largest]
    norm = sqrt(x * x + y * y + z * z + w * w)
    return x / norm, y / norm, z / norm, w / norm


def matrix(q: Quaternion) -> Matrix:
    """The rotation matrix, row by row, of a quaternion (x, y, z, w) of any length but zero."""
    x, y, z, w = q
    s = 2 / (x * x + y * y + z * z + w * w)
    return (
        1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w),
        s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w),
        s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y),
    )  # fmt: skip


SCENE = SceneForm(euler_top_scene, euler_top_reading, frozenset({"gyroscopic"}), conservative=False)
"""Not conservative in the sense of SceneForm: angular accelerations depend on the rates."""

"""Scene of the heavy top: a body whose fixed point is a ball joint (token `ball_joint`).

A case gives the moments about the fixed point, and W, weight times arm. The scene takes an arm l of 1/8 of the radius
of gyration, so that the moments about the centre of mass (the transverse ones less m l^2 = I1/64) are possible.
"""

from math import acos, atan2, copysign, cos, hypot, sin, sqrt

from gnomon.cases.core.forms import Values
from gnomon.cases.core.scene import Body, Readings, Scene, SceneForm, Vector
from gnomon.cases.scenes.attitude import Matrix, in_body, matrix, quaternion

TOKENS = frozenset({"ball_joint", "gyroscopic"})
SHARE = 64


def standing(rates: Vector, r: Matrix, moment: float, axial: float, weight: float) -> Scene:
    """A top of mass 1 that rotates about the origin with body rates `rates` and attitude `r`."""
    arm = sqrt(moment / SHARE)
    x, y, z = rates
    spin = tuple(r[3 * i] * x + r[3 * i + 1] * y + r[3 * i + 2] * z for i in range(3))
    place = (arm * r[2], arm * r[5], arm * r[8])
    velocity = (
        spin[1] * place[2] - spin[2] * place[1],
        spin[2] * place[0] - spin[0] * place[2],
        spin[0] * place[1] - spin[1] * place[0],
    )
    own = moment - arm * arm
    top = Body("top", 1.0, (own, own, axial), place, quaternion(r), velocity, (spin[0], spin[1], spin[2]))
    return Scene((0.0, 0.0, -weight / arm), (top,))


def read(readings: Readings) -> tuple[Vector, Matrix]:
    _, attitude, _, spin = readings.bodies["top"]
    r = matrix(attitude)
    return in_body(r, spin), r


def body_scene(state: Values, parameters: Values) -> Scene:
    moment, axial, weight = parameters
    attitude = state[3:] if any(state[3:]) else (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    return standing((state[0], state[1], state[2]), attitude, moment, axial, weight)


def body_reading(readings: Readings, parameters: Values) -> Values:
    rates, r = read(readings)
    return (*rates, *r)


def angles_scene(state: Values, parameters: Values) -> Scene:
    """3-1-3 Euler angles; if theta is zero, the precession rate is set to zero."""
    theta, omega, phi, psi = state
    moment, axial, weight, a, b = parameters
    s, u = sin(theta), cos(theta)
    return _by_angles(theta, omega, phi, psi, (b - a * u) / (moment * s) if s else 0.0, (moment, axial, weight, a))


def rising_scene(state: Values, parameters: Values) -> Scene:
    theta, omega, phi, psi = state
    moment, _axial, _weight, a = parameters
    return _by_angles(theta, omega, phi, psi, a * sin(theta) / (moment * (1 + cos(theta))), parameters)


def _by_angles(theta: float, omega: float, phi: float, psi: float, across: float, parameters: Values) -> Scene:
    """`across` = phi' sin(theta)."""
    moment, axial, weight, a = parameters
    s, u, cf, sf, cp, sp = sin(theta), cos(theta), cos(phi), sin(phi), cos(psi), sin(psi)
    r = (
        cf * cp - sf * u * sp, -cf * sp - sf * u * cp, sf * s,
        sf * cp + cf * u * sp, -sf * sp + cf * u * cp, -cf * s,
        s * sp, s * cp, u,
    )  # fmt: skip
    return standing((omega * cp + across * sp, across * cp - omega * sp, a / axial), r, moment, axial, weight)


def angles_reading(readings: Readings, parameters: Values) -> Values:
    """theta is read as positive: after a passage of the vertical the azimuth differs by half a turn."""
    (w1, w2, _), r = read(readings)
    tilt = hypot(r[6], r[7])
    theta = atan2(tilt, r[8])
    if not tilt:
        return acos(copysign(1.0, r[8])), w1, 0.0, atan2(r[3], r[0])
    psi = atan2(r[6], r[7])
    return theta, w1 * cos(psi) - w2 * sin(psi), atan2(r[2], -r[5]), psi


BODY_SCENE = SceneForm(body_scene, body_reading, TOKENS, conservative=False)
ANGLES_SCENE = SceneForm(angles_scene, angles_reading, TOKENS, conservative=False)
RISING_SCENE = SceneForm(rising_scene, angles_reading, TOKENS, conservative=False)

"""Scene of the rolling disc: the rim of a thin disc on a plane on which it cannot slip."""

from __future__ import annotations

from math import acos, atan2, cos, sin

from gnomon.cases.core.forms import Values
from gnomon.cases.core.scene import Body, Contact, Readings, Scene, SceneForm
from gnomon.cases.rigid_bodies.euler_top_scene import in_body, matrix, quaternion


def disc_scene(state: Values, parameters: Values) -> Scene:
    """The disc's axes: along the tangent, the steepest radius and the axle, rotated by the roll psi about the axle."""
    x, y, theta, phi, psi, w1, w2, w3 = state
    g, a = parameters
    ct, st, cf, sf, cp, sp = cos(theta), sin(theta), cos(phi), sin(phi), cos(psi), sin(psi)
    tangent, radius, axle = (cf, sf, 0.0), (-ct * sf, ct * cf, st), (st * sf, -st * cf, ct)
    spin = tuple(w1 * t + w2 * r + w3 * n for t, r, n in zip(tangent, radius, axle, strict=True))
    # The centre is at a up the steepest radius from the point of contact, which has velocity zero: v = w x a r.
    arm = tuple(a * r for r in radius)
    velocity = (
        spin[1] * arm[2] - spin[2] * arm[1],
        spin[2] * arm[0] - spin[0] * arm[2],
        spin[0] * arm[1] - spin[1] * arm[0],
    )
    first = tuple(cp * t + sp * r for t, r in zip(tangent, radius, strict=True))
    second = tuple(cp * r - sp * t for t, r in zip(tangent, radius, strict=True))
    r = tuple(v for row in zip(first, second, axle, strict=True) for v in row)
    moment = a * a / 4
    disc = Body(
        "disc",
        1.0,
        (moment, moment, 2 * moment),
        (x + arm[0], y + arm[1], arm[2]),
        quaternion(r),
        velocity,
        (spin[0], spin[1], spin[2]),
    )
    return Scene((0.0, 0.0, -g), (disc,), contacts=(Contact("disc", (0.0, 0.0, 1.0)),))


def disc_reading(readings: Readings, parameters: Values) -> Values:
    (x, y, _), attitude, _, spin = readings.bodies["disc"]
    r = matrix(attitude)
    a = parameters[1]
    theta, phi, psi = acos(max(-1.0, min(1.0, r[8]))), atan2(r[2], -r[5]), atan2(r[6], r[7])
    w1, w2, w3 = in_body(r, spin)
    c, s = cos(psi), sin(psi)
    ahead = a * cos(theta)
    return x + ahead * sin(phi), y - ahead * cos(phi), theta, phi, psi, w1 * c - w2 * s, w1 * s + w2 * c, w3


SCENE = SceneForm(disc_scene, disc_reading, frozenset({"disc_contact", "rolling_without_slip"}), conservative=False)

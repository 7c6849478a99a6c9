"""Scenes of masses on a massless rope through a hole or over a pulley."""

from math import atan2, cos, hypot, sin

from gnomon.cases.core.scene import Body, Contact, Readings, Rope, Scene, SceneForm
from gnomon.cases.scenes.two_masses import NO_INERTIA, from_polar, to_polar

Values = tuple[float, ...]
LENGTH = 100.0
"""Length of a rope where the motion does not depend on it (m)."""
TABLE = (0.0, 0.0, 1.0)
HOLE = (0.0, 0.0, 0.0)


def _any_length(t: float) -> float:
    return LENGTH


def hanging_mass_scene(state: Values, parameters: Values) -> Scene:
    """m1 on a smooth table, m2 below the hole."""
    g, m1, m2 = parameters
    place, velocity = from_polar(state)
    bodies = (
        Body("m1", m1, NO_INERTIA, place, velocity=velocity),
        Body("m2", m2, NO_INERTIA, (0.0, 0.0, state[0] - LENGTH), velocity=(0.0, 0.0, state[2])),
    )
    return Scene((0.0, 0.0, -g), bodies, contacts=(Contact("m1", TABLE),), ropes=(Rope("m1", HOLE, _any_length, "m2"),))


def hanging_mass_reading(readings: Readings, parameters: Values) -> Values:
    place, _, velocity, _ = readings.bodies["m1"]
    return to_polar(place, velocity)


def shortened_scene(state: Values, parameters: Values) -> Scene:
    theta, omega = state
    m, r0, c = parameters
    place, velocity = from_polar((r0, theta, -c, omega))
    body = Body("mass", m, NO_INERTIA, place, velocity=velocity)
    return Scene((0.0, 0.0, 0.0), (body,), ropes=(Rope("mass", HOLE, lambda t: r0 - c * t),))


def shortened_reading(readings: Readings, parameters: Values) -> Values:
    place, _, velocity, _ = readings.bodies["mass"]
    _, theta, _, omega = to_polar(place, velocity)
    return theta, omega


def atwood_scene(state: Values, parameters: Values) -> Scene:
    """m1 hangs below the pulley, x below its reference position; m2 hangs on the other side."""
    x, v = state
    g, m1, m2, inertia, radius = parameters
    bodies = (
        Body("m1", m1, NO_INERTIA, (0.0, 0.0, -x - LENGTH / 2), velocity=(0.0, 0.0, -v)),
        Body("m2", m2, NO_INERTIA, (0.0, 0.0, x - LENGTH / 2), velocity=(0.0, 0.0, v)),
    )
    rope = Rope("m1", HOLE, _any_length, "m2", inertia=inertia / radius**2)
    return Scene((0.0, 0.0, -g), bodies, ropes=(rope,))


def atwood_reading(readings: Readings, parameters: Values) -> Values:
    place, _, velocity, _ = readings.bodies["m1"]
    return -place[2] - LENGTH / 2, -velocity[2]


def swinging_scene(state: Values, parameters: Values) -> Scene:
    """One mass swings at r from the pulley, the other hangs straight below it."""
    r, theta, vr, w = state
    mu, g = parameters
    s, c = sin(theta), cos(theta)
    velocity = (vr * s + r * w * c, 0.0, -vr * c + r * w * s)
    bodies = (
        Body("swings", 1.0, NO_INERTIA, (r * s, 0.0, -r * c), velocity=velocity),
        Body("hangs", mu, NO_INERTIA, (0.0, 0.0, r - LENGTH), velocity=(0.0, 0.0, vr)),
    )
    return Scene((0.0, 0.0, -g), bodies, ropes=(Rope("swings", HOLE, _any_length, "hangs"),))


def swinging_reading(readings: Readings, parameters: Values) -> Values:
    (x, _, z), _, (vx, _, vz), _ = readings.bodies["swings"]
    r = hypot(x, z)
    return r, atan2(x, -z), (x * vx + z * vz) / r, (x * vz - z * vx) / (r * r)


HANGING = SceneForm(hanging_mass_scene, hanging_mass_reading, frozenset({"rope"}), conservative=False)
SHORTENED = SceneForm(shortened_scene, shortened_reading, frozenset({"rope", "driven_axis"}), conservative=False)
ATWOOD = SceneForm(atwood_scene, atwood_reading, frozenset({"rope", "pulley"}))
SWINGING = SceneForm(swinging_scene, swinging_reading, frozenset({"rope"}), conservative=False)

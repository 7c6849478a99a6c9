"""Scenes of particles that act on each other: free points, with one force for each pair.

Plane motions lie in the engine's plane (x, y), with gravity in (x, z): `axes` names the engine's axes.
"""

from collections.abc import Callable
from itertools import combinations
from math import atan2, cos, hypot, sin, sqrt

from gnomon.cases.core.scene import Body, Force, Readings, Scene, SceneForm, Vector

Values = tuple[float, ...]
Attraction = Callable[[float, Values], float]
"""(distance, parameters) -> attraction over the distance and over both masses."""
NO_INERTIA: Vector = (0.0, 0.0, 0.0)
MUTUAL = frozenset({"mutual_force"})


def place_in(axes: tuple[int, ...], values: Values) -> Vector:
    point = [0.0, 0.0, 0.0]
    for axis, value in zip(axes, values, strict=True):
        point[axis] = value
    return point[0], point[1], point[2]


def attracting(
    masses: Callable[[Values], Values],
    attraction: Attraction,
    axes: tuple[int, ...],
    gravity: Callable[[Values], float] = lambda parameters: 0.0,
) -> SceneForm:
    """State (position of each..., velocity of each...) of particles that attract each other in pairs."""
    size = len(axes)

    def build(state: Values, parameters: Values) -> Scene:
        each, half = masses(parameters), len(state) // 2
        names = [f"particle {n + 1}" for n in range(len(each))]
        bodies = [
            Body(name, mass, NO_INERTIA, place_in(axes, state[i : i + size]), velocity=place_in(axes, state[half + i :][:size]))
            for name, mass, i in zip(names, each, range(0, half, size), strict=True)
        ]  # fmt: skip
        forces = [
            Force(names[i], "mutual_force", pull(each[i] * each[j], parameters), names[j])
            for i, j in combinations(range(len(each)), 2)
        ]
        return Scene((0.0, 0.0, -gravity(parameters)), tuple(bodies), forces=tuple(forces))

    def pull(product: float, parameters: Values) -> Callable[[float, Vector, Vector], Vector]:
        def law(t: float, position: Vector, velocity: Vector) -> Vector:
            x, y, z = position
            factor = -product * attraction(sqrt(x * x + y * y + z * z), parameters)
            return factor * x, factor * y, factor * z

        return law

    def observe(readings: Readings, parameters: Values) -> Values:
        bodies = [readings.bodies[f"particle {n + 1}"] for n in range(len(masses(parameters)))]
        places = [position[axis] for position, *_ in bodies for axis in axes]
        return (*places, *(velocity[axis] for _, _, velocity, _ in bodies for axis in axes))

    return SceneForm(build, observe, MUTUAL)


def inward(pull: Callable[[float, Values], float], parameters: Values) -> Callable[[float, Vector, Vector], Vector]:
    """The force `pull(r, parameters)` towards the origin of the plane."""

    def law(t: float, position: Vector, velocity: Vector) -> Vector:
        x, y, _ = position
        r = hypot(x, y)
        factor = -pull(r, parameters) / r
        return factor * x, factor * y, 0.0

    return law


def polar_pair(masses: Callable[[Values], Values], pull: Callable[[float, Values], float]) -> SceneForm:
    """State (r, theta, r', theta') of particle 2 relative to particle 1; their centre of mass is at rest; `pull` in N."""

    def build(state: Values, parameters: Values) -> Scene:
        m1, m2 = masses(parameters)
        place, velocity = from_polar(state)
        shares = (-m2 / (m1 + m2), m1 / (m1 + m2))
        bodies = tuple(
            Body(f"particle {n}", mass, NO_INERTIA, times(share, place), velocity=times(share, velocity))
            for n, mass, share in ((1, m1, shares[0]), (2, m2, shares[1]))
        )

        force = Force("particle 2", "mutual_force", inward(pull, parameters), "particle 1")
        return Scene((0.0, 0.0, 0.0), bodies, forces=(force,))

    def observe(readings: Readings, parameters: Values) -> Values:
        (a, _, u, _), (b, _, v, _) = (readings.bodies[f"particle {n}"] for n in (1, 2))
        return to_polar((b[0] - a[0], b[1] - a[1]), (v[0] - u[0], v[1] - u[1]))

    return SceneForm(build, observe, MUTUAL)


def polar_point(pull: Callable[[float, Values], float]) -> SceneForm:
    """State (r, theta, r', theta') of a point of mass 1, pulled to the origin by `pull(r, parameters)` in N."""

    def build(state: Values, parameters: Values) -> Scene:
        place, velocity = from_polar(state)

        body = Body("point", 1.0, NO_INERTIA, place, velocity=velocity)
        return Scene((0.0, 0.0, 0.0), (body,), forces=(Force("point", "position_force", inward(pull, parameters)),))

    def observe(readings: Readings, parameters: Values) -> Values:
        place, _, velocity, _ = readings.bodies["point"]
        return to_polar(place, velocity)

    return SceneForm(build, observe, frozenset({"position_force"}))


def from_polar(state: Values) -> tuple[Vector, Vector]:
    """Position and velocity in the plane (x, y) from (r, theta, r', theta')."""
    r, theta, vr, omega = state
    c, s = cos(theta), sin(theta)
    return (r * c, r * s, 0.0), (vr * c - r * omega * s, vr * s + r * omega * c, 0.0)


def to_polar(place: Values, velocity: Values) -> Values:
    (x, y), (vx, vy) = place[:2], velocity[:2]
    r = hypot(x, y)
    return r, atan2(y, x), (x * vx + y * vy) / r, (x * vy - y * vx) / (r * r)


def times(factor: float, vector: Vector) -> Vector:
    return factor * vector[0], factor * vector[1], factor * vector[2]


def line_scene(state: Values, parameters: Values) -> Scene:
    """Two masses on a line and a spring; the masses may pass through each other."""
    x1, x2, v1, v2 = state
    m1, m2, k, length = parameters

    def spring(t: float, position: Vector, velocity: Vector) -> Vector:
        return -k * (position[0] + length), 0.0, 0.0

    bodies = (
        Body("particle 1", m1, NO_INERTIA, (x1, 0.0, 0.0), velocity=(v1, 0.0, 0.0)),
        Body("particle 2", m2, NO_INERTIA, (x2, 0.0, 0.0), velocity=(v2, 0.0, 0.0)),
    )
    return Scene((0.0, 0.0, 0.0), bodies, forces=(Force("particle 1", "mutual_force", spring, "particle 2"),))


def line_reading(readings: Readings, parameters: Values) -> Values:
    (r1, _, v1, _), (r2, _, v2, _) = (readings.bodies[f"particle {n}"] for n in (1, 2))
    return r1[0], r2[0], v1[0], v2[0]


def rod_scene(state: Values, parameters: Values) -> Scene:
    """The dumbbell is one rigid body that turns about y, so its moment about the rod's axis has no effect."""
    x, y, theta, vx, vy, omega = state
    g, m1, m2, length = parameters
    arm, moment = m2 / (m1 + m2) * length, m1 * m2 / (m1 + m2) * length**2
    c, s = cos(theta), sin(theta)
    rod = Body(
        "rod",
        m1 + m2,
        (moment, moment, moment),
        (x + arm * c, 0.0, y + arm * s),
        (0.0, -sin(theta / 2), 0.0, cos(theta / 2)),
        (vx - arm * omega * s, 0.0, vy + arm * omega * c),
        (0.0, -omega, 0.0),
    )
    return Scene((0.0, 0.0, -g), (rod,))


def rod_reading(readings: Readings, parameters: Values) -> Values:
    """The state, from the position of the rod; the angle is within one turn."""
    _g, m1, m2, length = parameters
    (x, _, z), (_, turn, _, rest), (vx, _, vz), (_, spin, _) = readings.bodies["rod"]
    arm, theta, omega = m2 / (m1 + m2) * length, -2 * atan2(turn, rest), -spin
    c, s = cos(theta), sin(theta)
    return x - arm * c, z - arm * s, theta, vx + arm * omega * s, vz - arm * omega * c, omega


ON_A_LINE = SceneForm(line_scene, line_reading, MUTUAL)
ROD = SceneForm(rod_scene, rod_reading, frozenset())

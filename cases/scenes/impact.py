"""Scenes of bodies that collide: spheres without friction, with one contact for each pair."""

from collections.abc import Callable
from math import sin

from gnomon.cases.core.scene import Body, Contact, Readings, Scene, SceneForm, Slider, Vector

Values = tuple[float, ...]
RADIUS = 0.05
"""Radius of balls on a line (m). Coordinates of a case are shifted so that touching neighbours have equal ones."""
AXIS: Vector = (1.0, 0.0, 0.0)


def _ball(name: str, mass: float, radius: float, place: Vector, velocity: Vector) -> Body:
    moment = 2 * mass * radius**2 / 5
    return Body(name, mass, (moment, moment, moment), place, velocity=velocity, radius=radius)


def ball_line(
    masses: Callable[[Values], Values], restitution: Callable[[Values], float], wall: bool = False
) -> SceneForm:
    """State (x1, ..., v1, ...) of balls on a line; with a `wall` left of the first at x = 0, of the same restitution."""

    def build(state: Values, parameters: Values) -> Scene:
        each, e = masses(parameters), restitution(parameters)
        count = len(each)
        names = [f"ball {n + 1}" for n in range(count)]
        bodies = [
            _ball(names[n], each[n], RADIUS, (state[n] + (2 * n + 1) * RADIUS, 0.0, 0.0), (state[count + n], 0.0, 0.0))
            for n in range(count)
        ]
        contacts = [Contact(names[n], AXIS, restitution=e, partner=names[n + 1]) for n in range(count - 1)]
        if wall:
            contacts.append(Contact(names[0], AXIS, restitution=e))
        return Scene((0.0, 0.0, 0.0), tuple(bodies), contacts=tuple(contacts))

    def observe(readings: Readings, parameters: Values) -> Values:
        balls = [readings.bodies[f"ball {n + 1}"] for n in range(len(masses(parameters)))]
        places = [position[0] - (2 * n + 1) * RADIUS for n, (position, *_) in enumerate(balls)]
        return (*places, *(velocity[0] for _, _, velocity, _ in balls))

    return SceneForm(build, observe, frozenset({"rigid_impact", "body_contact"}), conservative=False)


def discs_scene(state: Values, parameters: Values) -> Scene:
    m1, m2, reach, e = parameters
    bodies = tuple(
        _ball(f"disc {n + 1}", mass, reach / 2, (*state[2 * n : 2 * n + 2], 0.0), (*state[4 + 2 * n : 6 + 2 * n], 0.0))  # type: ignore[arg-type]
        for n, mass in enumerate((m1, m2))
    )
    return Scene((0.0, 0.0, 0.0), bodies, contacts=(Contact("disc 1", AXIS, restitution=e, partner="disc 2"),))


def discs_reading(readings: Readings, parameters: Values) -> Values:
    (r1, _, v1, _), (r2, _, v2, _) = readings.bodies["disc 1"], readings.bodies["disc 2"]
    return (*r1[:2], *r2[:2], *v1[:2], *v2[:2])


DISCS = SceneForm(discs_scene, discs_reading, frozenset({"rigid_impact", "body_contact"}), conservative=False)


def incline_scene(state: Values, parameters: Values) -> Scene:
    """The plane is horizontal and gravity is tilted; x is down the incline, y the gap below the sphere."""
    x, y, vx, vy = state
    along, across, e = parameters
    ball = _ball("ball", 1.0, RADIUS, (x, 0.0, RADIUS + y), (vx, 0.0, vy))
    return Scene((along, 0.0, -across), (ball,), contacts=(Contact("ball", (0.0, 0.0, 1.0), restitution=e),))


def incline_reading(readings: Readings, parameters: Values) -> Values:
    position, _, velocity, _ = readings.bodies["ball"]
    return position[0], position[2] - RADIUS, velocity[0], velocity[2]


INCLINE = SceneForm(incline_scene, incline_reading, frozenset({"rigid_impact"}), conservative=False)


def table_scene(state: Values, parameters: Values) -> Scene:
    """The table's position is prescribed; z is the height of the ball above the table."""
    z, u = state
    _g, e, b, A, w = parameters

    def lift(t: float) -> float:
        return b * t * t / 2 + A * sin(w * t)

    ball = _ball("ball", 1.0, RADIUS, (0.0, 0.0, RADIUS + z), (0.0, 0.0, u + A * w))
    table = Body("table", 1.0, (0.0, 0.0, 0.0))
    return Scene(
        (0.0, 0.0, -parameters[0]),
        (ball, table),
        sliders=(Slider("lift", "table", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.0, A * w, drive=lift),),
        contacts=(Contact("ball", (0.0, 0.0, 1.0), restitution=e, partner="table"),),
    )


def table_reading(readings: Readings, parameters: Values) -> Values:
    (place, rate), (position, _, velocity, _) = readings.joints["lift"], readings.bodies["ball"]
    return position[2] - RADIUS - place, velocity[2] - rate


TABLE = SceneForm(
    table_scene, table_reading, frozenset({"rigid_impact", "body_contact", "driven_axis"}), conservative=False
)

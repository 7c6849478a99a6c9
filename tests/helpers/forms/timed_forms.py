"""A form of each type whose motion depends on the time since `start`, which is its only parameter."""

from gnomon.cases.declare import *


def drive(t: Any, parameters: Values) -> Any:
    (start,) = parameters
    return cos(2 * (t - start))


def oscillator(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    return v, drive(t, parameters) - 4 * x


def pull(t: Any, place: Values, parameters: Values) -> Values:
    (x,) = place
    return (drive(t, parameters) - 4 * x,)


def stiffness(parameters: Values) -> Values:
    return 0, 1, -4, 0


def rest(t: Any, state: Values, parameters: Values) -> Values:
    x, _v = state
    return 0 * x, drive(t, parameters)


def moments(parameters: Values) -> Values:
    return 1, 2, 2.5


def torque(t: Any, state: Values, parameters: Values) -> Values:
    return drive(t, parameters), 0 * t, 0 * t


def light(parameters: Values) -> Values:
    return (8,)


def fields(t: Any, place: Values, parameters: Values) -> Values:
    return drive(t, parameters), 0 * t, 0 * t, 0 * t, 0 * t, 1 + 0 * t


def gyration(t: Any, state: Values, parameters: Values) -> Values:
    _x, _y, _z, u1, u2, u3 = state
    return u1, u2, u3, drive(t, parameters) + u2, -u1, 0 * u3


def wind(t: Any, place: Values, parameters: Values) -> Values:
    x, _y = place
    return drive(t, parameters), 0 * x - 1


def rod(t: Any, place: Values, parameters: Values) -> Values:
    x, y = place
    return ((x * x + y * y) / 2,)


def along_rod(t: Any, place: Values, parameters: Values) -> Values:
    return place


def pendulum(t: Any, state: Values, parameters: Values) -> Values:
    x, y, u, v = state
    fx, fy = wind(t, (x, y), parameters)
    tension = (x * fx + y * fy + u * u + v * v) / (x * x + y * y)
    return u, v, fx - tension * x, fy - tension * y


def fall(t: Any, state: Values, parameters: Values) -> Values:
    _y, v = state
    return v, drive(t, parameters) / 2 - 1


def floor(t: Any, state: Values, parameters: Values) -> Values:
    """It moves: the time of the guard matters."""
    return (state[0] + drive(t, parameters) / 32,)


def upwards(t: Any, place: Values, parameters: Values) -> Values:
    return (1 + 0 * place[0],)


def bounce(t: Any, state: Values, parameters: Values) -> Values:
    y, v = state
    return y, drive(t, parameters) / 32 - 7 * v / 8


def half(parameters: Values) -> Values:
    return (0.5,)


def early_or_late(t: Any, state: Values, parameters: Values) -> str:
    return "early" if t < parameters[0] + 1.5 else "late"


def slide(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    start, side = parameters
    return v, drive(t, (start,)) - 4 * x - side / 8


def bounds(t: Any, state: Values, parameters: Values) -> Values:
    x, _v = state
    return (2 + drive(t, parameters)) / 16, 0.25 + 0 * x


def masses(parameters: Values) -> Values:
    return 1.0, 0.0


def bodies(state: Values) -> tuple[Values, ...]:
    x, y, u, v = state
    return (0.0,) * 6, (x, y, 0.0, u, v, 0.0)


def of_bodies(found: tuple[Values, ...]) -> Values:
    _sun, (x, y, _z, u, v, _w) = found
    return x, y, u, v


def pushed_body(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    x, v = state
    body = Body("body", 1.0, (1.0, 1.0, 1.0), (x, 0.0, 0.0), velocity=(v, 0.0, 0.0))
    force = Force("body", "time_force", lambda t, place, velocity: (drive(t, parameters), 0.0, 0.0))
    return Scene((0.0, 0.0, 0.0), (body,), forces=(force,))


def of_readings(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    position, _, velocity, _ = readings.bodies["body"]
    return position[0], velocity[0]


FLIGHT: dict[str, Any] = {
    "modes": (Mode("early", fall), Mode("late", fall)),
    "start": early_or_late,
    "transitions": tuple(Transition("hit", mode, floor, -1, bounce, early_or_late) for mode in ("early", "late")),
    "settle": 1e-9,
}

FORMS: dict[type, tuple[Any, tuple[float, ...]]] = {
    FirstOrder: (FirstOrder(oscillator), (1, 0)),
    SecondOrder: (SecondOrder(pull), (1, 0)),
    SemiLinear: (SemiLinear(oscillator, linear=stiffness, rest=rest), (1, 0)),
    RigidBody: (RigidBody(moments, torque), (1, 0.5, 0.25, 1, 0, 0, 0, 1, 0, 0, 0, 1)),
    Charged: (Charged(gyration, fields=fields, light=light), (1, 0, 0, 2, 0, 0)),
    Constrained: (Constrained(pendulum, force=wind, constraint=rod, gradient=along_rod), (0, -1, 0.5, 0)),
    Impact: (Impact(**FLIGHT, free=fall, gap=floor, normal=upwards, restitution=half), (0.125, 0)),
    Friction: (Friction(**FLIGHT, sliding=slide, bounds=bounds), (1, 0)),
    Hybrid: (Hybrid(**FLIGHT), (0.125, 0)),
    NBody: (NBody(masses, bodies, of_bodies), (1, 0, 0, 1)),
    SceneForm: (SceneForm(pushed_body, of_readings, frozenset({"time_force", "gyroscopic"})), (1, 0)),
}
"""By type: a form and a state from which it moves."""

"""Forms that are wrong: functions of the wrong length, functions that raise, equations that end at t = 1.

Each form is correct except for one of its functions; `STARTS` are states from which all of them move. Those of first order
have two components, as other tests have for which Radau IIA 5 is compiled.
"""

from dataclasses import replace

from gnomon.cases.declare import *


def decay(t: Any, state: Values, parameters: Values) -> Values:
    (x,) = state
    return (-x,)


def decay_until_1(t: Any, state: Values, parameters: Values) -> Values:
    (x,) = state
    return (sqrt(1 - t) / 1024 - x,)


def decay_twice(t: Any, state: Values, parameters: Values) -> Values:
    (x,) = state
    return -x, -x


def swing_by_a_number(t: Any, state: Values, parameters: Values) -> Any:
    x, _v = state
    return -x


def nothing(t: Any, state: Values, parameters: Values) -> Values:
    return ()


def decay_or_raise(t: Any, state: Values, parameters: Values) -> Values:
    (x,) = state
    if x > 2:
        raise ValueError("x is above 2")
    return (-x,)


def swing_or_raise(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    if x > 2:
        raise ValueError("x is above 2")
    return v, -x


def swing_but_at_0(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    return v, (1 if x == 0 else -x)


def swing_above_0(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    return v, (-x if x > 0 else 0)


def blow_up(t: Any, place: Values, parameters: Values) -> Values:
    """x'' = 6 x^2 from 4 with the velocity 16: 1/(0.5 - t)^2 to five digits; from 1 at rest it is finite up to t = 1."""
    (x,) = place
    return (6 * x * x + sqrt(1 - t) / 1024,)


def rise_for_ever(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    return v, 6 * x * x + sqrt(1 - t) / 1024


def relax(t: Any, state: Values, parameters: Values) -> Values:
    """At a rate of 1e8 towards the time."""
    x, y = state
    return 100000000 * (t - x), 100000000 * (t - y)


def tremble(t: Any, place: Values, parameters: Values) -> Values:
    """At a frequency of 1e8 about the time."""
    (x,) = place
    return (10000000000000000 * (t - x),)


def one(parameters: Values) -> Values:
    return (1,)


def two(parameters: Values) -> Values:
    return 1, 2


def three(parameters: Values) -> Values:
    return 1, 2, 3


def none_given(parameters: Values) -> Values:
    raise ValueError("no numbers")


def gyrate(t: Any, state: Values, parameters: Values) -> Values:
    _x, _y, _z, u, v, w = state
    return u, v, w, v, -u, 0 * w


def fields(t: Any, place: Values, parameters: Values) -> Values:
    x = place[0]
    return 0 * x, 0 * x, 0 * x, 0 * x, 0 * x, 1 + 0 * x


def fields_until_1(t: Any, place: Values, parameters: Values) -> Values:
    x = place[0]
    return sqrt(1 - t), 0 * x, 0 * x, 0 * x, 0 * x, 1 + 0 * x


def no_magnetic_field(t: Any, place: Values, parameters: Values) -> Values:
    x = place[0]
    return 0 * x, 0 * x, 0 * x


def swing(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    return vx, vy, 0 * x, 0 * y


def swing_until_1(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    return vx, vy, 0 * x, 0 * y - sqrt(1 - t)


def weight(t: Any, place: Values, parameters: Values) -> Values:
    x, _y = place
    return 0 * x, 0 * x - 1


def weight_until_1(t: Any, place: Values, parameters: Values) -> Values:
    x, _y = place
    return 0 * x, 0 * x - sqrt(1 - t)


def rod(t: Any, place: Values, parameters: Values) -> Values:
    x, y = place
    return ((x * x + y * y) / 2,)


def along_rod(t: Any, place: Values, parameters: Values) -> Values:
    x, y = place
    return x, y


def no_torque(t: Any, state: Values, parameters: Values) -> Values:
    return 0 * t, 0 * t, 0 * t


def torque_until_1(t: Any, state: Values, parameters: Values) -> Values:
    return sqrt(1 - t), 0 * t, 0 * t


def torque_of_two(t: Any, state: Values, parameters: Values) -> Values:
    return 0 * t, 0 * t


def fall(t: Any, state: Values, parameters: Values) -> Values:
    _y, v = state
    return v, 0 * v - 1


def fall_until_1(t: Any, state: Values, parameters: Values) -> Values:
    _y, v = state
    return v, sqrt(1 - t) - 1


def fall_in_three(t: Any, state: Values, parameters: Values) -> Values:
    _y, v = state
    return v, 0 * v - 1, v


def height(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0],)


def height_until_1(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] + sqrt(1 - t),)


def upwards(t: Any, place: Values, parameters: Values) -> Values:
    return (1 + 0 * place[0],)


def bounce(t: Any, state: Values, parameters: Values) -> Values:
    y, v = state
    return y, -v / 2


def bounce_nowhere(t: Any, state: Values, parameters: Values) -> Values:
    y, v = state
    return y, v


def half(parameters: Values) -> Values:
    return (0.5,)


def slide(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    (side,) = parameters
    return v, -x - side / 2


def slide_until_1(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    (side,) = parameters
    return v, sqrt(1 - t) - x - side / 2


def bounds(t: Any, state: Values, parameters: Values) -> Values:
    x, _v = state
    return 0.5 + 0 * x, 0.5 + 0 * x


def start_flying(t: Any, state: Values, parameters: Values) -> str:
    return "flies"


def flight(
    equations: Any = fall, guard: Any = height, reset: Any = bounce, start: Any = start_flying, target: Any = "flies"
) -> dict[str, Any]:
    """A bouncing ball that states no limit mode."""
    hit = Transition("hit", "flies", guard, -1, reset, target)
    return {"modes": (Mode("flies", equations),), "start": start, "transitions": (hit,), "settle": 1e-9}


def contact(**other: Any) -> Impact:
    functions = {"free": fall, "gap": height, "normal": upwards, "restitution": half} | other
    return Impact(**flight(), **functions)


def rubbing(**other: Any) -> Friction:
    return Friction(**flight(), **({"sliding": slide, "bounds": bounds} | other))


def hanging(**other: Any) -> Constrained:
    return Constrained(swing, **({"force": weight, "constraint": rod, "gradient": along_rod} | other))


STARTS: dict[type, tuple[float, ...]] = {
    Charged: (1, 0, 0, 2, 0, 0), Constrained: (1, 0.125, -0.125, 1), SemiLinear: (1,), FirstOrder: (1, 0),
    SecondOrder: (1, 0), RigidBody: (1, 0.5, 0.25, 1, 0, 0, 0, 1, 0, 0, 0, 1), Impact: (1, 0), Friction: (1, 2),
    Hybrid: (1, 0),
}  # fmt: skip

WRONG_LENGTH: dict[type, tuple[tuple[Any, str], ...]] = {
    FirstOrder: (
        (FirstOrder(fall_in_three), "fall_in_three gives 3 values where 2 are wanted"),
        (FirstOrder(nothing), "nothing gives 0 values where 2 are wanted"),
        (FirstOrder(swing_by_a_number), "swing_by_a_number gives a float; let it give a tuple of 2"),
    ),
    SecondOrder: ((SecondOrder(decay_twice), "decay_twice gives 2 values where 1 is wanted"),),
    SemiLinear: (
        (SemiLinear(decay, linear=one, rest=decay_twice), "decay_twice gives 2 values where 1 is wanted"),
        (SemiLinear(decay, linear=two, rest=decay), "two gives 2 values where 1 is wanted"),
        (SemiLinear(decay, linear=none_given, rest=decay), "raises ValueError: no numbers"),
    ),
    Charged: (
        (Charged(gyrate, fields=no_magnetic_field, light=one), "no_magnetic_field gives 3 values where 6 are wanted"),
        (Charged(gyrate, fields=fields, light=two), "two gives 2 values where 1 is wanted"),
    ),
    Constrained: (
        (hanging(force=rod), "rod gives 1 value where 2 are wanted"),
        (hanging(constraint=along_rod, gradient=rod), "rod gives 1 value where 4 are wanted"),
        (hanging(mass=along_rod), "along_rod gives 2 values where 4 are wanted"),
        (hanging(constraint_rate=along_rod), "along_rod gives 2 values where 1 is wanted"),
    ),
    RigidBody: (
        (RigidBody(three, torque_of_two), "torque_of_two gives 2 values where 3 are wanted"),
        (RigidBody(two, no_torque), "two gives 2 values where 3 are wanted"),
    ),
    Impact: (
        (contact(free=fall_in_three), "fall_in_three gives 3 values where 2 are wanted"),
        (contact(gap=fall_in_three, normal=fall), r"raises ValueError: not enough values to unpack"),
        (contact(restitution=two), "two gives 2 values where 1 is wanted"),
    ),
    Friction: ((rubbing(bounds=upwards), "upwards gives 1 value where 2 are wanted"),),
    Hybrid: (
        (Hybrid(**flight(equations=fall_in_three)), "fall_in_three gives 3 values where 2 are wanted"),
        (Hybrid(**flight(guard=fall)), "fall gives 2 values where 1 is wanted"),
        (Hybrid(**flight(reset=height)), "height gives 1 value where 2 are wanted"),
        (Hybrid(**flight(target="rolls")), "there is no mode 'rolls'; the form has flies"),
    ),
}
"""By type: a form, and its error message."""

UNTIL_1: dict[type, Any] = {
    FirstOrder: FirstOrder(rise_for_ever),
    SecondOrder: SecondOrder(blow_up),
    SemiLinear: SemiLinear(decay, linear=one, rest=decay_until_1),
    Charged: Charged(gyrate, fields=fields_until_1, light=one),
    Constrained: replace(hanging(force=weight_until_1), equations=swing_until_1),
    RigidBody: RigidBody(three, torque_until_1),
    Impact: contact(free=fall_until_1),
    Friction: rubbing(sliding=slide_until_1),
    Hybrid: Hybrid(**flight(equations=fall_until_1)),
}
"""By type: a form whose functions return nan after t = 1."""

RAISING: dict[type, Any] = {
    FirstOrder: FirstOrder(swing_or_raise),
    SecondOrder: SecondOrder(decay_or_raise),
    SemiLinear: SemiLinear(decay, linear=one, rest=decay_or_raise),
}
"""By type: a form whose function raises an exception at some states."""

BRANCHING = (swing_but_at_0, swing_above_0)
"""Equations that work on numbers only, not on symbols."""

BLOWING_UP: dict[type, tuple[Any, tuple[float, ...]]] = {
    FirstOrder: (FirstOrder(rise_for_ever), (4, 16)),
    SecondOrder: (SecondOrder(blow_up), (4, 16)),
    Hybrid: (Hybrid(**flight(equations=rise_for_ever)), (4, 16)),
}
"""By type: a form and a state from which it is infinite at t = 0.5."""

STIFF: dict[type, Any] = {FirstOrder: FirstOrder(relax), SecondOrder: SecondOrder(tremble)}

"""Times, counts, positions and speeds of events, computed independently: from the events and the states at them."""

from typing import Any

import mpmath
from gnomon.cases import get
from independent_quantities import HYBRID, ObservedMotion, close, label_of, oracle
from mpmath import cos, pi, sin


def last(observed: ObservedMotion, *starts: str) -> Any:
    found = [event for start in starts for event in observed.events(start)]
    assert found, observed.events()
    return found[0]


@oracle(
    *("leaving_time", "stop_time", "strike_time", "grip_time", "slip_time", "first_impact", "impact_time", "onset"),
    *("rolling_time", "landing_time", "floor_time", "first_release", "last_impact", "t_inf", "apex_time", "lift_off"),
    "first_rest_time",
    of=HYBRID,
)
def time_of_event(observed: ObservedMotion, value: Any) -> Any:
    if value is observed.found.get("leaving_time"):
        return last(observed, "leaves").time
    if value is observed.found.get("last_impact"):
        return observed.events()[-1].time
    for label, start in (
        ("t_inf", "limit"),
        ("rolling_time", "rolls"),
        ("landing_time", "lands"),
        ("floor_time", "lies"),
    ):
        if value is observed.found.get(label):
            return last(observed, start).time
    if value is observed.found.get("stop_time") and observed.case.name == "coulomb_friction_oscillator":
        return observed.events()[-1].time
    if value is observed.found.get("first_release"):
        return last(observed, "release").time
    if value is observed.found.get("lift_off"):
        return last(observed, "lifts").time
    return observed.events()[0].time


@oracle(
    *("stick_slip_belt.slip_time", "stick_slip_falling_friction.slip_time", "stick_time"),
    *("stick_slip_belt.period", "stick_slip_falling_friction.period"),
    of=HYBRID,
)
def between_release_and_stick(observed: ObservedMotion, value: Any) -> Any:
    release, stick = observed.events("release"), observed.events("stick")
    after = next(e.time for e in stick if e.time > release[0].time)
    found = {"period": release[1].time - release[0].time, "slip_time": after - release[0].time}
    found["stick_time"] = release[1].time - after
    return next(x for n, x in found.items() if observed.found[n] is value)


@oracle("fastest_sliding", of=HYBRID)
def past_the_block(observed: ObservedMotion, value: Any) -> bool:
    """No sample of a slip slides faster, and one slides nearly as fast."""
    begin = observed.events("release")[0].time
    end = next(e.time for e in observed.events("stick") if e.time > begin)
    found = max(observed.p.V - observed.at(begin + (end - begin) * k / 200).v for k in range(201))
    return bool(value * (1 - mpmath.mpf("1e-3")) < found <= value)


@oracle("bouncing_ball.period", "bouncing_ball_incline.period", of=HYBRID)
def between_bounces(observed: ObservedMotion, value: Any) -> Any:
    return observed.events()[3].time - observed.events()[2].time


@oracle("coulomb_friction_oscillator.period", of=HYBRID)
def two_half_cycles(observed: ObservedMotion, value: Any) -> Any:
    return observed.events()[2].time - observed.events()[0].time


@oracle("planet_tunnel.period", "work_energy_spring_block.period", of=HYBRID)
def initial_state_returns(observed: ObservedMotion, value: Any) -> bool:
    """The initial state returns after the period, and not after half of it."""
    a, b, c = (observed.state(value * k) for k in (0, 1, mpmath.mpf(1) / 2))
    size = max(map(abs, a))
    off = [max(abs(x - y) for x, y in zip(a, s, strict=True)) / size for s in (b, c)]
    return bool(off[0] < 1e-18 and off[1] > 1e-3)


@oracle("contact_time", of=HYBRID)
def on_the_spring(observed: ObservedMotion, value: Any) -> Any:
    return observed.events("lift")[0].time - observed.events("touch")[0].time


@oracle("return_time", "return_speed", of=HYBRID)
def back_at_the_start(observed: ObservedMotion, value: Any) -> Any:
    time, x = observed.found["return_time"], observed.names[0]
    assert abs(getattr(observed.at(time), x) - getattr(observed.at(0), x)) < 1e-18
    return time if value is time else abs(observed.at(time).v)


@oracle("flight_time", of=HYBRID)
def back_on_the_circle(observed: ObservedMotion, value: Any) -> Any:
    """The time from leaving the circle, along its tangent, until the parabola meets the circle again."""
    event, p = last(observed, "leaves"), observed.p
    angle, rate = event.before.theta, event.before.omega
    x, y = p.R * sin(angle), -p.R * cos(angle)
    vx, vy = p.R * rate * cos(angle), p.R * rate * sin(angle)
    fall = (x + vx * value) ** 2 + (y + vy * value - p.g * value**2 / 2) ** 2
    inside = (x + vx * value / 2) ** 2 + (y + vy * value / 2 - p.g * value**2 / 8) ** 2
    return bool(value == mpmath.inf or (abs(fall - p.R**2) < 1e-18 and inside < p.R**2))


@oracle("impacts", "half_cycles", "bounces", of=HYBRID)
def events_counted(observed: ObservedMotion, value: Any) -> bool:
    if any(event.name == "limit" for event in observed.events()):
        return bool(value == mpmath.inf)
    return bool(value == len(observed.events()))


@oracle("fires", of=HYBRID)
def strikes_counted(observed: ObservedMotion, value: Any) -> bool:
    return bool(value == len(observed.events("strike")))


@oracle("turns", of=HYBRID)
def over_the_top(observed: ObservedMotion, value: Any) -> Any:
    return mpmath.floor((abs(observed.events()[0].after.theta) + pi) / (2 * pi))


@oracle("leaving_speed", "leaving_angle", "leaving_rate", "floor_rate", "centre_velocity", of=HYBRID)
def at_the_event(observed: ObservedMotion, value: Any) -> Any:
    label = label_of(observed, value)
    if label == "floor_rate":
        return last(observed, "lies").before.omega
    event = last(observed, "leaves").before
    if label == "centre_velocity":
        return observed.p.L / 2 * cos(event.theta) * event.omega
    return getattr(event, {"leaving_speed": "v", "leaving_angle": "theta", "leaving_rate": "omega"}[label])


@oracle("strike_speed", "impact_speed", "surface_speed", "lift_off_speed", of=HYBRID)
def speed_at_the_event(observed: ObservedMotion, value: Any) -> Any:
    event = last(observed, "strike", "bounce", "leaves_down", "enters", "lifts").before
    return abs(getattr(event, "vy" if hasattr(event, "vy") else "v"))


@oracle("rolling_vx", "rolling_vy", "deflection", "slide_x", "slide_speed", "common_w1", "rolling_speed", of=HYBRID)
def state_at_the_event(observed: ObservedMotion, value: Any) -> Any:
    label = label_of(observed, value)
    event = last(observed, "rolls", "lands", "limit", "grips").after
    names = {"deflection": "y", "slide_x": "x", "slide_speed": "vx", "common_w1": "w1", "rolling_speed": "v"}
    return getattr(event, names.get(label, label.removeprefix("rolling_")))


@oracle("stop_position", "stop_distance", "stop_angle", "first_rest", "second_rest", of=HYBRID)
def place_at_rest(observed: ObservedMotion, value: Any) -> Any:
    label = label_of(observed, value)
    events = observed.events("stop") or observed.events()
    event = events[{"first_rest": 0, "second_rest": 1}.get(label, -1)].after
    start = getattr(observed.at(0), observed.names[0]) if label == "stop_distance" else 0
    return abs(getattr(event, observed.names[0]) - start) if start else getattr(event, observed.names[0])


@oracle("jump", of=HYBRID)
def jump_of_the_rate(observed: ObservedMotion, value: Any) -> Any:
    event = last(observed, "blow")
    return event.after.omega - event.before.omega


@oracle("amplitude_before", "amplitude_after", "swing_angle", of=HYBRID)
def angle_of_the_turning_point(observed: ObservedMotion, value: Any) -> Any:
    """The angle that follows from the energy of the swing: theta'^2/2 = w^2 (cos(theta) - cos(largest))."""
    event = observed.events()[0]
    state = event.before if value is observed.found.get("amplitude_before") else event.after
    w2 = observed.p.g / observed.p.L if hasattr(observed.p, "L") else 3 * observed.p.g / (2 * observed.p.l)
    return mpmath.acos(cos(state.theta) - state.omega**2 / (2 * w2))


@oracle("rise", of=HYBRID)
def rise_to_the_turning_point(observed: ObservedMotion, value: Any) -> Any:
    return observed.p.L * (1 - cos(observed.found["swing_angle"]))


@oracle("rate", of=HYBRID)
def after_the_impact(observed: ObservedMotion, value: Any) -> Any:
    return observed.events()[0].after.omega


@oracle("farthest", "apex_height", of=HYBRID)
def largest_position(observed: ObservedMotion, value: Any) -> Any:
    until = observed.found.get("period", observed.found.get("return_time"))
    return observed.largest(lambda s: getattr(s, observed.names[0]), until)


@oracle("largest_compression", of=HYBRID)
def largest_compression(observed: ObservedMotion, value: Any) -> Any:
    return -observed.least(lambda s: s.y, observed.found["period"])


@oracle("apex", of=HYBRID)
def apex_of_the_mass_centre(observed: ObservedMotion, value: Any) -> Any:
    total = observed.p.m1 + observed.p.m2
    return observed.largest(lambda s: (observed.p.m1 * s.y1 + observed.p.m2 * s.y2) / total)


@oracle("last_speed", of=HYBRID)
def speed_of_the_last_ball(observed: ObservedMotion, value: Any) -> Any:
    return observed.state(observed.span)[-1]


@oracle("final_speed", "final_velocity", of=HYBRID)
def at_the_end(observed: ObservedMotion, value: Any) -> Any:
    end = max(observed.span, observed.events()[-1].time)
    return observed.at(2 * end).v


@oracle("late", of=HYBRID)
def lag_behind_an_impulse(observed: ObservedMotion, value: Any) -> Any:
    at_once = get(observed.case.name, **{**observed.case.parameters, "T": 0}, initial_state=observed.case.initial_state)
    return ObservedMotion(at_once).at(observed.span).x - observed.at(observed.span).x


@oracle("path_length", of=HYBRID)
def path_of_bounces(observed: ObservedMotion, value: Any) -> bool:
    """The first fall, then v^2/g for each bounce; the rest of the sum is below the gap `settle`."""
    bounces = observed.events("bounce")
    pull = getattr(observed.p, "g", None) or observed.p.g_across
    total = bounces[0].before.v ** 2 / (2 * pull) + sum(e.after.v**2 for e in bounces) / pull
    return close(value, total, 14)

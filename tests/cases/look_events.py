"""Times, counts, places and speeds of events."""

from __future__ import annotations

from typing import Any

import mpmath
from gnomon.cases import get
from mpmath import cos, pi, sin
from outside import HYBRID, Outside, close, label_of, oracle


def last(look: Outside, *starts: str) -> Any:
    found = [event for start in starts for event in look.events(start)]
    assert found, look.events()
    return found[0]


@oracle(
    *("leaving_time", "stop_time", "strike_time", "grip_time", "slip_time", "first_impact", "impact_time", "onset"),
    *("rolling_time", "landing_time", "floor_time", "first_release", "last_impact", "t_inf", "apex_time", "lift_off"),
    "first_rest_time",
    of=HYBRID,
)
def when(look: Outside, value: Any) -> Any:
    if value is look.found.get("leaving_time"):
        return last(look, "leaves").time
    if value is look.found.get("last_impact"):
        return look.events()[-1].time
    for label, start in (
        ("t_inf", "limit"),
        ("rolling_time", "rolls"),
        ("landing_time", "lands"),
        ("floor_time", "lies"),
    ):
        if value is look.found.get(label):
            return last(look, start).time
    if value is look.found.get("stop_time") and look.case.name == "coulomb_friction_oscillator":
        return look.events()[-1].time
    if value is look.found.get("first_release"):
        return last(look, "release").time
    if value is look.found.get("lift_off"):
        return last(look, "lifts").time
    return look.events()[0].time


@oracle("stick_slip_belt.slip_time", "stick_time", "stick_slip_belt.period", of=HYBRID)
def between_release_and_stick(look: Outside, value: Any) -> Any:
    release, stick = look.events("release"), look.events("stick")
    after = next(e.time for e in stick if e.time > release[0].time)
    found = {"period": release[1].time - release[0].time, "slip_time": after - release[0].time}
    found["stick_time"] = release[1].time - after
    return next(x for n, x in found.items() if look.found[n] is value)


@oracle("bouncing_ball.period", "bouncing_ball_incline.period", of=HYBRID)
def between_bounces(look: Outside, value: Any) -> Any:
    return look.events()[3].time - look.events()[2].time


@oracle("coulomb_friction_oscillator.period", of=HYBRID)
def two_half_cycles(look: Outside, value: Any) -> Any:
    return look.events()[2].time - look.events()[0].time


@oracle("planet_tunnel.period", "work_energy_spring_block.period", of=HYBRID)
def comes_back(look: Outside, value: Any) -> bool:
    """The start returns, and no part of the period brings it back."""
    a, b, c = (look.state(value * k) for k in (0, 1, mpmath.mpf(1) / 2))
    size = max(map(abs, a))
    off = [max(abs(x - y) for x, y in zip(a, s, strict=True)) / size for s in (b, c)]
    return bool(off[0] < 1e-18 and off[1] > 1e-3)


@oracle("contact_time", of=HYBRID)
def on_the_spring(look: Outside, value: Any) -> Any:
    return look.events("lift")[0].time - look.events("touch")[0].time


@oracle("return_time", "return_speed", of=HYBRID)
def back_at_the_start(look: Outside, value: Any) -> Any:
    time, x = look.found["return_time"], look.names[0]
    assert abs(getattr(look.at(time), x) - getattr(look.at(0), x)) < 1e-18
    return time if value is time else abs(look.at(time).v)


@oracle("flight_time", of=HYBRID)
def back_on_the_circle(look: Outside, value: Any) -> Any:
    """From where it leaves, thrown along the circle, to where the parabola meets the circle again."""
    event, p = last(look, "leaves"), look.p
    angle, rate = event.before.theta, event.before.omega
    x, y = p.R * sin(angle), -p.R * cos(angle)
    vx, vy = p.R * rate * cos(angle), p.R * rate * sin(angle)
    fall = (x + vx * value) ** 2 + (y + vy * value - p.g * value**2 / 2) ** 2
    inside = (x + vx * value / 2) ** 2 + (y + vy * value / 2 - p.g * value**2 / 8) ** 2
    return bool(value == mpmath.inf or (abs(fall - p.R**2) < 1e-18 and inside < p.R**2))


@oracle("impacts", "half_cycles", "bounces", of=HYBRID)
def events_counted(look: Outside, value: Any) -> bool:
    if any(event.name == "limit" for event in look.events()):
        return bool(value == mpmath.inf)
    return bool(value == len(look.events()))


@oracle("fires", of=HYBRID)
def struck_or_not(look: Outside, value: Any) -> bool:
    return bool(value == len(look.events("strike")))


@oracle("turns", of=HYBRID)
def over_the_top(look: Outside, value: Any) -> Any:
    return mpmath.floor((abs(look.events()[0].after.theta) + pi) / (2 * pi))


@oracle("leaving_speed", "leaving_angle", "leaving_rate", "floor_rate", "centre_velocity", of=HYBRID)
def at_the_event(look: Outside, value: Any) -> Any:
    label = label_of(look, value)
    if label == "floor_rate":
        return last(look, "lies").before.omega
    event = last(look, "leaves").before
    if label == "centre_velocity":
        return look.p.L / 2 * cos(event.theta) * event.omega
    return getattr(event, {"leaving_speed": "v", "leaving_angle": "theta", "leaving_rate": "omega"}[label])


@oracle("strike_speed", "impact_speed", "surface_speed", "lift_off_speed", of=HYBRID)
def speed_at_the_event(look: Outside, value: Any) -> Any:
    event = last(look, "strike", "bounce", "leaves_down", "enters", "lifts").before
    return abs(getattr(event, "vy" if hasattr(event, "vy") else "v"))


@oracle("rolling_vx", "rolling_vy", "deflection", "slide_x", "slide_speed", "common_w1", "rolling_speed", of=HYBRID)
def state_at_the_event(look: Outside, value: Any) -> Any:
    label = label_of(look, value)
    event = last(look, "rolls", "lands", "limit", "grips").after
    names = {"deflection": "y", "slide_x": "x", "slide_speed": "vx", "common_w1": "w1", "rolling_speed": "v"}
    return getattr(event, names.get(label, label.removeprefix("rolling_")))


@oracle("stop_position", "stop_distance", "stop_angle", "first_rest", "second_rest", of=HYBRID)
def place_at_rest(look: Outside, value: Any) -> Any:
    label = label_of(look, value)
    events = look.events("stop") or look.events()
    event = events[{"first_rest": 0, "second_rest": 1}.get(label, -1)].after
    start = getattr(look.at(0), look.names[0]) if label == "stop_distance" else 0
    return abs(getattr(event, look.names[0]) - start) if start else getattr(event, look.names[0])


@oracle("jump", of=HYBRID)
def of_the_rate(look: Outside, value: Any) -> Any:
    event = last(look, "blow")
    return event.after.omega - event.before.omega


@oracle("amplitude_before", "amplitude_after", "swing_angle", of=HYBRID)
def where_it_turns(look: Outside, value: Any) -> Any:
    """The height that the swing's own energy reaches: theta'^2/2 = w^2 (cos(theta) - cos(largest))."""
    event = look.events()[0]
    state = event.before if value is look.found.get("amplitude_before") else event.after
    w2 = look.p.g / look.p.L if hasattr(look.p, "L") else 3 * look.p.g / (2 * look.p.l)
    return mpmath.acos(cos(state.theta) - state.omega**2 / (2 * w2))


@oracle("rise", of=HYBRID)
def to_the_turning_point(look: Outside, value: Any) -> Any:
    return look.p.L * (1 - cos(look.found["swing_angle"]))


@oracle("rate", of=HYBRID)
def after_the_impact(look: Outside, value: Any) -> Any:
    return look.events()[0].after.omega


@oracle("farthest", "apex_height", of=HYBRID)
def furthest(look: Outside, value: Any) -> Any:
    until = look.found.get("period", look.found.get("return_time"))
    return look.largest(lambda s: getattr(s, look.names[0]), until)


@oracle("largest_compression", of=HYBRID)
def deepest(look: Outside, value: Any) -> Any:
    return -look.least(lambda s: s.y, look.found["period"])


@oracle("apex", of=HYBRID)
def of_the_mass_centre(look: Outside, value: Any) -> Any:
    total = look.p.m1 + look.p.m2
    return look.largest(lambda s: (look.p.m1 * s.y1 + look.p.m2 * s.y2) / total)


@oracle("last_speed", of=HYBRID)
def of_the_last_ball(look: Outside, value: Any) -> Any:
    return look.state(look.span)[-1]


@oracle("final_speed", "final_velocity", of=HYBRID)
def at_the_end(look: Outside, value: Any) -> Any:
    end = max(look.span, look.events()[-1].time)
    return look.at(2 * end).v


@oracle("late", of=HYBRID)
def against_a_pulse_at_once(look: Outside, value: Any) -> Any:
    at_once = get(look.case.name, **{**look.case.parameters, "T": 0}, initial_state=look.case.initial_state)
    return Outside(at_once).at(look.span).x - look.at(look.span).x


@oracle("path_length", of=HYBRID)
def up_and_down(look: Outside, value: Any) -> bool:
    """The first fall, then v^2/g a bounce; what is missing of the sum is below the gap `settle`."""
    bounces = look.events("bounce")
    pull = getattr(look.p, "g", None) or look.p.g_across
    total = bounces[0].before.v ** 2 / (2 * pull) + sum(e.after.v**2 for e in bounces) / pull
    return close(value, total, 14)

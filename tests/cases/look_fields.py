"""Charges, drag, forcing and the turning Earth."""

from __future__ import annotations

from typing import Any

import mpmath
import pytest
from gnomon.cases import get
from mpmath import cos, hypot, pi, sin, sqrt
from outside import Late, Outside, close, oracle


@oracle("gyration_rate", "gyration_period", "gyroradius")
def gyration(look: Outside, value: Any) -> Any:
    """The acceleration turns at the rate; the radius is |a|/rate^2, both across the magnetic field."""
    h = mpmath.mpf("1e-9")
    field = mpmath.matrix([look.p.Bx, look.p.By, look.p.Bz])
    a, b = (mpmath.matrix([look.rate(n, t) for n in ("vx", "vy", "vz")]) for t in (h, 2 * h))
    a, b = (x - field * (mpmath.fdot(x, field) / mpmath.norm(field) ** 2) for x in (a, b))
    rate = mpmath.norm(b - a) / mpmath.norm(a) / h
    found = {"gyration_rate": rate, "gyration_period": 2 * pi / rate, "gyroradius": mpmath.norm(a) / rate**2}
    # a chord of 1e-9 rad, and differences over 1e-12 of differences over 1e-9
    return any(value is look.found[n] and close(value, x, 8) for n, x in found.items())


@oracle("drift_x", "drift_y", "drift_z")
def mean_motion_across_the_field(look: Outside, value: Any) -> Any:
    axis = next(n for n in "xyz" if look.found[f"drift_{n}"] is value)
    period = look.found["gyration_period"]
    way = mpmath.matrix([getattr(look.at(period), n) - getattr(look.at(0), n) for n in "xyz"]) / period
    field = mpmath.matrix([look.p.Bx, look.p.By, look.p.Bz])
    along = sum(a * b for a, b in zip(way, field, strict=True)) / mpmath.norm(field) ** 2
    return (way - along * field)["xyz".index(axis)]


@oracle("gamma")
def lorentz_factor(look: Outside, value: Any) -> Any:
    """u is gamma v: the velocity is the slope of the place."""
    speed = mpmath.norm(mpmath.matrix([look.rate(n) for n in "xyz"]))
    return 1 / sqrt(1 - (speed / look.p.c) ** 2)


@oracle("proper_time")
def clock_on_the_charge(look: Outside, value: Any) -> bool:
    def slow(t: Any) -> Any:
        s = look.at(t)
        return 1 / sqrt(1 + (s.ux**2 + s.uy**2 + s.uz**2) / look.p.c**2)

    # Simpson's rule on 64 intervals of some twentieth of a turn
    h = look.span / 64
    total = sum((1 if k in (0, 64) else 4 if k % 2 else 2) * slow(k * h) for k in range(65)) * h / 3
    return close(value, total, 5)


@oracle("tangential_acceleration", "curvature_radius")
def of_the_path(look: Outside, value: Any) -> bool:
    def velocity(t: Any) -> Any:
        return mpmath.matrix([look.rate(n, t) for n in "xyz"])

    h = mpmath.mpf(look.case.time_scale) * mpmath.mpf("1e-9")
    v, a = velocity(h), (velocity(2 * h) - velocity(0)) / (2 * h)
    along = sum(x * y for x, y in zip(a, v, strict=True)) / mpmath.norm(v)
    if value is look.found["tangential_acceleration"]:
        return close(value, along, 6)
    across = sqrt(mpmath.norm(a) ** 2 - along**2)
    return close(value, mpmath.norm(v) ** 2 / across, 6)


@oracle("field_square", "field_product")
def of_the_fields(look: Outside, value: Any) -> Any:
    """As a boost along x at 3/5 of c sees them (Jackson, Classical Electrodynamics, 11.10)."""
    p, gamma, beta = look.p, mpmath.mpf(5) / 4, mpmath.mpf(3) / 5
    e = [p.Ex, gamma * (p.Ey - beta * p.c * p.Bz), gamma * (p.Ez + beta * p.c * p.By)]
    b = [p.Bx, gamma * (p.By + beta * p.Ez / p.c), gamma * (p.Bz - beta * p.Ey / p.c)]
    if value is look.found["field_product"]:
        return sum(x * y for x, y in zip(e, b, strict=True))
    return sum(x * x for x in e) - p.c**2 * sum(x * x for x in b)


@oracle("crossing")
def above_or_below_the_focus(look: Outside, value: Any) -> bool:
    """There one of xi, eta is zero, and y = (eta^2 - xi^2)/2."""
    x, y = look.names[:2]
    t = mpmath.findroot(lambda t: getattr(look.at(t), x) * getattr(look.at(t), y), (0, look.span), solver="anderson")
    s = look.at(t)
    return close(value, (getattr(s, y) ** 2 - getattr(s, x) ** 2) / 2)


@oracle("terminal_speed")
def at_last(look: Outside, value: Any) -> Any:
    """Where the rates of the velocity vanish: falling straight down."""
    down = next(n for n in ("vz", "vy", "v") if n in look.names)
    rest = {n: mpmath.mpf(0) for n in look.names if n.startswith("v")} | {down: -value}
    return bool(abs(look.equations(rest)[look.names.index(down)]) < 1e-18)


@oracle("relaxation_time")
def of_the_velocity(look: Outside, value: Any) -> Any:
    return -1 / look.jacobian([mpmath.mpf(0)] * 2)[1, 1]


@oracle("falling_speed", "rising_speed")
def balanced(look: Outside, value: Any) -> bool:
    """Of the drop without the field, downward, and in it, upward: no acceleration is left."""
    falls = value is look.found["falling_speed"]
    pull = look.equations([mpmath.mpf(0), -value if falls else value], **({"E": mpmath.mpf(0)} if falls else {}))[1]
    return bool(abs(pull) < 1e-18 * look.p.g)


@oracle("charge")
def what_was_put_in(look: Outside, value: Any) -> Any:
    return look.p.q


@oracle("apex_time", "apex_height")
def highest(look: Outside, value: Any) -> Any:
    time = look.found["apex_time"]
    assert abs(look.at(time).vy) < 1e-18
    return time if value is time else look.at(time).y


@oracle("landing_time", "flight_time", "landing_x", "range")
def comes_down(look: Outside, value: Any) -> Any:
    time = look.found.get("landing_time") or look.found["flight_time"]
    assert abs(look.at(time).y) < 1e-18
    assert time > 0
    return time if value is time else look.at(time).x - (0 if value is look.found.get("landing_x") else look.at(0).x)


@oracle("highest_apex", "farthest_range")
def best_of_all_throws(look: Outside, value: Any) -> bool:
    """Straight up it is reached, and of 89 throws at whole degrees none goes beyond."""
    speed, best = hypot(look.at(0).vx, look.at(0).vy), []
    high = value is look.found["highest_apex"]
    for degrees in range(1, 91):
        angle = pi * degrees / 180
        start = [look.case.initial_state[0], look.case.initial_state[1], speed * cos(angle), speed * sin(angle)]
        throw = get(look.case.name, initial_state=start, g=look.case.parameters["g"]).quantities(30)
        best.append(throw["apex_height" if high else "landing_x"])
    return close(max(best), value) and best.index(max(best)) == (89 if high else 44)


@oracle("steady_amplitude", "phase_lag", "magnification", "unbalance_ratio", "transmissibility")
def long_after_the_start(look: Outside, value: Any) -> Any:
    """x = X cos(w t - lag) once all else has died away; the others are ratios of its terms in the equations."""
    p, whole = look.p, 2 * pi / look.p.w
    late = whole * mpmath.ceil(200 * p.m / p.c / whole)
    here, quarter = (look.at(late + k * whole / 4) for k in (0, 1))
    size, lag = hypot(here.x, quarter.x), mpmath.atan2(quarter.x, here.x)
    passed = hypot(*(p.k * s.x + p.c * s.v for s in (here, quarter)))
    found = {"steady_amplitude": size, "phase_lag": lag, "magnification": size / (p.F0 / p.k)}
    found |= {"unbalance_ratio": p.m * size * p.w**2 / p.F0, "transmissibility": passed / p.F0}
    return next(x for n, x in found.items() if look.found[n] is value)


@oracle("growing_part", "dying_part", "bounded_amplitude")
def three_parts(look: Outside, value: Any) -> bool:
    """r = A e^(Ot) + B e^(-Ot) + C sin(Ot) at three other times."""
    a, b, c = (look.found[n] for n in ("growing_part", "dying_part", "bounded_amplitude"))
    u = [look.p.O * t for t in (mpmath.mpf("0.3"), mpmath.mpf("0.9"), mpmath.mpf("1.7"))]
    found = [a * mpmath.exp(x) + b * mpmath.exp(-x) + c * sin(x) for x in u]
    return all(close(look.at(x / look.p.O).r, r) for x, r in zip(u, found, strict=True))


@oracle("phase")
def of_the_cosine(look: Outside, value: Any) -> bool:
    w, size = 2 * pi / look.found["period"], look.found["amplitude"]
    return any(
        all(close(look.at(t).x, size * cos(w * t + sign * value)) for t in (mpmath.mpf("0.3"), mpmath.mpf(1)))
        for sign in (1, -1)
    )


@oracle("fall_time", "east_deflection", "north_deflection")
def strikes(look: Outside, value: Any) -> Any:
    """At z = 0, to the right of the start as seen along the axes x (east) and y (north)."""
    time = look.found["fall_time"]
    assert abs(look.at(time).z) < 1e-17
    return next(
        x
        for n, x in (("fall_time", time), ("east_deflection", look.at(time).x), ("north_deflection", look.at(time).y))
        if look.found[n] is value
    )


@oracle("first_order_deflection")
def of_the_motion_to_first_order(look: Outside, value: Any) -> bool:
    numbers = {name: look.case.parameters[name] for name in ("g", "Om", "lat")}
    first = Outside(get("free_fall_first_order", initial_state=look.case.initial_state, **numbers))
    time = sqrt(2 * look.at(0).z / look.p.g)
    return close(value, first.at(time).x, 12)


@oracle("free_time_limit")
def turns_no_further_than_the_free_body(look: Outside, value: Any) -> bool:
    """At last it stands as the free body stands at that time."""
    still, numbers = look.at(200 / look.p.nu), dict(look.case.parameters)
    attitude = [n for n in look.names if n[0] in "wR"]
    start = [x for n, x in zip(look.names, look.case.initial_state, strict=True) if n in attitude]
    free = Outside(get("euler_top", initial_state=start, **{n: numbers[n] for n in ("I1", "I2", "I3")})).at(value)
    return all(close(getattr(still, n), getattr(free, n)) for n in attitude if n[0] == "R")


@oracle("final_momentum")
def along_the_vertical(look: Outside, value: Any) -> Any:
    """To which it decays: of three equally spaced values Aitken's rule gives the limit of an exponential."""
    a, b, c = (
        sum(getattr(look.p, f"I{i}") * getattr(s, f"w{i}") * getattr(s, f"R3{i}") for i in (1, 2, 3))
        for s in (look.at(t * look.span / 8) for t in range(3))
    )
    return (a * c - b * b) / (a + c - 2 * b)


@oracle("end_time")
def neither_slides_nor_drills(look: Outside, value: Any) -> bool:
    before, after = (look.at(value * share) for share in (mpmath.mpf("0.9"), 1 - mpmath.mpf("1e-12")))
    slips = [max(abs(s.vx - look.p.R * s.wy), abs(s.vy + look.p.R * s.wx), abs(s.wz)) for s in (before, after)]
    with pytest.raises(ValueError, match="neither slides nor drills"):
        look.at(value * (1 + mpmath.mpf("1e-12")))
    return bool(slips[1] < 1e-9 * slips[0])


@oracle("final_vx", "final_vy")
def once_it_rolls(look: Outside, value: Any) -> Any:
    return getattr(
        look.at(look.found["end_time"] * (1 - mpmath.mpf("1e-12"))), "vx" if value is look.found["final_vx"] else "vy"
    )


@oracle("final_speed")
def chaplygin_at_last(look: Outside, value: Any) -> Any:
    return look.at(200).v


@oracle("whole_turn")
def from_the_far_past(look: Outside, value: Any) -> Any:
    return look.at(200).theta - look.at(-200).theta


@oracle("edge_x", "edge_y")
def along_the_edge(look: Outside, value: Any) -> bool:
    """The integral of v cos(theta), v sin(theta)."""
    part = mpmath.cos if value is look.found["edge_x"] else mpmath.sin
    pieces = [look.span * k / 6 for k in range(7)]
    found = mpmath.quad(lambda t: look.at(t).v * part(look.at(t).theta), pieces, method="gauss-legendre", maxdegree=4)
    return close(value, found, 10)


@oracle("knife_edge_incline.drift")
def mean_velocity_across(look: Outside, value: Any) -> Any:
    turn = 2 * pi / look.p.w
    return max((look.at(turn).x - look.at(0).x) / turn, (look.at(turn).y - look.at(0).y) / turn, key=abs)


@oracle("fluctuation")
def half_of_the_swing_of_the_rate(look: Outside, value: Any) -> Any:
    late, turn = 200 * look.p.I / look.p.c, 2 * pi / look.p.W
    found = look.extremes(lambda s: s.w, turn)  # its times are moved to late ones
    shifted = Late(look, late).extremes(lambda s: s.w, turn)
    assert found
    return (max(x for _, x in shifted) - min(x for _, x in shifted)) / 2

"""Quantities of charges, drag, forcing and the rotating Earth, computed independently: from motion and equations."""

from typing import Any

import mpmath
import pytest
from gnomon.cases import get
from independent_quantities import LaterMotion, ObservedMotion, close, oracle
from mpmath import cos, hypot, pi, sin, sqrt


@oracle("gyration_rate", "gyration_period", "gyroradius")
def gyration(observed: ObservedMotion, value: Any) -> Any:
    """The acceleration rotates at the rate; the radius is |a|/rate^2; both normal to the magnetic field."""
    h = mpmath.mpf("1e-9")
    field = mpmath.matrix([observed.p.Bx, observed.p.By, observed.p.Bz])
    a, b = (mpmath.matrix([observed.rate(n, t) for n in ("vx", "vy", "vz")]) for t in (h, 2 * h))
    a, b = (x - field * (mpmath.fdot(x, field) / mpmath.norm(field) ** 2) for x in (a, b))
    rate = mpmath.norm(b - a) / mpmath.norm(a) / h
    found = {"gyration_rate": rate, "gyration_period": 2 * pi / rate, "gyroradius": mpmath.norm(a) / rate**2}
    # a chord of 1e-9 rad, and differences over 1e-12 of differences over 1e-9
    return any(value is observed.found[n] and close(value, x, 8) for n, x in found.items())


@oracle("drift_x", "drift_y", "drift_z")
def mean_motion_across_the_field(observed: ObservedMotion, value: Any) -> Any:
    axis = next(n for n in "xyz" if observed.found[f"drift_{n}"] is value)
    period = observed.found["gyration_period"]
    way = mpmath.matrix([getattr(observed.at(period), n) - getattr(observed.at(0), n) for n in "xyz"]) / period
    field = mpmath.matrix([observed.p.Bx, observed.p.By, observed.p.Bz])
    along = sum(a * b for a, b in zip(way, field, strict=True)) / mpmath.norm(field) ** 2
    return (way - along * field)["xyz".index(axis)]


@oracle("gamma")
def lorentz_factor(observed: ObservedMotion, value: Any) -> Any:
    """gamma from the velocity, the derivative of the position."""
    speed = mpmath.norm(mpmath.matrix([observed.rate(n) for n in "xyz"]))
    return 1 / sqrt(1 - (speed / observed.p.c) ** 2)


@oracle("proper_time")
def proper_time_by_quadrature(observed: ObservedMotion, value: Any) -> bool:
    def slow(t: Any) -> Any:
        s = observed.at(t)
        return 1 / sqrt(1 + (s.ux**2 + s.uy**2 + s.uz**2) / observed.p.c**2)

    # Simpson's rule on 64 intervals of about a twentieth of a turn
    h = observed.span / 64
    total = sum((1 if k in (0, 64) else 4 if k % 2 else 2) * slow(k * h) for k in range(65)) * h / 3
    return close(value, total, 5)


@oracle("tangential_acceleration", "curvature_radius")
def curvature_of_the_path(observed: ObservedMotion, value: Any) -> bool:
    def velocity(t: Any) -> Any:
        return mpmath.matrix([observed.rate(n, t) for n in "xyz"])

    h = mpmath.mpf(observed.case.time_scale) * mpmath.mpf("1e-9")
    v, a = velocity(h), (velocity(2 * h) - velocity(0)) / (2 * h)
    along = sum(x * y for x, y in zip(a, v, strict=True)) / mpmath.norm(v)
    if value is observed.found["tangential_acceleration"]:
        return close(value, along, 6)
    across = sqrt(mpmath.norm(a) ** 2 - along**2)
    return close(value, mpmath.norm(v) ** 2 / across, 6)


@oracle("field_square", "field_product")
def invariants_of_the_fields(observed: ObservedMotion, value: Any) -> Any:
    """From the fields after a boost along x at 3/5 of c (Jackson, Classical Electrodynamics, 11.10)."""
    p, gamma, beta = observed.p, mpmath.mpf(5) / 4, mpmath.mpf(3) / 5
    e = [p.Ex, gamma * (p.Ey - beta * p.c * p.Bz), gamma * (p.Ez + beta * p.c * p.By)]
    b = [p.Bx, gamma * (p.By + beta * p.Ez / p.c), gamma * (p.Bz - beta * p.Ey / p.c)]
    if value is observed.found["field_product"]:
        return sum(x * y for x, y in zip(e, b, strict=True))
    return sum(x * x for x in e) - p.c**2 * sum(x * x for x in b)


@oracle("crossing")
def above_or_below_the_focus(observed: ObservedMotion, value: Any) -> bool:
    """At the crossing one of xi, eta is zero, and y = (eta^2 - xi^2)/2."""
    x, y = observed.names[:2]
    t = mpmath.findroot(
        lambda t: getattr(observed.at(t), x) * getattr(observed.at(t), y), (0, observed.span), solver="anderson"
    )
    s = observed.at(t)
    return close(value, (getattr(s, y) ** 2 - getattr(s, x) ** 2) / 2)


@oracle("terminal_speed")
def acceleration_vanishes(observed: ObservedMotion, value: Any) -> Any:
    """At this speed straight down the acceleration vanishes."""
    down = next(n for n in ("vz", "vy", "v") if n in observed.names)
    rest = {n: mpmath.mpf(0) for n in observed.names if n.startswith("v")} | {down: -value}
    return bool(abs(observed.equations(rest)[observed.names.index(down)]) < 1e-18)


@oracle("relaxation_time")
def decay_time_of_the_velocity(observed: ObservedMotion, value: Any) -> Any:
    return -1 / observed.jacobian([mpmath.mpf(0)] * 2)[1, 1]


@oracle("falling_speed", "rising_speed")
def forces_balance(observed: ObservedMotion, value: Any) -> bool:
    """At the falling speed without the field, and at the rising speed with it, the acceleration vanishes."""
    falls = value is observed.found["falling_speed"]
    pull = observed.equations([mpmath.mpf(0), -value if falls else value], **({"E": mpmath.mpf(0)} if falls else {}))[1]
    return bool(abs(pull) < 1e-18 * observed.p.g)


@oracle("charge")
def charge_parameter(observed: ObservedMotion, value: Any) -> Any:
    return observed.p.q


@oracle("apex_time", "apex_height")
def apex(observed: ObservedMotion, value: Any) -> Any:
    time = observed.found["apex_time"]
    assert abs(observed.at(time).vy) < 1e-18
    return time if value is time else observed.at(time).y


@oracle("landing_time", "flight_time", "landing_x", "range")
def landing(observed: ObservedMotion, value: Any) -> Any:
    time = observed.found.get("landing_time") or observed.found["flight_time"]
    assert abs(observed.at(time).y) < 1e-18
    assert time > 0
    return (
        time
        if value is time
        else observed.at(time).x - (0 if value is observed.found.get("landing_x") else observed.at(0).x)
    )


@oracle("highest_apex", "farthest_range")
def best_of_all_throws(observed: ObservedMotion, value: Any) -> bool:
    """The best of 90 throws at whole degrees: the vertical one, or that at 45 degrees."""
    speed, best = hypot(observed.at(0).vx, observed.at(0).vy), []
    high = value is observed.found["highest_apex"]
    for degrees in range(1, 91):
        angle = pi * degrees / 180
        start = [observed.case.initial_state[0], observed.case.initial_state[1], speed * cos(angle), speed * sin(angle)]
        throw = get(observed.case.name, initial_state=start, g=observed.case.parameters["g"]).quantities(30)
        best.append(throw["apex_height" if high else "landing_x"])
    return close(max(best), value) and best.index(max(best)) == (89 if high else 44)


@oracle("steady_amplitude", "phase_lag", "magnification", "unbalance_ratio", "transmissibility")
def long_after_the_start(observed: ObservedMotion, value: Any) -> Any:
    """x = X cos(w t - lag) after the transient has decayed; the others are ratios of terms in the equations."""
    p, whole = observed.p, 2 * pi / observed.p.w
    late = whole * mpmath.ceil(200 * p.m / p.c / whole)
    here, quarter = (observed.at(late + k * whole / 4) for k in (0, 1))
    size, lag = hypot(here.x, quarter.x), mpmath.atan2(quarter.x, here.x)
    passed = hypot(*(p.k * s.x + p.c * s.v for s in (here, quarter)))
    found = {"steady_amplitude": size, "phase_lag": lag, "magnification": size / (p.F0 / p.k)}
    found |= {"unbalance_ratio": p.m * size * p.w**2 / p.F0, "transmissibility": passed / p.F0}
    return next(x for n, x in found.items() if observed.found[n] is value)


@oracle("growing_part", "dying_part", "bounded_amplitude")
def coefficients_of_three_terms(observed: ObservedMotion, value: Any) -> bool:
    """r = A e^(Ot) + B e^(-Ot) + C sin(Ot) at three other times."""
    a, b, c = (observed.found[n] for n in ("growing_part", "dying_part", "bounded_amplitude"))
    u = [observed.p.O * t for t in (mpmath.mpf("0.3"), mpmath.mpf("0.9"), mpmath.mpf("1.7"))]
    found = [a * mpmath.exp(x) + b * mpmath.exp(-x) + c * sin(x) for x in u]
    return all(close(observed.at(x / observed.p.O).r, r) for x, r in zip(u, found, strict=True))


@oracle("phase")
def phase_of_the_cosine(observed: ObservedMotion, value: Any) -> bool:
    w, size = 2 * pi / observed.found["period"], observed.found["amplitude"]
    return any(
        all(close(observed.at(t).x, size * cos(w * t + sign * value)) for t in (mpmath.mpf("0.3"), mpmath.mpf(1)))
        for sign in (1, -1)
    )


@oracle("fall_time", "east_deflection", "north_deflection")
def landing_of_the_fall(observed: ObservedMotion, value: Any) -> Any:
    """Time and position at z = 0."""
    time = observed.found["fall_time"]
    assert abs(observed.at(time).z) < 1e-17
    return next(
        x
        for n, x in (
            ("fall_time", time),
            ("east_deflection", observed.at(time).x),
            ("north_deflection", observed.at(time).y),
        )
        if observed.found[n] is value
    )


@oracle("first_order_deflection")
def deflection_of_the_first_order_motion(observed: ObservedMotion, value: Any) -> bool:
    numbers = {name: observed.case.parameters[name] for name in ("g", "Om", "lat")}
    first = ObservedMotion(get("free_fall_first_order", initial_state=observed.case.initial_state, **numbers))
    time = sqrt(2 * observed.at(0).z / observed.p.g)
    return close(value, first.at(time).x, 12)


@oracle("free_time_limit")
def turns_no_further_than_the_free_body(observed: ObservedMotion, value: Any) -> bool:
    """The final attitude equals the attitude of the torque-free body at that time."""
    still, numbers = observed.at(200 / observed.p.nu), dict(observed.case.parameters)
    attitude = [n for n in observed.names if n[0] in "wR"]
    start = [x for n, x in zip(observed.names, observed.case.initial_state, strict=True) if n in attitude]
    free = ObservedMotion(get("euler_top", initial_state=start, **{n: numbers[n] for n in ("I1", "I2", "I3")})).at(
        value
    )
    return all(close(getattr(still, n), getattr(free, n)) for n in attitude if n[0] == "R")


@oracle("final_momentum")
def limit_of_the_vertical_momentum(observed: ObservedMotion, value: Any) -> Any:
    """The limit of an exponential from three equally spaced values, by Aitken's rule."""
    a, b, c = (
        sum(getattr(observed.p, f"I{i}") * getattr(s, f"w{i}") * getattr(s, f"R3{i}") for i in (1, 2, 3))
        for s in (observed.at(t * observed.span / 8) for t in range(3))
    )
    return (a * c - b * b) / (a + c - 2 * b)


@oracle("end_time")
def neither_slides_nor_drills(observed: ObservedMotion, value: Any) -> bool:
    before, after = (observed.at(value * share) for share in (mpmath.mpf("0.9"), 1 - mpmath.mpf("1e-12")))
    slips = [max(abs(s.vx - observed.p.R * s.wy), abs(s.vy + observed.p.R * s.wx), abs(s.wz)) for s in (before, after)]
    with pytest.raises(ValueError, match="neither slides nor drills"):
        observed.at(value * (1 + mpmath.mpf("1e-12")))
    return bool(slips[1] < 1e-9 * slips[0])


@oracle("final_vx", "final_vy")
def velocity_at_the_end(observed: ObservedMotion, value: Any) -> Any:
    return getattr(
        observed.at(observed.found["end_time"] * (1 - mpmath.mpf("1e-12"))),
        "vx" if value is observed.found["final_vx"] else "vy",
    )


@oracle("final_speed")
def speed_long_after_the_start(observed: ObservedMotion, value: Any) -> Any:
    return observed.at(200).v


@oracle("whole_turn")
def turn_between_far_times(observed: ObservedMotion, value: Any) -> Any:
    return observed.at(200).theta - observed.at(-200).theta


@oracle("edge_x", "edge_y")
def along_the_edge(observed: ObservedMotion, value: Any) -> bool:
    """The integral of v cos(theta), v sin(theta)."""
    part = mpmath.cos if value is observed.found["edge_x"] else mpmath.sin
    pieces = [observed.span * k / 6 for k in range(7)]
    found = mpmath.quad(
        lambda t: observed.at(t).v * part(observed.at(t).theta), pieces, method="gauss-legendre", maxdegree=4
    )
    return close(value, found, 10)


@oracle("knife_edge_incline.drift")
def mean_velocity_across(observed: ObservedMotion, value: Any) -> Any:
    turn = 2 * pi / observed.p.w
    return max(
        (observed.at(turn).x - observed.at(0).x) / turn, (observed.at(turn).y - observed.at(0).y) / turn, key=abs
    )


@oracle("fluctuation")
def half_of_the_swing_of_the_rate(observed: ObservedMotion, value: Any) -> Any:
    late, turn = 200 * observed.p.I / observed.p.c, 2 * pi / observed.p.W
    found = observed.extremes(lambda s: s.w, turn)  # early, before the transient has decayed
    shifted = LaterMotion(observed, late).extremes(lambda s: s.w, turn)
    assert found
    return (max(x for _, x in shifted) - min(x for _, x in shifted)) / 2

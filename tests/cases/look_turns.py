"""Turning points, apsides and what stays on the way."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import mpmath
import pytest
from mpmath import cos, hypot, pi, sqrt
from outside import Late, Outside, close, oracle, period_of


def first(look: Outside) -> str:
    """The coordinate that turns: of a cart, the angle."""
    return look.names[1] if look.case.name == "pendulum_on_cart" else look.names[0]


@oracle("largest", "amplitude", "largest_x", "angle_amplitude")
def turns_at_largest(look: Outside, value: Any) -> Any:
    if "turn_time" in look.found:
        return pi
    rest = look.found.get("rest_angle", 0)
    return look.largest(lambda s: getattr(s, first(look)) - rest, period_of(look))


@oracle("least", "least_x")
def turns_at_least(look: Outside, value: Any) -> Any:
    return look.least(lambda s: getattr(s, first(look)), period_of(look))


@oracle("top_speed", "top_rate")
def fastest(look: Outside, value: Any) -> Any:
    return look.largest(lambda s: abs(getattr(s, look.names[1])), period_of(look))


@oracle("two_mass_spring.amplitude")
def half_of_the_way(look: Outside, value: Any) -> Any:
    way = [f(lambda s: s.x2 - s.x1, look.found["period"]) for f in (look.largest, look.least)]
    return (way[0] - way[1]) / 2


@oracle("arc_amplitude")
def along_the_arc(look: Outside, value: Any) -> Any:
    (arc,) = look.case.formulations
    parameters = tuple(vars(look.p).values())
    return arc.encode(mpmath, (look.found["angle_amplitude"], mpmath.mpf(0)), parameters)[0]


@oracle("closest", "closest_distance", "semi_minor_axis")
def nearest_to_the_origin(look: Outside, value: Any) -> Any:
    if look.case.name == "inertial_straight_line":  # of the whole line, the part before the start included
        return Late(look, -look.span / 16).least(lambda s: hypot(s.x, s.y), look.span / 8)
    until = look.found.get("swing_period") or look.found.get("period") or look.span
    return look.least(lambda s: hypot(s.x, s.y), until)


@oracle("farthest", "semi_major_axis")
def furthest_from_the_origin(look: Outside, value: Any) -> Any:
    return look.largest(lambda s: hypot(s.x, s.y), look.found["period"])


@oracle("radial_fall_inverse_square.farthest")
def where_the_energy_is_spent(look: Outside, value: Any) -> Any:
    energy = look.invariant("energy")
    return mpmath.inf if energy >= 0 else -look.p.mu / energy


def apsides(look: Outside) -> tuple[Any, Any]:
    """Least and largest distance from the centre of attraction, or of the first from the second."""
    if look.case.name == "equilateral_three_body":
        return look.found["shortest_side"], look.found["longest_side"]
    if look.case.name == "two_body":
        return tuple(
            f(lambda s: hypot(s.x2 - s.x1, s.y2 - s.y1), look.found["period"]) for f in (look.least, look.largest)
        )
    return tuple(f(lambda s: hypot(s.x, s.y), look.found["period"]) for f in (look.least, look.largest))


def conic(look: Outside) -> bool:
    """Only of an ellipse the apsides are both reached; its siblings are tested where the conic is."""
    return "period" in look.found


@oracle("eccentricity")
def ratio_of_the_apsides(look: Outside, value: Any) -> Any:
    if not conic(look):
        return bool(value >= 1)
    near, far = apsides(look)
    return (far - near) / (far + near)


@oracle("pericentre")
def the_nearer_apsis(look: Outside, value: Any) -> Any:
    if "collision_time" in look.found:
        return mpmath.mpf(0)
    return apsides(look)[0] if conic(look) else look.least(lambda s: hypot(s.x, s.y))


@oracle("kepler_orbit.semi_major_axis", "two_body.semi_major_axis")
def mean_of_the_apsides(look: Outside, value: Any) -> Any:
    return sum(apsides(look)) / 2 if conic(look) else -look.p.mu / (2 * look.invariant("energy"))


@oracle("semi_latus_rectum")
def harmonic_mean_of_the_apsides(look: Outside, value: Any) -> Any:
    near, far = apsides(look) if conic(look) else (look.found["pericentre"], mpmath.inf)
    return 2 / (1 / near + 1 / far) if conic(look) else near * (1 + look.found["eccentricity"])


@oracle("areal_rate")
def area_swept_in_a_second(look: Outside, value: Any) -> Any:
    s = look.at(1)
    return (s.x * s.vy - s.y * s.vx) / 2


@oracle("third_law_factor")
def against_keplers(look: Outside, value: Any) -> Any:
    return look.found["period"] ** 2 * look.p.G * look.p.m1 / (4 * pi**2 * look.found["semi_major_axis"] ** 3)


@oracle("shortest_side", "longest_side")
def side(look: Outside, value: Any) -> Any:
    def length(s: Any) -> Any:
        return sqrt((s.x2 - s.x1) ** 2 + (s.y2 - s.y1) ** 2 + (s.z2 - s.z1) ** 2)

    if "period" not in look.found:
        return look.least(length)
    ends = look.least(length, look.found["period"], 24), look.largest(length, look.found["period"], 24)
    return ends[close(value, ends[1])]


@oracle("lowest_cosine", "highest_cosine")
def heights(look: Outside, value: Any) -> Any:
    ends = [f(lambda s: cos(s.theta), look.found["nutation_period"]) for f in (look.least, look.largest)]
    assert look.found["lowest_cosine"] < look.found["highest_cosine"]
    return ends[close(value, ends[1])]


@oracle("collision_time")
def the_centre_is_reached(look: Outside, value: Any) -> bool:
    """1e-9 of the time before, the distance is at most some cube root of that; after it there is no motion."""
    place = [i for i, name in enumerate(look.names) if name in ("r", "x", "y")]
    before = mpmath.norm([look.state(value * (1 - mpmath.mpf(10) ** -9), 20)[i] for i in place])
    with pytest.raises((ValueError, ArithmeticError), match=r"collision|centre|step"):
        look.state(value * (1 + mpmath.mpf(10) ** -9), 20)
    return bool(before < 1e-2 * mpmath.norm([look.state(0)[i] for i in place]))


@oracle("diameter")
def of_the_circle_through_the_centre(look: Outside, value: Any) -> bool:
    """r^2 = d x in the axis of the start, at all times."""
    s, start = look.at(look.found["collision_time"] / 2), look.at(0)
    return close((s.x**2 + s.y**2) * hypot(start.x, start.y), value * (s.x * start.x + s.y * start.y))


@oracle("circle_speed")
def pull_is_centripetal(look: Outside, value: Any) -> Any:
    s = look.at(0)
    _, _, ax, ay = look.equations(look.state(0))
    return sqrt(hypot(ax, ay) * hypot(s.x, s.y))


@oracle("energy")
def differs_as_the_invariant(look: Outside, value: Any) -> bool:
    """Zero of the potential is a matter of words: held is the difference from a motion that starts elsewhere."""
    label = next(n for n in ("energy", "jacobi") if n in look.case.invariants)
    start = [x * (Fraction(9, 10) if i == 0 else Fraction(11, 10)) for i, x in enumerate(look.case.initial_state)]
    other = Outside(look.case.with_numbers(start, look.case.parameters))
    gaps = look.invariant(label, look.span / 3) - other.invariant(label, other.span / 3), value - other.found["energy"]
    return close(*gaps) and gaps[0] != 0


@oracle("momentum")
def of_the_ignorable_angle(look: Outside, value: Any) -> Any:
    label = next(n for n in ("momentum", "angular_momentum") if n in look.case.invariants)
    return look.invariant(label, look.span / 3)


@oracle("momentum_x", "momentum_y")
def total_momentum(look: Outside, value: Any) -> Any:
    axis = "x" if value is look.found["momentum_x"] else "y"
    s = look.at(0)
    return look.p.m1 * getattr(s, f"v{axis}1") + look.p.m2 * getattr(s, f"v{axis}2")


@oracle("drift_speed")
def of_the_centre(look: Outside, value: Any) -> Any:
    def centre(t: Any) -> Any:
        s = look.at(t)
        return (look.p.m1 * s.x1 + look.p.m2 * s.x2) / (look.p.m1 + look.p.m2)

    return (centre(3) - centre(0)) / 3


@oracle("escape_energy")
def height_of_the_hilltops(look: Outside, value: Any) -> Any:
    top = sqrt(-look.p.alpha / look.p.beta)
    assert abs(look.equations([top, mpmath.mpf(0)])[1]) < 1e-30
    return look.invariant("energy", 0, (top, mpmath.mpf(0)))


@oracle("escape_speed")
def energy_zero(look: Outside, value: Any) -> bool:
    return close(1 + look.invariant("energy", 0, (look.at(0).r, value)) / value**2, 1)

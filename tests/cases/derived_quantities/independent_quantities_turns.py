"""Turning points, apsides and constants of the motion, computed independently: from extremes of the motion."""

from fractions import Fraction
from typing import Any

import mpmath
import pytest
from independent_quantities import LaterMotion, ObservedMotion, close, oracle, period_of
from mpmath import cos, hypot, pi, sqrt


def first(observed: ObservedMotion) -> str:
    """The coordinate with turning points: for a pendulum on a cart the angle."""
    return observed.names[1] if observed.case.name == "pendulum_on_cart" else observed.names[0]


@oracle("largest", "amplitude", "largest_x", "angle_amplitude")
def turns_at_largest(observed: ObservedMotion, value: Any) -> Any:
    if "turn_time" in observed.found:
        return pi
    rest = observed.found.get("rest_angle", 0)
    return observed.largest(lambda s: getattr(s, first(observed)) - rest, period_of(observed))


@oracle("least", "least_x")
def turns_at_least(observed: ObservedMotion, value: Any) -> Any:
    return observed.least(lambda s: getattr(s, first(observed)), period_of(observed))


@oracle("top_speed", "top_rate")
def fastest(observed: ObservedMotion, value: Any) -> Any:
    return observed.largest(lambda s: abs(getattr(s, observed.names[1])), period_of(observed))


@oracle("two_mass_spring.amplitude")
def half_of_the_way(observed: ObservedMotion, value: Any) -> Any:
    way = [f(lambda s: s.x2 - s.x1, observed.found["period"]) for f in (observed.largest, observed.least)]
    return (way[0] - way[1]) / 2


@oracle("arc_amplitude")
def along_the_arc(observed: ObservedMotion, value: Any) -> Any:
    (arc,) = observed.case.formulations
    parameters = tuple(vars(observed.p).values())
    return arc.encode(mpmath, (observed.found["angle_amplitude"], mpmath.mpf(0)), parameters)[0]


@oracle("closest", "closest_distance", "semi_minor_axis")
def nearest_to_the_origin(observed: ObservedMotion, value: Any) -> Any:
    if observed.case.name == "inertial_straight_line":  # of the whole line, including times before the start
        return LaterMotion(observed, -observed.span / 16).least(lambda s: hypot(s.x, s.y), observed.span / 8)
    until = observed.found.get("swing_period") or observed.found.get("period") or observed.span
    return observed.least(lambda s: hypot(s.x, s.y), until)


@oracle("farthest", "semi_major_axis")
def furthest_from_the_origin(observed: ObservedMotion, value: Any) -> Any:
    return observed.largest(lambda s: hypot(s.x, s.y), observed.found["period"])


@oracle("radial_fall_inverse_square.farthest")
def where_the_energy_is_spent(observed: ObservedMotion, value: Any) -> Any:
    energy = observed.invariant("energy")
    return mpmath.inf if energy >= 0 else -observed.p.mu / energy


def apsides(observed: ObservedMotion) -> tuple[Any, Any]:
    """Least and largest distance from the centre of attraction, or between the two bodies."""
    if observed.case.name == "equilateral_three_body":
        return observed.found["shortest_side"], observed.found["longest_side"]
    if observed.case.name == "two_body":
        return tuple(
            f(lambda s: hypot(s.x2 - s.x1, s.y2 - s.y1), observed.found["period"])
            for f in (observed.least, observed.largest)
        )
    return tuple(f(lambda s: hypot(s.x, s.y), observed.found["period"]) for f in (observed.least, observed.largest))


def conic(observed: ObservedMotion) -> bool:
    """Both apsides are reached only on an ellipse; for other conics see the tests of the exact motion."""
    return "period" in observed.found


@oracle("eccentricity")
def ratio_of_the_apsides(observed: ObservedMotion, value: Any) -> Any:
    if not conic(observed):
        return bool(value >= 1)
    near, far = apsides(observed)
    return (far - near) / (far + near)


@oracle("pericentre")
def the_nearer_apsis(observed: ObservedMotion, value: Any) -> Any:
    if "collision_time" in observed.found:
        return mpmath.mpf(0)
    return apsides(observed)[0] if conic(observed) else observed.least(lambda s: hypot(s.x, s.y))


@oracle("kepler_orbit.semi_major_axis", "two_body.semi_major_axis")
def mean_of_the_apsides(observed: ObservedMotion, value: Any) -> Any:
    return sum(apsides(observed)) / 2 if conic(observed) else -observed.p.mu / (2 * observed.invariant("energy"))


@oracle("semi_latus_rectum")
def harmonic_mean_of_the_apsides(observed: ObservedMotion, value: Any) -> Any:
    near, far = apsides(observed) if conic(observed) else (observed.found["pericentre"], mpmath.inf)
    return 2 / (1 / near + 1 / far) if conic(observed) else near * (1 + observed.found["eccentricity"])


@oracle("areal_rate")
def area_swept_in_a_second(observed: ObservedMotion, value: Any) -> Any:
    s = observed.at(1)
    return (s.x * s.vy - s.y * s.vx) / 2


@oracle("third_law_factor")
def ratio_to_keplers_law(observed: ObservedMotion, value: Any) -> Any:
    return (
        observed.found["period"] ** 2
        * observed.p.G
        * observed.p.m1
        / (4 * pi**2 * observed.found["semi_major_axis"] ** 3)
    )


@oracle("shortest_side", "longest_side")
def side(observed: ObservedMotion, value: Any) -> Any:
    def length(s: Any) -> Any:
        return sqrt((s.x2 - s.x1) ** 2 + (s.y2 - s.y1) ** 2 + (s.z2 - s.z1) ** 2)

    if "period" not in observed.found:
        return observed.least(length)
    ends = observed.least(length, observed.found["period"], 24), observed.largest(length, observed.found["period"], 24)
    return ends[close(value, ends[1])]


@oracle("lowest_cosine", "highest_cosine")
def heights(observed: ObservedMotion, value: Any) -> Any:
    ends = [f(lambda s: cos(s.theta), observed.found["nutation_period"]) for f in (observed.least, observed.largest)]
    assert observed.found["lowest_cosine"] < observed.found["highest_cosine"]
    return ends[close(value, ends[1])]


@oracle("collision_time")
def the_centre_is_reached(observed: ObservedMotion, value: Any) -> bool:
    """At 1e-9 of the time before it the distance is close to zero, like a cube root; after it the motion has ended."""
    place = [i for i, name in enumerate(observed.names) if name in ("r", "x", "y")]
    before = mpmath.norm([observed.state(value * (1 - mpmath.mpf(10) ** -9), 20)[i] for i in place])
    with pytest.raises((ValueError, ArithmeticError), match=r"collision|centre|step"):
        observed.state(value * (1 + mpmath.mpf(10) ** -9), 20)
    return bool(before < 1e-2 * mpmath.norm([observed.state(0)[i] for i in place]))


@oracle("diameter")
def of_the_circle_through_the_centre(observed: ObservedMotion, value: Any) -> bool:
    """r^2 = d x at all times, x along the initial position."""
    s, start = observed.at(observed.found["collision_time"] / 2), observed.at(0)
    return close((s.x**2 + s.y**2) * hypot(start.x, start.y), value * (s.x * start.x + s.y * start.y))


@oracle("circle_speed")
def pull_is_centripetal(observed: ObservedMotion, value: Any) -> Any:
    s = observed.at(0)
    _, _, ax, ay = observed.equations(observed.state(0))
    return sqrt(hypot(ax, ay) * hypot(s.x, s.y))


@oracle("energy")
def energy_difference_of_two_starts(observed: ObservedMotion, value: Any) -> bool:
    """The zero of the potential is arbitrary, so the difference from another start is compared."""
    label = next(n for n in ("energy", "jacobi") if n in observed.case.invariants)
    start = [x * (Fraction(9, 10) if i == 0 else Fraction(11, 10)) for i, x in enumerate(observed.case.initial_state)]
    other = ObservedMotion(observed.case.with_numbers(start, observed.case.parameters))
    gaps = (
        observed.invariant(label, observed.span / 3) - other.invariant(label, other.span / 3),
        value - other.found["energy"],
    )
    return close(*gaps) and gaps[0] != 0


@oracle("momentum")
def of_the_ignorable_angle(observed: ObservedMotion, value: Any) -> Any:
    label = next(n for n in ("momentum", "angular_momentum") if n in observed.case.invariants)
    return observed.invariant(label, observed.span / 3)


@oracle("momentum_x", "momentum_y")
def total_momentum(observed: ObservedMotion, value: Any) -> Any:
    axis = "x" if value is observed.found["momentum_x"] else "y"
    s = observed.at(0)
    return observed.p.m1 * getattr(s, f"v{axis}1") + observed.p.m2 * getattr(s, f"v{axis}2")


@oracle("drift_speed")
def of_the_centre(observed: ObservedMotion, value: Any) -> Any:
    def centre(t: Any) -> Any:
        s = observed.at(t)
        return (observed.p.m1 * s.x1 + observed.p.m2 * s.x2) / (observed.p.m1 + observed.p.m2)

    return (centre(3) - centre(0)) / 3


@oracle("escape_energy")
def height_of_the_hilltops(observed: ObservedMotion, value: Any) -> Any:
    top = sqrt(-observed.p.alpha / observed.p.beta)
    assert abs(observed.equations([top, mpmath.mpf(0)])[1]) < 1e-30
    return observed.invariant("energy", 0, (top, mpmath.mpf(0)))


@oracle("escape_speed")
def energy_zero(observed: ObservedMotion, value: Any) -> bool:
    return close(1 + observed.invariant("energy", 0, (observed.at(0).r, value)) / value**2, 1)

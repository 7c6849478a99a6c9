"""Forces, from the accelerations of the motion."""

from __future__ import annotations

from typing import Any

import mpmath
from mpmath import cos, hypot, pi, sin
from outside import Outside, angle_at_rest, oracle, period_of, swing


@oracle("tension_lowest_point", "tension_highest_point")
def pull_of_the_rod(look: Outside, value: Any) -> Any:
    """L omega^2 + g cos(theta), the largest and the least over a period; turning, of a whole turn."""

    def pull(s: Any) -> Any:
        return look.p.L * s.omega**2 + look.p.g * cos(s.theta)

    ends = look.largest(pull, period_of(look)), look.least(pull, period_of(look))
    return ends[value is look.found["tension_highest_point"]]


@oracle("multiplier")
def pull_over_the_length(look: Outside, value: Any) -> Any:
    s = look.at(0)
    return -(look.rate("vx") * s.x + (look.rate("vy") + look.p.g) * s.y) / (s.x**2 + s.y**2)


@oracle("normal_force_bottom", "normal_force_start")
def normal_force(look: Outside, value: Any) -> Any:
    """g cos(slope) + v^2 curvature: at the bottom the curvature is that which sets the small swings."""
    if look.case.name != "cycloidal_pendulum":
        _, t = min((abs(getattr(look.at(t), look.names[0])), t) for t in zero_crossings(look))
        curvature = -look.jacobian([mpmath.mpf(0)] * 2)[1, 0] / look.p.g
        return look.p.g + look.at(t).v ** 2 * curvature

    def place(t: Any) -> Any:
        phi, a = look.at(t).phi, look.p.a
        return mpmath.mpc(a * (phi + sin(phi)), a * (1 - cos(phi)))

    t = zero_crossings(look)[0] if value is look.found["normal_force_bottom"] else mpmath.mpf(0)
    along = look.slope(place, t + mpmath.mpf("1e-9"))
    h = mpmath.mpf("1e-9")
    force = (place(t + h) - 2 * place(t) + place(t - h)) / h**2 + 1j * look.p.g
    found = (force * mpmath.conj(along * 1j / abs(along))).real
    # along a path of which only the direction counts; second differences over 1e-9 are right to some 16 digits
    return bool(abs(abs(found) - value) < 1e-7)


def zero_crossings(look: Outside) -> list[Any]:
    x = look.names[0]
    quarter = look.found["period"] / 2
    return [mpmath.findroot(lambda t: getattr(look.at(t), x), (0, quarter), solver="anderson", tol=1e-35, verify=False)]


@oracle("center_of_percussion")
def length_of_the_equivalent_pendulum(look: Outside, value: Any) -> Any:
    return look.p.g / swing(look, angle_at_rest(look, 0)) ** 2


@oracle("reaction_along", "reaction_across")
def of_the_axis(look: Outside, value: Any) -> Any:
    """What the mass centre's acceleration leaves over from the weight."""
    s, p = look.at(0), look.p
    if value is look.found["reaction_along"]:
        return p.m * (p.g * cos(s.theta) + p.l * s.omega**2)
    return p.m * (p.g * sin(s.theta) + p.l * look.rate("omega"))


@oracle("drive_torque")
def growth_of_the_momentum_about_the_shaft(look: Outside, value: Any) -> Any:
    def momentum(t: Any) -> Any:
        theta, p = look.at(t).theta, look.p
        if hasattr(p, "R"):
            return (p.R * sin(theta)) ** 2 * p.Om
        return p.Om * (p.I_b * sin(theta) ** 2 + p.I_c * cos(theta) ** 2)

    return look.slope(momentum)


@oracle("bearing_torque")
def growth_of_the_momentum_across_the_shaft(look: Outside, value: Any) -> Any:
    """In turning axes: d/dt of the part across, and the shaft carries I_a theta' round."""

    def across(t: Any) -> Any:
        theta = look.at(t).theta
        return look.p.Om * (look.p.I_b - look.p.I_c) * sin(theta) * cos(theta)

    return look.slope(across) + look.p.Om * look.p.I_a * look.at(0).omega


@oracle("wall_force")
def across_the_slot(look: Outside, value: Any) -> Any:
    """The mass times the transverse acceleration of r in a slot that turns."""
    return (
        look.p.m
        * mpmath.im(
            mpmath.diff(
                lambda t: look.at(t).r * mpmath.expj(look.p.Om * t), mpmath.mpf("1e-20"), 2, h=mpmath.mpf("1e-9")
            )
        )
        if look.p.mu == 0
        else 2 * look.p.m * look.p.Om * look.at(0).v
    )


@oracle("largest_force")
def of_the_accelerated_cart(look: Outside, value: Any) -> Any:
    h = 2 * pi / look.p.w / 12
    return look.p.M * max(abs(look.rate("v", k * h)) for k in range(12))


@oracle("cart_way")
def there_and_back(look: Outside, value: Any) -> Any:
    half = pi / look.p.w
    return abs(look.at(half).x - look.at(0).x - half * look.found["centre_speed"])


@oracle("centre_speed")
def mean_velocity(look: Outside, value: Any) -> Any:
    turn = 2 * pi / look.p.w
    return (look.at(turn).x - look.at(0).x) / turn


@oracle("dumbbell_free_flight.tension")
def of_the_rod_between(look: Outside, value: Any) -> Any:
    return look.p.m1 * hypot(look.rate("vx1"), look.rate("vy1") + look.p.g)


@oracle("acceleration", "wedge_acceleration", "relative_acceleration")
def acceleration(look: Outside, value: Any) -> Any:
    if look.case.name == "wedge_block_energy_momentum":
        return look.rate("V" if value is look.found["wedge_acceleration"] else "v")
    return look.rate("v")


@oracle("tension_1", "tension_2")
def of_the_string(look: Outside, value: Any) -> Any:
    """What is left of each weight: the heavier sinks."""
    a = look.rate("v")
    return look.p.m1 * (look.p.g - a) if value is look.found["tension_1"] else look.p.m2 * (look.p.g + a)


@oracle("wedge_block_energy_momentum.normal_force")
def pushes_the_wedge(look: Outside, value: Any) -> Any:
    return look.p.M * abs(look.rate("V")) / sin(look.p.alpha)


@oracle("string_force")
def of_the_unwinding_string(look: Outside, value: Any) -> Any:
    return look.p.m * (look.p.g - look.rate("v"))


@oracle("tension_start", "tension_end")
def pull_inward(look: Outside, value: Any) -> Any:
    t = 0 if value is look.found["tension_start"] else look.span
    return look.p.m * (look.p.r0 - look.p.c * t) * look.at(t).omega ** 2


@oracle("rate_end")
def at_the_end(look: Outside, value: Any) -> Any:
    return look.at(look.span).omega


@oracle("shortened_string.work", "work")
def kinetic_energy_gained(look: Outside, value: Any) -> Any:
    speeds = [(look.p.r0 - look.p.c * t) * look.at(t).omega for t in (0, look.span)]
    return look.p.m * (speeds[1] ** 2 - speeds[0] ** 2) / 2
